"""The world: a constant radiance or a map rendered by Cycles, in the scene's property `reframe`."""
import math
import os
import urllib.parse

import bpy

from . import bake, glb, plans, shader_tree
from .channels import is_constant, strength_of
from .folding import Folder
from .messages import blenders_error, fail, lose, refuse, warn
from .versions import has_nodes, has_sun_by_angles, panorama_of, set_format

LARGEST_MAP = 8192  # pixels across
SKY_MAP = 2048  # if no image determines the size
SKY_SAMPLES = (4, 256)  # of a pixel, and at most with a sun, whose edge decides how bright it is


def plain_radiance(world):
    """The radiance of a world of constant colour; None if it needs a map."""
    if not has_nodes(world):
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


def has_sun(world):
    return any(n.type == "TEX_SKY" and has_sun_by_angles(n) and n.sun_disc for n in nodes_behind(world.node_tree.get_output_node("CYCLES")))


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
    set_format(render.image_settings, "OPEN_EXR")
    render.image_settings.color_depth = "32"
    render.image_settings.color_mode, render.image_settings.exr_codec = "RGB", "ZIP"
    render.use_file_extension = False
    render.filepath = path
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    # an image is sampled at pixel centres, anything else averaged over the pixel
    cycles.samples, cycles.filter_width = (1, 0.01) if exact else (SKY_SAMPLES[has_sun(copy)], 1.0)
    cycles.use_adaptive_sampling, cycles.use_denoising = has_sun(copy), False
    cycles.adaptive_min_samples, cycles.adaptive_threshold = SKY_SAMPLES[0], 0.02
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    bpy.data.worlds.remove(copy)
    if not os.path.exists(path):
        fail("world '%s': its map was not rendered: %s" % (world.name, blenders_error()))


def refuse_early(scene, args):
    """A map in the way is better reported before the work than after it."""
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    if scene.world is not None and "environment" not in own and not args.embed and plain_radiance(scene.world) is None:
        refuse(args, glb.place_of_map(args))


def hidden_ways(world):
    """The rays that do not see it, but for the camera's, which Reframe knows."""
    return [way for way in ("diffuse", "glossy", "transmission") if not getattr(world.cycles_visibility, way)]


# A world that changes: its radiance, the strength of its map, or the turn of that about the vertical.


class Look:
    """A world in one state: what shines, how strongly, and by how much it is turned, radians."""

    def __init__(self, world):
        self.world, self.shows, self.factor, self.turn = world, "constant", 1.0, 0.0
        self.radiance = None if has_nodes(world) else list(world.color)
        out = world.node_tree.get_output_node("CYCLES") if has_nodes(world) else None
        if out is None or not out.inputs["Surface"].is_linked:
            self.radiance = self.radiance or [0.0] * 3
            return
        tree = world.node_tree
        plans.give_constants(tree, "diffuse")
        folder = Folder(tree, lambda node, text: None)
        shine = folder.fold(out.inputs["Surface"]).emission
        if is_constant(shine):
            self.radiance = list(shine)
            return
        ref, self.factor = strength_of(folder, shine)
        behind = shader_tree.nodes_behind(tree, list(folder.nodes[ref.node].inputs)) + [folder.nodes[ref.node]]
        self.turn, fixed = turn_of(behind)
        self.shows = repr((ref, bake.of_nodes(tree, behind)))
        for undo in fixed:
            undo()


def turn_of(nodes):
    """By how much all that depends on the direction is turned about the vertical, which is set to 0 for a comparison, and what undoes
    that. Points are turned before a texture is looked up: the other way."""
    textures = [n for n in nodes if n.type.startswith("TEX_") and n.type != "TEX_COORD"]
    if textures and all(n.type == "TEX_SKY" and has_sun_by_angles(n) and not n.inputs["Vector"].is_linked for n in textures):
        before = [(n, n.sun_rotation) for n in textures]
        for node in textures:
            node.sun_rotation -= before[0][1]
        return SUN_TURNS * before[0][1], [lambda n=n, v=v: setattr(n, "sun_rotation", v) for n, v in before]
    links = [n.inputs["Vector"].links for n in textures]
    mappings = {k[0].from_node.name: k[0].from_node for k in links if k} if all(links) else {}
    if len(mappings) != 1:
        return 0.0, []
    node = next(iter(mappings.values()))
    if node.type != "MAPPING" or node.vector_type != "POINT" or any(i.is_linked for i in node.inputs[1:]):
        return 0.0, []
    where, angle, scale = (tuple(node.inputs[n].default_value) for n in ("Location", "Rotation", "Scale"))
    if max(map(abs, where)) > 0.0 or angle[0] != 0.0 or angle[1] != 0.0 or scale[0] != scale[1]:
        return 0.0, []
    turns = node.inputs["Rotation"]
    turns.default_value = (0.0, 0.0, 0.0)
    return -angle[2], [lambda: setattr(turns, "default_value", angle)]


SUN_TURNS = -1.0  # a sun turns clockwise, seen from above


def keys_of(world, states, tracks):
    """The world to be rendered, or its radiance, and the keys of the environment."""
    looks = [Look(copy) for copy in states.copies]
    times = [float("%.9g" % t) for t in tracks.seconds]
    lit = [k for k in looks if not (k.shows == "constant" and max(k.radiance) <= 0.0)]
    if all(k.shows == "constant" for k in looks):
        values = states.of_each([[float("%.9g" % max(r, 0.0)) for r in k.radiance] for k in looks])
        return None, max((k.radiance for k in looks), key=max), [{"time": t, "radiance": v} for t, v in zip(times, values)]
    if len({k.shows for k in lit}) > 1:
        lose("world '%s' changes otherwise than in strength, in its one colour, or by a turn about the vertical: taken as in the first "
             "frame" % world.name)
        return states.copies[states.of_frames[0]], None, []
    base = max(lit, key=lambda k: k.factor)
    keys = [{"time": t, "strength": float("%.9g" % ((k.factor if k in lit else 0.0) / base.factor)),
             "rotation": float("%.9g" % math.degrees((k.turn if k in lit else base.turn) - base.turn))}
            for t, k in zip(times, states.of_each(looks))]
    return base.world, None, keys


def keep_world(scene, args, recorded, tracks):
    world = scene.world
    own = scene["reframe"].to_dict() if "reframe" in scene else {}
    if world is None or "environment" in own:
        return
    states, keys = recorded.worlds.get(world.name_full), []
    still = states.copies[0] if states is not None else world
    if states is not None and len(states.copies) > 1:
        still, radiance, keys = keys_of(world, states, tracks)
    else:
        radiance = plain_radiance(still)
    if radiance is not None and min(radiance) < 0.0:
        lose("world '%s' takes light away in Blender: left out%s" % (world.name, " in some colours" if max(radiance) > 0.0 else ""))
        radiance = [max(r, 0.0) for r in radiance]
    if radiance is not None and max(radiance) == 0.0:
        return
    if hidden_ways(world):
        lose("world '%s' is hidden from some kinds of rays in Blender: lights all surfaces here" % world.name)
    own["environment"] = environment = {}
    if radiance is not None:
        environment["radiance"] = radiance
    else:
        render_map(still, *check_world(still), glb.map_path(args))
        environment["map"] = urllib.parse.quote(os.path.basename(glb.place_of_map(args)))
    if scene.render.film_transparent or not world.cycles_visibility.camera:
        environment["visible"] = False
    glb.keys_of_sky += keys
    scene["reframe"] = own
