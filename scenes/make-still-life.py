#!/usr/bin/env python3
"""Writes a still life of glass, a mirror and rough metal as a .glb.

On a table in a closed room under one large lamp: a solid glass ball, a drinking
glass with a thick bottom, a block of amber that absorbs blue (its colour deepens
with its thickness), a framed mirror and a brushed copper ball. Uses only Python's
standard library; the same arguments give the same bytes.

  make-still-life.py OUT.glb [--frames N] [--no-glass]

--no-glass leaves out the glass bodies, for comparisons with other programs.
"""

import math

import glb
from glb import lambert, material
from shapes import make_box, make_lathe, make_quad, make_room, make_sphere

TABLE = 0.75
LOW, HIGH = (-2.0, 0.0, -1.5), (2.0, 2.7, 2.5)

# Up the outside, over the lip, and down the inside to the bottom of the bowl.
GLASS_PROFILE = (
    (0.0, 0.0), (0.024, 0.0), (0.0295, 0.0012), (0.0315, 0.005), (0.0325, 0.02), (0.034, 0.045), (0.0355, 0.07),
    (0.037, 0.095), (0.0385, 0.12), (0.0393, 0.1335), (0.0387, 0.135), (0.0381, 0.1335), (0.0371, 0.12),
    (0.0352, 0.095), (0.0334, 0.07), (0.0315, 0.045), (0.0295, 0.026), (0.026, 0.0195), (0.018, 0.0175), (0.0, 0.017),
)


def glass(name, ior, color=None, distance=None):
    """A solid glass material; `color` is the transmittance of white light over the given distance."""
    result = material(name, [1.0, 1.0, 1.0], roughness=0.0, double_sided=False)
    volume = {"thicknessFactor": 1.0}
    if color is not None:
        volume.update(attenuationColor=color, attenuationDistance=distance)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                            "KHR_materials_ior": {"ior": ior}, "KHR_materials_volume": volume}
    return result


def add_room(gltf):
    colors = {"floor": [0.3, 0.22, 0.16], "ceiling": [0.75, 0.75, 0.75], "back wall": [0.35, 0.42, 0.45],
              "left wall": [0.6, 0.55, 0.48], "right wall": [0.6, 0.55, 0.48], "front wall": [0.55, 0.5, 0.5]}
    for name, mesh in make_room(LOW, HIGH).items():
        gltf.mesh(name, mesh, lambert(name, colors[name]))
    lamp = material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.94, 0.85], strength=5.0,
                    double_sided=False)
    gltf.mesh("light", make_quad((-1.2, HIGH[1] - 0.05, -1.0), (1.6, 0.0, 0.0), (0.0, 0.0, 1.6)), lamp)
    gltf.mesh("table", make_box((1.8, 0.06, 0.9)), lambert("table", [0.45, 0.4, 0.34]), [(0.0, TABLE - 0.06, -0.3)])
    gltf.mesh("table foot", make_box((0.5, TABLE - 0.06, 0.4)), lambert("table foot", [0.2, 0.14, 0.1]),
              [(0.0, 0.0, -0.3)])


def add_mirror(gltf):
    """Upright at the back of the table, turned a little to the left."""
    turn = math.radians(14.0)
    c, s = math.cos(turn), math.sin(turn)
    middle, width, height = (0.16, TABLE + 0.02, -0.56), 0.42, 0.34
    corner = (middle[0] - 0.5 * width * c, middle[1], middle[2] + 0.5 * width * s)
    mirror = material("mirror", [0.93, 0.94, 0.93], metallic=1.0, roughness=0.0)
    gltf.mesh("mirror", make_quad(corner, (width * c, 0.0, -width * s), (0.0, height, 0.0)), mirror)
    gltf.mesh("frame", make_box((width + 0.05, height + 0.05, 0.02), turn), lambert("frame", [0.16, 0.09, 0.05]),
              [(middle[0] - 0.012 * s, TABLE, middle[2] - 0.012 * c)])


def main():
    parser = glb.make_parser("Writes a still life of glass, a mirror and rough metal.")
    parser.add_argument("--no-glass", action="store_true", help="without the glass bodies")
    arguments = parser.parse_args()
    gltf = glb.Gltf("make-still-life.py", "still life")
    add_room(gltf)
    add_mirror(gltf)
    gltf.mesh("copper ball", make_sphere(0.06, 80, 40),
              material("copper", [0.95, 0.64, 0.54], metallic=1.0, roughness=0.35), [(0.27, TABLE + 0.06, -0.22)])
    gltf.mesh("pear", make_sphere(0.04, 64, 32), lambert("pear", [0.55, 0.5, 0.12]), [(-0.03, TABLE + 0.04, -0.38)])
    gltf.mesh("cup", make_sphere(0.03, 64, 32), material("lacquer", [0.4, 0.03, 0.03], roughness=0.2),
              [(0.13, TABLE + 0.03, -0.14)])
    if not arguments.no_glass:
        # slightly above the table, so that no two surfaces coincide
        stand = TABLE + 0.0005
        gltf.mesh("glass ball", make_sphere(0.065, 128, 64), glass("crystal", 1.5), [(-0.2, stand + 0.065, -0.22)])
        gltf.mesh("drinking glass", make_lathe(GLASS_PROFILE, 96, 120), glass("glass", 1.5), [(0.0, stand, -0.22)])
        gltf.mesh("amber", make_box((0.1, 0.045, 0.07), math.radians(35.0)),
                  glass("amber", 1.55, [0.9, 0.45, 0.08], 0.05), [(-0.1, stand, -0.06)])
    eyes, targets = ((-0.22, 1.12, 0.62), (0.2, 1.04, 0.56)), ((0.03, TABLE + 0.08, -0.28), (0.03, TABLE + 0.08, -0.26))
    gltf.camera(glb.glide(arguments.frames, eyes, targets), math.radians(34.0))
    glb.save("make-still-life.py", gltf, arguments.out)


if __name__ == "__main__":
    main()
