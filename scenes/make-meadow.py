#!/usr/bin/env python3
"""Writes a meadow with very many trees as a .glb: one tree in memory, of which all others are instances.

Trees of 20,000 triangles, most of them leaves that a texture cuts out, under a sun and a sky. Uses only Python's standard
library; the same arguments give the same bytes.

  make-meadow.py OUT.glb [--trees N] [--triangles T] [--nodes] [--frames F]

There are N trees (10,000) of about T triangles (20,000), by EXT_mesh_gpu_instancing, or with --nodes as a node each.
"""

import argparse
import math
import random

import glb
from glb import lambert, material
from pictures import png
from shapes import Mesh, make_lathe, make_quad, normalize

STEP = 5.0  # m between trees
TRUNK = ((0.0, 0.0), (0.34, 0.0), (0.22, 0.4), (0.18, 1.6), (0.12, 3.0), (0.05, 4.6), (0.0, 5.2))


def whole(text):
    count = int(text) if text.isdecimal() else 0
    if not 1 <= count <= 10000000:
        raise argparse.ArgumentTypeError("wants a whole number from 1 to 10000000, got '%s'" % text)
    return count


def leaf(x, y):
    """A pointed leaf with a rib; alpha is 0 around it."""
    u, v = (x - 31.5) / 32.0, (y - 31.5) / 32.0
    inside = abs(u) < 0.75 * (1.0 - v * v)
    rib = abs(u) < 0.05
    return (0.3, 0.5, 0.15, 1.0) if inside and rib else (0.16, 0.36, 0.08, 1.0 if inside else 0.0)


def make_crown(leaves, chance):
    """Two triangles for each leaf, in a ball that is denser outside."""
    mesh = Mesh()
    for _ in range(leaves):
        z, turn = chance.uniform(-1.0, 1.0), chance.uniform(0.0, 2.0 * math.pi)
        reach = 1.7 * chance.uniform(0.25, 1.0) ** 0.4
        across = math.sqrt(1.0 - z * z)
        out = (across * math.cos(turn), z, across * math.sin(turn))
        middle = tuple(reach * o + m for o, m in zip(out, (0.0, 4.2, 0.0)))
        along = normalize(tuple(o + chance.uniform(-0.7, 0.7) for o in out))
        side = normalize((along[2] + chance.uniform(-0.4, 0.4), chance.uniform(-0.4, 0.4), -along[0] + 0.01))
        size = chance.uniform(0.1, 0.17)
        corner = tuple(m - size * (a + s) for m, a, s in zip(middle, along, side))
        mesh.quad(corner, tuple(2.0 * size * s for s in side), tuple(2.0 * size * a for a in along))
    return mesh


def add_tree(gltf, triangles, chance):
    """A mesh of two primitives: trunk and leaves."""
    columns = max(4, int(math.sqrt(0.1 * triangles)))
    trunk = make_lathe(TRUNK, columns, max(3, triangles // (20 * columns)))
    crown = make_crown(max(1, (triangles - len(trunk.indices) // 3) // 2), chance)
    leaves = material("leaves", [1.0, 1.0, 1.0], roughness=0.5)
    leaves["pbrMetallicRoughness"]["baseColorTexture"] = {"index": gltf.texture("leaf", png(64, 64, leaf), repeat=False)}
    leaves["alphaMode"] = "MASK"
    number = gltf.add_mesh("tree", trunk, lambert("bark", [0.2, 0.13, 0.08]))
    gltf.add_mesh("crown", crown, leaves)
    gltf.json["meshes"][number]["primitives"] += gltf.json["meshes"].pop()["primitives"]
    return number


def add_trees(gltf, arguments, chance):
    tree = add_tree(gltf, arguments.triangles, chance)
    side = math.ceil(math.sqrt(arguments.trees))
    places = []
    for i in range(arguments.trees):
        row, column = divmod(i, side)
        angle, size = chance.uniform(0.0, math.pi), chance.uniform(0.7, 1.3)
        places.append(((STEP * (column - 0.5 * side + chance.uniform(-0.3, 0.3)), 0.0, -STEP * (row + chance.uniform(-0.3, 0.3))),
                       (0.0, math.sin(angle), 0.0, math.cos(angle)), (size, size * chance.uniform(0.8, 1.2), size)))
    if arguments.nodes:
        for place, turn, size in places:
            gltf.node({"mesh": tree, "translation": list(place), "rotation": list(turn), "scale": list(size)})
    else:
        attributes = {"TRANSLATION": gltf.accessor([p[0] for p in places], "VEC3"),
                      "ROTATION": gltf.accessor([p[1] for p in places], "VEC4"),
                      "SCALE": gltf.accessor([p[2] for p in places], "VEC3")}
        gltf.extensions.append("EXT_mesh_gpu_instancing")
        gltf.node({"name": "trees", "mesh": tree, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}})
    return STEP * side


def main():
    parser = glb.make_parser("Writes a meadow with very many trees.")
    parser.add_argument("--trees", type=whole, metavar="N", default=10000, help="(10000)")
    parser.add_argument("--triangles", type=whole, metavar="T", default=20000, help="of the tree, about (20000)")
    parser.add_argument("--nodes", action="store_true", help="a node for each tree in place of EXT_mesh_gpu_instancing")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-meadow.py", "meadow")
    side = add_trees(gltf, arguments, random.Random(2))
    gltf.mesh("ground", make_quad((-2.0 * side, 0.0, side), (4.0 * side, 0.0, 0.0), (0.0, 0.0, -4.0 * side)),
              lambert("grass", [0.16, 0.24, 0.07]))
    gltf.light("sun", {"type": "directional", "intensity": 3.0, "color": [1.0, 0.9, 0.75]}, (0.4, 0.6, 0.5), (0.0, 0.0, 0.0))
    gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"radiance": [0.35, 0.5, 0.8]}}}
    eyes, targets = ((-2.0, 5.0, 9.0), (2.0, 7.0, 5.0)), ((0.0, 3.5, -8.0), (0.0, 3.0, -12.0))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(45.0))
    glb.save("make-meadow.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
