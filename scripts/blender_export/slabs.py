"""Panes that are modelled as thin boxes: two parallel walls of glass, which together bend nothing."""
import bpy
import numpy
from mathutils import Vector, geometry
from mathutils.bvhtree import BVHTree

THIN = 0.02  # of the root of a wall's area, at most
RIM = 0.2  # of a wall's area, at most, are the faces between the two
TOUCHED = 0.3  # of points of the walls, at most, may lie on something or in it: rims are held by frames
MOST_FACES = 20000  # of a mesh that is looked at
trees = {}  # of the faces of objects, by name


def islands(faces):
    """Lists of the numbers of faces that hang together; `faces` gives the vertices of each."""
    parent = {}

    def root(v):
        while parent.setdefault(v, v) != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    for vertices in faces:
        for v in vertices[1:]:
            parent[root(v)] = root(vertices[0])
    found = {}
    for number, vertices in enumerate(faces):
        found.setdefault(root(vertices[0]), []).append(number)
    return list(found.values())


def walls_of(polygons, points):
    """The faces of the two walls, if these are two parallel walls, close to each other, and the rims between them; with the
    distance of the walls."""
    normal = numpy.array(max(polygons, key=lambda p: p.area).normal)
    heights = points[sorted({v for p in polygons for v in p.vertices})] @ normal
    low, high = heights.min(), heights.max()
    areas, walls = {1: 0.0, -1: 0.0, 0: 0.0}, []
    for p in polygons:
        cosine = float(numpy.dot(normal, p.normal))
        side = 0 if abs(cosine) <= 0.999 else 1 if cosine > 0.0 else -1
        areas[side] += p.area
        if side != 0:
            if numpy.abs(points[list(p.vertices)] @ normal - (high if side == 1 else low)).max() > 0.01 * (high - low) + 1e-7:
                return None, 0.0
            walls.append(p)
    is_slab = abs(areas[1] - areas[-1]) < 0.01 * areas[1] and areas[0] < RIM * areas[1] and high - low < THIN * areas[1] ** 0.5
    return (walls, high - low) if is_slab else (None, 0.0)


def points_of(walls, points):
    """Points and normals all over faces, their number by area."""
    step = (sum(p.area for p in walls) / 200.0) ** 0.5
    for p in walls:
        corners = [Vector(points[v]) for v in p.vertices]
        for i, j, k in geometry.tessellate_polygon([corners]):
            a, b, c = corners[i], corners[j], corners[k]
            n = max(1, round(((b - a).cross(c - a).length / 2.0) ** 0.5 / step))
            for u in range(n):
                for v in range(n):
                    x, y = ((u + 0.5) / n) ** 0.5, (v + 0.5) / n
                    yield a + (b - a) * (x * (1.0 - y)) + (c - a) * (x * y), Vector(p.normal)


def tree_of(o):
    """What casts rays of the world, from a start to an end, at an object."""
    if o.name not in trees:
        trees[o.name] = BVHTree.FromObject(o, bpy.context.evaluated_depsgraph_get())
    tree, inverse = trees[o.name], o.matrix_world.inverted_safe()
    return lambda start, end: hits(tree, inverse @ start, inverse @ end)


def hits(tree, start, end):
    return tree.ray_cast(start, end - start, (end - start).length)[0] is not None


def bounds(o):
    corners = numpy.array([o.matrix_world @ Vector(c) for c in o.bound_box])
    return corners.min(axis=0), corners.max(axis=0)


def is_near(a, b, margin):
    return bool((a[0] <= b[1] + margin).all() and (b[0] <= a[1] + margin).all())


def is_touched(walls, points, thickness, others):
    """Does something lie on the walls, or between them? Then light that it scatters is in the glass."""
    count, touched = 0, 0
    for at, normal in points_of(walls, points):
        count += 1
        # from within the slab, near its other wall, through this one
        start, end = at - normal * (0.99 * thickness), at + normal * (0.05 * thickness)
        touched += any(cast(start, end) for cast in others)
    return touched > TOUCHED * count


def has_slabs(o, material):
    """Is all that has a material of an object such slabs, which nothing touches?"""
    if len(o.data.polygons) > MOST_FACES:
        return False
    mesh = o.data.copy()
    mesh.transform(o.matrix_world)
    if o.matrix_world.determinant() < 0.0:
        mesh.flip_normals()
    points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", points)
    found = all_slabs(o, mesh, points.reshape(-1, 3).astype(numpy.float64), material)
    bpy.data.meshes.remove(mesh)
    return found


def all_slabs(o, mesh, points, material):
    slots = {i for i, slot in enumerate(o.material_slots) if slot.material == material}
    polygons = [p for p in mesh.polygons if p.material_index in slots]
    parts = [[polygons[i] for i in part] for part in islands([list(p.vertices) for p in polygons])]
    slabs = [walls_of(part, points) for part in parts]
    if not slabs or any(walls is None for walls, _ in slabs):
        return False
    here = bounds(o)
    others = [tree_of(other) for other in bpy.context.scene.objects if other.type == "MESH" and other != o and
              other.data.polygons and is_near(here, bounds(other), 0.05 * max(thickness for _, thickness in slabs))]
    for part, (walls, thickness) in zip(parts, slabs):
        if is_touched(walls, points, thickness, others + faces_but(mesh, points, {p.index for p in part})):
            return False
    return True


def faces_but(mesh, points, own):
    """What casts rays at all other faces of a mesh, if there are others."""
    faces = [p.vertices for p in mesh.polygons if p.index not in own]
    tree = BVHTree.FromPolygons([Vector(p) for p in points], faces) if faces else None
    return [] if tree is None else [lambda start, end: hits(tree, start, end)]
