#!/usr/bin/env python3
"""Writes an open-plan office floor with very many lights as a .glb.

Modelled after the office scene of Bekaert, Sbert and Halton, Accelerating Path
Tracing by Re-Using Paths (2002): about 315,000 triangles, 2,450 emissive polygons,
glossy desks. A closed floor of 42 x 3 x 37 m: rows of ceiling lamps of seven panes
each; groups of desks between partitions, with screen, keyboard, cup, papers and a
chair; round columns, plants, and a gangway along which the camera moves. Uses only
Python's standard library; the same arguments give the same bytes.

  make-office-floor.py OUT.glb [--frames N] [--glass]

--glass makes the cups of glass and the frames of the desks mirrors, for light paths.
"""

import math
import random

import glb
from glb import glass, lambert, material
from shapes import Mesh, add, make_box, make_lathe, make_quad, make_room, make_sphere

LOW, HIGH = (-21.0, 0.0, -18.5), (21.0, 3.0, 18.5)
LAMPS = (25, 14)          # along x and along z
PANES = 7                 # per lamp: 25 x 14 x 7 = 2450 polygons
GROUPS = (9, 10)          # of four desks each, along x and along z
SPACING = (4.5, 3.55)
GANGWAY = 0.0             # x of the omitted column of groups

CUP_PROFILE = ((0.0, 0.0), (0.03, 0.0), (0.036, 0.008), (0.04, 0.05), (0.042, 0.09), (0.038, 0.09), (0.035, 0.05),
               (0.03, 0.012), (0.0, 0.01))
POT_PROFILE = ((0.0, 0.0), (0.16, 0.0), (0.2, 0.15), (0.22, 0.4), (0.2, 0.4), (0.0, 0.36))


def merged(parts):
    """One mesh of (mesh, place, turn about y) parts."""
    out = Mesh()
    for mesh, place, turn in parts:
        c, s = math.cos(turn), math.sin(turn)
        first = len(out.positions)
        out.positions += [add((x * c + z * s, y, z * c - x * s), place) for x, y, z in mesh.positions]
        out.normals += [(x * c + z * s, y, z * c - x * s) for x, y, z in mesh.normals]
        out.uvs += mesh.uvs
        out.indices += [first + i for i in mesh.indices]
    return out


def box(size, place, turn=0.0):
    return make_box(size), place, turn


def make_tube(radius, height, columns):
    """A round wall, open at both ends, standing at y = 0."""
    def point(row, column):
        turn = 2.0 * math.pi * (column % columns) / columns
        normal = (math.sin(turn), 0.0, math.cos(turn))
        return (radius * normal[0], row * height, radius * normal[2]), normal, (column / columns, 1.0 - row)

    mesh = Mesh()
    mesh.grid(point, 1, columns)
    return mesh


def add_room(gltf):
    colors = {"floor": [0.2, 0.22, 0.25], "ceiling": [0.75, 0.75, 0.75], "back wall": [0.6, 0.6, 0.56],
              "left wall": [0.55, 0.6, 0.62], "right wall": [0.62, 0.56, 0.5], "front wall": [0.6, 0.6, 0.6]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))


def add_lamps(gltf):
    """Housings below the ceiling, each with a row of panes that emit downwards."""
    cold, warm, housing = Mesh(), Mesh(), make_box((1.3, 0.06, 0.24))
    places = []
    for row in range(LAMPS[1]):
        for column in range(LAMPS[0]):
            x = LOW[0] + (HIGH[0] - LOW[0]) * (column + 0.5) / LAMPS[0]
            z = LOW[2] + (HIGH[2] - LOW[2]) * (row + 0.5) / LAMPS[1]
            places.append((x, HIGH[1] - 0.1, z))
            mesh = warm if (row + column) % 5 == 0 else cold
            for pane in range(PANES):
                left = x - 0.6 + pane * 1.2 / PANES
                mesh.quad((left + 0.01, HIGH[1] - 0.101, z - 0.09), (1.2 / PANES - 0.02, 0.0, 0.0), (0.0, 0.0, 0.18))
    gltf.mesh("housing", housing, lambert("housing", [0.7, 0.7, 0.7]), places)
    for name, mesh, color in (("cold light", cold, [0.85, 0.95, 1.0]), ("warm light", warm, [1.0, 0.8, 0.55])):
        gltf.mesh(name, mesh, material(name, [0.0, 0.0, 0.0], specular=0.0, emissive=color, strength=14.0, double_sided=False))


def make_chair():
    """A chair: seat, back and two arms on five feet with wheels."""
    parts = [(make_lathe(((0.0, 0.0), (0.23, 0.0), (0.25, 0.03), (0.24, 0.07), (0.0, 0.08)), 16, 6), (0.0, 0.44, 0.0), 0.0),
             (make_tube(0.03, 0.38, 10), (0.0, 0.07, 0.0), 0.0),
             box((0.42, 0.5, 0.05), (0.0, 0.62, 0.24)), box((0.06, 0.2, 0.03), (0.0, 0.44, 0.25))]
    for side in (-1.0, 1.0):
        parts += [box((0.04, 0.03, 0.26), (side * 0.27, 0.68, 0.0)), box((0.04, 0.24, 0.04), (side * 0.27, 0.45, 0.05))]
    for foot in range(5):
        turn = 2.0 * math.pi * foot / 5.0
        x, z = math.sin(turn), math.cos(turn)
        parts += [box((0.05, 0.04, 0.28), (0.14 * x, 0.05, 0.14 * z), turn),
                  (make_sphere(0.03, 6, 4), (0.28 * x, 0.03, 0.28 * z), 0.0)]
    return merged(parts)


def make_keyboard():
    """A keyboard: a slab with keys."""
    parts = [box((0.44, 0.012, 0.15), (0.0, 0.0, 0.0))]
    for row in range(3):
        for column in range(4):
            parts.append(box((0.09, 0.01, 0.035), (-0.156 + column * 0.104, 0.012, -0.045 + row * 0.045)))
    return merged(parts)


def make_monitor():
    foot = make_lathe(((0.0, 0.0), (0.12, 0.0), (0.115, 0.01), (0.0, 0.016)), 16, 4)
    pole = make_tube(0.018, 0.14, 10)
    return merged([(foot, (0.0, 0.0, 0.0), 0.0), (pole, (0.0, 0.01, 0.0), 0.0), box((0.52, 0.32, 0.03), (0.0, 0.12, 0.0))])


def make_plant(chance):
    """A plant: leaves of two triangles per side, on stems that lean outwards."""
    mesh = Mesh()
    for _ in range(90):
        turn, lean, height = chance.uniform(0.0, 2.0 * math.pi), chance.uniform(0.05, 0.45), chance.uniform(0.4, 1.3)
        x, z = math.sin(turn) * lean, math.cos(turn) * lean
        along = (0.14 * math.sin(turn), chance.uniform(0.0, 0.2), 0.14 * math.cos(turn))
        mesh.quad((x, height, z), (0.05 * math.cos(turn), 0.0, -0.05 * math.sin(turn)), along)
    return mesh


def add_desks(gltf, chance, clear):
    """Groups of four desks around a cross of partitions; one node per object."""
    top = material("desk top", [0.42, 0.3, 0.2], roughness=0.22)
    dark, cloth = material("dark plastic", [0.03, 0.03, 0.035], roughness=0.3), lambert("partition", [0.25, 0.33, 0.42])
    things = {
        "desk": (make_box((1.5, 0.03, 0.75)), top), "frame": (merged([box((0.04, 0.7, 0.6), (x, 0.0, 0.0)) for x in (-0.7, 0.7)]),
                                                             material("steel", [0.6, 0.6, 0.62], metallic=1.0, roughness=0.0 if clear else 0.35)),
        "chair": (make_chair(), lambert("chair", [0.05, 0.06, 0.1])), "monitor": (make_monitor(), dark),
        "keyboard": (make_keyboard(), dark), "cup": (make_lathe(CUP_PROFILE, 10, 6),
                                                    glass("cup") if clear else material("cup", [0.7, 0.68, 0.6], roughness=0.2)),
        "paper": (make_box((0.21, 0.004, 0.297)), lambert("paper", [0.8, 0.8, 0.78])),
    }
    numbers = {name: gltf.add_mesh(name, mesh, kind) for name, (mesh, kind) in things.items()}
    walls = [gltf.add_mesh("long partition", make_box((3.1, 1.3, 0.05)), cloth),
             gltf.add_mesh("short partition", make_box((0.05, 1.3, 1.6)), cloth)]

    def put(parent, number, place, turn):
        gltf.node({"mesh": number, "translation": list(place),
                   "rotation": [0.0, math.sin(0.5 * turn), 0.0, math.cos(0.5 * turn)]}, parent)

    for row in range(GROUPS[1]):
        for column in range(GROUPS[0]):
            x, z = (column - 0.5 * (GROUPS[0] - 1)) * SPACING[0], (row - 0.5 * (GROUPS[1] - 1)) * SPACING[1]
            if abs(x - GANGWAY) < 0.1:
                continue
            group = gltf.node({"name": "group %d %d" % (row + 1, column + 1), "translation": [x, 0.0, z]})
            for wall in walls:
                put(group, wall, (0.0, 0.0, 0.0), 0.0)
            for side, end in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
                place, turn = (side * 0.79, 0.0, end * 0.42), 0.0 if end > 0.0 else math.pi
                put(group, numbers["desk"], add(place, (0.0, 0.7, 0.0)), turn)
                put(group, numbers["frame"], place, turn)
                some = chance.uniform
                for name, offset, turned in (
                        ("monitor", (some(-0.2, 0.2), 0.73, -end * 0.2), some(-0.3, 0.3)),
                        ("keyboard", (0.0, 0.73, end * 0.12), some(-0.1, 0.1)),
                        ("cup", (chance.choice((-0.5, 0.5)), 0.73, end * some(0.0, 0.2)), 0.0),
                        ("paper", (some(-0.6, -0.4), 0.73, -end * 0.15), some(-0.6, 0.6)),
                        ("chair", (some(-0.2, 0.2), 0.0, end * some(0.45, 0.75)), some(-0.6, 0.6))):
                    put(group, numbers[name], add(place, offset), turn + turned)


def add_rest(gltf, chance):
    """Columns along the gangway, plants at their feet."""
    column = make_tube(0.25, HIGH[1], 40)
    spots = [(x, 0.0, z) for z in (-14.0, -7.0, 0.0, 7.0, 14.0) for x in (-1.9, 1.9)]
    gltf.mesh("column", column, lambert("column", [0.65, 0.65, 0.62]), spots)
    places = [add(place, (0.0, 0.0, 0.6)) for place in spots]
    gltf.mesh("pot", make_lathe(POT_PROFILE, 24, 10), material("pot", [0.5, 0.22, 0.12], roughness=0.4), places)
    gltf.mesh("plant", make_plant(chance), lambert("plant", [0.1, 0.3, 0.08]), places)


def walk(frames):
    """The camera moves down the gangway, looking from one side to the other."""
    views = []
    for frame in range(frames):
        t = frame / (frames - 1) if frames > 1 else 0.0
        eye = (0.5 * math.sin(1.5 * math.pi * t), 1.65 + 0.02 * math.sin(12.0 * math.pi * t), 16.5 - 6.0 * t)
        target = (eye[0] + 2.5 * math.sin(0.6 + 1.6 * math.pi * t), 1.1, eye[2] - 4.0)
        views.append((eye, target))
    return views


def main():
    parser = glb.make_parser("Writes an office floor with 2,450 lamps.")
    parser.add_argument("--glass", action="store_true", help="cups of glass, frames of desks that are mirrors")
    arguments = parser.parse_args()
    gltf, chance = glb.Gltf("make-office-floor.py", "office floor"), random.Random(2002)
    add_room(gltf)
    add_lamps(gltf)
    add_desks(gltf, chance, arguments.glass)
    add_rest(gltf, chance)
    gltf.camera(walk(arguments.frames), math.radians(50.0))
    glb.save("make-office-floor.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
