"""What goes into the .glb besides the exporter's own: the map of the sky, and the warnings."""
import os
import struct
import tempfile

from .messages import warnings

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
