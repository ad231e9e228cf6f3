#!/usr/bin/env python3
"""Writes a staircase with a lacquered handrail as a .glb.

A bulb hangs in a stairwell. The rail, its rims of steel and the edges of the steps are curved, glossy and thin: they mirror
the bulb in lines and points narrower than a pixel, which hold most of the noise. Uses only Python's standard library;
the same arguments give the same bytes.

  make-handrail.py OUT.glb [--frames N]
"""

import math

import glb
from glb import lambert, material
from shapes import Mesh, add, cross, make_box, make_room, make_sphere, mix, normalize, sub

LOW, HIGH = (-1.6, 0.0, -3.2), (1.6, 3.6, 2.4)
STEPS, RISE, GOING = 9, 0.17, 0.29
FIRST = 0.3                      # z of the front of the first step
EDGE, RIGHT = 0.05, HIGH[0]      # x of the free side of the stairs, and of the wall
RAIL, BALUSTER, RIM = 0.021, 0.008, 0.002  # m, radii
HEIGHT = 0.9                     # of the rail above the steps
BULB, STRENGTH = 0.06, 300.0


def make_tube(points, radius, columns):
    """A tube around a smooth curve, with open ends."""
    tangents = [normalize(sub(points[min(i + 1, len(points) - 1)], points[max(i - 1, 0)])) for i in range(len(points))]
    side = normalize(cross(tangents[0], (0.31, 0.2, 0.93)))
    frames = []
    for tangent in tangents:  # each side is the last one turned no further than the curve turns
        up = normalize(cross(tangent, side))
        side = cross(up, tangent)
        frames.append((side, up))

    def point(row, column):
        angle = 2.0 * math.pi * (column % columns) / columns
        normal = tuple(math.cos(angle) * a + math.sin(angle) * b for a, b in zip(*frames[row]))
        return add(points[row], tuple(radius * n for n in normal)), normal, (column / columns, row / (len(points) - 1))

    mesh = Mesh()
    mesh.grid(point, len(points) - 1, columns)
    return mesh


def make_ring(middle, axis, radius, thickness):
    """A torus."""
    side = normalize(cross(axis, (0.31, 0.2, 0.93)))
    up = normalize(cross(axis, side))
    turns = 24
    return make_tube([add(middle, tuple(radius * (math.cos(a) * p + math.sin(a) * q) for p, q in zip(side, up)))
                      for a in (2.0 * math.pi * i / turns for i in range(turns + 1))], thickness, 10)


def along(t):
    """The rail's middle at step t, over the free side of the stairs."""
    return (EDGE + 0.06, HEIGHT + RISE * t, FIRST - GOING * t)


def rail_points():
    """From a curl over the first step, up along the stairs, to a bend at the top."""
    foot, top = along(0.5), along(STEPS - 0.5)
    curl = [add(foot, (-0.16 + 0.16 * math.cos(a) * (1.0 - 0.2 * a / math.pi), -0.05 * a, 0.16 * math.sin(a))) for a in (math.pi * i / 24 for i in range(30, 0, -1))]
    bend = [add(top, (0.0, RISE * t - 0.10 * t * t, -GOING * t)) for t in (0.1 * i for i in range(1, 14))]
    return curl + [mix(foot, top, i / 40) for i in range(41)] + bend


def add_stairs(gltf):
    steel, wood = material("steel", [0.75, 0.75, 0.77], 1.0, 0.12), lambert("wood", [0.38, 0.26, 0.16])
    rail, painted = material("rail", [0.1, 0.03, 0.02], 0.0, 0.1), lambert("painted", [0.6, 0.6, 0.56])
    width, middle = RIGHT - EDGE, 0.5 * (RIGHT + EDGE)
    points = rail_points()
    gltf.mesh("rail", make_tube(points, RAIL, 24), rail)
    for i in range(2, len(points) - 2, 2):
        gltf.mesh("rim %d" % (i // 2), make_ring(points[i], sub(points[i + 1], points[i - 1]), RAIL, RIM), steel)
    for i in range(STEPS):
        top, z = RISE * (i + 1), FIRST - GOING * i
        gltf.mesh("step %d" % (i + 1), make_box((width, top, GOING)), wood, [(middle, 0.0, z - 0.5 * GOING)])
        gltf.mesh("edge %d" % (i + 1), make_tube([(EDGE, top, z), (middle, top, z), (RIGHT, top, z)], 0.004, 16), steel)
        for part in (0.25, 0.75):
            x, y, depth = along(i + part)
            gltf.mesh("baluster %d %g" % (i + 1, part), make_tube([mix((x, top, depth), (x, y, depth), k / 4) for k in range(5)], BALUSTER, 16), painted)
            gltf.mesh("collar %d %g" % (i + 1, part), make_ring((x, 0.5 * (top + y), depth), (0.0, 1.0, 0.0), BALUSTER, RIM), steel)


def main():
    arguments = glb.make_parser("Writes a staircase with a lacquered handrail.").parse_args()
    gltf = glb.Gltf("make-handrail.py", "handrail")
    colors = {"floor": [0.4, 0.36, 0.32], "ceiling": [0.75, 0.75, 0.75], "back wall": [0.6, 0.58, 0.54], "left wall": [0.62, 0.5, 0.38],
              "right wall": [0.6, 0.6, 0.58], "front wall": [0.5, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))
    add_stairs(gltf)
    bulb = material("bulb", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.9, 0.75], strength=STRENGTH, double_sided=False)
    gltf.mesh("bulb", make_sphere(BULB, 24, 12), bulb, [(-0.7, 2.9, -0.5)])
    gltf.mesh("ball", make_sphere(0.22, 64, 32), material("vase", [0.12, 0.2, 0.35], 0.0, 0.15), [(-0.9, 0.221, -1.1)])
    eyes, targets = ((-0.45, 1.35, 0.75), (-0.35, 1.95, -0.35)), ((0.3, 1.0, -0.5), (0.4, 1.6, -1.6))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(46.0))
    glb.save("make-handrail.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
