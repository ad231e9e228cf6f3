"""Scenes of shapes that shine, whose pictures have no noise but that of edges, for test_blender_export.c."""
import math

import bpy

from blender_words import begin, eye, geometry_group, instances_of, key, moved_to, placed, shine


def shot():
    """Frames, rate, size and lens that are not the usual ones; of frames 101 and 110."""
    scene = begin(110, 101)
    render = scene.render
    render.fps, render.fps_base = 30, 1.001
    render.resolution_x, render.resolution_y, render.resolution_percentage = 160, 90, 40
    render.pixel_aspect_x, render.pixel_aspect_y = 1.0, 1.5
    for i in range(30):
        bpy.ops.mesh.primitive_cube_add(size=0.7, location=(i % 6 - 2.5, (i * 7) % 5, i // 6 - 2))
        bpy.context.object.data.materials.append(shine("m%d" % i, (i % 3 + 0.2, (i // 3) % 3 + 0.1, 1.5 - i % 2)))
    camera = eye((0, 0, 0), (math.radians(85), 0.1, 0))
    data = camera.data
    data.sensor_fit, data.sensor_width, data.sensor_height = "AUTO", 36, 24
    data.shift_x, data.shift_y = 0.12, -0.08
    key(camera, "location", ((101, (-1, -7, 0.5)), (110, (1, -7, 0))))
    key(data, "lens", ((101, 30), (110, 60)))
    # frames 104 to 106 are another camera's
    side = placed("Side", bpy.data.cameras.new("Side"), (7, 0, 0), (math.radians(90), 0, math.radians(90)))
    for frame, which in ((101, camera), (104, side), (107, camera)):
        scene.timeline_markers.new(which.name, frame=frame).camera = which
    key(bpy.data.objects["Cube"], "rotation_euler", ((101, (0, 0, 0)), (110, (0, 0, 1))))
    # behind the camera: what moves by a shape key, and what follows another object
    bpy.ops.mesh.primitive_cube_add(location=(0, -30, 0))
    wave = bpy.context.object
    wave.name = "Wave"
    wave.shape_key_add(name="Basis")
    bent = wave.shape_key_add(name="bent")
    bent.data[0].co.z += 1.0
    key(bent, "value", ((104, 0.0), (106, 1.0)))
    guide = placed("guide")
    key(guide, "location", ((101, (0, 0, 0)), (110, (1, 0, 0))))
    bpy.ops.mesh.primitive_cube_add(location=(0, -40, 0))
    bpy.context.object.name = "Follower"
    follow = bpy.context.object.constraints.new("COPY_LOCATION")
    follow.target, follow.use_offset = guide, True
    return 101, 110


def mesh(name, kind, colour, place, **how):
    getattr(bpy.ops.mesh, "primitive_%s_add" % kind)(location=place, **how)
    o = bpy.context.object
    o.name = name
    o.data.materials.append(shine(name, colour))
    return o


def geometry_nodes(o, source):
    """Instances of an object on the points of the mesh, scaled and turned."""
    scatter, = geometry_group(o, "GeometryNodeInstanceOnPoints", name="scatter")
    info = scatter.id_data.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = source
    scatter.inputs["Scale"].default_value = (0.5, 1.0, 0.7)
    scatter.inputs["Rotation"].default_value = (0.3, 0.6, 0.1)
    scatter.id_data.links.new(info.outputs["Geometry"], scatter.inputs["Instance"])


def geometry():
    """Instances and modifiers of every kind."""
    scene = begin()
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
    group = moved_to(bpy.data.collections.new("group"), mesh("piece", "monkey", (1, 0.5, 0.1), (0, 0, 0), size=1.0))
    instances_of(group, "left", (-3.4, 0, 0.4)).scale = (0.7, 0.7, 0.7)
    instances_of(group, "right", (3.6, 0, -0.6)).scale = (-0.7, 0.7, 0.5)
    # a character's pose, and text
    armature = placed("bones", bpy.data.armatures.new("bones"), (1.2, 0, 0))
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
    text = placed("text", bpy.data.curves.new("text", "FONT"), (-2, 0, -2.4), (math.pi / 2, 0, 0))
    text.data.body = "R"
    text.data.materials.append(shine("text", (0.3, 1, 0.6)))
    # left out: an excluded collection and a holdout, which lies behind all
    out = bpy.data.collections.new("out")
    scene.collection.children.link(out)
    moved_to(out, mesh("excluded", "cube", (9, 9, 9), (0, -3, 0), size=1))
    bpy.context.view_layer.layer_collection.children["out"].exclude = True
    mesh("hole in the picture", "cube", (9, 9, 9), (0, 9, 0), size=1).is_holdout = True
    eye((0.3, -13, 0.2))
