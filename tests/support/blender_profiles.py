"""A .blend of lamps that shine to each side otherwise, for test_blender_profiles.c: lamps.blend, and with the argument "lost" those whose
files cannot be carried. Run inside Blender."""
import math
import os
import sys

import bpy

DOWN, AROUND = (0, 30, 60, 90), (0, 90, 180, 270, 360)
CANDELA = [[100, 80, 40, 10], [100, 90, 70, 20], [100, 60, 30, 0], [100, 20, 10, 0], [100, 80, 40, 10]]


def ies(extra="TILT=NONE", kind=1):
    numbers = [[1, 1000, 1, len(DOWN), len(AROUND), kind, 2, 0, 0, 0], [1, 1, 100], DOWN, AROUND, *CANDELA]
    return "IESNA:LM-63-2002\n[TEST] own\n%s\n" % extra + "".join(" ".join(map(str, line)) + "\n" for line in numbers)


def lamp(kind, name, place=(0, 0, 3), turn=(0, 0, 0)):
    data = bpy.data.lights.new(name, kind)
    data.energy = 4.0 * math.pi * 10.0
    if kind != "AREA":
        data.shadow_soft_size = 0.0
    o = bpy.data.objects.new(name, data)
    o.location, o.rotation_euler = place, turn
    bpy.context.scene.collection.objects.link(o)
    return o


def shine_by(o, text, strength=1.0, path=None):
    o.data.use_nodes = True
    tree = o.data.node_tree
    node, emission = tree.nodes.new("ShaderNodeTexIES"), next(n for n in tree.nodes if n.type == "EMISSION")
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


def make():
    with open("lamp.ies", "w") as file:
        file.write(ies())
    shine_by(lamp("POINT", "inside"), ies(), 2.0)
    shine_by(lamp("POINT", "outside", turn=(0.0, 0.0, math.pi / 2)), None, 1.0, "//lamp.ies")
    turned(*shine_by(lamp("POINT", "mapped"), ies()), (0.0, 0.0, math.pi / 2))
    spot = lamp("SPOT", "spot")
    spot.data.spot_size, spot.data.spot_blend = math.radians(120.0), 1.0
    wide = lamp("SPOT", "wide")
    wide.data.spot_size, wide.data.spot_blend, wide.scale = math.radians(90.0), 1.0, (2.0, 1.0, 1.0)


def make_lost():
    shine_by(lamp("AREA", "panel"), ies())
    shine_by(lamp("POINT", "sideways"), ies(kind=2))
    shine_by(lamp("POINT", "missing"), None, 1.0, "//none.ies")
    tree, node = shine_by(lamp("POINT", "dimmed"), ies())
    plus = tree.nodes.new("ShaderNodeMath")
    emission = node.outputs[0].links[0].to_node
    tree.links.new(node.outputs[0], plus.inputs[0])
    tree.links.new(plus.outputs[0], emission.inputs["Strength"])
    tree, node = shine_by(lamp("POINT", "gobo"), ies())
    image = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(image.outputs["Fac"], emission_of(tree).inputs["Strength"])


def emission_of(tree):
    return next(n for n in tree.nodes if n.type == "EMISSION")


bpy.ops.wm.read_factory_settings(use_empty=True)
s = bpy.context.scene
s.render.engine = "CYCLES"
s.cycles.max_bounces = s.cycles.diffuse_bounces = s.cycles.glossy_bounces = s.cycles.transmission_bounces = 64
s.cycles.sample_clamp_direct = s.cycles.sample_clamp_indirect = 0.0
s.frame_start = s.frame_end = 1
bpy.ops.mesh.primitive_plane_add(size=4)
eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
eye.location = (0, 0, 5)
s.collection.objects.link(eye)
s.camera = eye
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("lamps.blend"))
make_lost() if "lost" in sys.argv else make()
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("lamps.blend"))
