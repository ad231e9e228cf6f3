"""Bakes what glTF cannot express into textures, with Cycles, object by object.

A channel that varies is wired into an emission, so a bake gives its values and not light; the normal is baked as
such. Objects that share a mesh share the bake, unless their materials depend on the object.
"""
import contextlib
import hashlib
import math
import os
import time

import bmesh
import bpy
import mathutils
import numpy

from . import gloss, shader_tree
from .channels import (ADDED, DIRECTIONS, LAYER, MEANS, NUMBERS, Ref, STEP, WORDS, coordinates_of, is_constant, is_read, make_textures,
                       means_of)
from .messages import note, warn
from .plans import tell_view
from .shader_tree import SKIPPED

SMALLEST = 128  # pixels across
SIDES = 3.0  # pixels of a texture's side for each pixel across the object: it shows the back as well
MOST_VIEWS = 50
OWN_PLACE = {"OBJECT_INFO": None, "PARTICLE_INFO": None, "HAIR_INFO": None, "VECT_TRANSFORM": None, "CAMERA": None,
             "AMBIENT_OCCLUSION": None, "BEVEL": None, "TEX_POINTDENSITY": None,
             "NEW_GEOMETRY": ("Position", "Normal", "True Normal", "Incoming", "Parametric"),
             "TEX_COORD": ("Camera", "Window", "Reflection")}


PASSES_OF = {"alpha": ("base", "numbers"), "roughness": ("numbers",), "metallic": ("numbers",)}  # of others their own


class Job:
    """Objects that share a bake: one mesh, and the plans of those of its slots that need one."""

    def __init__(self, plans, own_place, only=None):
        self.objects, self.plans, self.own_place = [], plans, own_place
        self.only = only  # passes; None: all

    def at(self, i):
        """As it is in an exported frame: those passes that change."""
        plans = {slot: p if p.changes is None else p.changes.plan_at(i) for slot, p in self.plans.items()}
        played = set().union(*(p.changes.played for p in self.plans.values() if p.changes is not None))
        return Job(plans, self.own_place, sorted({kind for n in played for kind in PASSES_OF.get(n, (n,))}))

    def passes(self):
        """The names of all that are baked."""
        found = self.all_passes()
        return found if self.only is None else [kind for kind in found if kind in self.only]

    def all_passes(self):
        wanted = set().union(*(p.baked for p in self.plans.values()))
        averaged = set().union(*(p.averaged for p in self.plans.values()))
        found = [n for n in ("base", "emission", "normal", *ADDED) if n in wanted]
        found += ["numbers"] if wanted & set(NUMBERS) else []
        return found + ["means %d" % i for i, group in enumerate(MEANS) if averaged & set(group)]

    def words(self):
        names = set().union(*(p.baked | p.averaged for p in self.plans.values()))
        return ", ".join(dict.fromkeys(WORDS[n] for n in WORDS if n in names))


def depends_on_place(plan):
    """Do two objects with the same mesh look different?"""
    for node in plan.copy.node_tree.nodes:
        if node.type in OWN_PLACE and (OWN_PLACE[node.type] is None or any(node.outputs[n].is_linked for n in OWN_PLACE[node.type])):
            return True
        if node.type == "TEX_COORD" and node.object is not None or node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
            return True
    return False


def sort_jobs(to_bake):
    jobs = {}
    for o, plans in to_bake.items():
        own_place = any(depends_on_place(p) for p in plans.values())
        key = (o.name,) if own_place else (o.data.name_full, tuple(sorted((i, p.material.name_full) for i, p in plans.items())))
        jobs.setdefault(key, Job(plans, own_place)).objects.append(o)
    return list(jobs.values())


class Views:
    """From where objects are seen, which decides on the size of their textures."""

    def __init__(self, recorder, height, largest, placed):
        keys = recorder.keys
        few = keys[::max(len(keys) // MOST_VIEWS, 1)] + keys[-1:]
        self.parallel = recorder.projection == "orthographic"

        def focal(extent):
            """In pixels; of an orthographic camera pixels per metre, of a panorama pixels per radian."""
            if self.parallel:
                return 0.5 * height / extent
            return height / math.pi if extent is None else 0.5 * height / math.tan(0.5 * math.radians(extent))

        self.eyes = [(place, focal(extent)) for _, place, _, extent, _ in few]
        self.largest, self.placed = largest, placed

    def pixels(self, o):
        """How large an object is in the picture at most; infinite where the camera is in or near it."""
        if o.name in self.placed:
            return math.inf
        corners = [o.matrix_world @ mathutils.Vector(c) for c in o.bound_box]
        centre = sum(corners, mathutils.Vector()) / 8.0
        radius = max((c - centre).length for c in corners)
        if self.parallel:
            return max(2.0 * radius * focal for _, focal in self.eyes)
        near = [((place - centre).length, focal) for place, focal in self.eyes]
        return max(2.0 * radius / d * focal if d > 2.0 * radius else math.inf for d, focal in near)

    def side(self, job):
        pixels = min(SIDES * max(self.pixels(o) for o in job.objects), texels_of(job))
        side = min(SMALLEST, self.largest)
        while side < min(pixels, self.largest):
            side *= 2
        return min(side, self.largest)


# How fine a bake can be at most: as fine as the images behind it, where nothing else is.

FILLED = 0.5  # of a texture's pixels have faces, or more
OPERATIONS = ("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "MINIMUM", "MAXIMUM", "ABSOLUTE", "SCALE", "POWER", "SQRT")
SMOOTH = {"MATH": ("operation", OPERATIONS), "VECT_MATH": ("operation", OPERATIONS),
          "VALTORGB": ("color_ramp.interpolation", ("LINEAR", "EASE", "B_SPLINE", "CARDINAL")),
          "MAP_RANGE": ("interpolation_type", ("LINEAR", "SMOOTHSTEP", "SMOOTHERSTEP"))}
SMOOTH.update({kind: None for kind in (
    "MIX", "MIX_RGB", "INVERT", "HUE_SAT", "BRIGHTCONTRAST", "GAMMA", "CURVE_RGB", "CURVE_VEC", "CURVE_FLOAT", "RGBTOBW", "CLAMP", "VALUE",
    "RGB", "SEPARATE_COLOR", "COMBINE_COLOR", "SEPRGB", "COMBRGB", "SEPXYZ", "COMBXYZ", "NORMAL_MAP", "FRESNEL", "LAYER_WEIGHT")})


def is_smooth(node):
    """Does a node make no detail of its own?"""
    if node.type not in SMOOTH:
        return False
    if SMOOTH[node.type] is None:
        return True
    name, allowed = SMOOTH[node.type]
    return node.path_resolve(name) in allowed


def images_behind(plan):
    """The image nodes behind what a plan bakes; None where there is more."""
    tree, images, done = plan.copy.node_tree, [], set()
    values = [getattr(plan.surface, n) for n in plan.baked | plan.averaged]
    left = [tree.nodes[v.node] for v in values if isinstance(v, Ref)]
    while left:
        node = left.pop()
        if node.name in done:
            continue
        done.add(node.name)
        if node.type == "TEX_IMAGE":
            is_still = is_read(node.image) and node.image.source in ("FILE", "GENERATED")
            if not is_still or node.projection != "FLAT" or node.interpolation == "Closest" or coordinates_of(node) is None:
                return None
            images.append(node)
        elif is_smooth(node):
            left += [link.from_node for i in node.inputs for link in i.links]
        else:
            return None
    return images


def texels_of(job):
    """The side of a texture in which every pixel of the images that are baked finds one; infinite where more than images is baked."""
    mesh = job.objects[0].data
    images = [(slot, node) for slot, plan in job.plans.items() for node in images_behind(plan) or (None,)]
    if any(node is None for _, node in images) or any(p.changes is not None for p in job.plans.values()):
        return math.inf
    mesh.calc_loop_triangles()
    corners, slots = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32), numpy.empty(len(mesh.loop_triangles), numpy.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    mesh.loop_triangles.foreach_get("material_index", slots)
    corners, slots = corners.reshape(-1, 3), numpy.clip(slots, 0, max(len(mesh.materials) - 1, 0))
    vertices, points = numpy.empty(len(mesh.loops), numpy.int32), numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.loops.foreach_get("vertex_index", vertices)
    mesh.vertices.foreach_get("co", points)
    areas = areas_of(points.reshape(-1, 3)[vertices][corners])
    whole, most = areas[numpy.isin(slots, list(job.plans))].sum(), 0.0
    for slot, node in images:
        name, turn = coordinates_of(node)
        layer = mesh.uv_layers.get(name or default_layer(mesh))
        if layer is None:
            continue  # one texel
        uvs = numpy.empty(2 * len(mesh.loops), numpy.float32)
        layer.data.foreach_get("uv", uvs)
        shown = (slots == slot) & (areas > 1e-6 * whole)
        scale = numpy.prod(numpy.array(node.image.size, float) * (turn[2] if turn else 1.0))
        texels = areas_of(numpy.pad(uvs.reshape(-1, 2), ((0, 0), (0, 1)))[corners[shown]]) * abs(scale)
        most = max(most, quantile(texels / areas[shown], areas[shown]))
    return math.sqrt(most * whole / FILLED)


def areas_of(triangles):
    return 0.5 * numpy.linalg.norm(numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)


def quantile(values, weights):
    """Nine tenths of the area have less."""
    if len(values) == 0:
        return 0.0
    order = numpy.argsort(values)
    return float(values[order][numpy.searchsorted(numpy.cumsum(weights[order]), 0.9 * weights.sum())])


def bake_job(job, side, cache):
    """Bakes, or takes from the cache; gives the objects their new mesh. Returns the pixels, and whether they were baked."""
    first = job.objects[0]
    mesh = own_mesh(first)
    faces = faces_of(mesh, job.plans)
    if not faces.any():
        return mesh, None, False, None
    loops = loops_of(mesh, faces)
    part = part_of(mesh, faces)
    result, fresh, key = find_or_bake(first, part, job, side, cache, len(loops))
    frames, baked = bake_frames(first, part, job, side, cache, result)
    bpy.data.meshes.remove(part)
    add_layer(mesh, result["uv"], loops)
    if frames is not None:
        result, fresh, key = {**frames[0], "frames": frames}, fresh or baked, None
    return mesh, result, fresh, key


def find_or_bake(o, part, job, side, cache, corners, uvs=None):
    """The pixels, whether they were baked, and their key. `uvs`: the coordinates, where they are given."""
    key = cache_key(o, part, job, side)
    result = cache.find(key)
    fresh = result is None or len(result["uv"]) != corners or uvs is not None and not numpy.array_equal(result["uv"], uvs)
    if fresh:
        result = bake_part(o, part.copy(), job, side, uvs)
        cache.keep(key, result)
    return result, fresh, key


MOST_PIXELS = 1 << 26  # of the bakes of all frames of one object


def bake_frames(o, part, job, side, cache, result):
    """The pixels of every exported frame, and whether any were baked; None where no bake changes. Those of passes that stand still are
    those of `result`."""
    changing = [p for p in job.plans.values() if p.changes is not None and p.changes.played]
    if not changing:
        return None, False
    known, frames, any_fresh = {}, [], False
    count = len(set(zip(*(p.changes.states.of_frames for p in changing))))
    passes = len(job.at(0).passes())
    if count * passes * side * side > MOST_PIXELS:
        fits = 16
        while count * passes * (2 * fits) ** 2 <= MOST_PIXELS:
            fits *= 2
        changing[0].lose(None, "changes over %d frames, whose textures of %d pixels across are more than are baked: taken as in one of "
                         "them: give --bake %d or less" % (count, side, fits))
        return None, False
    for i in range(len(changing[0].changes.states.of_frames)):
        now = job.at(i)
        state = tuple(id(p) for p in now.plans.values())
        if state not in known:
            with contextlib.ExitStack() as shown:
                for p in job.plans.values():
                    if p.changes is not None:
                        shown.enter_context(p.changes.films_at(i))
                pixels, fresh, _ = find_or_bake(o, part, now, side, cache, len(result["uv"]), result["uv"])
            any_fresh |= fresh
            known[state] = {name: v if name == "uv" else v.astype(numpy.float16) for name, v in {**result, **pixels}.items()}
        frames.append(known[state])
    return frames, any_fresh


def bake_objects(to_bake, views, folder, is_solid, build):
    """Bakes what the plans of objects ask for; returns the slots (object, number, material) to be set."""
    jobs, cache = sort_jobs(to_bake), Cache(folder)
    new, made, known, seen = [], {}, {}, {}
    for i, job in enumerate(jobs):
        start, side = time.monotonic(), views.side(job)
        name = job.objects[0].name
        try:
            mesh, result, fresh, key = bake_job(job, side, cache)
        except Exception as e:  # Blender's bake fails for reasons of its own
            warn("'%s': could not be baked: taken as constant: %s" % (name, " ".join(str(e).split())[:200]))
            mesh, result, fresh, key = job.objects[0].data, None, False, None
        solid = {slot: is_solid(p, job.objects[0]) for slot, p in job.plans.items()}
        same = (key, tuple(sorted((slot, id(p), solid[slot]) for slot, p in job.plans.items())))
        materials = known.get(same) if key is not None else None
        if materials is None:
            materials = known[same] = make_materials(job, name, result, solid, made, build, mesh)
        for o in job.objects:
            o.data = mesh
            new += [(o, slot, material) for slot, material in materials.items()]
        if result is None:
            continue
        for plan in job.plans.values():
            seen.setdefault(plan, []).extend(result["shares"])
        note("baked %d of %d: '%s' at %dx%d: %s: %s" % (i + 1, len(jobs), name, side, side, job.words(),
                                                        "%.1f s" % (time.monotonic() - start) if fresh else "from the cache"))
    for plan, shares in seen.items():
        tell_view(plan, min(shares), max(shares))
    cache.tell()
    return new


def make_materials(job, name, result, solid, made, build, mesh):
    """The materials of the slots of a job; `made` counts those of each plan. Without pixels they are constant."""
    textures = make_textures(name, result) if result is not None else None
    if textures is not None:
        textures["place"] = mesh.uv_layers.find(LAYER)
    materials = {}
    for slot, plan in job.plans.items():
        made[plan] = made.get(plan, 0) + 1
        plain = plan.free_name()
        means = means_of(plan, result) if result is not None else None
        factor, summand = plan.lifted
        most = float(((result["base"] - numpy.float32(summand)) / factor).max()) if "base" in plan.baked and result is not None else 0.0
        if most > 1.0 + STEP:
            plan.tell(None, "reflects up to %.2g times the light that arrives in Blender: 1 at most here" % most)
        materials[slot] = build(plan, plain if made[plan] == 1 else "%s %s" % (plain, name), textures, means, solid[slot])
    return materials


# Bakes one object: its faces over coordinates of their own, alone in a scene of its own.

SAMPLES = 4
MARGIN = 8  # pixels around each island, against seams
NOTHING = -1e30  # marks pixels that no face has; margins of Blender 5 mix a little of it into some


def own_mesh(o):
    """A copy of the mesh of an object, with all its materials."""
    mesh = o.data.copy()
    for i, slot in enumerate(o.material_slots):
        mesh.materials[i] = slot.material
    return mesh


def faces_of(mesh, slots):
    indices = numpy.empty(len(mesh.polygons), numpy.int32)
    mesh.polygons.foreach_get("material_index", indices)
    return numpy.isin(numpy.clip(indices, 0, max(len(mesh.materials) - 1, 0)), list(slots))


def loops_of(mesh, faces):
    """The numbers of the loops of some faces, in order."""
    counts = numpy.empty(len(mesh.polygons), numpy.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    return numpy.flatnonzero(numpy.repeat(faces, counts))


def part_of(mesh, faces):
    part = mesh.copy()
    if not faces.all():
        work = bmesh.new()
        work.from_mesh(part)
        work.faces.ensure_lookup_table()
        bmesh.ops.delete(work, geom=[work.faces[i] for i in numpy.flatnonzero(~faces)], context="FACES")
        work.to_mesh(part)
        work.free()
    return part


def default_layer(mesh):
    return next((layer.name for layer in mesh.uv_layers if layer.active_render), "reframe none")


def add_layer(mesh, uvs=None, loops=None):
    """Adds the coordinates; the mesh keeps the set it uses by default, for Reframe reads two."""
    keep = default_layer(mesh)
    for name in [layer.name for layer in mesh.uv_layers]:
        if name != keep:
            mesh.uv_layers.remove(mesh.uv_layers[name])
    layer = mesh.uv_layers.new(name=LAYER, do_init=False)
    if uvs is not None:
        every = numpy.zeros((len(mesh.loops), 2), numpy.float32)
        every[loops] = uvs
        layer.data.foreach_set("uv", every.ravel())
    if keep in mesh.uv_layers:
        mesh.uv_layers[keep].active_render = True


def select_layer(o, uvs=None):
    """What is baked lies by these coordinates."""
    layer = o.data.uv_layers[LAYER]
    o.data.uv_layers.active = layer
    layer.active_render = True
    return uvs


def unwrap(o, size):
    """Gives every face of a mesh a place of its own."""
    select_layer(o)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.reveal()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=math.radians(66.0), island_margin=2.0 * MARGIN / 1024.0 if size > 256 else 4.0 / size)
    bpy.ops.object.mode_set(mode="OBJECT")
    uvs = numpy.empty(2 * len(o.data.loops), numpy.float32)
    o.data.uv_layers[LAYER].data.foreach_get("uv", uvs)
    return uvs.reshape(-1, 2)


def depends_on_view(plan, kind):
    """Does a pass show what changes with the direction of view?"""
    tree, values = plan.copy.node_tree, [getattr(plan.surface, n) for n in names_of(kind)]
    starts = [tree.nodes[v.node] for v in values if isinstance(v, Ref)]
    behind = shader_tree.nodes_behind(tree, [i for n in starts for i in n.inputs]) + starts
    return any(shader_tree.is_by_angle(n) for n in shader_tree.view_nodes(behind))


def names_of(kind):
    """The channels of a pass."""
    return NUMBERS if kind == "numbers" else MEANS[int(kind.split()[1])] if " " in kind else (kind,)


def wire(plan, kind, image, pin, cosine):
    """A copy of the material that emits the values of a pass, seen at an angle, and bakes into the image."""
    material = plan.copy.copy()
    tree = material.node_tree
    shader_tree.pin_coordinates(tree, pin)
    shader_tree.see_at(tree, cosine)
    for node in list(tree.nodes):
        if node.type == "OUTPUT_MATERIAL":
            tree.nodes.remove(node)
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = image
    for node in tree.nodes:
        node.select = False
    target.select = True
    tree.nodes.active = target

    def feed(value, socket):
        if isinstance(value, Ref):
            tree.links.new(tree.nodes[value.node].outputs[value.output], socket)
        elif isinstance(value, tuple):
            tree.links.new(shader_tree.constant(tree, value), socket)
        elif value is not None:
            socket.default_value = value

    if "normal" in kind:
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        feed(getattr(plan.surface, kind), shader.inputs["Normal"])
    else:
        shader = tree.nodes.new("ShaderNodeEmission")
        if kind in ("base", "emission", *ADDED):
            value = getattr(plan.surface, kind)
            feed(value, shader.inputs["Color"])
        else:
            join = tree.nodes.new("ShaderNodeCombineXYZ")
            for name, socket in zip(names_of(kind), join.inputs):
                value = getattr(plan.surface, name)
                feed(sum(value) / 3.0 if isinstance(value, tuple) and is_constant(value) else value, socket)
            tree.links.new(join.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return material


def bake_pass(o, plans, kind, size, pin):
    """The pixels, and the least and most of what they are in one direction of view: where they depend on it, they are the mean of some."""
    if kind in DIRECTIONS or not any(depends_on_view(p, kind) for p in plans.values()):
        return bake_seen(o, plans, kind, size, pin, 1.0), (1.0, 1.0)
    seen = numpy.array([bake_seen(o, plans, kind, size, pin, c) for c in gloss.COSINES])
    parts = seen if len(names_of(kind)) > 1 else seen.mean(axis=3)
    mean = parts.mean(axis=0)
    shares = numpy.where(mean > STEP, parts, 1.0) / numpy.where(mean > STEP, mean, 1.0)
    return seen.mean(axis=0), (shares.min(), shares.max())


def bake_seen(o, plans, kind, size, pin, cosine):
    image = bpy.data.images.new("reframe " + kind, size, size, alpha=True, float_buffer=True, is_data=True)
    image.pixels.foreach_set(numpy.full(size * size * 4, NOTHING, numpy.float32))
    made = {}
    for i, slot in enumerate(o.material_slots):
        plan = plans.get(i) or next(iter(plans.values()))
        made.setdefault(id(plan), wire(plan, kind, image, pin, cosine))
        slot.material = made[id(plan)]
    if "normal" in kind:
        bpy.ops.object.bake(type="NORMAL", normal_space="TANGENT", margin=MARGIN, use_clear=False, uv_layer=LAYER)
    else:
        bpy.ops.object.bake(type="EMIT", margin=MARGIN, use_clear=False, uv_layer=LAYER)
    pixels = numpy.empty(size * size * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    for slot in o.material_slots:
        slot.material = None
    for material in made.values():
        bpy.data.materials.remove(material)
    bpy.data.images.remove(image)
    return fill_gaps(pixels.reshape(size, size, 4))


def fill_gaps(pixels):
    """RGB, with the mean where no face is."""
    covered = pixels[:, :, :3].min(axis=2) > 1e-10 * NOTHING
    rgb = numpy.nan_to_num(pixels[:, :, :3], posinf=1e4, neginf=0.0)
    if covered.any():
        rgb[~covered] = rgb[covered].mean(axis=0)
    return rgb


class Stage:
    """A scene of its own, with the object alone in it."""

    def __init__(self, o, part):
        self.before = bpy.context.window.scene
        self.scene = bpy.data.scenes.new("reframe bake")
        self.original, self.name = o, o.name
        o.name = self.name + " (before export)"
        self.o = bpy.data.objects.new(self.name, part)  # the name decides on Object Info's random number
        self.o.matrix_world = o.matrix_world.copy()
        self.o.color, self.o.pass_index = o.color, o.pass_index
        self.scene.collection.objects.link(self.o)
        cycles = self.scene.cycles
        self.scene.render.engine = "CYCLES"
        cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", SAMPLES, False, False
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        self.scene.render.bake.target = "IMAGE_TEXTURES"
        self.scene.render.bake.use_selected_to_active = False
        self.scene.frame_set(self.before.frame_current)
        bpy.context.window.scene = self.scene
        bpy.context.view_layer.objects.active = self.o
        self.o.select_set(True)

    def close(self):
        bpy.context.window.scene = self.before
        part = self.o.data
        bpy.data.objects.remove(self.o)
        bpy.data.meshes.remove(part)
        bpy.data.scenes.remove(self.scene)
        self.original.name = self.name


def bake_part(o, part, job, size, uvs=None):
    """The coordinates, unless they are given, and the pixels of all passes."""
    pin = default_layer(part)
    add_layer(part, uvs, slice(None))
    stage = Stage(o, part)
    try:
        result = {"uv": unwrap(stage.o, size) if uvs is None else select_layer(stage.o, uvs)}
        shares = []
        for kind in job.passes():
            result[kind], found = bake_pass(stage.o, job.plans, kind, size, pin)
            shares += found
        result["shares"] = numpy.array([min(shares), max(shares)])
    finally:
        stage.close()
    return result


# Bakes kept on disk, by a hash of what they were made from.

VERSION = b"reframe bake 5"


class Cache:
    def __init__(self, folder):
        self.folder, self.hits = folder, 0
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as e:
            warn("%s: bakes cannot be kept: %s" % (folder, e.strerror))
            self.folder = None

    def path(self, cache_key):
        return os.path.join(self.folder, cache_key + ".npz")

    def find(self, cache_key):
        if self.folder is None or cache_key is None:
            return None
        try:
            with numpy.load(self.path(cache_key), allow_pickle=False) as file:
                found = {name: file[name].astype(numpy.float32) for name in file.files}
        except (OSError, ValueError, KeyError, EOFError):
            return None
        except Exception:  # a damaged file, of which zipfile has its own exceptions
            return None
        self.hits += 1
        return found if "uv" in found else None

    def keep(self, cache_key, result):
        if self.folder is None or cache_key is None:
            return
        temporary = self.path(cache_key) + ".%d" % os.getpid()
        try:
            with open(temporary, "wb") as file:
                numpy.savez_compressed(file, **{n: v if n == "uv" else v.astype(numpy.float16) for n, v in result.items()})
            os.replace(temporary, self.path(cache_key))
        except OSError as e:
            warn("%s: bakes cannot be kept: %s" % (self.folder, e.strerror))
            self.folder = None

    def tell(self):
        if self.hits > 0:
            note("%d from the cache %s" % (self.hits, self.folder))


def of_image(image):
    """What identifies the pixels of an image."""
    if image.packed_file is not None:
        return "packed", hashlib.sha256(image.packed_file.data).hexdigest()
    path = bpy.path.abspath(image.filepath, library=image.library)
    try:
        at = os.stat(path)
        return path, at.st_mtime_ns, at.st_size
    except OSError:
        pixels = numpy.empty(len(image.pixels), numpy.float32)
        image.pixels.foreach_get(pixels)
        return "generated", hashlib.sha256(pixels.tobytes()).hexdigest()


def values(thing):
    """What a node, a ramp, a curve is set to, as text. Colours and locations of nodes are the editor's."""
    found, skipped = [], SKIPPED if isinstance(thing, bpy.types.Node) else SKIPPED - {"color", "location"}
    for p in thing.bl_rna.properties:
        name = p.identifier
        if name in skipped or name.startswith("bl_"):
            continue
        value = getattr(thing, name, None)
        if p.type == "COLLECTION":
            if name in ("elements", "curves", "points"):
                found.append((name, [values(v) for v in value]))
        elif p.type != "POINTER":
            found.append((name, tuple(value) if getattr(p, "is_array", False) else value))
        elif isinstance(value, bpy.types.Image):
            found.append((name, of_image(value), value.colorspace_settings.name, value.alpha_mode))
        elif isinstance(value, bpy.types.Object):
            found.append((name, value.name, [tuple(row) for row in value.matrix_world]))
        elif isinstance(value, bpy.types.ID):
            found.append((name, value.name_full))
        elif value is not None:
            found.append((name, values(value)))
    return found


def of_tree(tree):
    return of_nodes(tree, tree.nodes)


def of_nodes(tree, nodes):
    """Some nodes of a tree and their links, as text."""
    found, names = [], {n.name for n in nodes}
    for node in sorted(nodes, key=lambda n: n.name):
        sockets = [(s.identifier, value_text(s)) for s in list(node.inputs) + list(node.outputs)]
        found.append((node.name, node.bl_idname, sockets, values(node)))
    links = sorted((k.from_node.name, k.from_socket.identifier, k.to_node.name, k.to_socket.identifier) for k in tree.links
                   if k.to_node.name in names)
    return repr((found, links))


def value_text(socket):
    value = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def array(collection, name, width, kind=numpy.float32):
    found = numpy.empty(len(collection) * width, kind)
    collection.foreach_get(name, found)
    return found.tobytes()


def of_mesh(mesh, digest):
    digest.update(array(mesh.vertices, "co", 3))
    digest.update(array(mesh.loops, "vertex_index", 1, numpy.int32))
    digest.update(array(mesh.polygons, "loop_total", 1, numpy.int32))
    digest.update(array(mesh.polygons, "material_index", 1, numpy.int32))
    digest.update(array(mesh.polygons, "use_smooth", 1, bool))
    for layer in mesh.uv_layers:
        digest.update(repr((layer.name, layer.active_render)).encode())
        digest.update(array(layer.data, "uv", 2))
    widths = {"FLOAT": ("value", 1), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4)}
    for a in mesh.attributes:
        if a.data_type in widths and len(a.data) > 0:
            digest.update(repr((a.name, a.domain)).encode() + array(a.data, *widths[a.data_type]))
    digest.update(repr((tuple(mesh.texspace_location), tuple(mesh.texspace_size))).encode())


def cache_key(o, part, job, size):
    """The name of the bake; None if it depends on more than can be hashed."""
    digest = hashlib.sha256(VERSION + repr((bpy.app.version, size)).encode())
    of_mesh(part, digest)
    for slot, plan in sorted(job.plans.items()):
        if any(n.type in ("SCRIPT", "TEX_POINTDENSITY") for n in plan.copy.node_tree.nodes):
            return None
        digest.update(repr((slot, plan.surface, sorted(plan.baked), sorted(plan.averaged))).encode())
        digest.update(of_tree(plan.copy.node_tree).encode())
    if job.only is not None:
        digest.update(repr(job.only).encode())
    if job.own_place:
        digest.update(repr((o.name, [tuple(row) for row in o.matrix_world], tuple(o.color), o.pass_index)).encode())
    return digest.hexdigest()
