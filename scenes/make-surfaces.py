#!/usr/bin/env python3
"""Writes brushed metal, films, cloth, curtains and dispersive glass side by side.

  make-surfaces.py OUT.glb [--light even|sky|sun|room]

Each surface is a ball or a sheet in a frame of its own: in a white world, under a sky
with a warm and a blue light (OUT-sky.hdr beside OUT.glb), under a sun, or in a room
whose lamp is behind a curtain. Of a sheet "from behind" the light is on the other
side. Uses only Python's standard library; the same arguments give the same bytes.
"""

import math
import os

import glb
from glb import lambert, material
from pictures import write_hdr
from shapes import Mesh, make_quad, make_room, make_sphere, normalize

RADIUS, DISTANCE = 0.5, 5.0  # of a ball, and of the camera from it
FILL = 0.97  # of the width of a ball's picture is the ball
COLUMNS = 7
SPACING = {"even": 6.0, "sky": 6.0, "sun": 6.0, "room": 1.8}  # so far apart that what one lacks is little to the others
SUN = normalize((-0.4, 0.5, 0.77))
MAP = (256, 128)

WHITE, BLACK, RED, GOLD = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0], [0.6, 0.08, 0.05], [1.0, 0.77, 0.34]


def extended(name, color, metallic, roughness, specular=None, **extensions):
    result = material(name, color, metallic, roughness, specular)
    for key, value in extensions.items():
        result.setdefault("extensions", {})["KHR_materials_" + key] = value
    return result


def brushed(name, color, roughness, strength, turn=0.0, **more):
    return extended(name, color, 1.0, roughness, anisotropy={"anisotropyStrength": strength, "anisotropyRotation": turn}, **more)


def film(name, thickness, index=1.33, roughness=0.2, ior=1.5, **more):
    """A film on something black."""
    return extended(name, BLACK, 0.0, roughness, ior={"ior": ior}, iridescence={
        "iridescenceFactor": 1.0, "iridescenceIor": index, "iridescenceThicknessMaximum": thickness}, **more)


def body(name, roughness=0.0, ior=1.5, **more):
    result = extended(name, WHITE, 0.0, roughness, transmission={"transmissionFactor": 1.0}, ior={"ior": ior},
                      volume={"thicknessFactor": 1.0}, **more)
    del result["doubleSided"]
    return result


def cloth(name, color, sheen, roughness, **more):
    return extended(name, color, 0.0, 1.0, 0.0, sheen={"sheenColorFactor": sheen, "sheenRoughnessFactor": roughness}, **more)


def shade(name, color, through, factor, specular=0.0, roughness=0.4):
    return extended(name, color, 0.0, roughness, specular, diffuse_transmission={
        "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": through})


CURTAIN = shade("curtain", [0.8, 0.7, 0.5], [0.9, 0.5, 0.3], 0.6)
COAT = {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.1}

# What each shows, and of which shape it is.
SURFACES = (
    ("ball", brushed("brushed", WHITE, 0.3, 0.6)),
    ("ball", brushed("brushed slantwise", WHITE, 0.2, 0.8, 0.25 * math.pi)),
    ("ball", brushed("brushed across", WHITE, 0.4, 1.0, 0.5 * math.pi)),
    ("ball", brushed("brushed sharp", WHITE, 0.06, 0.3, 1.0)),
    ("ball", brushed("brushed gold", GOLD, 0.4, 0.7, -0.5)),
    ("ball", brushed("brushed, coated", WHITE, 0.3, 0.6, clearcoat=COAT)),
    ("ball", film("film 0", 0.0)),
    ("ball", film("film 200", 200.0)),
    ("ball", film("film 400", 400.0)),
    ("ball", film("film 700", 700.0, 1.8)),
    ("ball", film("film 2000", 2000.0)),
    ("ball", film("film, brushed", 400.0, anisotropy={"anisotropyStrength": 0.6})),
    ("ball", body("glass")),
    ("ball", body("film on glass", iridescence={
        "iridescenceFactor": 1.0, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 350.0})),
    ("ball", body("film on rough glass", 0.3, iridescence={
        "iridescenceFactor": 1.0, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 350.0})),
    ("ball", body("dispersion", dispersion={"dispersion": 2.0})),
    ("ball", body("dispersion, high", ior=1.9, dispersion={"dispersion": 8.0})),
    ("ball", body("dispersion, rough", 0.3, dispersion={"dispersion": 8.0})),
    ("ball", cloth("sheen", BLACK, WHITE, 0.5)),
    ("ball", cloth("sheen, smooth", BLACK, [0.9, 0.5, 0.7], 0.2)),
    ("ball", cloth("sheen, rough", RED, [0.6, 0.8, 0.9], 1.0)),
    ("ball", cloth("sheen, coated", RED, [0.6, 0.6, 0.6], 0.5, clearcoat=COAT)),
    ("sheet", cloth("cloth", RED, [0.7, 0.5, 0.5], 0.4)),
    ("ball", shade("lampshade", [0.8, 0.8, 0.8], [0.8, 0.6, 0.4], 0.5)),
    ("ball", shade("all through", WHITE, [0.9, 0.9, 0.9], 1.0)),
    ("ball", shade("leaf", [0.2, 0.5, 0.1], [0.4, 0.6, 0.1], 0.5, 1.0)),
    ("sheet", dict(CURTAIN, name="curtain from the front")),
    ("sheet", dict(CURTAIN, name="curtain from behind")),
)


def wave(size, columns, rows):
    """An upright sheet of soft folds, which shade nothing from the sun."""
    def point(row, column):
        u, v = column / columns, row / rows
        depth, slope = 0.05 * math.sin(4.0 * math.pi * u), 0.05 * 4.0 * math.pi * math.cos(4.0 * math.pi * u) / size
        return (size * (u - 0.5), size * (0.5 - v), depth), normalize((-slope, 0.0, 1.0)), (u, v)

    mesh = Mesh()
    mesh.grid(lambda row, column: point(rows - row, column), rows, columns)
    return mesh


MESHES = {"ball": lambda: make_sphere(RADIUS, 192, 96), "sheet": lambda: wave(1.5, 96, 4)}


def sky(x, y):
    """Radiance of a pixel of the map, whose top is +y and whose centre is -z."""
    theta, phi = math.pi * (y + 0.5) / MAP[1], 2.0 * math.pi * ((x + 0.5) / MAP[0] - 0.5)
    way = (math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi))
    lobe = lambda axis: math.exp(40.0 * (sum(a * b for a, b in zip(way, axis)) - 1.0))
    warm, blue = lobe(SUN), lobe(normalize((0.5, 0.3, -0.8)))
    return tuple(0.3 + 0.2 * way[1] + 8.0 * warm * a + 10.0 * blue * b for a, b in zip((1.0, 0.8, 0.6), (0.5, 0.8, 1.0)))


def put_room(gltf, places, spacing):
    """Grey walls, a curtain from wall to wall behind the surfaces, and a lamp behind it."""
    low = (min(p[0] for p in places) - spacing, min(p[1] for p in places) - spacing, -3.0)
    high = (max(p[0] for p in places) + spacing, max(p[1] for p in places) + spacing, 10.0)
    for name, mesh in make_room(low, high).items():
        gltf.mesh(name, mesh, lambert("wall", [0.6, 0.6, 0.6]))
    width, height = high[0] - low[0], high[1] - low[1]
    lamp = material("lamp", BLACK, specular=0.0, emissive=WHITE, strength=6.0, double_sided=False)
    gltf.mesh("lamp", make_quad((low[0] + 0.2 * width, low[1] + 0.2 * height, -2.95), (0.6 * width, 0.0, 0.0),
                                (0.0, 0.6 * height, 0.0)), lamp)
    gltf.mesh("wide curtain", make_quad((low[0] - 0.1, low[1] - 0.1, -1.5), (width + 0.2, 0.0, 0.0), (0.0, height + 0.2, 0.0)), CURTAIN)


def main():
    parser = glb.make_parser("Writes brushed metal, films, cloth, curtains and dispersive glass side by side.")
    parser.add_argument("--light", choices=SPACING, default="room")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-surfaces.py", arguments.light)
    spacing, views, shapes = SPACING[arguments.light], [], {}
    places = [(spacing * (i % COLUMNS), -spacing * (i // COLUMNS), 0.0) for i in range(len(SURFACES))]
    for place, (shape, surface) in zip(places, SURFACES):
        name = surface["name"]
        if shape not in shapes:
            shapes[shape] = gltf.json["meshes"][gltf.add_mesh(name, MESHES[shape](), surface)]["primitives"][0]
        else:
            gltf.json["meshes"].append({"name": name, "primitives": [dict(shapes[shape], material=gltf.material(surface))]})
        gltf.node({"name": name, "mesh": len(gltf.json["meshes"]) - 1, "translation": list(place)})
        behind = name.endswith("from behind") and arguments.light != "room"
        views.append(((place[0], place[1], -DISTANCE if behind else DISTANCE), place))
    yfov = 2.0 * math.atan(RADIUS / math.sqrt(DISTANCE * DISTANCE - RADIUS * RADIUS) / FILL)
    if arguments.light == "even":
        gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"radiance": WHITE}}}
    elif arguments.light == "sky":
        path = os.path.splitext(arguments.out)[0] + "-sky.hdr"
        gltf.json["scenes"][0]["extras"] = {"reframe": {"environment": {"map": os.path.basename(path)}}}
        write_hdr(path, MAP[0], MAP[1], sky)
    elif arguments.light == "sun":
        gltf.light("sun", {"type": "directional", "intensity": 3.0, "color": WHITE}, SUN, (0.0, 0.0, 0.0))
    else:
        put_room(gltf, places, spacing)
    gltf.camera(views, yfov)
    glb.save("make-surfaces.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
