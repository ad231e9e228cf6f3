#!/usr/bin/env python3
"""tests/scripts/check-citations finds what leads nowhere, and takes what does not."""
import os
import subprocess
import sys
import tempfile
import unittest

CHECK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "check-citations")
GOOD = {
    "README.md": "[math](src/reuse/estimators.md#2-films), [code](src/a.c), [web](https://example.org/page)\n",
    "src/reuse/estimators.md": "# Estimators\n\n## 2. Films\n\nSee `src/a.c`; the output is build/out.md.\n",
    "src/a.c": "#include <time.h> // like reuse/estimators.md and a.c, time.h\n",
}


class Citations(unittest.TestCase):
    def expect(self, output, **changed):
        with tempfile.TemporaryDirectory() as top:
            for name, text in dict(GOOD, **changed).items():
                path = os.path.join(top, name)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
            run = subprocess.run([sys.executable, "-B", CHECK, top], stdout=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 1 if output else 0, run.stdout)
        self.assertEqual(run.stdout.split("\n")[0], output or "check-citations: 0 faults")

    def test_good_tree(self):
        self.expect("")

    def test_name_in_comment(self):
        self.expect("src/a.c:2: b.h is not there", **{"src/a.c": "//\n// see b.h\n"})

    def test_path_in_text(self):
        self.expect("README.md:1: src/b.h is not there", **{"README.md": "see `src/b.h` or sheen.c\n"})

    def test_link(self):
        self.expect("README.md:1: link to sub/b.c: is not there", **{"README.md": "[code](sub/b.c)\n"})

    def test_heading(self):
        self.expect("README.md:1: link to src/reuse/estimators.md#3-films: no such heading",
                    **{"README.md": "[math](src/reuse/estimators.md#3-films)\n"})


if __name__ == "__main__":
    unittest.main()
