#!/usr/bin/env python3
"""The sums of scripts/bench, scripts/validate and scripts/blender-parity against figures whose answer is known, and a small run. Skipped (77) without numpy."""
import argparse
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

try:
    import numpy as np
except ImportError:
    if sys.executable != "/usr/bin/python3" and os.path.exists("/usr/bin/python3"):  # Debian's has it if another is first in the path
        os.execv("/usr/bin/python3", ["/usr/bin/python3", "-B", *sys.argv])
    print("skipped: there is no numpy (apt-get install python3-numpy)")
    sys.exit(77)

BUILD = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.isdir(sys.argv[1]) else None
SCRIPTS = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scripts")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SCRIPTS, "bench"))
import budget  # noqa: E402
import pictures  # noqa: E402
import rivals  # noqa: E402
import runs  # noqa: E402


def load(*path):
    loader = importlib.machinery.SourceFileLoader(path[-1], os.path.join(SCRIPTS, *path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


bench, validate, parity = load("bench", "run"), load("validate"), load("blender-parity")


def noisy(rng, sigma, size=(3, 40, 50)):
    return rng.normal(1.0, sigma, (*size, 3))


class Errors(unittest.TestCase):
    def test_two_seeds_give_the_error(self):
        # sigma 0.2 at brightness 1: 3 channels of 0.04 / 1
        rng = np.random.default_rng(1)
        made = pictures.error_of_pairs(np.stack([noisy(rng, 0.2) for _ in range(2)]), np.ones((3, 40, 50)))
        self.assertAlmostEqual(made["relmse"], 0.12, delta=0.005)
        self.assertAlmostEqual(made["phi"], 1.0, delta=0.05)
        self.assertAlmostEqual(made["f1_squared"], 2 * 0.04, delta=0.05 * 0.08)
        self.assertTrue(made["median"] < made["trimmed"] < made["relmse"])

    @unittest.skipIf(BUILD is None, "needs the folder of a build as argument")
    def test_f1_is_that_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            binary, scene, seen = os.path.join(BUILD, "reframe"), runs.make_scene(folder, "textured-room"), []
            for seed in (1, 2):
                pattern = os.path.join(folder, "%d.####.exr" % seed)
                seen.append(pictures.load(pattern, runs.render(binary, scene, pattern, "24x14", runs.PLAIN, 2, seed, "1-3")))
            told = runs.ask(binary, "flicker", os.path.join(folder, "1.####.exr"), "--reference", pattern)
        self.assertAlmostEqual(pictures.relative_f1_squared(seen[0] - seen[1], pictures.denominators(seen[1])) ** 0.5 / told["f1_relative"], 1.0, delta=1e-6)

    def test_error_that_lasts_does_not_flicker(self):
        rng = np.random.default_rng(2)
        still = np.stack([np.repeat(noisy(rng, 0.2, (1, 40, 50)), 3, 0) for _ in range(2)])
        self.assertAlmostEqual(pictures.error_of_pairs(still, np.ones((3, 40, 50)))["phi"], 0.0)

    def test_reference_is_taken_off(self):
        rng, below = np.random.default_rng(3), np.ones((3, 40, 50))
        halves = [noisy(rng, 0.2) for _ in range(2)]
        own = pictures.squares(halves[0] - halves[1]) / 4
        self.assertAlmostEqual(pictures.error_beside([noisy(rng, 0.1)], np.mean(halves, axis=0), below, own)[0], 0.03, delta=0.005)

    def test_worst_share(self):
        values = np.ones(2000)
        values[7:9] = 999.0  # 0.1 % of them
        self.assertAlmostEqual(pictures.worst_share(values), 0.5)

    def test_gain(self):
        plain, reused = {"relmse": 1.0, "cpu": 3.0}, {"relmse": 0.1, "cpu": 6.0}
        self.assertAlmostEqual(pictures.gain(plain, reused), 5.0)
        self.assertTrue(math.isnan(pictures.gain(plain, {"relmse": -0.1, "cpu": 6.0})))

    def test_heavy_tails(self):
        """One of ten thousand pixels is a firefly in the reference too, and the error of one picture is all there."""
        rng, reference = np.random.default_rng(5), np.ones((1, 100, 100, 3))
        reference[0, 50, 50] = 100.0
        below, own = pictures.denominators(reference), pictures.own_denominators(reference)
        seen = {name: reference + rng.normal(0.0, sigma, (2, 1, 100, 100, 3)) for name, sigma in (("plain", 0.3), ("reused", 0.1), ("firefly", 0.1))}
        seen["firefly"][0, 0, 50, 50] += 100.0
        rows = {name: dict(pictures.error_of_pairs(made, below, own), cpu=1.0) for name, made in seen.items()}
        self.assertEqual([pictures.heavy_tails(rows["plain"], rows[name]) for name in ("plain", "reused", "firefly")], ["", "", ", heavy tails"])

    def test_blur(self):
        # the corner counts its edges twice: rows 0,0,3 of columns 0,0,1
        self.assertAlmostEqual(pictures.blur(np.arange(6.0).reshape(2, 3))[0, 0], (0 + 0 + 1 + 0 + 0 + 1 + 3 + 3 + 4) / 9)

    def test_denominators_by_hand(self):
        # a firefly has no part in it; beside an edge none to all of five columns are bright; a column of squares has medians of three
        bright = np.full((2, 9, 9, 3), 0.5)
        bright[1, 4, 4] = 1000.0
        self.assertTrue(np.allclose(pictures.denominators(bright), 0.251, rtol=1e-12))
        edge = np.repeat(np.repeat((np.arange(20) >= 10)[None, :, None] * 1.0, 9, 0), 3, 2)
        self.assertTrue(np.allclose(pictures.denominators(edge)[4, 7:13], (np.arange(6) / 5) ** 2 + 0.001, rtol=1e-12))
        column = np.repeat((np.arange(7.0) ** 2)[:, None, None], 3, 2)
        self.assertTrue(np.allclose(pictures.denominators(column)[[0, 3, 6], 0], np.array([1.0, 11.0, 29.8]) ** 2 + 0.001, rtol=1e-12))

    def test_fireflies_divide_nothing(self):
        rng = np.random.default_rng(4)
        seen = {"few": np.stack([noisy(rng, 0.5) for _ in range(2)]), "many": np.stack([noisy(rng, 0.05) for _ in range(2)])}
        seen["few"][0, :, 10:20, 10:20] = 1e6
        self.assertTrue(np.array_equal(pictures.most_accurate(seen.values()), seen["many"].mean(0)))


class Rivals(unittest.TestCase):
    def test_samples_that_fit(self):
        self.assertEqual(budget.samples_for(10.0, lambda n: 1.0 + 0.25 * n), 36)
        self.assertEqual(budget.samples_for(0.5, lambda n: 1.0 + 0.25 * n), 1)

    def test_own_error_of_the_reference_is_taken_off(self):
        rng = np.random.default_rng(5)
        halves, seen = np.stack([noisy(rng, 0.1) for _ in range(2)]), [noisy(rng, 0.1) for _ in range(2)]
        told = rivals.figures(seen, halves, -1.0)
        self.assertAlmostEqual(told["relmse"], 0.03, delta=0.001)
        self.assertAlmostEqual(told["f1"], 100 * 0.02 ** 0.5, delta=0.3)
        self.assertAlmostEqual(told["srgb"], 0.05 * 0.659, delta=0.001)  # the slope of sRGB at a half

    def test_agreement(self):
        rows = [{"jod": j, "relmse": -j ** 3, "srgb": j, "f1": 0.0} for j in (1.0, 2.0, 3.0)]
        self.assertIn("JOD over the 3 rows: 1.00 with relMSE, -1.00 with sRGB", rivals.agreement(rows))
        self.assertEqual(rivals.agreement([dict(row, jod=math.nan) for row in rows]), "")

    def test_materials_are_simplified(self):
        materials = [{"name": "floor", "pbrMetallicRoughness": {"metallicFactor": 1.0, "roughnessFactor": 0.3, "baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}},
                     {"name": "mirror", "doubleSided": True, "pbrMetallicRoughness": {"roughnessFactor": 0.0, "baseColorFactor": [0.9, 0.9, 0.9, 1.0]}},
                     {"name": "amber", "pbrMetallicRoughness": {}, "extensions": {"KHR_materials_transmission": {}, "KHR_materials_ior": {"ior": 1.6}, "KHR_materials_clearcoat": {}}}]
        with tempfile.TemporaryDirectory() as folder:
            source = os.path.join(folder, "room.glb")
            runs.write_glb(source, {"materials": materials, "scenes": [{}]}, b"")
            floor, mirror, amber = runs.read_glb(rivals.simplify(source, folder))[0]["materials"]
        self.assertEqual((floor["pbrMetallicRoughness"]["metallicFactor"], floor["pbrMetallicRoughness"]["baseColorTexture"]), (0.0, {"index": 0}))
        self.assertNotIn("normalTexture", floor)
        self.assertEqual((mirror["pbrMetallicRoughness"]["metallicFactor"], mirror["pbrMetallicRoughness"]["baseColorFactor"]), (1.0, [1.0] * 4))
        self.assertEqual(sorted(amber["extensions"]), ["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"])

    @unittest.skipIf(BUILD is None, "needs the folder of a build as argument")
    def test_without_rivals(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([os.path.join(SCRIPTS, "bench", "run"), "rivals", "--quick", "--binary", os.path.join(BUILD, "reframe"), "--out", folder, "--size", "24x14", "--scene",
                                   "still-life", "--blender", "nowhere/blender", "--rivals", "nowhere/python"], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                  env={**os.environ, "REFRAME_OIDN": "nowhere"})
        lines = done.stdout.strip().splitlines()
        self.assertEqual([line.split(":")[1].strip() for line in done.stderr.splitlines() if line.startswith("skipped: ")], ["Cycles", "LuxCore", "Mitsuba", "JOD", "Reframe, denoised"])
        self.assertEqual(lines[4].strip("|").split("|"), rivals.COLUMNS)
        self.assertEqual([line.split("|")[1] for line in lines[6:]], ["still-life, Reframe, path tracing", "still-life, Reframe, groups"])
        self.assertTrue(all(line.split("|")[5] == "1.0000" and line.endswith("|–|") for line in lines[6:]))


class Scenes(unittest.TestCase):
    def test_materials_become_numbers(self):
        gltf = {"materials": [{"name": "mirror", "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}, "alphaMode": "MASK"},
                              {"name": "pane", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}, {"name": "wall"}],
                "meshes": [{"primitives": [{"material": 1}, {}]}], "scenes": [{"extras": {"reframe": {}}}]}
        self.assertEqual([pictures.is_specular(m) for m in gltf["materials"]], [True, True, False])
        self.assertEqual(pictures.number(gltf), ["mirror (metal 0)", "pane (pane 1)", "wall (metal 1)", "no material"])
        self.assertEqual([p["material"] for p in gltf["meshes"][0]["primitives"]], [1, 3])
        self.assertEqual([round(pictures.STEPS * m["emissiveFactor"][0]) for m in gltf["materials"]], [1, 2, 3, 4])
        self.assertEqual(gltf["materials"][0]["alphaMode"], "MASK")
        self.assertNotIn("extensions", gltf["materials"][1])

    def test_options_are_dropped(self):
        given = ["--adaptive", "on", "--light-samples", "2", "--no-half", "--max-depth=5"]
        self.assertEqual(runs.without(given, "--adaptive", "--max-depth"), ["--light-samples", "2", "--no-half"])
        self.assertEqual(runs.without(["--adaptive", "--seed", "3"], "--adaptive"), ["--seed", "3"])

    def test_glb(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.glb")
            runs.write_glb(path, {"a": [1, "ä"]}, b"rest")
            self.assertEqual(runs.read_glb(path), ({"a": [1, "ä"]}, b"rest"))


class Page(unittest.TestCase):
    def test_cells(self):
        self.assertEqual([bench.cell(v) for v in (0.012345, 1.0, 99.96, 1787.4, math.nan, None, "a")], ["0.0123", "1", "100", "1787", "–", "–", "a"])

    def test_table(self):
        table = bench.Table("Title", "Text.", ["scene", "CPU s"])
        table.add("vase-room", 2.5)
        self.assertEqual(table.markdown(), "## Title\n\nText.\n\n|scene|CPU s|\n|---|---:|\n|vase-room|2.5|\n")

    @unittest.skipIf(BUILD is None, "needs the folder of a build as argument")
    def test_run(self):
        with tempfile.TemporaryDirectory() as folder:
            page, report = (os.path.join(folder, name) for name in ("page.md", "report.json"))
            subprocess.run([os.path.join(SCRIPTS, "bench", "run"), "reuse", "--binary", os.path.join(BUILD, "reframe"), "--out", folder, "--size", "24x14", "--frames", "20-22",
                            "--scene", "still-life", "--settings", "0:1,1:1", "--spp", "6", "--materials", "--busy", "--write", page, "--json", report,
                            "--", "--max-depth", "4"], check=True, stderr=subprocess.DEVNULL)
            with open(report, encoding="utf-8") as file:
                reuse, materials = json.load(file)
            with open(page, encoding="utf-8") as file:
                text = file.read()
        self.assertEqual([row[0] for row in reuse["rows"]], ["still-life 0:1", "still-life 1:1"])
        self.assertTrue(all(v > 0.0 for row in reuse["rows"] for v in row[1:]))
        self.assertEqual(reuse["rows"][0][4:8], [1.0, 1.0, 1.0, 1.0])
        mirror = next(row for row in materials["rows"] if row[0] == "still-life mirror (metal 0)")
        self.assertTrue(8.0 < mirror[1] < 20.0)
        self.assertTrue(re.match(r"# Figures\n\n.*, revision \S+, pictures [1-9]\d*, ", text) and "|still-life 1:1|" in text)

    @unittest.skipIf(BUILD is None, "needs the folder of a build as argument")
    def test_clean(self):
        with tempfile.TemporaryDirectory() as folder:
            report = os.path.join(folder, "report.json")
            command = [os.path.join(SCRIPTS, "bench", "run"), "clean", "--quick", "--binary", os.path.join(BUILD, "reframe"), "--out", folder, "--size", "24x14", "--scene", "still-life",
                       "--settings", "1:3x3", "--reference-spp", "68", "--json", report]
            said = [subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True).stderr for _ in range(2)]
            with open(report, encoding="utf-8") as file:
                table = json.load(file)[0]
        row = dict(zip(table["columns"], table["rows"][0]))
        self.assertNotIn("reference: kept", said[0])
        self.assertIn("reference: kept", said[1])
        self.assertTrue(row["reference"] < row["off: relMSE"])
        self.assertTrue(row["auto / best"] >= 1.0 and 0.0 <= row["light removed, %"] < 10.0)
        self.assertTrue(float(row["sum"]) < 1e-5)

    def test_errors(self):
        for words, text in ((["reuse", "--binary", "nowhere"], "there is no program"), (["reuse", "--size", "9"], "--size must be"), (["nothing"], "invalid choice")):
            done = subprocess.run([os.path.join(SCRIPTS, "bench", "run"), *words], stderr=subprocess.PIPE, text=True, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn(text, done.stderr)


class Validate(unittest.TestCase):
    def test_ratio_of_means(self):
        ratio, error = validate.ratio_of([1.0, 3.0], [4.0, 4.0])
        self.assertAlmostEqual(ratio, 0.5)
        self.assertAlmostEqual(error, 0.25)
        self.assertEqual(validate.ratio_of([0.0, 0.0], [1.0, 2.0]), (0.0, 0.0))
        self.assertEqual(validate.ratio_of([1.0, 1.0], [0.0, 0.0])[0], math.inf)
        self.assertEqual([validate.verdict_of(r, 0.002, 0.02) for r in (1.015, 0.985, 1.018, 1.023, 1.025, math.inf)],
                         ["within", "within", "undecided", "undecided", "outside", "outside"])

    def test_spheres_of_materials(self):
        inside = validate.disc(64)
        self.assertTrue(0.93 < inside.sum() / (0.25 * math.pi * (64 * validate.FILL) ** 2) < 1.0)
        said = ["'ball coat': material 'coat', node 'Principled BSDF': sheen: left out", "'ball coat': material 'coat': glass",
                "'ball rough coat': material 'rough coat', node 'A': no"]
        self.assertEqual(validate.warnings_of("coat", said + said), ["node 'Principled BSDF': sheen: left out", "glass"])
        self.assertEqual(validate.warnings_of("plain", said), [])

    def test_shapes(self):
        """Noise of seeds is no difference of shape, a turn of the same brightness is one."""
        inside, random = validate.disc(64), np.random.default_rng(7)
        ramp = np.repeat(np.linspace(0.5, 1.5, 64)[:, None, None], 64, axis=1) * np.ones(3)
        noisy = [ramp * random.gamma(4.0, 0.25, ramp.shape) for _ in range(8)]
        self.assertLess(abs(validate.shape_of(noisy[:4], noisy[4:], inside)), 0.03)
        turned = [picture.transpose(1, 0, 2) for picture in noisy[:4]]
        self.assertGreater(validate.shape_of(turned, noisy[4:], inside), 0.2)
        full = np.ones((64, 64), bool)
        self.assertAlmostEqual(validate.shape_of([1.1 * ramp] * 2, [ramp] * 2, full), 0.1 * np.sqrt(1.0 + 1.0 / 12.0), places=3)

    def test_survey_of_models(self):
        """A stand-in for the program does what the name of the model says."""
        program = """#!/bin/sh
case "$(cat "$2")" in
    *lossy.gltf*) echo "reframe render: warning: a.gltf: material 'x': sheen: left out" >&2;;
    *refused.gltf*) echo "reframe render: a.gltf: images[12]: 3 of 4: not valid glTF 2.0" >&2; exit 1;;
    *silent.gltf*) exit 1;;
    *crashed.gltf*) kill -SEGV $$;;
    *hung.gltf*) exec sleep 60;;
esac
"""
        with tempfile.TemporaryDirectory() as folder:
            models, binary = os.path.join(folder, "models"), os.path.join(folder, "program")
            os.mkdir(models)
            for name in ("taken", "lossy", "refused", "silent", "crashed", "hung"):
                with open(os.path.join(models, name + ".gltf"), "w", encoding="utf-8") as file:
                    file.write("{}")
            with open(os.path.join(models, "pointer.glb"), "w", encoding="utf-8") as file:
                file.write("version https://git-lfs.github.com/spec/v1\n")
            with open(binary, "w", encoding="utf-8") as file:
                file.write(program)
            os.chmod(binary, 0o755)
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                bad = validate.survey(argparse.Namespace(files=[models], out=folder, binary=binary, limit=2.0))
            self.assertEqual(bad, "crashed or hung: crashed.gltf, hung.gltf, silent.gltf")
            with open(os.path.join(folder, "models.json"), encoding="utf-8") as file:
                rows = {row["file"]: row for row in json.load(file)}
        self.assertEqual({name: row["outcome"] for name, row in rows.items()},
                         {"taken.gltf": "taken", "lossy.gltf": "lossy", "refused.gltf": "refused", "silent.gltf": "crashed",
                          "crashed.gltf": "crashed", "hung.gltf": "hung"})
        self.assertEqual(rows["lossy.gltf"]["reasons"], ["a.gltf: material '...': sheen: left out"])
        self.assertEqual(rows["refused.gltf"]["reasons"], ["a.gltf: images[]: N of N: not valid glTF 2.0"])
        self.assertIn("left out: 1 Git LFS pointers", said.getvalue())

    def test_honesty(self):
        # true, estimate, whether a lower bound, likely
        self.assertTrue(validate.honesty("", [(1.0, 1.1, False, 1.0)] * 9 + [(1.0, 2.0, False, 1.0)] + [(1.0, 0.1, True, 1.0)]))
        self.assertFalse(validate.honesty("", [(1.0, 1.1, False, 1.0)] * 8 + [(1.0, 2.0, False, 1.0)] * 2))
        self.assertFalse(validate.honesty("", [(1.0, 1.1, True, 1.0)]))


BLENDER = os.environ.get("REFRAME_BLENDER", "blender")


class Parity(unittest.TestCase):
    def test_digests_follow_what_a_scene_calls(self):
        found, names = parity.definitions()
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual([sum(name.startswith(kind) for name in names) for kind in ("room_", "move_")], [3, 12])
        before = {name: parity.digest_of(name, found) for name in ("spot_hard", "move_cloth")}
        found["bake_physics"] = found["sheet"]
        after = {name: parity.digest_of(name, found) for name in before}
        self.assertEqual(before["spot_hard"], after["spot_hard"])
        self.assertNotEqual(before["move_cloth"], after["move_cloth"])

    def test_regions(self):
        """Twice the light in one region, some in one that is dark; the noise is 1 % and 2 % of two seeds."""
        theirs = np.ones((2, 1, 12))
        theirs[..., 11] = 0.0
        ours = theirs.copy()
        ours[..., 0], ours[..., 11], ours[0, 0, 1], theirs[1, 0, 2] = 2.0, 0.01, 1.02, 1.04
        with unittest.mock.patch.object(parity, "means", side_effect=[ours, theirs]):
            row = parity.compare("", argparse.Namespace(seeds=2), {})
        mean = theirs.mean(0).mean()
        for region, off, error in ((0, 1.0, 0.0), (1, 0.01, 0.01), (2, -0.02 / 1.02, 0.02 / 1.02 ** 2), (11, 0.01 / (parity.DARK * mean), 0.0)):
            self.assertAlmostEqual(row["off"][region], off)
            self.assertAlmostEqual(row["error"][region], error)
        text = parity.summary("0", [{**row, "verdict": "warned"}, {"off": [1.0], "error": [0.0], "verdict": "refused"}])
        self.assertIn("10 of 12 regions (83.3 %) within 3 %, 2 beyond 10 %, 2 with a standard error above 0.7 %; 2 scenes: 1 warned, 1 refused", text)

    @unittest.skipIf(BUILD is None or shutil.which(BLENDER) is None, "needs the folder of a build as argument, and Blender")
    def test_scene(self):
        """The map of a sky with a sun takes longer."""
        scene = "world-sky" if "REFRAME_LONG" in os.environ else "sun-sharp"
        with tempfile.TemporaryDirectory() as folder:
            table = os.path.join(folder, "table.md")
            done = subprocess.run([os.path.join(SCRIPTS, "blender-parity"), "--blender", BLENDER, "--binary", os.path.join(BUILD, "reframe"), "--out", folder, "--only",
                                   scene, "--seeds", "2", "--markdown", table], stdout=subprocess.PIPE, text=True, check=False)
            with open(table, encoding="utf-8") as file:
                text = file.read()
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("12 of 12 regions (100.0 %) within 3 %", text)
        self.assertIn("| %s | " % scene, text)


if __name__ == "__main__":
    unittest.main()
