"""Lamps that change: keys of what they become. Each is exported as in the frame in which it is brightest; that also is a lamp which is
off in the first.
"""
import math

import bpy
import numpy

from . import lights
from .channels import WHITE, is_constant, strength_of
from .folding import Folder
from .messages import lose
from .values import differs
from .versions import IS_4, has_nodes, principled_of, socket

STRENGTH = "extensions/KHR_materials_emissive_strength/emissiveStrength"


def factor_of_nodes(light):
    """What a lamp's nodes multiply its colour by; of nodes that vary, the number that they are multiplied by."""
    if not has_nodes(light):
        return WHITE
    out = light.node_tree.get_output_node("CYCLES")
    if out is None or not out.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0)
    folder = Folder(light.node_tree, lambda node, text: None)
    shine = folder.fold(out.inputs["Surface"]).emission
    return shine if is_constant(shine) else (strength_of(folder, shine)[1],) * 3


def watts_of(light, matrix):
    energy, colour = lights.power_of(light, matrix)
    return [max(energy * a * b, 0.0) for a, b in zip(colour, factor_of_nodes(light))]


def size_of(light):
    """What scales the mesh of a lamp in x, y and z."""
    if light.type == "AREA":
        return light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size, 1.0
    return (light.shadow_soft_size,) * 3


def cone_of(lamp, light):
    """The angles of the cone of a spot as it is exported, and what its energy is multiplied by."""
    spot = bpy.data.objects.new("spot", light.copy())
    spot.matrix_world = lamp.matrix_world
    spot.data.energy = 1.0
    lights.fit_scaled_spot(spot) if IS_4 else lights.fit_spot(spot.data)
    outer = 0.5 * spot.data.spot_size
    found = outer * (1.0 - spot.data.spot_blend), outer, spot.data.energy
    bpy.data.lights.remove(spot.data)
    return found


class Changing:
    """A lamp that changes."""

    def __init__(self, lamp, states):
        self.name, self.states, self.kind = lamp.name, states, lamp.data.type
        self.watts = [watts_of(copy, lamp.matrix_world) for copy in states.copies]
        self.base = max(range(len(self.watts)), key=lambda i: (max(self.watts[i]), -i))
        self.sizes = [size_of(copy) for copy in states.copies] if self.kind != "SUN" else [(1.0,) * 3] * len(self.watts)
        self.cones = [cone_of(lamp, copy) for copy in states.copies] if self.kind == "SPOT" else None

    def is_dark(self):
        return max(self.watts[self.base]) <= 0.0

    def of_each(self, values):
        return self.states.of_each(values)

    def shares(self, areas):
        """For each state what the light is, by channel, of the most there is in the exported one."""
        most = max(self.watts[self.base])
        return [[w / most * area for w in watts] for watts, area in zip(self.watts, areas)]

    def key_light(self, o, tracks):
        light = o.data
        power = [1.0] * len(self.watts) if self.cones is None else [cone[2] / self.cones[self.base][2] for cone in self.cones]
        shares = self.shares(power)
        most = light.energy if light.type == "SUN" else light.energy / (4.0 * math.pi)
        tracks.light(light.name, "intensity", self.of_each([most * max(s) for s in shares]))
        tracks.light(light.name, "color", self.of_each([[c / max(s) for c in s] if max(s) > 0.0 else list(light.color) for s in shares]))
        if self.cones is not None and light.type == "SPOT":
            tracks.light(light.name, "spot/innerConeAngle", self.of_each([cone[0] for cone in self.cones]))
            tracks.light(light.name, "spot/outerConeAngle", self.of_each([cone[1] for cone in self.cones]))
        self.tell_still()

    def tell_still(self):
        """What shadows are soft by has no keys."""
        names = {"SUN": ("angle",), "AREA": ("size", "size_y", "spread", "shape")}.get(self.kind, ("shadow_soft_size",))
        words = {"angle": "angle", "shadow_soft_size": "radius", "spread": "spread"}
        for name in names:
            values = [getattr(copy, name) for copy in self.states.copies]
            if len(set(values)) > 1:
                lose("'%s': the %s of the lamp changes: taken as in the frame in which it is brightest" %
                     (self.name, words.get(name, "shape")))
                return

    def key_mesh(self, o, tracks, patches):
        """Its size by the node, its light by the material, so that the watts stay."""
        base, whole = self.sizes[self.base], [s[0] * s[1] for s in self.sizes]
        shares = self.shares([whole[self.base] / a if a > 0.0 else 0.0 for a in whole])
        name = o.data.materials[0].name
        strength = socket(principled_of(o.data.materials[0].node_tree), "Emission Strength").default_value
        most = max(max(s) for s in shares)
        values = self.of_each([[c / most for c in s] for s in shares])
        tracks.material(name, "emissiveFactor", values)
        patches[name] = {**patches.get(name, {}), "first": {"emissiveFactor": values[0], STRENGTH: strength * most}}
        if any(differs(s, base) for s in self.sizes):
            ratios = numpy.array(self.of_each([[max(a / b, 1e-6) for a, b in zip(s, base)] for s in self.sizes]))
            tracks.enlarge(o.name, tuple(o.scale), ratios)
        spreads = [getattr(copy, "spread", 0.0) for copy in self.states.copies]
        if self.kind == "AREA" and any(differs(s, spreads[0]) for s in spreads):
            lose("'%s': the spread of the lamp changes: taken as in the frame in which it is brightest" % self.name)


def begin(scene, recorded):
    """Lets lamps be as they are when they are brightest; returns those that change."""
    found, renamed = [], {}
    for o in [o for o in scene.objects if o.type == "LIGHT"]:
        states = recorded.lamps.get(o.data.name_full) if o.data.library is None else None
        if states is None or len(states.copies) < 2 or o.data.type == "AREA" and o.data.cycles.is_portal:
            continue
        found.append((o, Changing(o, states)))
    for o, lamp in found:
        block, copy = lamp.states.source.block, lamp.states.copies[lamp.base]
        if copy.name != block.name and block not in renamed:
            name = block.name  # by which lamps are told apart
            block.name = name + " (before export)"
            copy.name = name
            renamed[block] = copy
        o.data = copy
    return [lamp for _, lamp in found if not lamp.is_dark()]


def finish(scene, changing, tracks, patches):
    """Writes the keys, when the lamps are what is exported."""
    for lamp in changing:
        o = scene.objects.get(lamp.name)
        mesh = next((scene.objects[lamp.name + end] for end in (" area", " sphere") if lamp.name + end in scene.objects), None)
        if o is not None and o.type == "LIGHT":
            lamp.key_light(o, tracks)
        elif mesh is not None:
            lamp.key_mesh(mesh, tracks, patches)
