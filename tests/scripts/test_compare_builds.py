#!/usr/bin/env python3
"""scripts/compare-builds: its sums against figures whose answer is known, and a run. Skipped (77) without numpy."""
import importlib.machinery
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
except ImportError:
    if sys.executable != "/usr/bin/python3" and os.path.exists("/usr/bin/python3"):  # Debian's has it if another is first in the path
        os.execv("/usr/bin/python3", ["/usr/bin/python3", "-B", *sys.argv])
    print("skipped: there is no numpy (apt-get install python3-numpy)")
    sys.exit(77)

BUILD = sys.argv.pop(1)
SCENE = sys.argv.pop(1)
TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.join(TOP, "scripts", "compare-builds")
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("compare_builds", PROGRAM)
builds = importlib.util.module_from_spec(importlib.util.spec_from_loader("compare_builds", loader))
loader.exec_module(builds)


def noisy(rng, seeds, sigma, size=(2, 40, 60)):
    return rng.normal(1.0, sigma, (seeds, *size, 3)).astype(np.float32)


class Sums(unittest.TestCase):
    def test_error_with_and_without_reference(self):
        # sigma 0.2: 3 channels of 0.04; the reference's halves have 0.4, so their mean 3 channels of 0.08
        rng = np.random.default_rng(1)
        pictures, halves, below, cpu = noisy(rng, 4, 0.2), noisy(rng, 2, 0.4), np.ones((2, 40, 60)), np.ones(4)
        alone, beside = builds.figures(cpu, pictures, below), builds.figures(cpu, pictures, below, halves)
        self.assertAlmostEqual(alone["relmse"][0], 0.12, delta=0.004)
        self.assertAlmostEqual(beside["relmse"][0], 0.12, delta=0.012)
        self.assertTrue(alone["median"][0] < alone["trimmed"][0] < alone["relmse"][0])
        # a picture too bright by 0.5: 3 channels of 0.25, which the seeds alone do not show
        self.assertAlmostEqual(builds.figures(cpu, pictures + 0.5, below)["relmse"][0], 0.12, delta=0.004)
        self.assertAlmostEqual(builds.figures(cpu, pictures + 0.5, below, halves)["relmse"][0], 0.87, delta=0.02)

    def test_rows(self):
        def of(error, cpu, mean):
            return {"relmse": np.full(5, error), "trimmed": np.full(5, error / 2), "median": np.full(5, error / 8), "cpu": np.full(5, cpu), "mean": np.full(5, mean)}

        first, second = builds.make_rows({"a": of(0.4, 3.0, 1.0), "b": of(0.1, 6.0, 1.01)})
        self.assertEqual((first["efficiency"], first["error_ratio"], first["brightness"]), ((1.0, 0.0), (1.0, 0.0), (0.0, 0.0)))
        for key, figure in (("efficiency", 2.0), ("trimmed", 2.0), ("median", 2.0), ("error_ratio", 0.25), ("cpu_ratio", 2.0), ("brightness", 1.0)):
            self.assertAlmostEqual(second[key][0], figure)
            self.assertAlmostEqual(second[key][1], 0.0)

        with self.assertRaises(SystemExit) as raised:
            builds.make_rows({"a": of(0.4, 3.0, 1.0), "b": of(0.0, 6.0, 0.0)})
        self.assertIn("b: no error is left", raised.exception.code)

    def test_standard_error(self):
        # of a mean the jackknife gives s / sqrt(n) exactly
        values = np.array([1.0, 4.0, 2.0, 7.0, 3.0])
        left_out = [np.delete(values, i).mean() for i in range(5)]
        self.assertAlmostEqual(builds.spread(np.array([values.mean(), *left_out]))[1], values.std(ddof=1) / np.sqrt(5))
        # and of a ratio of variances as much as it scatters when all is done again, also where single bright pixels decide
        rng, below = np.random.default_rng(2), np.ones((1, 5, 8))
        for spikes in (0.0, 0.02):
            figures, errors = [], []
            for _ in range(200):
                def pictures(sigma):
                    made = noisy(rng, 8, sigma, (1, 5, 8))
                    return made + 3.0 * sigma * (rng.random(made.shape) < spikes)
                cpu = rng.normal(1.0, 0.05, 8)
                found = {"a": builds.figures(np.ones(8), pictures(0.2), below), "b": builds.figures(cpu, pictures(0.1), below)}
                figure, error = builds.make_rows(found)[1]["efficiency"]
                figures.append(figure)
                errors.append(error)
            self.assertAlmostEqual(np.mean(figures), 4.0, delta=0.3)
            self.assertAlmostEqual(np.sqrt(np.mean(np.square(errors))) / np.std(figures), 1.0, delta=0.2)

    def test_variant(self):
        v = builds.variant("a-1=%s,8:rooks16,A=b=c,--adaptive=off,--no-half" % BUILD, "3:3x3")
        self.assertEqual(v, ("a-1", os.path.join(BUILD, "reframe"), "8:rooks16", {"A": "b=c"}, ["--adaptive=off", "--no-half"]))
        self.assertEqual(builds.variant("b=" + v.binary, "3:3x3").setting, "3:3x3")


class Run(unittest.TestCase):
    def run_it(self, *words):
        return subprocess.run([sys.executable, "-B", PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)

    def test_errors(self):
        for words, text in (((SCENE, "a=" + BUILD), "two variants"), ((SCENE, "a=" + BUILD, "a=" + BUILD), "two variants"), ((SCENE, "a", "b"), "LABEL=BUILD"),
                            ((SCENE, "a=nowhere", "b=" + BUILD), "no program"), ((SCENE, "a=%s,3" % BUILD, "b=" + BUILD), "'3' is neither"),
                            ((SCENE, "a=" + BUILD, "b=" + BUILD, "--seeds", "2"), "--seeds"), ((SCENE, "a=" + BUILD, "b=" + BUILD, "--size", "9"), "--size"),
                            (("nowhere.glb", "a=" + BUILD, "b=" + BUILD), "no scene nowhere.glb")):
            done = self.run_it(*words)
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (1, "", 1), done.stderr)
            self.assertIn(text, done.stderr)

    def test_run(self):
        with tempfile.TemporaryDirectory() as folder:
            report = os.path.join(folder, "report.json")
            done = self.run_it(SCENE, "one=" + BUILD, "same=" + BUILD, "plain=%s,0:1,--no-adaptive,OMP_DYNAMIC=false" % BUILD, "dark=%s,--max-depth=2" % BUILD,
                               "--out", folder, "--size", "24x14", "--frames", "20-22", "--setting", "1:2x2", "--spp", "6", "--seeds", "3", "--reference-spp", "40",
                               "--json", report, "--", "--max-depth", "4", "--adaptive")
            said = [line for line in done.stderr.splitlines() if not line.startswith("reframe render: warning: --max-depth")]
            self.assertEqual((done.returncode, len(said)), (0, 1), done.stderr)  # the reference is named
            with open(report) as file:
                one, same, plain, dark = json.load(file)["rows"]
        self.assertEqual([same[key] for key in ("error_ratio", "brightness")], [[1.0, 0.0], [0.0, 0.0]])
        self.assertEqual(one["efficiency"], [1.0, 0.0])
        self.assertTrue(plain["error_ratio"][0] > 1.0 > plain["cpu_ratio"][0] and plain["brightness"][1] > 0.0)
        self.assertTrue(dark["brightness"][0] < -20.0 and dark["error_ratio"][0] > 1.0)
        self.assertIn("against 40 samples of 0:1", done.stdout)
        self.assertEqual(len(done.stdout.splitlines()), 6)


if __name__ == "__main__":
    unittest.main()
