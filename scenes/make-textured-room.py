#!/usr/bin/env python3
"""Writes a room with textures of every kind as a .glb.

A checkered floor whose squares differ in roughness, a wall of boards and one of
bricks with a normal map, an alpha-masked fence and a screen with an emissive texture.
The images are generated and embedded as PNG. Uses only Python's standard library;
the same arguments give the same bytes (with the same zlib).

  make-textured-room.py OUT.glb [--frames N]
"""

import math

import glb
from glb import lambert, material
from pictures import normal_map, png
from shapes import make_box, make_quad, make_room, make_sphere, normalize, sub

LOW, HIGH = (-2.5, 0.0, -2.0), (2.5, 2.8, 2.5)
SIZE = 256


def scaled(mesh, across, up):
    """Repeats the texture over the quad of the mesh."""
    mesh.uvs = [(u * across, v * up) for u, v in mesh.uvs]
    return mesh


def with_tangents(mesh):
    """Tangents of a single quad: along its lower edge; the bitangent points up."""
    tangent = normalize(sub(mesh.positions[1], mesh.positions[0]))
    mesh.tangents = [tangent + (1.0,)] * len(mesh.positions)
    return mesh


def textured(name, textures, metallic=0.0, roughness=1.0, **more):
    """A material; textures: members of pbrMetallicRoughness, by index."""
    result = dict(material(name, [1.0, 1.0, 1.0], metallic, roughness), **more)
    for key, index in textures.items():
        result["pbrMetallicRoughness"][key] = {"index": index}
    return result


def checker(x, y):
    return (0.86, 0.84, 0.8) if (x * 2 // SIZE + y * 2 // SIZE) % 2 == 0 else (0.3, 0.16, 0.14)


def checker_roughness(x, y):  # green: roughness, blue: metallic
    return (0.0, 0.25 if (x * 2 // SIZE + y * 2 // SIZE) % 2 == 0 else 0.7, 0.0)


def boards(x, y):
    """Four upright boards with elongated growth rings."""
    board, across = divmod(x, SIZE // 4)
    ring = math.sin(0.45 * across + 2.5 * math.sin(2.0 * math.pi * y / SIZE + 1.7 * board) + 1.3 * board)
    tone = (0.75 + 0.06 * board + 0.12 * ring) * (0.35 if across in (0, 1) else 1.0)
    return tuple(tone * v for v in (0.75, 0.52, 0.32))


def brick(x, y):
    """Height in [0, 1] and number of the brick: rows of 32 pixels, alternately offset by half a brick."""
    row = y // 32
    column, along = divmod((x + 32 * (row % 2)) % SIZE, 64)
    edge = min(along, 63 - along, y % 32, 31 - y % 32)
    return min(max((edge - 1.5) / 3.0, 0.0), 1.0), 4 * row + column


def brick_color(x, y):
    height, number = brick(x, y)
    tone = 0.85 + 0.15 * math.sin(12.9 * number)
    return tuple(m + (tone * b - m) * height for m, b in zip((0.62, 0.6, 0.56), (0.68, 0.34, 0.26)))


def fence(x, y):
    """A chain-link fence; alpha is 0 between the wires."""
    a, b = (x + y) % 64, (x - y) % 64
    wire = min(a, 64 - a, b, 64 - b)
    alpha = min(max(1.0 - (wire - 5.0) / 4.0, 0.0), 1.0)
    return 0.25, 0.5, 0.3, alpha


def screen(x, y):
    """An arrow off centre to the upper right, to reveal flips, over colour bars."""
    if y > 208:
        bar = x * 6 // SIZE
        return tuple(float((bar + 1) >> k & 1) for k in range(3))
    u, v = x - 128, 110 - y
    head = 0 <= 80 - v <= 80 and v > 10 and abs(u) < 80 - v
    shaft = -80 < v <= 10 and abs(u) < 16
    dot = (u - 90) ** 2 + (v - 70) ** 2 < 200
    return (1.0, 0.8, 0.2) if head or shaft else (1.0, 0.1, 0.1) if dot else (0.03, 0.07, 0.2)


def add_room(gltf):
    room = make_room(LOW, HIGH)
    floor = textured("floor", {"baseColorTexture": gltf.texture("checker", png(SIZE, SIZE, checker)),
                               "metallicRoughnessTexture": gltf.texture("checker gloss", png(SIZE, SIZE, checker_roughness))})
    wood = textured("boards", {"baseColorTexture": gltf.texture("boards", png(SIZE, SIZE, boards))}, roughness=0.6)
    bricks = textured("bricks", {"baseColorTexture": gltf.texture("bricks", png(SIZE, SIZE, brick_color))}, roughness=0.9,
                      normalTexture={"index": gltf.texture("brick normals", normal_map(
                          SIZE, SIZE, lambda x, y: 3.0 * brick(x, y)[0]))})
    gltf.mesh("floor", scaled(room["floor"], 5.0, 4.5), floor)
    gltf.mesh("left wall", scaled(room["left wall"], 4.5, 1.0), wood)
    gltf.mesh("back wall", with_tangents(scaled(room["back wall"], 4.0, 2.24)), bricks)
    for name in ("ceiling", "right wall", "front wall"):
        gltf.mesh(name, room[name], lambert(name, [0.65, 0.65, 0.62]))
    lamp = material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.95, 0.88], strength=9.0, double_sided=False)
    gltf.mesh("light", make_quad((-0.7, HIGH[1] - 0.05, -1.3), (1.2, 0.0, 0.0), (0.0, 0.0, 0.9)), lamp)


def add_objects(gltf):
    wire = textured("fence", {"baseColorTexture": gltf.texture("fence", png(SIZE, SIZE, fence))}, metallic=0.0,
                    roughness=0.5, alphaMode="MASK", alphaCutoff=0.5)
    gltf.mesh("fence", scaled(make_quad((0.5, 0.0, 0.1), (1.6, 0.0, -0.7), (0.0, 1.0, 0.0)), 4.0, 2.5), wire)
    glow = material("screen", [0.02, 0.02, 0.02], roughness=0.3, emissive=[1.0, 1.0, 1.0], strength=3.0, double_sided=False)
    glow["emissiveTexture"] = {"index": gltf.texture("screen", png(SIZE, SIZE, screen), repeat=False)}
    gltf.mesh("screen", make_quad((-1.75, 0.62, -1.58), (0.9, 0.0, -0.1), (0.0, 0.7, 0.0)), glow)
    gltf.mesh("screen back", make_box((0.96, 0.76, 0.04), math.atan2(0.1, 0.9)), lambert("case", [0.05, 0.05, 0.05]),
              [(-1.303, 0.59, -1.655)])
    gltf.mesh("chest", make_box((1.1, 0.59, 0.5)), lambert("chest", [0.5, 0.42, 0.3]), [(-1.3, 0.0, -1.65)])
    ball = material("ball", [0.8, 0.8, 0.8], metallic=1.0, roughness=0.15)
    gltf.mesh("ball", make_sphere(0.3, 64, 32), ball, [(0.1, 0.3, -0.9)])
    gltf.mesh("block", make_box((0.4, 0.5, 0.4), math.radians(25.0)), lambert("block", [0.2, 0.35, 0.55]), [(1.5, 0.0, -1.0)])


def main():
    arguments = glb.make_parser("Writes a room with textures of every kind.").parse_args()
    gltf = glb.Gltf("make-textured-room.py", "textured room")
    add_room(gltf)
    add_objects(gltf)
    eyes, targets = ((-0.5, 1.35, 2.1), (0.6, 1.25, 1.8)), ((-0.15, 0.85, -1.5), (-0.05, 0.8, -1.5))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(48.0))
    glb.save("make-textured-room.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
