#!/usr/bin/env python3
"""Writes objects on a turntable under a sky: a .glb, an environment map and a scene file.

A ball of red car paint with a clear coat, a brass vase and a glossy blue block on a
round stand; the camera orbits them once in 48 frames. The light is a generated
environment map: a clear sky with a low sun over bare ground. Uses only Python's
standard library; the same arguments give the same bytes.

  make-turntable.py OUT.glb [--frames N]

writes OUT.glb, OUT-sky.hdr (equirectangular) and OUT.json, which refers to both and
is the file to render.
"""

import json
import math
import os
import sys

import glb
from glb import lambert, material
from pictures import write_hdr
from shapes import Mesh, make_box, make_lathe, make_quad, make_sphere, normalize

SUN = normalize((-0.55, 0.5, 0.45))
SUN_ANGLE = math.radians(2.5)  # radius, with a soft edge; larger than the real sun, so that the map can resolve it
MAP = (512, 256)

VASE_PROFILE = (
    (0.0, 0.0), (0.1, 0.0), (0.13, 0.01), (0.12, 0.03), (0.06, 0.08), (0.05, 0.13), (0.11, 0.24), (0.15, 0.36),
    (0.13, 0.47), (0.075, 0.55), (0.07, 0.6), (0.1, 0.65), (0.104, 0.656), (0.095, 0.655), (0.06, 0.6), (0.064, 0.55),
    (0.118, 0.465), (0.138, 0.36), (0.1, 0.25), (0.0, 0.2),
)


def sky(x, y):
    """Radiance of a pixel of the map, whose top is +y and whose centre is -z."""
    theta = math.pi * (y + 0.5) / MAP[1]
    phi = 2.0 * math.pi * ((x + 0.5) / MAP[0] - 0.5)
    way = (math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi))
    up = way[1]
    if up < 0.0:
        haze = math.exp(20.0 * up)
        return tuple(g + (h - g) * haze for g, h in zip((0.16, 0.13, 0.1), (0.55, 0.52, 0.48)))
    toward = sum(a * b for a, b in zip(way, SUN))
    horizon = (1.0 - up) ** 4
    glow = 0.9 * max(toward, 0.0) ** 24
    color = [z + (h - z) * horizon for z, h in zip((0.13, 0.27, 0.62), (0.8, 0.86, 0.95))]
    color = [v + glow * g for v, g in zip(color, (1.0, 0.85, 0.6))]
    angle = math.acos(min(max(toward, -1.0), 1.0))
    disc = min(max((1.2 * SUN_ANGLE - angle) / (0.4 * SUN_ANGLE), 0.0), 1.0)
    return tuple(v + disc * s for v, s in zip(color, (420.0, 370.0, 290.0)))


def make_stand(radius, height, columns):
    """A round plate with a hard edge: top and side have separate normals."""
    mesh = Mesh()
    ring = [(radius * math.sin(2.0 * math.pi * i / columns), radius * math.cos(2.0 * math.pi * i / columns))
            for i in range(columns)]
    middle = mesh.vertex((0.0, height, 0.0), (0.0, 1.0, 0.0), (0.5, 0.5))
    tops = [mesh.vertex((x, height, z), (0.0, 1.0, 0.0), (0.5 + 0.5 * x / radius, 0.5 + 0.5 * z / radius)) for x, z in ring]
    for i in range(columns):
        mesh.indices.extend((middle, tops[i], tops[(i + 1) % columns]))
    sides = [[mesh.vertex((x, h, z), (x / radius, 0.0, z / radius), (i / columns, 1.0 - h / height))
              for h in (0.0, height)] for i, (x, z) in enumerate(ring)]
    for i in range(columns):
        (a, d), (b, c) = sides[i], sides[(i + 1) % columns]
        mesh.indices.extend((a, b, c, a, c, d))
    return mesh


def orbit(frames):
    """One orbit; the last frame is one step before the first, so that it loops."""
    views = []
    for frame in range(frames):
        angle = 2.0 * math.pi * frame / frames
        views.append(((2.0 * math.sin(angle), 0.95, 2.0 * math.cos(angle)), (0.0, 0.3, 0.0)))
    return views


def add_objects(gltf):
    paint = material("car paint", [0.5, 0.02, 0.02], roughness=0.45)
    paint["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.05}}
    gltf.mesh("ground", make_quad((-30.0, 0.0, 30.0), (60.0, 0.0, 0.0), (0.0, 0.0, -60.0)),
              lambert("ground", [0.3, 0.27, 0.22]))
    gltf.mesh("stand", make_stand(0.75, 0.1, 96), lambert("stand", [0.6, 0.6, 0.58]))
    gltf.mesh("ball", make_sphere(0.22, 96, 48), paint, [(-0.3, 0.32, 0.2)])
    gltf.mesh("vase", make_lathe(VASE_PROFILE, 96, 96),
              material("brass", [0.9, 0.72, 0.4], metallic=1.0, roughness=0.2), [(0.22, 0.1, -0.2)])
    gltf.mesh("block", make_box((0.22, 0.18, 0.3), math.radians(30.0)),
              material("lacquer", [0.03, 0.1, 0.4], roughness=0.2), [(0.3, 0.1, 0.3)])


def main():
    arguments = glb.make_parser("Writes objects on a turntable under a sky, and a scene file.").parse_args()
    gltf = glb.Gltf("make-turntable.py", "turntable")
    add_objects(gltf)
    gltf.camera(orbit(arguments.frames), math.radians(34.0))
    glb.save("make-turntable.py", gltf, arguments.out)
    base = os.path.splitext(arguments.out)[0]
    scene = {"about": "Objects on a turntable, made by scenes/make-turntable.py.", "scene": os.path.basename(arguments.out),
             "environment": {"map": os.path.basename(base) + "-sky.hdr"}}
    try:
        write_hdr(base + "-sky.hdr", MAP[0], MAP[1], sky)
        with open(base + ".json", "w", encoding="utf-8") as file:
            file.write(json.dumps(scene, indent=2) + "\n")
    except OSError as error:
        sys.exit("make-turntable.py: %s: %s" % (error.filename, error.strerror))


if __name__ == "__main__":
    main()
