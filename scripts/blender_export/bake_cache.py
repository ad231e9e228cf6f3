"""Bakes kept on disk, by a hash of what they were made from."""
import hashlib
import os

import bpy
import numpy

from .messages import warn
from .shader_tree import SKIPPED

VERSION = b"reframe bake 2"


def default_folder():
    return os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "reframe", "bake")


class Cache:
    def __init__(self, folder):
        self.folder, self.hits = folder, 0
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as e:
            warn("%s: bakes cannot be kept: %s" % (folder, e.strerror))
            self.folder = None

    def path(self, key):
        return os.path.join(self.folder, key + ".npz")

    def find(self, key):
        if self.folder is None or key is None:
            return None
        try:
            with numpy.load(self.path(key), allow_pickle=False) as file:
                found = {name: file[name].astype(numpy.float32) for name in file.files}
        except (OSError, ValueError, KeyError, EOFError):
            return None
        except Exception:  # a damaged file, of which zipfile has its own exceptions
            return None
        self.hits += 1
        return found if "uv" in found else None

    def keep(self, key, result):
        if self.folder is None or key is None:
            return
        temporary = self.path(key) + ".%d" % os.getpid()
        try:
            with open(temporary, "wb") as file:
                numpy.savez_compressed(file, **{n: v if n == "uv" else v.astype(numpy.float16) for n, v in result.items()})
            os.replace(temporary, self.path(key))
        except OSError as e:
            warn("%s: bakes cannot be kept: %s" % (self.folder, e.strerror))
            self.folder = None

    def tell(self):
        if self.hits > 0:
            print("blender-export: %d from the cache %s" % (self.hits, self.folder), flush=True)


def of_image(image):
    """What identifies the pixels of an image."""
    if image.packed_file is not None:
        return "packed", hashlib.sha256(image.packed_file.data).hexdigest()
    path = bpy.path.abspath(image.filepath, library=image.library)
    try:
        at = os.stat(path)
        return path, at.st_mtime_ns, at.st_size
    except OSError:
        pixels = numpy.empty(len(image.pixels), numpy.float32)
        image.pixels.foreach_get(pixels)
        return "generated", hashlib.sha256(pixels.tobytes()).hexdigest()


def values(thing):
    """What a node, a ramp, a curve is set to, as text."""
    found = []
    for p in thing.bl_rna.properties:
        name = p.identifier
        if name in SKIPPED or name.startswith("bl_"):
            continue
        value = getattr(thing, name, None)
        if p.type == "COLLECTION":
            if name in ("elements", "curves", "points"):
                found.append((name, [values(v) for v in value]))
        elif p.type != "POINTER":
            found.append((name, tuple(value) if getattr(p, "is_array", False) else value))
        elif isinstance(value, bpy.types.Image):
            found.append((name, of_image(value), value.colorspace_settings.name, value.alpha_mode))
        elif isinstance(value, bpy.types.Object):
            found.append((name, value.name, [tuple(row) for row in value.matrix_world]))
        elif isinstance(value, bpy.types.ID):
            found.append((name, value.name_full))
        elif value is not None:
            found.append((name, values(value)))
    return found


def of_tree(tree):
    found = []
    for node in sorted(tree.nodes, key=lambda n: n.name):
        sockets = [(s.identifier, value_text(s)) for s in list(node.inputs) + list(node.outputs)]
        found.append((node.name, node.bl_idname, sockets, values(node)))
    links = sorted((k.from_node.name, k.from_socket.identifier, k.to_node.name, k.to_socket.identifier) for k in tree.links)
    return repr((found, links))


def value_text(socket):
    value = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def array(collection, name, width, kind=numpy.float32):
    found = numpy.empty(len(collection) * width, kind)
    collection.foreach_get(name, found)
    return found.tobytes()


def of_mesh(mesh, digest):
    digest.update(array(mesh.vertices, "co", 3))
    digest.update(array(mesh.loops, "vertex_index", 1, numpy.int32))
    digest.update(array(mesh.polygons, "loop_total", 1, numpy.int32))
    digest.update(array(mesh.polygons, "material_index", 1, numpy.int32))
    digest.update(array(mesh.polygons, "use_smooth", 1, bool))
    for layer in mesh.uv_layers:
        digest.update(repr((layer.name, layer.active_render)).encode())
        digest.update(array(layer.data, "uv", 2))
    widths = {"FLOAT": ("value", 1), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4)}
    for a in mesh.attributes:
        if a.data_type in widths and len(a.data) > 0:
            digest.update(repr((a.name, a.domain)).encode() + array(a.data, *widths[a.data_type]))
    digest.update(repr((tuple(mesh.texspace_location), tuple(mesh.texspace_size))).encode())


def key(o, part, job, size):
    """The name of the bake; None if it depends on more than can be hashed."""
    digest = hashlib.sha256(VERSION + repr((bpy.app.version, size)).encode())
    of_mesh(part, digest)
    for slot, plan in sorted(job.plans.items()):
        if any(n.type in ("SCRIPT", "TEX_POINTDENSITY") for n in plan.copy.node_tree.nodes):
            return None
        digest.update(repr((slot, plan.surface, sorted(plan.baked), sorted(plan.averaged))).encode())
        digest.update(of_tree(plan.copy.node_tree).encode())
    if job.own_place:
        digest.update(repr((o.name, [tuple(row) for row in o.matrix_world], tuple(o.color), o.pass_index)).encode())
    return digest.hexdigest()
