#!/usr/bin/env python3
"""Writes a room with frosted glass as a .glb.

A lamp and coloured things stand behind a screen of solid rough glass; before it, on a table, a bowl of rough glass over a
pear and a lampshade of thin rough glass around a bulb. What shows through holds most of the noise. Uses only Python's
standard library; the same arguments give the same bytes.

  make-frosted-room.py OUT.glb [--frames N]
"""

import math

import glb
from glb import lambert, material
from shapes import make_box, make_lathe, make_room, make_sphere

TABLE = 0.75
LOW, HIGH = (-2.0, 0.0, -2.5), (2.0, 2.7, 2.5)

# Up the outside, over the lip, and down the inside.
BOWL_PROFILE = (
    (0.0, 0.0), (0.05, 0.0), (0.062, 0.006), (0.085, 0.03), (0.108, 0.062), (0.121, 0.095), (0.126, 0.118), (0.124, 0.122),
    (0.12, 0.119), (0.113, 0.096), (0.099, 0.066), (0.077, 0.037), (0.052, 0.018), (0.0, 0.014),
)


def frosted(name, roughness, color, solid):
    result = material(name, color, roughness=roughness, double_sided=not solid)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5}}
    if solid:
        result["extensions"]["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    return result


def lamp(name, strength):
    return material(name, [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.9, 0.75], strength=strength)


def main():
    arguments = glb.make_parser("Writes a room with frosted glass.").parse_args()
    gltf = glb.Gltf("make-frosted-room.py", "frosted room")
    colors = {"floor": [0.35, 0.3, 0.26], "ceiling": [0.75, 0.75, 0.75], "back wall": [0.6, 0.58, 0.5],
              "left wall": [0.2, 0.42, 0.5], "right wall": [0.6, 0.55, 0.48], "front wall": [0.55, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))
    gltf.mesh("table", make_box((1.6, 0.05, 0.7)), lambert("table", [0.45, 0.36, 0.26]), [(0.0, TABLE - 0.05, 0.2)])
    gltf.mesh("table foot", make_box((0.4, TABLE - 0.05, 0.3)), lambert("table foot", [0.2, 0.14, 0.1]), [(0.0, 0.0, 0.2)])
    # behind the screen
    gltf.mesh("screen", make_box((1.5, 1.9, 0.02)), frosted("screen", 0.3, [0.95, 0.98, 0.97], True), [(-0.35, 0.05, -0.9)])
    gltf.mesh("bulb", make_sphere(0.07, 32, 16), lamp("bulb", 90.0), [(-0.2, 1.5, -1.5)])
    for i, color in enumerate(([0.7, 0.12, 0.08], [0.1, 0.3, 0.65], [0.7, 0.55, 0.1])):
        gltf.mesh(f"column {i}", make_box((0.22, 1.2, 0.22)), lambert(f"column {i}", color), [(-0.85 + 0.5 * i, 0.0, -1.3)])
    # on the table
    stand = TABLE + 0.0005
    gltf.mesh("bowl", make_lathe(BOWL_PROFILE, 96, 80), frosted("bowl", 0.45, [0.9, 0.97, 1.0], True), [(0.25, stand, 0.3)])
    gltf.mesh("pear", make_sphere(0.045, 48, 24), lambert("pear", [0.55, 0.5, 0.12]), [(0.25, stand + 0.061, 0.3)])
    gltf.mesh("shade", make_sphere(0.09, 64, 32), frosted("shade", 0.4, [1.0, 0.93, 0.8], False), [(-0.3, stand + 0.1, 0.25)])
    gltf.mesh("filament", make_sphere(0.015, 24, 12), lamp("filament", 180.0), [(-0.3, stand + 0.1, 0.25)])
    eyes, targets = ((0.5, 1.35, 1.7), (-0.25, 1.28, 1.6)), ((-0.05, 0.95, 0.0), (0.0, 0.95, 0.0))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(42.0))
    glb.save("make-frosted-room.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
