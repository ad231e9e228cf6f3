"""Faces of one side in one place, which Cycles lets shade each other: a ray leaves the one and meets the other."""
import bpy
import numpy
from mathutils.bvhtree import BVHTree

from . import shapes
from .messages import list_names, warn

LEAST = 1e-4  # of the area of all triangles: smaller ones are not looked at
NEAR = 1e-6  # of the size of the scene: rounding errors of places


def triangles_of(instance):
    """The corners of an object's triangles, in the world."""
    mesh = instance.object.data
    mesh.calc_loop_triangles()
    corners = shapes.array_of(mesh.loop_triangles, "vertices", 3, numpy.int32)
    matrix = numpy.array(instance.matrix_world, numpy.float32)
    return (shapes.positions_of(mesh) @ matrix[:3, :3].T + matrix[:3, 3])[corners].reshape(-1, 3, 3)


def places_on(triangle):
    middle = triangle.mean(axis=0)
    return [middle, *(0.5 * (middle + triangle))]


def partners(tree, i, triangle, normal, near):
    """The triangles that lie where this one does and face the same way, but not within a body."""
    found = set()
    for place in places_on(triangle):
        same = {k for _, other, k, _ in tree.find_nearest_range(place, near) if k != i and other.dot(normal) > 0.999}
        if same - found:
            _, met, _, _ = tree.ray_cast(place + 100.0 * near * normal, normal)
            found |= same if met is None or met.dot(normal) < 0.0 else set()
    return found


def warn_of(objects):
    """`objects`: the names of those that are rendered."""
    parts, names = [], []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if not instance.is_instance and instance.show_self and instance.object.type == "MESH" and instance.object.original.name_full in objects:
            parts.append(triangles_of(instance))
            names += [instance.object.name] * len(parts[-1])
    every = numpy.concatenate(parts) if parts else numpy.empty((0, 3, 3))
    cross = numpy.cross(every[:, 1] - every[:, 0], every[:, 2] - every[:, 0])
    area = numpy.linalg.norm(cross, axis=1)
    large = numpy.flatnonzero(area > max(LEAST * area.sum(), 1e-12))
    if not len(large):
        return
    corners, normals = every[large].astype(float), cross[large] / area[large, None]
    near = NEAR * float(numpy.abs(corners).max())
    tree = BVHTree.FromPolygons(corners.reshape(-1, 3).tolist(), numpy.arange(3 * len(large)).reshape(-1, 3).tolist(), all_triangles=True)
    found = {names[large[k]] for i in range(len(large)) for k in partners(tree, i, corners[i], normals[i], near)}
    if found:
        warn("%s: faces in one place, which shade each other in Blender: as one here" % list_names(sorted(found)))
