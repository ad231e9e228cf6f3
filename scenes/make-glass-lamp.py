#!/usr/bin/env python3
"""Writes a lamp without size in a shade of thick glass as a .glb.

On a table in a closed room stands a fluted glass, open at the top, with a point light
in it: all that reaches table and walls below the rim has been refracted, so light
samples find none of it. A faint lamp at the ceiling lights the rest. Uses only
Python's standard library; the same arguments give the same bytes.

  make-glass-lamp.py OUT.glb [--frames N] [--bulb RADIUS]

--bulb puts a shining ball of so many metres and the same intensity in the place of
the point, which paths from the camera can find: for comparisons.
"""

import math

import glb
from glb import glass, lambert, material
from shapes import Mesh, cross, make_box, make_lathe, make_quad, make_room, make_sphere, normalize, sub

LOW, HIGH = (-1.5, 0.0, -1.2), (1.5, 2.2, 1.8)
TABLE = 0.72
LAMP = (0.0, TABLE + 0.15, -0.1)
INTENSITY = 1.2  # W/sr
COLOR = (1.0, 0.85, 0.62)

FLUTES, DEPTH = 14, 0.035  # of the outside, and how deep they are in radii
# Radius and height along the wall: the outside, the lip, the inside and the bottom.
SHADE_PROFILE = (
    (0.0, 0.0), (0.03, 0.0), (0.052, 0.003), (0.06, 0.015), (0.066, 0.05), (0.075, 0.1), (0.084, 0.15), (0.089, 0.2), (0.087, 0.25),
    (0.081, 0.285), (0.078, 0.29), (0.0755, 0.285), (0.08, 0.25), (0.082, 0.2), (0.077, 0.15), (0.068, 0.1), (0.059, 0.05),
    (0.052, 0.03), (0.03, 0.024), (0.0, 0.0235),
)
BASE_PROFILE = ((0.0, 0.0), (0.07, 0.0), (0.075, 0.006), (0.068, 0.016), (0.05, 0.02), (0.0, 0.02))


def point_of(profile, t):
    """Catmull-Rom through the profile, mirrored at the axis."""
    n = len(profile) - 1
    i = min(int(t * n), n - 1)
    x = t * n - i
    p0 = profile[i - 1] if i > 0 else (-profile[1][0], profile[1][1])
    p3 = profile[i + 2] if i + 2 <= n else (-profile[n - 1][0], profile[n - 1][1])
    result = []
    for a, b, c, d in zip(p0, profile[i], profile[i + 1], p3):
        result.append(b + x * (0.5 * (c - a) + x * (a - 2.5 * b + 2.0 * c - 0.5 * d + x * (1.5 * (b - c) + 0.5 * (d - a)))))
    return result


def make_shade(columns, rows):
    """A surface of revolution whose outside is fluted between bottom and lip."""
    def place(t, phi):
        radius, height = point_of(SHADE_PROFILE, min(max(t, 0.0), 1.0))
        fade = math.sin(math.pi * min(max(t / 0.53, 0.0), 1.0)) ** 2
        radius *= 1.0 + DEPTH * fade * math.cos(FLUTES * phi)
        return radius * math.sin(phi), height, radius * math.cos(phi)

    def point(row, column):
        t, phi, step = row / rows, 2.0 * math.pi * (column % columns) / columns, 1e-4
        if row in (0, rows):
            return (0.0, SHADE_PROFILE[0 if row == 0 else -1][1], 0.0), (0.0, -1.0 if row == 0 else 1.0, 0.0), (column / columns, 1.0 - t)
        up = sub(place(t + step, phi), place(t - step, phi))
        along = sub(place(t, phi + step), place(t, phi - step))
        return place(t, phi), normalize(cross(along, up)), (column / columns, 1.0 - t)

    mesh = Mesh()
    mesh.grid(point, rows, columns)
    return mesh


def add_room(gltf):
    colors = {"floor": [0.25, 0.2, 0.16], "ceiling": [0.7, 0.7, 0.7], "back wall": [0.5, 0.5, 0.46], "left wall": [0.55, 0.42, 0.35],
              "right wall": [0.4, 0.48, 0.5], "front wall": [0.5, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))
    lamp = material("ceiling lamp", [0.0, 0.0, 0.0], specular=0.0, emissive=[0.75, 0.85, 1.0], strength=1.0, double_sided=False)
    gltf.mesh("ceiling lamp", make_quad((-0.4, HIGH[1] - 0.03, 0.2), (0.8, 0.0, 0.0), (0.0, 0.0, 0.8)), lamp)
    gltf.mesh("table", make_box((1.3, 0.05, 0.8)), lambert("table", [0.55, 0.47, 0.38]), [(0.0, TABLE - 0.05, -0.15)])
    gltf.mesh("table foot", make_box((0.4, TABLE - 0.05, 0.3)), lambert("table foot", [0.2, 0.14, 0.1]), [(0.0, 0.0, -0.15)])


def add_lamp(gltf, bulb):
    if bulb is None:
        gltf.light("point", {"type": "point", "color": COLOR, "intensity": INTENSITY}, LAMP, (0.0, LAMP[1], -1.0))
        return
    # the intensity of a ball is its radiance times the area of a disc
    shine = material("bulb", [0.0, 0.0, 0.0], specular=0.0, emissive=COLOR, strength=INTENSITY / (math.pi * bulb * bulb), double_sided=False)
    gltf.mesh("bulb", make_sphere(bulb, 24, 12), shine, [LAMP])


def main():
    parser = glb.make_parser("Writes a lamp without size in a shade of thick glass.")
    parser.add_argument("--bulb", type=glb.number_between(1e-4, 0.04, "metres from 0.0001 to 0.04"), metavar="RADIUS", help="a shining ball of so many metres in the place of the point")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-glass-lamp.py", "glass lamp")
    add_room(gltf)
    add_lamp(gltf, arguments.bulb)
    gltf.mesh("base", make_lathe(BASE_PROFILE, 64, 40), lambert("base", [0.3, 0.22, 0.12]), [(LAMP[0], TABLE + 0.0005, LAMP[2])])
    gltf.mesh("shade", make_shade(224, 120), glass("glass"), [(LAMP[0], TABLE + 0.022, LAMP[2])])
    gltf.mesh("pear", make_sphere(0.045, 48, 24), lambert("pear", [0.55, 0.5, 0.12]), [(-0.24, TABLE + 0.045, 0.04)])
    gltf.mesh("book", make_box((0.16, 0.035, 0.22), 0.5), lambert("book", [0.45, 0.12, 0.1]), [(0.28, TABLE + 0.0005, 0.0)])
    gltf.mesh("copper ball", make_sphere(0.05, 64, 32), material("copper", [0.95, 0.64, 0.54], metallic=1.0, roughness=0.35),
              [(0.2, TABLE + 0.05, -0.36)])
    eyes, targets = ((-0.45, 1.2, 0.9), (0.35, 1.14, 0.93)), ((0.0, TABLE + 0.07, -0.08), (0.0, TABLE + 0.07, -0.08))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(34.0))
    glb.save("make-glass-lamp.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
