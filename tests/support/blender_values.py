"""Values that change from frame to frame, for test_blender_values.c."""
import math
import os

import bpy
import numpy

import blender_words
from blender_words import Shader, add_socket, begin, eye, give_nodes, grey, lamp, lamp_nodes, set_format, socket, world

FRAMES = (1, 5)
SHOWN = (1, 3, 5)


def set_up():
    begin(FRAMES[1], size=(32, 24))
    eye()


def on_plane(name, place):
    """A material that consists of nodes, on a plane of its own."""
    bpy.ops.mesh.primitive_plane_add(size=1.8, location=place, rotation=(0.5 * math.pi, 0.0, 0.0))
    bpy.context.object.name = name
    s = Shader(name)
    bpy.context.object.data.materials.append(s.material)
    return s


def key(owner, path, first, last, index=-1):
    """Straight from the first frame to the last."""
    blender_words.key(owner, path, zip(FRAMES, (first, last)), index, "LINEAR")


def picture(name, pixels):
    """A PNG of grey pixels."""
    values = numpy.array(pixels, numpy.float32)
    image = bpy.data.images.new(name, values.shape[1], values.shape[0])
    rgba = numpy.ones((*values.shape, 4), numpy.float32)
    rgba[:, :, :3] = values[:, :, None]
    image.pixels.foreach_set(rgba.ravel())
    image.filepath_raw, image.file_format = os.path.abspath(name + ".png"), "PNG"
    image.save()
    return image


def film(kind="SEQUENCE", count=4):
    """Grey pictures, each lighter than the one before."""
    for n in range(count):
        bpy.data.images.remove(picture("film.%04d" % (n + 3), [[0.2 * (n + 1)] * 4] * 4))
    image = bpy.data.images.load(os.path.abspath("film.0003.png"))
    image.source = kind
    return image


def lit(kind, name, place=(0.0, -3.0, 0.0), turn=(0.5 * math.pi, 0.0, 0.0), **settings):
    return lamp(kind, name, place, turn, **settings)


def surfaces():
    """Numbers of shaders: keyed, driven, and within a group."""
    lit("SUN", "sun", energy=3.0)
    s = on_plane("glow", (-2.0, 0.0, 1.0))
    light = s.add("Emission", Color=(1.0, 0.5, 0.25, 1.0))
    key(light.inputs["Strength"], "default_value", 0.0, 8.0)
    s.done(light)
    s = on_plane("paint", (0.0, 0.0, 1.0))
    paint = s.add("BsdfPrincipled", Roughness=0.4, Specular=0.0)
    for i, (a, b) in enumerate(((0.8, 0.1), (0.2, 0.2), (0.1, 0.6))):
        key(socket(paint, "Base Color"), "default_value", a, b, i)
    s.done(paint)
    s = on_plane("steel", (2.0, 0.0, 1.0))
    steel = s.add("BsdfPrincipled", Base_Color=(0.8, 0.7, 0.6, 1.0), Metallic=1.0)
    key(socket(steel, "Roughness"), "default_value", 0.2, 0.6)
    s.done(steel)
    s = on_plane("fades", (-2.0, 0.0, -1.0))
    fades = s.add("BsdfPrincipled", Base_Color=grey(0.5), Specular=0.0, Roughness=1.0)
    key(socket(fades, "Alpha"), "default_value", 1.0, 0.2)
    s.done(fades)
    group = bpy.data.node_groups.new("counter", "ShaderNodeTree")
    add_socket(group, "OUTPUT", "NodeSocketFloat", "Count")
    count, out = group.nodes.new("ShaderNodeValue"), group.nodes.new("NodeGroupOutput")
    group.links.new(count.outputs[0], out.inputs[0])
    count.outputs[0].driver_add("default_value").driver.expression = "frame / 10"
    s = on_plane("driven", (0.0, 0.0, -1.0))
    counter = s.add("Group")
    counter.node_tree = group
    s.done(s.add("BsdfDiffuse", Color=counter))


def show(s, image, at=None):
    node = s.add("TexImage")
    node.image = image
    if at is not None:
        s.feed(node.inputs["Vector"], at)
    return node


def pictures():
    """A film that shines ever more, one that is looked at in turn and mixed with noise, a picture that slides and turns, clouds that boil."""
    lit("SUN", "sun", energy=3.0)
    s = on_plane("screen", (-2.0, 0.0, 1.0))
    screen = show(s, film())
    screen.image_user.frame_duration, screen.image_user.frame_start, screen.image_user.frame_offset = 4, 2, 2
    shine = s.add("Emission", Color=screen)
    key(shine.inputs["Strength"], "default_value", 1.0, 2.0)
    s.done(shine)
    s = on_plane("mixed", (0.0, 0.0, 1.0))
    mixed = show(s, film())
    mixed.image_user.frame_duration, mixed.image_user.frame_offset, mixed.image_user.use_cyclic = 3, 2, True
    both = s.math("VectorMath", "MULTIPLY", mixed, s.add("TexNoise", Scale=3.0).outputs["Color"])
    s.done(s.add("BsdfDiffuse", Color=both))
    s = on_plane("slides", (2.0, 0.0, 1.0))
    turn, where = s.add("Mapping"), s.add("TexCoord")
    s.feed(turn.inputs["Vector"], where.outputs["UV"])
    key(turn.inputs["Location"], "default_value", 0.0, 0.4, 0)
    key(turn.inputs["Rotation"], "default_value", 0.0, 0.5, 2)
    s.done(s.add("BsdfDiffuse", Color=show(s, picture("stairs", [[0.1 * (x // 8 + y // 8) for x in range(32)] for y in range(32)]), turn)))
    s = on_plane("boils", (-2.0, 0.0, -1.0))
    clouds = s.add("TexNoise", Scale=3.0)
    clouds.noise_dimensions = "4D"
    key(clouds.inputs["W"], "default_value", 0.0, 2.0)
    s.done(s.add("BsdfDiffuse", Color=clouds))
    s = on_plane("ember", (0.0, 0.0, -1.0))
    ember = s.add("Emission", Color=s.add("TexNoise", Scale=3.0))
    key(ember.inputs["Strength"], "default_value", 0.0, 2.0)
    s.done(ember)
    return SHOWN


def wall():
    """What shows how the world lights it: a cube."""
    bpy.ops.mesh.primitive_cube_add(size=1.5, rotation=(0.3, 0.2, 0.5))


def dusk():
    """A world of one colour, which changes."""
    wall()
    _, shine = world()
    key(shine.inputs["Strength"], "default_value", 1.0, 0.25)
    for i, (a, b) in enumerate(((0.2, 0.8), (0.4, 0.4), (0.8, 0.0))):
        key(shine.inputs["Color"], "default_value", a, b, i)


def panorama():
    """A picture of the world that turns and fades, its strength driven through a group."""
    wall()
    tree, shine = world()
    image = bpy.data.images.new("panorama", 64, 32, float_buffer=True)
    pixels = numpy.ones((32, 64, 4), numpy.float32)
    pixels[:, :, 0], pixels[:, :, 1] = numpy.linspace(0.0, 1.0, 64)[None, :], numpy.linspace(0.0, 1.0, 32)[:, None]
    pixels[16:, 8:16, :3] = (6.0, 5.0, 4.0)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    sky, turn, at = (tree.nodes.new("ShaderNode" + kind) for kind in ("TexEnvironment", "Mapping", "TexCoord"))
    sky.image = image
    tree.links.new(at.outputs["Generated"], turn.inputs[0])
    tree.links.new(turn.outputs[0], sky.inputs[0])
    tree.links.new(sky.outputs[0], shine.inputs["Color"])
    key(turn.inputs["Rotation"], "default_value", 0.0, math.radians(90.0), 2)  # by whole pixels of the picture
    shine.inputs["Strength"].driver_add("default_value").driver.expression = "(frame - 1) / 4"
    return SHOWN


def sun():
    """A sky whose sun turns."""
    wall()
    tree, shine = world()
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sun_elevation, sky.sun_disc = 0.3, False  # of the default model
    tree.links.new(sky.outputs[0], shine.inputs["Color"])
    key(sky, "sun_rotation", 0.0, 2.0)
    return SHOWN


def rises():
    """A sky whose sun rises, which is lost."""
    sun()
    key(bpy.context.scene.world.node_tree.nodes["Sky Texture"], "sun_elevation", 0.0, 1.0)


def lamps():
    """Lamps of all kinds before a wall each: energy, colour, size and cone; one that is off at first, one whose nodes are driven."""
    for i in range(6):
        s = on_plane("wall %d" % i, (2.0 * (i % 3 - 1), 0.0, 1.0 - 2.0 * (i // 3)))
        s.done(s.add("BsdfDiffuse", Color=grey(0.8)))
    panel = lit("AREA", "panel", (-2.0, -2.0, 3.5), (1.0, 0.0, 0.0))
    key(panel.data, "size", 0.2, 0.8)
    key(panel.data, "energy", 20.0, 100.0)
    bulb = lit("POINT", "bulb", (0.0, -0.8, 1.0), shadow_soft_size=0.0)
    key(bulb.data, "energy", 0.0, 20.0)
    for i, (a, b) in enumerate(((1.0, 0.2), (1.0, 0.5), (0.5, 1.0))):
        key(bulb.data, "color", a, b, i)
    spot = lit("SPOT", "spot", (2.0, -2.0, 1.0), shadow_soft_size=0.0, spot_blend=0.2, energy=100.0)
    key(spot.data, "spot_size", 0.4, 0.8)
    driven = lit("POINT", "driven", (-2.0, -0.8, -1.0), energy=10.0, shadow_soft_size=0.0)
    lamp_nodes(driven)[1].inputs["Strength"].driver_add("default_value").driver.expression = "frame / 5"
    plate = lit("AREA", "plate", (0.0, -2.0, -3.5), (2.1, 0.0, 0.0), shape="ELLIPSE", size=0.5, energy=100.0)
    key(plate.data, "size_y", 0.1, 1.0)
    return SHOWN


def movie():
    """A movie, of which frames 1 to 5 are greys, shown from its second frame on."""
    other = bpy.data.scenes.new("movie")
    other.camera = bpy.data.objects.new("movie", bpy.data.cameras.new("movie"))
    other.collection.objects.link(other.camera)
    other.world = bpy.data.worlds.new("movie")
    give_nodes(other.world)
    shine = other.world.node_tree.nodes["Background"]
    key(shine.inputs["Strength"], "default_value", 0.2, 1.0)
    for i in range(3):
        shine.inputs["Color"].default_value[i] = 1.0
    render = other.render
    render.engine, other.cycles.samples, other.cycles.use_denoising = "CYCLES", 1, False
    other.frame_start, other.frame_end = FRAMES
    render.resolution_x, render.resolution_y, render.resolution_percentage = 64, 64, 100
    set_format(render.image_settings, "FFMPEG")
    render.ffmpeg.format, render.ffmpeg.codec = "AVI", "PNG"
    render.filepath, render.use_file_extension, other.view_settings.view_transform = os.path.abspath("movie.avi"), False, "Raw"
    bpy.ops.render.render(animation=True, scene="movie")
    bpy.data.scenes.remove(other)
    s = on_plane("screen", (0.0, 0.0, 1.0))
    node = show(s, bpy.data.images.load(os.path.abspath("movie.avi")))
    node.image_user.frame_duration, node.image_user.frame_offset = 3, 1
    s.done(s.add("Emission", Color=node))
    return SHOWN
