"""Sizes of lamps that shine without being seen: radii of points and spots, angles of suns, and area lamps as planes."""
import math

import bpy

from .versions import IS_4

extras = {}  # of lamp data, by name, until `write`


def is_soft(light):
    """Is it a disc that turns to what it lights? Blender 3 has no other."""
    return getattr(light, "use_soft_falloff", True)


def has_size(light):
    return light.type == "AREA" or (light.angle if light.type == "SUN" else light.shadow_soft_size) > 0.0


def give_size(lamp):
    """What glTF does not say of a point, a spot or a sun."""
    light = lamp.data
    if light.type == "SUN" and light.angle > 0.0:
        extras[light.name] = {"angle": min(math.degrees(light.angle), 180.0)}
        if not IS_4:  # Cycles draws points of a disc that is flat, each of the same light
            cosine = math.cos(0.5 * min(light.angle, math.pi))
            light.energy *= 2.0 * cosine / (1.0 + cosine)
    elif light.type in ("POINT", "SPOT") and light.shadow_soft_size > 0.0:
        extras[light.name] = {"radius": light.shadow_soft_size, "soft": True} if is_soft(light) else {"radius": light.shadow_soft_size}


def is_plane(lamp, seen):
    """Is an area lamp one that its mesh would show, or whose light a mesh would send to other sides? Of spreads within a tenth of a
    degree of all sides, none is."""
    return seen or lamp.data.spread < math.pi - 0.002


def make_plane(lamp):
    """The lamp becomes a spot for Blender's exporter, of which `write` makes a plane; its light goes with its shape as scaled."""
    light, scale = lamp.data, lamp.matrix_world.to_scale()
    size = (light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    size = [s * abs(k) for s, k in zip(size, scale)]
    name, watts = light.name, light.energy
    own = {"shape": "rectangle" if light.shape in ("SQUARE", "RECTANGLE") else "ellipse", "size": size}
    if light.spread < math.pi - 0.002:
        own["spread"] = min(max(math.degrees(light.spread), 1.0), 180.0)
    if min(size) <= 0.0 or watts <= 0.0:
        bpy.data.objects.remove(lamp)
        return
    extras[name] = own
    light.type = "SPOT"
    light = bpy.data.lights[name]
    light.shadow_soft_size, light.spot_size, light.spot_blend = 0.0, math.pi, 1.0
    # along the axis watts over pi, in Cycles of Blender 3 watts over 4; the exporter divides a spot's by 4 pi
    light.energy = watts * (4.0 if IS_4 else math.pi)


def write(gltf):
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        own = extras.get(light.get("name"))
        if own is None:
            continue
        light.setdefault("extras", {}).setdefault("reframe", {}).update(own)
        if "shape" in own:
            light["type"] = "point"
            light.pop("spot", None)
