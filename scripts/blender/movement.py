"""What is rendered, frame by frame: which objects and instances are there, and where they stand.

A thing is an object, or an instance by its maker, by what it shows and by Blender's persistent number of it. Only what differs from
the first time that a thing is seen is kept, so that what stands still takes no memory, however many of it there are.
"""
import bpy
import mathutils
import numpy

from . import shapes
from .affine import decompose
from .moves import shape_of

STILL = 2e-7  # of the size of a matrix: what differs less stands still
CHUNK = 1024  # things whose matrices of all frames are in memory at once


def maker_of(instance):
    """The object that makes an instance, or what is no instance itself."""
    return (instance.parent if instance.is_instance else instance.object).original


def shown_by(instance):
    """The object whose shape is seen."""
    return (instance.instance_object if instance.is_instance else instance.object).original


class Shape:
    """What things show: an object's own shape, a lamp, or a mesh of geometry nodes alone."""

    def __init__(self, original, is_lamp, mesh):
        self.original, self.is_lamp, self.mesh = original, is_lamp, mesh
        self.things = []


class Recorder:
    """`seen(instance)` decides on all instances of one maker and one object at once; `recorded` are the exported frames."""

    def __init__(self, recorded, seen):
        self.recorded, self.seen = list(recorded), seen
        self.deforming = shapes.Recorder()
        self.shapes = {}  # by the name of an object, or by maker, object and digest
        self.things = {}  # numbers
        self.instanced = []  # is a thing an instance?
        self.base = numpy.empty((0, 4, 4), numpy.float32)  # matrices as first seen
        self.present, self.moved = [], []  # by frame: flags as bits; numbers and matrices of what is elsewhere than at first
        self.touched, self.updated, self.digests = True, set(), {}
        bpy.app.handlers.frame_change_post.append(self.collect)

    def collect(self, scene, depsgraph):
        """The list of updates is there only during this call."""
        for update in depsgraph.updates:
            if isinstance(update.id, bpy.types.Object) and update.id.type != "CAMERA":
                self.touched = True
                if update.is_updated_geometry:
                    self.updated.add(update.id.original.name_full)

    def note(self, number, depsgraph):
        if not self.touched:
            self.present.append(self.present[-1])
            self.moved.append(self.moved[-1])
            return
        ids, matrices, fresh = self.read(depsgraph)
        self.take(ids, matrices)
        for key in fresh | {name for name in self.updated if name in self.shapes}:
            shape = self.shapes[key]
            if not shape.is_lamp and not is_plain(shape.original):
                self.deforming.note(key, number, shape.original.evaluated_get(depsgraph), depsgraph)
        self.touched = False
        self.updated.clear()

    def read(self, depsgraph):
        """The numbers and matrices of what is seen in a frame, and the names of objects that had not been seen before."""
        instances = depsgraph.object_instances
        count = len(instances)
        matrices, marks = numpy.empty(16 * count, numpy.float32), numpy.empty(8 * count, numpy.int32)
        instances.foreach_get("matrix_world", matrices)
        instances.foreach_get("persistent_id", marks)
        marks = marks.tobytes()
        ids, rows, fresh, known, taken = [], [], set(), {}, set()
        for i, instance in enumerate(instances):
            o, is_instance = instance.object, instance.is_instance
            parent = instance.parent if is_instance else None
            pair = (parent.as_pointer() if is_instance else 0, (instance.instance_object if is_instance else o).as_pointer(),
                    o.data.as_pointer() if o.data is not None else 0, o.type, is_instance or instance.show_self)
            if pair not in known:
                known[pair] = self.know(instance, fresh)
            key = known[pair]
            if key is None:
                continue
            thing = (key, marks[32 * i:32 * i + 32] if is_instance else None)
            while thing in taken:
                thing += (0,)  # twice the same number: told apart by their order
            taken.add(thing)
            ids.append(self.number_of(thing, is_instance))
            rows.append(i)
        return numpy.array(ids, numpy.int64), matrices.reshape(-1, 4, 4)[rows].transpose(0, 2, 1), fresh

    def know(self, instance, fresh):
        """The maker and the shape of some instances; None for those that are not rendered."""
        if not self.seen(instance):
            return None
        o, original = instance.object, shown_by(instance)
        maker = maker_of(instance).name_full
        is_lamp = o.type == "LIGHT"
        is_own = not instance.is_instance or o.data.original == original.data or o.data == instance.instance_object.data
        if is_lamp or is_own:
            key = original.name_full
            mesh = None
        else:
            # meshes of geometry nodes, or what instances show of curves and text
            place = (maker, o.data.as_pointer())
            if place not in self.digests or maker in self.updated or original.name_full in self.updated:
                self.digests[place] = shape_of(o)
            key = (maker, original.name_full, self.digests[place])
            mesh = o.data.copy() if key not in self.shapes else None
        if key not in self.shapes:
            self.shapes[key] = Shape(original, is_lamp, mesh)
            fresh |= {key} if mesh is None else set()
        return maker, key

    def number_of(self, thing, is_instance):
        number = self.things.get(thing)
        if number is None:
            number = self.things[thing] = len(self.things)
            self.instanced.append(is_instance)
            self.shapes[thing[0][1]].things.append(number)
        return number

    def take(self, ids, matrices):
        count, before = len(self.things), len(self.base)
        if count > before:
            self.base = numpy.concatenate((self.base, numpy.empty((count - before, 4, 4), numpy.float32)))
            new = ids >= before
            self.base[ids[new]] = matrices[new]
        flags = numpy.zeros(count, bool)
        flags[ids] = True
        self.present.append(numpy.packbits(flags))
        base = self.base[ids]
        size = numpy.maximum(numpy.abs(base).max(axis=(1, 2), initial=0.0), 1.0)
        elsewhere = numpy.abs(matrices - base).max(axis=(1, 2), initial=0.0) > STILL * size
        self.moved.append((ids[elsewhere], matrices[elsewhere]))

    def finish(self):
        """Called when all frames are noted: finds out what moves, and what comes and goes."""
        bpy.app.handlers.frame_change_post.remove(self.collect)
        self.deforming.finish()
        count = len(self.things)
        self.flags = {}
        every = numpy.zeros((len(self.present), (count + 7) // 8), numpy.uint8)
        for row, bits in zip(every, self.present):
            row[:len(bits)] = bits
        always = numpy.unpackbits(numpy.bitwise_and.reduce(every, axis=0), count=count).astype(bool)
        for i in numpy.flatnonzero(~always):
            self.flags[int(i)] = (every[:, i >> 3] >> (7 - (i & 7)) & 1).astype(bool)
        self.paths = {}
        ids = numpy.unique(numpy.concatenate([numbers for numbers, _ in self.moved]))
        for start in range(0, len(ids), CHUNK):
            chunk = ids[start:start + CHUNK]
            for i, path in zip(chunk, decompose(self.matrices_of(chunk))):
                self.paths[int(i)] = path

    def matrices_of(self, chunk):
        """Of all frames; where a thing is not there, it stays where it was last, or is where it appears."""
        found = numpy.repeat(self.base[chunk][:, None], len(self.moved), axis=1).astype(numpy.float64)
        for frame, (numbers, matrices) in enumerate(self.moved):
            at = numpy.searchsorted(chunk, numbers)
            at[at == len(chunk)] = 0
            mine = chunk[at] == numbers
            found[at[mine], frame] = matrices[mine]
        for row, i in zip(found, chunk):
            if int(i) in self.flags:
                there = numpy.flatnonzero(self.flags[int(i)])
                row[:] = row[there[numpy.maximum(numpy.searchsorted(there, numpy.arange(len(row)), side="right") - 1, 0)]]
        return found

    def matrix(self, number):
        """Where a thing is when it is first seen."""
        return mathutils.Matrix(self.base[number].tolist())

    def path(self, number):
        """How a thing moves; None for what stands still."""
        return self.paths.get(number)

    def rest(self, number):
        """The path of a thing that stands still."""
        return decompose(self.base[number][None, None].astype(numpy.float64))[0]

    def is_still(self, number):
        return number not in self.paths and number not in self.flags

    def meshes(self, shape):
        """Those that a shape has, and flags of the frames in which it has each, or None for all."""
        if shape.mesh is not None or is_plain(shape.original):
            return [(shape.mesh or shape.original.data, None)]
        spans = self.deforming.spans(shape.original.name_full)
        if len(spans) < 2:
            return [(mesh, None) for _, mesh in spans]
        ends = [first for first, _ in spans[1:]] + [self.recorded[-1] + 1]
        numbers = numpy.array(self.recorded)
        return [(mesh, (first <= numbers) & (numbers < end)) for (first, mesh), end in zip(spans, ends)]


def is_plain(o):
    """Is its mesh in the file what is rendered?"""
    return (o.type == "MESH" and not o.modifiers and o.data.shape_keys is None and not o.particle_systems and
            o.parent_type not in ("ARMATURE", "LATTICE"))

