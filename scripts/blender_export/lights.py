"""Area lights as one-sided emissive quads and discs of the same power."""
import math

import bpy

from . import materials

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
    # a one-sided surface of radiance L and area A emits the power pi A L
    largest = max(light.color) or 1.0
    color = [c / largest for c in light.color]
    mesh.materials.append(materials.glow(lamp.name, color, light.energy * largest / (math.pi * area)))
    quad = bpy.data.objects.new(lamp.name + " area", mesh)
    quad.matrix_world = lamp.matrix_world.copy()
    scene.collection.objects.link(quad)


def replace_area_lights(scene):
    lamps = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "AREA"]
    for lamp in lamps:
        if not lamp.hide_render:
            replace_area_light(scene, lamp)
        bpy.data.objects.remove(lamp)
