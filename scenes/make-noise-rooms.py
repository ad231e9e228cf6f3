#!/usr/bin/env python3
"""Writes one of fourteen small rooms whose noise is of different kinds, for checks of the error estimate and of chosen settings.

  make-noise-rooms.py OUT.glb --room NAME [--seed N] [--frames N]

shelf      a lamp hidden above a shelf, diffuse          crystal    glass balls under a small lamp: caustics
brushed    the same with rough metals                    lantern    a small lamp inside solid glass: all light is a caustic
mirrors    mirrors that face a hidden lamp               coats      clear coats under five tiny lamps
spots      spot lights in the dark                       patio      an open yard under an even sky
checker    black and white checks, one lamp in view      window     a sky that enters through a pane
corridor   a lamp in the next room                       neon       thin bright tubes over a black floor
curtain    a curtain lit from behind, a lamp shade       drawn      lamps, materials and path drawn by --seed

Uses only Python's standard library; the same arguments give the same bytes (with the same zlib).
"""

import math
import random

import glb
from glb import lambert, material
from pictures import png
from shapes import Mesh, make_box, make_quad, make_room, make_sphere, normalize

LOW, HIGH = (-2.0, 0.0, -2.0), (2.0, 2.6, 2.2)
WHITE = [1.0, 0.95, 0.85]


def glass(name):
    result = material(name, [1.0, 1.0, 1.0], roughness=0.0, double_sided=False)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5},
                            "KHR_materials_volume": {"thicknessFactor": 1.0}}
    return result


def pane(name):
    result = material(name, [1.0, 1.0, 1.0], roughness=0.0)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5}}
    return result


def coated(name, color, roughness=0.0):
    result = material(name, color, roughness=0.6)
    result["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": roughness}}
    return result


def lamp(strength, double_sided=False):
    return material("light %g" % strength, [0.0, 0.0, 0.0], specular=0.0, emissive=WHITE, strength=strength,
                    double_sided=double_sided)


def add_walls(gltf, without=(), floor=None):
    colors = {"floor": [0.45, 0.4, 0.35], "ceiling": [0.8, 0.8, 0.8], "back wall": [0.6, 0.55, 0.5],
              "left wall": [0.65, 0.3, 0.2], "right wall": [0.25, 0.45, 0.3], "front wall": [0.5, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        if name not in without:
            gltf.mesh(name, mesh, floor if floor is not None and name == "floor" else lambert(name, colors[name]))


def add_things(gltf, first, second, third=None):
    """Two balls and a box on the floor."""
    gltf.mesh("left ball", make_sphere(0.42, 48, 24), first, [(-0.75, 0.43, -0.7)])
    gltf.mesh("right ball", make_sphere(0.3, 48, 24), second, [(0.55, 0.31, 0.0)])
    gltf.mesh("box", make_box((0.6, 1.0, 0.6), 0.4), third or lambert("box", [0.5, 0.5, 0.55]), [(0.9, 0.002, -1.1)])


def add_lamp(gltf, name, middle, size, strength, up=False):
    """A horizontal square lamp that shines down, or up."""
    x, z = (size, 0.0, 0.0), (0.0, 0.0, size)
    corner = (middle[0] - 0.5 * size, middle[1], middle[2] - 0.5 * size)
    gltf.mesh(name, make_quad(corner, z, x) if up else make_quad(corner, x, z), lamp(strength))


def add_hidden_lamp(gltf, size=0.35, strength=60.0):
    """On top of a shelf at the back wall: it shines at the ceiling close above."""
    gltf.mesh("shelf", make_box((1.8, 0.04, 0.5)), lambert("shelf", [0.4, 0.3, 0.2]), [(-0.2, 2.05, -1.74)])
    gltf.mesh("shelf front", make_box((1.8, 0.16, 0.03)), lambert("shelf", [0.4, 0.3, 0.2]), [(-0.2, 2.05, -1.48)])
    add_lamp(gltf, "lamp", (-0.2, 2.11, -1.74), size, strength, up=True)


def shelf(gltf):
    add_walls(gltf)
    add_things(gltf, lambert("clay", [0.6, 0.4, 0.3]), lambert("chalk", [0.8, 0.8, 0.8]))
    add_hidden_lamp(gltf)


def brushed(gltf):
    add_walls(gltf, floor=material("floor", [0.35, 0.3, 0.28], roughness=0.35))
    add_things(gltf, material("copper", [0.95, 0.64, 0.54], 1.0, 0.3), material("steel", [0.7, 0.7, 0.7], 1.0, 0.15),
               material("brass", [0.9, 0.75, 0.4], 1.0, 0.5))
    add_hidden_lamp(gltf)


def mirrors(gltf):
    add_walls(gltf)
    silver = material("silver", [0.95, 0.95, 0.95], 1.0, 0.0)
    add_things(gltf, silver, silver, silver)
    add_hidden_lamp(gltf)


def spots(gltf):
    add_walls(gltf)
    add_things(gltf, material("varnish", [0.3, 0.1, 0.08], 0.0, 0.2), lambert("chalk", [0.8, 0.8, 0.8]))
    for i, x in enumerate((-1.2, 0.2, 1.3)):
        spot = {"type": "spot", "color": WHITE, "intensity": 12.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.3}}
        gltf.light("spot %d" % (i + 1), spot, (x, 2.5, -0.5), (0.7 * x, 0.0, -0.6))


def checker(gltf):
    def check(x, y):
        return (0.95, 0.95, 0.95) if (x // 8 + y // 8) % 2 == 0 else (0.0, 0.0, 0.0)
    floor = lambert("floor", [1.0, 1.0, 1.0])
    floor["pbrMetallicRoughness"]["baseColorTexture"] = {"index": gltf.texture("checks", png(128, 128, check))}
    add_walls(gltf, floor=floor)
    add_things(gltf, lambert("black", [0.0, 0.0, 0.0]), lambert("chalk", [0.8, 0.8, 0.8]), dict(floor, name="check box"))
    add_lamp(gltf, "lamp", (0.0, 1.75, -1.3), 0.4, 12.0)


def corridor(gltf):
    add_walls(gltf, without=("right wall",))
    gltf.mesh("wall with a gap", make_box((0.06, 2.6, 3.4)), lambert("gap wall", [0.6, 0.6, 0.55]), [(1.9, 0.0, -0.3)])
    add_things(gltf, lambert("clay", [0.6, 0.4, 0.3]), material("steel", [0.7, 0.7, 0.7], 1.0, 0.2))
    for name, mesh in make_room((2.0, 0.0, -2.0), (4.0, 2.6, 2.2)).items():
        if name != "left wall":
            gltf.mesh("next " + name, mesh, lambert("next room", [0.7, 0.7, 0.7]))
    add_lamp(gltf, "lamp", (3.3, 2.55, -1.0), 0.5, 120.0)


def crystal(gltf):
    add_walls(gltf)
    add_things(gltf, glass("crystal"), glass("crystal"))
    add_lamp(gltf, "lamp", (0.0, 2.55, -0.4), 0.25, 80.0)


def lantern(gltf):
    add_walls(gltf)
    gltf.mesh("lantern", make_box((0.5, 0.5, 0.5), 0.3), glass("lantern"), [(0.1, 0.4, -0.6)])
    gltf.mesh("stand", make_box((0.3, 0.38, 0.3)), lambert("stand", [0.3, 0.3, 0.3]), [(0.1, 0.002, -0.6)])
    gltf.mesh("bulb", make_sphere(0.09, 24, 12), lamp(60.0), [(0.1, 0.65, -0.6)])
    gltf.mesh("ball", make_sphere(0.25, 48, 24), lambert("chalk", [0.8, 0.8, 0.8]), [(-0.9, 0.26, -0.3)])


def coats(gltf):
    add_walls(gltf, floor=coated("floor", [0.35, 0.18, 0.1]))
    add_things(gltf, coated("red", [0.5, 0.03, 0.03]), coated("blue", [0.03, 0.05, 0.4], 0.15),
               material("steel", [0.7, 0.7, 0.7], 1.0, 0.08))
    for i in range(5):
        add_lamp(gltf, "lamp %d" % (i + 1), (-1.6 + 0.8 * i, 2.5, -0.9 + 0.3 * (i % 2)), 0.06, 250.0)


def patio(gltf):
    add_walls(gltf, without=("ceiling", "front wall"))
    add_things(gltf, material("varnish", [0.1, 0.3, 0.1], 0.0, 0.25), glass("crystal"))
    gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"radiance": [0.5, 0.7, 1.0]}}}


def window(gltf):
    add_walls(gltf, without=("left wall",))
    for name, low, high in (("under", (-2.0, 0.0, -2.0), (-2.0, 1.2, 2.2)), ("over", (-2.0, 1.9, -2.0), (-2.0, 2.6, 2.2)),
                            ("left", (-2.0, 1.2, -0.4), (-2.0, 1.9, 2.2)), ("right", (-2.0, 1.2, -2.0), (-2.0, 1.9, -1.2))):
        gltf.mesh(name, make_quad((low[0], low[1], high[2]), (0.0, 0.0, low[2] - high[2]), (0.0, high[1] - low[1], 0.0)),
                  lambert("window wall", [0.65, 0.6, 0.5]))
    gltf.mesh("pane", make_quad((-2.0, 1.2, -0.4), (0.0, 0.0, -0.8), (0.0, 0.7, 0.0)), pane("pane"))
    add_things(gltf, material("copper", [0.95, 0.64, 0.54], 1.0, 0.25), lambert("chalk", [0.8, 0.8, 0.8]))
    gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"radiance": [3.0, 4.0, 6.0]}}}


def neon(gltf):
    add_walls(gltf, floor=material("floor", [0.02, 0.02, 0.02], roughness=0.12))
    add_things(gltf, material("varnish", [0.02, 0.02, 0.02], 0.0, 0.1), material("steel", [0.7, 0.7, 0.7], 1.0, 0.25))
    for i in range(4):
        gltf.mesh("tube %d" % (i + 1), make_box((0.02, 1.6, 0.02)), lamp(40.0), [(-1.6 + i, 0.5, -1.85)])


def shade(name, color, through, factor, roughness=0.6):
    result = material(name, color, 0.0, roughness)
    result["extensions"] = {"KHR_materials_diffuse_transmission": {
        "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": through}}
    return result


def make_folds(x, depth, low, high, z0, z1, folds):
    """A curtain before the left wall, in smooth folds."""
    def point(row, column):
        t = column / (8 * folds)
        turn = 2.0 * math.pi * folds * t
        normal = normalize((1.0, 0.0, -depth * 2.0 * math.pi * folds * math.cos(turn) / (z1 - z0)))
        return (x + depth * math.sin(turn), high + (low - high) * row, z0 + t * (z1 - z0)), normal, (t, row)

    mesh = Mesh()
    mesh.grid(point, 1, 8 * folds)
    return mesh


def curtain(gltf):
    add_walls(gltf, without=("left wall",))
    gltf.mesh("lamp outside", make_quad((-2.9, 0.3, 1.2), (0.0, 0.0, -2.6), (0.0, 1.8, 0.0)), lamp(12.0))
    gltf.mesh("curtain", make_folds(-1.85, 0.07, 0.0, 2.6, -2.0, 2.2, 14), shade("curtain", [0.8, 0.75, 0.6], [0.9, 0.6, 0.35], 0.5))
    gltf.mesh("shade", make_sphere(0.3, 48, 24), shade("shade", [0.9, 0.9, 0.9], [0.95, 0.85, 0.6], 0.6, 0.3), [(0.9, 1.35, -1.1)])
    gltf.mesh("bulb", make_sphere(0.06, 24, 12), lamp(60.0), [(0.9, 1.35, -1.1)])
    add_things(gltf, lambert("chalk", [0.8, 0.8, 0.8]), material("varnish", [0.3, 0.1, 0.08], 0.0, 0.25))


def drawn(gltf, draw):
    def color():
        return [0.1 + 0.8 * draw() for _ in range(3)]

    def thing(name):
        metal, kind = 1.0 if draw() < 0.3 else 0.0, draw()
        return (lambert(name, color()) if kind < 0.5 else material(name, color(), metal, 0.1 + 0.5 * draw()) if kind < 0.8
                else coated(name, color(), 0.2 * draw()) if kind < 0.9 else glass(name))
    floor, kind = color(), draw()
    add_walls(gltf, floor=material("floor", floor, roughness=0.2 + 0.4 * draw()) if kind < 0.3 else lambert("floor", floor))
    add_things(gltf, thing("left ball"), thing("right ball"), thing("box"))
    kind, size = draw(), 0.1 + 1.1 * draw() ** 2
    if kind < 0.3:
        add_hidden_lamp(gltf, 0.1 + 0.35 * draw())
    elif kind < 0.8:
        add_lamp(gltf, "lamp", (2.0 * draw() - 1.0, 2.55, 2.0 * draw() - 1.5), size, 10.0 / size ** 2)
    for i in range(0 if kind < 0.65 else 1 + int(3.0 * draw())):
        spot = {"type": "spot", "color": WHITE, "intensity": 5.0 + 15.0 * draw(), "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2 + 0.6 * draw()}}
        gltf.light("spot %d" % (i + 1), spot, (3.0 * draw() - 1.5, 2.5, 2.0 * draw() - 1.5), (2.0 * draw() - 1.0, 0.0, -1.0))


ROOMS = {room.__name__: room for room in (shelf, brushed, mirrors, spots, checker, corridor, crystal, lantern, coats, patio,
                                          window, neon, curtain, drawn)}


def main():
    parser = glb.make_parser("Writes a room whose noise is of a certain kind.")
    parser.add_argument("--room", choices=ROOMS, required=True)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the room drawn (1)")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-noise-rooms.py", arguments.room)
    eyes, targets = ((-0.4, 1.3, 2.0), (0.5, 1.25, 1.9)), ((0.0, 0.75, -0.8), (0.0, 0.8, -0.8))
    if arguments.room == "drawn":
        draw = random.Random(arguments.seed).random
        drawn(gltf, draw)
        eyes = tuple((2.0 * draw() - 1.0, 0.8 + draw(), 2.0 - 0.5 * draw()) for _ in range(2))
        targets = tuple((draw() - 0.5, 0.5 + 0.5 * draw(), -0.8) for _ in range(2))
    else:
        ROOMS[arguments.room](gltf)
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(50.0))
    glb.save("make-noise-rooms.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
