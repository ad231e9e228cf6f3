"""Lamps as glTF has them: their nodes folded, spots as bright as in Cycles, area lights as one-sided emissive quads and discs,
round lamps as spheres, where the camera would not see these; other lamps have sizes (extents.py).
"""
import math

import bmesh
import bpy
import mathutils
import numpy
from bpy_extras.object_utils import world_to_camera_view

from . import extents, materials, passes, profiles, shader_tree
from .channels import WHITE, is_constant
from .folding import Folder
from .geometry import hidden_ways, shown_by
from .messages import list_names, lose, warn
from .versions import IS_4, has_nodes

NEAR = 7.0  # radii from a lamp of soft falloff, within which it gives 2 % less light than a sphere


def power_of(light, matrix):
    """The energy of a lamp and its colour, with what newer versions of Blender multiply them by: exposure, temperature, and the area by
    which Cycles divides where the lamp's watts are not to depend on its size."""
    energy, colour = light.energy * 2.0 ** getattr(light, "exposure", 0.0), tuple(light.color)
    if getattr(light, "use_temperature", False):
        colour = tuple(a * b for a, b in zip(colour, light.temperature_color))
    return energy * (1.0 if getattr(light, "normalize", True) else light.area(matrix_world=matrix)), colour


def settle_power(lamp):
    """Puts all of it into energy and colour: Blender's exporter knows some of the rest."""
    light = lamp.data
    energy, colour = power_of(light, lamp.matrix_world)
    largest = max(max(colour), 1.0)
    light.energy, light.color = energy * largest, [c / largest for c in colour]
    for name, value in (("exposure", 0.0), ("use_temperature", False), ("normalize", True)):
        if hasattr(light, name):
            setattr(light, name, value)


def replace_area_light(scene, lamp):
    """Applies the world scale to shape and area; the power is unchanged."""
    light = lamp.data
    scale = lamp.matrix_world.to_scale()
    corners, area = corners_of(light)
    area *= abs(scale.x * scale.y)
    if area == 0.0 or light.energy <= 0.0:
        return None
    mesh = bpy.data.meshes.new(lamp.name)
    mesh.from_pydata(corners, [], [list(range(len(corners)))])
    # pi A gives all of the lamp's watts; in Cycles of Blender 3 the radiance is its watts over 4 A
    spread = (math.pi if IS_4 else 4.0) * area
    largest = max(light.color) or 1.0
    color = [c / largest for c in light.color]
    mesh.materials.append(materials.glow(lamp.name, color, light.energy * largest / spread))
    quad = bpy.data.objects.new(lamp.name + " area", mesh)
    quad.matrix_world = lamp.matrix_world.copy()
    quad[passes.TAG] = lamp[passes.TAG]
    scene.collection.objects.link(quad)
    return quad.name


def replace_point_light(scene, lamp):
    """A sphere that radiates I = watts / (4 pi) to all sides, as Cycles' lamps do; its faces are a little smaller than it."""
    light = lamp.data
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=2, radius=light.shadow_soft_size)
    area = sum(f.calc_area() for f in work.faces)
    mesh = bpy.data.meshes.new(lamp.name)
    work.to_mesh(mesh)
    work.free()
    largest = max(light.color) or 1.0
    # a convex body of radiance L radiates pi L times its surface
    radiance = light.energy * largest / (math.pi * area)
    mesh.materials.append(materials.glow(lamp.name, [c / largest for c in light.color], radiance))
    ball = bpy.data.objects.new(lamp.name + " sphere", mesh)
    ball.location = lamp.matrix_world.translation
    ball[passes.TAG] = lamp[passes.TAG]
    scene.collection.objects.link(ball)
    return ball.name


def teller(lamp):
    """Warns of a lamp's nodes."""
    def tell(node, text):
        warn("'%s': lamp%s: %s" % (lamp.name, ", node '%s'" % node.name if node is not None else "", text))
    return tell


def shine_of_nodes(lamp):
    """What a lamp's nodes multiply its colour by; nothing without nodes."""
    if not has_nodes(lamp.data):
        return WHITE
    tell = teller(lamp)
    tree = lamp.data.node_tree
    shader_tree.flatten(tree)
    out = tree.get_output_node("CYCLES")
    if out is None or not out.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0)
    shine = Folder(tree, tell).fold(out.inputs["Surface"]).emission
    if is_constant(shine):
        return shine
    lose("'%s': lamp, node '%s': varies or is not known here: the lamp is taken without its nodes" % (lamp.name, tree.nodes[shine.node].name))
    return WHITE


def fold_at(tree, number, intensity):
    """The emission of a lamp's tree where an IES file gives this number; a Ref if it varies otherwise."""
    number.outputs[0].default_value = intensity
    return Folder(tree, lambda node, text: None).fold(tree.get_output_node("CYCLES").inputs["Surface"]).emission


def take_file(lamp):
    """The IES file of a lamp and how it is turned, or None. In the lamp's tree, the number 1 takes its place."""
    if not has_nodes(lamp.data):
        return None
    tree = lamp.data.node_tree
    shader_tree.flatten(tree)
    out = tree.get_output_node("CYCLES")
    if out is None or not out.inputs["Surface"].is_linked:
        return None
    nodes = [node for node in tree.nodes if node.type == "TEX_IES" and node.outputs[0].is_linked]
    if not nodes:
        return None
    node, ies, wrong = nodes[0], None, None
    try:
        ies = profiles.Ies(profiles.text_of(node))
        turn = profiles.turning(node.inputs["Vector"])
        if len(nodes) > 1:
            wrong = "there are %d of them" % len(nodes)
        if lamp.data.type not in ("POINT", "SPOT"):
            wrong = "a lamp of the type %s has no profile here" % lamp.data.type.lower()
    except profiles.Refused as e:
        wrong = str(e)
    number, times = tree.nodes.new("ShaderNodeValue"), tree.nodes.new("ShaderNodeMath")
    times.operation = "MULTIPLY"
    strength = node.inputs["Strength"]
    if strength.is_linked:
        tree.links.new(strength.links[0].from_socket, times.inputs[0])
    else:
        times.inputs[0].default_value = strength.default_value
    tree.links.new(number.outputs[0], times.inputs[1])
    for one in nodes:
        for link in list(one.outputs[0].links):
            tree.links.new(times.outputs[0], link.to_socket)
    none, one, two = (fold_at(tree, number, x) for x in (0.0, 1.0, 2.0))
    is_known = all(is_constant(a) for a in (none, one, two))
    if is_known and (max(map(abs, none)) > 0.0 or any(abs(b - 2.0 * a) > 1e-5 * abs(b) for a, b in zip(one, two))):
        wrong = wrong or "the light is not in proportion to it"
    if wrong is None:
        number.outputs[0].default_value = 1.0
        return ies, turn
    number.outputs[0].default_value = profiles.WATTS * profiles.mean_over_sphere(ies) if ies is not None else 1.0
    lose("'%s': lamp, node '%s': its IES file is taken as the same to all sides: %s" % (lamp.name, node.name, wrong))
    return None


def fold_nodes(lamp):
    """Blender's exporter would take one part of a lamp's nodes and leave the other. False for a lamp that only takes light away."""
    light = lamp.data
    watts = [light.energy * a * b for a, b in zip(light.color, shine_of_nodes(lamp))]
    if min(watts) < 0.0:
        lose("'%s': lamp: takes light away in Blender: left out%s" % (lamp.name, " in some colours" if max(watts) > 0.0 else ""))
    largest = max(*watts, 0.0)
    if largest > 0.0:
        light.color = [max(w, 0.0) / largest for w in watts]
    light.energy = largest
    light.use_nodes = False
    if light.node_tree is not None:  # which newer exporters of Blender read even so
        light.node_tree.nodes.clear()
    return largest > 0.0 or min(watts) == 0.0


def power_of_spot(light):
    """Of a spot of Blender 3, over that of its cone in glTF."""
    least = math.cos(0.5 * light.spot_size)
    edge = (1.0 - least) * light.spot_blend
    full = least + edge
    return (0.5 * (1.0 - full * full) + edge * (0.5 * least + 0.35 * edge)) / (1.0 - full + 0.5 * edge)


def fit_spot(light):
    """Cycles' spots fall off with the cosine, and smoothly at the edge; glTF's do not. Of the same power they become."""
    outer = 0.5 * light.spot_size
    least = math.cos(outer)
    full = least + (1.0 - least) * light.spot_blend  # the cosine from which on all light arrives
    light.energy *= power_of_spot(light)
    light.spot_blend = 1.0 - math.acos(0.75 * full + 0.25 * least) / outer  # glTF: the square of a ramp, a third of its width


def cone_of(light, widened):
    """The cosine of the edge of a spot's cone that is `widened` by its scale, and the integral of its light over the cosines."""
    half = 0.5 * light.spot_size
    least = math.cos(half)
    edge = max((1.0 - least) * light.spot_blend, 1e-9)
    outer = math.atan(widened * math.tan(half)) if half < 0.4999 * math.pi else 0.5 * math.pi
    end, steps, lit = math.cos(outer), 4000, 0.0
    for i in range(steps):
        cosine = end + (1.0 - end) * (i + 0.5) / steps
        own = cosine / math.hypot(cosine, math.sqrt(1.0 - cosine * cosine) / widened)
        t = min(max((own - least) / edge, 0.0), 1.0)
        lit += t * t * (3.0 - 2.0 * t) * (1.0 - end) / steps
    return end, lit


def fit_scaled_spot(lamp):
    """Spots of Blender 4 fall off at the edge alone, smoothly; glTF's by the square of a ramp, whose integral is a third of its width.
    The power is kept."""
    light, scale = lamp.data, [max(abs(s), 1e-6) for s in lamp.matrix_world.to_scale()]
    end, lit = cone_of(light, math.sqrt(scale[0] * scale[1]) / scale[2])
    outer = math.acos(end)
    inner = min(end + 1.5 * (1.0 - end - lit), 1.0)
    light.spot_size = 2.0 * outer
    light.spot_blend = min(max(1.0 - math.acos(inner) / outer, 0.0), 1.0)


def tell_lost(scene, lamps, spheres, planes):
    """Says what lamps lose by their kind."""
    soft = [o.name for o in lamps if o.data.type == "SPOT" and o.data.energy > 0.0 and o.data.name not in profiles.tables]
    if soft:
        warn("the edges of spots whose cones change have the light of Blender's on the whole, but fall off otherwise: " + list_names(soft))
    unseen = [o.name for o in lamps if o.name not in spheres and (o.name in planes or o.data.type != "AREA" and extents.has_size(o.data))]
    kinds = materials.specular_kinds(scene.objects) if unseen else ()
    if kinds:
        warn("lamps that light as in Blender, but are not seen in %s%s: %s" % (
            " and ".join(n for n in ("mirrors", "glass") if n in kinds),
            ", and light nothing through solid glass" if "solid glass" in kinds else "", list_names(unseen)))


def distance_to(o, matrix, place):
    """The distance of a place from the surface of a mesh."""
    found, nearest, _, _ = o.closest_point_on_mesh(matrix.inverted_safe() @ place)
    return (matrix @ nearest - place).length if found else math.inf


def balls_around(meshes):
    """The middles and radii of balls around meshes."""
    boxes = numpy.array([[matrix @ mathutils.Vector(c) for c in o.bound_box] for o, matrix in meshes]).reshape(-1, 8, 3)
    middles = boxes.mean(axis=1)
    return middles, numpy.sqrt(((boxes - middles[:, None]) ** 2).sum(axis=2)).max(axis=1) if meshes else numpy.zeros(0)


def tell_near(scene, lamps, spheres, placed):
    """What a sphere in the place of a lamp does to surfaces near to it. A lamp of soft falloff is a disc that turns to each surface: of
    a radius r, at a distance d, it has 1 / (1 + (r/d)^2) of a sphere's light. Light passes lamps in Blender."""
    if not IS_4:
        return
    meshes = [(o, matrix) for o in scene.objects if o.type == "MESH" and o.data.polygons for matrix in placed.get(o.name, [o.matrix_world])]
    middles, radii = balls_around(meshes)
    for lamp in lamps:
        if lamp.name not in spheres:
            continue
        radius, place = lamp.data.shadow_soft_size, lamp.matrix_world.translation
        near = numpy.flatnonzero(numpy.sqrt(((middles - place) ** 2).sum(axis=1)) - radii < NEAR * radius)
        least = min((distance_to(*meshes[i], place) for i in near), default=math.inf)
        share = min((radius / max(least, 1e-6)) ** 2, 10.0)
        if share > NEAR**-2 and extents.is_soft(lamp.data):
            warn("'%s': soft falloff: left out, which gives what is near up to %.0f %% more light" % (lamp.name, 100.0 * share))
        if share > NEAR**-2:
            warn("'%s': a sphere here, which takes up to %.0f %% of the light that what is near returns" % (lamp.name, min(100.0 * share, 100.0)))


def give_profile(lamp, file, keyed):
    """The tables of a lamp's IES file and of its cone. A cone that changes has none, nor one that glTF has as it is."""
    light = lamp.data
    fitted = power_of_spot(light) if light.type == "SPOT" and not IS_4 else 1.0
    if file is not None:
        light.energy *= profiles.of_file(lamp, *file, fitted)
        if keyed:
            lose("'%s': its cone changes, which it does not where there is an IES file: taken as in the first frame" % lamp.name)
    elif light.type == "SPOT" and not keyed and light.energy > 0.0:
        profiles.of_cone(lamp, fitted)


def prepare(scene, in_view, placed):
    """Gives every lamp data of its own, of its name, with what its nodes and its cone make of it; portals are none. Returns
    the names of those that become spheres, and planes."""
    lamps, kept, spheres, planes = [], [], set(), set()
    for lamp in [o for o in scene.objects if o.type == "LIGHT"]:
        if lamp.data.type == "AREA" and lamp.data.cycles.is_portal:
            bpy.data.objects.remove(lamp)
        elif not lamp.hide_render:
            lamps.append(lamp)
    places = {lamp: place_of(lamp) for lamp in lamps}  # by the names of data
    for data in list(bpy.data.lights):  # which sorts itself by name
        if data.library is None:
            data.name = "was " + data.name
    for lamp in lamps:
        seen = places[lamp] in in_view
        lamp.data = lamp.data.copy()
        lamp.data.name = lamp.name
        keyed = profiles.has_keyed_cone(lamp.data)
        lamp.data.animation_data_clear()
        settle_power(lamp)
        file = take_file(lamp)
        is_plain = not has_nodes(lamp.data) and lamp.data.energy >= 0.0
        if not is_plain and not fold_nodes(lamp):
            bpy.data.objects.remove(lamp)
            continue
        if scene.render.engine == "CYCLES":
            lamp.data.use_custom_distance = False  # which is Eevee's, and would be glTF's range
        give_profile(lamp, file, keyed)
        if lamp.data.type == "SPOT":
            fit_scaled_spot(lamp) if IS_4 else fit_spot(lamp.data)
        kept.append(lamp)
        if lamp.data.type == "POINT" and extents.has_size(lamp.data) and file is None and not seen and lamp.data.energy > 0.0:
            spheres.add(lamp.name)
        elif lamp.data.type == "AREA" and extents.is_plane(lamp, seen):
            planes.add(lamp.name)
        else:
            extents.give_size(lamp)
    tell_lost(scene, kept, spheres, planes)
    tell_near(scene, kept, spheres, placed)
    return spheres, planes


def carry(scene, in_view, placed, tracks):
    """`in_view`: the places of point and area lamps that would be seen as meshes; `placed`: where instances are."""
    spheres, planes = prepare(scene, in_view, placed)
    for name in sorted(spheres):
        tracks.follow(replace_point_light(scene, scene.objects[name]), name, ("translation",))
        bpy.data.objects.remove(scene.objects[name])
    lamps = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "AREA"]
    for lamp in lamps:
        if lamp.name in planes:
            extents.make_plane(lamp)
            continue
        if not lamp.hide_render:
            tracks.follow(replace_area_light(scene, lamp), lamp.name)
        bpy.data.objects.remove(lamp)


# Which point and area lamps come into the picture, where Cycles' camera does not see them.

DISC_CORNERS = 64


def corners_of(light):
    """The outline of a flat shape in x and y, counter-clockwise seen from -z, and its area."""
    x = 0.5 * light.size
    y = 0.5 * (light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    if light.shape in ("SQUARE", "RECTANGLE"):
        return [(-x, -y, 0), (-x, y, 0), (x, y, 0), (x, -y, 0)], 4 * x * y
    turns = [-2 * math.pi * i / DISC_CORNERS for i in range(DISC_CORNERS)]
    area = 0.5 * DISC_CORNERS * math.sin(2 * math.pi / DISC_CORNERS) * x * y
    return [(x * math.cos(a), y * math.sin(a), 0) for a in turns], area


def place_of(lamp, matrix=None):
    """What tells lamps apart, also where instances show one several times: its data, and where it stands."""
    return lamp.data.name_full, tuple(matrix.translation if matrix is not None else lamp.location)


def extent_of(lamp, scale):
    """The radius of a sphere around what shines."""
    if lamp.data.type != "AREA":
        return lamp.data.shadow_soft_size
    corners, _ = corners_of(lamp.data)
    return max(math.hypot(x * scale.x, y * scale.y) for x, y, _ in corners)


def unseen_lamps(depsgraph):
    """The lamps, and the matrices of them, that stand in the scene and that the camera does not see."""
    found = []
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT" and instance.object.data.type in ("POINT", "AREA"):
            if (instance.is_instance or instance.show_self) and "camera" in hidden_ways(instance):
                found.append((shown_by(instance), instance.matrix_world.copy(), instance.is_instance))
    return found


class InView:
    """Notes them frame by frame: `depsgraph` is that of the first frame, as lamps are exported."""

    def __init__(self, scene, depsgraph):
        self.scene, self.lamps = scene, unseen_lamps(depsgraph)
        self.places = set()

    def note(self, camera, depsgraph):
        for lamp, matrix, is_instance in self.lamps:
            now = matrix if is_instance else lamp.evaluated_get(depsgraph).matrix_world
            x, y, depth = world_to_camera_view(self.scene, camera, now.translation)
            size = extent_of(lamp, now.to_scale())
            edge = 0.05 + size / max(depth, 1e-3)
            if camera.data.type == "PANO" or depth > -size and -edge < x < 1.0 + edge and -edge < y < 1.0 + edge:
                self.places.add(place_of(lamp, matrix))
