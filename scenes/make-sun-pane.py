#!/usr/bin/env python3
"""Writes a sun that shines through a window of thick glass as a .glb.

A closed room whose left wall has a window of three panes, bodies of glass 4 cm thick:
one flat, one with bevelled edges, one with a bullseye in its middle. The sun's light
on floor and wall has been refracted twice, so light samples find none of it. A faint
lamp at the ceiling lights the rest. Uses only Python's standard library; the same
arguments give the same bytes.

  make-sun-pane.py OUT.glb [--frames N] [--disc DEGREES]

--disc puts a shining disc far away, so many degrees in radius and of the same
irradiance, in the place of the sun, which paths from the camera can find: for comparisons.
"""

import math

import glb
from glb import glass, lambert, material
from shapes import Mesh, add, cross, make_box, make_quad, make_room, make_sphere, normalize, sub

LOW, HIGH = (-1.5, 0.0, -1.5), (1.5, 2.3, 1.7)
THICK = 0.04
PANE, GAP = (0.5, 0.9), 0.05        # along z and y; the frame between panes
BOTTOM = 0.75
MIDDLES = (-0.85, -0.3, 0.25)       # z of the panes
SUN = normalize((1.0, -0.78, 0.06))  # the way that the light travels
IRRADIANCE, COLOR = 6.0, (1.0, 0.94, 0.82)
FAR = 6.0                            # m, of the disc from the window


def make_slab(middle, bevel, bullseye, cells):
    """A body with a front and a back at x = LOW[0] ± THICK / 2, whose outer side is bevelled towards the edges or bulges."""
    def outside(y, z):
        y0, z0 = y - BOTTOM - 0.5 * PANE[1], z - middle
        edge = min(0.5 * PANE[1] - abs(y0), 0.5 * PANE[0] - abs(z0))
        height = 0.5 * THICK
        if bevel > 0.0:
            height -= 0.5 * bevel * max(1.0 - edge / (2.0 * bevel), 0.0) * 0.5
        if bullseye > 0.0:
            r = math.hypot(y0, z0) / bullseye
            height += 0.03 * (math.cos(0.5 * math.pi * min(r, 1.0)) ** 2) * (1.0 + 0.4 * math.cos(3.0 * math.pi * r)) / 1.4
        return LOW[0] - height

    def side(x_of, sign):
        rows = cells if bevel > 0.0 or bullseye > 0.0 else 1
        rows = rows if sign < 0.0 else 1

        def point(row, column):
            y = BOTTOM + PANE[1] * row / rows
            z = middle + PANE[0] * ((column / rows) - 0.5)
            step = 1e-4
            up = (x_of(y + step, z) - x_of(y - step, z), 2.0 * step, 0.0)
            along = (x_of(y, z + step) - x_of(y, z - step), 0.0, 2.0 * step)
            normal = normalize(cross(along, up))
            normal = normal if normal[0] * sign > 0.0 else tuple(-v for v in normal)
            return (x_of(y, z), y, z), normal, (column / rows, 1.0 - row / rows)
        return point, rows

    mesh = Mesh()
    for x_of, sign in ((outside, -1.0), (lambda y, z: LOW[0] + 0.5 * THICK, 1.0)):
        point, rows = side(x_of, sign)
        if sign < 0.0:
            mesh.grid(point, rows, rows)
        else:
            mesh.grid(lambda row, column: point(row, rows - column), rows, rows)
    # the four sides, thinner where the outside is bevelled: a little inside of the frame
    inner, z0, z1, y0, y1 = LOW[0] + 0.5 * THICK, middle - 0.5 * PANE[0], middle + 0.5 * PANE[0], BOTTOM, BOTTOM + PANE[1]
    depth = (outside(y0, z0) - inner, 0.0, 0.0)
    mesh.quad((inner, y0, z0), (0.0, 0.0, PANE[0]), depth)
    mesh.quad((inner, y1, z1), (0.0, 0.0, -PANE[0]), depth)
    mesh.quad((inner, y1, z0), (0.0, -PANE[1], 0.0), depth)
    mesh.quad((inner, y0, z1), (0.0, PANE[1], 0.0), depth)
    return mesh


def add_room(gltf):
    colors = {"floor": [0.5, 0.45, 0.38], "ceiling": [0.75, 0.75, 0.75], "back wall": [0.55, 0.55, 0.5], "right wall": [0.6, 0.55, 0.48],
              "front wall": [0.5, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        if name in colors:
            gltf.mesh(name, mesh, lambert(name, colors[name]))
    lamp = material("ceiling lamp", [0.0, 0.0, 0.0], specular=0.0, emissive=[0.75, 0.85, 1.0], strength=1.0, double_sided=False)
    gltf.mesh("ceiling lamp", make_quad((-0.4, HIGH[1] - 0.03, -0.4), (0.8, 0.0, 0.0), (0.0, 0.0, 0.8)), lamp)
    gltf.mesh("bench", make_box((0.9, 0.4, 0.4), 0.3), lambert("bench", [0.4, 0.3, 0.22]), [(0.55, 0.0, -0.75)])
    gltf.mesh("ball", make_sphere(0.16, 64, 32), lambert("ball", [0.7, 0.68, 0.62]), [(0.0, 0.16, 0.35)])


def add_wall(gltf):
    """The wall around the panes, thicker than they are, which holds their edges."""
    wall, half = lambert("left wall", [0.6, 0.58, 0.52]), 0.04
    y0, y1 = BOTTOM, BOTTOM + PANE[1]
    z = [LOW[2]] + [m + s * 0.5 * PANE[0] for m in MIDDLES for s in (-1.0, 1.0)] + [HIGH[2]]
    parts = [((LOW[2], 0.0), (HIGH[2], y0)), ((LOW[2], y1), (HIGH[2], HIGH[1]))]
    parts += [((z[i], y0), (z[i + 1], y1)) for i in range(0, len(z), 2)]
    for (za, ya), (zb, yb) in parts:
        gltf.mesh("left wall", make_box((2.0 * half, yb - ya, zb - za)), wall, [(LOW[0], ya, 0.5 * (za + zb))])


def add_sun(gltf, degrees):
    middle = (LOW[0], BOTTOM + 0.5 * PANE[1], MIDDLES[1])
    if degrees is None:
        gltf.light("sun", {"type": "directional", "color": COLOR, "intensity": IRRADIANCE}, sub(middle, SUN), middle)
        return
    # the irradiance of a disc straight above is its radiance times pi times the sine of its radius squared
    radius = FAR * math.tan(math.radians(degrees))
    strength = IRRADIANCE / (math.pi * math.sin(math.radians(degrees)) ** 2)
    place = add(middle, tuple(-FAR * v for v in SUN))
    x = normalize(cross((0.0, 1.0, 0.0), SUN))
    y = cross(SUN, x)
    mesh = Mesh()
    ring = [add(place, tuple(radius * (math.cos(a) * p + math.sin(a) * q) for p, q in zip(x, y)))
            for a in (2.0 * math.pi * i / 48 for i in range(48))]
    first = mesh.vertex(place, SUN, (0.5, 0.5))
    for p in ring:
        mesh.vertex(p, SUN, (0.5, 0.5))
    for i in range(48):
        mesh.indices.extend((first, first + 1 + i, first + 1 + (i + 1) % 48))
    gltf.mesh("sun", mesh, material("sun", [0.0, 0.0, 0.0], specular=0.0, emissive=COLOR, strength=strength, double_sided=False))


def main():
    parser = glb.make_parser("Writes a sun that shines through a window of thick glass.")
    parser.add_argument("--disc", type=glb.number_between(0.1, 10.0, "degrees from 0.1 to 10"), metavar="DEGREES", help="a shining disc of so many degrees in radius in the place of the sun")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-sun-pane.py", "sun pane")
    add_room(gltf)
    add_wall(gltf)
    add_sun(gltf, arguments.disc)
    for name, middle, bevel, bullseye in zip(("flat pane", "bevelled pane", "bullseye pane"), MIDDLES, (0.0, 0.03, 0.0), (0.0, 0.0, 0.2)):
        gltf.mesh(name, make_slab(middle, bevel, bullseye, 96), glass("glass"))
    eyes, targets = ((0.75, 1.5, 1.55), (0.2, 1.45, 1.6)), ((-0.35, 0.55, -0.5), (-0.25, 0.55, -0.5))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(58.0))
    glb.save("make-sun-pane.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
