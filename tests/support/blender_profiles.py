"""Lamps that shine to each side otherwise, for test_blender_profiles.c."""
import math

import bpy

import blender_words
from blender_words import begin, eye, lamp_nodes, save

DOWN, AROUND = (0, 30, 60, 90), (0, 90, 180, 270, 360)
CANDELA = [[100, 80, 40, 10], [100, 90, 70, 20], [100, 60, 30, 0], [100, 20, 10, 0], [100, 80, 40, 10]]


def ies(extra="TILT=NONE", kind=1):
    numbers = [[1, 1000, 1, len(DOWN), len(AROUND), kind, 2, 0, 0, 0], [1, 1, 100], DOWN, AROUND, *CANDELA]
    return "IESNA:LM-63-2002\n[TEST] own\n%s\n" % extra + "".join(" ".join(map(str, line)) + "\n" for line in numbers)


def lamp(kind, name, **settings):
    """Of 10 W/sr, and a point but for areas."""
    return blender_words.lamp(kind, name, energy=4.0 * math.pi * 10.0, **({} if kind == "AREA" else {"shadow_soft_size": 0.0}), **settings)


def shine_by(o, text, strength=1.0, path=None):
    tree, emission = lamp_nodes(o)
    node = tree.nodes.new("ShaderNodeTexIES")
    node.inputs["Strength"].default_value = strength
    if path is None:
        node.mode, node.ies = "INTERNAL", bpy.data.texts.new("ies")
        node.ies.write(text)
    else:
        node.mode, node.filepath = "EXTERNAL", path
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.25, 1.0)
    tree.links.new(node.outputs["Fac"], emission.inputs["Strength"])
    return tree, node


def turned(tree, node, by):
    coordinates, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = by
    tree.links.new(coordinates.outputs["Normal"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])


def lamps():
    """Those whose files are carried."""
    with open("lamp.ies", "w") as file:
        file.write(ies())
    shine_by(lamp("POINT", "inside"), ies(), 2.0)
    shine_by(lamp("POINT", "outside", turn=(0.0, 0.0, math.pi / 2)), None, 1.0, "//lamp.ies")
    turned(*shine_by(lamp("POINT", "mapped"), ies()), (0.0, 0.0, math.pi / 2))
    lamp("SPOT", "spot", spot_size=math.radians(120.0), spot_blend=1.0)
    lamp("SPOT", "wide", spot_size=math.radians(90.0), spot_blend=1.0).scale = (2.0, 1.0, 1.0)


def lost():
    """Those whose files are not."""
    shine_by(lamp("AREA", "panel"), ies())
    shine_by(lamp("POINT", "sideways"), ies(kind=2))
    shine_by(lamp("POINT", "missing"), None, 1.0, "//none.ies")
    dimmed = lamp("POINT", "dimmed")
    tree, node = shine_by(dimmed, ies())
    plus = tree.nodes.new("ShaderNodeMath")
    tree.links.new(node.outputs[0], plus.inputs[0])
    tree.links.new(plus.outputs[0], lamp_nodes(dimmed)[1].inputs["Strength"])
    gobo = lamp("POINT", "gobo")
    tree, _ = shine_by(gobo, ies())
    image = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(image.outputs["Fac"], lamp_nodes(gobo)[1].inputs["Strength"])


def set_up():
    scene = begin()
    scene.render.engine = "CYCLES"
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 64
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    bpy.ops.mesh.primitive_plane_add(size=4)
    eye((0, 0, 5), (0, 0, 0), "eye")
    save("lamps")  # so that files are beside it
