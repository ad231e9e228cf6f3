"""Copies of .glb scenes with smaller lamps, for the benchmark scripts."""
import struct

import benchlib
import materiallib

FLOAT = 5126  # glTF's number of the type


def emits(material):
    return any(material.get("emissiveFactor", [0.0]))


def shrink(scene, out, factor):
    """Writes a copy in which each primitive that emits is `factor` times as large around the middle of its bounds, with the same power."""
    gltf, rest = materiallib.read_glb(scene)
    data, done = bytearray(rest), set()
    for mesh in gltf["meshes"]:
        for primitive in mesh["primitives"]:
            at = primitive["attributes"]["POSITION"]
            if emits(gltf["materials"][primitive["material"]]) and at not in done:
                shrink_positions(gltf, data, gltf["accessors"][at], factor)
                done.add(at)
    if not done:
        benchlib.fail("%s: nothing emits but lamps without size" % scene)
    for material in filter(emits, gltf["materials"]):
        strength = material.setdefault("extensions", {}).setdefault("KHR_materials_emissive_strength", {"emissiveStrength": 1.0})
        strength["emissiveStrength"] /= factor * factor
    gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "KHR_materials_emissive_strength"})
    materiallib.write_glb(out, gltf, bytes(data))


def shrink_positions(gltf, data, accessor, factor):
    view = gltf["bufferViews"][accessor["bufferView"]]
    if accessor["componentType"] != FLOAT:
        benchlib.fail("a lamp's positions are no floats")
    first = 8 + view.get("byteOffset", 0) + accessor.get("byteOffset", 0)  # after the chunk's header
    middle = [(low + high) / 2 for low, high in zip(accessor["min"], accessor["max"])]
    moved = []
    for i in range(accessor["count"]):
        at = first + i * view.get("byteStride", 12)
        moved.append([m + factor * (x - m) for m, x in zip(middle, struct.unpack_from("<3f", data, at))])
        struct.pack_into("<3f", data, at, *moved[-1])
        moved[-1] = struct.unpack_from("<3f", data, at)
    accessor["min"], accessor["max"] = [[how(axis) for axis in zip(*moved)] for how in (min, max)]
