"""Scenes in which a little is set that Reframe does not have, for test_blender_losses.c."""
import math

import bpy

import blender_words
from blender_words import begin, eye, geometry_group, give_nodes, instances_of, lamp_nodes, lights_without_shadow, moved_to, socket


def lamp(kind, name, place=(0, 0, 3), turn=(0, 0, 0)):
    """Of 20 W and 25 cm, turned by degrees."""
    return blender_words.lamp(kind, name, place, [math.radians(a) for a in turn], energy=20.0, shadow_soft_size=0.25)


def cube(name, place=None):
    """Where no place is given, above the others: faces in one place are told."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=place or (0, 0, 2 * len(bpy.data.meshes)))
    bpy.context.object.name = name
    return bpy.context.object


def plain():
    """A scene of which nothing is lost."""
    scene = begin(3, size=(32, 24))
    cube("cube")
    lamp("AREA", "key")
    eye()
    return scene


def specular(kind):
    """A smooth cube in view of nothing."""
    s = blender_words.Shader(kind)
    cube(kind, (0, 9, 2 * len(bpy.data.meshes))).data.materials.append(s.done(s.add(kind, Roughness=0.0)))


def lamps():
    """Lamps that some rays do not see, or that throw no shadow; mirrors and glass, which show what has no mesh."""
    scene = plain()
    specular("BsdfGlossy")
    specular("BsdfGlass")
    lights_without_shadow(lamp("POINT", "through walls").data)
    lamp("SUN", "for gloss").visible_diffuse = False
    lamp("SPOT", "lens").visible_camera = True
    lamp("AREA", "window", (0, 2, 0), (90, 0, 0))
    shown = lamp("AREA", "shown", (0, 2, 0), (90, 0, 0))
    shown.visible_camera = True
    portal = lamp("AREA", "portal", (0, 2, 0), (90, 0, 0))
    portal.data.cycles.is_portal = True
    lights_without_shadow(portal.data)
    scene.world = bpy.data.worlds.new("sky")
    scene.world.cycles_visibility.glossy = False
    unlit = lamp("POINT", "unlit")
    unlit.visible_diffuse = unlit.visible_glossy = unlit.visible_transmission = False


def linked():
    """Lamps that light some objects only, or throw shadows of some only; a scaled spot, and soft lamps near a surface and far from all."""
    scene = plain()
    specular("BsdfGlossy")
    scene.objects["cube"].light_linking.receiver_collection = bpy.data.collections.new("receivers")
    lamp("POINT", "for some").light_linking.receiver_collection = bpy.data.collections.new("some")
    lamp("SUN", "past some", turn=(0, 0, 1)).light_linking.blocker_collection = bpy.data.collections.new("blockers")
    bpy.data.lights["past some"].angle = 0.0
    bpy.data.lights["for some"].use_soft_falloff = False
    lamp("SPOT", "wide", (0, 0, -9)).scale = (2, 1, 1)
    lamp("POINT", "close", (0, 0, 1.5))
    lamp("POINT", "far", (0, 0, 9))
    for name in ("wide", "close", "far", "for some"):
        scene.objects[name].location.y = -7.0  # behind the camera
    scene.objects["close"].location.y = 0.0


def instances():
    """What is in a collection that only instances show is reported as well; what is hidden is not."""
    scene = plain()
    group = moved_to(bpy.data.collections.new("group"), *(cube(name, (0, 0, 0)) for name in ("ghost", "hole", "fur", "dust")))
    bpy.data.objects["ghost"].visible_glossy = False
    bpy.data.objects["ghost"].data.polygons.foreach_set("use_smooth", [True] * 6)
    bpy.data.objects["hole"].is_holdout = True  # which does not count: instances are held out by what makes them
    with bpy.context.temp_override(object=bpy.data.objects["fur"]):
        bpy.data.objects["fur"].modifiers.new("hair", "PARTICLE_SYSTEM")
    bpy.data.objects["fur"].particle_systems[0].settings.type = "HAIR"
    geometry_group(bpy.data.objects["dust"], "GeometryNodeMeshToPoints")
    torch = lamp("POINT", "torch")
    lights_without_shadow(torch.data)
    moved_to(group, torch)
    instances_of(group)
    instances_of(group, "pit").is_holdout = True
    off = bpy.data.collections.new("off")
    scene.collection.children.link(off)
    off.hide_render = True
    unseen = cube("unseen")
    moved_to(off, unseen)
    unseen.is_shadow_catcher = True
    far = bpy.data.collections.new("far")
    scene.collection.children.link(far)
    bpy.context.view_layer.layer_collection.children["far"].indirect_only = True


def key(o, path, *values):
    """A value of a property in each of the frames from the first on."""
    blender_words.key(o, path, enumerate(values, 1))


def switched():
    """Objects that are hidden in some frames; saved in another frame than the first."""
    scene = plain()
    key(cube("goes", (2, 0, 0)), "hide_render", False, False, True)
    key(cube("comes", (-2, 0, 0)), "hide_render", True, False, False)
    # what the viewport hides counts for nothing
    key(cube("stays", (0, 2, 0)), "hide_viewport", False, True, True)
    unseen = cube("is away", (0, -2, 0))
    key(unseen, "hide_render", True, True)
    key(unseen, "hide_viewport", False, True)
    key(lamp("POINT", "blinks"), "hide_render", False, True, False)
    builds = cube("builds").modifiers.new("array", "ARRAY")
    key(builds, "show_render", True, False)
    place = instances_of(moved_to(bpy.data.collections.new("group"), cube("piece")))
    key(place, "hide_render", False, True, True)
    scene.frame_set(3)


def changes():
    """Each of a lamp's settings that changes, nodes of a lamp, a world of one colour."""
    scene = plain()
    specular("BsdfGlossy")
    beam = lamp("AREA", "wide")
    beam.data.shape = "RECTANGLE"
    key(beam.data, "size_y", 1.0, 1.0, 2.0)
    key(lamp("AREA", "spread").data, "spread", math.pi, 2.0, math.pi)
    key(lamp("SPOT", "edge").data, "spot_blend", 0.1, 0.1, 0.2)
    key(lamp("POINT", "ball").data, "shadow_soft_size", 0.1, 0.2)
    scene.world = bpy.data.worlds.new("sky")
    give_nodes(scene.world)
    key(scene.world.node_tree.nodes["Background"].inputs["Strength"], "default_value", 0.0, 1.0)
    key(lamp_nodes(lamp("POINT", "bulb"))[1].inputs["Strength"], "default_value", 1.0, 2.0)
    cone = lamp("SPOT", "cone")
    key(cone.data, "spot_size", 0.5, 0.6)
    key(cone.data, "shadow_soft_size", 0.0)


def more_changes():
    """The rest of them, and a sun, a material without nodes, and one that a driver changes."""
    scene = plain()
    specular("BsdfGlossy")
    key(lamp("POINT", "bright").data, "energy", 1.0, 2.0)
    key(lamp("POINT", "red").data, "color", (1, 1, 1), (1, 0, 0))
    key(lamp("AREA", "size").data, "size", 1.0, 2.0)
    key(lamp("SUN", "sun").data, "angle", 0.1, 0.2)
    paint = bpy.data.materials.new("paint")
    paint.use_nodes = False
    key(paint, "diffuse_color", (1, 0, 0, 1), (0, 1, 0, 1))
    bpy.data.objects["cube"].data.materials.append(paint)


def pictures():
    """A part of the picture, lines over it, and several layers."""
    scene = plain()
    scene.render.use_border, scene.render.use_freestyle = True, True
    scene.view_layers.new("back")
    scene.view_layers.new("unused").use = False
    bpy.context.view_layer.use_solid = bpy.context.view_layer.use_sky = False


def darkness():
    """What takes light away: lamps of each kind, a lamp's nodes, a surface, a world; and a surface that is too bright."""
    scene = plain()
    for kind in ("AREA", "POINT", "SUN", "SPOT"):
        lamp(kind, "dark " + kind.lower()).data.energy = -20.0
    lamp_nodes(lamp("POINT", "nodes"))[1].inputs["Strength"].default_value = -1.0
    twice = lamp("AREA", "twice")  # which gives light again
    twice.data.energy = -20.0
    lamp_nodes(twice)[1].inputs["Strength"].default_value = -1.0
    for name, which, value in (("hole", "Emission Strength", -1.0), ("bright", "Base Color", (1.5, 1.0, 1.0, 1.0))):
        material = bpy.data.materials.new(name)
        give_nodes(material)
        node = material.node_tree.nodes["Principled BSDF"]
        socket(node, "Emission").default_value = (1.0, 1.0, 1.0, 1.0)
        node.inputs["Emission Strength"].default_value = 0.0
        node.inputs[which].default_value = value
        cube(name).data.materials.append(material)
    scene.world = bpy.data.worlds.new("sky")
    give_nodes(scene.world)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = -1.0


def placed_lamps():
    """Lamps that instances bring: a point lamp and an area lamp in view, the same ones behind the camera."""
    plain()
    specular("BsdfGlossy")
    group = bpy.data.collections.new("group")
    for kind, name in (("POINT", "torch"), ("AREA", "panel")):
        o = lamp(kind, name, (0, 0, 0.5))
        o.data.shadow_soft_size = 0.2
        moved_to(group, o)
    for y in (2, -20):
        instances_of(group, place=(0, y, 0))


def cycles_settings():
    """What Cycles leaves out by its settings, for a lamp, a material, an object, or the whole scene; a sun that nothing mirrors."""
    scene = plain()
    lamp("SUN", "sun")
    cycles, view = scene.cycles, scene.view_settings
    cycles.max_bounces, cycles.glossy_bounces = 8, 2
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect, cycles.use_fast_gi = 3.0, True
    scene.render.film_transparent, cycles.film_transparent_glass = True, True
    view.exposure, view.gamma, view.use_curve_mapping = 1.0, 2.0, True
    view.look = "AgX - High Contrast" if view.view_transform == "AgX" else "High Contrast"
    lamp("AREA", "once").data.cycles.max_bounces = 0
    veil = bpy.data.materials.new("veil")
    give_nodes(veil)
    veil.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
    (veil if hasattr(veil, "use_transparent_shadow") else veil.cycles).use_transparent_shadow = False
    bpy.data.objects["cube"].data.materials.append(veil)
    rock = cube("rock", (2, 0, 0))
    smooth = rock.modifiers.new("round", "SUBSURF")
    if hasattr(cycles, "feature_set"):
        cycles.feature_set = "EXPERIMENTAL"
    (smooth if hasattr(smooth, "use_adaptive_subdivision") else rock.cycles).use_adaptive_subdivision = True


def limits():
    """A room in which paths end early, in all and by kind."""
    scene = plain()
    bpy.ops.mesh.primitive_cube_add(size=20)
    cycles = scene.cycles
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transparent_max_bounces = 2, 1, 0, 4
    cycles.transmission_bounces, cycles.sample_clamp_direct = 2, 0.001


def sides():
    """Sides that shine differently, a world with a volume, and an object that is culled."""
    scene = plain()
    scene.world = bpy.data.worlds.new("fog")
    give_nodes(scene.world)
    tree = scene.world.node_tree
    out = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], out.inputs["Volume"])
    for name, strengths in (("back", (0.0, 5.0)), ("both", (5.0, 1.0))):
        s = blender_words.Shader(name)
        a, b = (s.add("Emission", Strength=strength) if strength > 0.0 else s.add("BsdfDiffuse") for strength in strengths)
        cube(name).data.materials.append(s.done(s.mix(s.add("NewGeometry").outputs["Backfacing"], a, b)))
    cube("twin", scene.objects["both"].location)
    scene.render.use_simplify = scene.cycles.use_distance_cull = True
    scene.objects["cube"].cycles.use_distance_cull = True


def over_time(o, kind, value, **settings):
    """Sets what a mesh carries by the number of the frame."""
    change, = geometry_group(o, kind)
    for name, setting in settings.items():
        setattr(change, name, setting)
    if "Name" in change.inputs:
        change.inputs["Name"].default_value = "paint"
    time = change.id_data.nodes.new("GeometryNodeInputSceneTime")
    change.id_data.links.new(time.outputs["Frame"], next(i for i in change.inputs if i.name == value and i.enabled))


def carried():
    """Shapes that stay, with texture coordinates, colours and materials that change."""
    plain()
    key(cube("coordinates").modifiers.new("warp", "UV_WARP"), "offset", (0, 0), (0.5, 0))
    over_time(cube("colours"), "GeometryNodeStoreNamedAttribute", "Value", data_type="FLOAT_COLOR")
    over_time(cube("materials"), "GeometryNodeSetMaterialIndex", "Material Index")
    steady = cube("steady").modifiers.new("steady", "UV_WARP")
    key(steady, "offset", (0, 0), (0, 0))


def gone():
    """A film whose files are not there."""
    plain()
    image = bpy.data.images.new("film", 4, 4)
    image.source, image.filepath = "SEQUENCE", "/nowhere/film.0001.png"
    screen = bpy.data.materials.new("screen")
    give_nodes(screen)
    tree = screen.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.image_user.frame_duration = image, 3
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    bpy.data.objects["cube"].data.materials.append(screen)
