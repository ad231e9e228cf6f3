"""Writes PNG and Radiance HDR images for the scene scripts of this folder."""

import math
import struct
import zlib


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, pixel):
    """The bytes of an 8-bit PNG; pixel(x, y) returns 3 or 4 encoded values in [0, 1]."""
    channels = len(pixel(0, 0))
    rows = bytearray()
    for y in range(height):
        rows.append(0)  # no filter
        for x in range(width):
            rows.extend(min(max(int(255.0 * v + 0.5), 0), 255) for v in pixel(x, y))
    header = struct.pack(">IIBBBBB", width, height, 8, 6 if channels == 4 else 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) +
            chunk(b"IEND", b""))


def normal_map(width, height, bump):
    """The bytes of a tileable normal map from heights bump(x, y) in pixels. Green is up."""
    def pixel(x, y):
        dx = 0.5 * (bump((x + 1) % width, y) - bump((x - 1) % width, y))
        dy = 0.5 * (bump(x, (y + 1) % height) - bump(x, (y - 1) % height))
        scale = 1.0 / math.sqrt(dx * dx + dy * dy + 1.0)
        return 0.5 - 0.5 * dx * scale, 0.5 + 0.5 * dy * scale, 0.5 + 0.5 * scale

    return png(width, height, pixel)


def rgbe(color):
    largest = max(color)
    if largest < 1e-32:
        return b"\0\0\0\0"
    fraction, exponent = math.frexp(largest)
    scale = fraction * 256.0 / largest
    return bytes([min(int(v * scale), 255) for v in color] + [exponent + 128])


def write_hdr(file_name, width, height, pixel):
    """Writes a Radiance HDR image with uncompressed scanlines; pixel(x, y) returns linear RGB."""
    with open(file_name, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        for y in range(height):
            file.write(b"".join(rgbe(pixel(x, y)) for x in range(width)))
