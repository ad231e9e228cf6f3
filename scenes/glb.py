"""Writes .glb files; shared by the scene scripts of this folder.

Only Python's standard library; the same calls give the same bytes.
"""

import argparse
import json
import math
import struct
import sys

from shapes import cross, mix, normalize, sub

FPS = 24


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


def glass(name):
    """Smooth and clear, of index 1.5, with an inside."""
    result = material(name, [1.0, 1.0, 1.0], roughness=0.0, double_sided=False)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5},
                            "KHR_materials_volume": {"thicknessFactor": 1.0}}
    return result


def look_rotation(eye, target):
    """Quaternion x y z w of a camera that looks along -z, +y up."""
    back = normalize(sub(eye, target))
    right = normalize(cross((0.0, 1.0, 0.0), back))
    up = cross(back, right)
    m = [[right[i], up[i], back[i]] for i in range(3)]
    # Shepperd's method: starts from the largest of the four squares, so nothing cancels.
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
    """Builds a glTF document and writes it as .glb."""

    def __init__(self, script, scene):
        self.binary = bytearray()
        self.materials, self.textures = {}, {}
        self.extensions = []  # used elsewhere than in materials and lights
        self.json = {"asset": {"version": "2.0", "generator": "reframe scenes/" + script}, "scene": 0,
                     "scenes": [{"name": scene, "nodes": []}], "nodes": [], "cameras": [], "animations": [],
                     "materials": [], "meshes": [], "accessors": [], "bufferViews": [], "buffers": []}

    def view(self, data, target=None):
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.binary += data
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, kind, component=5126, target=None, bounds=False):
        """Adds an accessor. values: numbers, or tuples of them: floats (5126), indices (5125) or joints (5123)."""
        flat = [x for value in values for x in value] if kind != "SCALAR" or component == 5126 else values
        data = struct.pack("<%d%s" % (len(flat), {5126: "f", 5125: "I", 5123: "H"}[component]), *flat)
        result = {"bufferView": self.view(data, target), "componentType": component, "count": len(values),
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

    def texture(self, name, png, repeat=True):
        """Adds a texture from the bytes of a PNG; returns its index."""
        if name not in self.textures:
            for key in ("images", "samplers", "textures"):
                self.json.setdefault(key, [])
            self.json["images"].append({"name": name, "mimeType": "image/png", "bufferView": self.view(png)})
            wrap = 10497 if repeat else 33071
            sampler = {"magFilter": 9729, "minFilter": 9729, "wrapS": wrap, "wrapT": wrap}
            if sampler not in self.json["samplers"]:
                self.json["samplers"].append(sampler)
            self.json["textures"].append({"name": name, "source": len(self.json["images"]) - 1,
                                          "sampler": self.json["samplers"].index(sampler)})
            self.textures[name] = len(self.json["textures"]) - 1
        return self.textures[name]

    def node(self, description, parent=None):
        self.json["nodes"].append(description)
        number = len(self.json["nodes"]) - 1
        if parent is None:
            self.json["scenes"][0]["nodes"].append(number)
        else:
            self.json["nodes"][parent].setdefault("children", []).append(number)
        return number

    def light(self, name, description, place, towards):
        """Adds a light of KHR_lights_punctual at a position; spots and suns point at a target."""
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
        lights.append(dict(description, name=name))
        self.node({"name": name, "translation": list(place), "rotation": look_rotation(place, towards),
                   "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})

    def add_mesh(self, name, mesh, description):
        attributes = {"POSITION": self.accessor(mesh.positions, "VEC3", target=34962, bounds=True),
                      "NORMAL": self.accessor(mesh.normals, "VEC3", target=34962),
                      "TEXCOORD_0": self.accessor(mesh.uvs, "VEC2", target=34962)}
        if mesh.tangents:
            attributes["TANGENT"] = self.accessor(mesh.tangents, "VEC4", target=34962)
        primitive = {"attributes": attributes, "indices": self.accessor(mesh.indices, "SCALAR", 5125, 34963),
                     "material": self.material(description)}
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def mesh(self, name, mesh, description, places=((0.0, 0.0, 0.0),)):
        """Adds a mesh with its material, and a node for each of its instances."""
        number = self.add_mesh(name, mesh, description)
        for i, place in enumerate(places):
            node = {"name": name if len(places) == 1 else "%s %d" % (name, i + 1), "mesh": number}
            if any(place):
                node["translation"] = list(place)
            self.node(node)

    def camera(self, views, yfov):
        rotations = []
        for eye, target in views:
            q = look_rotation(eye, target)
            # Choose the sign nearer to the previous frame, so that interpolation takes the shorter arc.
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
        used = {name for m in self.json["materials"] for name in m.get("extensions", {})}
        self.json["extensionsUsed"] = sorted(used.union(self.json.get("extensions", {}), self.extensions))
        self.json = {key: value for key, value in self.json.items() if value != []}  # glTF has no empty arrays
        text = json.dumps(self.json, separators=(",", ":")).encode("utf-8")
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.binary)
        with open(file_name, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, size))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary)


def frame_count(text):
    """Type for argparse: a number of frames."""
    count = int(text) if text.isdecimal() else 0
    if not 1 <= count <= 100000:
        raise argparse.ArgumentTypeError("must be a whole number from 1 to 100000, got '%s'" % text)
    return count


def number_between(low, high, what):
    """The type of an option whose value lies between two numbers; `what` names them and their unit."""
    def read(text):
        value = float(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError("must be %s, got '%s'" % (what, text))
        return value
    read.__name__ = "number"  # in argparse's messages
    return read


def make_parser(description):
    """The arguments common to all scene scripts."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("out", metavar="OUT.glb")
    parser.add_argument("--frames", type=frame_count, metavar="N", default=48,
                        help="frames of the camera's path, at 24 per second (48)")
    return parser


def glide(frames, eyes, targets):
    """Eye and target of each frame on the way from the first to the second of each
    pair, with ease-in and ease-out."""
    views = []
    for frame in range(frames):
        t = frame / (frames - 1) if frames > 1 else 0.0
        t = t * t * (3.0 - 2.0 * t)
        views.append((mix(eyes[0], eyes[1], t), mix(targets[0], targets[1], t)))
    return views


def save(script, gltf, file_name):
    """Writes the file; on failure prints one line and exits with 1."""
    try:
        gltf.write(file_name)
    except OSError as error:
        sys.exit("%s: %s: %s" % (script, file_name, error.strerror))
