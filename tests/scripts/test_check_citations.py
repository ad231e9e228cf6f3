#!/usr/bin/env python3
"""tests/scripts/check-citations finds what leads nowhere, figures that are not on the page and pages that are old, and takes the rest."""
import os
import subprocess
import sys
import tempfile
import unittest

CHECK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "check-citations")
PAGE, MARK = "scripts/bench/RESULTS.md", "<!-- figures of scripts/bench/RESULTS.md: %s -->\n"
TABLE = MARK % "attic, hall: efficiency 3:3x3,\nflicker 8:1" + "\n|room|a|b|\n|---|---|---|\n|attic|8.1|12|\n|hall|2|0.9|\n"
GOOD = {
    "README.md": "[math](src/reuse/estimators.md#2-films), [code](src/a.c), [web](https://example.org/page)\n\n" + TABLE + "\n"
                 + MARK % "office: efficiency Reframe" + "It is 33 times as fast in 3 times the memory.\n",
    PAGE: "Written by `x`: revision a, pictures 2, a CPU.\n\n|scene|efficiency|flicker|\n|---|---:|---:|\n|attic 3:3x3|8.06|1|\n|attic 8:1, heavy tails|7|12.3|\n"
          "|hall 3:3x3|2.04|1|\n|hall 8:1|1|0.941|\n\n|scene, renderer|efficiency|\n|---|---:|\n|office, Cycles|1|\n|office, Reframe|33.4|\n",
    "src/output/version.c": "#define PICTURES 2\n",
    "src/reuse/estimators.md": "# Estimators\n\n## 2. Films\n\nSee `src/a.c`; the output is build/out.md.\n",
    "src/a.c": "#include <time.h> // like reuse/estimators.md and a.c, time.h\n",
}


class Citations(unittest.TestCase):
    def expect(self, output, *words, code=None, **changed):
        with tempfile.TemporaryDirectory() as top:
            for name, text in dict(GOOD, **changed).items():
                path = os.path.join(top, name)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
            run = subprocess.run([sys.executable, "-B", CHECK, *words, top], stdout=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, (1 if output else 0) if code is None else code, run.stdout)
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

    def test_figures(self):
        text, need = GOOD["README.md"], "figures of %s need a comment that says which" % PAGE
        for old, new, fault in (("|attic|8.1", "|attic|8.2", "8: 8.2: efficiency of attic 3:3x3 is 8.06 in " + PAGE),
                                ("|0.9|", "|1|", "9: 1: flicker of hall 8:1 is 0.941 in " + PAGE),
                                ("attic, hall", "attic, cellar", "9: 2: efficiency of cellar 3:3x3 is not there in " + PAGE),
                                ("attic, hall", "attic", "6: 4 figures are quoted, 2 are named"),
                                ("It is 33", "It is 35", "12: 35: efficiency of office Reframe is 33.4 in " + PAGE),
                                (MARK % "office: efficiency Reframe", "", "11: 33: " + need),
                                ("|hall", "\n|hall", "6: 2 figures are quoted, 4 are named")):
            with self.subTest(fault):
                self.expect("README.md:" + fault, **{"README.md": text.replace(old, new)})

    def test_old_pages(self):
        self.expect("", "--release")
        warning = "%s is of older pictures than src/output/version.c: scripts/bench/run all --write %s" % (PAGE, PAGE)
        for changed in ({"src/output/version.c": "#define PICTURES 3\n"}, {PAGE: GOOD[PAGE].replace(", pictures 2", "")}):
            self.expect("warning: " + warning, code=0, **changed)
            self.expect(warning, "--release", **changed)


if __name__ == "__main__":
    unittest.main()
