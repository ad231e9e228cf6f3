"""Pixels for the benchmark scripts: EXR files as `render --float --compression none` writes them, read and written
without further packages. A picture is (width, height, [red, green, blue]), each channel an array of floats by rows."""
import array
import struct
import sys

from benchlib import fail

MAGIC = 20000630
FLOAT = 2


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
            fail("%s: channel %s is not of 32-bit floats" % (path, name))
        names.append(name)
        at += 16
    return names


def attributes(path):
    with open(path, "rb") as file:
        return header(file.read())[0]


def read(path, wanted="RGB"):
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<ii", data)
    if magic != MAGIC or version & ~0xff & ~0x400:
        fail("%s: not a flat EXR file of one part by lines" % path)
    found, at = header(data)
    if found["compression"] != b"\0":
        fail("%s: is compressed" % path)
    left, top, right, bottom = struct.unpack("<4i", found["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    names = channel_names(found["channels"], path)
    line, first = 4 * width, at + 8 * height
    channels = []
    for name in wanted:
        values = array.array("f")
        for y in range(height):
            start = first + y * (8 + len(names) * line) + 8 + names.index(name) * line
            values.frombytes(data[start:start + line])
        if sys.byteorder == "big":
            values.byteswap()
        channels.append(values)
    return width, height, channels


def attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def write(path, picture):
    width, height, channels = picture
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listed = b"".join(name + b"\0" + struct.pack("<iiii", FLOAT, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    head = struct.pack("<ii", MAGIC, 2) + b"".join([
        attribute("channels", "chlist", listed), attribute("compression", "compression", b"\0"), attribute("dataWindow", "box2i", box),
        attribute("displayWindow", "box2i", box), attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)), attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    line = 8 + 12 * width
    with open(path, "wb") as file:
        file.write(head + struct.pack("<%dQ" % height, *(len(head) + 8 * height + line * y for y in range(height))))
        for y in range(height):
            file.write(struct.pack("<ii", y, 12 * width))
            for channel in reversed(channels):
                file.write(struct.pack("<%df" % width, *channel[y * width:(y + 1) * width]))


def mean(pictures):
    width, height, _ = pictures[0]
    return width, height, [array.array("f", (sum(values) / len(pictures) for values in zip(*(p[2][c] for p in pictures)))) for c in range(3)]


def neighbours(items):
    """Each item with those before and after it; at the ends the item itself stands for what is missing."""
    return zip([items[0]] + items[:-1], items, items[1:] + [items[-1]])


def blur(values, width):
    """The mean over 3x3 pixels."""
    rows = [list(values[at:at + width]) for at in range(0, len(values), width)]
    across = [[a + b + c for a, b, c in neighbours(row)] for row in rows]
    return [(a + b + c) / 9 for three in neighbours(across) for a, b, c in zip(*three)]


def enlarge(picture, times):
    """Every pixel as a square."""
    width, height, channels = picture
    large = []
    for channel in channels:
        rows = [[v for v in channel[y * width:(y + 1) * width] for _ in range(times)] for y in range(height)]
        large.append([v for row in rows for _ in range(times) for v in row])
    return width * times, height * times, large
