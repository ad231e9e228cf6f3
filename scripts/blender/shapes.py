"""What deforms: shapes by frame, as a skin or morph targets where the topology stays, else as a mesh for each span of frames.

    recorder = Recorder()
    recorder.note(key, number, o, depsgraph)   in each frame in which the geometry of an object was updated
    finish(), spans(key)                       once all frames are noted: meshes for the new objects
    prepare()                                  just before Blender's exporter runs
    write(gltf, data, tracks, placed)          afterwards: skins and targets, and their keys for all nodes that show the meshes

Positions and normals wait in a temporary file. Exported vertices are matched with Blender's by a layer of coordinates that numbers
the corners and is taken out of the file again.
"""
import collections
import functools
import hashlib
import itertools
import tempfile

import bpy
import numpy

from .factors import Rows, factors, summed
from .glb_data import FLOAT, UNSIGNED_INT
from .messages import lose
from .moves import trees_within
from .skins import Skin, influences_of, pose_of
from .versions import has_nodes

SHAPE = "reframe shape"  # a property of meshes that deform: the number of their shape
MATRIX = "reframe matrix"  # another one: what was applied to the shape afterwards
PARTS = ("POSITION", "NORMAL")
LAYER = "reframe corners"  # their numbers, in two columns of whole numbers from FIRST on
FIRST, COLUMN = 1 << 20, 4096
SAME = 1e-7  # of the size: what moves less stands still
SAME_NORMAL = 1e-4
NEAR, NEAR_NORMAL = 5e-6, 1e-3  # of the size, and of 1: what shapes that are sums of few targets may be off by
MOST_BYTES = 3 << 30  # of positions and normals; a .glb has 4 GiB
MOST_CORNERS = 30000000  # of all meshes whose topology changes


def array_of(collection, name, width, kind):
    found = numpy.empty(len(collection) * width, kind)
    collection.foreach_get(name, found)
    return found


def positions_of(mesh):
    return array_of(mesh.vertices, "co", 3, numpy.float32).reshape(-1, 3)


def normals_of(mesh):
    """Those of the corners, as they are rendered."""
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
        normals = array_of(mesh.loops, "normal", 3, numpy.float32)
    else:
        normals = array_of(mesh.corner_normals, "vector", 3, numpy.float32)
    return normals.reshape(-1, 3)


def materials_of(o, mesh):
    return [*mesh.materials, *(slot.material for slot in o.material_slots)]


def asked_for(o, mesh):
    """The attributes that materials ask for, besides coordinates."""
    trees = [t for m in materials_of(o, mesh) if m is not None and has_nodes(m) for t in trees_within(m.node_tree)]
    names = {n.attribute_name for t in trees for n in t.nodes if n.type == "ATTRIBUTE"}
    names |= {n.layer_name for t in trees for n in t.nodes if n.type == "VERTEX_COLOR"}
    colours = set(mesh.color_attributes.keys()) if "" in names else set()
    return sorted((names | colours) - set(mesh.uv_layers.keys()))


VALUES = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3), "FLOAT2": ("vector", 2),
          "FLOAT": ("value", 1), "INT": ("value", 1)}


def topology_of(o, mesh):
    """A digest of all but where vertices are."""
    digest = hashlib.md5(repr((len(mesh.vertices), [m.name if m is not None else None for m in materials_of(o, mesh)])).encode())
    digest.update(array_of(mesh.loops, "vertex_index", 1, numpy.int32))
    digest.update(array_of(mesh.polygons, "loop_total", 1, numpy.int32))
    digest.update(array_of(mesh.polygons, "material_index", 1, numpy.int32))
    for layer in mesh.uv_layers:
        digest.update(layer.name.encode() + array_of(layer.data, "uv", 2, numpy.float32).tobytes())
    for name in asked_for(o, mesh):
        attribute = mesh.attributes.get(name)
        if attribute is not None and attribute.data_type in VALUES:
            digest.update(name.encode() + array_of(attribute.data, *VALUES[attribute.data_type], numpy.float32).tobytes())
    return digest.digest()


def mesh_of(o, depsgraph):
    """A mesh of an evaluated object, as it is rendered."""
    mesh = bpy.data.meshes.new_from_object(o, preserve_all_data_layers=True, depsgraph=depsgraph)
    own = o.original.data
    if mesh is not None and isinstance(own, bpy.types.Mesh):
        mesh.use_auto_texspace = False  # generated coordinates stay those of the mesh as modelled
        mesh.texspace_location, mesh.texspace_size = own.texspace_location, own.texspace_size
    return mesh


def transformed(mesh, matrix):
    """A copy of a mesh, and of its shape, in another space."""
    mesh = mesh.copy()
    mesh.transform(matrix)
    if SHAPE in mesh:
        mesh[MATRIX] = [value for row in matrix for value in row]
    return mesh


class Corners:
    """Which corners of a mesh have one vertex in the file: those of a vertex whose normals are the same."""

    def __init__(self, groups, first):
        self.groups, self.first = groups, first  # the group of each corner, a corner of each group

    def refined(self, normals):
        """The same, or one with as many more groups as these normals need."""
        if not len(self.groups) or numpy.abs(normals - normals[self.first][self.groups]).max() <= SAME_NORMAL:
            return self
        key = self.groups.astype(numpy.uint64) * numpy.uint64(0x9E3779B97F4A7C15)
        for column, factor in zip(numpy.round(normals / SAME_NORMAL).astype(numpy.int64).astype(numpy.uint64).T,
                                  (0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93)):
            key += (column + numpy.uint64(1)) * numpy.uint64(factor)
        _, first, groups = numpy.unique(key, return_index=True, return_inverse=True)
        return Corners(groups.reshape(-1).astype(numpy.int32), first)


def corners_by_vertex(vertices):
    _, first, groups = numpy.unique(vertices, return_index=True, return_inverse=True)
    return Corners(groups.reshape(-1).astype(numpy.int32), first)


class Record:
    """A shape in the temporary file, unless it is the first of its topology."""

    def __init__(self, start, corners, pose):
        self.start, self.corners, self.pose = start, corners, pose


class Shape:
    """What has one topology for a span of frames."""

    def __init__(self, number, topology, mesh):
        self.first, self.topology, self.mesh = number, topology, mesh
        self.vertices = array_of(mesh.loops, "vertex_index", 1, numpy.int32) if mesh is not None else numpy.empty(0, numpy.int32)
        self.vertex_count = len(mesh.vertices) if mesh is not None else 0
        self.corners = corners_by_vertex(self.vertices)
        self.records, self.events = [], []  # an event: a frame from which on there is a record
        self.last = None  # positions and normals
        self.influences = None  # of vertices, where it has an armature

    def is_last(self, positions, normals):
        if self.last is None:
            return False
        size = float(numpy.ptp(positions, axis=0).max()) if len(positions) else 0.0
        moved = numpy.abs(positions - self.last[0]).max(initial=0.0), numpy.abs(normals - self.last[1]).max(initial=0.0)
        return moved[0] <= SAME * size and moved[1] <= SAME_NORMAL

    def record_at(self, number):
        found = [record for first, record in self.events if first <= number]
        return found[-1] if found else 0


class Recorder:
    def __init__(self):
        self.file = tempfile.TemporaryFile(prefix="reframe-")
        self.size, self.corners = 0, 0
        self.shapes = {}  # lists of shapes, by key
        self.numbered = []
        self.full = set()  # keys of which no more is noted

    def note(self, key, number, o, depsgraph, matrix=None):
        """Notes the geometry of an evaluated object; `matrix` is applied to it. Not while the depsgraph is gone through."""
        if key in self.full:
            return
        is_mesh = isinstance(o.data, bpy.types.Mesh)
        mesh = o.data if is_mesh else o.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        if mesh is not None and matrix is not None:
            mesh = mesh.copy()
            mesh.transform(matrix)
        try:
            self.note_mesh(key, number, o, mesh, depsgraph, matrix)
        finally:
            if mesh is not None and matrix is not None:
                bpy.data.meshes.remove(mesh)
            if not is_mesh:
                o.to_mesh_clear()

    def note_mesh(self, key, number, o, mesh, depsgraph, matrix):
        is_empty = mesh is None or not len(mesh.polygons)
        topology = None if is_empty else topology_of(o, mesh)
        shapes = self.shapes.setdefault(key, [])
        if not shapes or shapes[-1].topology != topology:
            if shapes and self.is_full(key, number, o, 0 if is_empty else len(mesh.loops)):
                return
            if shapes:
                shapes[-1].last = None
            new = None if is_empty else mesh_of(o, depsgraph)
            if new is not None:
                if matrix is not None:
                    new.transform(matrix)
                new[SHAPE] = len(self.numbered)
            shapes.append(Shape(number, topology, new))
            self.numbered.append(shapes[-1])
        shape = shapes[-1]
        if is_empty:
            return
        positions, normals = positions_of(mesh), normals_of(mesh)
        if shape.is_last(positions, normals):
            return
        shape.corners = shape.corners.refined(normals)
        kept = normals[shape.corners.first]
        if shape.records:  # the first is the mesh itself
            if self.size + positions.nbytes + kept.nbytes > MOST_BYTES:
                self.refuse(key, number, o, "the shapes of all objects take more than %d GiB: export fewer frames" % (MOST_BYTES >> 30))
                return
            self.file.seek(self.size)
            self.file.write(positions.tobytes())
            self.file.write(kept.tobytes())
        shape.events.append((number, len(shape.records)))
        shape.records.append(Record(self.size, shape.corners, pose_of(o, depsgraph)))
        if len(shape.records) == 2 and shape.records[0].pose is not None:
            shape.influences = influences_of(o, shape.mesh, shape.records[0].pose.names)
        self.size += positions.nbytes + kept.nbytes if len(shape.records) > 1 else 0
        shape.last = positions, normals

    def is_full(self, key, number, o, corners):
        self.corners += corners
        if self.corners <= MOST_CORNERS:
            return False
        self.refuse(key, number, o, "meshes of all topologies have more than %d million corners: export fewer frames" %
                    (MOST_CORNERS // 1000000))
        return True

    def refuse(self, key, number, o, why):
        self.full.add(key)
        lose("'%s': keeps its shape from frame %d on: %s" % (o.name, number, why))

    def finish(self):
        for shape in self.numbered:
            if shape.mesh is not None and len(shape.records) < 2:
                del shape.mesh[SHAPE]

    def spans(self, key):
        """Pairs: the number of the frame from which on a mesh is shown, and the mesh; None: nothing is."""
        return [(shape.first, shape.mesh) for shape in self.shapes.get(key, [])]

    # the file

    def prepare(self):
        """Numbers the corners of meshes that deform."""
        for mesh in bpy.data.meshes:
            shape = self.shape_of(mesh)
            if shape is None or len(shape.records) < 2:
                continue
            if len(mesh.loops) != len(shape.vertices):
                lose("mesh '%s': made anew for its material: its shape stays as in the first frame" % mesh.name)
                continue
            active = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
            while len(mesh.uv_layers) > 7:
                mesh.uv_layers.remove(next(layer for layer in reversed(mesh.uv_layers) if layer.name != active))
            layer = mesh.uv_layers.new(name=LAYER, do_init=False)
            groups = shape.corners.groups
            layer.data.foreach_set("uv", numpy.stack([FIRST + groups // COLUMN, FIRST + groups % COLUMN], 1).astype(numpy.float32).ravel())
            if active is not None:
                mesh.uv_layers[active].active_render = True

    def shape_of(self, owner):
        number = owner.get(SHAPE)
        return self.numbered[int(number)] if number is not None else None

    def read(self, shape, record, groups):
        """Positions and normals of groups of corners of the last record."""
        record, corners = shape.records[record], shape.corners.first[groups]
        ends = numpy.cumsum((record.start, 12 * shape.vertex_count, 12 * len(record.corners.first)))
        positions, normals = (numpy.memmap(self.file, numpy.float32, "r", start, ((end - start) // 12, 3))
                              for start, end in zip(ends, ends[1:]))
        return positions[shape.vertices[corners]], normals[record.corners.groups[corners]]

    def write(self, gltf, data, tracks, placed):
        """Adds skins and targets to the meshes that Blender's exporter wrote, and how they move to `tracks`; called before anything else is
        added. `placed`: names of objects that become instances."""
        self.file.flush()
        found = []  # a mesh, its shape, what is applied to it, and the group of corners of each vertex of each primitive
        numbered = set()  # accessors
        for i, mesh in enumerate(gltf.get("meshes", [])):
            extras = mesh.get("extras", {})
            shape, matrix = self.shape_of(extras), numpy.array(extras.pop(MATRIX, numpy.identity(4))).reshape(4, 4)
            if shape is None:
                continue
            del extras[SHAPE]
            if not extras:
                del mesh["extras"]
            corners = [take_corners(gltf, data, p, shape, numbered) for p in mesh["primitives"]] if len(shape.records) > 1 else [None]
            if all(c is not None for c in corners):
                found.append((i, shape, matrix, corners))
        remove_accessors(gltf, data, numbered)
        used = collections.Counter(p["attributes"]["POSITION"] for mesh in gltf.get("meshes", []) for p in mesh["primitives"])
        for i, shape, matrix, corners in found:
            mesh, owners = gltf["meshes"][i], [k for k, node in enumerate(gltf["nodes"]) if node.get("mesh") == i]
            is_own = all(used[p["attributes"]["POSITION"]] == 1 for p in mesh["primitives"])
            may_follow = is_own and (matrix == numpy.identity(4)).all() and not any(gltf["nodes"][k]["name"] in placed for k in owners)
            skin, weights = self.write_mesh(gltf, data, mesh, shape, matrix, corners, may_follow)
            records = [shape.record_at(n) for n in tracks.numbers]
            for k in owners:
                if skin is not None:
                    skin.write(gltf, data, tracks, k, records)
                if weights.size:
                    tracks.node(gltf["nodes"][k]["name"], "weights", weights[records])

    def write_mesh(self, gltf, data, mesh, shape, matrix, corners, may_follow):
        """The first shape is that of the mesh itself; the others are sums of targets. Returns a skin or None, and the weights of each
        record."""
        primitives, groups = mesh["primitives"], numpy.concatenate(corners)
        bases = [numpy.concatenate([read_floats(gltf, data, p["attributes"][name]) for p in primitives]) for name in PARTS]
        ends = numpy.cumsum([len(groups) for groups in corners])
        size = float(numpy.ptp(bases[0], axis=0).max(initial=0.0))
        skin, columns, targets = (self.skinned(shape, groups, bases, size) if may_follow else None) or self.morphed(
            shape, matrix, groups, bases, size)
        weights = numpy.concatenate(columns, axis=1)
        for primitive, start, end in zip(primitives, [0, *ends], ends):
            if skin is not None:
                for name, values in zip(PARTS, (skin.positions, skin.normals)):
                    write_floats(gltf, data, primitive["attributes"][name], values[start:end])
                skin.write_influences(data, primitive, start, end)
            if weights.size:
                primitive["targets"] = []
        for deltas in itertools.chain(*targets):
            for primitive, start, end in zip(primitives, [0, *ends], ends):
                primitive["targets"].append({name: add_deltas(data, values[start:end], name == "POSITION")
                                             for name, values in zip(PARTS, deltas) if values is not None})
        if weights.size:
            mesh["weights"] = [0.0] * weights.shape[1]
        return skin, numpy.concatenate((numpy.zeros_like(weights[:1]), weights))

    def morphed(self, shape, matrix, groups, bases, size):
        """No skin; weights and targets of positions and normals."""
        moved = self.rows(shape, matrix, groups, bases)
        found = [factors(rows, error) for rows, error in zip(moved, (NEAR * size, NEAR_NORMAL))]
        whole = numpy.eye(len(shape.records) - 1)
        if found[0] is None and found[1] is None:
            return None, [whole], [zip(summed(moved[0], whole), summed(moved[1], whole))]
        columns = [whole if weights is None else weights for weights in found]
        return None, columns, [((deltas, None) for deltas in summed(moved[0], columns[0])),
                               ((None, deltas) for deltas in summed(moved[1], columns[1]))]

    def skinned(self, shape, groups, bases, size):
        """A skin, and weights and targets of the normals, which bend otherwise; None where vertices do not follow it in every record."""
        poses = [record.pose for record in shape.records]
        if shape.influences is None or any(pose is None or pose.names != poses[0].names for pose in poses):
            return None
        vertices = shape.vertices[shape.corners.first[groups]]
        skin = Skin(poses, [values[vertices] for values in shape.influences])
        records = range(1, len(poses))
        if (skin.is_sheared() or not skin.lay(*bases) or
                not all(skin.places(r, size, y_up(self.read(shape, r, groups)[0])) for r in records)):
            return None

        def read(first, last):
            turned = (skin.at_rest(r, y_up(unit(self.read(shape, r, groups[first:last])[1])), first, last) for r in records)
            found = numpy.stack([normals - skin.normals[first:last] for normals in turned])
            found[numpy.abs(found).max(axis=2) <= SAME_NORMAL] = 0.0  # where one bone alone turns them
            return found.reshape(len(records), -1)

        rows = Rows(len(records), len(groups), read)
        weights = factors(rows, NEAR_NORMAL)
        weights = numpy.eye(len(records)) if weights is None else weights
        deltas = numpy.empty((weights.shape[1], 3 * len(groups)), numpy.float32)
        for row, values in zip(deltas, summed(rows, weights)):
            row[:] = values.ravel()
        for r in records:
            rest = skin.normals + (weights[r - 1].astype(numpy.float32) @ deltas).reshape(-1, 3)
            if not skin.turns(r, y_up(unit(self.read(shape, r, groups)[1])), rest):
                return None
        return skin, [weights], [[(None, values.reshape(-1, 3)) for values in deltas]]

    def rows(self, shape, matrix, groups, bases):
        """What the positions and the normals of exported vertices differ by from those of the mesh, in all records but the first."""

        def read(part, first, last):
            found = (applied(matrix, *self.read(shape, record, groups[first:last])) for record in range(1, len(shape.records)))
            return numpy.stack([(y_up(parts[part]) - bases[part][first:last]).ravel() for parts in found])

        return [Rows(len(shape.records) - 1, len(groups), functools.partial(read, part)) for part in range(2)]


def applied(matrix, positions, normals):
    turn = matrix[:3, :3]
    if not (matrix == numpy.identity(4)).all():  # faces of what is mirrored look the other way
        positions = (positions @ turn.T + matrix[:3, 3]).astype(numpy.float32)
        normals = normals @ numpy.linalg.inv(turn) * numpy.sign(numpy.linalg.det(turn))
    return positions, unit(normals)


def unit(vectors):
    lengths = numpy.linalg.norm(vectors, axis=1, keepdims=True)
    return numpy.where(lengths > 0.0, vectors / numpy.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0)).astype(numpy.float32)


def y_up(vectors):
    return numpy.stack((vectors[:, 0], vectors[:, 2], -vectors[:, 1]), axis=1)


def read_floats(gltf, data, index):
    """An accessor of floats, as Blender's exporter writes them."""
    accessor = gltf["accessors"][index]
    width = {"VEC2": 2, "VEC3": 3}[accessor["type"]]
    start = gltf["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return numpy.frombuffer(bytes(data.bytes[start:start + 4 * width * accessor["count"]]), numpy.float32).reshape(-1, width)


def write_floats(gltf, data, index, values):
    """Into the place of an accessor."""
    accessor = gltf["accessors"][index]
    start = gltf["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
    data.bytes[start:start + values.nbytes] = values.tobytes()
    if "min" in accessor:
        accessor["min"], accessor["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()


def take_corners(gltf, data, primitive, shape, numbered):
    """The groups of corners that vertices of a primitive are of; the coordinates that say so are taken out of it."""
    sets = [name for name in primitive["attributes"] if name.startswith("TEXCOORD_")]
    last = max(sets, key=lambda name: int(name[9:]), default=None)
    if last is None:
        return None
    values = read_floats(gltf, data, primitive["attributes"][last])
    columns = numpy.rint(numpy.stack((values[:, 0], 1.0 - values[:, 1]), axis=1)).astype(numpy.int64) - FIRST
    if columns.size and (columns.min() < 0 or columns[:, 1].max() >= COLUMN):
        return None
    numbered.add(primitive["attributes"].pop(last))
    return columns[:, 0] * COLUMN + columns[:, 1]


def remove_accessors(gltf, data, gone):
    """Takes accessors and their views out of what Blender's exporter wrote."""
    if not gone:
        return
    views = {gltf["accessors"][i]["bufferView"] for i in gone}
    kept = [i for i in range(len(gltf["accessors"])) if i not in gone]
    kept_views = [i for i in range(len(gltf["bufferViews"])) if i not in views]
    number, view_number = {old: new for new, old in enumerate(kept)}, {old: new for new, old in enumerate(kept_views)}
    old, data.bytes = data.bytes, bytearray()
    for view in (gltf["bufferViews"][i] for i in kept_views):
        data.bytes += b"\0" * (-len(data.bytes) % 4)
        start, view["byteOffset"] = view.get("byteOffset", 0), len(data.bytes)
        data.bytes += old[start:start + view["byteLength"]]
    gltf["accessors"], gltf["bufferViews"] = [gltf["accessors"][i] for i in kept], [gltf["bufferViews"][i] for i in kept_views]
    for owner in gltf["accessors"] + gltf.get("images", []):
        if "bufferView" in owner:
            owner["bufferView"] = view_number[owner["bufferView"]]
    for primitive in (p for mesh in gltf["meshes"] for p in mesh["primitives"]):
        primitive["attributes"] = {name: number[i] for name, i in primitive["attributes"].items()}
        if "indices" in primitive:
            primitive["indices"] = number[primitive["indices"]]
    for sampler in (s for animation in gltf.get("animations", []) for s in animation["samplers"]):
        sampler["input"], sampler["output"] = number[sampler["input"]], number[sampler["output"]]


def add_deltas(data, deltas, bounds):
    """An accessor of what is added to vertices: a sparse one where few change."""
    changed = numpy.flatnonzero(deltas.any(axis=1))
    deltas = numpy.ascontiguousarray(deltas, numpy.float32)
    if 4 * len(changed) > 3 * len(deltas):
        return data.accessor(deltas, FLOAT, "VEC3", bounds)
    accessor = {"componentType": FLOAT, "type": "VEC3", "count": len(deltas)}
    if bounds:
        accessor["min"], accessor["max"] = deltas.min(axis=0).tolist(), deltas.max(axis=0).tolist()
    if len(changed):
        accessor["sparse"] = {"count": len(changed),
                              "indices": {"bufferView": data.view(changed.astype(numpy.uint32).tobytes()), "componentType": UNSIGNED_INT},
                              "values": {"bufferView": data.view(deltas[changed].tobytes())}}
    data.gltf["accessors"].append(accessor)
    return len(data.gltf["accessors"]) - 1
