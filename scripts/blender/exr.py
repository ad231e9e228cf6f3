"""Reads the frames that `reframe render` writes: EXR files of one part with scanlines, uncompressed or by ZIP, since Python inside Blender
has no reader of all their channels.
"""
import struct
import zlib

import numpy

LINES = {0: 1, 2: 1, 3: 16}  # of a block, by compression: NONE, ZIPS, ZIP
KINDS = ("<u4", "<f2", "<f4")


def text_at(data, at):
    """A text that ends with 0, and where the next thing begins."""
    end = data.index(b"\0", at)
    return data[at:end].decode("utf-8", "replace"), end + 1


def header_of(data):
    """The attributes by name, as bytes, and where they end (OpenEXR file layout, "Header")."""
    found, at = {}, 8
    while data[at] != 0:
        name, at = text_at(data, at)
        _, at = text_at(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def channels_of(value):
    """Names and types, in the order of the file."""
    found, at = [], 0
    while value[at] != 0:
        name, at = text_at(value, at)
        found.append((name, KINDS[struct.unpack_from("<i", value, at)[0]]))
        at += 16
    return found


def inflated(block, size):
    """The bytes of a block that ZIP has compressed: differences of neighbours, even ones before odd ones."""
    packed = numpy.frombuffer(zlib.decompress(block), numpy.uint8)
    steps = packed.copy()
    steps[1:] -= 128
    values, out = numpy.cumsum(steps, dtype=numpy.uint8), numpy.empty(size, numpy.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = values[:half], values[half:]
    return out


def read(path):
    """The channels of a frame by name, as float arrays of the whole picture (the display window), the top row first; and its
    attributes, as bytes."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"\x76\x2f\x31\x01" or data[5] & 0x1a:  # tiles, deep pixels, several parts
        raise ValueError("%s: not a frame of one part with scanlines" % path)
    header, at = header_of(data)
    compression = header["compression"][0]
    if compression not in LINES:
        raise ValueError("%s: its compression is not one that is read here: zip or none" % path)
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    x0, y0, x1, y1 = struct.unpack("<4i", header["displayWindow"])
    width, height, channels = right - left + 1, bottom - top + 1, channels_of(header["channels"])
    line = sum(width * numpy.dtype(kind).itemsize for _, kind in channels)
    rows = numpy.zeros((height, line), numpy.uint8)
    for offset in struct.unpack_from("<%dQ" % -(-height // LINES[compression]), data, at):
        y, length = struct.unpack_from("<ii", data, offset)
        count = min(LINES[compression], bottom + 1 - y)
        block = data[offset + 8:offset + 8 + length]
        whole = numpy.frombuffer(block, numpy.uint8) if length == count * line else inflated(block, count * line)
        rows[y - top:y - top + count] = whole.reshape(count, line)
    found, begin = {}, 0
    for name, kind in channels:
        end = begin + width * numpy.dtype(kind).itemsize
        values = numpy.ascontiguousarray(rows[:, begin:end]).view(kind).astype(numpy.float32)
        picture = numpy.zeros((y1 - y0 + 1, x1 - x0 + 1), numpy.float32)
        inner = values[max(y0 - top, 0):y1 + 1 - top, max(x0 - left, 0):x1 + 1 - left]
        picture[max(top - y0, 0):, max(left - x0, 0):][:inner.shape[0], :inner.shape[1]] = inner
        found[name], begin = picture, end
    return found, header
