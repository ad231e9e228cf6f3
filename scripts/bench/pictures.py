"""Pictures as numpy arrays for the scripts that measure, the errors in them, and which material each pixel shows.

Pictures are frames, rows, columns and channels of 64-bit floats; EXR files are those of `render --float --compression none`.
"""
import os
import struct
import sys
import zlib

import runs

try:
    import numpy as np
except ImportError:
    if sys.executable != "/usr/bin/python3" and os.path.exists("/usr/bin/python3"):  # Debian's has it if another is first in the path
        os.execv("/usr/bin/python3", ["/usr/bin/python3", "-B", *sys.argv])
    runs.fail("%s has no numpy: install python3-numpy" % sys.executable)

MAGIC, FLOAT = 20000630, 2
FLOOR = 1e-3
WORST = 0.001  # of the pixels, left out of trimmed means
STEPS = 4096  # more materials than that are not distinguished


def text_until_zero(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def header(data):
    """Attributes as bytes, and where the table of lines begins."""
    at, attributes = 8, {}
    while data[at] != 0:
        name, at = text_until_zero(data, at)
        _, at = text_until_zero(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def channel_names(attribute, path):
    names, at = [], 0
    while attribute[at] != 0:
        name, at = text_until_zero(attribute, at)
        if struct.unpack_from("<i", attribute, at)[0] != FLOAT:
            runs.fail("%s: channel %s is not of 32-bit floats" % (path, name))
        names.append(name)
        at += 16
    return names


def read(path, wanted="RGB"):
    """Rows, columns, wanted channels."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<ii", data)
    if magic != MAGIC or version & ~0xff & ~0x400:
        runs.fail("%s: not a flat EXR file of one part by lines" % path)
    found, at = header(data)
    if found["compression"] != b"\0":
        runs.fail("%s: is compressed" % path)
    left, top, right, bottom = struct.unpack("<4i", found["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    names = channel_names(found["channels"], path)
    line = np.dtype([("y", "<i4"), ("size", "<i4"), ("pixels", "<f4", (len(names), width))])
    pixels = np.frombuffer(data, line, height, at + 8 * height)["pixels"]
    return pixels[:, [names.index(name) for name in wanted]].transpose(0, 2, 1).astype(np.float64)


def load(pattern, result, wanted="RGB"):
    """The frames that a render reported."""
    return np.stack([read(runs.frame_of(pattern, f["frame"]), wanted) for f in result["frames"]])


def srgb(picture):
    """Values from 0 to 1 on a display."""
    light = np.clip(picture, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)


def on_display(picture, stops):
    return np.rint(255.0 * srgb(picture * 2.0 ** stops)).astype(np.uint8)


def write_chunks(path, shape, colour, chunks):
    """A PNG of 8 bits from rows and columns, the type of its colours and what follows."""
    head = struct.pack(">2I5B", shape[1], shape[0], 8, colour, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", head), *chunks, (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def compressed(rows):
    return zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows), 9)


def write_png(path, picture, stops=0.0):
    """A picture in sRGB."""
    write_chunks(path, picture.shape, 2, [(b"IDAT", compressed(on_display(picture, stops)))])


def nearest(values, colours):
    """The number of the colour that is nearest to each value; both are rows of RGB."""
    values, colours = values.astype(np.float32), colours.astype(np.float32)
    return np.argmin((colours ** 2).sum(1) - 2.0 * values @ colours.T, axis=1)


def palette(values):
    """256 colours that stand for all values, by Lloyd's algorithm."""
    sample = values[np.argsort(values.sum(1, dtype=int), kind="stable")][::max(len(values) // 32768, 1)].astype(np.float64)
    colours = sample[np.linspace(0, len(sample) - 1, 256).astype(int)]
    for _ in range(12):
        near = nearest(sample, colours)
        count = np.bincount(near, minlength=256)[:, None]
        sums = np.stack([np.bincount(near, sample[:, c], 256) for c in range(3)], axis=1)
        colours = np.where(count > 0, sums / np.maximum(count, 1), colours)
    return np.rint(colours).astype(np.uint8)


def write_film(path, pictures, rate, stops=0.0):
    """Frames as an animated PNG of 256 colours."""
    shown = on_display(pictures, stops)
    colours = palette(shown.reshape(-1, 3))
    size = struct.pack(">2I", pictures.shape[2], pictures.shape[1])
    chunks, number = [(b"acTL", struct.pack(">2I", len(shown), 0)), (b"PLTE", colours.tobytes())], 0
    for frame in shown:
        chunks.append((b"fcTL", struct.pack(">I", number) + size + struct.pack(">2I2H2B", 0, 0, 1, rate, 0, 0)))
        data = compressed(nearest(frame.reshape(-1, 3), colours).astype(np.uint8).reshape(frame.shape[:2]))
        chunks.append((b"IDAT", data) if number == 0 else (b"fdAT", struct.pack(">I", number + 1) + data))
        number += 1 if number == 0 else 2
    write_chunks(path, pictures.shape[1:], 3, chunks)


def blur(grey):
    """The mean over 3x3 pixels; rows and columns are the last axes."""
    wide = np.pad(grey, [(0, 0)] * (grey.ndim - 2) + [(1, 1), (1, 1)], mode="edge")
    rows, columns = grey.shape[-2:]
    return sum(wide[..., y:y + rows, x:x + columns] for y in range(3) for x in range(3)) / 9


def windows(grey, side):
    """The pixels around each one of a frame, side x side; beyond the border the nearest."""
    wide, (rows, columns) = np.pad(grey, side // 2, mode="edge"), grey.shape
    return np.stack([wide[y:y + rows, x:x + columns] for y in range(side) for x in range(side)])


def denominators(pictures):
    """What squared errors are divided by, as in src/film/brightness.h: the squared brightness, the median over 3x3 pixels and of
    that the mean over 5x5, and 0.001."""
    grey = pictures.mean(-1)
    frames = grey.reshape(-1, *grey.shape[-2:])
    return np.stack([windows(np.median(windows(f, 3), axis=0), 5).mean(0) ** 2 + FLOOR for f in frames]).reshape(grey.shape)


def own_denominators(pictures):
    """The same of each pixel alone, which spares fireflies that the pictures hold themselves: where efficiencies by both differ, few
    pixels decide."""
    return pictures.mean(-1) ** 2 + FLOOR


def most_accurate(seen):
    """Of pictures by several ways, each with at least two seeds, the mean over the seeds of those that differ least from seed to
    seed, in the pixel in the middle: what errors without a reference are divided by."""
    return np.mean(min(seen, key=lambda made: np.median(squares(made[0].astype(np.float64) - made[1]))), axis=0, dtype=np.float64)


def squares(error):
    return (error ** 2).sum(-1)


def trimmed(values):
    """The mean without the 0.1 % of the pixels with the largest error, which few seeds catch by chance."""
    kept = max(int(values.size * (1.0 - WORST)), 1)
    return np.partition(values.ravel(), kept - 1)[:kept].mean()


def worst_share(values):
    """What the 0.1 % of the pixels with the largest error hold of it."""
    return 1.0 - trimmed(values) * max(int(values.size * (1.0 - WORST)), 1) / values.sum()


def changes(error):
    """Squared changes of the error from frame to frame, and the squared errors of both frames."""
    before, after = error[:-1], error[1:]
    return np.array([((after - before) ** 2).sum(), (before ** 2 + after ** 2).sum()])


def relative_f1_squared(error, below):
    """As in src/measure/flicker.h, in place: squared changes over the mean of what both frames' errors are divided by, a channel."""
    if len(error) < 2:
        return np.nan
    return (squares(error[1:] - error[:-1]) / ((below[1:] + below[:-1]) / 2)).mean() / 3


def error_of_pairs(pictures, below, own=None):
    """Errors without a reference: half the squared difference of the pictures of two seeds is the squared error in the mean.
    pictures: seeds, of which each two are a pair, then frames as above. own: own_denominators, for heavy_tails."""
    pairs = [(a - b) * 0.5 ** 0.5 for a, b in zip(pictures[::2], pictures[1::2])]
    relative = np.mean([squares(error) / below for error in pairs], axis=0)
    change, both = sum(changes(error) for error in pairs) / len(pairs)
    other = {} if own is None else {"relmse_own": np.mean([squares(error) / own for error in pairs])}
    return {**other, "relative": relative, "relmse": relative.mean(), "trimmed": trimmed(relative), "median": np.median(relative),
            "f1_squared": np.mean([relative_f1_squared(error, below) for error in pairs]), "phi": change / both if both > 0.0 else np.nan}


def error_beside(pictures, reference, below, own):
    """Errors against a reference, whose own error is subtracted: of all pixels of a region, and without the worst."""
    relative = np.mean([squares(picture - reference) / below for picture in pictures], axis=0)
    return relative.mean() - own.mean(), trimmed(relative)


def gain(base, mine, key="relmse"):
    """Efficiency 1 / (error * CPU seconds) over that of the base."""
    above, under = base[key] * base["cpu"], mine[key] * mine["cpu"]
    return above / under if above > 0.0 and under > 0.0 else np.nan


def heavy_tails(base, mine, key="relmse"):
    """What a row says where efficiencies by two denominators differ by more than a third."""
    by = [gain(base, mine, key), gain(base, mine, key + "_own")]
    return ", heavy tails" if max(by) > 4 / 3 * min(by) else ""


def describe(material):
    """Name and what decides how it reflects; textures and the JSON of a scene file may say otherwise."""
    base, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
    rough = base.get("roughnessFactor", 1.0)
    if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0) > 0.0:
        kind = "glass" if "KHR_materials_volume" in extensions else "pane"
    elif base.get("metallicFactor", 1.0) >= 0.5:
        kind = "metal"
    elif extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0) == 0.0:
        return "%s (matte)" % material.get("name", "?")
    else:
        kind = "dielectric"
    return "%s (%s %.2g)" % (material.get("name", "?"), kind, rough)


def is_specular(material):
    """Glass and mirrors, which light paths go on from."""
    base, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
    glass = extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0) > 0.0
    mirror = base.get("metallicFactor", 1.0) >= 0.5 and base.get("roughnessFactor", 1.0) < 0.04
    return glass or mirror or material.get("extras", {}).get("reframe", {}).get("bsdf") in ("glass", "mirror")


def number(gltf):
    """Replaces every material by one that emits its number; returns what the numbers stand for."""
    materials = gltf.setdefault("materials", [])
    names = [describe(m) for m in materials] + ["no material"]
    for mesh in gltf.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive.setdefault("material", len(materials))
            primitive.get("extensions", {}).pop("KHR_materials_variants", None)
    alpha = [{key: m[key] for key in ("alphaMode", "alphaCutoff") if key in m} for m in materials] + [{}]
    base = [m.get("pbrMetallicRoughness", {}) for m in materials] + [{}]
    gltf["materials"] = [dict(a, pbrMetallicRoughness=b, doubleSided=True, emissiveFactor=[(i + 1) / STEPS, 1, 0])
                         for i, (a, b) in enumerate(zip(alpha, base))]
    for scene in gltf.get("scenes", []):
        scene.pop("extras", None)
    return names


def materials_seen(binary, scene, folder, size, frames):
    """The names of the materials of a .glb, and for each pixel the number of that which the camera sees first: -1 is none."""
    gltf, rest = runs.read_glb(scene)
    names = number(gltf)
    made, pattern = os.path.join(folder, "numbered.glb"), os.path.join(folder, "materials.####.exr")
    runs.write_glb(made, gltf, rest)
    done = runs.render(binary, made, pattern, size, runs.PLAIN, 1, 1, frames, 0, ["--max-depth", "1", "--filter", "box"])
    red, green = np.moveaxis(load(pattern, done, "RG"), -1, 0)
    return names, np.where(green > 0.0, np.rint(STEPS * red / np.maximum(green, 1e-9)).astype(int) - 1, -1)
