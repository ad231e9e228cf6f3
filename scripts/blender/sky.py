"""The world: a constant radiance or a map rendered by Cycles, in the scene's property `reframe`."""
import math
import os
import urllib.parse

import bpy

from . import glb, plans, shader_tree
from .messages import fail, refuse, warn
from .moves import animated_paths, tell_animation
from .versions import panorama_of

LARGEST_MAP = 8192  # pixels across
SKY_MAP = 2048  # if no image determines the size
SKY_SAMPLES = 4


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
        warn("world '%s' looks different to the camera than to surfaces: taken as it lights the scene" % world.name)
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
    if any(n.type == "LIGHT_PATH" for n in nodes_behind(copy.node_tree.get_output_node("CYCLES"))):
        shader_tree.flatten(copy.node_tree)
        plans.give_constants(copy.node_tree, "diffuse")
    copy.cycles.sampling_method = "NONE"
    camera = bpy.data.objects.new("reframe map", bpy.data.cameras.new("reframe map"))
    camera.data.type = "PANO"
    panorama_of(camera.data).panorama_type = "EQUIRECTANGULAR"
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


def map_path(args):
    return os.path.abspath(args.out)[:-len(".glb")] + "-sky.exr"


def refuse_early(scene, args):
    """A map in the way is better reported before the work than after it."""
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    if scene.world is not None and "environment" not in own and not args.embed and plain_radiance(scene.world) is None:
        refuse(args, map_path(args))


def hidden_ways(world):
    """The rays that do not see it, but for the camera's, which Reframe knows."""
    return [way for way in ("diffuse", "glossy", "transmission") if not getattr(world.cycles_visibility, way)]


def tell_changes(world):
    def tell(node, text):
        warn("world '%s'%s: %s" % (world.name, ", node '%s'" % node.name if node is not None else "", text))
    if world.use_nodes:
        tell_animation(world.node_tree, tell)
    elif animated_paths(world):
        tell(None, "animated or driven: taken as in the first frame")


def keep_world(scene, args):
    world = scene.world
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    if world is None or "environment" in own:
        return
    tell_changes(world)
    radiance = plain_radiance(world)
    if radiance is not None and min(radiance) < 0.0:
        warn("world '%s' takes light away in Blender: left out%s" % (world.name, " in some colours" if max(radiance) > 0.0 else ""))
        radiance = [max(r, 0.0) for r in radiance]
    if radiance is not None and max(radiance) == 0.0:
        return
    if hidden_ways(world):
        warn("world '%s' is hidden from some kinds of rays in Blender: lights all surfaces here" % world.name)
    own["environment"] = environment = {}
    if radiance is not None:
        environment["radiance"] = radiance
    else:
        if args.embed:
            path = glb.map_path()
        else:
            path = map_path(args)
            refuse(args, path)
        render_map(world, *check_world(world), path)
        environment["map"] = urllib.parse.quote(os.path.basename(path))
    if scene.render.film_transparent or not world.cycles_visibility.camera:
        environment["visible"] = False
    scene["reframe"] = own
