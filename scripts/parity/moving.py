"""Small scenes that move, in frames 1 to 20."""
import bpy

from parity.still import shape_key
from parity.words import *  # noqa: F401,F403

SHOWN = (4, 12, 20)
ENDS = (1, 20)


def bake_physics():
    bpy.context.view_layer.update()
    bpy.ops.ptcache.bake_all(bake=True)


@scene(SHOWN, 48)
def move_keys():
    """A child with keys on a parent that turns and grows."""
    o, child = sample()
    child.parent = parent = placed("parent")
    key(parent, "rotation_euler", zip(ENDS, (0.0, 2.0)), 2)
    key(parent, "scale", zip(ENDS, ((1, 1, 1), (1.3, 0.8, 1.2))))
    key(child, "location", zip(ENDS, ((1.1, 0.2, 0.6), (1.6, -0.5, 1.0))))
    key(o, "location", zip((1, 10, 20), ((-1.0, 0.0, 0.7), (-1.5, -0.8, 1.2), (-0.5, 0.5, 0.7))))


@scene(SHOWN, 48)
def move_follow():
    """A constraint along a curve, and a driver by the frame."""
    o, block = sample()
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.5, location=(0, -0.3, 0.7))
    path = shaped("path", None)
    path.data.use_path, path.data.path_duration = True, 40
    key(path.data, "eval_time", zip(ENDS, (0.0, 30.0)))
    follow = o.constraints.new("FOLLOW_PATH")
    follow.target, o.location = path, (0, 0, 0)
    driver = block.driver_add("rotation_euler", 2).driver
    driver.type, driver.expression = "SCRIPTED", "frame * 0.1"


@scene(SHOWN, 48)
def move_rigid_body():
    o, block = sample()
    o.location, block.location = (-0.6, -0.5, 2.2), (0.7, -0.3, 1.2)
    for body, kind in ((o, "ACTIVE"), (block, "ACTIVE"), (bpy.data.objects["floor"], "PASSIVE")):
        bpy.context.view_layer.objects.active = body
        bpy.ops.rigidbody.object_add(type=kind)
    bpy.data.objects["floor"].rigid_body.collision_shape = "MESH"
    bake_physics()


@scene(SHOWN, 48)
def move_armature():
    sample()
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.25, depth=2.0, location=(0.1, -1.2, 1.0))
    arm = shaped("arm", matte(GOLD), True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0.1, -1.2, 1.0), plane_no=(0, 0, 1))
    bpy.ops.mesh.subdivide(number_cuts=3)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.armature_add(location=(0.1, -1.2, 0.0))
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    low = rig.data.edit_bones[0]
    low.tail = (0, 0, 1.0)
    high = rig.data.edit_bones.new("high")
    high.head, high.tail, high.parent = (0, 0, 1.0), (0, 0, 2.0), low
    bpy.ops.object.mode_set(mode="OBJECT")
    arm.select_set(True)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    bone = rig.pose.bones["high"]
    bone.rotation_mode = "XYZ"
    key(bone, "rotation_euler", zip(ENDS, ((0, 0, 0), (0.6, 0.3, 1.2))))


@scene(SHOWN, 48)
def move_shape_keys():
    shape_key()
    block = bpy.data.objects["ball"].data.shape_keys.key_blocks["tall"]
    key(block, "value", zip((1, 12, 20), (0.0, 1.0, 0.3)))


@scene(SHOWN, 48)
def move_cloth():
    """Cloth that falls on a ball, and waves by a modifier."""
    sample()
    cloth = sheet((-1.0, 0.0, 1.7), (1.8, 1.8), matte(GOLD), "cloth", cuts=12)
    bpy.ops.object.transform_apply(scale=True)
    cloth.modifiers.new("cloth", "CLOTH")
    bpy.data.objects["ball"].modifiers.new("hard", "COLLISION")
    water = sheet((1.2, -1.6, 0.3), (2.0, 1.2), principled(BLUE, Roughness=0.3), "water", cuts=24)
    wave = water.modifiers.new("wave", "WAVE")
    wave.height, wave.width, wave.narrowness, wave.time_offset = 0.3, 0.5, 3.0, -20.0
    bake_physics()


@scene(SHOWN, 48)
def move_particles():
    """Born from frame 1 to 15, dead after 8 frames."""
    sample()
    drop = ball((0, 0, -5), 0.15, principled(GOLD, Metallic=1.0, Roughness=0.4), "drop")
    source = sheet((0.0, -1.0, 1.8), (2.0, 0.8), matte(BLUE), "source")
    source.modifiers.new("rain", "PARTICLE_SYSTEM")
    rain = source.particle_systems[0].settings
    rain.count, rain.frame_start, rain.frame_end, rain.lifetime = 40, 1, 15, 8
    rain.render_type, rain.instance_object, rain.particle_size, rain.size_random = "OBJECT", drop, 1.0, 0.5
    bake_physics()


@scene(SHOWN, 48)
def move_topology():
    """The number of an array, and a cutter that moves through a box."""
    o, block = sample()
    o.scale = (0.5, 0.5, 0.5)
    array = o.modifiers.new("row", "ARRAY")
    array.relative_offset_displace = (0.0, -1.1, 0.0)
    key(array, "count", zip(ENDS, (1, 4)))
    cutter = ball((1.1, -0.6, 2.0), 0.6, None, "cutter")
    cutter.hide_render = True
    key(cutter, "location", zip(ENDS, ((1.1, -0.6, 2.0), (1.1, -0.6, 0.3))))
    cut = block.modifiers.new("cut", "BOOLEAN")
    cut.object, cut.operation = cutter, "DIFFERENCE"


@scene(SHOWN, 48)
def move_hide():
    o, block = sample()
    key(o, "hide_render", ((1, False), (8, True), (16, False)), interpolation="CONSTANT")
    key(block, "hide_render", ((1, True), (10, False)), interpolation="CONSTANT")


@scene(SHOWN, 48)
def move_lamps():
    """Energy, colour, size and place of lamps."""
    stage()
    area = softbox((-2.0, -2.0, 3.0), 100.0)
    key(area.data, "energy", zip(ENDS, (50.0, 300.0)))
    key(area.data, "size", zip(ENDS, (0.5, 2.5)))
    point = lamp("POINT", (2.0, -1.5, 2.0), 100.0, shadow_soft_size=0.1)
    key(point.data, "color", zip(ENDS, ((1.0, 0.2, 0.1), (0.2, 0.4, 1.0))))
    key(point, "location", zip(ENDS, ((2.0, -1.5, 2.0), (0.0, -1.5, 1.5))))
    sun = lamp("SUN", (-2, 3, 4), 1.0, (0, 0, 0.5), angle=0.05)
    key(sun.data, "energy", zip(ENDS, (1.0, 0.0)))


@scene(SHOWN, 48)
def move_glow():
    """Emission, the strength of the world, an image sequence and a base colour."""
    lit, painted = glow((1.0, 0.6, 0.3), 1.0), matte(RED, "paint")
    o, _ = stage(lit, painted)
    key(next(n for n in lit.node_tree.nodes if n.type == "EMISSION").inputs["Strength"], "default_value", zip(ENDS, (0.2, 6.0)))
    key(next(n for n in painted.node_tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"], "default_value",
        zip(ENDS, ((0.8, 0.1, 0.1, 1.0), (0.1, 0.2, 0.9, 1.0))))
    tree, background = world((0.4, 0.5, 0.6))
    key(background.inputs["Strength"], "default_value", zip(ENDS, (0.2, 1.0)))
    for i in range(1, 21):
        frame = picture("film%04d.png" % i, 16, 16, lambda u, v, i=i: (0.05 * i + 0.0 * u, 0.5 * v + 0.0 * u, 0.8 - 0.03 * i + 0.0 * u))
        if i > 1:
            bpy.data.images.remove(frame)
    frame = bpy.data.images["film0001.png"]
    frame.source = "SEQUENCE"

    def shader(t):
        node = image_node(t, frame)
        node.image_user.frame_duration, node.image_user.frame_start, node.image_user.use_auto_refresh = 20, 1, True
        return add(t, "Emission", Color=node, Strength=2.0)
    sheet((1.0, 1.5, 2.2), (1.5, 1.0), material("screen", shader), "screen", UPRIGHT)


@scene((6, 10, 11))
def move_cuts():
    """Markers that change the camera, with motion blur of half a frame and a ball that passes."""
    o, _ = sample()
    key(o, "location", zip(ENDS, ((-3.0, -0.5, 0.7), (3.0, -0.5, 0.7))), interpolation="LINEAR")
    first = bpy.context.scene.camera
    key(first, "location", zip(ENDS, ((-1.0, -6.0, 2.4), (1.0, -6.0, 2.4))), interpolation="LINEAR")
    second = camera((3.0, -4.0, 3.0), (0.0, 0.0, 0.5))
    for frame, who in ((1, first), (11, second)):
        marker = bpy.context.scene.timeline_markers.new("cut", frame=frame)
        marker.camera = who
    bpy.context.scene.camera = first
    bpy.context.scene.render.use_motion_blur, bpy.context.scene.render.motion_blur_shutter = True, 0.5
