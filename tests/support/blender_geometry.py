"""For test_blender_export.c: geometry.blend, of instances and modifiers of every kind, and Cycles' picture
of it, geometry-1.exr. All surfaces shine, so that the picture has no noise but that of edges.
"""
import math
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
sys.dont_write_bytecode = True
from blender_both import geometry_tree  # noqa: E402
from blender_shot import cycles_picture, shine  # noqa: E402


def mesh(name, kind, colour, place, **how):
    getattr(bpy.ops.mesh, "primitive_%s_add" % kind)(location=place, **how)
    o = bpy.context.object
    o.name = name
    o.data.materials.append(shine(name, colour))
    return o


def geometry_nodes(o, source):
    """Instances of an object on the points of the mesh, scaled and turned."""
    tree = geometry_tree("scatter")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    info, scatter = tree.nodes.new("GeometryNodeObjectInfo"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    info.inputs["Object"].default_value = source
    scatter.inputs["Scale"].default_value = (0.5, 1.0, 0.7)
    scatter.inputs["Rotation"].default_value = (0.3, 0.6, 0.1)
    tree.links.new(start.outputs[0], scatter.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], end.inputs[0])
    o.modifiers.new("scatter", "NODES").node_group = tree


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start = scene.frame_end = 1
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 72, 100
    # rendered at level 3, shown at level 0
    ball = mesh("ball", "cube", (1, 0.2, 0.2), (-3, 0, 2), size=2)
    levels = ball.modifiers.new("smooth", "SUBSURF")
    levels.levels, levels.render_levels = 0, 3
    # a modifier that only the viewport has
    ball.modifiers.new("array", "ARRAY").show_render = False
    # a hidden cutter still cuts, and is not seen
    cut = mesh("cut", "cube", (0.2, 1, 0.2), (0, 0, 2), size=1.6)
    cutter = mesh("cutter", "cylinder", (9, 9, 9), (0, 0, 2), radius=0.5, depth=3, rotation=(math.pi / 2, 0, 0))
    cutter.hide_render = True
    hole = cut.modifiers.new("hole", "BOOLEAN")
    hole.object = cutter
    # instances by geometry nodes of an object that is itself hidden in the viewport
    seed = mesh("seed", "cone", (0.2, 0.2, 1), (20, 0, 0), radius1=0.3, depth=0.8)
    seed.hide_viewport = True
    geometry_nodes(mesh("field", "grid", (1, 1, 1), (3, 0, 2), x_subdivisions=3, y_subdivisions=3, size=2,
                        rotation=(math.pi / 2, 0, 0)), seed)
    # by vertices and by faces
    for kind, x, colour in (("VERTS", -3, (1, 1, 0)), ("FACES", -0.5, (0, 1, 1))):
        parent = mesh("by " + kind, "ico_sphere", (5, 5, 5), (x, 0, -1), radius=0.9, subdivisions=1)
        child = mesh("child " + kind, "cube", colour, (x, 0, -1), size=0.4)
        child.parent = parent
        child.matrix_parent_inverse = parent.matrix_world.inverted()
        parent.instance_type = kind
        parent.show_instancer_for_render = False
        parent.use_instance_faces_scale = True
    # by particles, and by a collection that is placed twice, once mirrored
    emitter = mesh("emitter", "plane", (0.5, 0.5, 0.5), (2, 0, -1.8), size=1.6)
    emitter.modifiers.new("grains", "PARTICLE_SYSTEM")
    grains = emitter.particle_systems[0].settings
    grains.count, grains.frame_start, grains.frame_end, grains.lifetime = 12, 1, 1, 50
    grains.physics_type, grains.emit_from, grains.use_emit_random = "NO", "FACE", False
    grains.render_type, grains.instance_object, grains.particle_size = "OBJECT", seed, 0.6
    grains.display_percentage = 25
    group = bpy.data.collections.new("group")
    piece = mesh("piece", "monkey", (1, 0.5, 0.1), (0, 0, 0), size=1.0)
    scene.collection.objects.unlink(piece)
    group.objects.link(piece)
    for name, scale in (("left", (0.7, 0.7, 0.7)), ("right", (-0.7, 0.7, 0.5))):
        place = bpy.data.objects.new(name, None)
        place.instance_type, place.instance_collection = "COLLECTION", group
        place.location, place.scale = (-3.4 if name == "left" else 3.6, 0, 0.4 if name == "left" else -0.6), scale
        scene.collection.objects.link(place)
    # a character's pose, and text
    armature = bpy.data.objects.new("bones", bpy.data.armatures.new("bones"))
    scene.collection.objects.link(armature)
    armature.location = (1.2, 0, 0)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("arm")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    arm = mesh("arm", "cube", (1, 0, 1), (1.2, 0, 0.2), size=0.4)
    arm.vertex_groups.new(name="arm").add(range(8), 1.0, "ADD")
    arm.modifiers.new("pose", "ARMATURE").object = armature
    armature.pose.bones["arm"].rotation_mode = "XYZ"
    armature.pose.bones["arm"].rotation_euler = (0, 0.9, 0.4)
    text = bpy.data.objects.new("text", bpy.data.curves.new("text", "FONT"))
    text.data.body, text.location, text.rotation_euler = "R", (-2, 0, -2.4), (math.pi / 2, 0, 0)
    text.data.materials.append(shine("text", (0.3, 1, 0.6)))
    scene.collection.objects.link(text)
    # left out: an excluded collection and a holdout, which lies behind all
    out = bpy.data.collections.new("out")
    scene.collection.children.link(out)
    excluded = mesh("excluded", "cube", (9, 9, 9), (0, -3, 0), size=1)
    scene.collection.objects.unlink(excluded)
    out.objects.link(excluded)
    bpy.context.view_layer.layer_collection.children["out"].exclude = True
    mesh("hole in the picture", "cube", (9, 9, 9), (0, 9, 0), size=1).is_holdout = True
    eye = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    eye.location, eye.rotation_euler = (0.3, -13, 0.2), (math.pi / 2, 0, 0)
    scene.collection.objects.link(eye)
    scene.camera = eye
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("geometry.blend"))
    cycles_picture(scene, 1, "geometry-1.exr")


if __name__ == "__main__":
    main()
