"""Compares a .glb with the .blend that it was exported from, frame by frame: blender -b A.blend -P blender_compare.py -- A.glb [STEP]

Prints "frame N: M of K things differ" for each frame in which something is not where Blender has it, then "compared K things". A thing is
the box around the world-space vertices of an object or instance that is rendered, and for lamps where they are and whither they shine.
"""
import os
import sys

import bpy
import numpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
from blender import glb_data  # noqa: E402
from blender.versions import curve_lists  # noqa: E402

TOLERANCE = 2e-4
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
KINDS = {5126: numpy.float32, 5121: numpy.uint8, 5123: numpy.uint16, 5125: numpy.uint32}


class Film:
    """The nodes of a .glb over time."""

    def __init__(self, path):
        self.gltf, rest = glb_data.read(path)
        self.data = glb_data.Data(self.gltf, rest).bytes
        self.channels = {}
        self.read = {}
        for animation in self.gltf.get("animations", []):
            for channel in animation["channels"]:
                target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
                pointer = target.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer", "")
                key = (int(pointer.split("/")[2]), "visible") if pointer.startswith("/nodes/") else (target.get("node"), target["path"])
                self.channels[key] = sampler

    def array(self, index):
        if index not in self.read:
            accessor = self.gltf["accessors"][index]
            width, kind = WIDTHS[accessor["type"]], KINDS[accessor["componentType"]]
            found = numpy.zeros((accessor["count"], width), kind)
            if "bufferView" in accessor:
                found = self.numbers(accessor["bufferView"], accessor.get("byteOffset", 0), kind, found.size).reshape(-1, width)
            sparse = accessor.get("sparse")
            if sparse is not None:
                rows = self.numbers(sparse["indices"]["bufferView"], 0, KINDS[sparse["indices"]["componentType"]], sparse["count"])
                found = found.copy()
                found[rows] = self.numbers(sparse["values"]["bufferView"], 0, kind, sparse["count"] * width).reshape(-1, width)
            self.read[index] = found
        return self.read[index]

    def numbers(self, view, offset, kind, count):
        start = self.gltf["bufferViews"][view].get("byteOffset", 0) + offset
        return numpy.frombuffer(bytes(self.data[start:start + count * numpy.dtype(kind).itemsize]), kind)

    def value(self, node, path, still, seconds):
        sampler = self.channels.get((node, path))
        if sampler is None:
            return still
        times, values = self.array(sampler["input"])[:, 0].astype(float), self.array(sampler["output"])
        values = values.reshape(len(times), -1).astype(float)
        k = int(numpy.clip(numpy.searchsorted(times, seconds + 1e-5, side="right") - 1, 0, len(times) - 1))
        if k == len(times) - 1 or sampler.get("interpolation") == "STEP" or seconds <= times[k]:
            return values[k]
        t = (seconds - times[k]) / (times[k + 1] - times[k])
        return values[k] * (1.0 - t) + values[k + 1] * t

    def local(self, i, seconds):
        node = self.gltf["nodes"][i]
        place = self.value(i, "translation", node.get("translation", (0, 0, 0)), seconds)
        turn = self.value(i, "rotation", node.get("rotation", (0, 0, 0, 1)), seconds)
        scale = self.value(i, "scale", node.get("scale", (1, 1, 1)), seconds)
        return matrix_of(place, turn, scale)

    def placed(self, seconds):
        """Nodes that are shown, with their world matrices."""
        scene = self.gltf["scenes"][self.gltf.get("scene", 0)]
        left = [(i, numpy.eye(4)) for i in scene["nodes"]]
        while left:
            i, above = left.pop()
            node = self.gltf["nodes"][i]
            shown = node.get("extensions", {}).get("KHR_node_visibility", {}).get("visible", True)
            if not numpy.all(self.value(i, "visible", shown, seconds)):
                continue
            world = above @ self.local(i, seconds)
            yield i, node, world
            left += [(child, world) for child in node.get("children", [])]

    def points(self, i, mesh, seconds):
        found = []
        for primitive in mesh["primitives"]:
            at = self.array(primitive["attributes"]["POSITION"]).astype(float)
            weights = self.value(i, "weights", mesh.get("weights", []), seconds)
            for weight, target in zip(weights, primitive.get("targets", [])):
                at = at + weight * self.array(target["POSITION"])
            found.append(at)
        return numpy.concatenate(found)

    def things(self, seconds):
        for i, node, world in self.placed(seconds):
            if "KHR_lights_punctual" in node.get("extensions", {}):
                yield lamp_of(world)
            if "mesh" not in node:
                continue
            points = self.points(i, self.gltf["meshes"][node["mesh"]], seconds)
            instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes")
            if instances is None:
                yield box_of(points, world)
                continue
            parts = [self.array(instances[name]) for name in ("TRANSLATION", "ROTATION", "SCALE")]
            for place, turn, scale in zip(*parts):
                yield box_of(points, world @ matrix_of(place, turn, scale))


def matrix_of(place, turn, scale):
    x, y, z, w = numpy.array(turn, float) / numpy.linalg.norm(turn)
    m = numpy.eye(4)
    m[:3, :3] = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]) * numpy.array(scale, float)
    m[:3, 3] = place
    return m


def box_of(points, world):
    at = points @ world[:3, :3].T + world[:3, 3]
    return numpy.concatenate((at.min(axis=0), at.max(axis=0)))


def lamp_of(world):
    way = -world[:3, 2]
    return numpy.concatenate((world[:3, 3], way / max(numpy.linalg.norm(way), 1e-9)))


Y_UP = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)


def blenders(depsgraph):
    """What Blender shows, in glTF's axes."""
    points = {}
    for instance in depsgraph.object_instances:
        o, world = instance.object, Y_UP @ numpy.array(instance.matrix_world, float)
        if not (instance.is_instance or instance.show_self):
            continue
        if o.type == "LIGHT" and o.data.type != "AREA":
            yield lamp_of(world)
        if o.type == "MESH" and o.data.polygons:
            key = o.data.as_pointer()
            if key not in points:
                at = numpy.empty(3 * len(o.data.vertices), numpy.float32)
                o.data.vertices.foreach_get("co", at)
                points[key] = at.reshape(-1, 3).astype(float)
            yield box_of(points[key], world)
        if o.type == "LIGHT" and o.data.type == "AREA":
            x, y = 0.5 * o.data.size, 0.5 * (o.data.size_y if o.data.shape in ("RECTANGLE", "ELLIPSE") else o.data.size)
            yield box_of(numpy.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]), world)


def is_hidden(o, number):
    """By its keys: Blender does not evaluate those of what the viewport hides."""
    lists = curve_lists(o.animation_data) if o.animation_data is not None else []
    curve = next((curve for curves in lists for curve in curves if curve.data_path == "hide_render"), None)
    return curve.evaluate(number) > 0.5 if curve is not None else o.hide_render


def unmatched(wanted, found):
    """How many of two lists of things have no partner in the other."""
    if not wanted or not found:
        return len(wanted) + len(found)
    right = numpy.array(found)
    free, missing = numpy.ones(len(right), bool), 0
    for thing in numpy.array(wanted):
        distance = numpy.where(free, numpy.abs(right - thing).max(axis=1), numpy.inf)
        i = distance.argmin()
        if distance[i] > TOLERANCE * (1.0 + numpy.abs(thing).max()):
            missing += 1
        else:
            free[i] = False
    return max(missing, int(free.sum()))


def main():
    path, *step = sys.argv[sys.argv.index("--") + 1:]
    scene = bpy.context.scene
    film = Film(path)
    rate = scene.render.fps / scene.render.fps_base
    for o in bpy.data.objects:
        for modifier in o.modifiers:
            if modifier.show_viewport != modifier.show_render:  # what is set begins simulations anew
                modifier.show_viewport = modifier.show_render
    compared = 0
    for number in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(number)
        if (number - scene.frame_start) % int(step[0] if step else 1) != 0:
            continue
        switched = [o for o in bpy.data.objects if o.hide_viewport != is_hidden(o, number)]
        for o in switched:
            o.hide_viewport = not o.hide_viewport
        if switched:
            scene.frame_set(number)  # what was hidden has not moved
        depsgraph = bpy.context.evaluated_depsgraph_get()
        wanted, found = list(blenders(depsgraph)), list(film.things((number - min(scene.frame_start, 1)) / rate))
        compared += len(wanted)
        missing = unmatched(wanted, found)
        if missing:
            print("frame %d: %d of %d things differ" % (number, missing, len(wanted)))
    print("compared %d things" % compared)


main()
