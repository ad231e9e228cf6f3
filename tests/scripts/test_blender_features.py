#!/usr/bin/env python3
"""scenes/README.md says of Blender what the exporter's messages and lists say (scripts/blender/features); and differences are found."""
import importlib.machinery
import importlib.util
import os
import sys
import unittest

sys.dont_write_bytecode = True
TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
LOADER = importlib.machinery.SourceFileLoader("features", os.path.join(TOP, "scripts", "blender", "features"))
features = importlib.util.module_from_spec(importlib.util.spec_from_loader("features", LOADER))
LOADER.exec_module(features)


class Features(unittest.TestCase):
    def put(self, name, value):
        self.addCleanup(setattr, features, name, getattr(features, name))
        setattr(features, name, value)

    def test_rows_are_those_of_the_sources(self):
        self.assertEqual(features.faults(), [])

    def test_readme_has_the_table(self):
        with open(os.path.join(TOP, "scenes", "README.md"), encoding="utf-8") as file:
            text = file.read()
        self.assertEqual(text, features.with_table(text), "run scripts/blender/features --write")
        self.assertNotEqual(text.replace("Motion blur |", "Blur |"), features.with_table(text))

    def test_losses_that_stop_the_export_are_bold(self):
        text = "\n".join(features.lines())
        self.assertIn("**volume, negative light, ray visibility**", text)
        self.assertIn("| clip start and end;", text)

    def test_message_without_a_row(self):
        said = features.messages()
        self.put("messages", lambda: said + [(True, "'%s': melts")])
        self.assertEqual(features.faults(), ["in no row: '%s': melts"])

    def test_row_without_a_message(self):
        self.put("SCENE", features.SCENE + [("Ice", "yes", "", [("heat", ["melts"])])])
        self.assertEqual(features.faults(), ["no message says: melts"])

    def test_error_and_warning_in_one(self):
        self.put("SCENE", features.SCENE + [("Both", "yes", "", [("all", ["its back shines", "stereoscopy"])])])
        self.assertEqual(features.faults(), ["errors and warnings in one: all"])

    def test_shader_without_a_row(self):
        known = features.shaders()
        self.put("shaders", lambda: known | {"BSDF_ICE"})
        self.assertEqual(features.faults(), ["shader in no row, or unknown: BSDF_ICE"])


if __name__ == "__main__":
    unittest.main()
