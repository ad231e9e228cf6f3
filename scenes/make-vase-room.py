#!/usr/bin/env python3
"""Writes the room with a glossy vase and a zooming camera as a .glb.

Modelled after the test scene of Mendez Feliu, Sbert and Szirmay-Kalos, Reusing Frames
in Camera Animation (WSCG 2006). A closed room of 6 x 3 x 5 m (x, y, z; y up,
the camera looks along -z) with one panel light, a table, a Phong vase, a brushed
metal ball and a coated blue box. Uses only Python's standard library; the same
arguments give the same bytes.

  make-vase-room.py OUT.glb [--frames N] [--variant lambert|phong|ggx] [--wide]

The camera's path is anim/vase-zoom.json, of which N frames (48) are taken,
evenly from its beginning to its end. --variant gives vase, ball and box the
same kind of material; --wide leads the camera around the vase in steps of 25
degrees, so that neighbours of a group see the highlights at other places.
"""

import json
import math
import os

import glb
from glb import lambert, material
from shapes import add, make_box, make_lathe, make_quad, make_sphere, mix

VASE = (0.0, 0.75, -1.3)  # its position on the table
WIDE_STEP = math.radians(25.0)
WIDE_RADIUS = 1.05


# Radius and height of the vase along its wall: from the middle of the foot over
# belly, neck and lip to the inside, back down to the middle of its bottom.
VASE_PROFILE = (
    (0.0, 0.0), (0.07, 0.001), (0.108, 0.025), (0.155, 0.1), (0.185, 0.19), (0.165, 0.28), (0.1, 0.36),
    (0.066, 0.42), (0.076, 0.475), (0.104, 0.508), (0.104, 0.522), (0.09, 0.517), (0.066, 0.478), (0.054, 0.42),
    (0.088, 0.355), (0.152, 0.277), (0.172, 0.19), (0.143, 0.105), (0.09, 0.032), (0.0, 0.018),
)


def phong(name, diffuse, lobe, exponent):
    # For other renderers: the roughness whose GGX lobe is about as wide.
    roughness = round(math.sqrt(math.sqrt(2.0 / (exponent + 2.0))), 3)
    return material(name, diffuse, roughness=roughness, phong=(diffuse, lobe, exponent))


def object_materials(variant):
    """Materials of vase, ball and box: their own, or all of one kind."""
    kinds = {
        "lambert": (lambert("vase", [0.5, 0.16, 0.12]), lambert("ball", [0.75, 0.45, 0.3]),
                    lambert("box", [0.08, 0.16, 0.5])),
        "phong": (phong("vase", [0.25, 0.08, 0.06], [0.55, 0.55, 0.55], 60),
                  phong("ball", [0.1, 0.05, 0.03], [0.75, 0.5, 0.35], 20),
                  phong("box", [0.05, 0.1, 0.4], [0.3, 0.3, 0.3], 40)),
        "ggx": (material("vase", [0.3, 0.09, 0.07], roughness=0.3),
                material("ball", [0.95, 0.64, 0.54], metallic=1.0, roughness=0.3),
                material("box", [0.06, 0.14, 0.5], roughness=0.25)),
    }
    if variant is not None:
        return kinds[variant]
    return kinds["phong"][0], kinds["ggx"][1], kinds["ggx"][2]


def make_room():
    """(name, mesh, material) of quads that face into the room."""
    x, y, z = (6.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 5.0)
    minus_x, minus_z = (-6.0, 0.0, 0.0), (0.0, 0.0, -5.0)
    return [
        ("floor", make_quad((-3.0, 0.0, 2.5), x, minus_z), lambert("floor", [0.45, 0.3, 0.18])),
        ("ceiling", make_quad((-3.0, 3.0, -2.5), x, z), lambert("ceiling", [0.7, 0.7, 0.7])),
        ("back wall", make_quad((-3.0, 0.0, -2.5), x, y), lambert("back wall", [0.65, 0.62, 0.56])),
        ("left wall", make_quad((-3.0, 0.0, 2.5), minus_z, y), lambert("left wall", [0.6, 0.2, 0.15])),
        ("right wall", make_quad((3.0, 0.0, -2.5), z, y), lambert("right wall", [0.14, 0.42, 0.4])),
        ("front wall", make_quad((3.0, 0.0, 2.5), minus_x, y), lambert("front wall", [0.5, 0.5, 0.5])),
        ("light", make_quad((-0.3, 2.95, -1.2), (1.2, 0.0, 0.0), (0.0, 0.0, 1.2)),
         material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.93, 0.82], strength=12.0,
                  double_sided=False)),
    ]


def make_objects(variant):
    """(name, mesh, material, positions), one position per instance."""
    vase, ball, box = object_materials(variant)
    wood = lambert("table", [0.36, 0.22, 0.12])
    legs = [(sx * 0.65, 0.0, VASE[2] + sz * 0.36) for sx in (-1, 1) for sz in (-1, 1)]
    return [
        ("table top", make_box((1.4, 0.05, 0.82)), wood, [(0.0, 0.7, VASE[2])]),
        ("table leg", make_box((0.06, 0.7, 0.06)), wood, legs),
        ("vase", make_lathe(VASE_PROFILE, 96, 64), vase, [VASE]),
        ("ball", make_sphere(0.28, 64, 32), ball, [(0.98, 0.28, -0.62)]),
        ("box", make_box((0.2, 0.16, 0.16), math.radians(28.0)), box, [(-0.42, 0.75, -1.16)]),
    ]


def read_path(file_name, frames):
    """Eye and target of each frame, evenly spaced in time, and yfov. Only for paths
    with linear keys and a single target, like vase-zoom.json."""
    with open(file_name, encoding="utf-8") as file:
        path = json.load(file)
    keys = path["keys"]
    start, end = keys[0]["time"], keys[-1]["time"]
    views, k = [], 0
    for frame in range(frames):
        time = start + (end - start) * (frame / (frames - 1) if frames > 1 else 0.0)
        while k + 2 < len(keys) and keys[k + 1]["time"] <= time:
            k += 1
        a, b = keys[k], keys[k + 1]
        t = min((time - a["time"]) / (b["time"] - a["time"]), 1.0)
        views.append((mix(a["position"], b["position"], t), tuple(path["target"])))
    return views, math.radians(path["fov"])


def wide_path(frames):
    target = add(VASE, (0.0, 0.27, 0.0))
    views = []
    for frame in range(frames):
        angle = frame * WIDE_STEP
        views.append((add(target, (WIDE_RADIUS * math.sin(angle), 0.3, WIDE_RADIUS * math.cos(angle))), target))
    return views


def main():
    parser = glb.make_parser("Writes the room with a glossy vase and a zooming camera.")
    parser.add_argument("--variant", choices=("lambert", "phong", "ggx"), help="material of vase, ball and box")
    parser.add_argument("--wide", action="store_true", help="move the camera around the vase in steps of 25 degrees")
    arguments = parser.parse_args()
    here = os.path.dirname(os.path.abspath(__file__))
    views, yfov = read_path(os.path.join(here, os.pardir, "anim", "vase-zoom.json"), arguments.frames)
    if arguments.wide:
        views = wide_path(arguments.frames)
    gltf = glb.Gltf("make-vase-room.py", "vase room")
    for name, mesh, description in make_room():
        gltf.mesh(name, mesh, description)
    for name, mesh, description, places in make_objects(arguments.variant):
        gltf.mesh(name, mesh, description, places)
    gltf.camera(views, yfov)
    glb.save("make-vase-room.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
