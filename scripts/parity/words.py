"""Words for making scenes in Blender, in few lines each. For Blender 3.4 and later."""
import math
import os

import bpy
import numpy
from mathutils import Vector

from blender.versions import curve_lists, give_nodes, socket

SCENES = {}
SIZE = (64, 48)
GREY, RED, BLUE, GOLD = (0.6, 0.6, 0.6), (0.6, 0.08, 0.05), (0.1, 0.3, 0.7), (1.0, 0.77, 0.34)


class Absent(Exception):
    """This version of Blender has no such thing."""


def scene(frames=(1,), samples=128):
    """A scene: its name is the function's, with dashes. Which frames are compared, and the samples of each seed."""
    def register(make):
        SCENES[make.__name__.replace("_", "-")] = (make, list(frames), samples)
        return make
    return register


def beside(name):
    """A file beside the .blend."""
    return os.path.join(os.path.dirname(bpy.data.filepath), name)


def add(tree, kind, **inputs):
    """A node; names of sockets are those of Blender 3, with underscores for spaces."""
    try:
        node = tree.nodes.new("ShaderNode" + kind)
    except RuntimeError as error:
        raise Absent from error
    for name, value in inputs.items():
        feed(tree, node, name, value)
    return node


def feed(tree, node, name, value):
    try:
        into = node.inputs[name] if isinstance(name, int) else socket(node, name.replace("_", " "))
    except KeyError as error:
        raise Absent from error
    give(tree, into, value)


def give(tree, into, value):
    """Links a node's first output or a socket to an input, or sets its value."""
    if isinstance(value, bpy.types.Node):
        value = value.outputs[0]
    if isinstance(value, bpy.types.NodeSocket):
        tree.links.new(value, into)
    elif hasattr(into.default_value, "__len__") and isinstance(value, tuple):
        into.default_value = (*value, 1.0)[:len(into.default_value)]
    else:
        into.default_value = value


def mix(tree, factor, a, b):
    node = tree.nodes.new("ShaderNodeMixShader")
    for i, value in enumerate((factor, a, b)):
        feed(tree, node, i, value)
    return node


def ramp(tree, factor, *stops):
    """A colour ramp of (position, colour)."""
    node = add(tree, "ValToRGB", Fac=factor)
    for i, (place, colour) in enumerate(stops):
        element = node.color_ramp.elements[i] if i < 2 else node.color_ramp.elements.new(place)
        element.position, element.color = place, (*colour, 1.0)
    return node


def material(name, make):
    """make(tree) gives the shader, or the shader and a displacement."""
    made = bpy.data.materials.new(name)
    give_nodes(made)
    tree = made.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = make(tree)
    shader, displacement = shader if isinstance(shader, tuple) else (shader, None)
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    if displacement is not None:
        tree.links.new(displacement.outputs[0], out.inputs["Displacement"])
    return made


def matte(colour, name="matte"):
    return material(name, lambda tree: add(tree, "BsdfDiffuse", Color=colour))


def principled(colour=(0.8, 0.8, 0.8), **inputs):
    return material("surface", lambda tree: add(tree, "BsdfPrincipled", Base_Color=colour, **inputs))


def glow(colour, strength, name="glow"):
    return material(name, lambda tree: add(tree, "Emission", Color=colour, Strength=strength))


def shaped(name, surface, smooth=False):
    """The object that an operator has just added."""
    o = bpy.context.object
    o.name = name
    if surface is not None:
        o.data.materials.append(surface)
    if smooth:
        bpy.ops.object.shade_smooth()
    return o


def ball(place, radius, surface=None, name="ball"):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius, location=place)
    return shaped(name, surface, True)


def box(place, size, surface=None, name="box", turn=(0.0, 0.0, 0.0)):
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=place, rotation=turn)
    o = shaped(name, surface)
    o.scale = size
    return o


def sheet(place, size, surface=None, name="sheet", turn=(0.0, 0.0, 0.0), cuts=1):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=cuts, y_subdivisions=cuts, size=1.0, location=place, rotation=turn)
    o = shaped(name, surface)
    o.scale = (size[0], size[1], 1.0)
    return o


UPRIGHT = (0.5 * math.pi, 0.0, 0.0)


def aim(o, target):
    o.rotation_euler = (Vector(target) - o.location).to_track_quat("-Z", "Y").to_euler()
    return o


def placed(name, data=None, place=(0, 0, 0), turn=(0, 0, 0)):
    """An object of the scene."""
    o = bpy.data.objects.new(name, data)
    o.location, o.rotation_euler = place, turn
    bpy.context.scene.collection.objects.link(o)
    return o


def lamp(kind, place, energy, target=None, **settings):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy, data.shadow_soft_size = energy, 0.0
    if kind == "SUN":
        data.angle = 0.0
    for name, value in settings.items():
        setattr(data, name, value)
    o = placed(kind.lower(), data, place)
    return aim(o, target) if target is not None else o


def lamp_nodes(o):
    """The tree of a lamp and its emission node."""
    give_nodes(o.data)
    tree = o.data.node_tree
    return tree, next(n for n in tree.nodes if n.type == "EMISSION")


def camera(place=(0.0, -6.0, 2.4), target=(0.0, 0.0, 0.7), **settings):
    data = bpy.data.cameras.new("camera")
    for name, value in settings.items():
        setattr(data, name, value)
    o = placed("camera", data, place)
    bpy.context.scene.camera = aim(o, target)
    return o


def world(colour=(0.0, 0.0, 0.0), strength=1.0):
    """The background node and its tree."""
    made = bpy.context.scene.world = bpy.data.worlds.new("world")
    give_nodes(made)
    tree = made.node_tree
    node = next(n for n in tree.nodes if n.type == "BACKGROUND")
    feed(tree, node, "Color", colour)
    feed(tree, node, "Strength", strength)
    return tree, node


def stage(ball_of=None, box_of=None, floor_of=None):
    """A floor and a wall, a ball and a box on it, in the dark; returns ball and box."""
    world()
    camera()
    floor = floor_of or matte(GREY, "floor")
    sheet((0, 0, 0), (12, 8), floor, "floor")
    sheet((0, 2.5, 2), (12, 5), floor, "wall", UPRIGHT)
    return (ball((-1.0, 0.0, 0.7), 0.7, ball_of or matte(RED, "ball")),
            box((1.1, 0.2, 0.6), (1.1, 1.1, 1.2), box_of or matte(BLUE, "box"), turn=(0, 0, 0.4)))


def sample(*surfaces):
    """Surfaces on a ball and a box under a lamp and a weak sky; more on balls in front."""
    made = stage(*surfaces[:2])
    world((0.25, 0.3, 0.35))
    softbox((-2.5, -3.0, 4.0), 250.0)
    front = [ball((-0.4 + 0.9 * i, -1.5, 0.35), 0.35, s, "front %d" % i) for i, s in enumerate(surfaces[2:])]
    return (*made, *front)


def softbox(place, energy, target=(0.0, 0.0, 0.5), size=1.5, **settings):
    return lamp("AREA", place, energy, target, size=size, **settings)


def picture(name, width, height, colour_at, is_float=False):
    """An image file of colour_at(u, v) beside the .blend, u and v as arrays from 0 to 1."""
    v, u = ((numpy.indices((height, width)) + 0.5) / numpy.array([height, width])[:, None, None])
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[..., :3] = numpy.moveaxis(numpy.array(numpy.broadcast_arrays(*colour_at(u, v))), 0, -1)
    image = bpy.data.images.new(name, width, height, float_buffer=is_float)
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw = beside(name)
    image.file_format = "HDR" if is_float else "PNG"
    image.save()
    return bpy.data.images.load(beside(name))


def image_node(tree, image, vector=None):
    node = add(tree, "TexImage")
    node.image = image
    if vector is not None:
        feed(tree, node, "Vector", vector)
    return node


def stripes(u, v):
    odd = ((u * 6).astype(int) + (v * 4).astype(int)) % 2
    return 0.15 + 0.7 * odd, 0.2 + 0.5 * u, 0.7 - 0.5 * v


def ies_file():
    """A made-up lamp: a narrow lobe downwards and a wide weak one."""
    angles = range(0, 181, 5)
    values = [400.0 * max(math.cos(math.radians(a)), 0.0) ** 8 + 60.0 * math.sin(math.radians(a)) ** 2 + 5.0 for a in angles]
    lines = ["IESNA:LM-63-2002", "TILT=NONE", "1 1000 1 %d 1 1 2 0 0 0" % len(values), "1.0 1.0 100",
             " ".join("%d" % a for a in angles), "0", " ".join("%.3f" % v for v in values)]
    with open(beside("lamp.ies"), "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
    return beside("lamp.ies")


def shine_by_ies(o, strength):
    tree, emission = lamp_nodes(o)
    node = add(tree, "TexIES", Strength=strength)
    node.mode, node.filepath = "EXTERNAL", ies_file()
    feed(tree, emission, "Strength", node.outputs["Fac"])


def key(owner, path, frames_values, index=-1, interpolation=None):
    """Keys of a property, with Blender's interpolation or another."""
    for frame, value in frames_values:
        if index < 0:
            setattr(owner, path, value)
        else:
            getattr(owner, path)[index] = value
        owner.keyframe_insert(path, index=index, frame=frame)
    for curves in curve_lists(owner.id_data.animation_data) if interpolation is not None else []:
        for point in [point for curve in curves for point in curve.keyframe_points]:
            point.interpolation = interpolation
