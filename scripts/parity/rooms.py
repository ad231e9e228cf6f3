"""Rooms with everything at once."""
import math

import bpy

from parity.words import *  # noqa: F401,F403


def walls(width, depth, height, surface, window=None):
    """A closed room around the origin; the window is a hole (y from, to, z from, to) in the wall towards x."""
    w, d = 0.5 * width, 0.5 * depth
    sheet((0, 0, height), (width, depth), surface, "ceiling", (math.pi, 0.0, 0.0), 8)
    sheet((0, d, 0.5 * height), (width, height), surface, "back", UPRIGHT, 8)
    sheet((0, -d, 0.5 * height), (width, height), surface, "front", UPRIGHT, 8)
    sheet((-w, 0, 0.5 * height), (height, depth), surface, "left", (0.0, 0.5 * math.pi, 0.0), 8)
    y0, y1, z0, z1 = window or (0, 0, 0, 0)
    for i, (a, b, low, high) in enumerate(((-d, y0, 0, height), (y1, d, 0, height), (y0, y1, 0, z0), (y0, y1, z1, height))):
        if b > a and high > low:
            sheet((w, 0.5 * (a + b), 0.5 * (low + high)), (high - low, b - a), surface, "right %d" % i, (0.0, 0.5 * math.pi, 0.0), 4)


def planks(t):
    grain = add(t, "TexWave", Scale=1.5, Distortion=3.0)
    colour = ramp(t, grain.outputs["Fac"], (0.0, (0.25, 0.13, 0.06)), (1.0, (0.5, 0.3, 0.15)))
    return add(t, "BsdfPrincipled", Base_Color=colour, Roughness=0.4)


def plant(place):
    """Leaves as instances on a ball."""
    leaf = sheet((0, 0, -9), (0.16, 0.08), material("leaf", lambda t: mix(
        t, 0.4, add(t, "BsdfDiffuse", Color=(0.1, 0.4, 0.08)), add(t, "BsdfTranslucent", Color=(0.2, 0.5, 0.05)))), "leaf")
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.3, location=place)
    bush = shaped("bush", None)
    leaf.parent, bush.instance_type, bush.show_instancer_for_render = bush, "FACES", False
    box((place[0], place[1], 0.25), (0.3, 0.3, 0.5), matte((0.5, 0.2, 0.1), "pot"), "pot")


def sofa(surface):
    for place, size in (((0, 1.2, 0.35), (2.2, 0.9, 0.4)), ((0, 1.65, 0.75), (2.2, 0.25, 0.7)), ((-1.1, 1.2, 0.55), (0.25, 0.9, 0.5))):
        box(place, size, surface, "sofa").modifiers.new("round", "BEVEL").width = 0.06


@scene(samples=512)
def room_living():
    """By day: sun and sky by a window with curtains, an area lamp, a floor lamp with a shade, images, metal, glass, a plant."""
    tree, background = world()
    feed(tree, background, "Color", add(tree, "Blackbody", Temperature=9000.0))
    feed(tree, background, "Strength", 2.0)
    camera((-0.6, -2.3, 1.5), (0.3, 1.0, 0.8), lens=24.0)
    walls(5.0, 5.0, 2.7, matte((0.75, 0.72, 0.68), "paint"), (-1.0, 1.5, 0.6, 2.3))
    sheet((0, 0, 0), (5.0, 5.0), material("planks", planks), "floor", cuts=8)
    lamp("SUN", (4, -1, 4), 6.0, (0, 0.3, 0), angle=math.radians(0.53), color=(1.0, 0.9, 0.75))
    softbox((0.0, 0.0, 2.65), 60.0, (0.0, 0.0, 0.0), 1.2)
    cloth = material("cloth", lambda t: mix(t, 0.6, add(t, "BsdfDiffuse", Color=GREY), add(t, "BsdfTranslucent", Color=(0.9, 0.8, 0.7))))
    sheet((2.45, 1.1, 1.4), (1.9, 0.7), cloth, "curtain", (0.0, 0.5 * math.pi, 0.0))
    sofa(principled((0.25, 0.3, 0.4), Roughness=0.9, Sheen=0.3))
    lamp("POINT", (1.5, 1.6, 1.6), 25.0, shadow_soft_size=0.05, color=(1.0, 0.75, 0.5))
    bpy.ops.mesh.primitive_cone_add(vertices=32, radius1=0.3, radius2=0.15, depth=0.35, end_fill_type="NOTHING", location=(1.5, 1.6, 1.6))
    paper = material("shade", lambda t: mix(t, 0.5, *(add(t, "Bsdf" + kind, Color=(0.9, 0.8, 0.6)) for kind in ("Diffuse", "Translucent"))))
    shaped("shade", paper)
    box((1.5, 1.6, 0.7), (0.04, 0.04, 1.4), principled(GOLD, Metallic=1.0, Roughness=0.3), "stand")
    box((0.1, -0.1, 0.4), (1.1, 0.6, 0.04), principled((0.05, 0.05, 0.05), Roughness=0.15, Clearcoat=0.5), "table")
    ball((0.0, -0.1, 0.57), 0.15, material("glass", lambda t: add(t, "BsdfGlass", IOR=1.45, Roughness=0.0)), "bowl")
    ball((0.35, -0.1, 0.52), 0.1, principled((0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.2), "silver")
    paint = picture("stripes.png", 64, 64, stripes)
    painting = material("painting", lambda t: add(t, "BsdfPrincipled", Base_Color=image_node(t, paint), Roughness=0.7))
    sheet((-0.9, 2.48, 1.7), (0.9, 0.7), painting, "painting", UPRIGHT)
    plant((-1.8, 1.6, 0.8))


@scene(samples=512)
def room_night():
    """Downlights by IES, lamps with shades that glow, a wide spot of soft edge."""
    world((0.01, 0.012, 0.02))
    camera((-0.6, -2.3, 1.5), (0.3, 1.0, 0.8), lens=24.0)
    walls(5.0, 5.0, 2.7, matte((0.6, 0.58, 0.62), "paint"))
    sheet((0, 0, 0), (5.0, 5.0), material("planks", planks), "floor", cuts=8)
    for x in (-1.5, 0.0, 1.5):
        o = lamp("SPOT", (x, 2.1, 2.6), 100.0, (x, 2.2, 0.0), spot_size=math.radians(150), spot_blend=0.2, shadow_soft_size=0.02)
        shine_by_ies(o, 0.005)
    lamp("SPOT", (-1.5, -1.0, 2.5), 150.0, (0.5, 0.8, 0.3), spot_size=math.radians(70), spot_blend=0.7, shadow_soft_size=0.1)
    ball((1.6, 1.6, 1.1), 0.2, glow((1.0, 0.7, 0.4), 12.0, "shade"), "shade")
    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.12, depth=0.4, location=(-1.9, 0.6, 0.9))
    shaped("lantern", principled((0.9, 0.8, 0.7), Emission=(1.0, 0.6, 0.3), Emission_Strength=6.0), True)
    sofa(material("velvet", lambda t: add(t, "BsdfVelvet" if hasattr(bpy.types, "ShaderNodeBsdfVelvet") else "BsdfSheen", Color=RED)))
    box((0.1, -0.1, 0.4), (1.1, 0.6, 0.04), principled((0.3, 0.3, 0.3), Metallic=1.0, Roughness=0.25, Anisotropic=0.5), "table")
    ball((0.1, -0.1, 0.57), 0.15, principled((0.8, 0.4, 0.3), Roughness=0.2, Clearcoat=1.0), "vase")


@scene(samples=512)
def room_studio():
    """A product shot: softboxes with and without spread, a bottle of glass, a coated and a brushed body, a curved backdrop, focus."""
    world((0.08, 0.08, 0.09))
    o = camera((0.0, -5.0, 1.6), (0.0, 0.0, 0.7), lens=60.0)
    o.data.dof.use_dof, o.data.dof.focus_distance, o.data.dof.aperture_fstop = True, 5.0, 1.4
    paper = sheet((0, 0, 0), (8, 6), matte((0.8, 0.8, 0.8), "paper"), "backdrop", cuts=24)
    for v in paper.data.vertices:
        t = max(v.co.y - 0.2, 0.0)
        v.co.z = 3.5 * t * t * 8.0
    bpy.ops.object.shade_smooth()
    softbox((-2.5, -1.5, 2.5), 150.0, (0, 0, 0.6), 1.2)
    softbox((2.8, -1.0, 2.2), 120.0, (0, 0, 0.6), 0.6, spread=math.radians(60))
    lamp("AREA", (0.0, 1.5, 3.5), 100.0, (0, 0, 0.5), shape="RECTANGLE", size=2.0, size_y=0.4, color=(0.8, 0.9, 1.0))
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.3, depth=1.2, location=(-0.8, 0.0, 0.601))
    shaped("bottle", principled((0.8, 1.0, 0.85), Transmission=1.0, Roughness=0.0, IOR=1.45)).modifiers.new("round", "BEVEL").width = 0.1
    ball((0.1, -0.2, 0.4), 0.4, principled(RED, Clearcoat=1.0, Roughness=0.5), "red")
    box((1.0, 0.1, 0.4), (0.6, 0.6, 0.8), principled((0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.35, Anisotropic=0.7), "case",
        (0, 0, 0.5)).modifiers.new("round", "BEVEL").width = 0.05
    ball((0.5, -0.8, 0.18), 0.18, principled((0.9, 0.7, 0.6), Subsurface=0.5, Roughness=0.4), "soap")
