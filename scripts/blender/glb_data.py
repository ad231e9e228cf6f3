"""The parts of a .glb: its JSON, and the binary chunk, to which numbers are appended."""
import json
import struct

FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5121, 5123, 5125


class Data:
    """The binary chunk of a .glb, and its views and accessors in the JSON."""

    def __init__(self, gltf, rest):
        self.gltf = gltf
        self.bytes = bytearray(rest[8:8 + struct.unpack("<I", rest[:4])[0]]) if rest else bytearray()

    def view(self, data):
        """Appends bytes; returns the number of their view."""
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        views = self.gltf.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        return len(views) - 1

    def accessor(self, values, component, kind, bounds=False):
        """Appends rows of numbers of a numpy array, whose type is that of `component`; returns the number of their accessor."""
        accessors = self.gltf.setdefault("accessors", [])
        accessor = {"bufferView": self.view(values.tobytes()), "componentType": component, "type": kind, "count": len(values)}
        if bounds:
            accessor["min"], accessor["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()
        accessors.append(accessor)
        return len(accessors) - 1

    def chunk(self):
        """What follows the JSON in the file."""
        if not self.bytes:
            return b""
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        buffers = self.gltf.setdefault("buffers", [])
        if not buffers:
            buffers.append({})
        buffers[0]["byteLength"] = len(self.bytes)
        return struct.pack("<I4s", len(self.bytes), b"BIN\0") + bytes(self.bytes)


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
