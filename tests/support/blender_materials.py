"""Small scenes of materials, for test_blender_materials.c."""

import bpy
import numpy

from blender_words import Shader, add_socket, begin, eye, give_nodes, glow, grey, lamp, lamp_nodes, matte, socket

ROOM = 2.0  # half a side


def noise_mix(name, a, b, scale=3.0):
    """Two diffuse surfaces, mixed by a noise."""
    s = Shader(name)
    noise = s.add("TexNoise", Scale=scale, Detail=1.0)
    ramp = s.add("ValToRGB", Fac=noise.outputs["Fac"])
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.35, 0.65
    return s.done(s.mix(ramp.outputs["Color"], s.add("BsdfDiffuse", Color=a), s.add("BsdfDiffuse", Color=b)))


def put(mesh, material=None, **where):
    getattr(bpy.ops.mesh, "primitive_" + mesh + "_add")(**where)
    o = bpy.context.object
    if material is not None:
        o.data.materials.append(material)
    return o


def inwards(o):
    o.data.flip_normals()
    return o


def panel(strength, size, **where):
    """A lamp of an emission, or of a material. Cut into many faces: near one of two triangles Cycles is a per cent too dark."""
    material = glow(grey(1.0), strength, "lamp") if isinstance(strength, float) else strength
    return put("grid", material, x_subdivisions=12, y_subdivisions=12, size=size, **where)


def room(material, strength=8.0, size=1.0):
    """A closed room and a lamp of an emission."""
    walls = inwards(put("cube", material, size=2.0 * ROOM))
    panel(strength, size, location=(0.3 / size, 0.4 / size, ROOM - 0.02))
    return walls


def plain_room(**lit):
    return room(matte(grey(0.6), "wall"), **lit)


def procedural():
    room(noise_mix("wall", (0.85, 0.75, 0.6, 1.0), (0.1, 0.15, 0.3, 1.0)))


def striped(s):
    """The colour of an image. Between pixels Cycles interpolates sRGB values, glTF linear ones: hence no interpolation."""
    node = s.add("TexImage")
    node.interpolation = "Closest"
    node.image = bpy.data.images.get("stripes")
    if node.image is None:
        node.image = bpy.data.images.new("stripes", 64, 64)
        pixels = numpy.ones((64, 64, 4), numpy.float32)
        pixels[:, ::8, :3] = pixels[:, 1::8, :3] = pixels[:, 2::8, :3] = (0.9, 0.4, 0.1)
        pixels[:8, :, :3] = (0.1, 0.3, 0.8)
        node.image.pixels.foreach_set(pixels.ravel())
        node.image.pack()
    return node.outputs["Color"]


def images():
    """Images that need no bake: as they are, by a factor, and shining."""
    plain_room(strength=1.0, size=3.6)
    s = Shader("plain")
    put("cube", s.done(s.add("BsdfDiffuse", Color=striped(s))), size=1.0, location=(-1.1, 0.7, -1.3))
    s = Shader("dimmed")
    product = s.add("Mix")
    product.data_type, product.blend_type = "RGBA", "MULTIPLY"
    product.inputs[0].default_value = 1.0
    s.feed(product.inputs[6], striped(s))
    s.feed(product.inputs[7], (0.5, 0.9, 0.3, 1.0))
    put("cube", s.done(s.add("BsdfDiffuse", Color=product.outputs[2])), size=1.0, location=(0.2, 0.7, -1.3))
    s = Shader("shining")
    put("cube", s.done(s.add("Emission", Color=striped(s), Strength=2.5)), size=0.8, location=(1.2, 0.7, -1.3))


def veiled():
    """Images whose alpha no node asks for: Cycles shows their colours times alpha."""
    plain_room()
    for i, mode in enumerate(("STRAIGHT", "PREMUL")):
        s = Shader(mode)
        node = s.add("TexImage")
        node.interpolation = "Closest"
        node.image = bpy.data.images.new("veil", 8, 8, alpha=True)
        node.image.pixels.foreach_set(numpy.tile(numpy.array([0.8, 0.7, 0.4, 0.5], numpy.float32), 64))
        node.image.pack()
        node.image.alpha_mode = mode
        put("cube", s.done(s.add("BsdfDiffuse", Color=node)), size=1.2, location=(1.6 * i - 0.8, 0.7, -1.3))


def halves(s, space):
    """An image of two colours."""
    node = s.add("TexImage")
    node.interpolation = "Closest"
    name = "halves of " + space
    node.image = bpy.data.images.get(name)
    if node.image is None:
        node.image = bpy.data.images.new(name, 16, 16)
        node.image.colorspace_settings.name = space
        pixels = numpy.ones((16, 16, 4), numpy.float32)
        pixels[:, :8, :3], pixels[:, 8:, :3] = (0.2, 0.6, 0.4), (0.8, 0.4, 0.2)
        node.image.pixels.foreach_set(pixels.ravel())
        node.image.pack()
    return node


def packed():
    """Roughness and metallic by images: of their luminance, of a channel, inverted; and by more than a channel, which is baked."""
    plain_room()
    s = Shader("luminance")
    put("cube", s.done(s.add("BsdfPrincipled", Roughness=halves(s, "Non-Color"), Metallic=1.0)), size=1.0, location=(-1.1, 0.7, -1.3))
    s = Shader("inverted")
    image = halves(s, "sRGB")
    split, invert = s.add("SeparateColor", Color=image), s.add("Invert", Color=image)
    bsdf = s.add("BsdfPrincipled", Roughness=invert, Metallic=split.outputs["Blue"])
    put("cube", s.done(bsdf), size=1.0, location=(0.2, 0.7, -1.3))
    s = Shader("bent")
    image = halves(s, "Non-Color")
    image.interpolation = "Linear"
    put("cube", s.done(s.add("BsdfPrincipled", Roughness=s.add("Gamma", Color=image, Gamma=2.0))), size=0.8, location=(1.2, 0.7, -1.3))


def asked():
    """Colours and numbers that a material asks its objects for, by a custom property, by a property of Blender's, and by one that is not
    there; light ends by Blender's own limits."""
    cycles = bpy.context.scene.cycles
    cycles.diffuse_bounces, cycles.glossy_bounces, cycles.blur_glossy, cycles.sample_clamp_indirect = 4, 4, 1.0, 10.0
    plain_room()
    s = Shader("asked")
    nodes = [s.add("Attribute"), s.add("Attribute"), s.add("Attribute")]
    for node, name in zip(nodes, ("tint", "color", "absent")):
        node.attribute_type, node.attribute_name = "OBJECT", name
    half = s.mix(0.5, s.add("BsdfDiffuse", Color=nodes[0].outputs["Color"]), s.add("BsdfDiffuse", Color=nodes[1].outputs["Color"]))
    material = s.done(s.mix(nodes[2].outputs["Fac"], half, s.add("Emission")))
    for i, tint in enumerate(([0.1, 0.7, 0.7], [0.8, 0.2, 0.1])):
        o = put("cube", material, size=1.2, location=(1.6 * i - 0.8, 0.7, -1.3))
        o["tint"], o.color = tint, (0.9, 0.9, 0.1 + 0.8 * i, 1.0)


def mapped():
    """Colours by maths on an image, on a mesh with a modifier, seen twice; and vertex colours."""
    plain_room()
    s = Shader("stripes")
    gamma = s.add("Gamma", Color=striped(s), Gamma=2.0)
    block = put("cube", s.done(s.add("BsdfDiffuse", Color=gamma)), size=1.2, location=(-0.7, 0.6, -1.2))
    block.modifiers.new("round", "BEVEL").width = 0.1
    twin = block.copy()
    twin.location = (0.9, 0.9, -1.3)
    bpy.context.scene.collection.objects.link(twin)
    s = Shader("painted")
    ball = put("uv_sphere", s.done(s.add("BsdfDiffuse", Color=s.add("VertexColor").outputs["Color"])), radius=0.5, location=(0.0, -0.5, -1.4))
    ball.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
    for v, c in zip(ball.data.vertices, ball.data.color_attributes[0].data):
        c.color = (0.9 if v.co.z > 0.0 else 0.1, 0.3, 0.2, 1.0)


def glass():
    plain_room(strength=1.0, size=3.6)
    s = Shader("glass")
    put("uv_sphere", s.done(s.add("BsdfGlass", IOR=1.45, Roughness=0.0)), segments=48, ring_count=24, radius=0.6, location=(-0.7, 0.3, -0.8))
    bpy.ops.object.shade_smooth()
    s = Shader("frosted")
    rough = s.add("BsdfGlass", IOR=1.5, Roughness=0.4)
    if rough.distribution == "MULTI_GGX":  # as in Blender 4, whose light the facets here lose
        rough.distribution = "GGX"
    put("cube", s.done(rough), size=0.9, location=(0.8, 0.6, -1.2))


def transparent():
    plain_room()
    s = Shader("veil")
    see = s.add("BsdfTransparent")
    put("plane", s.done(s.mix(0.4, see, s.add("BsdfDiffuse", Color=(0.9, 0.2, 0.1, 1.0)))), size=2.4, location=(0.0, 0.2, -0.3)).rotation_euler = (1.4, 0.2, 0.0)
    s = Shader("net")
    checker = s.add("TexChecker", Scale=6.0)
    put("cube", s.done(s.mix(checker.outputs["Fac"], s.add("BsdfTransparent"), s.add("BsdfDiffuse", Color=grey(0.2)))), size=1.0, location=(0.9, 0.9, -1.3))


def emission():
    """Lamps of emission shaders: constant, varying, one-sided, and a share of a mixture."""
    walls = matte(grey(0.5), "wall")
    inwards(put("cube", walls, size=2.0 * ROOM))
    s = Shader("glowing noise")
    noise = s.add("TexNoise", Scale=2.0)
    panel(s.done(s.add("Emission", Color=noise.outputs["Color"], Strength=6.0)), 1.4, location=(0.0, 1.0, ROOM - 0.05))
    s = Shader("half glowing")
    put("uv_sphere", s.done(s.mix(0.5, s.add("Emission", Color=(0.2, 0.5, 1.0, 1.0), Strength=3.0), s.add("BsdfDiffuse", Color=grey(0.8)))), radius=0.4, location=(-0.8, 0.5, -1.2))
    s = Shader("one side")
    back = s.add("NewGeometry").outputs["Backfacing"]
    panel(s.done(s.mix(back, s.add("Emission", Strength=5.0), s.add("BsdfDiffuse", Color=grey(0.0)))), 0.8, location=(1.0, 0.8, 0.0))


def no_material():
    """A closed room of Blender's own grey, an empty slot, materials without nodes and without output."""
    walls = room(None)
    walls.data.materials.append(None)
    put("cube", None, size=1.0, location=(-0.7, 0.6, -1.5))
    material = bpy.data.materials.new("no nodes")
    material.diffuse_color = (0.2, 0.6, 0.3, 1.0)
    put("cube", material, size=0.8, location=(0.8, 0.8, -1.6))
    s = Shader("no output")
    s.tree.nodes.remove(s.out)
    put("uv_sphere", s.material, radius=0.4, location=(0.2, -0.4, -1.5))


def groups():
    """Groups within groups, reroutes, muted nodes, several outputs."""
    plain_room()
    inner = bpy.data.node_groups.new("colour", "ShaderNodeTree")
    add_socket(inner, "INPUT", "NodeSocketFloat", "Scale")
    add_socket(inner, "OUTPUT", "NodeSocketColor", "Colour")
    a, b = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    checker = inner.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (0.9, 0.1, 0.1, 1.0), (0.1, 0.1, 0.9, 1.0)
    inner.links.new(a.outputs["Scale"], checker.inputs["Scale"])
    inner.links.new(checker.outputs["Color"], b.inputs["Colour"])
    group = bpy.data.node_groups.new("surface", "ShaderNodeTree")
    add_socket(group, "INPUT", "NodeSocketFloat", "Scale")
    add_socket(group, "OUTPUT", "NodeSocketShader", "Surface")
    a, b = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    colour, shader = group.nodes.new("ShaderNodeGroup"), group.nodes.new("ShaderNodeBsdfDiffuse")
    colour.node_tree = inner
    group.links.new(a.outputs["Scale"], colour.inputs["Scale"])
    group.links.new(colour.outputs["Colour"], shader.inputs["Color"])
    group.links.new(shader.outputs[0], b.inputs["Surface"])
    s = Shader("grouped")
    node = s.tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Scale"].default_value = 4.0
    reroute = s.tree.nodes.new("NodeReroute")
    s.tree.links.new(node.outputs[0], reroute.inputs[0])
    muted = s.add("MixShader")
    muted.mute = True
    s.feed(muted.inputs[1], reroute.outputs[0])
    s.feed(muted.inputs[2], s.add("Emission", Strength=50.0))
    other = s.add("OutputMaterial")
    s.feed(other.inputs["Surface"], s.add("Emission", Strength=100.0))
    other.is_active_output = False
    s.out.is_active_output = True
    put("cube", s.done(muted), size=1.6, location=(0.0, 0.8, -1.2))


def other_rays():
    """Lamps that the camera sees otherwise, or not at all; windows that let shadow rays pass, by nodes and by the object."""
    inwards(put("cube", matte(grey(0.6), "wall"), size=2.0 * ROOM))
    s = Shader("dimmed")
    path = s.add("LightPath").outputs
    strength = s.math("Math", "SUBTRACT", 9.0, s.add("MapRange", Value=path["Is Camera Ray"], To_Max=8.0))
    panel(s.done(s.add("Emission", Strength=strength)), 0.8, location=(0.9, 0.4, ROOM - 0.02))
    s = Shader("unseen")
    seen = s.add("LightPath").outputs["Is Camera Ray"]
    panel(s.done(s.mix(seen, s.add("Emission", Strength=6.0), s.add("BsdfTransparent"))), 0.8, location=(-0.9, 0.4, ROOM - 0.02))
    s = Shader("window")
    path = s.add("LightPath").outputs
    either = s.math("Math", "MAXIMUM", path["Is Shadow Ray"], path["Is Diffuse Ray"])
    put("cube", s.done(s.mix(either, s.add("BsdfGlass", Roughness=0.0, IOR=1.45), s.add("BsdfTransparent"))), size=1.0,
        location=(0.8, 0.4, 0.5)).scale = (1.4, 1.4, 0.02)
    s = Shader("glass")
    pane = put("cube", s.done(s.add("BsdfGlass", Roughness=0.0, IOR=1.45)), size=1.0, location=(-0.8, 0.4, 0.9))
    pane.scale, pane.visible_shadow = (1.4, 1.4, 0.02), False
    s = Shader("facade")
    put("plane", s.done(s.mix(s.add("Fresnel", IOR=1.4), s.add("BsdfTransparent", Color=(0.8, 0.9, 1.0, 1.0)), s.add("BsdfGlossy", Roughness=0.0))), size=1.0,
        location=(0.0, 1.0, -0.8)).rotation_euler = (1.2, 0.0, 0.0)
    s = Shader("marble")
    both = s.mix(s.add("Fresnel", IOR=1.35), s.add("BsdfRefraction", IOR=1.35, Roughness=0.0), s.add("BsdfGlossy", Roughness=0.0, Color=grey(1.0)))
    put("uv_sphere", s.done(both), radius=0.2, location=(0.0, 0.4, -1.6))


def lamps():
    """Area lamps, one with nodes, a portal, a spot, and a point with the colour of a black body. Area lamps are small: here
    they take the light that falls on them, which in Cycles passes."""
    inwards(put("cube", matte(grey(0.6), "wall"), size=2.0 * ROOM))
    shapes = ("SQUARE", (-1.0, 0.6)), ("DISK", (0.0, 0.6)), ("ELLIPSE", (1.0, 0.6)), ("RECTANGLE", (0.0, -0.6))
    for shape, (x, y) in shapes:
        o = lamp("AREA", "AREA", (x, y, ROOM - 0.02), energy=30.0)
        o.data.shape, o.data.size, o.data.size_y = shape, 0.4, 0.25
        o.data.cycles.is_portal = shape == "RECTANGLE"
    o.data.energy = 1e4  # which a portal does not give
    kelvin = nodes_of(lamp("POINT", "POINT", (-0.8, -0.5, 0.5), energy=20.0, shadow_soft_size=0.0), 1.5)
    node = kelvin.id_data.nodes.new("ShaderNodeBlackbody")
    node.inputs[0].default_value = 3000.0
    kelvin.id_data.links.new(node.outputs[0], kelvin.inputs["Color"])
    nodes_of(bpy.data.objects["AREA"], 2.0).inputs["Color"].default_value = (0.2, 1.0, 0.5, 1.0)
    lamp("SPOT", "SPOT", (0.6, 0.2, 1.0), energy=300.0, shadow_soft_size=0.0, spot_size=1.4, spot_blend=0.4)


def nodes_of(o, strength):
    _, emission = lamp_nodes(o)
    emission.inputs["Strength"].default_value = strength
    return emission


def principled():
    """Blender's own material on all walls: its coat takes nothing from the base. A closed room shows it with every bounce."""
    s = Shader("wall")
    room(s.done(s.add("BsdfPrincipled", Base_Color=grey(0.6))))
    s = Shader("polished")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=(0.7, 0.3, 0.1, 1.0), Roughness=0.2, Specular=0.8)), size=1.2, location=(-0.7, 0.6, -1.3))
    s = Shader("dull")
    put("uv_sphere", s.done(s.add("BsdfPrincipled", Base_Color=(0.1, 0.3, 0.7, 1.0), Roughness=1.0, Specular=0.0)), radius=0.5, location=(0.8, 0.6, -1.4))


def rough_principled():
    """Rough Principled on all walls, rough metal and gloss, and a clear coat."""
    s = Shader("wall")
    room(s.done(s.add("BsdfPrincipled", Base_Color=grey(0.6), Roughness=0.8)), strength=3.0, size=2.0)
    s = Shader("cast")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=grey(0.7), Metallic=1.0, Roughness=0.9)), size=1.4, location=(-0.9, 0.6, -1.2))
    s = Shader("brushed")
    put("cube", s.done(gloss_of(s, 0.9, grey(0.7))), size=1.2, location=(0.9, 0.8, -1.3))
    s = Shader("lacquer")
    node = s.add("BsdfPrincipled", Base_Color=(0.6, 0.05, 0.03, 1.0), Clearcoat=1.0)
    put("uv_sphere", s.done(node), radius=0.5, location=(0.1, -0.4, -1.4))


def mixed_glass():
    """A slab that is diffuse in part, and a bulb above it: a sphere, whose light comes through glass."""
    inwards(put("cube", matte(grey(0.6), "wall"), size=2.0 * ROOM))
    s = Shader("sandblasted")
    glass = s.add("BsdfGlass", Roughness=0.1, IOR=1.45)
    glass.distribution = "GGX"
    put("cube", s.done(s.mix(0.3, glass, s.add("BsdfDiffuse", Color=grey(0.9)))), size=1.0, location=(0.0, 0.6, 0.4)).scale = (3.0, 0.05, 3.0)
    bulb = lamp("POINT", "POINT", (0.0, -ROOM + 0.8, ROOM - 0.3), energy=100.0, shadow_soft_size=0.25)
    if hasattr(bulb.data, "use_soft_falloff"):
        bulb.data.use_soft_falloff = False


def gloss_of(s, roughness, colour=(1.0, 1.0, 1.0, 1.0)):
    return s.add("BsdfGlossy", Roughness=roughness, Color=colour)


def shares_of_gloss():
    """Diffuse and gloss of two colours in fixed shares: constant, of an image, tinted, of Principled, added, mixed again."""
    s = Shader("wall")
    room(s.done(s.mix(0.3, s.add("BsdfDiffuse", Color=(0.7, 0.3, 0.2, 1.0)), gloss_of(s, 0.4, grey(0.9)))))
    s = Shader("printed")
    put("cube", s.done(s.mix(0.3, s.add("BsdfDiffuse", Color=striped(s)), gloss_of(s, 0.3))), size=1.2, location=(-1.2, 0.7, -1.3))
    s = Shader("tinted")
    dull = s.add("BsdfPrincipled", Base_Color=(0.2, 0.5, 0.7, 1.0), Roughness=0.1, Specular=0.0)
    put("uv_sphere", s.done(s.mix(0.4, gloss_of(s, 0.2, (0.9, 0.5, 0.1, 1.0)), dull)), radius=0.5, location=(0.1, 0.7, -1.4))
    s = Shader("sum")
    both = s.sum(s.add("BsdfDiffuse", Color=(0.1, 0.5, 0.2, 1.0)), gloss_of(s, 0.1, grey(0.3)))
    put("cube", s.done(s.mix(0.5, both, s.add("BsdfDiffuse", Color=(0.6, 0.1, 0.5, 1.0)))), size=0.9, location=(1.3, 0.9, -1.4))


def gloss_by_fresnel():
    """Diffuse under gloss by Fresnel's factor: constant, of an image, tinted, of Principled, mixed again."""
    s = Shader("wall")
    room(s.done(s.mix(s.add("Fresnel", IOR=1.5), s.add("BsdfDiffuse", Color=(0.6, 0.5, 0.4, 1.0)), gloss_of(s, 0.3))))
    s = Shader("printed")
    put("cube", s.done(s.mix(s.add("Fresnel", IOR=1.5), s.add("BsdfDiffuse", Color=striped(s)), gloss_of(s, 0.5))), size=1.2,
        location=(-1.2, 0.7, -1.3))
    s = Shader("tinted")
    dull = s.add("BsdfPrincipled", Base_Color=(0.2, 0.5, 0.7, 1.0), Roughness=0.9, Specular=0.0)
    put("uv_sphere", s.done(s.mix(s.add("Fresnel", IOR=2.0), dull, gloss_of(s, 0.2, (0.9, 0.5, 0.1, 1.0)))), radius=0.5,
        location=(0.1, 0.7, -1.4))
    s = Shader("half")
    coated = s.mix(s.add("LayerWeight", Blend=0.4).outputs["Fresnel"], s.add("BsdfDiffuse", Color=(0.1, 0.5, 0.2, 1.0)), gloss_of(s, 0.1))
    put("cube", s.done(s.mix(0.5, coated, s.add("BsdfDiffuse", Color=(0.6, 0.1, 0.5, 1.0)))), size=0.9, location=(1.3, 0.9, -1.4))


def furnace():
    """White balls in uniform white light: whatever reflects more than arrives is brighter than what is behind it."""
    world = bpy.data.worlds.new("white")
    give_nodes(world)
    world.node_tree.nodes["Background"].inputs[0].default_value = grey(1.0)
    bpy.context.scene.world = world
    for i, roughness in enumerate((0.1, 0.6)):
        where = {"radius": 0.45, "segments": 48, "ring_count": 24}
        fixed, sheer, added = Shader("fixed %d" % i), Shader("sheer %d" % i), Shader("added %d" % i)
        added.done(added.sum(added.add("BsdfDiffuse", Color=grey(0.6)), gloss_of(added, roughness, grey(0.4))))
        fixed.done(fixed.mix(0.3, fixed.add("BsdfDiffuse", Color=grey(1.0)), gloss_of(fixed, roughness, grey(0.99))))
        sheer.done(sheer.mix(sheer.add("Fresnel", IOR=1.8), sheer.add("BsdfDiffuse", Color=grey(1.0)), gloss_of(sheer, roughness)))
        for k, s in enumerate((fixed, sheer, added)):
            put("uv_sphere", s.material, location=(1.0 * k - 0.8, 0.5, 0.6 - i), **where)
            bpy.ops.object.shade_smooth()


def clear(name, ior=1.45):
    s = Shader(name)
    return s.done(s.add("BsdfGlass", IOR=ior, Roughness=0.0))


def box(material, where, size, turn=0.0):
    o = put("cube", material, size=1.0, location=where)
    o.scale, o.rotation_euler = size, (turn, 0.0, 0.0)
    return o


def panes():
    """Thin boxes of glass: a window held by a frame, double and mirrored, the cover of a picture, one turned and of dense glass."""
    plain_room(strength=3.0, size=1.6)
    window = box(clear("window"), (-0.9, 0.3, 0.4), (1.6, 0.02, 2.0))
    for z in (-0.55, 1.35):
        box(matte(grey(0.3), "frame"), (-0.9, 0.3, z), (1.7, 0.1, 0.15))
    box(window.data.materials[0], (-0.9, 0.36, 0.4), (-1.6, 0.02, 2.0))
    s = Shader("picture")
    put("plane", s.done(s.add("BsdfDiffuse", Color=striped(s))), size=1.4, location=(0.9, 1.9, 0.2), rotation=(1.5708, 0.0, 0.0))
    box(clear("cover"), (0.9, 1.87, 0.2), (1.5, 0.02, 1.5))
    box(clear("dense", 2.0), (0.6, 0.4, -1.0), (1.6, 0.02, 1.2), 0.6)


def odd_glass():
    """Glass that refracts what is seen through it, or in which something lies: not panes."""
    plain_room()
    for v in box(clear("wedge"), (-1.2, 0.5, 1.0), (1.0, 0.015, 1.0)).data.vertices:
        v.co.y += 1.0 if v.co.x > 0.0 and v.co.y > 0.0 else 0.0
    put("uv_sphere", clear("lens"), radius=0.5, segments=64, ring_count=32, location=(0.0, 0.5, 1.0)).scale = (1.0, 0.015, 1.0)
    box(clear("thick"), (1.2, 0.5, 1.0), (1.0, 0.05, 1.0))
    box(clear("strip"), (1.8, 0.5, 1.0), (0.02, 0.006, 1.5))
    box(clear("tank"), (-1.2, 0.5, -0.5), (1.0, 0.01, 1.0))
    box(clear("water", 1.33), (-1.2, 0.705, -0.5), (1.0, 0.4, 1.0))
    s = Shader("silver")
    silver = s.done(s.add("BsdfGlossy", Roughness=0.0))
    put("plane", silver, size=1.0, location=(0.0, 0.5052, -0.5), rotation=(1.5708, 0.0, 0.0))
    box(clear("mirror"), (0.0, 0.5, -0.5), (1.0, 0.01, 1.0))
    put("plane", silver, size=1.0, location=(1.2, 0.5, -0.5), rotation=(1.5708, 0.0, 0.0))
    box(clear("paperweight"), (1.2, 0.5, -0.5), (1.0, 0.01, 1.0))


def for_eevee():
    """What materials say of culling and clipping, which Cycles ignores: an emitter seen from behind, and leaves."""
    room(matte(grey(0.5), "walls"), strength=2.0)
    for name, turn, sets in (("glow", 1.5708, {"Emission": (1.0, 0.6, 0.3, 1.0), "Emission Strength": 2.0}),
                             ("back", -1.5708, {"Emission": (0.3, 0.6, 1.0, 1.0), "Emission Strength": 2.0}),
                             ("leaf", 1.2, {"Base Color": (0.2, 0.7, 0.2, 1.0), "Alpha": 0.3, "Specular": 0.0})):
        material = bpy.data.materials.new(name)
        give_nodes(material)
        material.use_backface_culling = True
        material.blend_method, material.alpha_threshold = "CLIP", 0.5
        for which, value in sets.items():
            socket(material.node_tree.nodes["Principled BSDF"], which).default_value = value
        where = {"glow": (-1.0, 0.5, 0.2), "back": (1.0, 0.5, 0.2), "leaf": (0.0, 0.0, -0.5)}[name]
        bpy.ops.mesh.primitive_plane_add(size=0.8, location=where, rotation=(turn, 0.0, 0.0))
        bpy.context.object.data.materials.append(material)


def curtains():
    """A lamp above a curtain from wall to wall; below it a shade and leaves cut out of half of their light."""
    plain_room(strength=30.0, size=3.0)
    s = Shader("curtain")
    put("plane", s.done(s.mix(0.6, s.add("BsdfDiffuse", Color=(0.8, 0.7, 0.5, 1.0)), s.add("BsdfTranslucent", Color=(0.9, 0.6, 0.4, 1.0)))),
        size=2.02 * ROOM, location=(0.0, 0.0, 1.2))
    s = Shader("shade")
    put("uv_sphere", s.done(s.add("BsdfTranslucent", Color=grey(0.8))), radius=0.5, location=(-0.6, 0.2, -1.2))
    s = Shader("leaf")
    leaf = s.mix(0.4, s.add("BsdfDiffuse", Color=(0.2, 0.5, 0.1, 1.0)), s.add("BsdfTranslucent", Color=(0.5, 0.8, 0.1, 1.0)))
    put("plane", s.done(s.mix(0.5, s.add("BsdfTransparent"), leaf)), size=0.8, location=(0.5, -0.2, -0.8))


def left_out():
    """What can only be named."""
    plain_room()
    s = Shader("skin")
    put("uv_sphere", s.done(s.add("BsdfPrincipled", Subsurface=0.5, Sheen=1.0, Anisotropic=0.3)), radius=0.4, location=(-1.0, 0.6, -1.4))
    s = Shader("fog")
    put("cube", s.done(s.add("BsdfTransparent"), Volume=s.add("VolumePrincipled")), size=0.8, location=(0.0, 0.6, -1.4))
    s = Shader("moving")
    shader = s.add("BsdfDiffuse")
    shader.inputs["Color"].driver_add("default_value", 0).driver.expression = "frame * 0.01"
    put("cube", s.done(shader), size=0.6, location=(1.0, 0.6, -1.5))
    s = Shader("rough")
    noise = s.add("TexNoise", Scale=20.0)
    bump = s.add("Bump", Height=noise.outputs["Fac"])
    put("plane", s.done(s.add("BsdfDiffuse", Normal=bump), Displacement=s.add("Displacement", Height=noise.outputs["Fac"])), size=2.0, location=(0.0, 0.0, -1.9))
    s = Shader("toon")
    put("cube", s.done(s.add("BsdfToon", Color=(0.9, 0.1, 0.1, 1.0))), size=0.4, location=(0.4, -0.8, -1.6))
    bpy.ops.object.mode_set(mode="EDIT")  # in which the file is saved


def layered():
    """Of Blender 4: rough metals, coats, tints, the Metallic node, and an image under a coat."""
    gold = (0.9, 0.6, 0.25, 1.0)
    s = Shader("wall")
    room(s.done(s.add("BsdfPrincipled", Base_Color=grey(0.5), Roughness=0.7)), strength=3.0, size=2.0)
    s = Shader("rough gold")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=gold, Metallic=1.0, Roughness=0.8)), size=1.0, location=(-1.2, 0.7, -1.4))
    s = Shader("half gold")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=gold, Metallic=0.5, Roughness=0.4, Specular_Tint=(0.3, 0.5, 1.0, 1.0))), size=0.8, location=(0.0, 1.0, -1.5))
    s = Shader("varnish")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=grey(0.8), Coat_Weight=1.0, Coat_IOR=1.4, Coat_Tint=gold)), size=0.8, location=(1.2, 0.9, -1.5))
    s = Shader("copper")
    metal = s.tree.nodes.new("ShaderNodeBsdfMetallic")
    metal.fresnel_type = "PHYSICAL_CONDUCTOR"
    metal.inputs["IOR"].default_value, metal.inputs["Extinction"].default_value = (0.27, 0.68, 1.32), (3.6, 2.6, 2.3)
    metal.inputs["Roughness"].default_value = 0.6
    put("uv_sphere", s.done(metal), radius=0.4, location=(-0.4, -0.2, -1.6))
    s = Shader("dense")
    put("cube", s.done(s.add("BsdfPrincipled", Base_Color=striped(s), IOR=2.0, Roughness=0.2)), size=0.7, location=(0.6, -0.1, -1.6))


def named():
    """Of Blender 4: what can only be named."""
    plain_room()
    for name, sets in (("film", {"Thin_Film_Thickness": 400.0}), ("skin", {"Subsurface": 0.5}), ("brushed", {"Anisotropic": 0.5, "Metallic": 1.0}),
                       ("clay", {"Diffuse_Roughness": 1.0}), ("bottle", {"Transmission_Weight": 0.5}), ("cloth", {"Sheen": 0.5})):
        s = Shader(name)
        put("cube", s.done(s.add("BsdfPrincipled", **sets)), size=0.4, location=(0.3, 0.3, -1.5))
    s = Shader("satin")
    put("cube", s.done(s.add("BsdfSheen", Roughness=0.8)), size=0.4, location=(0.9, 0.9, -1.5))
    s = Shader("scratched")
    metal = s.add("BsdfPrincipled", Metallic=1.0, Roughness=s.add("TexNoise").outputs["Fac"])
    put("cube", s.done(metal), size=0.4, location=(0.3, 0.9, -1.5))


def set_up():
    begin(size=(24, 18))
    camera = eye((0.2, -ROOM + 0.1, 0.1), (1.45, 0.0, 0.05), "eye")
    camera.data.lens, camera.data.clip_start = 20.0, 0.01
