"""Scenes of things that move, appear and disappear, for test_blender_movement.c."""
import math

import bpy

from blender_losses import lamp, plain
from blender_words import geometry_group, instances_of, key, moved_to, placed, shine


def wedge(name, place=(0, 0, 0)):
    """A shape without symmetry, so that what turns or mirrors it shows in the box around it."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0.2, 0.7, 0), (0.1, 0.2, 0.5)], [], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    return placed(name, mesh, place)


def rigid():
    """Keys, parents, constraints, drivers, a path, lamps; mirrored, sheared, flat and vanishing scales; what is hidden in some frames."""
    scene = plain()
    scene.frame_start, scene.frame_end = 3, 12
    turns = (3, (0, 0, 0)), (12, (0.5, 1, 9))
    keyed = wedge("keyed")
    key(keyed, "location", ((3, (0, 0, 0)), (12, (3, 0, 1))))
    key(keyed, "rotation_euler", turns)
    above = wedge("above", (0, 3, 0))
    key(above, "rotation_euler", turns)
    between = wedge("between", (2, 0, 0))
    between.parent, between.scale = above, (2, 2, 2)
    below = wedge("below", (1, 0, 0))
    below.parent = between
    key(below, "location", ((3, (1, 0, 0)), (12, (1, 1, 0))))
    looks = wedge("looks", (-3, 0, 0)).constraints.new("TRACK_TO")
    looks.target = keyed
    driver = wedge("driven", (-3, 3, 0)).driver_add("location", 2).driver
    driver.expression = "frame * frame / 50"
    line = bpy.data.curves.new("line", "CURVE")
    line.dimensions, line.use_path, line.path_duration = "3D", True, 10
    spline = line.splines.new("POLY")
    spline.points.add(2)
    for point, at in zip(spline.points, ((0, 0, 0, 1), (2, 1, 0, 1), (3, 3, 2, 1))):
        point.co = at
    path = placed("path", line, (4, 0, 0))
    along = wedge("along").constraints.new("FOLLOW_PATH")
    along.target, along.use_curve_follow = path, True
    key(along, "offset", ((3, 0.0), (12, -10.0)))
    wide = wedge("wide", (0, 6, 0))
    wide.scale = (1, 3, 1)
    for name, moves in (("sheared", True), ("always sheared", False)):
        sheared = wedge(name)
        sheared.parent, sheared.rotation_euler = wide, (0, 0, 1)
        if moves:
            key(sheared, "rotation_euler", turns)
    still = wedge("sheared, and moves")
    still.parent, still.rotation_euler = wide2(), (0, 0, 1)
    mirrored = wedge("mirrored", (-3, 3, 4))
    mirrored.scale = (-1, 1, 2)
    key(mirrored, "rotation_euler", turns)
    key(wedge("vanishes", (-3, 6, 0)), "scale", ((3, (0, 0, 0)), (5, (1, 1, 1)), (8, (1, 0, 1)), (10, (0, 0, 1)), (12, (1, 1, 1))))
    key(wedge("turns inside out", (-3, 9, 0)), "scale", ((3, (1, 1, 1)), (12, (-1, 1, 1))))
    hidden = wedge("hidden", (-6, 0, 0))
    key(hidden, "location", ((3, (-6, 0, 0)), (12, (-6, 3, 0))))
    key(hidden, "hide_render", ((3, True), (6, False), (9, True)))
    key(wedge("appears", (-6, 0, 3)), "hide_render", ((3, True), (7, False)))
    key(lamp("AREA", "panel"), "location", ((3, (0, 0, 5)), (12, (3, 0, 5))))
    scene.objects["panel"].rotation_euler = (0.5, 0.2, 0.3)
    key(lamp("SPOT", "beam"), "rotation_euler", turns)
    scene.frame_set(3)


def wide2():
    """Scaled, and moves."""
    o = wedge("wide and moves", (3, 6, 0))
    o.scale = (1, 3, 1)
    key(o, "location", ((3, (3, 6, 0)), (12, (3, 6, 2))))
    key(o, "rotation_euler", ((3, (0, 0, 0)), (12, (0, 1, 0))))
    return o


def scatter(o, source, moves):
    """Instances of geometry nodes, which go up and down."""
    points, *move = geometry_group(o, "GeometryNodeInstanceOnPoints", *["GeometryNodeRotateInstances"] * moves)
    tree = points.id_data
    info = tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = source
    tree.links.new(info.outputs["Geometry"], points.inputs["Instance"])
    for node in move:
        tree.links.new(tree.nodes.new("GeometryNodeInputSceneTime").outputs["Seconds"], node.inputs["Rotation"])


def many():
    """Particles that are born and die, instances that move and that stand still, collections, rigid bodies."""
    scene = plain()
    scene.frame_start, scene.frame_end = 1, 12
    seed, grain = wedge("seed", (0, 9, 0)), wedge("grain", (0, 12, 0))
    for name, x, moves in (("moves", 6, True), ("still", 12, False)):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, location=(x, 0, 0))
        bpy.context.object.name = name
        scatter(bpy.context.object, seed, moves)
    bpy.ops.mesh.primitive_plane_add(location=(-6, 0, 0))
    emitter = bpy.context.object
    emitter.modifiers.new("grains", "PARTICLE_SYSTEM")
    settings = emitter.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 20, 1, 6, 5
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", grain, 0.2
    place = instances_of(moved_to(bpy.data.collections.new("group"), wedge("one"), wedge("two")))
    key(place, "location", ((1, (0, -6, 0)), (12, (4, -6, 2))))
    bpy.ops.rigidbody.world_add()
    for o, kind in ((scene.objects["cube"], "PASSIVE"), (wedge("falls", (0.1, 0.2, 1.0)), "ACTIVE")):
        bpy.context.view_layer.objects.active = o
        bpy.ops.rigidbody.object_add(type=kind)
    scene.frame_set(1)


def film():
    """Cycles' pictures of what turns, moves and appears, with motion blur; all shines, so that they have no noise but that of edges."""
    scene = plain()
    for name in ("cube", "key"):
        bpy.data.objects.remove(scene.objects[name])
    scene.frame_start, scene.frame_end = 1, 8
    render = scene.render
    render.resolution_x, render.resolution_y = 64, 48
    render.use_motion_blur, render.motion_blur_shutter = True, 0.5
    for name, x, colour in (("left", -1.5, (1, 0.2, 0.2)), ("right", 1.0, (0.2, 1, 0.2)), ("new", -0.5, (0.2, 0.3, 1))):
        o = wedge(name, (x, 0, -0.7 if name != "new" else 0.6))
        o.scale = (1.5, 1.5, 1.5)
        o.data.materials.append(shine(name, colour))
    key(scene.objects["left"], "rotation_euler", ((1, (0, 0, 0)), (8, (0, 1.5, 0))))
    key(scene.objects["right"], "location", ((1, (-0.5, 0, -0.7)), (8, (2, 0, 0.5))))
    key(scene.objects["new"], "hide_render", ((1, True), (5, False)))
    scene.frame_set(1)
    return 4, 5


def edit():
    """Two cameras that a marker cuts between, with motion blur, of a shape that shines."""
    scene = plain()
    scene.objects["cube"].data.materials.append(shine("bright", (1, 0.5, 0.2)))
    scene.frame_start, scene.frame_end = 1, 6
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    for name, place in (("Eye", (0, -6, 0)), ("Side", (1, -4, 1))):
        eye = scene.objects.get(name)
        if eye is None:
            eye = placed(name, bpy.data.cameras.new(name), place, (math.pi / 2, 0, 0))
        key(eye, "location", ((1, place), (6, (place[0] + 1, place[1], place[2]))))
    for name, frame in (("Eye", 1), ("Side", 4)):
        scene.timeline_markers.new(name, frame=frame).camera = scene.objects[name]
    scene.frame_set(1)
