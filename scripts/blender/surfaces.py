"""The Blender side of the comparison of surfaces: renders the frames of a .glb of scenes/make-surfaces.py with Cycles.

  blender -b --factory-startup --python-exit-code 1 -P surfaces.py -- JOB.json

Materials become nodes that mean the same. What Cycles cannot scatter, sheen by Charlie, is computed by nodes where light comes
from one direction or from all alike. The job's "made" lists the materials: {} for an equal, {"differs": WHAT} for a
counterpart of another model, {"absent": WHY} for none. Written for Blender 3.4 and 4.3.
"""

import json
import math
import os
import sys

import bpy
import numpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from blender.cycles import cut_lamps, extension, make_sharp, read_gltf, set_cycles, set_material, set_world, write_animations  # noqa: E402
from blender.versions import is_principled_2, socket  # noqa: E402

COAT_F0 = 0.04
LIT_BELOW = 1.0 - (COAT_F0 + (1.0 - COAT_F0) / 21.0)  # what a coat lets through, of light from all sides


class Absent(Exception):
    """Cycles of this version has no counterpart."""


# Sheen by Charlie, of Conty and Kulla (Production Friendly Microfacet Sheen BRDF, 2017), as KHR_materials_sheen has it. The same
# formulas take numbers of numpy and values of nodes; `m` has the functions.

def sheen_l(m, x, alpha):
    t = (1.0 - alpha) ** 2
    a, b, c, d, e = (high + (low - high) * t for high, low in (
        (21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801), (-1.97760, -1.27393), (-4.32054, -4.85967)))
    return a / (1.0 + b * m.power(x, c)) + d * x + e


def sheen_lambda(m, cosine, alpha):
    half = 2.0 * sheen_l(numpy, 0.5, alpha)
    return m.where(cosine < 0.5, m.exp(sheen_l(m, cosine, alpha)), m.exp(half - sheen_l(m, 1.0 - cosine, alpha)))


def sheen_f(m, cos_o, cos_i, sine_h, alpha):
    """The BRDF; sine_h: of the half vector's angle from the normal."""
    d = (2.0 + 1.0 / alpha) * m.power(sine_h, 1.0 / alpha) / (2.0 * math.pi)
    return d / ((1.0 + sheen_lambda(m, cos_o, alpha) + sheen_lambda(m, cos_i, alpha)) * 4.0 * cos_o * cos_i)


def directional_albedo(alpha, cosines, n=512):
    """What Charlie reflects in all of even light, by the cosine of the view."""
    u, v = numpy.meshgrid((numpy.arange(n) + 0.5) / n, (numpy.arange(n) + 0.5) / n)
    cos_i, phi = u, math.pi * v
    sin_i = numpy.sqrt(1.0 - cos_i * cos_i)
    found = []
    for cos_o in cosines:
        along = cos_o + cos_i
        across2 = (1.0 - cos_o * cos_o) + sin_i * sin_i + 2.0 * math.sqrt(1.0 - cos_o * cos_o) * sin_i * numpy.cos(phi)
        sine_h = numpy.sqrt(across2 / (along * along + across2))
        found.append(2.0 * math.pi * float(numpy.mean(sheen_f(numpy, cos_o, cos_i, sine_h, alpha) * cos_i)))
    return numpy.array(found)


def schlick(m, cosine):
    return COAT_F0 + (1.0 - COAT_F0) * m.power(1.0 - cosine, 5.0)


class Value:
    """A number that nodes compute."""

    def __init__(self, tree, output):
        self.tree, self.output = tree, output

    def then(self, operation, *others):
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for at, other in zip(node.inputs, (self, *others)):
            if isinstance(other, Value):
                self.tree.links.new(other.output, at)
            else:
                at.default_value = other
        return Value(self.tree, node.outputs[0])

    def constant(self, number):
        node = self.tree.nodes.new("ShaderNodeValue")
        node.outputs[0].default_value = number
        return Value(self.tree, node.outputs[0])

    def __add__(self, other):
        return self.then("ADD", other)

    def __sub__(self, other):
        return self.then("SUBTRACT", other)

    def __mul__(self, other):
        return self.then("MULTIPLY", other)

    def __truediv__(self, other):
        return self.then("DIVIDE", other)

    def __lt__(self, other):
        return self.then("LESS_THAN", other)

    def __gt__(self, other):
        return self.then("GREATER_THAN", other)

    def __rsub__(self, other):
        return self.constant(other) - self

    def __rtruediv__(self, other):
        return self.constant(other) / self

    __radd__, __rmul__ = __add__, __mul__


class NodeFunctions:
    """As numpy has them."""
    power = staticmethod(lambda x, y: x.then("POWER", y))
    exp = staticmethod(lambda x: x.then("EXPONENT"))
    minimum = staticmethod(lambda x, y: x.then("MINIMUM", y))
    where = staticmethod(lambda condition, a, b: condition * a + (1.0 - condition) * b)


class Tree:
    """The nodes of one material."""

    def __init__(self, material):
        self.tree = material.node_tree
        self.tree.nodes.clear()

    def add(self, kind, **inputs):
        node = self.tree.nodes.new("ShaderNode" + kind)
        if hasattr(node, "distribution"):
            node.distribution = "GGX"
        for name, value in inputs.items():
            at = socket(node, name.replace("_", " "))
            if isinstance(value, Value):
                self.tree.links.new(value.output, at)
            elif isinstance(value, bpy.types.Node):
                self.tree.links.new(value.outputs[0], at)
            else:
                at.default_value = (*value, 1.0) if isinstance(value, tuple) else value
        return node

    def of_two(self, kind, a, b, factor=None):
        node = self.tree.nodes.new("ShaderNode" + kind)
        for at, value in zip(node.inputs, (a, b) if factor is None else (factor, a, b)):
            if isinstance(value, float):
                at.default_value = value
            else:
                self.tree.links.new(value.output if isinstance(value, Value) else value.outputs[0], at)
        return node

    def mix(self, factor, a, b):
        return self.of_two("MixShader", a, b, factor)

    def vectors(self, operation, a, b=None):
        node = self.tree.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for at, value in zip(node.inputs, (a, b)):
            if isinstance(value, tuple):
                at.default_value = value
            elif value is not None:
                self.tree.links.new(value, at)
        return node

    def geometry(self, name):
        return self.tree.nodes.new("ShaderNodeNewGeometry").outputs[name]

    def dot(self, a, b):
        return Value(self.tree, self.vectors("DOT_PRODUCT", a, b).outputs["Value"])

    def cos_view(self):
        return self.dot(self.geometry("Normal"), self.geometry("Incoming"))

    def emission(self, channels):
        node = self.tree.nodes.new("ShaderNodeCombineXYZ")
        for at, value in zip(node.inputs, channels):
            self.tree.links.new(value.output, at)
        return self.add("Emission", Color=node, Strength=1.0)

    def done(self, shader):
        self.tree.links.new(shader.outputs[0], self.tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])


class Surface:
    """What a material of the .glb says."""

    def __init__(self, description):
        pbr = description["pbrMetallicRoughness"]
        self.is_folded = description["name"] == "cloth"  # folds shade each other, which no formula tells
        of = lambda name, member, default: extension(description, name).get(member, default)  # noqa: E731
        self.color, self.metallic, self.roughness = tuple(pbr["baseColorFactor"][:3]), pbr["metallicFactor"], pbr["roughnessFactor"]
        self.specular, self.ior = of("specular", "specularFactor", 1.0), of("ior", "ior", 1.5)
        self.transmission, self.dispersion = of("transmission", "transmissionFactor", 0.0), of("dispersion", "dispersion", 0.0)
        self.strength, self.turn = of("anisotropy", "anisotropyStrength", 0.0), of("anisotropy", "anisotropyRotation", 0.0)
        self.coat, self.coat_roughness = of("clearcoat", "clearcoatFactor", 0.0), of("clearcoat", "clearcoatRoughnessFactor", 0.0)
        self.film = of("iridescence", "iridescenceFactor", 0.0)
        self.film_ior, self.film_thickness = of("iridescence", "iridescenceIor", 1.3), of("iridescence", "iridescenceThicknessMaximum", 400.0)
        self.sheen, self.sheen_roughness = tuple(of("sheen", "sheenColorFactor", (0.0,) * 3)), of("sheen", "sheenRoughnessFactor", 0.0)
        self.through = of("diffuse_transmission", "diffuseTransmissionFactor", 0.0)
        self.through_color = tuple(of("diffuse_transmission", "diffuseTransmissionColorFactor", (1.0,) * 3))

    def alphas(self):
        """Along the grain and across it."""
        alpha = self.roughness ** 2
        return alpha + (1.0 - alpha) * self.strength ** 2, alpha


def scaled(color, factor):
    return tuple(c * factor for c in color)


def along_the_grain(t, s):
    tangent = t.tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
    return {"Tangent": tangent}, s.turn / (2.0 * math.pi)


def metal(t, s, color):
    along, across = s.alphas()
    if s.film > 0.0:
        raise Absent("no film on metal")
    grain, turn = along_the_grain(t, s)
    if min(s.color) == 1.0:  # reflects all: no Fresnel; of a negative anisotropy the lobe is wide along the tangent
        return t.add("BsdfAnisotropic", Color=color, Roughness=(along * across) ** 0.25,
                     Anisotropy=math.sqrt(across / along) - 1.0, Rotation=turn, **grain)
    if across < 0.1 * along:
        raise Absent("Principled has no such anisotropy")
    return t.add("BsdfPrincipled", Base_Color=color, Metallic=1.0, Roughness=(along * across) ** 0.25,
                 Anisotropic=(1.0 - across / along) / 0.9, Anisotropic_Rotation=turn, **grain)


def film(t, s):
    if "Thin Film Thickness" not in t.add("BsdfPrincipled").inputs:
        raise Absent("no thin film")
    along, across = s.alphas()
    grain, turn = along_the_grain(t, s)
    anisotropic = (1.0 - across / along) / 0.9 if s.strength > 0.0 else 0.0
    return t.add("BsdfPrincipled", Base_Color=s.color, Roughness=(along * across) ** 0.25, Anisotropic=anisotropic,
                 Anisotropic_Rotation=turn, IOR=s.ior, Transmission=s.transmission, Thin_Film_Thickness=s.film_thickness,
                 Thin_Film_IOR=s.film_ior, **grain)


def glass(t, s):
    spread = (s.ior - 1.0) * 0.025 * s.dispersion
    parts = []
    for color, ior in ((s.color, s.ior),) if spread == 0.0 else (
            ((s.color[0], 0.0, 0.0), s.ior - spread), ((0.0, s.color[1], 0.0), s.ior), ((0.0, 0.0, s.color[2]), s.ior + spread)):
        parts.append(t.add("BsdfGlass", Color=color, IOR=ior, Roughness=s.roughness))
        if s.roughness == 0.0:
            make_sharp(parts[-1])
    while len(parts) > 1:
        parts = [t.of_two("AddShader", parts[0], parts[1]), *parts[2:]]
    return parts[0]


def base(t, s, color, through_color):
    lambert = t.add("BsdfDiffuse", Color=color, Roughness=0.0)
    return lambert if s.through == 0.0 else t.mix(s.through, lambert, t.add("BsdfTranslucent", Color=through_color))


def under_coat(t, below, roughness):
    """A layer that reflects by Schlick's Fresnel. Reframe's takes light from what is below on the way in as well: `below` has the
    colour that is as bright in even light."""
    return t.mix(schlick(NodeFunctions, t.cos_view()), below, t.add("BsdfGlossy", Color=(1.0,) * 3, Roughness=roughness))


# Sheen over a Lambert base, under a coat.

def sheen_parts(m, s, cos_o, cos_i, sine_h, albedo):
    """The BRDFs of sheen and base, but for their colours."""
    scale, most = s.sheen_roughness ** 2, max(s.sheen)
    left = m.minimum(1.0 - most * albedo(cos_o), 1.0 - most * albedo(cos_i))
    below = (1.0 - s.coat * schlick(m, cos_o)) * (1.0 - s.coat * schlick(m, cos_i))
    return sheen_f(m, cos_o, cos_i, sine_h, scale) * below, left * below * (1.0 / math.pi)


def polynomial(cosines, values, what):
    """Coefficients for x = 1 - cos, lowest first."""
    fit = numpy.polynomial.Polynomial.fit(1.0 - cosines, values, 12).convert()
    worst = numpy.abs(fit(1.0 - cosines) - values).max()
    if worst > 0.004:
        raise RuntimeError("the polynomial of %s is off by %g" % (what, worst))
    return [float(c) for c in fit.coef]


def horner(coefficients, cosine):
    x = 1.0 - cosine
    sum_of = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        sum_of = x * sum_of + c
    return sum_of


def glossy_f(m, cos_o, cos_i, cos_h, cos_oh, alpha):
    """GGX of the coat, with its Fresnel."""
    d = alpha ** 2 / (math.pi * m.power(1.0 - (1.0 - alpha ** 2) * cos_h * cos_h, 2.0))
    side = lambda c: m.power(alpha ** 2 + (1.0 - alpha ** 2) * c * c, 0.5)  # noqa: E731
    return 0.5 * d / (cos_o * side(cos_i) + cos_i * side(cos_o)) * schlick(m, cos_oh)


def cloth_by_formula(t, s, light):
    cosines = numpy.linspace(0.01, 1.0, 100)
    charlie = polynomial(cosines, directional_albedo(s.sheen_roughness ** 2, cosines), "Charlie")
    albedo = lambda cosine: horner(charlie, cosine)  # noqa: E731
    if light == "even":
        return t.emission([horner(p, t.cos_view()) for p in brightness(s, cosines, albedo)])
    sun = next(o for o in bpy.context.scene.objects if o.type == "LIGHT")
    way = tuple(sun.matrix_world.to_3x3().col[2])
    normal, incoming = t.geometry("Normal"), t.geometry("Incoming")
    cos_o, cos_i = t.dot(normal, incoming), t.dot(normal, way)
    half = t.vectors("NORMALIZE", t.vectors("ADD", incoming, way).outputs[0]).outputs[0]
    sine_h = Value(t.tree, t.vectors("LENGTH", t.vectors("CROSS_PRODUCT", normal, half).outputs[0]).outputs["Value"])
    m = NodeFunctions
    sheen, below = sheen_parts(m, s, cos_o, cos_i, sine_h, albedo)
    coat = s.coat * glossy_f(m, cos_o, cos_i, t.dot(normal, half), t.dot(incoming, half), s.coat_roughness ** 2) if s.coat else 0.0
    lit = (0.0 < cos_i) * cos_i * sun.data.energy
    return t.emission([(sheen * a + below * b + coat) * lit for a, b in zip(s.sheen, s.color)])


def brightness(s, cosines, albedo, n=256):
    """What the cloth reflects in even light of radiance 1 by the cosine of the view: polynomials for the channels."""
    u, v = numpy.meshgrid((numpy.arange(n) + 0.5) / n, (numpy.arange(n) + 0.5) / n)
    rows = []
    for cos_o in cosines:
        across2 = (1.0 - cos_o * cos_o) + (1.0 - u * u) + 2.0 * math.sqrt(1.0 - cos_o * cos_o) * numpy.sqrt(1.0 - u * u) * numpy.cos(math.pi * v)
        sine_h = numpy.sqrt(across2 / ((cos_o + u) ** 2 + across2))
        sheen, below = sheen_parts(numpy, s, cos_o, u, sine_h, albedo)
        parts = [2.0 * math.pi * float(numpy.mean(p * u)) for p in (sheen, below)]
        rows.append([a * parts[0] + b * parts[1] + s.coat * schlick(numpy, cos_o) for a, b in zip(s.sheen, s.color)])
    return [polynomial(cosines, numpy.array(channel), "cloth") for channel in zip(*rows)]


def cloth(t, s, light):
    """The shader, and how it differs."""
    if light == "sun" or light == "even" and not s.is_folded:
        limited = s.sheen_roughness < 0.28  # see src/bsdf/layered.c
        return cloth_by_formula(t, s, light), {"differs": "reflects more than falls in"} if limited else {}
    if s.coat > 0.0:
        raise Absent("no Charlie under a coat")
    if is_principled_2(t.add("BsdfPrincipled")):
        return t.add("BsdfPrincipled", Base_Color=s.color, Roughness=1.0, Specular=0.0, Sheen=1.0, Sheen_Tint=s.sheen,
                     Sheen_Roughness=s.sheen_roughness), {"differs": "sheen after Zeltner"}
    velvet = t.add("BsdfVelvet", Color=s.sheen, Sigma=s.sheen_roughness)
    return t.of_two("AddShader", velvet, base(t, s, s.color, BLACK)), {"differs": "sheen after Ashikhmin"}


BLACK = (0.0, 0.0, 0.0)
ONE_WAY = {"differs": "the coat takes light on the way out alone"}


def shader_of(t, s, light):
    """The shader, and how it differs."""
    if max(s.sheen) > 0.0:
        return cloth(t, s, light)
    if s.transmission > 0.0 and light == "sun":
        raise Absent("glass throws no light of a sun on itself")
    if s.film > 0.0 and s.metallic == 0.0:
        return film(t, s), {"differs": "Schlick's Fresnel at both sides of the film, another fit of its colours"}
    if s.transmission > 0.0:
        return glass(t, s), {}
    if s.metallic == 1.0:
        if s.coat == 0.0:
            return metal(t, s, s.color), {}
        return under_coat(t, metal(t, s, scaled(s.color, LIT_BELOW)), s.coat_roughness), ONE_WAY
    if s.specular == 0.0:
        return base(t, s, s.color, s.through_color), {}
    return under_coat(t, base(t, s, scaled(s.color, LIT_BELOW), scaled(s.through_color, LIT_BELOW)), s.roughness), ONE_WAY


def replace(description, light):
    """Gives a material its nodes; returns what is told of it."""
    material = bpy.data.materials[description["name"]]
    if max(description.get("emissiveFactor", BLACK)) > 0.0:
        set_material(material, description)
        return None
    t, s = Tree(material), Surface(description)
    try:
        shader, told = shader_of(t, s, light)
    except Absent as why:  # what is about as bright, for what is beside it
        shader, told = glass(t, s) if s.transmission > 0.0 else t.add("BsdfDiffuse", Color=s.color), {"absent": str(why)}
    t.done(shader)
    return told


def set_up(job, gltf):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=job["scene"])
    scene = bpy.context.scene
    for o in scene.objects:
        if o.type == "LIGHT":
            o.data.energy, o.data.angle = gltf["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], 0.0
    bpy.context.view_layer.update()
    told = {d["name"]: replace(d, job["light"]) for d in gltf["materials"]}
    cut_lamps({d["name"] for d in gltf["materials"] if max(d.get("emissiveFactor", BLACK)) > 0.0})
    scene.camera = next(o for o in scene.objects if o.type == "CAMERA")
    scene.camera.data.sensor_fit = "VERTICAL"
    scene.camera.data.angle_y = gltf["cameras"][0]["perspective"]["yfov"]
    set_world(scene, job, gltf)
    set_cycles(scene, job)
    scene.render.fps = 24
    scene.frame_start, scene.frame_end = 0, job["frames"] - 1
    return told


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    told = set_up(job, read_gltf(job["scene"]))
    with open(job["made"], "w", encoding="utf-8") as file:
        json.dump(told, file)
    write_animations(bpy.context.scene, job["cycles"])


main()
