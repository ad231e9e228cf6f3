"""Armatures as skins: a mesh at rest whose vertices follow joints, where that gives every recorded shape.

Whether it does is measured, not deduced from modifiers: volume that is preserved, envelopes, curved bones, and what deforms after
an armature show in positions that are elsewhere.
"""
import numpy

from .affine import decompose
from .glb_data import FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT
from .tracks import free_name

NEAR, NEAR_NORMAL = 1e-4, 1e-2  # of the size, and of 1
MOST = 8  # joints that a vertex follows
LEAST = 1e-4  # the sum of weights below which Blender moves no vertex
Y_UP = numpy.array(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)), numpy.float64)


def armature_of(o):
    """The only one that deforms an object."""
    found = [m.object for m in o.modifiers if m.type == "ARMATURE" and m.show_viewport and m.object is not None]
    if o.parent_type == "ARMATURE" and o.parent is not None and o.parent.type == "ARMATURE":
        found.append(o.parent)
    return found[0] if len(found) == 1 and o.type == "MESH" else None


class Pose:
    """Of the bones that have groups of vertices: what they do to vertices and where they are at rest, matrices in the object's space."""

    def __init__(self, names, moves, binds):
        self.names, self.moves, self.binds = names, moves, binds


def pose_of(o, depsgraph):
    """The pose of an evaluated object; None without an armature."""
    armature = armature_of(o)
    if armature is None:
        return None
    armature = armature.evaluated_get(depsgraph)
    groups = set(o.vertex_groups.keys())
    bones = [p for p in armature.pose.bones if p.name in groups and p.bone.use_deform]
    own = numpy.array(o.matrix_world)
    if not bones or numpy.linalg.det(own) == 0.0:
        return None
    place = numpy.linalg.inv(own) @ numpy.array(armature.matrix_world)
    binds = place @ numpy.array([p.bone.matrix_local for p in bones])
    if (numpy.linalg.det(binds) == 0.0).any():
        return None
    return Pose([p.name for p in bones], place @ numpy.array([p.matrix for p in bones]) @ numpy.linalg.inv(binds), binds)


def influences_of(o, mesh, names):
    """The joints that each vertex follows, and their weights (vertices, MOST); the joint after the last one stands still."""
    number = {name: i for i, name in enumerate(names)}
    joint_of = [number.get(name) for name in o.vertex_groups.keys()]
    joints, weights = numpy.zeros((len(mesh.vertices), MOST), numpy.int64), numpy.zeros((len(mesh.vertices), MOST), numpy.float32)
    for i, vertex in enumerate(mesh.vertices):
        found = [(g.weight, joint_of[g.group]) for g in vertex.groups if g.weight > 0.0 and g.group < len(joint_of)]
        found = sorted(((w, j) for w, j in found if j is not None), reverse=True)[:MOST]
        if sum(w for w, _ in found) <= LEAST:
            found = [(1.0, len(names))]
        for k, (weight, joint) in enumerate(found):
            joints[i, k], weights[i, k] = joint, weight
    return joints, weights / weights.sum(axis=1, keepdims=True)


def matrices_of(path):
    """Of an affine.Path, as a file holds it."""
    w, x, y, z = path.turns.astype(numpy.float32).astype(numpy.float64).T
    turns = numpy.stack((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
                         1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
                         1 - 2 * (x * x + y * y)), axis=1).reshape(-1, 3, 3)
    found = numpy.zeros((len(w), 4, 4))
    found[:, :3, :3] = turns * path.scales[:, None, :]
    found[:, :3, 3], found[:, 3, 3] = path.places, 1.0
    return found


def unit(vectors):
    return vectors / numpy.maximum(numpy.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def is_regular(matrices):
    return numpy.abs(numpy.linalg.det(matrices[:, :, :3])) > 1e-9


class Skin:
    """`poses`: by record; `influences`: by exported vertex. All is in glTF's axes from here on."""

    def __init__(self, poses, influences):
        self.names, (self.joints, self.weights) = poses[0].names, influences
        binds = Y_UP @ poses[0].binds @ Y_UP.T
        moves = Y_UP @ numpy.array([p.moves for p in poses]) @ Y_UP.T
        self.paths = decompose((moves @ binds).swapaxes(0, 1))
        self.inverse = numpy.linalg.inv(binds).astype(numpy.float32)
        self.inverse[:, 3] = 0.0, 0.0, 0.0, 1.0
        still = numpy.broadcast_to(numpy.eye(4), (len(poses), 1, 4, 4))
        follow = numpy.array([matrices_of(path) for path in self.paths]).swapaxes(0, 1) @ self.inverse.astype(numpy.float64)
        self.matrices = numpy.concatenate((follow, still), axis=1)[:, :, :3]
        self.has_still = bool((self.joints == len(self.names)).any())
        self.positions = self.normals = None

    def is_sheared(self):
        return any(path.inner is not None for path in self.paths)

    def blended(self, record, first=0, last=None):
        """The matrices (vertices, 3, 4) of exported vertices in a record."""
        joints, weights = self.joints[first:last], self.weights[first:last]
        found = numpy.zeros((len(joints), 3, 4))
        for k in range(MOST):
            if weights[:, k].any():
                found += weights[:, k, None, None] * self.matrices[record][joints[:, k]]
        return found

    def lay(self, positions, normals):
        """Finds the mesh at rest from that of the first record. Says whether there is one."""
        matrices = self.blended(0)
        if not is_regular(matrices).all():
            return False
        self.positions = numpy.linalg.solve(matrices[:, :, :3], (positions - matrices[:, :, 3])[:, :, None])[:, :, 0].astype(numpy.float32)
        self.normals = self.at_rest(0, normals).astype(numpy.float32)
        return True

    def at_rest(self, record, normals, first=0, last=None):
        """The normals of the mesh at rest that become these."""
        return unit(numpy.einsum("vij,vi->vj", self.blended(record, first, last)[:, :, :3], normals))

    def places(self, record, size, positions):
        """Are these the positions of a record, and can normals be turned there?"""
        matrices = self.blended(record)
        placed = numpy.einsum("vij,vj->vi", matrices[:, :, :3], self.positions) + matrices[:, :, 3]
        return bool((numpy.abs(placed - positions).max(axis=1) <= NEAR * size).all() and is_regular(matrices).all())

    def turns(self, record, normals, rest):
        """Are these the normals of a record, where those at rest are `rest`?"""
        turned = numpy.linalg.solve(self.blended(record)[:, :, :3].swapaxes(1, 2), rest[:, :, None])[:, :, 0]
        return bool((numpy.abs(unit(turned) - normals) <= NEAR_NORMAL).all())

    def write(self, gltf, data, tracks, owner, records):
        """Adds the joints, as children of the node `owner`, which place them where it is. `records`: by frame."""
        nodes, names = gltf["nodes"], {node.get("name") for node in gltf["nodes"]}
        joints = []
        for name, path in zip(self.names, self.paths):
            own = free_name("%s %s" % (nodes[owner]["name"], name), names)
            names.add(own)
            joints.append(len(nodes))
            nodes.append({"name": own})
            tracks.node(own, "translation", path.places[records])
            tracks.node(own, "rotation", path.turns[records][:, [1, 2, 3, 0]])
            tracks.node(own, "scale", path.scales[records])
        if self.has_still:
            joints.append(len(nodes))
            nodes.append({"name": free_name("%s at rest" % nodes[owner]["name"], names)})
        nodes[owner].setdefault("children", []).extend(joints)
        inverse = numpy.concatenate((self.inverse, numpy.eye(4, dtype=numpy.float32)[None]))[:len(joints)]
        binds = data.accessor(numpy.ascontiguousarray(inverse.swapaxes(1, 2)), FLOAT, "MAT4")
        gltf.setdefault("skins", []).append({"joints": joints, "inverseBindMatrices": binds})
        nodes[owner]["skin"] = len(gltf["skins"]) - 1

    def write_influences(self, data, primitive, first, last):
        sets = 2 if self.weights[:, 4:].any() else 1
        is_small = len(self.names) < 256
        for k in range(sets):
            columns = slice(4 * k, 4 * k + 4)
            joints = numpy.ascontiguousarray(self.joints[first:last, columns], numpy.uint8 if is_small else numpy.uint16)
            primitive["attributes"]["JOINTS_%d" % k] = data.accessor(joints, UNSIGNED_BYTE if is_small else UNSIGNED_SHORT, "VEC4")
            weights = numpy.ascontiguousarray(self.weights[first:last, columns])
            primitive["attributes"]["WEIGHTS_%d" % k] = data.accessor(weights, FLOAT, "VEC4")
