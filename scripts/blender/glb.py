"""Blender's glTF exporter, and what is put right in the .glb afterwards."""
import json
import os
import struct
import tempfile

import bpy
import numpy

from .gloss import CLEARCOAT
from .materials import patches
from .messages import warnings
from .versions import offered

if not hasattr(numpy, "bool"):
    numpy.bool = bool  # the exporter of Blender 3.4 uses a name that numpy 1.24 has removed


def export(path):
    operator = bpy.ops.export_scene.gltf
    operator(
        filepath=path, export_format="GLB", export_cameras=True, export_lights=True, export_extras=True, export_apply=True,
        use_renderable=True,  # skips objects hidden from render: cutters, targets, parents
        export_yup=True, export_animations=True, export_frame_range=True, export_force_sampling=False,
        # glTF multiplies by vertex colours whether the material uses them or not: they are baked
        **offered(operator, export_colors=False, export_vertex_color="NONE",
                  convert_lighting_mode="COMPAT", export_import_convert_lighting_mode="COMPAT"))


def read(path):
    """The JSON of a .glb, and all that follows it as bytes."""
    with open(path, "rb") as file:
        data = file.read()
    end = 20 + struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:end]), data[end:]


def write(path, gltf, rest):
    text = json.dumps(gltf, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON"))
        file.write(text + rest)


def restore_booleans(gltf):
    """Custom properties have no booleans, which Reframe's `visible` needs."""
    for scene in gltf.get("scenes", []):
        environment = scene.get("extras", {}).get("reframe", {}).get("environment", {})
        if isinstance(environment.get("visible"), int):
            environment["visible"] = bool(environment["visible"])


def add_extensions(gltf):
    """The extensions of materials that the exporter cannot write."""
    used = set(gltf.get("extensionsUsed", []))
    for material in gltf.get("materials", []):
        patch = patches.get(material.get("name"), {})
        material["name"] = patch.get("name", material.get("name"))
        if patch.get("extensions"):
            material.setdefault("extensions", {}).update(patch["extensions"])
            used.update(patch["extensions"])
        coat = material.get("extensions", {}).get("KHR_materials_clearcoat")
        if coat is not None:
            coat["clearcoatFactor"] = CLEARCOAT * coat.get("clearcoatFactor", 0.0)
        if patch.get("base") is not None:
            factor, summand = patch["base"]
            part = material.setdefault("pbrMetallicRoughness", {})
            colour = part.get("baseColorFactor", [1.0] * 4)
            added = (0.0,) * 3 if "baseColorTexture" in part else summand
            part["baseColorFactor"] = [min(max(c * factor + x, 0.0), 1.0) for c, x in zip(colour, added)] + [colour[3]]
        if "extras" in patch:
            material.setdefault("extras", {}).update(patch["extras"])
    if used:
        gltf["extensionsUsed"] = sorted(used)


def add_shot(gltf, shot):
    """Size, rate, what moves, and the camera's path (extras that src/scene/gltf/gltf_shot.c reads)."""
    for scene in gltf.get("scenes", []):
        own = scene.setdefault("extras", {}).setdefault("reframe", {})
        own.setdefault("render", shot["render"])
        if shot["moving"]:
            own["moving"] = shot["moving"]
    for node in gltf.get("nodes", []):
        if "camera" in node and node.get("name") == shot["camera"]:
            node.setdefault("extras", {})["reframe"] = {"path": shot["path"]}


def add_instances(gltf, rest, placed):
    """Places the meshes of nodes by EXT_mesh_gpu_instancing; returns the binary chunk with the places."""
    data = bytearray(rest[8:8 + struct.unpack("<I", rest[:4])[0]]) if rest else bytearray()
    for node in gltf.get("nodes", []):
        matrices = placed.get(node.get("name"))
        if matrices is None or "mesh" not in node:
            continue
        parts = [m.decompose() for m in matrices]
        columns = {"TRANSLATION": ("VEC3", [(p.x, p.z, -p.y) for p, _, _ in parts]),
                   "ROTATION": ("VEC4", [(q.x, q.z, -q.y, q.w) for _, q, _ in parts]),
                   "SCALE": ("VEC3", [(s.x, s.z, s.y) for _, _, s in parts])}
        attributes = {}
        for name, (kind, values) in columns.items():
            data += b"\0" * (-len(data) % 4)
            numbers = numpy.array(values, numpy.float32)
            gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": numbers.nbytes})
            gltf["accessors"].append({"bufferView": len(gltf["bufferViews"]) - 1, "componentType": 5126, "type": kind,
                                      "count": len(values)})
            attributes[name] = len(gltf["accessors"]) - 1
            data += numbers.tobytes()
        node.setdefault("extensions", {})["EXT_mesh_gpu_instancing"] = {"attributes": attributes}
        gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "EXT_mesh_gpu_instancing"})
    if not data:
        return rest
    gltf["buffers"][0]["byteLength"] = len(data)
    data += b"\0" * (-len(data) % 4)
    return struct.pack("<I4s", len(data), b"BIN\0") + bytes(data)


def finish(path, shot, placed):
    """Puts right in the file what the exporter could not write, and adds what it does not know."""
    gltf, rest = read(path)
    restore_booleans(gltf)
    add_shot(gltf, shot)
    add_extensions(gltf)
    rest = add_instances(gltf, rest, placed)
    rest = add_map(gltf, rest)
    add_warnings(gltf)
    write(path, gltf, rest)


# What goes into the .glb besides the exporter's own: the map of the sky, and the warnings.

_folder, _path = None, None  # of the map that waits to be put into the file


def map_path():
    """Where the map is rendered to, until it is embedded."""
    global _folder, _path
    _folder = tempfile.TemporaryDirectory(prefix="reframe-")
    _path = os.path.join(_folder.name, "sky.exr")
    return _path


def append(gltf, rest, data):
    """Adds bytes to the binary chunk; returns what follows the JSON now, and the number of their view."""
    binary = rest[8:8 + struct.unpack("<I", rest[:4])[0]] if rest else b""
    start = len(binary)
    binary += data + b"\0" * (-len(data) % 4)
    buffers = gltf.setdefault("buffers", [])
    if not buffers:
        buffers.append({})
    buffers[0]["byteLength"] = len(binary)
    views = gltf.setdefault("bufferViews", [])
    views.append({"buffer": 0, "byteOffset": start, "byteLength": len(data)})
    return struct.pack("<I4s", len(binary), b"BIN\0") + binary, len(views) - 1


def ours(gltf):
    """The extras that Reframe reads, of the scene that it renders."""
    scene = gltf["scenes"][gltf.get("scene", 0)]
    return scene.setdefault("extras", {}).setdefault("reframe", {})


def add_map(gltf, rest):
    """Puts the map that waits into the file."""
    environment = gltf["scenes"][gltf.get("scene", 0)].get("extras", {}).get("reframe", {}).get("environment", {})
    if _path is None or "map" not in environment:
        return rest
    with open(_path, "rb") as file:
        rest, view = append(gltf, rest, file.read())
    _folder.cleanup()
    del environment["map"]
    environment["bufferView"] = view
    return rest


def add_warnings(gltf):
    """For `reframe info` to repeat."""
    texts = warnings()
    if texts:
        ours(gltf)["export_warnings"] = list(dict.fromkeys(texts))
