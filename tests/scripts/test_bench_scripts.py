#!/usr/bin/env python3
"""The sums of scripts/bench-*, against figures whose answer is known."""
import importlib.machinery
import importlib.util
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile
import unittest

BUILD = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.isdir(sys.argv[1]) else None
SCRIPTS = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scripts")
sys.dont_write_bytecode = True
sys.path.insert(0, SCRIPTS)
import benchlib  # noqa: E402
import cycleslib  # noqa: E402
import errorlib  # noqa: E402
import materiallib  # noqa: E402
import picturelib  # noqa: E402


def load(name):
    loader = importlib.machinery.SourceFileLoader(name.replace("-", "_"), os.path.join(SCRIPTS, name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


flicker, lens, memory, mirrors, paper, tune = (load(name) for name in ("bench-flicker", "bench-lens", "bench-memory", "bench-mirrors", "bench-paper", "check-tune"))
materials = load("compare-materials")


class FakeJob:
    """Renders in 3 s and 0.25 s for each sample."""

    def __init__(self):
        self.asked = []

    def render(self, setting, spp):
        self.asked.append(spp)
        return {"cpu": 3.0 + 0.25 * spp}


def row(setting, cpu, f1_squared, mse, pairs=()):
    return {"setting": setting, "spp": 1, "cpu": cpu, "relmse": 2.0 * mse, "f1_squared": f1_squared, "mse": mse,
            "followed": {"f1_squared": f1_squared, "mse": mse}, "pairs": list(pairs)}


def pairs_of(count, content, factor, border=lambda frame: False):
    return [{"frame": frame, "border": border(frame), "f1_squared": (content(frame) * factor(frame)) ** 2} for frame in range(2, count + 1)]


class Sums(unittest.TestCase):
    def test_reference_share(self):
        error_of_one = 3.0
        measured = error_of_one / 16 + error_of_one / 1024
        self.assertAlmostEqual(measured * benchlib.reference_share(16, 1024), error_of_one / 1024)

    def test_line(self):
        fixed, slope = benchlib.line_through((2, 5.0), (6, 11.0))
        self.assertAlmostEqual(fixed, 2.0)
        self.assertAlmostEqual(slope, 1.5)


class Lens(unittest.TestCase):
    def test_all_but_one_in_a_hundred(self):
        self.assertEqual(lens.most_of([7.0] * 995 + [90.0] * 5), 7.0)
        self.assertEqual(lens.most_of([7.0] * 980 + [90.0] * 20), 90.0)

    def test_kept(self):
        def rows(*gains):
            return [[{"setting": s, "cpu": 1.0, "relmse": 1.0, "gain": g, "gain_trimmed": g, "gain_median": g} for s, g in (("0:1", 1.0), ("3:3x3", gain))] for gain in gains]

        found = lens.summarise(rows(2.0, 8.0), rows(4.0, 8.0))
        self.assertAlmostEqual(found[0]["kept"], 1.0)
        self.assertAlmostEqual(found[1]["kept"], math.sqrt(0.5))
        self.assertAlmostEqual(found[1]["kept_error"], 0.5 * math.log(2.0))
        self.assertIsNone(lens.summarise(rows(2.0), rows(4.0))[1]["kept_error"])


class Memory(unittest.TestCase):
    def test_ratio(self):
        middle, low, high = memory.ratio([(10.0, 11.0), (8.0, 8.4), (9.0, 12.6)])
        self.assertAlmostEqual(middle, 11.0 / 9.0)
        self.assertAlmostEqual(low, 1.05)
        self.assertAlmostEqual(high, 1.4)


    def test_combine(self):
        runs = [{"a": 1.0, "b": [2.0, {"c": "x"}], "n": 7}, {"a": 4.0, "b": [3.0, {"c": "x"}], "n": 7}, {"a": 2.0, "b": [9.0, {"c": "x"}], "n": 7}]
        self.assertEqual(benchlib.combine(statistics.median, runs), {"a": 2.0, "b": [3.0, {"c": "x"}], "n": 7})
        spans = paper.ranges([{"rows": [{"sooner": s, "sooner_at_equal_error": -s}]} for s in (3.0, 5.0, 4.0)])
        self.assertEqual(spans, [{"sooner": [3.0, 5.0], "sooner_at_equal_error": [-5.0, -3.0]}])


class Flicker(unittest.TestCase):
    def test_samples_for_seconds(self):
        job = FakeJob()
        self.assertEqual(flicker.samples_for(job, "3:1", 3.0 + 0.25 * 29), 28)
        self.assertEqual(flicker.samples_for(job, "0:1", 3.0 + 0.25 * 29), 29)
        self.assertEqual(flicker.samples_for(job, "8:1", 1.0), 17)  # less than a group needs is not to be had
        self.assertTrue(all(spp % 7 == 0 for spp in job.asked[:2]))

    def test_one_call_of_flicker(self):
        class Job(FakeJob):
            def render(self, setting, spp, seed=1):
                return super().render(setting, spp)

            def flicker(self, setting):
                return {"relmse": 0.5, "f1": 2.0, "mse": 3.0, "phi": 0.7, "motion": None,
                        "followed": {"f1": 1.0, "mse": 2.0, "phi": 0.25, "motion": 4.5, "coverage": 0.9},
                        "pairs": [{"frame": 2, "border": False, "f1": 3.0, "followed": None}]}

        done = flicker.measure(Job(), "3:1", 4, 1)
        self.assertEqual((done["cpu"], done["f1_squared"], done["mse"], done["motion"]), (4.0, 4.0, 3.0, 4.5))
        self.assertEqual(done["followed"], {"f1_squared": 1.0, "mse": 2.0})
        self.assertEqual(done["pairs"], [{"frame": 2, "border": False, "f1_squared": 9.0}])

    def test_reference_is_taken_off(self):
        # noise that is independent (phi 1) and of a group of 7 (1/7), and the reference with 1/16 of the last
        plain, last = 0.4, 0.1
        own = last / 16
        rows = [row("0:1", 10.0, 2 * plain + 2 * own / 7, plain + own), row("3:1", 5.0, 2 * last / 7 + 2 * own / 7, last + own)]
        flicker.correct(rows, 16)
        self.assertAlmostEqual(rows[0]["phi"], 1.0)
        self.assertAlmostEqual(rows[1]["phi"], 1.0 / 7.0)
        self.assertAlmostEqual(rows[1]["followed"]["phi"], 1.0 / 7.0)
        self.assertAlmostEqual(rows[1]["reference_share"], 1.0 / 17.0)
        # half the seconds: at as many, half of the squares
        self.assertAlmostEqual(rows[1]["f1"] ** 2, last / 7)
        self.assertAlmostEqual(rows[1]["f1_below"], math.sqrt(2 * plain / (last / 7)))
        self.assertAlmostEqual(rows[1]["relmse_equal"], last)

    def test_seams(self):
        # before frames 8, 15, ... a change of half as much again; then none
        seamy = row("3:1", 1.0, 1.0, 1.0, pairs_of(48, lambda frame: 1.0, lambda frame: 0.15 if frame % 7 == 1 else 0.1))
        there, least, most = flicker.seams(seamy)
        self.assertAlmostEqual(there, 1.5)
        self.assertTrue(least <= most < 1.0)
        for ratio in flicker.seams(row("3:1", 1.0, 1.0, 1.0, pairs_of(48, lambda frame: 1.0, lambda frame: 0.1))):
            self.assertAlmostEqual(ratio, 1.0)
        # nor in a picture whose flicker grows as it goes
        for ratio in flicker.seams(row("3:1", 1.0, 1.0, 1.0, pairs_of(48, lambda frame: math.sqrt(frame), lambda frame: 0.1))):
            self.assertAlmostEqual(ratio, 1.0)
        self.assertIsNone(flicker.seams(row("0:1", 1.0, 1.0, 1.0, pairs_of(48, lambda frame: 1.0, lambda frame: 1.0))))

    def test_ends(self):
        def at_end(frame):
            return frame < 7 or frame > 42

        # twice as noisy a picture at the ends
        def content(frame):
            return 2.0 if at_end(frame) else 1.0

        first = row("0:1", 1.0, 1.0, 1.0, pairs_of(48, content, lambda frame: 1.0))
        mine = row("3:1", 1.0, 1.0, 1.0, pairs_of(48, content, lambda frame: 0.09 if at_end(frame) else 0.1, at_end))
        self.assertAlmostEqual(flicker.ends(mine, first), 0.9)
        inside = row("3:1", 1.0, 1.0, 1.0, pairs_of(48, content, lambda frame: 0.1))
        self.assertIsNone(flicker.ends(inside, first))


def noisy(rng, count, brightness, sigma):
    return 1, count, [[rng.gauss(brightness, sigma) for _ in range(count)] for _ in range(3)]


class Mirrors(unittest.TestCase):
    def test_two_seeds_give_the_error(self):
        # sigma 0.2 at brightness 1: 3 channels of 0.04 / 1
        rng, count = random.Random(1), 4000
        below = dict.fromkeys((1, 2, 3), [1.0] * count)

        def errors_of(_):
            return [errorlib.difference(noisy(rng, count, 1.0, 0.2), noisy(rng, count, 1.0, 0.2), math.sqrt(0.5))]

        made = errorlib.summary(errorlib.follow((1, 2, 3), errors_of, below), None)
        self.assertAlmostEqual(made["relmse"], 0.12, delta=0.005)
        self.assertAlmostEqual(made["phi"], 1.0, delta=0.05)
        self.assertAlmostEqual(made["f1_squared"], 2 * 2 * 0.12 * count, delta=0.05 * 0.48 * count)
        self.assertTrue(made["median"] < made["trimmed"] < made["relmse"])

    def test_reference_is_taken_off(self):
        rng, count = random.Random(2), 4000
        below, reference, own = {1: [1.0] * count, 2: [1.0] * count}, {}, {}
        for frame in below:
            a, b = noisy(rng, count, 1.0, 0.2), noisy(rng, count, 1.0, 0.2)
            reference[frame], own[frame] = picturelib.mean([a, b]), [errorlib.difference(a, b, 0.5)]
        measured = errorlib.follow(below, lambda f: [errorlib.difference(noisy(rng, count, 1.0, 0.1), reference[f], 1.0)], below)
        made = errorlib.summary(measured, errorlib.follow(below, own.get, below))
        self.assertAlmostEqual(errorlib.summary(measured, None)["relmse"], 0.03 + 0.06, delta=0.005)
        self.assertAlmostEqual(made["relmse"], 0.03, delta=0.005)
        self.assertAlmostEqual(made["phi"], 1.0, delta=0.15)

    def test_gains(self):
        def of(error):
            return {"relative": {1: [error] * 4}, "change": error, "both": error}

        plain, reused = errorlib.make_rows({"0:1": of(1.0), "3:1": of(0.1)}, None, {"0:1": 3.0, "3:1": 6.0}, {"0:1": 14.0, "3:1": 15.8})
        self.assertEqual((plain["gain"], plain["f1_below"], reused["samples"]), (1.0, 1.0, 15.8))
        for key in ("gain", "gain_trimmed", "gain_median"):
            self.assertAlmostEqual(reused[key], 5.0)
        self.assertAlmostEqual(reused["f1_below"], math.sqrt(5.0))

    def test_regions(self):
        measured = {"0:1": {"relative": {1: [8.0, 2.0, 1.0, 1.0]}}, "3:1": {"relative": {1: [8.0, 0.2, 0.1, 0.1]}}}
        rows = [{"setting": "0:1", "cpu": 1.0}, {"setting": "3:1", "cpu": 2.0}]
        found = {"mirror": {1: [0]}, "floor": {1: [1, 2]}, "speck": {1: [3]}}
        mirror, floor, speck = errorlib.region_rows(found, measured, None, rows)
        self.assertEqual((mirror["pixels"], floor["pixels"]), (0.25, 0.5))
        self.assertAlmostEqual(floor["settings"][0]["share"], 0.25)
        self.assertAlmostEqual(floor["settings"][1]["relmse"], 0.15)
        self.assertAlmostEqual(floor["settings"][1]["gain"], 5.0)
        self.assertAlmostEqual(mirror["settings"][1]["gain"], 0.5)
        self.assertEqual(errorlib.merge_small(found, measured, 0.26, [1]), {"mirror": {1: [0]}, "floor": {1: [1, 2]}, "all others": {1: [3]}})
        own = {"relative": {1: [0.0, 0.1, 0.05, 0.05]}}
        self.assertAlmostEqual(errorlib.region_rows(found, measured, own, rows)[2]["settings"][1]["relmse"], 0.05)

    def test_region_option(self):
        self.assertEqual(mirrors.region("tea pot=1,2,30,40@5-7"), ("tea pot", [1, 2, 30, 40], (5, 7)))
        self.assertEqual(mirrors.region("a=1,2,3,4@5"), ("a", [1, 2, 3, 4], (5, 5)))
        with self.assertRaises(mirrors.argparse.ArgumentTypeError):
            mirrors.region("a=1,2,3")

    def test_pictures(self):
        picture = 3, 2, [[float(10 * c + i) for i in range(6)] for c in range(3)]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.exr")
            picturelib.write(path, picture)
            width, height, channels = picturelib.read(path)
        self.assertEqual((width, height, [list(c) for c in channels]), picture)
        self.assertEqual(picturelib.enlarge(picture, 2)[2][0][:12], [0, 0, 1, 1, 2, 2] * 2)
        # the corner counts its edges twice: rows 0,0,3 of columns 0,0,1
        blurred = picturelib.blur(picture[2][0], 3)
        self.assertAlmostEqual(blurred[0], (0 + 0 + 1 + 0 + 0 + 1 + 3 + 3 + 4) / 9)
        self.assertAlmostEqual(statistics.mean(picturelib.blur([7.0] * 6, 3)), 7.0)

    def test_materials_become_numbers(self):
        gltf = {"materials": [{"name": "mirror", "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}, "alphaMode": "MASK"},
                              {"name": "pane", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}],
                "meshes": [{"primitives": [{"material": 1}, {}]}], "scenes": [{"extras": {"reframe": {}}}]}
        self.assertEqual(materiallib.number(gltf), ["mirror (metal 0)", "pane (pane 1)", "no material"])
        self.assertEqual([p["material"] for p in gltf["meshes"][0]["primitives"]], [1, 2])
        self.assertEqual([round(materiallib.STEPS * m["emissiveFactor"][0]) for m in gltf["materials"]], [1, 2, 3])
        self.assertEqual(gltf["materials"][0]["alphaMode"], "MASK")
        self.assertNotIn("extensions", gltf["materials"][1])

    def test_edges(self):
        # rows AAAA, AAAA, AAAB
        found = {"a": list(range(11)), "b": [11]}
        self.assertEqual(materiallib.split_edges(found, 4, 3), {"a inside": [0, 1, 2, 3, 4, 5, 8, 9], "a edge": [6, 7, 10], "b edge": [11]})

    def test_options_are_dropped(self):
        given = ["--adaptive", "on", "--light-samples", "2", "--no-half", "--max-depth=5"]
        self.assertEqual(benchlib.without(given, "--adaptive", "--max-depth"), ["--light-samples", "2", "--no-half"])
        self.assertEqual(benchlib.without(["--adaptive", "--seed", "3"], "--adaptive"), ["--seed", "3"])

    @unittest.skipIf(BUILD is None, "needs the folder of a build as argument")
    def test_run(self):
        with tempfile.TemporaryDirectory() as folder:
            report = os.path.join(folder, "report.json")
            picture = os.path.join(folder, "group1-tile1-seed2.0021.exr")

            def run(*regions):
                subprocess.run([os.path.join(SCRIPTS, "bench-mirrors"), "--binary", os.path.join(BUILD, "reframe"), "--out", folder, "--size", "24x14",
                                "--frames", "20-22", "--settings", "0:1,1:1", "--spp", "6", "--json", report, "--keep-renders", *regions,
                                "--", "--max-depth", "4", "--adaptive"], check=True, stdout=subprocess.DEVNULL)
                with open(report) as file:
                    return json.load(file), os.stat(picture).st_mtime_ns

            first, rendered = run()
            made, kept = run("--reference-spp", "12", "--materials", "--beside", "table", "--map", "21",
                             "--region", "left=0,0,12,14", "--region", "right=12,0,24,14")
            with open(os.path.join(folder, "error-group1-tile1-0021.png"), "rb") as file:
                self.assertEqual(file.read(4), b"\x89PNG")
        self.assertEqual(rendered, kept)
        self.assertEqual([r["cpu"] for r in first["rows"]], [r["cpu"] for r in made["rows"]])
        self.assertEqual(first["regions"], {})
        self.assertEqual(made["rows"][0]["gain"], 1.0)
        self.assertTrue(all(r["cpu"] > 0 and r["relmse"] > 0 for r in made["rows"]))
        sides, materials = made["regions"]["rectangles"], made["regions"]["materials"]
        for parts in (sides, materials):
            self.assertAlmostEqual(sum(r["pixels"] for r in parts), 1.0)
            for setting in range(2):
                self.assertAlmostEqual(sum(r["settings"][setting]["share"] for r in parts), 1.0)
        # what is named is in the picture: the mirror takes a seventh of it
        mirror = next(r for r in materials if r["region"] == "mirror (metal 0)")
        self.assertTrue(0.08 < mirror["pixels"] < 0.2)


class Paper(unittest.TestCase):
    def test_row(self):
        plain = {"fixed": 2.0, "per_sample": 0.5, "error": 4.0, "own": 0.01}
        frames = [{"effective_spp": 90.0 if 7 <= i < 41 else 150.0} for i in range(48)]
        done = {"frames": frames, "error": 0.05 + 0.01, "cpu": 7.0, "peak_bytes": 1, "resident": 2}
        made = paper.compare(paper.EXPERIMENTS["A"], plain, "3:1", done)
        self.assertEqual((made["possible"], made["landed"]), (98, 90.0))
        self.assertAlmostEqual(made["sooner"], (2.0 + 45.0) / 7.0)
        self.assertAlmostEqual(made["sooner_with_ends"], (2.0 + 0.5 * (34 * 90.0 + 14 * 150.0) / 48) / 7.0)
        self.assertAlmostEqual(made["equal_spp"], 80.0)
        self.assertAlmostEqual(made["sooner_at_equal_error"], 42.0 / 7.0)


class Tune(unittest.TestCase):
    def test_summary(self):
        made = tune.summary([(2.0, 0.02), (4.0, 0.04), (3.0, 0.03)])
        self.assertAlmostEqual(made["cpu"], 3.0)
        self.assertAlmostEqual(made["relmse"], 0.03)
        self.assertAlmostEqual(made["efficiency"], 1 / 0.09)
        logs = [math.log(1 / 0.04), math.log(1 / 0.16), math.log(1 / 0.09)]
        mean = sum(logs) / 3
        self.assertAlmostEqual(made["spread"], math.sqrt(sum((x - mean) ** 2 for x in logs) / 2))
        self.assertIsNone(tune.summary([(2.0, 0.02)])["spread"])

    def test_lost(self):
        # one run below zero, still an error in the mean; then nothing left, or less
        self.assertAlmostEqual(tune.summary([(1.0, 0.03), (1.0, -0.01)])["efficiency"], 100.0)
        self.assertIsNone(tune.summary([(1.0, 0.03), (1.0, -0.01)])["spread"])
        self.assertIsNone(tune.summary([(1.0, 0.01), (1.0, -0.01)])["efficiency"])
        self.assertIsNone(tune.summary([(1.0, -0.01)])["efficiency"])

    def swept(self):
        return {s: tune.summary([(1.0, error)]) for s, error in {"0:1": 0.1, "3:3x3": 0.012, "8:3x3": 0.01, "16:4x4": -0.001}.items()}

    def test_judge(self):
        top, ratio, lost = tune.judge(self.swept(), "3:3x3")
        self.assertEqual((top, lost), ("8:3x3", ["16:4x4"]))
        self.assertAlmostEqual(ratio, 10 / 12)
        self.assertEqual(tune.judge(self.swept(), "16:4x4"), ("8:3x3", None, ["16:4x4"]))
        self.assertEqual(tune.judge({"0:1": tune.summary([(1.0, -0.1)])}, "0:1"), (None, None, ["0:1"]))

    def test_verdict(self):
        good, bad = {"scene": "a", "ratio": 0.85, "lost": []}, {"scene": "b", "ratio": 0.84, "lost": []}
        self.assertEqual(tune.verdict([good], 0), ("within 15 % of the best in all scenes", 0))
        self.assertEqual(tune.verdict([good, bad], 0), ("not within 15 % of the best: b", 1))
        text, status = tune.verdict([good], 0.6)
        self.assertEqual(status, 0)
        self.assertTrue(text.startswith("within 15 % of the best in all scenes; NOT an exhaustive sweep") and "0.6" in text)
        for ratio in (None, 0.9):  # what is lost may be the best
            text, status = tune.verdict([good, {"scene": "c", "ratio": ratio, "lost": ["8:3x3"]}], 0)
            self.assertEqual(status, 1)
            self.assertTrue("c 8:3x3" in text and "lost in the reference's noise" in text and "within 15" not in text)

    def test_ratio_of_means(self):
        ratio, error = cycleslib.ratio_of([1.0, 3.0], [4.0, 4.0])
        self.assertAlmostEqual(ratio, 0.5)
        self.assertAlmostEqual(error, 0.25)
        self.assertEqual(cycleslib.ratio_of([0.0, 0.0], [1.0, 2.0]), (0.0, 0.0))
        self.assertEqual(cycleslib.ratio_of([1.0, 1.0], [0.0, 0.0])[0], math.inf)
        self.assertEqual([cycleslib.verdict_of(r, 0.002, 0.02) for r in (1.015, 0.985, 1.018, 1.023, 1.025, math.inf)],
                         ["within", "within", "undecided", "undecided", "outside", "outside"])

    def test_spheres_of_materials(self):
        inside = materials.disc(64)
        share = len(inside) / (0.25 * math.pi * (64 * materials.FILL) ** 2)
        self.assertTrue(0.93 < share < 1.0)
        said = ["'ball coat': material 'coat', node 'Principled BSDF': sheen: left out", "'ball coat': material 'coat': glass",
                "'ball rough coat': material 'rough coat', node 'A': no"]
        self.assertEqual(materials.warnings_of("coat", said + said), ["node 'Principled BSDF': sheen: left out", "glass"])
        self.assertEqual(materials.warnings_of("plain", said), [])


if __name__ == "__main__":
    unittest.main()
