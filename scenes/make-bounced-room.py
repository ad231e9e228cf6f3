#!/usr/bin/env python3
"""Writes a room with only indirect light as a .glb.

A closed room of 6 x 3.2 x 5 m. Lamps in two troughs high on the side walls light the
ceiling. No surface below the rims, and so none in view, sees a lamp: all its light
comes by way of the ceiling and the tops of the walls.
Only Python's standard library; the same arguments give the same bytes.

  make-bounced-room.py OUT.glb [--frames N] [--spots]

--spots: two spot lights instead of the lamps in the troughs, and a small point light
behind the screen (KHR_lights_punctual), to test punctual lights.
"""

import math

import glb
from glb import lambert, material
from shapes import make_box, make_lathe, make_quad, make_room, make_sphere

RIM = 2.3  # height of the troughs' rims: the lamps do not light anything below
LOW, HIGH = (-3.0, 0.0, -2.5), (3.0, 3.2, 2.5)
LAMP = (-0.55, 0.9, -1.9)  # of --spots: behind the screen

JUG_PROFILE = (
    (0.0, 0.0), (0.06, 0.0), (0.085, 0.012), (0.11, 0.07), (0.118, 0.14), (0.1, 0.21), (0.07, 0.26), (0.062, 0.3),
    (0.078, 0.34), (0.082, 0.347), (0.074, 0.345), (0.055, 0.3), (0.062, 0.26), (0.09, 0.21), (0.108, 0.14),
    (0.1, 0.075), (0.075, 0.022), (0.0, 0.012),
)


def add_room(gltf):
    colors = {"floor": [0.42, 0.3, 0.2], "ceiling": [0.85, 0.85, 0.85], "back wall": [0.66, 0.64, 0.6],
              "left wall": [0.62, 0.45, 0.18], "right wall": [0.22, 0.38, 0.5], "front wall": [0.6, 0.6, 0.6]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))


def add_troughs(gltf, lit):
    """The troughs along the left and right walls: a floor and a front, white inside."""
    white = lambert("trough", [0.8, 0.8, 0.8])
    lamp = material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.9, 0.76], strength=24.0,
                    double_sided=False)
    length, depth = 3.6, 0.5
    for side, name in ((-1.0, "left"), (1.0, "right")):
        middle = side * (HIGH[0] - 0.5 * depth)
        gltf.mesh(name + " trough floor", make_box((depth, 0.03, length)), white, [(middle, RIM - 0.2, -0.2)])
        gltf.mesh(name + " trough front", make_box((0.03, 0.2, length)), white,
                  [(side * (HIGH[0] - depth - 0.015), RIM - 0.2, -0.2)])
        if lit:
            corner = (middle - 0.15, RIM - 0.1, -0.2 - 0.5 * length + 0.1)
            gltf.mesh(name + " light", make_quad(corner, (0.0, 0.0, length - 0.2), (0.3, 0.0, 0.0)), lamp)


def add_objects(gltf):
    wood, cloth = lambert("wood", [0.3, 0.17, 0.09]), lambert("cloth", [0.2, 0.27, 0.2])
    gltf.mesh("table top", make_box((1.5, 0.05, 0.8)), wood, [(0.3, 0.68, -0.9)])
    gltf.mesh("table leg", make_box((0.06, 0.68, 0.06)), wood,
              [(0.3 + x * 0.68, 0.0, -0.9 + z * 0.33) for x in (-1, 1) for z in (-1, 1)])
    gltf.mesh("jug", make_lathe(JUG_PROFILE, 80, 72), material("glaze", [0.55, 0.2, 0.1], roughness=0.25),
              [(0.05, 0.73, -0.85)])
    gltf.mesh("brass ball", make_sphere(0.13, 64, 32),
              material("brass", [0.9, 0.72, 0.4], metallic=1.0, roughness=0.3), [(0.55, 0.86, -0.72)])
    gltf.mesh("book", make_box((0.3, 0.05, 0.21), math.radians(20.0)), lambert("book", [0.45, 0.08, 0.1]),
              [(0.75, 0.73, -1.05)])
    gltf.mesh("sofa seat", make_box((0.8, 0.4, 1.7)), cloth, [(-2.4, 0.0, -0.6)])
    gltf.mesh("sofa back", make_box((0.22, 0.85, 1.7)), cloth, [(-2.75, 0.0, -0.6)])
    gltf.mesh("screen", make_box((1.1, 1.5, 0.04), math.radians(-18.0)), lambert("screen", [0.7, 0.66, 0.55]),
              [(-0.9, 0.0, -1.5)])
    gltf.mesh("shelf", make_box((0.4, 1.7, 0.9)), wood, [(2.75, 0.0, -1.6)])


def add_spots(gltf):
    for side in (-1.0, 1.0):
        place = (side * 2.85, RIM - 0.1, -0.2)
        spot = {"type": "spot", "color": [1.0, 0.9, 0.76], "intensity": 9.0,
                "spot": {"innerConeAngle": 0.6, "outerConeAngle": 1.1}}
        gltf.light("left spot" if side < 0.0 else "right spot", spot, place, (side * 1.9, HIGH[1], -0.6))
    gltf.light("lamp", {"type": "point", "color": [1.0, 0.75, 0.5], "intensity": 1.5}, LAMP, (LAMP[0], 0.0, 0.0))


def main():
    parser = glb.make_parser("Writes a room that only bounced light reaches.")
    parser.add_argument("--spots", action="store_true", help="spot and point lights instead of the troughs' lamps")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-bounced-room.py", "bounced room")
    add_room(gltf)
    add_troughs(gltf, not arguments.spots)
    add_objects(gltf)
    if arguments.spots:
        add_spots(gltf)
    eyes, targets = ((-0.5, 1.5, 1.3), (0.8, 1.4, 1.1)), ((0.15, 0.62, -1.0), (0.15, 0.68, -1.0))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(40.0))
    glb.save("make-bounced-room.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
