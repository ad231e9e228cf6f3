"""Small scenes of surfaces that glTF's extensions carry, for test_blender_surfaces.c."""
import bpy

from blender_materials import ROOM, gloss_of, plain_room, put, room, set_up, striped  # noqa: F401
from blender_words import Shader, grey


def ramp(s, factor, *stops):
    node = s.add("ValToRGB", Fac=factor)
    for element, (position, colour) in zip(node.color_ramp.elements, stops):
        element.position, element.color = position, colour
    return node.outputs["Color"]


def ball(material, where, radius=0.5):
    o = put("uv_sphere", material, radius=radius, segments=48, ring_count=24, location=where)
    bpy.ops.object.shade_smooth()
    return o


def by_angle():
    """Ramps of the angle: of a colour, of a share of gloss, of emission; the cosine made by hand; two that differ in colours alone."""
    s = Shader("wall")
    facing = s.add("LayerWeight", Blend=0.5).outputs["Facing"]
    colour = ramp(s, facing, (0.1, (0.3, 0.3, 0.3, 1.0)), (0.9, (0.9, 0.7, 0.5, 1.0)))
    room(s.done(s.add("BsdfDiffuse", Color=colour)), strength=3.0, size=2.0)
    s = Shader("lacquer")
    share = ramp(s, s.add("LayerWeight", Blend=0.4).outputs["Facing"], (0.0, grey(0.05)), (1.0, grey(0.8)))
    ball(s.done(s.mix(share, s.add("BsdfDiffuse", Color=(0.1, 0.3, 0.6, 1.0)), gloss_of(s, 0.3))), (-0.8, 0.5, -1.4))
    s = Shader("rim")
    glow = s.add("Emission", Color=ramp(s, s.add("Fresnel", IOR=1.4).outputs[0], (0.0, grey(0.0)), (0.5, (1.0, 0.5, 0.1, 1.0))))
    both = s.sum(s.add("BsdfDiffuse", Color=grey(0.3)), glow)
    ball(s.done(both), (0.4, 0.7, -1.4))
    s = Shader("by hand")
    geometry = s.add("NewGeometry").outputs
    cosine = s.math("VectorMath", "DOT_PRODUCT", geometry["Normal"], geometry["Incoming"])
    ball(s.done(s.add("BsdfDiffuse", Color=cosine.outputs["Value"])), (1.4, 0.9, -1.4))
    for name, dark, x in (("steep", 0.02, -0.2), ("even", 0.5, 0.9)):
        s = Shader(name)
        facing = s.add("LayerWeight", Blend=0.5).outputs["Facing"]
        ball(s.done(s.add("BsdfDiffuse", Color=ramp(s, facing, (0.0, grey(dark)), (1.0, grey(0.8))))), (x, -0.2, -1.7), 0.25)


def fabrics():
    """Sheen of Principled, velvet, and velvet over what is diffuse."""
    plain_room(strength=3.0, size=2.0)
    s = Shader("cloth")
    cloth = s.add("BsdfPrincipled", Base_Color=(0.5, 0.3, 0.2, 1.0), Roughness=0.8, Sheen=1.0)
    put("cube", s.done(cloth), size=1.2, location=(0.0, 1.2, -1.3))
    s = Shader("velvet")
    name = "BsdfVelvet" if hasattr(bpy.types, "ShaderNodeBsdfVelvet") else "BsdfSheen"
    velvet = s.add(name, Color=(0.8, 0.6, 0.4, 1.0))
    velvet.inputs["Sigma" if name == "BsdfVelvet" else "Roughness"].default_value = 0.6
    ball(s.done(velvet), (-1.1, 0.5, -1.4))
    s = Shader("plush")
    both = s.sum(s.add("BsdfDiffuse", Color=(0.1, 0.4, 0.2, 1.0)), s.add(name, Color=grey(0.3)))
    ball(s.done(both), (1.1, 0.6, -1.4))


def bumps():
    """Displacement that only bumps, on all that is seen: by its node and by vectors, beside a bump of the surface itself."""
    def bumpy(name, colour, height, **inputs):
        s = Shader(name)
        noise = s.add("TexNoise", Scale=4.0)
        own = {key: make(s) for key, make in inputs.items()}
        return s.done(s.add("BsdfDiffuse", Color=colour, **own), Displacement=height(s, noise.outputs["Fac"]))

    room(bumpy("wall", grey(0.6), lambda s, h: s.add("Displacement", Height=h, Scale=0.3)))

    def along(s, height):
        return s.math("VectorMath", "SCALE", s.add("NewGeometry").outputs["Normal"], height)

    ball(bumpy("vectors", (0.7, 0.3, 0.2, 1.0), along), (-0.7, 0.5, -1.3))
    ball(bumpy("both", (0.2, 0.5, 0.7, 1.0), lambda s, h: s.add("Displacement", Height=h, Scale=0.2),
               Normal=lambda s: s.add("Bump", Height=s.add("TexChecker", Scale=8.0).outputs["Fac"], Distance=0.1)), (0.8, 0.6, -1.3))


def brushed():
    """Brushed metal around an axis, along coordinates, and turned by an image; a clear coat with bumps; a thin film where there is one."""
    plain_room(strength=3.0, size=2.0)
    name = "BsdfAnisotropic" if hasattr(bpy.types, "ShaderNodeBsdfAnisotropic") else "BsdfGlossy"
    s = Shader("around")
    ball(s.done(s.add("BsdfPrincipled", Base_Color=(0.9, 0.7, 0.4, 1.0), Metallic=1.0, Roughness=0.4, Anisotropic=0.8)), (-1.1, 0.5, -1.4))
    s = Shader("along")
    tangent = s.add("Tangent")
    tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
    put("cube", s.done(s.add(name, Color=grey(0.8), Roughness=0.4, Anisotropy=-0.6, Tangent=tangent)), size=0.9, location=(0.0, 1.1, -1.5))
    s = Shader("turned")
    turn = s.add("SeparateColor", Color=striped(s)).outputs["Red"]
    ball(s.done(s.add(name, Color=grey(0.8), Roughness=0.4, Anisotropy=0.5, Rotation=turn)), (1.1, 0.6, -1.4))
    s = Shader("coat")
    node = s.add("BsdfPrincipled", Base_Color=(0.6, 0.1, 0.05, 1.0), Clearcoat=1.0)
    bump = s.add("Bump", Height=s.add("TexNoise", Scale=4.0).outputs["Fac"], Distance=0.1)
    s.feed(node.inputs.get("Clearcoat Normal") or node.inputs["Coat Normal"], bump)
    if "Thin Film Thickness" in node.inputs:
        node.inputs["Thin Film Thickness"].default_value = 300.0
    ball(s.done(node), (0.2, -0.3, -1.6), 0.35)


def leaves():
    """A lamp above a blind from wall to wall and a leaf; both sides of it by one image, and by an image and a noise."""
    plain_room(strength=30.0, size=3.0)
    s = Shader("blind")
    image = striped(s)
    put("plane", s.done(s.mix(0.5, s.add("BsdfDiffuse", Color=image), s.add("BsdfTranslucent", Color=image))), size=2.02 * ROOM,
        location=(0.0, 0.0, 1.2))
    s = Shader("leaf")
    green = ramp(s, s.add("TexNoise", Scale=3.0).outputs["Fac"], (0.4, (0.1, 0.5, 0.1, 1.0)), (0.6, (0.6, 0.8, 0.1, 1.0)))
    both = s.mix(0.6, s.add("BsdfDiffuse", Color=striped(s)), s.add("BsdfTranslucent", Color=green))
    put("plane", s.done(both), size=1.5, location=(0.3, -0.2, -0.8))


def displaced():
    """A ball with a modifier that is pushed out and in, one that is turned and scaled, and one by vectors, of a colour that varies."""
    plain_room(strength=3.0, size=2.0)

    def put_displaced(name, where, make, **turned):
        s = Shader(name)
        noise = s.add("TexNoise", Scale=1.5)
        own = s.material if "displacement_method" in bpy.types.Material.bl_rna.properties else s.material.cycles
        own.displacement_method = "DISPLACEMENT"
        o = ball(s.done(s.add("BsdfDiffuse", Color=noise.outputs["Color"]), Displacement=make(s, noise.outputs["Fac"])), where)
        for key, value in turned.items():
            setattr(o, key, value)
        return o

    pushed = put_displaced("pushed", (-0.8, 0.5, -1.0), lambda s, h: s.add("Displacement", Height=h, Midlevel=0.5, Scale=2.0))
    pushed.modifiers.new("fine", "SUBSURF")
    put_displaced("turned", (0.4, 0.9, -1.2), lambda s, h: s.add("Displacement", Height=h, Midlevel=0.3, Scale=1.0),
                  rotation_euler=(0.3, 0.5, 0.7), scale=(0.5, 0.8, 1.2))
    put_displaced("lifted", (1.3, 0.3, -1.5), lambda s, h: s.add("VectorDisplacement", Vector=s.add("CombineXYZ", Z=h), Scale=1.5))
