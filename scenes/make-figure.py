#!/usr/bin/env python3
"""Writes a figure that moves as a .glb, without camera and lights, for scene files to place in a room.

A trunk of 50,000 triangles, 2 m high, on a skin of 20 joints, whose animation "Wave" of 2 seconds bends it to
both sides. Uses only Python's standard library; the same arguments give the same bytes.

  make-figure.py OUT.glb [--rings R] [--columns C]
"""

import argparse
import math

import glb
from glb import lambert
from shapes import Mesh

HEIGHT, RADIUS, JOINTS = 2.0, 0.3, 20
BEND = math.radians(7.0)  # of a joint


def make_trunk(rings, columns):
    """The mesh, and for each vertex the joint below it and what it has of the one above."""
    mesh, held = Mesh(), []
    for ring in range(rings + 1):
        at = ring / rings * (JOINTS - 1)
        low = min(int(at), JOINTS - 2)
        for column in range(columns + 1):
            turn = 2.0 * math.pi * column / columns
            way = (math.cos(turn), 0.0, math.sin(turn))
            mesh.vertex((RADIUS * way[0], HEIGHT * ring / rings, RADIUS * way[2]), way, (column / columns, ring / rings))
            held.append((low, at - low))
    for ring in range(rings):
        for column in range(columns):
            a = ring * (columns + 1) + column
            b = a + columns + 1
            mesh.indices += [a, b, a + 1, a + 1, b, b + 1]
    return mesh, held


def main():
    parser = argparse.ArgumentParser(description="Writes a figure that moves, for scene files to place in a room.")
    parser.add_argument("out", metavar="OUT.glb")
    parser.add_argument("--rings", type=glb.frame_count, default=250, metavar="R", help="rows of its triangles (250)")
    parser.add_argument("--columns", type=glb.frame_count, default=100, metavar="C", help="columns of them (100)")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-figure.py", "figure")
    mesh, held = make_trunk(arguments.rings, arguments.columns)
    number = gltf.add_mesh("figure", mesh, lambert("figure", [0.6, 0.4, 0.3]))
    attributes = gltf.json["meshes"][number]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = gltf.accessor([(low, low + 1, 0, 0) for low, _ in held], "VEC4", 5123)
    attributes["WEIGHTS_0"] = gltf.accessor([(1.0 - part, part, 0.0, 0.0) for _, part in held], "VEC4")
    gltf.node({"name": "figure", "mesh": number, "skin": 0})
    step, joints = HEIGHT / (JOINTS - 1), []
    for joint in range(JOINTS):
        joints.append(gltf.node({"name": "joint %d" % (joint + 1), "translation": [0.0, step if joint > 0 else 0.0, 0.0]},
                                joints[-1] if joints else None))
    binds = [(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -step * joint, 0.0, 1.0) for joint in range(JOINTS)]
    gltf.json["skins"] = [{"joints": joints, "inverseBindMatrices": gltf.accessor(binds, "MAT4")}]
    times = gltf.accessor([(0.0,), (1.0,), (2.0,)], "SCALAR", bounds=True)
    turns = gltf.accessor([(0.0, 0.0, math.sin(0.5 * a), math.cos(0.5 * a)) for a in (BEND, -BEND, BEND)], "VEC4")
    gltf.json["animations"].append({"name": "Wave", "samplers": [{"input": times, "output": turns, "interpolation": "LINEAR"}],
                                    "channels": [{"sampler": 0, "target": {"node": joint, "path": "rotation"}} for joint in joints]})
    glb.save("make-figure.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
