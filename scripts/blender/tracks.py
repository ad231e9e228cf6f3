"""What moves and changes from frame to frame, as channels of a glTF animation with a key for every exported frame.

Blender's exporter writes a scene that stands still; `glb` adds these channels to its file. Names are those of Blender at the time
of the export. Keys are linear, in the seconds that the renderer takes a frame's number for: (number - 1) / rate.
"""
import math

import numpy

from .affine import product
from .glb_data import FLOAT, UNSIGNED_BYTE

WIDTHS = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3", "weights": "SCALAR"}
Y_UP = numpy.array((math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0))  # from Blender's axes to glTF's; quaternions are w, x, y, z here


def as_gltf(places, turns, scales, looks):
    """Places, rotations (w, x, y, z) and scales in Blender's axes as glTF has them. `looks`: of a lamp or a camera, which look along -z
    in both: the axes of its own space stay."""
    x, y, z = numpy.moveaxis(numpy.asarray(places), -1, 0)
    place = numpy.stack((x, z, -y), axis=-1)
    if looks:
        return place, product(Y_UP, numpy.asarray(turns))[..., [1, 2, 3, 0]], numpy.asarray(scales)
    w, x, y, z = numpy.moveaxis(numpy.asarray(turns), -1, 0)
    return place, numpy.stack((x, z, -y, w), axis=-1), numpy.asarray(scales)[..., [0, 2, 1]]


def without_flips(turns):
    """Quaternions whose sign is chosen such that each is near the one before: q and -q turn alike, but nothing between them does."""
    turns = numpy.array(turns, numpy.float64)
    signs = numpy.where((turns[1:] * turns[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    turns[1:] *= numpy.cumprod(signs)[:, None]
    return turns


def kept_keys(values, is_step):
    """Which keys give the same curve: none within a stretch of equal ones."""
    same = (values[1:] == values[:-1]).all(axis=1)
    kept = numpy.ones(len(values), bool)
    kept[1:] = ~same
    if not is_step:
        kept[:-1] |= ~same
    return kept


def names_of(items):
    found = {}
    for i, item in enumerate(items):
        found.setdefault(item.get("name"), []).append(i)
    return found


def free_name(name, names):
    while name in names:
        name += "'"
    return name


def lists_with(gltf, i):
    """The lists of nodes that have one."""
    return [owner[key] for owners, key in ((gltf.get("scenes", []), "nodes"), (gltf["nodes"], "children")) for owner in owners
            if i in owner.get(key, [])]


def add_beside(gltf, i, new):
    for nodes in lists_with(gltf, i):
        nodes.append(new)


class Tracks:
    """`numbers`: the exported frames; `rate`: frames per second as numerator and denominator; `middle`: of the time that the shutter is
    open, in frames from the frame itself. `values` have a row for each frame; those that stand still write nothing."""

    def __init__(self, numbers, rate, middle=0.0):
        self.numbers = list(numbers)
        below = min(numbers[0], 1)  # as cameras.Recorder.path shifts them: frame 1 is at 0 s
        self.seconds = (numpy.array(numbers, numpy.float64) - below) * rate[1] / rate[0]
        # what the renderer shows is what is there in the middle of the shutter's time
        self.switches = numpy.maximum(self.seconds + (max(middle, -0.45) - 0.5) * rate[1] / rate[0], 0.0)
        self.places, self.nodes, self.shown, self.flocks, self.values = {}, {}, {}, {}, []

    def place(self, name, path):
        """The node of an object moves by an affine.Path, in Blender's axes."""
        self.places[name] = {"translation": path.places, "rotation": path.turns, "scale": path.scales}
        if path.inner is not None:
            self.places[name]["inner"] = path.inner

    def flock(self, name, members):
        """Many instances of the mesh of an object that move: pairs of a path and flags of when it is there, or None."""
        self.flocks[name] = members

    def node(self, name, path, values):
        """A property of an object's node in glTF's axes: translation, rotation (x, y, z, w), scale, weights."""
        self.nodes.setdefault(name, {})[path] = values

    def visible(self, name, flags):
        """In which frames the object is there."""
        self.shown[name] = numpy.asarray(flags, bool)

    def follow(self, name, leader, paths=("translation", "rotation", "scale")):
        """An object that takes the place of another moves as that did, and is seen when that was."""
        if leader in self.places and name is not None:
            self.places[name] = {path: values for path, values in self.places[leader].items() if path in paths}
        if leader in self.shown and name is not None:
            self.shown[name] = self.shown[leader]

    def enlarge(self, name, scale, ratios):
        """An object that is scaled in every frame by another factor, on top of how it moves."""
        paths = self.places.setdefault(name, {})
        paths["scale"] = numpy.asarray(paths.get("scale", [scale])) * ratios

    def moves(self, name):
        """Does an object move, or come and go?"""
        return name in self.places or name in self.shown

    def light(self, name, member, values):
        """A property, by its path within KHR_lights_punctual, of the light that lamp data became."""
        self.values.append(("lights", name, member, values))

    def material(self, name, member, values):
        """A property, by its path within the material."""
        self.values.append(("materials", name, member, values))

    def add_flocks(self, gltf, still):
        nodes = gltf.get("nodes", [])
        names = {node.get("name") for node in nodes}
        for i, node in enumerate(list(nodes)):
            name = node.get("name")
            for k, (path, flags) in enumerate(self.flocks.get(name, [])):
                own = name if k == 0 and name not in still else free_name("%s %d" % (name, k + 1), names)
                if own != name:
                    names.add(own)
                    nodes.append({"name": own, **{key: node[key] for key in ("mesh", "extras") if key in node}})
                    add_beside(gltf, i, len(nodes) - 1)
                if name in self.nodes:
                    self.nodes[own] = self.nodes[name]
                self.place(own, path)
                if flags is not None:
                    self.visible(own, flags)

    def write(self, gltf, data, still=()):
        """Adds the channels to what Blender's exporter wrote, before anything in it is renamed. `still`: names of objects some of whose
        instances stand still."""
        writer = Writer(self, gltf, data)
        self.add_flocks(gltf, still)
        nodes = names_of(gltf.get("nodes", []))
        for name, paths in self.places.items():
            for i in nodes.get(name, []):
                writer.add_place(i, paths)
        for name, paths in self.nodes.items():
            for i in nodes.get(name, []):
                for path, values in paths.items():
                    writer.add_node(i, path, values)
        for name, flags in self.shown.items():
            for i in nodes.get(name, []):
                writer.add_visibility(i, flags)
        lights = gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        lists = {"lights": ("/extensions/KHR_lights_punctual/lights", names_of(lights)),
                 "materials": ("/materials", names_of(gltf.get("materials", [])))}
        for kind, name, member, values in self.values:
            root, named = lists[kind]
            for i in named.get(name, []):
                writer.add_pointer("%s/%d/%s" % (root, i, member), values)
        writer.finish()


class Writer:
    def __init__(self, tracks, gltf, data):
        self.tracks, self.gltf, self.data = tracks, gltf, data
        self.channels, self.samplers = [], []
        self.times = {}  # accessors, by which frames have keys and whether they switch
        self.used = set()

    def add(self, target, values, kind, is_step=False):
        """A channel, unless its values are all the same."""
        values = numpy.asarray(values)
        values = values.reshape(len(values), -1)
        if len(values) < 2 or (values == values[0]).all():
            return
        kept = kept_keys(values, is_step)
        output = values[kept].astype(numpy.uint8 if is_step else numpy.float32)
        if kind == "SCALAR":
            output = output.reshape(-1, 1)
        self.samplers.append({"input": self.input_of(kept, is_step), "interpolation": "STEP" if is_step else "LINEAR",
                              "output": self.data.accessor(output, UNSIGNED_BYTE if is_step else FLOAT, kind)})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def input_of(self, kept, is_step):
        key = (kept.tobytes(), is_step)
        if key not in self.times:
            times = (self.tracks.switches if is_step else self.tracks.seconds)[kept].astype(numpy.float32)
            self.times[key] = self.data.accessor(times.reshape(-1, 1), FLOAT, "SCALAR", bounds=True)
        return self.times[key]

    def add_place(self, i, paths):
        """A node of a lamp has other axes than one of a mesh."""
        node = self.gltf["nodes"][i]
        looks = "camera" in node or "KHR_lights_punctual" in node.get("extensions", {})
        names = ("translation", "rotation", "scale")
        still = ((0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (1.0,) * 3)
        values = as_gltf(*(paths.get(name, [other]) for name, other in zip(names, still)), looks)
        if "inner" in paths:  # it turns the node, and all else a parent of it
            outer = len(self.gltf["nodes"])
            for nodes in lists_with(self.gltf, i):
                nodes[nodes.index(i)] = outer
            self.gltf["nodes"].append({"name": node["name"] + " sheared", "children": [i]})
            _, turns, _ = as_gltf(still[:1], paths["inner"], still[2:], looks)
            node.pop("translation", None)
            node.pop("scale", None)
            self.add_node(i, "rotation", turns)
            i = outer
        for name, rows in zip(names, values):
            if name in paths:
                self.add_node(i, name, rows)

    def add_node(self, i, path, values):
        values = numpy.asarray(values, numpy.float64)
        if path == "rotation":
            values = without_flips(values)
        if path != "weights":
            self.gltf["nodes"][i][path] = [float(numpy.float32(v)) for v in values[0]]
        self.add({"node": i, "path": path}, values.astype(numpy.float32), WIDTHS[path])

    def add_visibility(self, i, flags):
        self.gltf["nodes"][i].setdefault("extensions", {})["KHR_node_visibility"] = {"visible": bool(flags[0])}
        self.used.add("KHR_node_visibility")
        self.add_pointer("/nodes/%d/extensions/KHR_node_visibility/visible" % i, flags, is_step=True)

    def add_pointer(self, pointer, values, is_step=False):
        values = numpy.asarray(values, bool if is_step else numpy.float32)
        width = values.shape[1] if values.ndim > 1 else 1
        count = len(self.channels)
        self.add({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}, values,
                 "SCALAR" if width == 1 else "VEC%d" % width, is_step)
        if len(self.channels) > count:
            self.used.add("KHR_animation_pointer")

    def finish(self):
        if self.channels:
            self.gltf.setdefault("animations", []).append({"name": "movement", "channels": self.channels, "samplers": self.samplers})
        if self.used:
            self.gltf["extensionsUsed"] = sorted({*self.gltf.get("extensionsUsed", []), *self.used})
