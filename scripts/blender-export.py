"""Exports a .blend as .glb for Reframe, in background mode:

    blender -b scene.blend -P scripts/blender-export.py -- out.glb [--camera NAME] [--frames A-B] [--overwrite]

Uses Blender's own glTF exporter and adds what it leaves out. The camera is baked
frame by frame, whatever animates it (parents, constraints, drivers). Area lights
become one-sided emissive quads or discs of the same power. Point, spot and sun lamps
are written in W/sr and W/m2 (the exporter's "unitless" mode), as Reframe expects
them. A world of constant colour becomes the environment in the scene's custom
property `reframe`; any other world (a rotated environment texture, a sky, any nodes)
is rendered by Cycles to a map, out-sky.exr beside out.glb, to which that property
refers. Custom properties are kept. Anything that cannot be exported gives a warning.
"""
import argparse
import json
import math
import os
import struct
import sys
import urllib.parse

import numpy

numpy.bool = bool  # the exporter of Blender 3.4 uses a name that numpy has removed
import bpy  # noqa: E402
import mathutils  # noqa: E402

DISC_CORNERS = 64
LARGEST_MAP = 8192  # pixels across
SKY_MAP = 2048  # if no image determines the size
SKY_SAMPLES = 4


def warn(text):
    print("blender-export: warning: " + text, file=sys.stderr)


def fail(text):
    print("blender-export: " + text, file=sys.stderr)
    sys.stderr.flush()
    os._exit(1)  # after an exception Blender would exit with status 0


def parse():
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    p = argparse.ArgumentParser(prog="blender -b scene.blend -P blender-export.py --", description=__doc__.split("\n")[0])
    p.add_argument("out", help="the .glb to write")
    p.add_argument("--camera", help="the camera to bake; default: the scene's active one")
    p.add_argument("--frames", help="A-B; default: the scene's own range")
    p.add_argument("--overwrite", action="store_true", help="replace files that are there already")
    try:
        args = p.parse_args(own)
    except SystemExit as e:
        os._exit(e.code if isinstance(e.code, int) else 2)
    if not args.out.endswith(".glb"):
        fail("%s: only .glb is written: name it .glb" % args.out)
    folder = os.path.dirname(os.path.abspath(args.out))
    if not os.path.isdir(folder):
        fail("%s: cannot be written: there is no folder %s" % (args.out, folder))
    refuse(args, args.out)
    return args


def refuse(args, path):
    if os.path.lexists(path) and not args.overwrite:
        fail("%s: is there already: give another name or --overwrite" % path)


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


def states(scene):
    """The transforms of everything visible or emitting, and the settings of lamps."""
    found = {}
    for o in scene.objects:
        if o.type in ("LIGHT", "MESH", "CURVE", "SURFACE", "META", "FONT") and not o.hide_render:
            numbers = [v for row in o.matrix_world for v in row]
            if o.type == "LIGHT":
                numbers += [o.data.energy, *o.data.color, getattr(o.data, "size", 0.0), getattr(o.data, "spot_size", 0.0)]
            found[o.name] = numbers
    return found


def warn_of_moves(moving):
    if moving:
        names = sorted(moving)
        more = " and %d more" % (len(names) - 5) if len(names) > 5 else ""
        warn("%s%s: moves or changes: taken as in the first frame" % (", ".join("'%s'" % n for n in names[:5]), more))


def bake_camera(scene, camera, first, last):
    """Bakes the camera into a new root camera with a key in every frame; warns of other animation."""
    data = camera.data.copy()
    baked = bpy.data.objects.new(camera.name + " baked", data)
    name = camera.name
    scene.collection.objects.link(baked)
    baked.rotation_mode = "QUATERNION"
    before, start, moving = None, None, set()
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        now = states(scene)
        start = start or now
        moving.update(n for n in now if n in start and max(abs(a - b) for a, b in zip(now[n], start[n])) > 1e-6)
        place, turn, _ = camera.matrix_world.decompose()
        if before is not None and before.dot(turn) < 0.0:
            turn.negate()  # interpolate along the shorter arc
        before = turn.copy()
        baked.location = place
        baked.rotation_quaternion = turn
        baked.keyframe_insert("location", frame=frame)
        baked.keyframe_insert("rotation_quaternion", frame=frame)
    warn_of_moves(moving)
    for curve in baked.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    if data.animation_data is not None:
        warn("the lens of '%s' is animated: the field of view of the first frame is taken" % name)
        data.animation_data_clear()
    scene.frame_set(first)
    places = [(child, child.matrix_world.copy()) for child in camera.children]
    for child, matrix in places:  # lamps attached to the original camera, which is removed
        child.parent = None
        child.matrix_world = matrix
    bpy.data.objects.remove(camera)
    baked.name = name
    scene.camera = baked


def corners_of(light):
    """The outline of a flat shape in x and y, counter-clockwise seen from -z, and its area."""
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
    """Applies the world scale to shape and area; the power is unchanged."""
    light = lamp.data
    scale = lamp.matrix_world.to_scale()
    corners, area = corners_of(light)
    area *= abs(scale.x * scale.y)
    if area == 0.0 or light.energy <= 0.0:
        return
    mesh = bpy.data.meshes.new(lamp.name)
    mesh.from_pydata(corners, [], [list(range(len(corners)))])
    # a one-sided surface of radiance L and area A emits the power pi A L
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


def plain_radiance(world):
    """The radiance of a world of constant colour; None if it needs a map."""
    if not world.use_nodes:
        return list(world.color)
    out = world.node_tree.get_output_node("CYCLES")
    links = out.inputs["Surface"].links if out is not None else []
    if not links:
        return [0.0, 0.0, 0.0]
    node = links[0].from_node
    if node.type != "BACKGROUND" or node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
        return None
    return [c * node.inputs["Strength"].default_value for c in node.inputs["Color"].default_value[:3]]


def nodes_behind(last):
    """All nodes upstream of a node, including itself and the contents of groups."""
    found, left = [], [last]
    while left:
        node = left.pop()
        if node in found:
            continue
        found.append(node)
        left += [link.from_node for i in node.inputs for link in i.links]
        if node.type == "GROUP" and node.node_tree is not None:
            left += list(node.node_tree.nodes)
    return found


def check_world(world):
    """Warns of what a map cannot represent; returns the width of the map, and whether the world uses images only."""
    nodes = nodes_behind(world.node_tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_node)
    images = [n for n in nodes if n.type in ("TEX_ENVIRONMENT", "TEX_IMAGE")]
    for node in images:
        if node.image is None or not node.image.has_data and not node.image.pixels:
            fail("world '%s': the image of its node '%s' cannot be read: pack it or correct its path" % (world.name, node.name))
    if any(n.type == "LIGHT_PATH" for n in nodes):
        warn("world '%s' looks different to the camera than to surfaces: taken as the camera sees it" % world.name)
    if world.animation_data or world.node_tree.animation_data:
        warn("world '%s' is animated: taken as in the first frame" % world.name)
    sides = [n.image.size[0] for n in images if n.type == "TEX_ENVIRONMENT"] or [SKY_MAP]
    if max(sides) > LARGEST_MAP:
        warn("world '%s': its image is %d pixels wide: reduced to %d" % (world.name, max(sides), LARGEST_MAP))
    procedural = any(n.type.startswith("TEX_") and n not in images and n.type != "TEX_COORD" for n in nodes)
    return min(max(sides), LARGEST_MAP), not procedural and bool(images)


def render_map(world, across, exact, path):
    """Renders the whole sky from the origin; the centre of Reframe's map is at Blender's +y as well."""
    scene = bpy.data.scenes.new("reframe map")
    copy = world.copy()
    copy.cycles_visibility.camera = True
    copy.cycles.sampling_method = "NONE"
    camera = bpy.data.objects.new("reframe map", bpy.data.cameras.new("reframe map"))
    camera.data.type = "PANO"
    camera.data.cycles.panorama_type = "EQUIRECTANGULAR"
    camera.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera, scene.world = camera, copy
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = across, max(across // 2, 1), 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode, render.image_settings.exr_codec = "RGB", "ZIP"
    render.use_file_extension = False
    render.filepath = path
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    # an image is sampled at pixel centres, anything else averaged over the pixel
    cycles.samples, cycles.filter_width = (1, 0.01) if exact else (SKY_SAMPLES, 1.0)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    bpy.data.worlds.remove(copy)
    if not os.path.exists(path):
        fail("%s: was not written: see Blender's messages above" % path)


def keep_world(scene, args):
    world = scene.world
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    if world is None or "environment" in own:
        return
    radiance = plain_radiance(world)
    if radiance is not None and max(radiance) <= 0.0:
        return
    own["environment"] = environment = {}
    if radiance is not None:
        environment["radiance"] = radiance
    else:
        path = os.path.abspath(args.out)[:-len(".glb")] + "-sky.exr"
        refuse(args, path)
        render_map(world, *check_world(world), path)
        environment["map"] = urllib.parse.quote(os.path.basename(path))
    if scene.render.film_transparent or not world.cycles_visibility.camera:
        environment["visible"] = False
    scene["reframe"] = own


def warn_of_the_rest(scene, camera):
    if camera.data.dof.use_dof:
        warn("'%s' has depth of field: Reframe's cameras are sharp everywhere" % camera.name)
    if scene.render.use_motion_blur or scene.eevee.use_motion_blur:
        warn("motion blur is on: Reframe renders without it")
    out = scene.world.node_tree.get_output_node("CYCLES") if scene.world is not None and scene.world.use_nodes else None
    if out is not None and out.inputs["Volume"].is_linked:
        warn("world '%s' has a volume: left out" % scene.world.name)


def export(path):
    bpy.ops.export_scene.gltf(
        filepath=path, export_format="GLB", export_cameras=True, export_lights=True, export_extras=True, export_apply=True,
        use_renderable=True,  # skips objects hidden from render: cutters, targets, parents
        export_yup=True, export_animations=True, export_frame_range=True, export_force_sampling=False,
        convert_lighting_mode="COMPAT")


def restore_booleans(path):
    """Custom properties have no booleans, which Reframe's `visible` needs."""
    with open(path, "rb") as file:
        data = file.read()
    end = 20 + struct.unpack("<I", data[12:16])[0]
    gltf = json.loads(data[20:end])
    environments = [s.get("extras", {}).get("reframe", {}).get("environment", {}) for s in gltf.get("scenes", [])]
    numbers = [e for e in environments if isinstance(e.get("visible"), int)]
    if not numbers:
        return
    for environment in numbers:
        environment["visible"] = bool(environment["visible"])
    text = json.dumps(gltf, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(data) - end, len(text), b"JSON"))
        file.write(text + data[end:])


def main():
    args = parse()
    scene = bpy.context.scene
    first, last = frame_range(scene, args.frames)
    scene.frame_start, scene.frame_end = first, last
    camera = find_camera(scene, args.camera)
    warn_of_the_rest(scene, camera)
    bake_camera(scene, camera, first, last)
    replace_area_lights(scene)
    keep_world(scene, args)
    export(os.path.abspath(args.out))
    if not os.path.exists(args.out):
        fail("%s: was not written: see Blender's messages above" % args.out)
    restore_booleans(args.out)
    print("blender-export: %s: frames %d to %d" % (args.out, first, last))


try:
    main()
except Exception as e:  # report any exception of Blender as one line and an exit status
    lines = [line.strip() for line in str(e).splitlines() if line.strip() and not line.startswith("Location:")]
    fail("%s: %s" % (type(e).__name__, lines[-1] if lines else "no details"))
