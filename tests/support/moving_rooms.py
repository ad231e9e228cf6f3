#!/usr/bin/env -S python3 -B
"""Writes small rooms in which something moves, each with the still room of every frame.

  moving_rooms.py FOLDER

writes CASE.glb, which moves by glTF's animations, and CASE-0.glb and so on for its frames, in which the same stands
still: their vertices are computed here, so that nobody who renders them knows of movement. The camera's path is in all
of them. Rooms in which lamps and materials change are those of changing_rooms.py. Uses only Python's standard library.
"""
import copy
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes"))

import glb  # noqa: E402
from glb import glass, lambert, material  # noqa: E402
from pictures import write_hdr  # noqa: E402
from shapes import Mesh, add, make_box, make_quad, make_room, make_sphere, mix  # noqa: E402

FRAMES = 7
LAST = FRAMES - 1
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)  # columns
HALF = [0, 1, 1, 0, 1, 0, 0]  # shown in some of the frames


# ---- Affine maps: nine numbers, column by column, and a shift ----

def apply(m, p):
    return tuple(m[r] * p[0] + m[3 + r] * p[1] + m[6 + r] * p[2] for r in range(3))


def cofactor(m):
    a, b, c = m[0:3], m[3:6], m[6:9]
    cross = lambda u, v: (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return cross(b, c) + cross(c, a) + cross(a, b)


def determinant(m):
    c = cofactor(m)
    return sum(m[i] * c[i] for i in range(3))


def times(outer, inner):
    """(m, shift) after (m, shift)."""
    m = sum((apply(outer[0], inner[0][3 * c:3 * c + 3]) for c in range(3)), ())
    return m, add(apply(outer[0], inner[1]), outer[1])


def turn(axis, angle):
    """Columns of the rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    return {"x": (1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c), "y": (c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c),
            "z": (c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0)}[axis]


class Way:
    """How a node moves: its position and its angle about an axis from the first to the last frame; or a list of the
    positions between which it steps, or which it passes at the times `keys` (in frames). `scale`, `shown`: a list of one
    for each frame."""

    def __init__(self, at=(0.0, 0.0, 0.0), to=None, axis="y", angle=0.0, angle_to=None, scale=None, shown=None, under=None,
                 keys=None):
        self.at, self.to, self.axis, self.angle, self.angle_to = at, to, axis, angle, angle_to
        self.scale, self.shown, self.under, self.keys = scale, shown, under, keys
        self.number = None  # of its node

    def position(self, frame):
        if self.keys:
            return self.at[max((k for k in range(len(self.keys)) if self.keys[k] <= frame), default=0)]
        if isinstance(self.at, list):
            return self.at[frame]
        return self.at if self.to is None else mix(self.at, self.to, frame / LAST)

    def turned(self, frame):
        return self.angle if self.angle_to is None else self.angle + (self.angle_to - self.angle) * frame / LAST

    def map(self, frame):
        size = self.scale[frame] if self.scale else (1.0, 1.0, 1.0)
        m = turn(self.axis, self.turned(frame))
        here = tuple(m[3 * c + r] * size[c] for c in range(3) for r in range(3)), self.position(frame)
        return times(self.under.map(frame), here) if self.under else here

    def is_shown(self, frame):
        return (not self.shown or bool(self.shown[frame])) and (not self.under or self.under.is_shown(frame))


class Thing:
    """A mesh on ways. `morph`: displacements of the vertices, and the weight at each frame. `joints`: ways of the
    bones, which stand at the origin of the mesh at rest; `bones`: the weights of each vertex."""

    def __init__(self, name, mesh, look, ways=None, morph=None, joints=None, bones=None):
        self.name, self.mesh, self.look, self.ways = name, mesh, look, ways or [Way()]
        self.morph, self.joints, self.bones = morph, joints, bones

    def baked(self, way, frame):
        """The mesh in the world, or None."""
        if not way.is_shown(frame):
            return None
        out = Mesh()
        m, shift = way.map(frame)
        bones = [joint.map(frame) for joint in self.joints or []]
        for v, (p, n, uv) in enumerate(zip(self.mesh.positions, self.mesh.normals, self.mesh.uvs)):
            if self.morph:
                weight = self.morph[1][frame]
                p = add(p, tuple(weight * x for x in self.morph[0][v]))
            if bones:
                m = tuple(sum(w * b[0][i] for w, b in zip(self.bones[v], bones)) for i in range(9))
                shift = tuple(sum(w * b[1][i] for w, b in zip(self.bones[v], bones)) for i in range(3))
            normal = apply(cofactor(m), n)
            normal = tuple(x if determinant(m) >= 0.0 else -x for x in normal)
            length = math.sqrt(sum(x * x for x in normal))
            out.vertex(add(apply(m, p), shift), tuple(x / length for x in normal) if length > 1e-12 else (0.0, 0.0, 0.0), uv)
        flip = not bones and determinant(way.map(frame)[0]) < 0.0
        for i in range(0, len(self.mesh.indices), 3):
            corners = self.mesh.indices[i:i + 3]
            if area(out, corners) > 1e-20:
                out.indices += [corners[0], corners[2], corners[1]] if flip else corners
        return out if out.indices else None


def area(mesh, corners):
    a, b, c = (mesh.positions[i] for i in corners)
    u, v = tuple(x - y for x, y in zip(b, a)), tuple(x - y for x, y in zip(c, a))
    return sum(x * x for x in cofactor(u + v + (0.0, 0.0, 0.0))[6:9])


class Lamp:
    """A punctual light that shines along -z of its way. `changes`: a value for each frame by its pointer, as in the file."""

    def __init__(self, name, description, way, changes=None, step=False):
        self.name, self.description, self.way, self.changes, self.step = name, description, way, changes or {}, step


def changed(description, changes, frame):
    """A light or a material as it is in a frame."""
    result = copy.deepcopy(description)
    for pointer, values in changes.items():
        inner, keys = result, pointer.split("/")
        for key in keys[:-1]:
            inner = inner.setdefault(key, {})
        value = values[frame]
        inner[keys[-1]] = list(value) if isinstance(value, tuple) else value
    return result


class Room:
    """A case: what stands still, what moves or changes, and the camera. `changes`: those of materials, by their names, as those of
    lamps; `yfov`: in degrees, one for each frame; `films`: bytes of a PNG for each frame, by the names of textures; `sky_keys`: what
    the sky has in each frame; `sky_map`: width, height and pixels of its map."""

    def __init__(self, name, eyes, targets, sky=None, frames=FRAMES):
        self.name, self.eyes, self.targets, self.sky, self.frames = name, eyes, targets, sky, frames
        self.things, self.lamps, self.stills = [], [], range(frames)
        self.changing_lamps, self.changes, self.textures, self.yfov = [], {}, [], None
        self.films, self.sky_keys, self.sky_map = {}, None, None

    def still(self, name, mesh, look, at=(0.0, 0.0, 0.0)):
        self.things.append(Thing(name, mesh, look, [Way(at)]))

    def move(self, *arguments, **named):
        self.things.append(Thing(*arguments, **named))

    def light(self, *arguments, **named):
        self.changing_lamps.append(Lamp(*arguments, **named))

    def look(self, thing, frame):
        return changed(thing.look, self.changes.get(thing.look["name"], {}), frame)

    def film(self, name, folder):
        """Writes its images, and says where they are."""
        for number, image in enumerate(self.films[name], 1):
            with open(os.path.join(folder, "%s-%s.%d.png" % (self.name, name, number)), "wb") as file:
                file.write(image)
        return {"frames": "%s-%s.#.png" % (self.name, name), "last": len(self.films[name]), "fps": glb.FPS}

    def sky_at(self, frame, moving, folder):
        sky = dict(self.sky)
        if self.sky_map:
            sky["map"] = self.name + "-sky.hdr"
            write_hdr(os.path.join(folder, sky["map"]), *self.sky_map)
        if self.sky_keys and moving:
            sky.update(interpolation="linear", keys=[dict(k, time=f / glb.FPS) for f, k in enumerate(self.sky_keys)])
        elif self.sky_keys:
            sky.update(self.sky_keys[frame])
        return sky

    def file(self, folder, frame=0, moving=False):
        out = glb.Gltf("moving_rooms.py", self.name)
        for name, image in self.textures:
            out.texture(name, image)
        for name, images in self.films.items():
            texture = out.texture(name, images[frame])
            image = out.json["textures"][texture]["source"]
            if moving:
                out.json["images"][image]["extras"] = {"reframe": self.film(name, folder)}
        if any("KHR_texture_transform" in pointer for changes in self.changes.values() for pointer in changes):
            out.extensions.append("KHR_texture_transform")
        if self.sky:
            out.json["scenes"][0]["extras"] = {"reframe": {"environment": self.sky_at(frame, moving, folder)}}
        views = [(mix(self.eyes[0], self.eyes[1], f / LAST), mix(self.targets[0], self.targets[1], f / LAST))
                 for f in range(self.frames)]
        out.camera(views, math.radians(self.yfov[frame] if self.yfov else 60.0))
        return out


# ---- The still rooms ----

def add_light(out, description, node):
    """The number of the light; its node, without a place."""
    lights = out.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    lights.append(description)
    node["extensions"] = {"KHR_lights_punctual": {"light": len(lights) - 1}}
    return len(lights) - 1


def write_still(room, frame, folder):
    out = room.file(folder, frame)
    for thing in room.things:
        for way in thing.ways:
            mesh = thing.baked(way, frame)
            if mesh:
                out.mesh(thing.name, mesh, room.look(thing, frame))
    for name, description, place, towards in room.lamps:
        out.light(name, description, place, towards)
    for lamp in room.changing_lamps:
        if lamp.way.is_shown(frame):
            m, shift = lamp.way.map(frame)
            columns = [x for c in range(3) for x in m[3 * c:3 * c + 3] + (0.0,)]
            node = {"name": lamp.name, "matrix": columns + list(shift) + [1.0]}
            add_light(out, dict(changed(lamp.description, lamp.changes, frame), name=lamp.name), node)
            out.node(node)
    out.write(os.path.join(folder, "%s-%d.glb" % (room.name, frame)))


# ---- The moving ones ----

class Animation:
    def __init__(self, out):
        self.out, self.samplers, self.channels, self.inputs = out, [], [], {}

    def times(self, frames):
        key = tuple(frames)
        if key not in self.inputs:
            self.inputs[key] = self.out.accessor([(f / glb.FPS,) for f in frames], "SCALAR", bounds=True)
        return self.inputs[key]

    def add(self, node, path, frames, values, kind, step=False):
        self.samplers.append({"input": self.times(frames), "output": self.out.accessor(values, kind),
                              "interpolation": "STEP" if step else "LINEAR"})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def show(self, node, shown):
        """By an accessor of bytes, as KHR_animation_pointer has it for booleans."""
        accessor = {"bufferView": self.out.view(bytes(shown)), "componentType": 5121, "count": len(shown), "type": "SCALAR"}
        self.out.json["accessors"].append(accessor)
        self.point("/nodes/%d/extensions/KHR_node_visibility/visible" % node, len(shown), len(self.out.json["accessors"]) - 1, True)

    def point(self, pointer, count, output, step=False):
        self.samplers.append({"input": self.times(range(count)), "output": output, "interpolation": "STEP" if step else "LINEAR"})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}})
        self.out.extensions.append("KHR_animation_pointer")

    def change(self, what, changes, step=False):
        for pointer, values in changes.items():
            rows = [v if isinstance(v, tuple) else (v,) for v in values]
            kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[len(rows[0])]
            self.point("%s/%s" % (what, pointer), len(rows), self.out.accessor(rows, kind), step)


def quaternion(axis, angle):
    q = [0.0, 0.0, 0.0, math.cos(0.5 * angle)]
    q["xyz".index(axis)] = math.sin(0.5 * angle)
    return tuple(q)


def add_way(out, animation, way, extra):
    """The node of a way, with the parents that it hangs on."""
    if way.under and way.under.number is None:
        add_way(out, animation, way.under, {})
    node = dict(extra, name="way %d" % len(out.json["nodes"]), translation=list(way.position(0)),
                rotation=list(quaternion(way.axis, way.angle)))
    if way.scale:
        node["scale"] = list(way.scale[0])
    if way.shown:
        node["extensions"] = dict(node.get("extensions", {}), KHR_node_visibility={"visible": bool(way.shown[0])})
        out.extensions.append("KHR_node_visibility")
    way.number = out.node(node, way.under.number if way.under else None)
    if isinstance(way.at, list):
        animation.add(way.number, "translation", way.keys or range(len(way.at)), way.at, "VEC3", not way.keys)
    elif way.to is not None:
        animation.add(way.number, "translation", (0, LAST), [way.at, way.to], "VEC3")
    if way.angle_to is not None:
        animation.add(way.number, "rotation", (0, LAST),
                      [quaternion(way.axis, way.angle), quaternion(way.axis, way.angle_to)], "VEC4")
    if way.scale:
        animation.add(way.number, "scale", range(len(way.scale)), way.scale, "VEC3")
    if way.shown:
        animation.show(way.number, way.shown)


def add_bones(out, primitive, thing):
    """Weights of up to four joints, and the skin."""
    joints = [(0.0, 1.0, 2.0, 3.0)] * len(thing.bones)
    data = bytes(int(j) for row in joints for j in row)
    out.json["accessors"].append({"bufferView": out.view(data, 34962), "componentType": 5121, "count": len(joints),
                                  "type": "VEC4"})
    primitive["attributes"]["JOINTS_0"] = len(out.json["accessors"]) - 1
    primitive["attributes"]["WEIGHTS_0"] = out.accessor([tuple(row) + (0.0,) * (4 - len(row)) for row in thing.bones], "VEC4")
    numbers = [joint.number for joint in thing.joints] + [thing.joints[0].number] * (4 - len(thing.joints))
    out.json.setdefault("skins", []).append({"joints": numbers})
    return len(out.json["skins"]) - 1


def write_moving(room, folder):
    out = room.file(folder, moving=True)
    animation = Animation(out)
    for thing in room.things:
        mesh = out.add_mesh(thing.name, thing.mesh, room.look(thing, 0))
        extra = {"mesh": mesh}
        primitive = out.json["meshes"][mesh]["primitives"][0]
        for joint in thing.joints or []:
            if joint.number is None:
                add_way(out, animation, joint, {})
        if thing.joints:
            extra["skin"] = add_bones(out, primitive, thing)
        if thing.morph:
            primitive["targets"] = [{"POSITION": out.accessor(thing.morph[0], "VEC3", bounds=True)}]
            out.json["meshes"][mesh]["weights"] = [thing.morph[1][0]]
        for way in thing.ways:
            add_way(out, animation, way, extra)
            if thing.morph:
                weights = thing.morph[1]
                animation.add(way.number, "weights", range(len(weights)), [(w,) for w in weights], "SCALAR")
    for name, description, place, towards in room.lamps:
        out.light(name, description, place, towards)
    for lamp in room.changing_lamps:
        node = {}
        number = add_light(out, dict(changed(lamp.description, lamp.changes, 0), name=lamp.name), node)
        add_way(out, animation, lamp.way, node)
        animation.change("/extensions/KHR_lights_punctual/lights/%d" % number, lamp.changes, lamp.step)
    for name, changes in room.changes.items():
        animation.change("/materials/%d" % out.materials[name], changes)
    if room.yfov:
        animation.change("/cameras/0/perspective", {"yfov": [math.radians(y) for y in room.yfov]})
    if animation.channels:
        camera = out.json["animations"][0]
        shift = len(camera["samplers"])
        camera["samplers"] += animation.samplers
        camera["channels"] += [dict(c, sampler=c["sampler"] + shift) for c in animation.channels]
    out.write(os.path.join(folder, room.name + ".glb"))


# ---- The cases ----

WHITE, RED, GREEN = lambert("white", [0.7, 0.7, 0.68]), lambert("red", [0.6, 0.2, 0.15]), lambert("green", [0.2, 0.5, 0.2])
LACQUER = material("lacquer", [0.5, 0.5, 0.55], roughness=0.3)
BRASS = material("brass", [0.8, 0.65, 0.4], metallic=1.0, roughness=0.35)
MIRROR = dict(material("mirror", [0.9, 0.9, 0.9]), extras={"reframe": {"bsdf": "mirror", "specular": [0.9, 0.9, 0.9]}})
GLOSSY = material("glossy", [0.9, 0.9, 0.9], metallic=1.0, roughness=0.12)


def shining(name, strength):
    return material(name, [0.0, 0.0, 0.0], specular=0.0, emissive=[1.0, 1.0, 1.0], strength=strength, double_sided=False)


def blended(name, color, alpha):
    result = material(name, color, roughness=0.4)
    result["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha
    result["alphaMode"] = "BLEND"
    return result


def pane(name):
    result = material(name, [0.8, 1.0, 0.9], roughness=0.0)
    result["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5}}
    return result


def leaf(name, color, through):
    """Scatters light to both sides."""
    result = material(name, color, roughness=0.4)
    result["extensions"] = {"KHR_materials_diffuse_transmission": {
        "diffuseTransmissionFactor": through, "diffuseTransmissionColorFactor": color[::-1]}}
    return result


def furnish(room, lamp=True, floor=LACQUER, ceiling=True):
    """A closed room, x -2 to 2, y 0 to 3, z -2 to 2, with a lamp in its ceiling and a block."""
    looks = {"floor": floor, "left wall": RED, "right wall": GREEN}
    for name, mesh in make_room((-2.0, 0.0, -2.0), (2.0, 3.0, 2.0)).items():
        if ceiling or name != "ceiling":
            room.still(name, mesh, looks.get(name, WHITE))
    if lamp:
        room.still("lamp", make_quad((-0.5, 2.95, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), shining("lamp", 12.0))
    room.still("block", make_box((0.6, 0.7, 0.6), 0.4), BRASS, (-0.8, 0.0, -0.9))


def view(name, from_x=-0.6, to_x=0.6, **named):
    return Room(name, ((from_x, 1.5, 1.8), (to_x, 1.6, 1.7)), ((-0.1, 1.0, -1.0), (0.1, 1.0, -1.0)), **named)


def sweep():
    """Something passes between lamp, wall and eye; the camera passes behind it. A part hangs on it."""
    room = view("sweep", 1.1, -1.1)
    furnish(room)
    way = Way((-1.0, 0.3, 0.7), (1.0, 0.5, 0.9), "y", -0.4, 0.9)
    room.move("panel", make_box((0.5, 1.5, 0.12)), LACQUER, [way])
    room.move("part", make_sphere(0.35, 8, 6), WHITE, [Way((0.2, 2.0, -0.6), (-0.2, 1.8, -0.9), under=way)])
    return room


def door():
    """A door opens on a bright room, from which all light comes."""
    room = view("door")
    furnish(room, lamp=False)
    room.things = [t for t in room.things if t.name != "back wall"]
    for corner, u in (((-2.0, 0.0, -2.0), (1.5, 0.0, 0.0)), ((0.5, 0.0, -2.0), (1.5, 0.0, 0.0))):
        room.still("back wall", make_quad(corner, u, (0.0, 3.0, 0.0)), WHITE)
    room.still("lintel", make_quad((-0.5, 2.0, -2.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), WHITE)
    for name, mesh in make_room((-1.5, 0.0, -4.0), (1.5, 3.0, -2.02)).items():
        if name != "front wall":
            room.still("bright " + name, mesh, WHITE)
    room.still("lamp", make_quad((-1.0, 2.9, -3.5), (2.0, 0.0, 0.0), (0.0, 0.0, 1.0)), shining("lamp", 20.0))
    hinge = Way((-0.5, 0.0, -2.0), None, "y", 0.15, -1.5)
    room.move("door", make_box((0.98, 1.98, 0.05)), LACQUER, [Way((0.5, 0.01, 0.0), under=hinge)])
    return room


def mirrors():
    """A perfect mirror and a glossy one turn, beside one that stands still."""
    room = view("mirrors")
    furnish(room)
    room.still("still mirror", make_quad((-1.95, 0.5, 1.0), (0.0, 0.0, -2.0), (0.0, 1.6, 0.0)), MIRROR)
    quad = make_quad((-0.5, -0.6, 0.0), (1.0, 0.0, 0.0), (0.0, 1.2, 0.0))
    room.move("mirror", quad, MIRROR, [Way((0.1, 0.9, -0.7), None, "y", -0.7, 0.7)])
    room.move("glossy", copy.deepcopy(quad), GLOSSY, [Way((1.3, 0.9, -0.6), None, "y", 0.3, -1.0)])
    return room


def fan():
    """Two blades turn by 84 degrees from frame to frame, below the lamp and before the eye."""
    room = view("fan")
    furnish(room)
    axle = Way((0.2, 1.4, -0.2), None, "z", 0.2, 9.0)
    room.move("blade", make_box((1.6, 0.25, 0.06)), LACQUER, [Way((0.0, -0.125, 0.0), under=axle)])
    room.move("other blade", make_box((0.25, 1.2, 0.06)), WHITE, [Way((0.0, -0.6, 0.1), under=axle)])
    room.stills = []
    return room


def column(height, rows):
    """A square column of rows of vertices around the y axis."""
    mesh = Mesh()
    for side in range(4):
        a = math.pi * (0.25 + 0.5 * side)
        u, v = (0.25 * math.sin(a), 0.25 * math.cos(a)), (0.25 * math.sin(a + 0.5 * math.pi), 0.25 * math.cos(a + 0.5 * math.pi))
        normal = (math.sin(a + 0.25 * math.pi), 0.0, math.cos(a + 0.25 * math.pi))
        first = len(mesh.positions)
        for row in range(rows + 1):
            for x, z in (u, v):
                mesh.vertex((x, height * row / rows, z), normal, (0.0, row / rows))
        for row in range(rows):
            i = first + 2 * row
            mesh.indices += [i, i + 1, i + 3, i, i + 3, i + 2]
    return mesh


def bones_of(mesh, height, count):
    """Each vertex between the two joints next to it by height."""
    rows = []
    for x, y, z in mesh.positions:
        at = min(max(y / height, 0.0), 1.0) * (count - 1)
        rows.append([max(0.0, 1.0 - abs(at - j)) for j in range(count)])
    return rows


def figure():
    """A column bends by three joints, and a ball swells by a morph target."""
    room = view("figure")
    furnish(room)
    mesh = column(1.6, 6)
    root = Way((0.5, 0.1, -0.3), (0.0, 0.1, 0.2), "y", 0.0, 0.6)
    middle = Way((0.0, 0.0, 0.0), None, "z", -0.2, 0.3, under=root)
    top = Way((0.0, 0.1, 0.0), (0.2, 0.0, 0.0), "x", 0.0, 0.5, under=middle)
    room.move("figure", mesh, LACQUER, [Way((7.0, 7.0, 7.0))], joints=[root, middle, top], bones=bones_of(mesh, 1.6, 3))
    ball = make_sphere(0.3, 8, 6)
    wide = [(0.9 * x, 0.0, 0.9 * z) for x, y, z in ball.positions]
    room.move("ball", ball, WHITE, [Way((-0.4, 2.3, 0.3))], morph=(wide, [f / LAST for f in range(FRAMES)]))
    return room


def shown():
    """A screen and a lid under the lamp are there in some frames only."""
    room = view("shown")
    furnish(room)
    room.move("screen", make_box((0.6, 1.4, 0.1)), LACQUER, [Way((0.5, 0.0, 0.2), shown=HALF)])
    room.move("lid", make_quad((-0.4, 2.6, -0.4), (0.9, 0.0, 0.0), (0.0, 0.0, 0.7)), WHITE,
              [Way(shown=[1 - s for s in HALF])])
    return room


def panes():
    """A curtain that lets half of the light through and a pane of glass move; balls are one mesh."""
    room = view("panes")
    furnish(room)
    quad = make_quad((-0.6, 0.0, 0.0), (1.2, 0.0, 0.0), (0.0, 1.6, 0.0))
    room.move("curtain", quad, blended("curtain", [0.8, 0.5, 0.4], 0.5), [Way((-0.9, 0.7, 0.3), (0.6, 0.9, 0.5), "y", 0.3, -0.3)])
    room.move("pane", copy.deepcopy(quad), pane("pane"), [Way((1.0, 0.4, -0.6), (-0.6, 0.9, -0.2), "y", -0.5, 0.4)])
    room.move("balls", make_sphere(0.2, 8, 6), BRASS,
              [Way((1.2, 0.3, 0.2), (0.9, 1.0, -0.3)), Way((0.2, 2.5, -0.2), (-0.5, 2.0, 0.0))])
    return room


def drapes():
    """A curtain that scatters light to both sides passes before a lamp, and a shade turns."""
    room = view("drapes")
    furnish(room, lamp=False)
    room.still("lamp", make_quad((-0.9, 0.8, -1.9), (1.8, 0.0, 0.0), (0.0, 1.2, 0.0)), shining("lamp", 12.0))
    room.move("curtain", make_quad((-0.8, 0.0, 0.0), (1.6, 0.0, 0.0), (0.0, 2.2, 0.1)), leaf("curtain", [0.5, 0.4, 0.3], 0.6),
              [Way((-0.9, 0.2, -0.6), (0.7, 0.3, 0.3), "y", 0.4, -0.5)])
    room.move("shade", make_box((0.5, 0.6, 0.5)), leaf("shade", [0.9, 0.7, 0.5], 0.9), [Way((0.9, 0.6, -0.3), (0.6, 1.0, 0.1), "y", 0.0, 1.2)])
    return room


def sky():
    """The light of a sky comes through an opening that moves: a slab passes over a hole."""
    room = view("sky", sky={"radiance": [3.0, 3.5, 4.0]})
    furnish(room, lamp=False, ceiling=False)
    for corner, u, v in (((-2.0, 3.0, -2.0), (4.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ((-2.0, 3.0, 1.0), (4.0, 0.0, 0.0), (0.0, 0.0, 1.0))):
        room.still("roof", make_quad(corner, u, v), WHITE)
    slab = make_box((1.2, 0.1, 2.4))
    room.move("slabs", slab, WHITE, [Way((-2.3, 3.02, 0.0), (-0.9, 3.02, 0.0)), Way((0.6, 3.02, 0.0), (2.0, 3.02, 0.0))])
    return room


# ---- Hard cases ----

def around_eye():
    """A box, open above, is around the camera in one frame."""
    room = view("around-eye")
    furnish(room)
    box = make_box((2.4, 2.1, 1.9))
    del box.indices[24:30]
    room.move("box", box, WHITE, [Way((0.0, 0.4, 1.0), shown=[0, 0, 0, 1, 0, 0, 0])])
    return room


def flat():
    """Scales of 0 along one axis, two and all."""
    room = view("flat")
    furnish(room)
    sizes = [(1.0, 1.0, 1.0), (1.0, 0.5, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.5, 0.5, 0.5), (0.0, 1.0, 0.0), (0.0, 1.0, 1.0)]
    room.move("box", make_box((1.2, 0.8, 0.9)), WHITE, [Way((0.6, 1.0, -0.4), scale=sizes)])
    room.move("ball", make_sphere(0.4, 8, 6), LACQUER, [Way((-0.4, 1.8, 0.2), scale=sizes[3:] + sizes[:3])])
    return room


def singular():
    """A skin whose joints lose a dimension, or all."""
    room = view("singular")
    furnish(room)
    mesh = column(1.6, 6)
    one = (1.0, 1.0, 1.0)
    root = Way((0.2, 0.1, 0.0), (0.0, 0.1, 0.2), "y", 0.0, 0.6, scale=[one, one, (1.0, 0.0, 1.0), (1.0, 1.0, 0.0), one, (0.0,) * 3, one])
    top = Way((0.0, 0.2, 0.0), None, "z", -0.3, 0.4, under=root, scale=[one, (0.0,) * 3, one, one, (0.0, 1.0, 1.0), one, one])
    room.move("figure", mesh, WHITE, [Way()], joints=[root, top], bones=bones_of(mesh, 1.6, 2))
    return room


def late():
    """Nothing stands still, nor is there at the beginning."""
    room = view("late", sky={"radiance": [1.0, 1.1, 1.3]})
    there = [0, 0, 1, 1, 1, 0, 1]
    room.move("ground", make_quad((-3.0, 0.0, 3.0), (6.0, 0.0, 0.0), (0.0, 0.0, -6.0)), WHITE,
              [Way((-0.5, 0.0, 0.0), (0.5, 0.1, 0.0), shown=there)])
    room.move("block", make_box((0.7, 1.2, 0.7)), LACQUER, [Way((0.4, 0.0, -0.4), (-0.6, 0.2, -0.1), "y", 0.0, 1.2, shown=there)])
    return room


def no_area():
    """Triangles without an area move along with a box."""
    room = view("no-area")
    furnish(room)
    box = make_box((0.6, 1.0, 0.6))
    corner = box.vertex((0.3, 1.6, 0.3), (0.0, 1.0, 0.0), (0.0, 0.0))
    box.indices += [corner, corner, corner, 0, 0, corner]
    needle = Mesh()
    for x in (0.0, 0.5, 1.0):
        needle.vertex((x, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0))
    needle.indices += [0, 1, 2]
    room.move("box", box, WHITE, [Way((-0.2, 0.0, 0.4), (0.8, 0.3, -0.4), "y", 0.0, 1.0)])
    room.move("needle", needle, WHITE, [Way((-0.2, 1.0, 0.4), (0.8, 1.3, -0.4))])
    return room


def far_out():
    """Things go 1000 km away and come back."""
    room = view("far-out")
    furnish(room)
    near, far = (0.4, 0.2, 0.1), (8e5, 6e5, -5e5)
    room.move("box", make_box((0.6, 1.2, 0.6)), WHITE, [Way([far, near, far, near, far, far, near])])
    room.move("ball", make_sphere(0.4, 8, 6), LACQUER, [Way([near, far, near, far, near, far, near])])
    return room


def short_path():
    """A path of three frames."""
    room = sweep()
    room.name, room.frames = "short-path", 3
    return room


def plate():
    """A plate covers the sun for a moment, far beyond where it is at other times."""
    room = view("plate", sky={"radiance": [0.2, 0.2, 0.2]})
    furnish(room, lamp=False, ceiling=False)
    room.lamps.append(("sun", {"type": "directional", "intensity": 5.0}, (0.0, 5.0, 0.0), (0.01, 0.0, 0.01)))
    below, above = (0.0, -9.0, 0.0), (-18.0, 9e3, -18.0)
    room.move("plate", make_quad((-4.0, 0.0, 4.0), (8.0, 0.0, 0.0), (0.0, 0.0, -8.0)), WHITE,
              [Way([below, below, above, below, below], keys=[0.0, 2.99, 3.0, 3.01, 6.1])])
    return room


def apart():
    """What moves is outside of the room."""
    room = view("apart")
    furnish(room)
    room.move("box", make_box((0.6, 1.2, 0.6)), WHITE, [Way((4.0, 0.2, 0.1), (5.0, 0.3, 0.2), "y", 0.1, 1.0)])
    return room


def lamps():
    """A sun, a point lamp and a faint sky light a ball and a block that move, one of them of clear glass."""
    room = view("lamps", sky={"radiance": [0.3, 0.35, 0.5], "visible": False})
    furnish(room, lamp=False, ceiling=False)
    room.lamps.append(("sun", {"type": "directional", "intensity": 2.0}, (0.0, 5.0, 0.0), (0.8, 0.0, -1.0)))
    room.lamps.append(("lamp", {"type": "point", "intensity": 3.0}, (-1.2, 2.0, 0.8), (0.0, 0.0, 0.0)))
    room.move("ball", make_sphere(0.4, 12, 8), glass("glass"), [Way((0.8, 0.5, 0.2), (-0.2, 0.6, 0.4))])
    room.move("block", make_box((0.5, 0.9, 0.5)), LACQUER, [Way((0.9, 0.9, -0.9), (0.3, 1.8, 0.3), "y", 0.0, 1.0)])
    return room


def shade():
    """A lid passes close under the only lamp: over the path it is before every part of it."""
    room = view("shade")
    furnish(room)
    room.move("lid", make_quad((-0.2, 2.9, -0.6), (0.4, 0.0, 0.0), (0.0, 0.0, 1.2)), WHITE, [Way((-0.6, 0.0, 0.0), (0.6, 0.0, 0.0))])
    room.stills = []
    return room


def many():
    """Ten thousand nodes that move."""
    room = view("many")
    furnish(room)
    ways = []
    for i in range(10000):
        x, y, z = i % 100, i // 100 % 10, i // 1000
        at = (-1.9 + 0.038 * x, 0.3 + 0.2 * y, -1.8 + 0.2 * z)
        ways.append(Way(at, add(at, (0.02, 0.1, 0.03)), "y", 0.01 * i))
    room.move("leaf", make_quad((0.0, 0.0, 0.0), (0.02, 0.0, 0.0), (0.0, 0.02, 0.01)), GREEN, ways)
    room.stills = [3]
    return room


CASES = (sweep, door, mirrors, fan, figure, shown, panes, drapes, sky, around_eye, flat, singular, late, no_area, far_out,
         short_path, plate, apart, lamps, shade, many)


def write_rooms(cases, folder):
    os.makedirs(folder, exist_ok=True)
    for case in cases:
        write_moving(case(), folder)
        room = case()
        for frame in room.stills:
            write_still(room, frame, folder)


def main():
    import changing_rooms  # which uses this file
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    write_rooms(CASES + changing_rooms.CASES, sys.argv[1])


if __name__ == "__main__":
    main()
