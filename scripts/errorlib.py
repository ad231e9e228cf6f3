"""Sums over the errors of rendered paths, for the benchmark scripts. An error is three channels of differences, whose
expected squares are the squared errors; there may be several that are independent."""
import math
import statistics

WORST = 0.001  # of the pixels, left out of the trimmed mean


def difference(a, b, factor):
    return [[factor * (x - y) for x, y in zip(p, q)] for p, q in zip(a[2], b[2])]


def squares(errors):
    """Over the channels, and in the mean over independent errors."""
    return [sum(pixel) / len(errors) for pixel in zip(*([r * r + g * g + b * b for r, g, b in zip(*e)] for e in errors))]


def changes(before, after):
    """Squared changes from frame to frame, and the squared errors of both frames."""
    change = both = 0.0
    for one, other in zip(before, after):
        for a, b in zip(one, other):
            change += sum((y - x) * (y - x) for x, y in zip(a, b))
            both += sum(x * x + y * y for x, y in zip(a, b))
    return change / len(before), both / len(before)


def follow(frames, errors_of, below):
    """Relative squared errors by frame, and the sums of changes() over neighbouring frames."""
    relative, change, both, before = {}, 0.0, 0.0, None
    for frame in frames:
        errors = errors_of(frame)
        relative[frame] = [e / b for e, b in zip(squares(errors), below[frame])]
        if before:
            step = changes(before, errors)
            change, both = change + step[0], both + step[1]
        before = errors
    return {"relative": relative, "change": change, "both": both}


def summary(measured, own):
    """relMSE in the mean, without the worst pixels, and of the pixel in the middle; F1 squared; phi. The reference's own
    error is subtracted where it adds up: not from the trimmed mean and the median."""
    values = sorted(v for frame in measured["relative"].values() for v in frame)
    change, both = measured["change"], measured["both"]
    taken = 0.0
    if own:
        taken = statistics.fmean(v for frame in own["relative"].values() for v in frame)
        change, both = change - own["change"], both - own["both"]
    return {"relmse": statistics.fmean(values) - taken, "trimmed": statistics.fmean(values[:max(int(len(values) * (1 - WORST)), 1)]),
            "median": statistics.median(values), "f1_squared": change, "phi": change / both if both > 0.0 else None}


def ratio(over, under):
    return over / under if over > 0.0 and under > 0.0 else None


def make_rows(measured, own, cpu, samples):
    """A row for each setting, with its gains over the first."""
    rows = [dict(summary(measured[s], own), setting=s, cpu=cpu[s], samples=samples[s]) for s in measured]
    first = rows[0]
    for r in rows:
        for key, of in (("gain", "relmse"), ("gain_trimmed", "trimmed"), ("gain_median", "median")):
            r[key] = ratio(first[of] * first["cpu"], r[of] * r["cpu"])
        f1 = ratio(first["f1_squared"] * first["cpu"], r["f1_squared"] * r["cpu"])
        r["f1_below"] = math.sqrt(f1) if f1 else None
    return rows


def sum_over(relative, where):
    return sum(relative[frame][at] for frame, pixels in where.items() for at in pixels)


def merge_small(found, measured, least, frames):
    """Puts regions together that have less than `least` of the pixels and of each setting's error."""
    total = sum(len(pixels) for where in found.values() for pixels in where.values())
    sums = {s: sum(map(sum, m["relative"].values())) for s, m in measured.items()}
    kept, rest = {}, {frame: [] for frame in frames}
    for name, where in found.items():
        shares = [sum_over(m["relative"], where) / max(sums[s], 1e-300) for s, m in measured.items()]
        if max(shares + [sum(map(len, where.values())) / total]) >= least:
            kept[name] = where
        else:
            for frame, pixels in where.items():
                rest[frame] += pixels
    return dict(kept, **{"all others": rest}) if any(rest.values()) else kept


def region_rows(found, measured, own, rows):
    """For each region its share of the pixels, and by setting: share of the error, relMSE, gain at equal CPU time."""
    first, result = rows[0], []
    everywhere = {frame: range(len(values)) for frame, values in measured[first["setting"]]["relative"].items()}
    all_pixels = sum(map(len, everywhere.values()))

    def error(setting, where):
        return sum_over(measured[setting]["relative"], where) - (sum_over(own["relative"], where) if own else 0.0)

    for name, where in found.items():
        pixels = sum(map(len, where.values()))
        made = {"region": name, "pixels": pixels / all_pixels, "settings": []}
        for row in rows:
            mine, base = error(row["setting"], where), error(first["setting"], where)
            made["settings"].append({"setting": row["setting"], "share": mine / error(row["setting"], everywhere), "relmse": mine / pixels if pixels else math.nan,
                                     "gain": base * first["cpu"] / (mine * row["cpu"]) if mine > 0.0 else math.nan})
        result.append(made)
    return result
