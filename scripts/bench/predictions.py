"""What `cost` predicts beside what renders take."""
import math
import os

import pictures
import numpy as np
import runs

WAYS = ("plain", "reuse")  # of the JSON of `cost`
SLOPES = ("slope_plain", "slope")


class Truth:
    """Renders by one way, with the samples that the seeds of `cost` predict in the middle for each error; to samples close by they are brought by the
    slope found and by the CPU seconds of a sample."""

    def __init__(self, args, said, way, setting):
        self.way, self.said, self.setting, self.errors, self.args = way, said, setting, {}, args
        self.slope = np.median([s[SLOPES[way]] for s in said])
        self.eyes = 2 * int(setting.split(":")[0]) + 1

    def rows(self, k):
        return [s["wanted"][k][WAYS[self.way]] for s in self.said]

    def render(self, k, scene, size, frames, below, say):
        """A pair of seeds; returns what errors are divided by, of the first pair where there is none yet."""
        spp = sorted(row["spp"] for row in self.rows(k))[len(self.said) // 2]
        pattern, seen, cpu = os.path.join(self.args.out, "picture.####.exr"), [], []
        for seed in (1001, 1002):
            done = runs.render(self.args.binary, scene, pattern, size, self.setting, spp, seed, frames, more=self.args.options)
            seen.append(pictures.load(pattern, done))
            cpu.append(done["cpu"])
        say("%s, %d samples: %.1f CPU s" % (self.setting, spp, np.mean(cpu)))
        below = pictures.denominators(np.mean(seen, axis=0)) if below is None else below
        self.errors[k] = spp, pictures.error_of_pairs(np.stack(seen), below)["relmse"], np.mean(cpu)
        return below

    def line(self, load=None):
        """CPU seconds of a sample, beside those of starting and loading, which are those of the other way if they are known."""
        spp, _, cpu = map(np.array, zip(*self.errors.values()))
        if load is None:
            load = max(np.polyfit(spp, cpu, 1, w=1 / cpu)[1], 0.0) if max(spp) > 2 * min(spp) else 0.0
        self.each = np.mean((cpu - load) / spp)
        return load

    def error(self, k, spp):
        return self.errors[k][1] * (spp / self.errors[k][0]) ** self.slope

    def seconds(self, k, spp):
        return self.errors[k][2] + self.each * (spp - self.errors[k][0])

    def needed(self, k, error):
        return self.errors[k][0] * (self.errors[k][1] / error) ** (-1 / self.slope)

    def told(self, row, said):
        return said["relmse_of_one_sample"][self.way] * row["spp"] ** said[SLOPES[self.way]]


def measure(args, name, scene, size, frames, setting, wanted, said, table, close, say):
    """Adds a row for each error and way, and counts what is close."""
    ways, below, seeds = [Truth(args, said, way, how) for way, how in enumerate((runs.PLAIN, setting))], None, len(said)
    for k, _ in sorted(enumerate(wanted), key=lambda pair: pair[1]):
        for truth in reversed(ways):  # with reuse, the least error first: the most accurate pictures
            below = truth.render(k, scene, size, frames, below, say)
    ways[1].line(ways[0].line())
    for k, error in enumerate(wanted):
        plain, reuse = (truth.each * truth.needed(k, error) for truth in ways)
        gains = [s["wanted"][k] for s in said]
        holds = sum(g["speedup_low"] <= plain / reuse <= g["speedup_high"] for g in gains)
        close.update({"speed-ups": sum(abs(g["speedup"] * reuse / plain - 1) <= 0.3 for g in gains), "all speed-ups": seeds, "intervals": holds, "all intervals": seeds})
        for truth in ways:
            rows = truth.rows(k)
            took, came = ([of(k, row["spp"]) for row in rows] for of in (truth.seconds, truth.error))
            told = [truth.told(row, s) for row, s in zip(rows, said)]
            spp = max(math.ceil(truth.needed(k, error) / truth.eyes - 0.02) * truth.eyes, 2)  # whole passes of all groups
            needed = truth.seconds(k, spp)
            held = sum(row["frame_seconds_low"] <= row["frame_seconds"] * needed / row["seconds"] <= row["frame_seconds_high"] for row in rows)
            close.update({"seconds": sum(abs(row["seconds"] / t - 1) <= 0.25 for row, t in zip(rows, took)), "all seconds": seeds, "intervals": held, "all intervals": seeds,
                          "errors": sum(abs(t / c - 1) <= 0.25 for t, c in zip(told, came)), "all errors": seeds})
            table.add("%s %s %g" % (name, truth.setting, error), spp, np.mean([row["spp"] for row in rows]), np.mean(took), np.mean([row["seconds"] for row in rows]), np.mean(came),
                      np.mean(told), plain / reuse if truth.way else None, np.mean([g["speedup"] for g in gains]) if truth.way else None,
                      "%d of %d" % (held, seeds), "%d of %d" % (holds, seeds) if truth.way else "–", "%d of %d" % (sum(row["extrapolated_from"] is not None for row in rows), seeds))


COLUMNS = ["scene, group:tile, relMSE", "samples", "predicted", "CPU s", "predicted", "relMSE", "predicted", "faster", "predicted", "seconds held", "faster held", "extrapolated"]
TEXT = ("`cost --budget %d`, %d seeds, frames %s of %s. *Samples* that the relMSE takes; CPU seconds of all frames and relMSE with the samples predicted; how many times *faster* reuse is "
        "than path tracing (0:1) at equal relMSE; in how many seeds the intervals hold them, and in how many the samples are over four times those tried. ")


def verdict(close):
    return "Seconds within 25 %%: %.0f %%; errors: %.0f %%; speed-ups within 30 %%: %.0f %%; intervals that hold: %.0f %%." % tuple(
        100 * close[what] / max(close["all " + what], 1) for what in ("seconds", "errors", "speed-ups", "intervals"))

