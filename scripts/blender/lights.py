"""Lamps as glTF has them: their nodes folded, spots as bright as in Cycles, area lights as one-sided emissive quads and discs,
round lamps out of view as spheres.
"""
import math

import bmesh
import bpy
import mathutils
import numpy
from bpy_extras.object_utils import world_to_camera_view

from . import materials, shader_tree
from .channels import WHITE, is_constant
from .folding import Folder
from .geometry import hidden_ways, shown_by
from .messages import list_names, warn
from .moves import tell_animation
from .versions import IS_4

NEAR = 7.0  # radii from a lamp of soft falloff, within which it gives 2 % less light than a sphere


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
    # pi A gives all of the lamp's watts; in Cycles of Blender 3 the radiance is its watts over 4 A
    spread = (math.pi if IS_4 else 4.0) * area
    largest = max(light.color) or 1.0
    color = [c / largest for c in light.color]
    mesh.materials.append(materials.glow(lamp.name, color, light.energy * largest / spread))
    quad = bpy.data.objects.new(lamp.name + " area", mesh)
    quad.matrix_world = lamp.matrix_world.copy()
    scene.collection.objects.link(quad)


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
    scene.collection.objects.link(ball)


def teller(lamp):
    """Warns of a lamp's nodes."""
    def tell(node, text):
        warn("'%s': lamp%s: %s" % (lamp.name, ", node '%s'" % node.name if node is not None else "", text))
    return tell


def shine_of_nodes(lamp):
    """What a lamp's nodes multiply its colour by; nothing without nodes."""
    if not lamp.data.use_nodes or lamp.data.node_tree is None:
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
    tell(tree.nodes[shine.node], "varies or is not known here: the lamp is taken without its nodes")
    return WHITE


def fold_nodes(lamp):
    """Blender's exporter would take one part of a lamp's nodes and leave the other. False for a lamp that only takes light away."""
    light = lamp.data
    watts = [light.energy * a * b for a, b in zip(light.color, shine_of_nodes(lamp))]
    if min(watts) < 0.0:
        teller(lamp)(None, "takes light away in Blender: left out" + (" in some colours" if max(watts) > 0.0 else ""))
    largest = max(*watts, 0.0)
    if largest > 0.0:
        light.color = [max(w, 0.0) / largest for w in watts]
    light.energy = largest
    light.use_nodes = False
    return largest > 0.0 or min(watts) == 0.0


def fit_spot(light):
    """Cycles' spots fall off with the cosine, and smoothly at the edge; glTF's do not. Of the same power they become."""
    outer = 0.5 * light.spot_size
    least = math.cos(outer)
    edge = (1.0 - least) * light.spot_blend
    full = least + edge  # the cosine from which on all light arrives
    power = 0.5 * (1.0 - full * full) + edge * (0.5 * least + 0.35 * edge)
    light.energy *= power / (1.0 - full + 0.5 * edge)
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
    if abs(scale[0] / scale[1] - 1.0) > 0.01:
        warn("'%s': the cone of a spot that is scaled by %.3g and %.3g: taken as round" % (lamp.name, scale[0], scale[1]))
    end, lit = cone_of(light, math.sqrt(scale[0] * scale[1]) / scale[2])
    outer = math.acos(end)
    inner = min(end + 1.5 * (1.0 - end - lit), 1.0)
    light.spot_size = 2.0 * outer
    light.spot_blend = min(max(1.0 - math.acos(inner) / outer, 0.0), 1.0)


def is_sized(lamp):
    return lamp.data.type in ("POINT", "SPOT") and lamp.data.shadow_soft_size > 0.0


def tell_lost(lamps, spheres):
    """Says what lamps lose by their kind."""
    for lamp in lamps:
        if lamp.data.type == "AREA" and lamp.data.spread < 0.999 * math.pi:
            warn("'%s': spread of %.0f degrees: left out, the light goes to all sides" % (lamp.name, math.degrees(lamp.data.spread)))
        if lamp.data.type == "SUN" and lamp.data.angle > 0.0:
            warn("'%s': a sun of %.1f degrees: its shadows are sharp here, it is not seen in mirrors, and lights nothing through solid glass" %
                 (lamp.name, math.degrees(lamp.data.angle)))
    sized = [o.name for o in lamps if is_sized(o) and o.name not in spheres]
    soft = [o.name for o in lamps if IS_4 and o.data.type == "SPOT" and o.data.spot_blend > 0.0]
    if soft:
        warn("the edges of spots have the light of Blender's on the whole, but fall off otherwise: " + list_names(soft))
    if sized:
        warn("spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in mirrors, no light through solid glass: " + list_names(sized))


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
    """What the size of a lamp does to surfaces near to it. One of soft falloff is a disc that turns to each surface: of a radius r, at a
    distance d, it has 1 / (1 + (r/d)^2) of a sphere's light. Light passes lamps in Blender."""
    if not IS_4:
        return
    meshes = [(o, matrix) for o in scene.objects if o.type == "MESH" and o.data.polygons for matrix in placed.get(o.name, [o.matrix_world])]
    middles, radii = balls_around(meshes)
    for lamp in lamps:
        is_soft = getattr(lamp.data, "use_soft_falloff", False)
        if not is_sized(lamp) or not (is_soft or lamp.name in spheres):
            continue
        radius, place = lamp.data.shadow_soft_size, lamp.matrix_world.translation
        near = numpy.flatnonzero(numpy.sqrt(((middles - place) ** 2).sum(axis=1)) - radii < NEAR * radius)
        least = min((distance_to(*meshes[i], place) for i in near), default=math.inf)
        share = min((radius / max(least, 1e-6)) ** 2, 10.0)
        if share > NEAR**-2 and is_soft:
            warn("'%s': soft falloff: left out, which gives what is near up to %.0f %% more light" % (lamp.name, 100.0 * share))
        if share > NEAR**-2 and lamp.name in spheres:
            warn("'%s': a sphere here, which takes up to %.0f %% of the light that what is near returns" % (lamp.name, min(100.0 * share, 100.0)))


def prepare(scene, in_view, placed):
    """Gives every lamp data of its own, with what its nodes and its cone make of it; portals are none."""
    lamps, kept, spheres = [], [], set()
    for lamp in [o for o in scene.objects if o.type == "LIGHT"]:
        if lamp.data.type == "AREA" and lamp.data.cycles.is_portal:
            bpy.data.objects.remove(lamp)
        elif not lamp.hide_render:
            lamps.append(lamp)
    for lamp in lamps:
        if lamp.data.use_nodes and lamp.data.node_tree is not None:
            tell_animation(lamp.data.node_tree, teller(lamp))
        seen = place_of(lamp) in in_view
        lamp.data = lamp.data.copy()
        lamp.data.animation_data_clear()
        is_plain = not (lamp.data.use_nodes and lamp.data.node_tree is not None) and lamp.data.energy >= 0.0
        if not is_plain and not fold_nodes(lamp):
            bpy.data.objects.remove(lamp)
            continue
        if scene.render.engine == "CYCLES":
            lamp.data.use_custom_distance = False  # which is Eevee's, and would be glTF's range
        if lamp.data.type == "SPOT":
            fit_scaled_spot(lamp) if IS_4 else fit_spot(lamp.data)
        kept.append(lamp)
        if is_sized(lamp) and lamp.data.type == "POINT" and not seen and lamp.data.energy > 0.0:
            spheres.add(lamp.name)
    tell_lost(kept, spheres)
    tell_near(scene, kept, spheres, placed)
    return spheres


def carry(scene, in_view, placed):
    """`in_view`: the places of point lamps that stay points, since as spheres they would be seen; `placed`: where instances are."""
    for name in sorted(prepare(scene, in_view, placed)):
        replace_point_light(scene, scene.objects[name])
        bpy.data.objects.remove(scene.objects[name])
    lamps = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "AREA"]
    for lamp in lamps:
        if not lamp.hide_render:
            replace_area_light(scene, lamp)
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
                found.append((shown_by(instance), instance.matrix_world.copy()))
    return found


class InView:
    """Notes them frame by frame: `depsgraph` is that of the first frame, as lamps are exported."""

    def __init__(self, scene, depsgraph):
        self.scene, self.lamps = scene, unseen_lamps(depsgraph)
        self.places, self.flat = set(), set()  # of point lamps; names of area lamps

    def note(self, camera):
        for lamp, matrix in self.lamps:
            x, y, depth = world_to_camera_view(self.scene, camera, matrix.translation)
            size = extent_of(lamp, matrix.to_scale())
            edge = 0.05 + size / max(depth, 1e-3)
            if camera.data.type == "PANO" or depth > -size and -edge < x < 1.0 + edge and -edge < y < 1.0 + edge:
                if lamp.data.type == "POINT":
                    self.places.add(place_of(lamp, matrix))
                elif lamp.data.energy > 0.0 and not lamp.data.cycles.is_portal:
                    self.flat.add(lamp.name)

    def tell(self):
        if self.flat:
            warn("%s: an area lamp that the camera does not see in Blender: may be in view here, and hides what is behind" %
                 list_names(sorted(self.flat)))
