"""Lamps as glTF has them: their nodes folded, spots as bright as in Cycles, area lights as one-sided emissive quads and discs,
round lamps out of view as spheres."""
import math

import bmesh
import bpy
from bpy_extras.object_utils import world_to_camera_view

from . import materials, shader_tree
from .animated import tell_animation
from .channels import WHITE, is_constant
from .folding import Folder
from .messages import list_names, warn

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
    # Cycles' radiance is the lamp's watts over 4 A, where pi A would give them all
    largest = max(light.color) or 1.0
    color = [c / largest for c in light.color]
    mesh.materials.append(materials.glow(lamp.name, color, light.energy * largest / (4.0 * area)))
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


def extent_of(lamp):
    """The radius of a sphere around what shines."""
    if lamp.data.type != "AREA":
        return lamp.data.shadow_soft_size
    corners, _ = corners_of(lamp.data)
    scale = lamp.matrix_world.to_scale()
    return max(math.hypot(x * scale.x, y * scale.y) for x, y, _ in corners)


class InView:
    """Notes which point and area lamps come into the picture, where Cycles' camera does not see them."""

    def __init__(self, scene):
        self.scene, self.names, self.flat = scene, set(), set()

    def note(self, camera):
        for lamp in [o for o in self.scene.objects if o.type == "LIGHT" and o.data.type in ("POINT", "AREA")]:
            if lamp.visible_camera or not lamp.visible_get():
                continue
            x, y, depth = world_to_camera_view(self.scene, camera, lamp.matrix_world.translation)
            size = extent_of(lamp)
            edge = 0.05 + size / max(depth, 1e-3)
            if camera.data.type == "PANO" or depth > -size and -edge < x < 1.0 + edge and -edge < y < 1.0 + edge:
                (self.names if lamp.data.type == "POINT" else self.flat).add(lamp.name)

    def tell(self):
        lamps = [self.scene.objects[n] for n in sorted(self.flat)]
        flat = [o.name for o in lamps if o.data.energy > 0.0 and not o.data.cycles.is_portal]
        if flat:
            warn("%s: an area lamp that the camera does not see in Blender: may be in view here, and hides what is behind" % list_names(flat))


def teller(lamp):
    """Warns of a lamp's nodes."""
    def tell(node, text):
        warn("'%s': lamp%s: %s" % (lamp.name, ", node '%s'" % node.name if node is not None else "", text))
    return tell


def shine_of_nodes(lamp):
    """What a lamp's nodes multiply its colour by."""
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
    """Blender's exporter would take one part of a lamp's nodes and leave the other."""
    light = lamp.data
    light.color = [max(a * b, 0.0) for a, b in zip(light.color, shine_of_nodes(lamp))]
    largest = max(light.color)
    if largest > 0.0:
        light.color = [c / largest for c in light.color]
    light.energy *= largest
    light.use_nodes = False


def fit_spot(light):
    """Cycles' spots fall off with the cosine, and smoothly at the edge; glTF's do not. Of the same power they become."""
    outer = 0.5 * light.spot_size
    least = math.cos(outer)
    edge = (1.0 - least) * light.spot_blend
    full = least + edge  # the cosine from which on all light arrives
    power = 0.5 * (1.0 - full * full) + edge * (0.5 * least + 0.35 * edge)
    light.energy *= power / (1.0 - full + 0.5 * edge)
    light.spot_blend = 1.0 - math.acos(0.75 * full + 0.25 * least) / outer  # glTF: the square of a ramp, a third of its width


def is_sized(lamp):
    return lamp.data.type in ("POINT", "SPOT") and lamp.data.shadow_soft_size > 0.0


def tell_lost(lamps, spheres):
    """Says what lamps lose by their kind."""
    for lamp in lamps:
        if lamp.data.type == "AREA" and lamp.data.spread < 0.999 * math.pi:
            warn("'%s': spread of %.0f degrees: left out, the light goes to all sides" % (lamp.name, math.degrees(lamp.data.spread)))
        if lamp.data.type == "SUN" and lamp.data.angle > 0.0:
            warn("'%s': a sun of %.1f degrees: its shadows are sharp here, and it is not seen in mirrors" % (lamp.name, math.degrees(lamp.data.angle)))
    sized = [o.name for o in lamps if is_sized(o) and o.name not in spheres]
    if sized:
        warn("spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in mirrors, no light through solid glass: " + list_names(sized))


def prepare(scene, in_view):
    """Gives every lamp data of its own, with what its nodes and its cone make of it; portals are none."""
    lamps = []
    for lamp in [o for o in scene.objects if o.type == "LIGHT"]:
        if lamp.data.type == "AREA" and lamp.data.cycles.is_portal:
            bpy.data.objects.remove(lamp)
        elif not lamp.hide_render:
            lamps.append(lamp)
    for lamp in lamps:
        if lamp.data.use_nodes and lamp.data.node_tree is not None:
            tell_animation(lamp.data.node_tree, teller(lamp))
        lamp.data = lamp.data.copy()
        lamp.data.animation_data_clear()
        if lamp.data.use_nodes and lamp.data.node_tree is not None:
            fold_nodes(lamp)
        if lamp.data.type == "SPOT":
            fit_spot(lamp.data)
    spheres = {o.name for o in lamps if is_sized(o) and o.data.type == "POINT" and o.name not in in_view and o.data.energy > 0.0}
    tell_lost(lamps, spheres)
    return spheres


def carry(scene, in_view):
    """`in_view`: the point lamps that stay points, since as spheres they would be seen."""
    for name in sorted(prepare(scene, in_view)):
        replace_point_light(scene, scene.objects[name])
        bpy.data.objects.remove(scene.objects[name])
    lamps = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "AREA"]
    for lamp in lamps:
        if not lamp.hide_render:
            replace_area_light(scene, lamp)
        bpy.data.objects.remove(lamp)
