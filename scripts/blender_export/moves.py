"""What moves or changes, and stands still in Reframe: everything but the camera."""
import hashlib

import bpy
import numpy

from .messages import list_names, warn

GEOMETRY = ("MESH", "CURVE", "SURFACE", "META", "FONT")


def state_of(o):
    """The transform of an object that is visible or emits, and the settings of a lamp."""
    numbers = [v for row in o.matrix_world for v in row]
    if o.type == "LIGHT":
        numbers += [o.data.energy, *o.data.color, getattr(o.data, "size", 0.0), getattr(o.data, "spot_size", 0.0)]
    return numbers


def shape_of(o):
    """A digest of an evaluated object's own shape."""
    digest = hashlib.md5(repr([tuple(corner) for corner in o.bound_box]).encode())
    if o.type == "MESH":
        points = numpy.empty(3 * len(o.data.vertices), numpy.float32)
        o.data.vertices.foreach_get("co", points)
        digest.update(points.tobytes())
    return digest.digest()


def instances_of(depsgraph):
    """Number and mean place of the instances by the object that makes them."""
    found = {}
    for instance in depsgraph.object_instances:
        if instance.is_instance and instance.parent is not None:
            count, total = found.get(instance.parent.name, (0, numpy.zeros(16)))
            found[instance.parent.name] = count + 1, total + numpy.array(instance.matrix_world).ravel()
    return found


class Watcher:
    """Compares the frames with the first one."""

    def __init__(self, scene):
        self.scene, self.first, self.moving = scene, None, set()
        self.shapes = {}  # by name, of objects whose geometry Blender has updated
        self.instances = None
        self.updated = set()  # names of objects that Blender has made anew for this frame
        bpy.app.handlers.frame_change_post.append(self.collect)

    def collect(self, scene, depsgraph):
        """The list of updates is there only during this call."""
        self.updated = {u.id.name for u in depsgraph.updates if u.is_updated_geometry and isinstance(u.id, bpy.types.Object)}

    def visible(self):
        return [o for o in self.scene.objects if o.type in ("LIGHT", *GEOMETRY) and not o.hide_render]

    def note(self, depsgraph, with_instances):
        now = {o.name: state_of(o.evaluated_get(depsgraph)) for o in self.visible()}
        if self.first is None:
            self.first = now
        self.moving.update(n for n in now
                           if n in self.first and max(abs(a - b) for a, b in zip(now[n], self.first[n])) > 1e-6)
        for name in self.updated & set(now) - self.moving:
            o = self.scene.objects[name]
            if o.type in GEOMETRY:
                self.shapes.setdefault(o.name, set()).add(shape_of(o.evaluated_get(depsgraph)))
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
        names = sorted(self.moving)
        if names:
            warn("%s: moves or changes: taken as in the first frame" % list_names(names))
        return names
