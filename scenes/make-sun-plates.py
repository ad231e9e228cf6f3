#!/usr/bin/env python3
"""Writes a sun that shines on metal plates and glasses as a .glb.

The sun enters a room by an open window and falls on a table laid with plates of smooth metal and with drinking glasses,
which throw its light on walls and ceiling. Paths from the camera find that light by chance: white specks. Uses only
Python's standard library; the same arguments give the same bytes.

  make-sun-plates.py OUT.glb [--frames N] [--disc DEGREES]

The sun is a shining disc far away, larger than the real one, since paths must find it for references.
"""

import math

import glb
from glb import glass, lambert, material
from shapes import Mesh, add, cross, make_box, make_lathe, make_room, normalize

LOW, HIGH = (-1.7, 0.0, -1.6), (1.7, 2.5, 1.9)
WINDOW = ((1.1, 2.35), (-1.1, 0.25))   # of the left wall: y, z
TABLE = 0.74
SUN = normalize((1.0, -0.72, 0.08))   # the way that the light travels
IRRADIANCE, COLOR, SKY = 14.0, (1.0, 0.95, 0.84), [0.35, 0.5, 0.8]
FAR = 8.0                             # m, of the disc from the table

PLATE = ((0.0, 0.004), (0.06, 0.004), (0.085, 0.006), (0.105, 0.014), (0.135, 0.021), (0.137, 0.023), (0.135, 0.025), (0.104, 0.018),
         (0.085, 0.010), (0.06, 0.008), (0.0, 0.008))
TUMBLER = ((0.0, 0.0), (0.026, 0.0), (0.030, 0.002), (0.032, 0.02), (0.035, 0.06), (0.038, 0.1), (0.0388, 0.103), (0.038, 0.104),
           (0.0372, 0.103), (0.0335, 0.06), (0.0300, 0.025), (0.02, 0.014), (0.0, 0.013))
BOWL = ((0.0, 0.0), (0.04, 0.0), (0.07, 0.012), (0.1, 0.045), (0.11, 0.08), (0.1115, 0.082), (0.108, 0.08), (0.097, 0.046), (0.068, 0.016),
        (0.04, 0.005), (0.0, 0.004))


def add_room(gltf):
    colors = {"floor": [0.32, 0.24, 0.17], "ceiling": [0.78, 0.78, 0.76], "back wall": [0.62, 0.6, 0.55], "right wall": [0.6, 0.56, 0.5],
              "front wall": [0.5, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        if name in colors:
            gltf.mesh(name, mesh, lambert(name, colors[name]))
    (y0, y1), (z0, z1) = WINDOW
    wall = lambert("left wall", [0.6, 0.58, 0.52])
    for part, (ya, yb, za, zb) in enumerate(((0.0, y0, LOW[2], HIGH[2]), (y1, HIGH[1], LOW[2], HIGH[2]), (y0, y1, LOW[2], z0), (y0, y1, z1, HIGH[2]))):
        gltf.mesh("left wall %d" % (part + 1), make_box((0.12, yb - ya, zb - za)), wall, [(LOW[0] - 0.06, ya, 0.5 * (za + zb))])
    gltf.mesh("bar", make_box((0.05, y1 - y0, 0.05)), wall, [(LOW[0] - 0.03, y0, -0.42)])
    gltf.mesh("table", make_box((1.5, 0.05, 1.1)), lambert("table", [0.42, 0.33, 0.25]), [(0.05, TABLE - 0.05, -0.45)])
    gltf.mesh("table foot", make_box((0.4, TABLE - 0.05, 0.4)), lambert("table foot", [0.2, 0.14, 0.1]), [(0.05, 0.0, -0.45)])


def add_table(gltf):
    steel, brass, copper = (material(name, color, 1.0, rough, double_sided=False) for name, color, rough in (
        ("steel", [0.8, 0.8, 0.8], 0.1), ("brass", [0.9, 0.75, 0.42], 0.15), ("copper", [0.95, 0.64, 0.54], 0.2)))
    above = TABLE + 0.0005
    gltf.mesh("steel plate", make_lathe(PLATE, 64, 48), steel, [(-0.32, above, -0.68), (0.28, above, -0.2)])
    gltf.mesh("brass plate", make_lathe(PLATE, 64, 48), brass, [(0.3, above, -0.72)])
    gltf.mesh("copper bowl", make_lathe(BOWL, 64, 48), copper, [(-0.3, above, -0.18)])
    gltf.mesh("tray", make_box((0.3, 0.008, 0.2), 0.2), material("tray", [0.82, 0.82, 0.84], 1.0, 0.12), [(0.0, above, -0.44)])
    gltf.mesh("glass", make_lathe(TUMBLER, 64, 64), glass("glass"), [(-0.08, above, -0.76), (0.52, above, -0.42), (-0.5, above, -0.42), (0.02, above, -0.12)])


def add_sun(gltf, degrees):
    """A shining disc far away, and a sky that enters with it."""
    # the irradiance of a disc straight above is its radiance times pi times the sine of its radius squared
    radius, strength = FAR * math.tan(math.radians(degrees)), IRRADIANCE / (math.pi * math.sin(math.radians(degrees)) ** 2)
    place = add((0.0, TABLE, -0.45), tuple(-FAR * v for v in SUN))
    x = normalize(cross((0.0, 1.0, 0.0), SUN))
    y = cross(SUN, x)
    mesh = Mesh()
    mesh.vertex(place, SUN, (0.5, 0.5))
    for i in range(48):
        a = 2.0 * math.pi * i / 48
        mesh.vertex(add(place, tuple(radius * (math.cos(a) * p + math.sin(a) * q) for p, q in zip(x, y))), SUN, (0.5, 0.5))
        mesh.indices.extend((0, 1 + i, 1 + (i + 1) % 48))
    gltf.mesh("sun", mesh, material("sun", [0.0, 0.0, 0.0], specular=0.0, emissive=COLOR, strength=strength, double_sided=False))
    gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"radiance": SKY}}}


def main():
    parser = glb.make_parser("Writes a sun that shines on metal plates and glasses.")
    parser.add_argument("--disc", type=glb.number_between(0.1, 10.0, "degrees from 0.1 to 10"), metavar="DEGREES", default=2.5, help="radius of the sun (2.5)")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-sun-plates.py", "sun plates")
    add_room(gltf)
    add_table(gltf)
    add_sun(gltf, arguments.disc)
    eyes, targets = ((0.2, 1.5, 1.5), (0.75, 1.4, 1.3)), ((0.0, 0.98, -0.7), (0.0, 0.98, -0.6))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(48.0))
    glb.save("make-sun-plates.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
