#!/usr/bin/env python3
"""The room with a glossy vase and a zooming camera, as a .glb.

After the test scene of Mendez Feliu, Sbert and Szirmay-Kalos, Reusing Frames
in Camera Animation (WSCG 2006). A closed room of 6 x 3 x 5 m (x, y, z; y up,
the camera looks along -z) with one panel light, a table, a Phong vase, a brushed
metal ball and a coated blue box. Only Python's standard library; the same
arguments give the same bytes.

  make-vase-room.py OUT.glb [--frames N] [--variant lambert|phong|ggx] [--wide]

The camera's path is anim/vase-zoom.json, of which N frames (48) are taken,
evenly from its beginning to its end. --variant gives vase, ball and box the
same kind of material; --wide leads the eye around the vase in steps of 25
degrees, so that neighbours of a group see the highlights at other places.
"""

import argparse
import json
import math
import os
import struct
import sys

FPS = 24
VASE = (0.0, 0.75, -1.3)  # where it stands: on the table
WIDE_STEP = math.radians(25.0)
WIDE_RADIUS = 1.05


# Vectors are tuples of three floats.
def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return (a[0] / length, a[1] / length, a[2] / length)


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


class Mesh:
    """Vertices with normals and UVs, and counter-clockwise triangles."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []

    def vertex(self, position, normal, uv):
        self.positions.append(position)
        self.normals.append(normal)
        self.uvs.append(uv)
        return len(self.positions) - 1

    def quad(self, corner, u, v):
        """A parallelogram; its front is where u x v points to."""
        normal = normalize(cross(u, v))
        first = self.vertex(corner, normal, (0.0, 1.0))
        self.vertex(add(corner, u), normal, (1.0, 1.0))
        self.vertex(add(add(corner, u), v), normal, (1.0, 0.0))
        self.vertex(add(corner, v), normal, (0.0, 0.0))
        for i in (0, 1, 2, 0, 2, 3):
            self.indices.append(first + i)

    def grid(self, points, rows, columns):
        """(rows + 1) x (columns + 1) vertices from points(row, column); the
        triangles that a pole makes collapse are left out."""
        first = len(self.positions)
        for row in range(rows + 1):
            for column in range(columns + 1):
                self.vertex(*points(row, column))
        for row in range(rows):
            for column in range(columns):
                a = first + row * (columns + 1) + column
                b, c, d = a + 1, a + columns + 2, a + columns + 1
                for triangle in ((a, b, c), (a, c, d)):
                    p = [self.positions[i] for i in triangle]
                    if p[0] != p[1] and p[1] != p[2] and p[2] != p[0]:
                        self.indices.extend(triangle)


def make_quad(corner, u, v):
    mesh = Mesh()
    mesh.quad(corner, u, v)
    return mesh


def make_box(size, turn=0.0):
    """A box around the origin, standing at y = 0, turned about y."""
    w, h, d = size
    c, s = math.cos(turn), math.sin(turn)
    x, y, z = (w * c, 0.0, -w * s), (0.0, h, 0.0), (d * s, 0.0, d * c)
    corner = (-0.5 * (x[0] + z[0]), 0.0, -0.5 * (x[2] + z[2]))
    minus = lambda a: (-a[0], -a[1], -a[2])
    mesh = Mesh()
    mesh.quad(add(corner, z), x, y)
    mesh.quad(add(corner, x), minus(x), y)
    mesh.quad(corner, z, y)
    mesh.quad(add(add(corner, x), z), minus(z), y)
    mesh.quad(add(add(corner, y), z), x, minus(z))
    mesh.quad(corner, x, z)
    return mesh


def make_sphere(radius, columns, rows):
    def point(row, column):
        theta, phi = math.pi * row / rows, 2.0 * math.pi * (column % columns) / columns
        ring = 0.0 if row in (0, rows) else math.sin(theta)
        normal = (ring * math.sin(phi), math.cos(theta), ring * math.cos(phi))
        position = tuple(radius * x for x in normal)
        return position, normal, (column / columns, row / rows)

    mesh = Mesh()
    # Rows go down and columns to the right as seen from outside: clockwise.
    mesh.grid(lambda row, column: point(row, columns - column), rows, columns)
    return mesh


# Radius and height of the vase along its wall: from the middle of the foot over
# belly, neck and lip to the inside, back down to the middle of its bottom.
VASE_PROFILE = (
    (0.0, 0.0), (0.07, 0.001), (0.108, 0.025), (0.155, 0.1), (0.185, 0.19), (0.165, 0.28), (0.1, 0.36),
    (0.066, 0.42), (0.076, 0.475), (0.104, 0.508), (0.104, 0.522), (0.09, 0.517), (0.066, 0.478), (0.054, 0.42),
    (0.088, 0.355), (0.152, 0.277), (0.172, 0.19), (0.143, 0.105), (0.09, 0.032), (0.0, 0.018),
)


def profile_point(t):
    """Point and derivative of the Catmull-Rom curve through VASE_PROFILE, t in
    [0, 1]. Beyond the axis the curve is mirrored, so it meets it at right angles."""
    n = len(VASE_PROFILE) - 1
    x = t * n
    i = min(int(x), n - 1)
    x -= i
    p1, p2 = VASE_PROFILE[i], VASE_PROFILE[i + 1]
    p0 = VASE_PROFILE[i - 1] if i > 0 else (-VASE_PROFILE[1][0], VASE_PROFILE[1][1])
    p3 = VASE_PROFILE[i + 2] if i + 2 <= n else (-VASE_PROFILE[n - 1][0], VASE_PROFILE[n - 1][1])
    point, slope = [], []
    for a, b, c, d in zip(p0, p1, p2, p3):
        k1, k2, k3 = 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c)
        point.append(b + x * (k1 + x * (k2 + x * k3)))
        slope.append(k1 + x * (2.0 * k2 + x * 3.0 * k3))
    return point, slope


def make_vase(columns, rows):
    def point(row, column):
        (radius, height), (dr, dh) = profile_point(row / rows)
        pole = row in (0, rows)
        radius = 0.0 if pole else radius
        phi = 2.0 * math.pi * (column % columns) / columns
        s, c = math.sin(phi), math.cos(phi)
        if pole:
            normal = (0.0, -1.0 if row == 0 else 1.0, 0.0)
        else:
            normal = normalize((dh * s, -dr, dh * c))
        return (radius * s, height, radius * c), normal, (column / columns, 1.0 - row / rows)

    mesh = Mesh()
    mesh.grid(point, rows, columns)
    return mesh


def material(name, color, metallic=0.0, roughness=1.0, specular=None, phong=None, emissive=None, strength=1.0,
             double_sided=True):
    result = {"name": name, "pbrMetallicRoughness": {
        "baseColorFactor": list(color) + [1.0], "metallicFactor": metallic, "roughnessFactor": roughness}}
    if double_sided:
        result["doubleSided"] = True
    extensions = {}
    if specular is not None:
        extensions["KHR_materials_specular"] = {"specularFactor": specular}
    if emissive is not None:
        result["emissiveFactor"] = list(emissive)
        extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    if extensions:
        result["extensions"] = extensions
    if phong is not None:
        diffuse, lobe, exponent = phong
        result["extras"] = {"reframe": {"bsdf": "phong", "diffuse": diffuse, "specular": lobe, "exponent": exponent}}
    return result


def lambert(name, color):
    return material(name, color, specular=0.0)


def phong(name, diffuse, lobe, exponent):
    # For other programs: the roughness whose GGX lobe is about as wide.
    roughness = round(math.sqrt(math.sqrt(2.0 / (exponent + 2.0))), 3)
    return material(name, diffuse, roughness=roughness, phong=(diffuse, lobe, exponent))


def object_materials(variant):
    """Vase, ball and box: as they are, or all of one kind."""
    kinds = {
        "lambert": (lambert("vase", [0.5, 0.16, 0.12]), lambert("ball", [0.75, 0.45, 0.3]),
                    lambert("box", [0.08, 0.16, 0.5])),
        "phong": (phong("vase", [0.25, 0.08, 0.06], [0.55, 0.55, 0.55], 60),
                  phong("ball", [0.1, 0.05, 0.03], [0.75, 0.5, 0.35], 20),
                  phong("box", [0.05, 0.1, 0.4], [0.3, 0.3, 0.3], 40)),
        "ggx": (material("vase", [0.3, 0.09, 0.07], roughness=0.3),
                material("ball", [0.95, 0.64, 0.54], metallic=1.0, roughness=0.3),
                material("box", [0.06, 0.14, 0.5], roughness=0.25)),
    }
    if variant is not None:
        return kinds[variant]
    return kinds["phong"][0], kinds["ggx"][1], kinds["ggx"][2]


def make_room():
    """(name, mesh, material): quads whose fronts look into the room."""
    x, y, z = (6.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 5.0)
    minus_x, minus_z = (-6.0, 0.0, 0.0), (0.0, 0.0, -5.0)
    return [
        ("floor", make_quad((-3.0, 0.0, 2.5), x, minus_z), lambert("floor", [0.45, 0.3, 0.18])),
        ("ceiling", make_quad((-3.0, 3.0, -2.5), x, z), lambert("ceiling", [0.7, 0.7, 0.7])),
        ("back wall", make_quad((-3.0, 0.0, -2.5), x, y), lambert("back wall", [0.65, 0.62, 0.56])),
        ("left wall", make_quad((-3.0, 0.0, 2.5), minus_z, y), lambert("left wall", [0.6, 0.2, 0.15])),
        ("right wall", make_quad((3.0, 0.0, -2.5), z, y), lambert("right wall", [0.14, 0.42, 0.4])),
        ("front wall", make_quad((3.0, 0.0, 2.5), minus_x, y), lambert("front wall", [0.5, 0.5, 0.5])),
        ("light", make_quad((-0.3, 2.95, -1.2), (1.2, 0.0, 0.0), (0.0, 0.0, 1.2)),
         material("light", [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 0.93, 0.82], strength=12.0,
                  double_sided=False)),
    ]


def make_objects(variant):
    """(name, mesh, material, places): a place for each instance."""
    vase, ball, box = object_materials(variant)
    wood = lambert("table", [0.36, 0.22, 0.12])
    legs = [(sx * 0.65, 0.0, VASE[2] + sz * 0.36) for sx in (-1, 1) for sz in (-1, 1)]
    return [
        ("table top", make_box((1.4, 0.05, 0.82)), wood, [(0.0, 0.7, VASE[2])]),
        ("table leg", make_box((0.06, 0.7, 0.06)), wood, legs),
        ("vase", make_vase(96, 64), vase, [VASE]),
        ("ball", make_sphere(0.28, 64, 32), ball, [(0.98, 0.28, -0.62)]),
        ("box", make_box((0.2, 0.16, 0.16), math.radians(28.0)), box, [(-0.42, 0.75, -1.16)]),
    ]


def read_path(file_name, frames):
    """Eye and target of each frame, evenly over the keys' time, and yfov; of
    paths with linear keys and one target only, as vase-zoom.json is."""
    with open(file_name, encoding="utf-8") as file:
        path = json.load(file)
    keys = path["keys"]
    start, end = keys[0]["time"], keys[-1]["time"]
    views, k = [], 0
    for frame in range(frames):
        time = start + (end - start) * (frame / (frames - 1) if frames > 1 else 0.0)
        while k + 2 < len(keys) and keys[k + 1]["time"] <= time:
            k += 1
        a, b = keys[k], keys[k + 1]
        t = min((time - a["time"]) / (b["time"] - a["time"]), 1.0)
        views.append((mix(a["position"], b["position"], t), tuple(path["target"])))
    return views, math.radians(path["fov"])


def wide_path(frames):
    target = add(VASE, (0.0, 0.27, 0.0))
    views = []
    for frame in range(frames):
        angle = frame * WIDE_STEP
        views.append((add(target, (WIDE_RADIUS * math.sin(angle), 0.3, WIDE_RADIUS * math.cos(angle))), target))
    return views


def look_rotation(eye, target):
    """Quaternion x y z w of a camera that looks along -z, +y up."""
    back = normalize(sub(eye, target))
    right = normalize(cross((0.0, 1.0, 0.0), back))
    up = cross(back, right)
    m = [[right[i], up[i], back[i]] for i in range(3)]
    # Shepperd: from the largest of the four squares, so nothing cancels.
    squares = (m[0][0] - m[1][1] - m[2][2], m[1][1] - m[0][0] - m[2][2], m[2][2] - m[0][0] - m[1][1],
               m[0][0] + m[1][1] + m[2][2])
    big = squares.index(max(squares))
    q = [0.0] * 4
    q[big] = 0.5 * math.sqrt(1.0 + squares[big])
    f = 0.25 / q[big]
    if big == 3:
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            q[i] = f * (m[k][j] - m[j][k])
    else:
        i, j, k = ((0, 1, 2), (1, 2, 0), (2, 0, 1))[big]
        q[3] = f * (m[k][j] - m[j][k])
        q[j] = f * (m[j][i] + m[i][j])
        q[k] = f * (m[k][i] + m[i][k])
    return q


class Gltf:
    """Collects the parts of a file and writes them as GLB."""

    def __init__(self):
        self.binary = bytearray()
        self.materials = {}
        self.json = {"asset": {"version": "2.0", "generator": "reframe scenes/make-vase-room.py"}, "scene": 0,
                     "scenes": [{"name": "vase room", "nodes": []}], "nodes": [], "cameras": [], "animations": [],
                     "materials": [], "meshes": [], "accessors": [], "bufferViews": [], "buffers": []}

    def accessor(self, values, kind, component=5126, target=None, bounds=False):
        """values: tuples of floats (5126), or plain indices (5125)."""
        floats = component == 5126
        flat = [x for value in values for x in value] if floats else values
        data = struct.pack("<%d%s" % (len(flat), "f" if floats else "I"), *flat)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.binary += data
        self.json["bufferViews"].append(view)
        result = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component, "count": len(values),
                  "type": kind}
        if bounds:
            stored = struct.unpack("<%df" % len(flat), data)
            width = len(values[0])
            result["min"] = [min(stored[i::width]) for i in range(width)]
            result["max"] = [max(stored[i::width]) for i in range(width)]
        self.json["accessors"].append(result)
        return len(self.json["accessors"]) - 1

    def material(self, description):
        name = description["name"]
        if name not in self.materials:
            self.materials[name] = len(self.json["materials"])
            self.json["materials"].append(description)
        return self.materials[name]

    def node(self, description):
        self.json["nodes"].append(description)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return len(self.json["nodes"]) - 1

    def mesh(self, name, mesh, description, places):
        attributes = {"POSITION": self.accessor(mesh.positions, "VEC3", target=34962, bounds=True),
                      "NORMAL": self.accessor(mesh.normals, "VEC3", target=34962),
                      "TEXCOORD_0": self.accessor(mesh.uvs, "VEC2", target=34962)}
        primitive = {"attributes": attributes, "indices": self.accessor(mesh.indices, "SCALAR", 5125, 34963),
                     "material": self.material(description)}
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        for i, place in enumerate(places):
            node = {"name": name if len(places) == 1 else "%s %d" % (name, i + 1),
                    "mesh": len(self.json["meshes"]) - 1}
            if any(place):
                node["translation"] = list(place)
            self.node(node)

    def camera(self, views, yfov):
        rotations = []
        for eye, target in views:
            q = look_rotation(eye, target)
            # Of the two signs, the one next to the frame before: interpolation takes the short way.
            if rotations and sum(a * b for a, b in zip(q, rotations[-1])) < 0.0:
                q = [-x for x in q]
            rotations.append(q)
        self.json["cameras"].append({"name": "Camera", "type": "perspective",
                                     "perspective": {"yfov": yfov, "znear": 0.01}})
        node = self.node({"name": "Camera", "camera": 0, "translation": list(views[0][0]), "rotation": rotations[0]})
        times = self.accessor([(i / FPS,) for i in range(len(views))], "SCALAR", bounds=True)
        outputs = (self.accessor([view[0] for view in views], "VEC3"), self.accessor(rotations, "VEC4"))
        self.json["animations"].append({
            "name": "Camera path",
            "samplers": [{"input": times, "output": output, "interpolation": "LINEAR"} for output in outputs],
            "channels": [{"sampler": i, "target": {"node": node, "path": path}}
                         for i, path in enumerate(("translation", "rotation"))]})

    def write(self, file_name):
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        used = sorted({name for m in self.json["materials"] for name in m.get("extensions", {})})
        self.json["extensionsUsed"] = used
        text = json.dumps(self.json, separators=(",", ":")).encode("utf-8")
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.binary)
        with open(file_name, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, size))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary)


def main():
    parser = argparse.ArgumentParser(description="Writes the room with a glossy vase and a zooming camera.")
    parser.add_argument("out", metavar="OUT.glb")
    parser.add_argument("--frames", type=int, default=48, help="frames of the camera's path, at 24 per second (48)")
    parser.add_argument("--variant", choices=("lambert", "phong", "ggx"), help="vase, ball and box all of this kind")
    parser.add_argument("--wide", action="store_true", help="eyes 25 degrees apart, around the vase")
    arguments = parser.parse_args()
    if not 1 <= arguments.frames <= 100000:
        parser.error("--frames: wants a whole number from 1 to 100000")
    here = os.path.dirname(os.path.abspath(__file__))
    views, yfov = read_path(os.path.join(here, os.pardir, "anim", "vase-zoom.json"), arguments.frames)
    if arguments.wide:
        views = wide_path(arguments.frames)
    gltf = Gltf()
    for name, mesh, description in make_room():
        gltf.mesh(name, mesh, description, [(0.0, 0.0, 0.0)])
    for name, mesh, description, places in make_objects(arguments.variant):
        gltf.mesh(name, mesh, description, places)
    gltf.camera(views, yfov)
    try:
        gltf.write(arguments.out)
    except OSError as error:
        sys.exit("make-vase-room.py: %s: %s" % (arguments.out, error.strerror))


if __name__ == "__main__":
    main()
