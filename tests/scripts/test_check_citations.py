#!/usr/bin/env python3
"""tests/scripts/check-citations finds what leads nowhere, and takes what does not."""
import os
import subprocess
import sys
import tempfile
import unittest

CHECK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "check-citations")
GOOD = {
    "README.md": "# Name\n\n[math](src/reuse/estimators.md#2-films), [code](src/a.c), [web](https://example.org/x.md)\n",
    "src/reuse/estimators.md": "# Estimators\n\nFR (16), PR section 3.6\n\n## 2. Films\n\n    I = A / B    (E1)\n",
    "src/a.c": '// See src/reuse/estimators.md, section 2 (E1), FR (16), a.h and reuse/b.h.\n#include "gone.h"\nint a; // src/*.c\n',
    "src/a.h": "// scripts/run makes it.\n",
    "src/reuse/b.h": "// Beside estimators.md; PR section 3.6.\n",
    "scripts/run": "# scenes/make-NAME.py out/x.glb\n",
    "scenes/make-room.py": "",
}


def faults(**changed):
    """What the check says of the good tree with some files changed; names with __ for / and _DOT_ for a dot."""
    files = dict(GOOD, **{name.replace("__", "/").replace("_DOT_", "."): text for name, text in changed.items()})
    with tempfile.TemporaryDirectory() as top:
        for name, text in files.items():
            if text is None:
                continue
            path = os.path.join(top, name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        run = subprocess.run([sys.executable, "-B", CHECK, top], stdout=subprocess.PIPE, text=True)
        return run.returncode, run.stdout


class Citations(unittest.TestCase):
    def expect(self, text, **changed):
        status, output = faults(**changed)
        self.assertEqual((status, output.count("\n")), (1, 1), output)
        self.assertIn(text, output)

    def test_good_tree(self):
        status, output = faults()
        self.assertEqual(status, 0, output)

    def test_path_in_a_comment(self):
        self.expect("src/a.h:1: scripts/gone is not there", src__a_DOT_h="// scripts/gone makes it.\n")

    def test_file_named_in_a_comment(self):
        self.expect("src/a.h:2: reuse/gone.h is not there", src__a_DOT_h="//\n// see reuse/gone.h\n")

    def test_path_in_a_message(self):
        self.expect("src/a.h:1: tests/gone.c is not there", src__a_DOT_h='const char* m = "see tests/gone.c";\n')

    def test_path_in_a_script(self):
        self.expect("scripts/run:1: scenes/take-NAME.py is not there", scripts__run="# scenes/take-NAME.py\n")

    def test_equation(self):
        self.expect("(E7) is not in", src__a_DOT_h="// by (E7)\n")

    def test_section(self):
        self.expect("section 3 is not in", src__a_DOT_h="// src/reuse/estimators.md, sections 2 and 3\n")

    def test_equation_of_a_paper(self):
        self.expect("FR (15) is not in", src__a_DOT_h="// FR (15)\n")

    def test_link(self):
        self.expect("link to gone.md: is not there", README_DOT_md="[text](gone.md)\n")

    def test_heading(self):
        self.expect("no such heading", README_DOT_md="[math](src/reuse/estimators.md#3-films)\n")

    def test_path_outside(self):
        self.expect("is outside of the repository", src__a_DOT_h="// (../../design/cli.md)\n")

    def test_path_above(self):
        self.expect("src/reuse/b.h:1: ../gone.h is not there", src__reuse__b_DOT_h="// (../gone.h)\n")

    def test_built_program(self):
        self.expect("build/tests/test_gone has no source", README_DOT_md="Run build/tests/test_gone.\n")

    def test_path_of_a_machine(self):
        self.expect("is a path of one machine", src__a_DOT_h="// see /home/me/notes\n")

    def test_long_readme(self):
        self.expect("has more than 150 lines", README_DOT_md="text\n" * 151)

    def test_missing_readme(self):
        self.expect("is not there, or empty", README_DOT_md=None)


if __name__ == "__main__":
    unittest.main()
