"""Writes a .blend as .glb for Reframe, without a window:

    blender -b scene.blend -P scripts/blender-export.py -- out.glb [--camera NAME] [--frames A-B]

Blender's own glTF exporter does the work; this makes ready what it leaves out.
The camera is baked frame by frame, whatever moves it (parents, constraints,
drivers). Area lights become quads or discs that glow on one side with the same
power. Point, spot and sun lamps are written in W/sr and W/m2 (the exporter's
"unitless" mode), as Reframe takes them. A world of one colour goes into the
scene's custom property `reframe`, as its environment. Custom properties are kept.
"""
import argparse
import math
import os
import sys

import numpy

numpy.bool = bool  # the exporter of Blender 3.4 with a newer numpy
import bpy  # noqa: E402
import mathutils  # noqa: E402

DISC_CORNERS = 64


def fail(text):
    print("blender-export: " + text, file=sys.stderr)
    sys.stderr.flush()
    os._exit(1)  # Blender makes 0 of an exception


def parse():
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    p = argparse.ArgumentParser(prog="blender -b scene.blend -P blender-export.py --", description=__doc__.split("\n")[0])
    p.add_argument("out", help="the .glb to write")
    p.add_argument("--camera", help="the camera to bake; default: the scene's active one")
    p.add_argument("--frames", help="A-B; default: the scene's own range")
    try:
        args = p.parse_args(own)
    except SystemExit as e:
        os._exit(e.code if isinstance(e.code, int) else 2)
    if not args.out.endswith(".glb"):
        fail("%s: only .glb is written: name it .glb" % args.out)
    folder = os.path.dirname(os.path.abspath(args.out))
    if not os.path.isdir(folder):
        fail("%s: cannot be written: there is no folder %s" % (args.out, folder))
    return args


def frame_range(scene, text):
    if not text:
        return scene.frame_start, scene.frame_end
    try:
        first, last = (int(n) for n in text.split("-"))
    except ValueError:
        fail("--frames: wants A-B, got '%s'" % text)
    if last < first:
        fail("--frames: %d comes after %d" % (first, last))
    return first, last


def find_camera(scene, name):
    cameras = [o for o in scene.objects if o.type == "CAMERA"]
    if name is None and scene.camera is not None:
        return scene.camera
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    fail("no camera%s in the scene: it has %s" % (" '%s'" % name if name else "", ", ".join(c.name for c in cameras) or "none"))


def bake_camera(scene, camera, first, last):
    """A camera of its own at the root, with a key in every frame."""
    data = camera.data.copy()
    baked = bpy.data.objects.new(camera.name + " baked", data)
    name = camera.name
    scene.collection.objects.link(baked)
    baked.rotation_mode = "QUATERNION"
    before = None
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        place, turn, _ = camera.matrix_world.decompose()
        if before is not None and before.dot(turn) < 0.0:
            turn.negate()  # the short way round between keys
        before = turn.copy()
        baked.location = place
        baked.rotation_quaternion = turn
        baked.keyframe_insert("location", frame=frame)
        baked.keyframe_insert("rotation_quaternion", frame=frame)
    for curve in baked.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    if data.animation_data is not None:
        print("blender-export: warning: the lens of '%s' is animated: the field of view of the first frame is taken" % name)
        data.animation_data_clear()
    scene.frame_set(first)
    places = [(child, child.matrix_world.copy()) for child in camera.children]
    for child, matrix in places:  # lamps at the camera, which goes
        child.parent = None
        child.matrix_world = matrix
    bpy.data.objects.remove(camera)
    baked.name = name
    scene.camera = baked


def corners_of(light):
    """A flat shape in x and y, counter-clockwise seen from -z, and its area."""
    x = 0.5 * light.size
    y = 0.5 * (light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    if light.shape in ("SQUARE", "RECTANGLE"):
        return [(-x, -y, 0), (-x, y, 0), (x, y, 0), (x, -y, 0)], 4 * x * y
    turns = [-2 * math.pi * i / DISC_CORNERS for i in range(DISC_CORNERS)]
    area = 0.5 * DISC_CORNERS * math.sin(2 * math.pi / DISC_CORNERS) * x * y
    return [(x * math.cos(a), y * math.sin(a), 0) for a in turns], area


def glow(name, color, strength):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.use_backface_culling = True  # one-sided
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0, 0, 0, 1)
    principled.inputs["Roughness"].default_value = 1.0
    principled.inputs["Specular"].default_value = 0.0
    principled.inputs["Emission"].default_value = (*color, 1)
    principled.inputs["Emission Strength"].default_value = strength
    return material


def replace_area_light(scene, lamp):
    """The world's scale stretches shape and area: power stays what it is."""
    light = lamp.data
    scale = lamp.matrix_world.to_scale()
    corners, area = corners_of(light)
    area *= abs(scale.x * scale.y)
    if area == 0.0 or light.energy <= 0.0:
        return
    mesh = bpy.data.meshes.new(lamp.name)
    mesh.from_pydata(corners, [], [list(range(len(corners)))])
    # a surface of radiance L and area A sends pi A L to its one side
    largest = max(light.color) or 1.0
    color = [c / largest for c in light.color]
    mesh.materials.append(glow(lamp.name, color, light.energy * largest / (math.pi * area)))
    quad = bpy.data.objects.new(lamp.name + " area", mesh)
    quad.matrix_world = lamp.matrix_world.copy()
    scene.collection.objects.link(quad)


def replace_area_lights(scene):
    lamps = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "AREA"]
    for lamp in lamps:
        if not lamp.hide_render:
            replace_area_light(scene, lamp)
        bpy.data.objects.remove(lamp)


def world_radiance(world):
    if world is None:
        return None
    if not world.use_nodes:
        return list(world.color)
    for node in world.node_tree.nodes:
        if node.type != "BACKGROUND" or not node.outputs[0].is_linked:
            continue
        if node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
            print("blender-export: warning: the world is no plain colour: give its map to Reframe by a scene file")
            return None
        return [c * node.inputs["Strength"].default_value for c in node.inputs["Color"].default_value[:3]]
    return None


def keep_world(scene):
    radiance = world_radiance(scene.world)
    if radiance is None or max(radiance) <= 0.0:
        return
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    own.setdefault("environment", {"radiance": radiance})
    scene["reframe"] = own


def export(path):
    bpy.ops.export_scene.gltf(
        filepath=path, export_format="GLB", export_cameras=True, export_lights=True, export_extras=True, export_apply=True,
        use_renderable=True,  # what is hidden stays in the scene: cutters, targets and parents are
        export_yup=True, export_animations=True, export_frame_range=True, export_force_sampling=False,
        convert_lighting_mode="COMPAT")


def main():
    args = parse()
    scene = bpy.context.scene
    first, last = frame_range(scene, args.frames)
    scene.frame_start, scene.frame_end = first, last
    bake_camera(scene, find_camera(scene, args.camera), first, last)
    replace_area_lights(scene)
    keep_world(scene)
    export(os.path.abspath(args.out))
    if not os.path.exists(args.out):
        fail("%s: was not written: see Blender's messages above" % args.out)
    print("blender-export: %s: frames %d to %d" % (args.out, first, last))


try:
    main()
except Exception as e:  # whatever Blender raises is one line and a status
    lines = [line.strip() for line in str(e).splitlines() if line.strip() and not line.startswith("Location:")]
    fail("%s: %s" % (type(e).__name__, lines[-1] if lines else "no more is known"))
