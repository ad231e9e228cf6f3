"""Small scenes, each of one thing that Blender has."""
import math

import bpy

from blender.versions import panorama_of
from parity.words import *  # noqa: F401,F403


# Lamps.


@scene()
def point_sharp():
    stage()
    lamp("POINT", (-1.5, -2.5, 3.5), 500.0)


@scene()
def point_radius():
    """In view, and mirrored."""
    stage(box_of=principled(GOLD, Metallic=1.0, Roughness=0.2))
    lamp("POINT", (0.2, 1.0, 2.0), 300.0, shadow_soft_size=0.3)


@scene()
def point_near():
    stage()
    lamp("POINT", (0.1, -0.2, 0.5), 60.0, shadow_soft_size=0.25)


@scene()
def spot_hard():
    stage()
    lamp("SPOT", (-2.0, -3.0, 4.0), 2500.0, (0, 0, 0.5), spot_size=math.radians(50), spot_blend=0.0)


@scene()
def spot_soft():
    stage()
    lamp("SPOT", (-2.0, -3.0, 4.0), 2500.0, (0, 0, 0.5), spot_size=math.radians(70), spot_blend=0.8)


@scene()
def spot_radius():
    stage()
    lamp("SPOT", (-1.0, -2.0, 3.0), 2000.0, (0, 0, 0.5), spot_size=math.radians(80), spot_blend=0.3, shadow_soft_size=0.4)


@scene()
def spot_scaled():
    stage()
    o = lamp("SPOT", (-2.0, -3.0, 4.0), 2500.0, (0, 0, 0.5), spot_size=math.radians(50), spot_blend=0.3)
    o.scale = (1.5, 1.5, 1.0)


@scene()
def sun_sharp():
    stage()
    lamp("SUN", (-2, -3, 4), 3.0, (0, 0, 0.5))


@scene()
def sun_1():
    stage()
    lamp("SUN", (-2, -3, 4), 3.0, (0, 0, 0.5), angle=math.radians(1.0))


@scene()
def sun_10():
    stage(box_of=principled(GOLD, Metallic=1.0, Roughness=0.3))
    lamp("SUN", (-2, -3, 4), 3.0, (0, 0, 0.5), angle=math.radians(10.0))


@scene()
def area_square():
    stage()
    softbox((-2.0, -2.0, 3.0), 250.0)
    lamp("AREA", (2.5, -1.0, 2.5), 150.0, (0, 0, 0.5), shape="RECTANGLE", size=2.0, size_y=0.3)


@scene()
def area_disc():
    stage()
    softbox((-2.0, -2.0, 3.0), 250.0, shape="DISK")
    lamp("AREA", (2.5, -1.0, 2.5), 150.0, (0, 0, 0.5), shape="ELLIPSE", size=1.6, size_y=0.5)


@scene()
def area_spread_30():
    stage()
    softbox((-2.0, -2.0, 3.0), 100.0, size=0.8, spread=math.radians(30))


@scene()
def area_spread_90():
    stage()
    softbox((-2.0, -2.0, 3.0), 150.0, size=0.8, spread=math.radians(90))


@scene()
def ies():
    stage()
    shine_by_ies(lamp("POINT", (-0.5, -0.8, 3.2), 100.0, (0, 0.0, 0.5)), 0.02)


@scene()
def lamp_colours():
    """Blackbody on a point, a colour by nodes on an area lamp, and a red sun."""
    stage()
    for o, kelvin in ((lamp("POINT", (-2.0, -1.5, 2.5), 200.0), 3000.0), (softbox((2.5, -2.0, 3.0), 200.0), 9000.0)):
        tree, emission = lamp_nodes(o)
        feed(tree, emission, "Color", add(tree, "Blackbody", Temperature=kelvin))
    lamp("SUN", (-2, -3, 4), 0.5, (0, 0, 0.5), color=(1.0, 0.4, 0.3))


@scene()
def lamps_many():
    stage()
    for i in range(12):
        turn = i * 2.4
        lamp("POINT", (3.0 * math.cos(turn), -0.5 + 1.8 * math.sin(turn), 0.8 + 0.2 * i), 40.0, color=(1.0, 0.5 + 0.04 * i, 0.3),
             shadow_soft_size=0.05)


# Worlds.


@scene()
def world_colour():
    stage()
    world((0.5, 0.6, 0.8), 0.8)


@scene()
def world_gradient():
    stage(box_of=principled(GOLD, Metallic=1.0, Roughness=0.1))
    tree, background = world()
    at = add(tree, "Separate" + ("XYZ"), Vector=add(tree, "TexCoord").outputs["Generated"])
    feed(tree, background, "Color", ramp(tree, at.outputs["Z"], (0.0, (0.9, 0.5, 0.2)), (0.7, (0.1, 0.3, 0.9))))


@scene()
def world_sky():
    stage()
    tree, background = world()
    sky = add(tree, "TexSky")
    sky.sun_elevation, sky.sun_rotation = math.radians(35), math.radians(200)
    feed(tree, background, "Color", sky)
    feed(tree, background, "Strength", 0.1)


@scene()
def world_map():
    stage(box_of=principled(GOLD, Metallic=1.0, Roughness=0.1))
    tree, background = world()

    def light(u, v):
        window = 20.0 * ((abs(u - 0.3) < 0.05) & (abs(v - 0.7) < 0.1))
        return 0.2 + window, 0.2 + 0.3 * v + window, 0.5 + 0.5 * v + 0.7 * window

    mapping = add(tree, "Mapping", Vector=add(tree, "TexCoord").outputs["Generated"])
    mapping.inputs["Rotation"].default_value = (0.2, 0.1, 1.1)
    node = add(tree, "TexEnvironment", Vector=mapping)
    node.image = picture("sky.hdr", 128, 64, light, True)
    feed(tree, background, "Color", node)


# Surfaces.


@scene()
def diffuse():
    sample(material("rough", lambda t: add(t, "BsdfDiffuse", Color=RED, Roughness=1.0)), principled(BLUE, Specular=0.0))


@scene()
def glossy():
    sample(*(material("glossy %g" % r, lambda t, r=r: add(t, "BsdfGlossy", Color=GOLD, Roughness=r)) for r in (0.1, 0.5, 0.0)))


@scene(samples=512)
def glass():
    _, block = sample(material("glass", lambda t: add(t, "BsdfGlass", IOR=1.45, Roughness=0.0)),
                      material("frosted", lambda t: add(t, "BsdfGlass", IOR=1.45, Roughness=0.4)))
    block.location.z += 0.02  # off the floor


@scene()
def metal():
    sample(principled(GOLD, Metallic=1.0, Roughness=0.1), principled(GOLD, Metallic=1.0, Roughness=0.5), principled(RED, Metallic=0.5))


@scene()
def plastic():
    sample(principled(RED, Roughness=0.1), principled(BLUE, Roughness=0.5), principled((0.02, 0.02, 0.02), Roughness=0.3))


@scene()
def coat():
    sample(principled(RED, Clearcoat=1.0), principled(BLUE, Clearcoat=1.0, Clearcoat_Roughness=0.3, Roughness=0.8))


@scene()
def sheen():
    sample(principled(RED, Sheen=1.0), principled(BLUE, Sheen=1.0, Roughness=0.9))


@scene()
def anisotropic():
    sample(principled(GOLD, Metallic=1.0, Roughness=0.4, Anisotropic=0.8),
           material("brushed", lambda t: add(t, "BsdfAnisotropic", Color=GOLD, Roughness=0.4, Anisotropy=0.7)))


@scene(samples=512)
def transmission():
    _, block = sample(principled((0.9, 1.0, 0.9), Transmission=1.0, Roughness=0.0, IOR=1.45),
                      principled(BLUE, Transmission=0.5, Roughness=0.3))
    block.location.z += 0.02


@scene()
def subsurface():
    marble = principled((0.8, 0.5, 0.4), Subsurface=1.0)
    node = marble.node_tree.nodes["Principled BSDF"]
    node.inputs["Subsurface Radius"].default_value = (0.2, 0.1, 0.05)
    sample(marble, principled((0.3, 0.6, 0.3), Subsurface=0.3))


@scene()
def emission():
    stage(glow((1.0, 0.6, 0.3), 4.0), principled(BLUE, Emission=(0.2, 0.9, 0.3), Emission_Strength=1.5))


def behind(surface, cuts=1):
    """A hanging sheet that is lit from behind."""
    world((0.02, 0.02, 0.02))
    camera()
    sheet((0, 0, 0), (12, 8), matte(GREY), "floor")
    softbox((0.0, 3.0, 2.5), 400.0)
    return sheet((0, 0.5, 1.3), (3.0, 2.4), surface, "curtain", UPRIGHT, cuts)


@scene()
def curtain():
    behind(material("cloth", lambda t: mix(t, 0.6, add(t, "BsdfDiffuse", Color=BLUE), add(t, "BsdfTranslucent", Color=(0.9, 0.6, 0.4)))))


@scene()
def curtain_open():
    """Cloth with a share that lets light straight through."""
    behind(material("voile", lambda t: mix(t, 0.4, add(t, "BsdfTranslucent", Color=(0.9, 0.9, 0.8)), add(t, "BsdfTransparent"))))


@scene()
def velvet():
    kind = "BsdfVelvet" if hasattr(bpy.types, "ShaderNodeBsdfVelvet") else "BsdfSheen"
    sample(material("velvet", lambda t: add(t, kind, Color=RED)))


@scene()
def mixes():
    def of(name, colour, roughness, factor):
        return material(name, lambda t: mix(t, factor(t), add(t, "BsdfDiffuse", Color=colour), add(t, "BsdfGlossy", Roughness=roughness)))
    sample(of("by Fresnel", BLUE, 0.2, lambda t: add(t, "Fresnel", IOR=1.5)),
           of("by checks", RED, 0.3, lambda t: add(t, "TexChecker", Scale=4.0).outputs["Fac"]))


@scene()
def varnish():
    """Gloss over Principled, of another roughness or colour."""
    def of(name, colour, factor, gloss=(1.0, 1.0, 1.0), **values):
        return material(name, lambda t: mix(t, factor(t), add(t, "BsdfPrincipled", Base_Color=colour, **values),
                                            add(t, "BsdfGlossy", Color=gloss, Roughness=0.1)))
    sample(of("by Fresnel", RED, lambda t: add(t, "Fresnel", IOR=1.45)),
           of("by Layer Weight", BLUE, lambda t: add(t, "LayerWeight", Blend=0.5).outputs["Fresnel"], GOLD, Roughness=0.4),
           of("by a share", RED, lambda t: 0.3))


@scene()
def facing():
    def shader(t):
        weight = add(t, "LayerWeight", Blend=0.5).outputs["Facing"]
        return add(t, "BsdfDiffuse", Color=ramp(t, weight, (0.0, (0.05, 0.05, 0.3)), (1.0, (0.9, 0.7, 0.3))))
    sample(material("facing", shader))


@scene()
def bump_only():
    def shader(t):
        height = add(t, "TexVoronoi", Scale=5.0)
        return add(t, "BsdfPrincipled", Base_Color=RED, Roughness=0.4), add(t, "Displacement", Height=height.outputs["Distance"], Scale=0.1)
    sample(material("bumps", shader))


@scene()
def displacement():
    def shader(t):
        height = add(t, "TexNoise", Scale=3.0)
        return add(t, "BsdfDiffuse", Color=RED), add(t, "Displacement", Height=height.outputs["Fac"], Scale=0.5, Midlevel=0.5)
    surface = material("hills", shader)
    if hasattr(surface, "displacement_method"):
        surface.displacement_method = "DISPLACEMENT"
    else:
        surface.cycles.displacement_method = "DISPLACEMENT"
    o, _ = sample(surface)
    o.modifiers.new("fine", "SUBSURF").render_levels = 3


@scene()
def images():
    def shader(t):
        mapping = add(t, "Mapping", Vector=add(t, "TexCoord").outputs["UV"])
        mapping.inputs["Scale"].default_value = (2.0, 1.5, 1.0)
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.5)
        return add(t, "BsdfPrincipled", Base_Color=image_node(t, picture("stripes.png", 64, 64, stripes), mapping), Roughness=0.6)
    surface = material("image", shader)
    sample(surface, surface)


@scene()
def procedural():
    def noise(t):
        return add(t, "BsdfDiffuse", Color=ramp(t, add(t, "TexNoise", Scale=4.0, Detail=3.0).outputs["Fac"], (0.35, RED), (0.65, GOLD)))

    def wood(t):
        grain = add(t, "TexWave", Scale=3.0, Distortion=4.0).outputs["Fac"]
        return add(t, "BsdfPrincipled", Base_Color=ramp(t, grain, (0.0, (0.2, 0.08, 0.02)), (1.0, (0.6, 0.35, 0.15))),
                   Roughness=add(t, "TexNoise", Scale=10.0).outputs["Fac"])
    sample(material("noise", noise), material("wood", wood))


@scene()
def alpha():
    """A cutout by an image, and a share by a number."""
    def holes(t):
        odd = add(t, "TexChecker", Scale=6.0).outputs["Fac"]
        return add(t, "BsdfPrincipled", Base_Color=RED, Alpha=odd)
    o, _ = sample(material("holes", holes), principled(BLUE, Alpha=0.4))
    o.location.y = -0.5


@scene()
def vertex_colour():
    def shader(t):
        node = add(t, "VertexColor")
        node.layer_name = "paint"
        return add(t, "BsdfDiffuse", Color=node)
    o, _ = sample(material("painted", shader))
    layer = o.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
    for vertex, value in zip(o.data.vertices, layer.data):
        value.color = (0.5 + 0.7 * vertex.co.x, 0.5 + 0.7 * vertex.co.y, 0.5 + 0.7 * vertex.co.z, 1.0)


# Geometry and instances.


@scene()
def modifiers():
    _, block = sample()
    block.modifiers.new("round", "BEVEL").width = 0.15
    array = block.modifiers.new("row", "ARRAY")
    array.count, array.relative_offset_displace = 2, (0.0, 0.0, 1.1)
    bpy.ops.mesh.primitive_monkey_add(size=1.2, location=(0.2, -1.4, 0.6))
    monkey = shaped("monkey", matte(GOLD), True)
    monkey.modifiers.new("smooth", "SUBSURF").render_levels = 2
    monkey.modifiers.new("thick", "SOLIDIFY").thickness = 0.05


@scene()
def instances():
    """By faces, and as a collection."""
    sample()
    parent = sheet((0.0, -1.6, 0.1), (3.0, 1.0), None, "faces", cuts=4)
    child = ball((0, 0, 0), 0.12, matte(GOLD), "seed")
    child.parent, parent.instance_type, parent.show_instancer_for_render = parent, "FACES", False
    group = bpy.data.collections.new("group")
    for o in (box((0, 0, 0), (0.3, 0.3, 0.3), matte(RED), "brick"), ball((0, 0, 0.3), 0.15, matte(BLUE), "knob")):
        bpy.context.scene.collection.objects.unlink(o)
        group.objects.link(o)
    for i in range(3):
        holder = placed("holder", None, (-2.5 + 2.4 * i, 1.4, 0.3))
        holder.instance_type, holder.instance_collection, holder.scale = "COLLECTION", group, (1 + i, 1, 1 + 0.5 * i)


@scene()
def hair_objects():
    """Particles of the kind hair that show an object."""
    sample()
    blade = box((0, 0, -5), (0.04, 0.04, 0.5), matte((0.2, 0.6, 0.1)), "blade")
    lawn = sheet((0.3, -1.6, 0.01), (3.0, 1.2), matte((0.1, 0.2, 0.05)), "lawn")
    lawn.modifiers.new("grass", "PARTICLE_SYSTEM")
    grass = lawn.particle_systems[0].settings
    grass.type, grass.count, grass.render_type, grass.instance_object = "HAIR", 200, "OBJECT", blade
    grass.hair_length, grass.particle_size = 1.0, 0.6


@scene()
def curves():
    sample()
    for i, kind in enumerate(("circle", "curve")):
        getattr(bpy.ops.curve, "primitive_bezier_%s_add" % kind)(radius=0.8, location=(-0.8 + 1.6 * i, -1.2, 0.3))
        o = shaped(kind, matte(GOLD))
        o.data.bevel_depth, o.rotation_euler = 0.12, (0.5, 0.0, 0.3)


@scene()
def text_and_blobs():
    sample()
    bpy.ops.object.text_add(location=(-1.9, -1.5, 0.0), rotation=UPRIGHT)
    o = shaped("words", matte(GOLD))
    o.data.body, o.data.extrude, o.data.bevel_depth = "Light", 0.1, 0.02
    for x in (0.6, 1.2):
        bpy.ops.object.metaball_add(type="BALL", radius=0.6, location=(x, -1.5, 0.5))
        shaped("blob", None)
    bpy.data.metaballs[0].materials.append(matte(RED))


@scene()
def shape_key():
    o, _ = sample()
    o.shape_key_add(name="Basis")
    for point in o.shape_key_add(name="tall").data:
        point.co = (0.6 * point.co.x, point.co.y, 1.6 * point.co.z)
    o.data.shape_keys.key_blocks["tall"].value = 0.7


@scene()
def mirrored():
    """A child of a parent with a negative, uneven scale."""
    sample()
    parent = placed("parent", None, (0.2, -1.3, 0.5), (0.0, 0.3, 0.5))
    parent.scale = (-1.5, 0.8, 1.0)
    bpy.ops.mesh.primitive_monkey_add(size=0.9)
    shaped("monkey", principled(GOLD, Roughness=0.3), True).parent = parent


# Cameras.


@scene()
def camera_shift():
    sample()
    camera(shift_x=0.2, shift_y=-0.1, lens=35.0, sensor_fit="VERTICAL")


@scene()
def camera_ortho():
    sample()
    camera(type="ORTHO", ortho_scale=5.0)


@scene()
def camera_panorama():
    sample()
    o = camera((0.2, -1.8, 1.2), (0.2, 5.0, 1.2), type="PANO")
    panorama_of(o.data).panorama_type = "EQUIRECTANGULAR"


@scene()
def camera_focus():
    sample()
    o = camera(lens=60.0)
    o.data.dof.use_dof, o.data.dof.focus_distance, o.data.dof.aperture_fstop = True, 4.5, 0.3
    o.data.dof.aperture_blades = 5


@scene()
def film_transparent():
    sample()
    bpy.data.objects.remove(bpy.data.objects["wall"])
    bpy.context.scene.render.film_transparent = True
