#!/usr/bin/env python3
"""Writes a scene of very many nodes and triangles as a .glb, to time loading.

A field of pebbles under one lamp: a node for each pebble and for each row. Uses only
Python's standard library; the same arguments give the same bytes.

  make-many.py OUT.glb [--triangles T] [--nodes N] [--meshes M] [--frames F]

There are N pebbles (50,000) of T / N triangles each (T: 1,000,000), rounded to a
possible number for a ball of rows and columns, in M different shapes (1,000). With
M = N every node has its own mesh.
"""

import argparse
import math
import random

import glb
from glb import lambert, material
from shapes import make_quad, make_sphere


def whole(text):
    count = int(text) if text.isdecimal() else 0
    if not 1 <= count <= 100000000:
        raise argparse.ArgumentTypeError("must be a whole number from 1 to 100000000, got '%s'" % text)
    return count


def ball_size(triangles):
    """Columns and rows of a ball with about the given number of triangles, which is 2 columns (rows - 1)."""
    rows = max(2, round(0.5 + math.sqrt(0.25 * triangles)))
    return max(3, round(triangles / (2.0 * (rows - 1)))), rows


def add_pebbles(gltf, arguments):
    chance = random.Random(1)
    columns, rows = ball_size(arguments.triangles / arguments.nodes)
    stones = [lambert("stone %d" % (i + 1), [0.3 + 0.1 * i, 0.32 + 0.06 * i, 0.35]) for i in range(4)]
    meshes = []
    for i in range(min(arguments.meshes, arguments.nodes)):
        ball = make_sphere(0.4, columns, rows)
        flat, long = chance.uniform(0.4, 0.8), chance.uniform(0.8, 1.2)
        ball.positions = [(x * long, y * flat, z) for x, y, z in ball.positions]
        meshes.append(gltf.add_mesh("pebble %d" % (i + 1), ball, stones[i % len(stones)]))
    side = math.ceil(math.sqrt(arguments.nodes))
    for i in range(arguments.nodes):
        row, column = divmod(i, side)
        if column == 0:
            parent = gltf.node({"name": "row %d" % (row + 1), "translation": [0.0, 0.0, -float(row)]})
        angle = chance.uniform(0.0, math.pi)
        gltf.node({"mesh": meshes[i % len(meshes)], "translation": [column - 0.5 * side, 0.25, chance.uniform(-0.1, 0.1)],
                   "rotation": [0.0, math.sin(angle), 0.0, math.cos(angle)]}, parent)
    return float(side)


def main():
    parser = glb.make_parser("Writes a field of very many pebbles.")
    parser.add_argument("--triangles", type=whole, metavar="T", default=1000000, help="in all (1000000)")
    parser.add_argument("--nodes", type=whole, metavar="N", default=50000, help="pebbles (50000)")
    parser.add_argument("--meshes", type=whole, metavar="M", default=1000, help="different shapes (1000)")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-many.py", "many pebbles")
    side = add_pebbles(gltf, arguments)
    gltf.mesh("ground", make_quad((-side, 0.0, side), (2.0 * side, 0.0, 0.0), (0.0, 0.0, -3.0 * side)),
              lambert("ground", [0.3, 0.25, 0.2]))
    lamp = material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.95, 0.9], strength=10.0, double_sided=False)
    gltf.mesh("light", make_quad((-0.5 * side, side, -side), (side, 0.0, 0.0), (0.0, 0.0, side)), lamp)
    eyes, targets = ((-3.0, 5.0, 9.0), (3.0, 4.0, 6.0)), ((0.0, 0.0, -4.0), (0.0, 0.0, -6.0))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(40.0))
    glb.save("make-many.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
