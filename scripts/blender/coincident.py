"""Faces of one side in one place, which Cycles lets shade each other: a ray leaves the one and meets the other."""
import bpy
import numpy
from mathutils.bvhtree import BVHTree

from . import shapes
from .messages import list_names, warn

LEAST = 1e-4  # of the area of all triangles: smaller ones are not looked at
NEAR = 1e-6  # of the size of the scene: rounding errors of places


def triangles_of(o):
    """The corners of an evaluated object's large triangles in the world, their normals times twice their area, and twice the area of all."""
    mesh = o.data
    mesh.calc_loop_triangles()
    corners = shapes.array_of(mesh.loop_triangles, "vertices", 3, numpy.int32)
    matrix = numpy.array(o.matrix_world, numpy.float32)
    every = (shapes.positions_of(mesh) @ matrix[:3, :3].T + matrix[:3, 3])[corners].reshape(-1, 3, 3)
    cross = numpy.cross(every[:, 1] - every[:, 0], every[:, 2] - every[:, 0])
    area = numpy.linalg.norm(cross, axis=1)
    large = area > max(LEAST * area.sum(), 1e-12)
    return every[large], cross[large], float(area.sum())


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
    parts, names = [(numpy.empty((0, 3, 3)), numpy.empty((0, 3)), 0.0)], []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        o = instance.object
        if not instance.is_instance and instance.show_self and o.type == "MESH" and o.original.name_full in objects:
            parts.append(triangles_of(o))
            names += [o.name] * len(parts[-1][0])
    corners, cross = (numpy.concatenate([part[i] for part in parts]).astype(float) for i in (0, 1))
    area = numpy.linalg.norm(cross, axis=1)
    large = numpy.flatnonzero(area > LEAST * sum(part[2] for part in parts))
    corners, normals = corners[large], cross[large] / area[large, None]
    near = NEAR * float(numpy.abs(corners).max(initial=0.0))
    tree = BVHTree.FromPolygons(corners.reshape(-1, 3).tolist(), numpy.arange(3 * len(large)).reshape(-1, 3).tolist(), all_triangles=True)
    found = {names[large[k]] for i in range(len(large)) for k in partners(tree, i, corners[i], normals[i], near)}
    if found:
        warn("%s: faces in one place, which shade each other in Blender: as one here" % list_names(sorted(found)))
