"""What moves or changes, and stands still in Reframe: everything but the camera."""
import hashlib

import bpy
import numpy

from . import hiding
from .messages import list_names, warn

GEOMETRY = ("MESH", "CURVE", "SURFACE", "META", "FONT")
LAMP = ("energy", "size", "size_y", "spread", "spot_size", "spot_blend", "shadow_soft_size", "angle")  # each for some kinds


def state_of(o):
    """The transform of an object that is visible or emits, and the settings of a lamp."""
    numbers = [v for row in o.matrix_world for v in row]
    if o.type == "LIGHT":
        numbers += [*o.data.color, *(getattr(o.data, name, 0.0) for name in LAMP)]
    return numbers


def carried_by(mesh):
    """Texture coordinates, colours and other attributes, and the materials of faces: each with a name and the length of its values."""
    kinds = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3), "FLOAT2": ("vector", 2),
             "FLOAT": ("value", 1), "INT": ("value", 1)}
    found = [(layer.data, "uv", 2) for layer in mesh.uv_layers] + [(mesh.polygons, "material_index", 1)]
    return found + [(a.data, *kinds[a.data_type]) for a in mesh.attributes if a.data_type in kinds and a.name != "position"]


def shape_of(o):
    """A digest of an evaluated object's own shape, and of what its vertices, corners and faces carry for materials."""
    digest = hashlib.md5(repr([tuple(corner) for corner in o.bound_box]).encode())
    if o.type == "MESH":
        points = numpy.empty(3 * len(o.data.vertices), numpy.float32)
        o.data.vertices.foreach_get("co", points)
        digest.update(points.tobytes())
        for values, name, width in carried_by(o.data):
            numbers = numpy.empty(width * len(values), numpy.float32)
            values.foreach_get(name, numbers)
            digest.update(numbers.tobytes())
    return digest.digest()


def instances_of(depsgraph):
    """Number and mean place of the instances by the object that makes them."""
    found = {}
    for instance in depsgraph.object_instances:
        if instance.is_instance and instance.parent is not None:
            count, total = found.get(instance.parent.name, (0, numpy.zeros(16)))
            found[instance.parent.name] = count + 1, total + numpy.array(instance.matrix_world).ravel()
    return found


def is_shown(o):
    """Is it an object that is seen, emits, or makes instances?"""
    return o.type in ("LIGHT", *GEOMETRY) or o.instance_type != "NONE"


class Watcher:
    """Compares the frames with the first one; `view_layer` shows what is rendered."""

    def __init__(self, scene, view_layer):
        self.scene, self.first, self.moving = scene, None, set()
        # what is hidden by its collection is so in all frames
        self.objects = [o for o in view_layer.objects if is_shown(o) and (o.visible_get() or o.hide_render)]
        self.hidden = set()  # names of those that are hidden in some frames
        self.shapes = {}  # by name, of objects whose geometry Blender has updated
        self.instances = None
        self.updated = set()  # names of objects that Blender has made anew for this frame
        bpy.app.handlers.frame_change_post.append(self.collect)

    def collect(self, scene, depsgraph):
        """The list of updates is there only during this call."""
        self.updated |= {u.id.name for u in depsgraph.updates if u.is_updated_geometry and isinstance(u.id, bpy.types.Object)}

    def note(self, depsgraph, with_instances):
        now = {o.name: state_of(o.evaluated_get(depsgraph)) for o in self.objects if not o.hide_render}
        if self.first is None:
            self.first = now
            self.moving = {o.name for o in self.objects if o.name in now and hiding.changes_in_renders(o)}
        self.hidden |= set(now) ^ set(self.first)
        self.moving.update(n for n in now
                           if n in self.first and max(abs(a - b) for a, b in zip(now[n], self.first[n])) > 1e-6)
        for name in self.updated & set(now) - self.moving:
            o = self.scene.objects[name]
            if o.type in GEOMETRY:
                self.shapes.setdefault(o.name, set()).add(shape_of(o.evaluated_get(depsgraph)))
        self.updated.clear()
        if with_instances:
            found = instances_of(depsgraph)
            self.instances = found if self.instances is None else self.instances
            for name in set(found) | set(self.instances):
                a, b = found.get(name), self.instances.get(name)
                if a is None or b is None or a[0] != b[0] or not numpy.allclose(a[1], b[1], rtol=1e-6, atol=1e-5):
                    self.moving.add(name)

    def finish(self, depsgraph):
        """Called in the first frame again; returns the names, sorted."""
        bpy.app.handlers.frame_change_post.remove(self.collect)
        for name, shapes in self.shapes.items():
            if shapes - {shape_of(self.scene.objects[name].evaluated_get(depsgraph))}:
                self.moving.add(name)
        for names, what in ((self.moving - self.hidden, "moves or changes"), (self.hidden, "hidden in some of the frames")):
            if names:
                warn("%s: %s: taken as in the first frame" % (list_names(sorted(names)), what))
        return sorted(self.moving | self.hidden)
