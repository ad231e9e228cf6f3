"""Bakes one object: its faces over coordinates of their own, alone in a scene of its own."""
import math

import bmesh
import bpy
import numpy

from . import shader_tree
from .channels import LAYER, MEANS, NUMBERS, Ref, is_constant

SAMPLES = 4
MARGIN = 8  # pixels around each island, against seams
NOTHING = -12345.0  # marks pixels that no face has


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
