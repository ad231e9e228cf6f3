"""Bakes what glTF cannot express into textures, with Cycles, object by object.

A channel that varies is wired into an emission, so a bake gives its values and not light; the normal is baked as
such. The object is baked alone, in a scene of its own, over coordinates that no two of its faces share.
"""
import math
import time

import bmesh
import bpy
import numpy

from . import bake_cache, shader_tree
from .messages import printable, warn
from .surface import Ref, is_constant

LAYER = "reframe bake"  # the coordinates of the baked textures
SAMPLES = 4
MARGIN = 8  # pixels around each island, against seams
NUMBERS = ("alpha", "roughness", "metallic")  # baked together, in R, G and B
MEANS = (("specular", "f0", "transmission"), ("ior", "clearcoat", "clearcoat_roughness"))
WORDS = {"base": "colour", "metallic": "metallic", "roughness": "roughness", "emission": "emission", "alpha": "alpha",
         "normal": "normal", "specular": "specular", "f0": "specular", "transmission": "transmission", "ior": "IOR",
         "clearcoat": "clearcoat", "clearcoat_roughness": "roughness of the clearcoat"}
NOTHING = -12345.0  # marks pixels that no face has
STEP = 0.6 / 255.0  # a texture that varies less is a constant
OWN_PLACE = {"OBJECT_INFO": None, "PARTICLE_INFO": None, "HAIR_INFO": None, "VECT_TRANSFORM": None, "CAMERA": None,
             "AMBIENT_OCCLUSION": None, "BEVEL": None, "TEX_POINTDENSITY": None,
             "NEW_GEOMETRY": ("Position", "Normal", "True Normal", "Incoming", "Parametric"),
             "TEX_COORD": ("Camera", "Window", "Reflection")}


class Job:
    """Objects that share a bake: one mesh, and the plans of those of its slots that need one."""

    def __init__(self, plans, own_place):
        self.objects, self.plans, self.own_place = [], plans, own_place

    def passes(self):
        wanted = set().union(*(p.baked for p in self.plans.values()))
        averaged = set().union(*(p.averaged for p in self.plans.values()))
        found = [n for n in ("base", "emission", "normal") if n in wanted]
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


# meshes

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


def unwrap(o, size):
    """Gives every face of a mesh a place of its own."""
    layer = o.data.uv_layers[LAYER]
    o.data.uv_layers.active = layer
    layer.active_render = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.reveal()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=math.radians(66.0), island_margin=2.0 * MARGIN / 1024.0 if size > 256 else 4.0 / size)
    bpy.ops.object.mode_set(mode="OBJECT")
    uvs = numpy.empty(2 * len(o.data.loops), numpy.float32)
    o.data.uv_layers[LAYER].data.foreach_get("uv", uvs)
    return uvs.reshape(-1, 2)


# passes

def wire(plan, kind, image, pin):
    """A copy of the material that emits the values of a pass, and bakes into the image."""
    material = plan.copy.copy()
    tree = material.node_tree
    shader_tree.pin_coordinates(tree, pin)
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

    if kind == "normal":
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        feed(plan.surface.normal, shader.inputs["Normal"])
    else:
        shader = tree.nodes.new("ShaderNodeEmission")
        if kind in ("base", "emission"):
            value = getattr(plan.surface, kind)
            feed(value, shader.inputs["Color"])
        else:
            three = NUMBERS if kind == "numbers" else MEANS[int(kind.split()[1])]
            join = tree.nodes.new("ShaderNodeCombineXYZ")
            for name, socket in zip(three, join.inputs):
                value = getattr(plan.surface, name)
                feed(sum(value) / 3.0 if isinstance(value, tuple) and is_constant(value) else value, socket)
            tree.links.new(join.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return material


def bake_pass(o, plans, kind, size, pin):
    image = bpy.data.images.new("reframe " + kind, size, size, alpha=True, float_buffer=True, is_data=True)
    image.pixels.foreach_set(numpy.full(size * size * 4, NOTHING, numpy.float32))
    made = {}
    for i, slot in enumerate(o.material_slots):
        plan = plans.get(i) or next(iter(plans.values()))
        made.setdefault(id(plan), wire(plan, kind, image, pin))
        slot.material = made[id(plan)]
    if kind == "normal":
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
    covered = pixels[:, :, 0] != NOTHING
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


def bake_part(o, part, job, size):
    """The coordinates and the pixels of all passes."""
    pin = default_layer(part)
    add_layer(part)
    stage = Stage(o, part)
    try:
        result = {"uv": unwrap(stage.o, size)}
        for kind in job.passes():
            result[kind] = bake_pass(stage.o, job.plans, kind, size, pin)
    finally:
        stage.close()
    return result


# textures

def srgb(linear):
    linear = numpy.clip(linear, 0.0, 1.0)
    return numpy.where(linear <= 0.0031308, linear * 12.92, 1.055 * numpy.power(linear, 1.0 / 2.4) - 0.055)


def picture(name, rgb, alpha=None, data=True):
    """A packed image of 8 bits from encoded values."""
    height, width = rgb.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=alpha is not None, is_data=data)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[:, :, :3] = rgb
    if alpha is not None:
        pixels[:, :, 3] = alpha
        image.alpha_mode = "CHANNEL_PACKED"
    image.pixels.foreach_set(numpy.clip(pixels, 0.0, 1.0).ravel())
    image.pack()
    return image


def is_flat(pixels):
    return float((pixels.max(axis=(0, 1)) - pixels.min(axis=(0, 1))).max()) < STEP


def make_textures(name, result):
    """The images of a job by channel."""
    textures = {}
    numbers = result.get("numbers")
    alpha = numbers[:, :, 0] if numbers is not None else None
    if "base" in result:
        varies = alpha is not None and alpha.min() < 1.0 - STEP
        textures["base"] = picture(name + " base", srgb(result["base"]), alpha if varies else None, data=False)
    if "emission" in result:
        strength = max(float(result["emission"].max()), 1e-6)
        textures["emission"] = (picture(name + " emission", srgb(result["emission"] / strength), data=False), strength)
    if "normal" in result:
        textures["normal"] = picture(name + " normal", result["normal"])
    if numbers is not None:
        both = numbers.copy()
        both[:, :, 0] = 1.0
        textures["numbers"] = picture(name + " roughness, metallic", both)
    return textures


def means_of(plan, result):
    """Constants for the channels of a plan that do not vary after all, or whose mean is taken."""
    means = {}
    numbers = result.get("numbers")
    alpha_varies = "alpha" in plan.baked and not is_flat(numbers[:, :, 0:1])
    for n in plan.baked:
        if n in NUMBERS:
            pixels = numbers[:, :, NUMBERS.index(n)][:, :, None]
        else:
            pixels = result[n]
        if is_flat(pixels) and n != "normal" and not (n == "base" and alpha_varies):
            mean = pixels.mean(axis=(0, 1))
            means[n] = tuple(float(max(v, 0.0)) for v in mean) if len(mean) == 3 else float(min(max(mean[0], 0.0), 1.0))
    for i, group in enumerate(MEANS):
        for n, pixels in zip(group, numpy.moveaxis(result.get("means %d" % i, numpy.zeros((1, 1, 3))), 2, 0)):
            if n in plan.averaged:
                means[n] = float(max(pixels.mean(), 0.0))
    return means


def link_textures(tree, principled, textures, names):
    """Feeds channels from images over the baked coordinates; returns the strength of the emission."""
    place = tree.nodes.new("ShaderNodeUVMap")
    place.uv_map = LAYER

    def show(image):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.extension = image, "EXTEND"
        tree.links.new(place.outputs[0], node.inputs["Vector"])
        return node

    strength = 1.0
    if "base" in names or "alpha" in names:
        node = show(textures["base"])
        tree.links.new(node.outputs["Color"], principled.inputs["Base Color"])
        if "alpha" in names:
            tree.links.new(node.outputs["Alpha"], principled.inputs["Alpha"])
    if "emission" in names:
        image, strength = textures["emission"]
        tree.links.new(show(image).outputs["Color"], principled.inputs["Emission"])
    if "normal" in names:
        node = tree.nodes.new("ShaderNodeNormalMap")
        node.uv_map = LAYER
        tree.links.new(show(textures["normal"]).outputs["Color"], node.inputs["Color"])
        tree.links.new(node.outputs[0], principled.inputs["Normal"])
    if "metallic" in names or "roughness" in names:
        split = tree.nodes.new("ShaderNodeSeparateColor")
        tree.links.new(show(textures["numbers"]).outputs["Color"], split.inputs[0])
        for n, channel in (("metallic", "Blue"), ("roughness", "Green")):
            if n in names:
                tree.links.new(split.outputs[channel], principled.inputs[n.capitalize()])
    return strength


# all objects

def bake_job(job, args, cache):
    """Bakes, or takes from the cache; gives the objects their new mesh. Returns the pixels, and whether they were baked."""
    first = job.objects[0]
    mesh = own_mesh(first)
    faces = faces_of(mesh, job.plans)
    if not faces.any():
        return mesh, None, False
    loops = loops_of(mesh, faces)
    part = part_of(mesh, faces)
    key = bake_cache.key(first, part, job, args.bake)
    result = cache.find(key)
    fresh = result is None or len(result["uv"]) != len(loops)
    if fresh:
        result = bake_part(first, part, job, args.bake)
        cache.keep(key, result)
    else:
        bpy.data.meshes.remove(part)
    add_layer(mesh, result["uv"], loops)
    return mesh, result, fresh


def bake_objects(to_bake, args, is_closed, build):
    """Bakes what the plans of objects ask for; returns the slots (object, number, material) to be set."""
    jobs = sort_jobs(to_bake)
    cache = bake_cache.Cache(args.bake_cache)
    new, made = [], {}
    for i, job in enumerate(jobs):
        start = time.monotonic()
        name = job.objects[0].name
        solid = any(p.surface.transmission != 0.0 for p in job.plans.values()) and is_closed(job.objects[0].data)
        try:
            mesh, result, fresh = bake_job(job, args, cache)
            if result is None:
                new += [(o, slot, build(p, p.material.name)) for o in job.objects for slot, p in job.plans.items()]
                continue
        except Exception as e:  # Blender's bake fails for reasons of its own
            warn("'%s': could not be baked: taken as constant: %s" % (name, " ".join(str(e).split())[:200]))
            new += [(o, slot, build(p, p.material.name + " constant")) for o in job.objects for slot, p in job.plans.items()]
            continue
        textures = make_textures(name, result)
        materials = {}
        for slot, plan in job.plans.items():
            made[plan] = made.get(plan, 0) + 1
            plain = plan.free_name()
            materials[slot] = build(plan, plain if made[plan] == 1 else "%s %s" % (plain, name), textures, means_of(plan, result), solid)
        for o in job.objects:
            o.data = mesh
            new += [(o, slot, material) for slot, material in materials.items()]
        print("blender-export: baked %d of %d: '%s' at %dx%d: %s: %s" % (i + 1, len(jobs), printable(name), args.bake, args.bake, job.words(),
              "%.1f s" % (time.monotonic() - start) if fresh else "from the cache"), flush=True)
    cache.tell()
    return new
