"""A shader tree folded into the channels of glTF's material: mixes of shaders become mixes of channels."""
import numpy

from . import cloth, grain, packed
from .channels import BLACK, F0_OF_GLTF, Ref, Surface, WHITE, colour_source, f0_of, is_constant, number_source
from .gloss import (Layers, Shell, as_gloss, as_varnish, gloss_of, gloss_of_3, mean, of_conductor, of_metal, of_rough_diffuse, reflected,
                    schlick, tell_multiple, views)
from .mixtures import as_curtain, as_glass, as_one
from .shader_tree import Values
from .versions import IS_4, is_principled_2, socket

SUBSURFACE = ("subsurface scattering: taken as diffuse: at most 8 % brighter or darker where it is light, 28 % where it is dark, 45 % where "
              "its colour varies or its radius is ten times the body's")
THIN_WALL = ("a thin wall: taken as a thin pane: 16 % brighter or darker at most where it is clear, 29 % where it is rough or partly opaque, "
             "58 % where light scatters below it")
LEFT_OUT = {  # shaders without equivalent, and what is kept of them
    "SUBSURFACE_SCATTERING": SUBSURFACE,
    "BSDF_TOON": "toon shading: taken as diffuse",
    "BSDF_HAIR": "hair: taken as diffuse",
    "BSDF_HAIR_PRINCIPLED": "hair: taken as diffuse",
    "EEVEE_SPECULAR": "a shader of Eevee: taken as diffuse",
    "HOLDOUT": "a holdout: taken as black",
}
# Per cent by which the light of boxes of glass differs, up to each roughness (3.4.1, 5.0.0): multiple scattering loses none in Blender.
ROUGH_GLASS = {
    "GGX": ((0.7, 5), (1.0, 17)),
    "BECKMANN": ((0.3, 5), (0.4, 15), (0.5, 27), (0.7, 42), (1.0, 49)),
    "MULTI_GGX": ((0.3, 15), (0.4, 23), (0.5, 38), (0.7, 60), (1.0, 80)),
}


def not_absorbed(colour, x):
    """The share of what a surface would absorb that leaves a body by its other sides, by the radius over the body's: fitted to white, grey
    and dark balls under a sun."""
    return 0.6 * colour**1.6 * x * x / (x * x + 0.7) if IS_4 else 0.42 * x / (x + 0.75)


class Folder(Values):
    """Surfaces of the shaders of a tree. `size`: the radius of the body that has them; 0: not known."""

    size = 0.0

    def scattered(self, colour, node, scale):
        """A diffuse colour that is about as bright as subsurface scattering; one that varies stays as it is."""
        self.warn(node, SUBSURFACE)
        radii = self.read(node.inputs["Subsurface Radius" if node.type == "BSDF_PRINCIPLED" else "Radius"])
        if self.size <= 0.0 or not all(is_constant(v) for v in (colour, radii, scale)):
            return colour
        inside = [min(max(c, 0.0), 1.0) for c in colour]
        return tuple(c + (1.0 - c) * not_absorbed(c, max(scale * r, 0.0) / self.size) for c, r in zip(inside, radii))

    def fold(self, socket):
        if not socket.is_linked or not socket.links[0].is_valid:
            return Surface(base=BLACK, specular=0.0)
        source = socket.links[0].from_socket
        node = source.node
        if source.type != "SHADER":  # a colour where a shader belongs is emitted
            return Surface(base=BLACK, specular=0.0, emission=self.ref(source))
        if node.type == "MIX_SHADER":
            return self.fold_mix(node)
        if node.type == "ADD_SHADER":
            return self.fold_sum(self.fold(node.inputs[0]), self.fold(node.inputs[1]), node)
        make = getattr(self, "of_" + node.type.lower(), None)
        if make is not None:
            return make(node)
        if node.type not in LEFT_OUT:
            self.warn(node, "its shader is unknown here: taken as black")
            return Surface(base=BLACK, specular=0.0)
        if node.type == "SUBSURFACE_SCATTERING":
            colour = self.scattered(self.read(node.inputs["Color"]), node, self.read(node.inputs["Scale"]))
            return Surface(base=colour, specular=0.0, normal=self.normal_of(node))
        self.warn(node, LEFT_OUT[node.type])
        colour = next((i for i in node.inputs if i.name in ("Color", "Diffuse Color", "Base Color")), None)
        return Surface(base=self.read(colour) if colour is not None and node.type != "HOLDOUT" else BLACK, specular=0.0,
                       normal=self.normal_of(node))

    def normal_of(self, node, name="Normal"):
        socket = node.inputs.get(name)
        value = self.read(socket) if socket is not None and socket.is_linked else None
        return value if isinstance(value, Ref) else None

    def of_bsdf_translucent(self, node):
        colour = self.read(node.inputs["Color"])
        colour = tuple(min(max(c, 0.0), 1.0) for c in colour) if is_constant(colour) else colour
        return Surface(base=colour, specular=0.0, through=1.0, through_colour=colour, normal=self.normal_of(node))

    def make_opaque(self, s, node):
        """For mixtures in which nothing shines through in glTF."""
        if s.through == 0.0:
            return
        self.warn(node, "light that shines through: taken as diffuse")
        s.base = self.blend(s.base, s.through_colour, s.through, True)
        s.through, s.through_colour = 0.0, WHITE

    def of_bsdf_sheen(self, node):
        return sheen(self, node, "Roughness", node.distribution)

    def of_bsdf_velvet(self, node):
        return sheen(self, node, "Sigma", "ASHIKHMIN")

    def of_bsdf_diffuse(self, node):
        roughness, colour = (self.read(node.inputs[name]) for name in ("Roughness", "Color"))
        out = Surface(base=colour, specular=0.0, normal=self.normal_of(node))
        if roughness != 0.0:
            self.warn(node, AS_LAMBERT)
            rough = known(roughness, BETWEEN)
            if is_constant(colour):
                out.base = rough_diffuse(colour, rough)
            else:
                out.scale = rough_diffuse((BETWEEN,), rough)[0] / BETWEEN
        return out

    def of_bsdf_glossy(self, node):
        if "Anisotropy" in node.inputs and node.type == "BSDF_GLOSSY":
            return glossy(self, node)
        if node.type == "BSDF_GLOSSY" and getattr(node, "distribution", "") == "SHARP":
            roughness = 0.0
        else:
            roughness = self.read(node.inputs["Roughness"])
            tell_multiple(self, node)
        out = Surface(base=self.read(node.inputs["Color"]), metallic=1.0, roughness=roughness, normal=self.normal_of(node),
                      scale=gloss_of_3(roughness) if node.distribution == "GGX" else 1.0)
        if "Anisotropy" in node.inputs:
            grain.put_on(self, out, node, self.read(node.inputs["Anisotropy"]), False)
        return out

    def of_bsdf_metallic(self, node):
        return metallic(self, node)

    def of_bsdf_anisotropic(self, node):
        return self.of_bsdf_glossy(node)

    def of_bsdf_glass(self, node):
        self.tell_distribution(node)
        if IS_4 and node.type == "BSDF_GLASS" and self.read(node.inputs["Color"]) != WHITE:
            self.warn(node, "the colour of its reflection: taken as white")
        roughness = 0.0 if node.distribution == "SHARP" else self.read(node.inputs["Roughness"])
        return Surface(base=self.read(node.inputs["Color"]), metallic=0.0, roughness=roughness, specular=1.0, transmission=1.0,
                       ior=self.read(node.inputs["IOR"]), normal=self.normal_of(node))

    def tell_distribution(self, node):
        rough = round(min(known(self.read(node.inputs["Roughness"]), 1.0), 1.0), 3)
        if rough > 0.25 and node.distribution in ROUGH_GLASS:
            most = next(share for largest, share in ROUGH_GLASS[node.distribution] if rough <= largest)
            self.warn(node, "rough glass (%s): up to %d %% brighter or darker than in Blender" % (node.distribution.replace("_", " ").lower(), most))

    def of_bsdf_refraction(self, node):
        self.warn(node, "refraction without reflection: taken as glass")
        return self.of_bsdf_glass(node)

    def of_bsdf_transparent(self, node):
        colour = self.read(node.inputs["Color"])
        if colour == WHITE:
            return Surface(alpha=0.0)
        if not is_constant(colour):
            self.warn(node, "its colour varies: what passes is not tinted")
            return Surface(alpha=0.0)
        # a pane that neither refracts nor reflects, only tints
        return Surface(base=colour, metallic=0.0, roughness=0.0, specular=1.0, transmission=1.0, ior=1.0)

    def of_emission(self, node):
        light = self.times(self.read(node.inputs["Color"]), self.read(node.inputs["Strength"]), True)
        return Surface(base=BLACK, specular=0.0, emission=light)

    of_background = of_emission

    def of_bsdf_principled(self, node):
        if is_principled_2(node):
            return principled(self, node)
        get = lambda name: self.read(node.inputs[name])  # noqa: E731
        tell_multiple(self, node, get("Metallic"))
        if get("Transmission") != 0.0 and (not is_constant(get("Roughness")) or get("Roughness") > 0.25):
            self.warn(node, "rough glass: up to 7 % brighter or darker than in Blender, with a roughness above 0.7 up to a third brighter")
        base = self.blend(get("Base Color"), get("Subsurface Color"), get("Subsurface"), True)
        if get("Subsurface") != 0.0 and get("Metallic") != 1.0:
            base = self.scattered(base, node, get("Subsurface"))
        specular, ior = get("Specular"), get("IOR")
        alpha = get("Alpha")
        light = self.times(get("Emission"), self.times(get("Emission Strength"), alpha), True)
        coat = 0.0 if specular == 0.0 else 1.0  # without it Cycles leaves the lobe out, also at grazing angles
        out = Surface(base=base, metallic=get("Metallic"), roughness=get("Roughness"), specular=coat,
                       f0=self.times(specular, 0.08 / F0_OF_GLTF), transmission=get("Transmission"), ior=ior,
                       clearcoat=get("Clearcoat"), clearcoat_roughness=get("Clearcoat Roughness"), alpha=alpha, emission=light,
                       normal=self.normal_of(node), principled=True)
        grain.put_on(self, out, node, get("Anisotropic"), True)
        put_coat_normal(self, out, node, "Clearcoat Normal")
        if out.clearcoat != 0.0 and out.metallic != 0.0 and is_constant(base) and min(base) < DARK:
            self.warn(node, "a clear coat over metal: colours below 0.1 up to 11 % darker")  # measured under a sun and a white sky
        self.put_sheen(out, node, get("Sheen"), get("Sheen Tint"), get("Base Color"))
        return out

    def put_sheen(self, out, node, weight, tint, base):
        """Of Blender 3, where it is a part of what is diffuse."""
        values = (weight, tint, out.metallic, out.transmission)
        if weight == 0.0:
            return
        if not all(is_constant(v) for v in values):
            self.warn(node, "sheen that varies: left out")
            return
        weight *= (1.0 - out.metallic) * (1.0 - out.transmission)
        if not is_constant(base) and tint > 0.0:
            self.warn(node, "the tint of its sheen: taken as white")
        cloth.tell(self, node)
        cloth.put_on_principled(out, max(weight, 0.0), tint, base)
        out.left = cloth.left(out.sheen, out.sheen_roughness)

    # mixtures

    def fold_mix(self, node):
        factor = node.inputs[0]
        source = factor.links[0].from_socket if factor.is_linked else None
        if (glass := as_glass(self, node, source)) is not None:
            return glass
        a, b = self.fold(node.inputs[1]), self.fold(node.inputs[2])
        if source is not None and source.node.type == "NEW_GEOMETRY" and source.name == "Backfacing":
            return self.by_side(a, b, node)
        one = as_one(self, a, b, source, node) if source is not None else None
        if one is not None:
            return one
        t = self.read(factor)
        if is_constant(t):
            t = min(max(t, 0.0), 1.0)
        else:
            t = self.number("ADD", t, 0.0, clamp=True)
        return self.mixed(a, b, t, node)

    def by_side(self, front, back, node):
        """Two looks of one surface. glTF has emission of the front alone, or of both sides alike, and one look of all else."""
        if front.emission == BLACK and back.emission != BLACK:
            self.lose(node, "its back shines in Blender, not its front: does not shine here: turn the faces round")
        elif back.emission == BLACK and front.emission != BLACK:
            front.one_sided = True
            if back.alpha == 0.0:
                self.warn(node, "its back lets light through in Blender: is black here")
            elif (back.base, back.transmission) != (front.base, front.transmission):
                self.warn(node, "its back looks different: as its front, but does not shine")
        elif back.emission != front.emission:
            self.lose(node, "its sides shine differently in Blender: both as the front here")
        elif back != front:
            self.warn(node, "its back looks different: taken as the front")
        return front

    def mixed(self, a, b, t, node):
        if t == 0.0:
            return a
        if t == 1.0:
            return b
        self.settle_base(a)
        self.settle_base(b)
        one = as_gloss(self, a, b, (self.rest(t), t), node) or as_curtain(self, a, b, t)
        if one is None and is_constant(t):
            one = as_varnish(self, a, b, lambda c: t + 0.0 * c, node) or as_varnish(self, b, a, lambda c: 1.0 - t + 0.0 * c, node)
        if one is not None:
            return one
        for one, other in ((a, b), (b, a)):
            if other.alpha != 0.0:
                self.make_opaque(one, node)
        if a.normal != b.normal and a.normal is not None and b.normal is not None:
            self.warn(node, "its shaders have different normals: that of the first is taken")
        light = self.blend(a.emission, b.emission, t, True)
        left, right = self.times(a.alpha, self.rest(t)), self.times(b.alpha, t)
        alpha = self.plus(left, right) if a.alpha != b.alpha else a.alpha
        if a.alpha == b.alpha:
            share = t
        elif is_constant(alpha) and is_constant(right):
            share = right / alpha if alpha > 0.0 else t
        elif right == 0.0 or left == 0.0:
            share = 0.0 if right == 0.0 else 1.0
        else:
            share = self.number("DIVIDE", right, self.number("MAXIMUM", alpha, 1e-6))
        out = Surface(alpha=alpha, emission=light, normal=a.normal if a.normal is not None else b.normal)
        for name in ("base", "metallic", "roughness", "specular", "f0", "transmission", "ior", "clearcoat", "clearcoat_roughness"):
            mine, other = self.alike(name, a, b)
            colours = name == "base" or any(isinstance(v, tuple) and is_constant(v) for v in (mine, other))
            setattr(out, name, self.blend(mine, other, share, colours))
        out.sheen, out.sheen_roughness = mixed_sheen(a, b, share)
        self.put_under_sheen(out)
        glossy = a if a.aspect < b.aspect else b
        out.aspect, out.turn, out.is_across, out.tangent = glossy.aspect, glossy.turn, glossy.is_across, glossy.tangent
        out.coat_normal = a.coat_normal if a.coat_normal is not None else b.coat_normal
        out.film = a.film if a.film is not None else b.film
        seen = a if b.alpha == 0.0 else b
        out.through, out.through_colour = seen.through, seen.through_colour
        out.one_sided, out.thin = a.one_sided or b.one_sided, a.thin or b.thin
        out.principled, out.added = a.principled or b.principled, a.added or b.added
        self.share_of_glass(a, b, share, out, node)
        return out

    def share_of_glass(self, a, b, share, out, node):
        """Glass and what lets nothing pass have one colour in glTF: each gets its own light by its share of the transmission."""
        values = (a.base, b.base, out.transmission, share)
        if None in values or not all(is_constant(v) for v in values) or a.base == b.base or 0.0 in (a.alpha, b.alpha):
            return
        passes = [s.transmission or 0.0 for s in (a, b)]
        if passes[0] == passes[1] or not all(is_constant(p) for p in passes):
            return
        weights = [w * sum(s.base) for w, s in ((1.0 - share, a), (share, b))]
        if min(weights) > 0.0:
            out.transmission = sum(w * p for w, p in zip(weights, passes)) / sum(weights)
        if min(weights) > 0.0 and max(abs(x / sum(a.base) - y / sum(b.base)) for x, y in zip(a.base, b.base)) > 0.02:
            self.warn(node, "a mixture of glass with a surface of another colour: both have the mean of the two")

    def settle_base(self, s):
        """In a mixture the base itself is scaled, and neither coat nor sheen take from it."""
        if s.sheen != BLACK and s.left == 1.0:
            s.base = self.times(s.base, (cloth.left(s.sheen, s.sheen_roughness),) * 3, True)
        s.left = 1.0
        if (s.scale, s.lift) != (1.0, BLACK):
            base = self.plus(self.times(s.base, (s.scale,) * 3, True), s.lift, True)
            s.base = tuple(min(max(c, 0.0), 1.0) for c in base) if is_constant(base) else base
            s.scale, s.lift, s.covered, s.added = 1.0, BLACK, 1.0, True

    def alike(self, name, a, b):
        """A channel of both sides of a mixture, as values that can be blended."""
        mine, other = getattr(a, name), getattr(b, name)
        if name in ("metallic", "transmission") and a.base != BLACK and b.base != BLACK:
            # open means none, unless the shader is black, which has a share of no lobe
            mine = 0.0 if mine is None and a.alpha != 0.0 else mine
            other = 0.0 if other is None and b.alpha != 0.0 else other
        if name == "f0" and mine is not None and other is not None and mine != other:
            if is_constant(mine) and is_constant(other):
                return tuple(v if isinstance(v, tuple) else (v,) * 3 for v in (mine, other))
            return tuple(sum(v) / 3.0 if is_constant(v) and isinstance(v, tuple) else v for v in (mine, other))
        return mine, other

    def fold_sum(self, a, b, node):
        for one, other in ((a, b), (b, a)):
            if one.base == BLACK and one.alpha == 1.0 and one.specular == 0.0 and one.transmission in (None, 0.0) and one.sheen == BLACK:
                other.emission = self.plus(other.emission, one.emission, True)
                if other.alpha == 0.0:
                    self.warn(node, "light of a surface that is not there otherwise: it hides half of what is behind")
                    other.alpha, other.base, other.specular = 0.5, BLACK, 0.0
                return other
        if a.alpha == 0.0 or b.alpha == 0.0:
            self.warn(node, "a sum with what passes straight through: taken as half of each")
            return self.mixed(a, b, 0.5, node)
        self.make_opaque(a, node)
        self.make_opaque(b, node)
        self.settle_base(a)
        self.settle_base(b)
        one, ones = as_gloss(self, a, b, (1.0, 1.0), node), numpy.ones_like
        one = one or as_varnish(self, a, b, ones, node, ones) or as_varnish(self, b, a, ones, node, ones)
        if one is not None:
            return one
        weights = [sum(s.base) if s.base is not None and is_constant(s.base) else None for s in (a, b)]
        t = 0.5 if None in weights or sum(weights) == 0.0 else weights[1] / sum(weights)
        light = self.plus(a.emission, b.emission, True)
        base = self.plus(a.base, b.base, True)
        out = self.mixed(a, b, t, node)
        out.base = tuple(min(c, 1.0) for c in base) if is_constant(base) else self.vector("MINIMUM", base, WHITE)
        out.emission = light
        out.sheen, out.sheen_roughness = tuple(min(x + y, 1.0) for x, y in zip(a.sheen, b.sheen)), max(a.sheen_roughness, b.sheen_roughness)
        self.put_under_sheen(out)
        return out

    def put_under_sheen(self, s):
        """Makes up for what sheen takes from a base that has its own brightness."""
        if s.sheen != BLACK and s.base is not None:
            base = self.times(s.base, (1.0 / cloth.left(s.sheen, s.sheen_roughness),) * 3, True)
            s.base = tuple(min(c, 1.0) for c in base) if is_constant(base) else base


def mixed_sheen(a, b, share):
    """Colour and roughness."""
    weights = [w * max(s.sheen) for w, s in ((1.0 - known(share, BETWEEN), a), (known(share, BETWEEN), b))]
    if max(weights) == 0.0:
        return BLACK, 0.0
    share = known(share, BETWEEN)
    return (tuple(x + (y - x) * share for x, y in zip(a.sheen, b.sheen)),
            (weights[0] * a.sheen_roughness + weights[1] * b.sheen_roughness) / sum(weights))


# Principled of Blender 4 as a surface of glTF that reflects as much (gloss.py).

DARK = 0.1  # of a colour
REPORTED = 0.015  # differences are named from here on
BETWEEN = 0.5  # what is taken for a roughness or a colour that varies
FEW = 0.25, 0.85  # roughnesses for which that is checked
STOPS = 0.0, 1.0, 0.25, 0.5, 0.7, 0.85  # for which a colour is fitted where roughness is baked
AS_LAMBERT = ("its diffuse roughness (Oren-Nayar): taken as Lambert: at most 20 % brighter or darker in even light, 57 % darker where a lamp "
              "lights it from the front, 82 % brighter where from behind")  # of roughness 1
WHITER = 1.01  # than white: from here on metal becomes a coat


def known(value, otherwise):
    return value if is_constant(value) else otherwise


def tell_difference(folder, node, ratio, why):
    """`ratio`: of what is reflected here and in Blender."""
    if abs(ratio - 1.0) > REPORTED:
        folder.warn(node, "%s: reflects up to %.0f %% %s than in Blender" % (why, 100.0 * abs(ratio - 1.0), "less" if ratio < 1.0 else "more"))


def tell_spread(folder, node, ratios, why):
    most = max(abs(r - 1.0) for r in ratios)
    if most > REPORTED:
        folder.warn(node, "%s: what it reflects differs from Blender's by up to %.0f %%" % (why, 100.0 * most))


def tell_bright(folder, node, roughness, colour):
    """What rough facets keep of their energy in Blender is diffuse here. Measured on balls and boxes under an area lamp."""
    if roughness > 0.4 and max(colour) > 0.7:
        folder.warn(node, "bright rough metal: under a lamp up to 10 % brighter or darker than in Blender")


def farthest(ratios):
    return max(ratios, key=lambda r: abs(r - 1.0))


def tint_of(folder, node, name):
    """A tint, which has one value per material."""
    value = folder.read(node.inputs[name])
    if is_constant(value):
        return tuple(max(c, 0.0) for c in value)
    folder.warn(node, "%s varies: taken as white" % name.lower())
    return WHITE


def tell_lost(folder, node):
    if "Diffuse Roughness" in node.inputs and folder.read(node.inputs["Diffuse Roughness"]) != 0.0:
        folder.warn(node, AS_LAMBERT)
    film = node.inputs.get("Thin Film Thickness")
    thickness = folder.read(film) if film is not None else 0.0
    if not is_constant(thickness):
        folder.warn(node, "a thin film that varies: left out")


class Principled:
    """The node's values."""

    def __init__(self, folder, node):
        get = lambda name: folder.read(socket(node, name))  # noqa: E731
        self.folder, self.node = folder, node
        self.base, self.metallic, self.roughness = get("Base Color"), get("Metallic"), get("Roughness")
        if get("Subsurface") != 0.0 and self.metallic != 1.0:
            body = folder.scattered(self.base, node, get("Subsurface Scale"))
            self.base = folder.blend(self.base, body, get("Subsurface"), True)
        self.ior, self.level, self.transmission = get("IOR"), get("Specular"), get("Transmission")
        self.coat, self.coat_roughness = get("Clearcoat"), get("Clearcoat Roughness")
        self.coat_ior = get("Coat IOR")
        self.tint = tint_of(folder, node, "Specular Tint")
        if self.coat != 0.0 and not is_constant(self.coat_ior):
            folder.warn(node, "coat IOR varies: taken as 1.5")
        self.coat_tint = tint_of(folder, node, "Coat Tint") if self.coat != 0.0 else WHITE
        rough = node.inputs.get("Diffuse Roughness")
        self.diffuse_roughness = known(folder.read(rough), 0.0) if rough is not None else 0.0
        self.sheen = self.sheen_of(get("Sheen"), get("Sheen Roughness"))
        self.is_multiple = node.distribution == "MULTI_GGX"
        wall = node.inputs.get("Thin Wall")  # from Blender 5.2 on
        self.is_thin = wall is not None and folder.read(wall) == 1.0
        if self.is_thin and (self.transmission != 0.0 or get("Subsurface") != 0.0):
            folder.warn(node, THIN_WALL)
        self.bases = {}  # fitted, by roughness

    def sheen_of(self, weight, roughness):
        """What it reflects on average, in each colour; and the layer and the diffuse rest that are glTF's."""
        self.layer, self.rest = Surface(), BLACK
        if weight == 0.0:
            return BLACK
        tint = tint_of(self.folder, self.node, "Sheen Tint")
        if self.transmission != 0.0 or not is_constant(weight) or not is_constant(roughness):
            self.folder.warn(self.node, "sheen of glass: left out" if self.transmission != 0.0 else "sheen that varies: left out")
            return BLACK
        cloth.tell(self.folder, self.node)
        colour = tuple(min(max(weight, 0.0), 1.0) * min(t, 1.0) for t in tint)
        self.rest = cloth.put_on(self.layer, colour, roughness, "MICROFIBER")
        return tuple(c * cloth.mean_of_cycles(roughness, "MICROFIBER") for c in colour)

    def layers(self, roughness=None, metallic=None):
        within = lambda v: min(max(v, 0.0), 1.0)  # noqa: E731
        return Layers(within(known(self.metallic, 0.0) if metallic is None else metallic),
                      within(known(self.roughness, BETWEEN) if roughness is None else roughness), max(known(self.ior, 1.5), 1e-3),
                      max(known(self.level, 0.5), 0.0), within(known(self.coat, 0.0)), within(known(self.coat_roughness, 0.03)),
                      known(self.coat_ior, 1.5), self.is_multiple)

    def wanted(self, layers, base):
        """What is to be reflected below glTF's sheen."""
        below = [layers.parts(b, t, c, max(self.tint), of_rough_diffuse(min(b, 1.0), self.diffuse_roughness) if self.diffuse_roughness > 0.0 else b)
                 for b, t, c in zip(base, self.tint, self.coat_tint)]
        if self.sheen == BLACK:
            return below
        kept = (1.0 - max(self.sheen)) / cloth.left(self.layer.sheen, self.layer.sheen_roughness)
        return [rest + kept * b for rest, b in zip(self.rest, below)]

    def f0_of(self, layers):
        return [min(layers.f0 * t, 1.0) for t in self.tint]

    def opaque(self):
        layers = self.layers()
        out = Surface(base=self.base, metallic=self.metallic, roughness=self.roughness, specular=1.0 if layers.f0 > 0.0 else 0.0,
                      transmission=0.0, ior=1.5, clearcoat=self.coat, clearcoat_roughness=self.coat_roughness,
                      normal=self.folder.normal_of(self.node), sheen=self.layer.sheen, sheen_roughness=self.layer.sheen_roughness)
        f0 = self.f0_of(layers)
        f0 = self.fit(out, layers, f0) if is_constant(self.base) and is_constant(self.metallic) else self.fit_image(out, layers, f0)
        out.f0 = f0[0] / F0_OF_GLTF if len(set(f0)) == 1 else tuple(f / F0_OF_GLTF for f in f0)
        if not is_constant(self.level):
            out.f0 = self.folder.times(self.level, 2.0 * f0_of(known(self.ior, 1.5)))
        elif not is_constant(self.ior):
            self.folder.warn(self.node, "IOR varies: taken as 1.5")
        self.tell_varying(out, f0)
        if layers.coat > 0.5:
            self.folder.warn(self.node, "a clear coat: where light grazes up to 5 % brighter or darker than in Blender")
        return out

    def fit(self, out, layers, f0):
        """Chooses the base; metal that would be brighter than white becomes a coat over it."""
        wanted = self.wanted(layers, self.base)
        out.added = True
        if max(self.base) > 1.0:  # which is reported, and taken as 1
            return f0
        shell = Shell(layers, f0, out.specular)
        bases = [shell.base_for(w, i) for i, w in enumerate(wanted)]
        if layers.metallic > 0.0 and max(bases) > WHITER:
            f0 = [(1.0 - layers.metallic) * f + layers.metallic * b for f, b in zip(f0, self.base)]
            out.metallic, out.specular = 0.0, 1.0
            tell_bright(self.folder, self.node, layers.roughness, self.base)
            shell = Shell(self.layers(metallic=0.0), f0, 1.0)
            bases = [shell.base_for(w, i) for i, w in enumerate(wanted)]
        out.base = tuple(min(max(b, 0.0), 1.0) for b in bases)
        if is_constant(self.coat):
            out.clearcoat = shell.clearcoat
        ratios = [(h + 1e-3) / (w + 1e-3) for h, w in zip(shell.reflects(out.base), wanted)]
        tell_difference(self.folder, self.node, farthest(ratios), "its colour")
        if out.metallic > 0.0 and not is_constant(self.roughness) and self.is_baked(self.roughness):
            self.fit_rough(out, f0)
        return f0

    def is_baked(self, number):
        return number_source(self.folder, number) is None and packed.linear(self.folder.socket(number)) is None

    def fit_rough(self, out, f0):
        """Metal of a roughness that is baked: its colour, too, by roughness."""
        ramp = self.folder.nodes.new("ShaderNodeValToRGB")
        self.folder.put(self.roughness, ramp.inputs[0])
        for i, r in enumerate(STOPS):
            layers = self.layers(roughness=r)
            shell = Shell(layers, f0, out.specular)
            self.bases[r] = [min(max(shell.base_for(w, k), 0.0), 1.0) for k, w in enumerate(self.wanted(layers, self.base))]
            stop = ramp.color_ramp.elements[i] if i < 2 else ramp.color_ramp.elements.new(r)
            stop.position, stop.color = r, (*self.bases[r], 1.0)
        out.base = self.folder.ref(ramp.outputs["Color"])

    def fit_image(self, out, layers, f0):
        """Images that are carried are scaled only: the coat makes up for what they cannot."""
        shell = Shell(layers, f0, out.specular)
        low, high = (0.2, 0.8) if layers.metallic == 1.0 else (0.0, 1.0)
        dark, bright = (self.wanted(layers, (b,) * 3) for b in (low, high))
        slopes = [(b - a) / (high - low) for a, b in zip(dark, bright)]
        is_baked = not is_constant(self.base) and is_constant(self.metallic) and colour_source(self.folder, self.base) is None
        out.scale, out.added = sum(slopes) / 3.0 / shell.below, True
        if is_constant(self.coat):
            out.clearcoat = shell.clearcoat
        lack = [d - s * low - c for d, s, c in zip(dark, slopes, shell.coats)]
        if is_baked:
            out.lift = tuple(x / shell.below for x in lack)
        else:
            out.scale = min(out.scale, 1.0)
        if not is_baked and layers.metallic < 1.0 and out.specular > 0.0:
            each = (1.0 - layers.metallic) * shell.gloss
            f0 = [min(max(f + x / each, 0.0), 1.0) for f, x in zip(f0, lack)]
            shell = Shell(layers, f0, out.specular)
        wanted = self.wanted(layers, (0.6,) * 3)
        here = [c + shell.below * (out.scale * 0.6 + x) for c, x in zip(shell.coats, out.lift)]
        tell_difference(self.folder, self.node, farthest([h / w for h, w in zip(here, wanted)]), "an image as the colour of rough metal"
                        if layers.metallic > 0.5 else "an image as its colour")
        return f0

    def tell_varying(self, out, f0):
        """What a roughness or metal that varies makes of it."""
        several = []
        if not is_constant(self.roughness):
            several.append(("its colour" if self.bases else "roughness varies, and is taken as %g for its brightness" % BETWEEN,
                            [self.layers(roughness=r) for r in FEW]))
        if not is_constant(self.metallic):
            several.append(("metallic varies, and surfaces are fitted without it", [self.layers(metallic=1.0)]))
        base = known(self.base, (0.6,) * 3)
        here = tuple(out.scale * b for b in known(out.base, base))
        for why, others in several:
            ratios = []
            for layers in others:
                if out.metallic == 0.0 and self.metallic != 0.0 and is_constant(self.metallic):  # metal as a coat
                    shell = Shell(self.layers(layers.roughness, 0.0), f0, out.specular)
                else:
                    shell = Shell(layers, f0, out.specular)
                shown = self.bases.get(layers.roughness, here)
                ratios += [(h + 1e-3) / (w + 1e-3) for h, w in zip(shell.reflects(shown), self.wanted(layers, base))]
            tell_spread(self.folder, self.node, ratios, why)

    def dull(self):
        """The part of a surface that is not glass: no coat covers both."""
        self.folder.warn(self.node, "glass in part: the rest has no gloss of its own")
        base = self.base
        if is_constant(base) and is_constant(self.metallic):
            base = tuple(min(w, 1.0) for w in self.wanted(self.layers(), base))
        return Surface(base=base, metallic=0.0, roughness=self.roughness, specular=0.0, transmission=0.0, ior=self.ior,
                       normal=self.folder.normal_of(self.node))

    def glass(self):
        if self.tint != WHITE:
            self.folder.warn(self.node, "the specular tint of glass: left out")
        self.folder.tell_distribution(self.node)
        base = self.base
        if self.is_thin:
            pass  # its colour is that of one surface
        elif is_constant(base):
            base = tuple(min(max(c, 0.0), 1.0) ** 0.5 for c in base)  # Cycles takes the root at each surface
        else:
            root = self.folder.nodes.new("ShaderNodeGamma")
            root.inputs["Gamma"].default_value = 0.5
            self.folder.put(base, root.inputs["Color"])
            base = self.folder.ref(root.outputs[0])
        return Surface(base=base, metallic=self.metallic, roughness=self.roughness, specular=1.0, f0=1.0, transmission=1.0, ior=self.ior,
                       clearcoat=self.coat, clearcoat_roughness=self.coat_roughness, normal=self.folder.normal_of(self.node))


def put_coat_normal(folder, out, node, name):
    if out.clearcoat == 0.0:
        return
    out.coat_normal = folder.normal_of(node, name)
    if out.coat_normal is not None:
        folder.warn(node, "a clear coat with a normal of its own: up to 10 % darker where it is steep")


FILM = 0.1  # nanometres: thinner films are none to Cycles


def put_film(folder, out, node, metallic):
    """Cycles has films over what is not metal."""
    film = node.inputs.get("Thin Film Thickness")
    thickness, index = (folder.read(i) if i is not None else 0.0 for i in (film, node.inputs.get("Thin Film IOR")))
    if not is_constant(thickness) or not is_constant(index) or thickness <= FILM or metallic == 1.0:
        return
    if metallic != 0.0:
        folder.warn(node, "a thin film over metal in part: over all of it")
    folder.warn(node, "a thin film: up to 12 % darker than in Blender, of colours that differ a little")
    out.film = (thickness, max(index, 1.0))


def principled(folder, node):
    tell_lost(folder, node)
    values = Principled(folder, node)
    share = values.transmission
    if share != 0.0 and is_constant(values.metallic) and values.metallic >= 1.0:
        share = 0.0
    if share != 0.0 and values.metallic != 0.0:
        folder.warn(node, "metal and glass in one: both have one colour")
    if is_constant(share):
        share = min(max(share, 0.0), 1.0)
    if share == 0.0:
        out = values.opaque()
    elif share == 1.0:
        out = values.glass()
    else:
        out = folder.mixed(values.dull(), values.glass(), share, node)
    if share == 0.0:
        grain.put_on(folder, out, node, folder.read(node.inputs["Anisotropic"]), True)
        if out.aspect < 1.0 and values.is_multiple and values.metallic != 0.0:
            folder.warn(node, "anisotropic metal of multiple scattering: up to 4 % darker")
    elif folder.read(node.inputs["Anisotropic"]) != 0.0:
        folder.warn(node, "anisotropy of glass: taken as equally rough in all directions")
    out.thin = values.is_thin
    put_coat_normal(folder, out, node, "Coat Normal")
    put_film(folder, out, node, values.metallic)
    out.alpha = folder.read(node.inputs["Alpha"])
    light = folder.times(folder.read(socket(node, "Emission")), folder.times(folder.read(node.inputs["Emission Strength"]), out.alpha), True)
    layers = values.layers()
    if (layers.coat > 0.0 or values.sheen != BLACK) and light != BLACK:
        light = folder.times(light, tuple((1.0 - max(values.sheen)) * layers.shine(t) for t in values.coat_tint), True)
    out.emission = light
    return out


# Glossy, Metallic, Sheen and rough Diffuse of Blender 4 as surfaces of glTF that reflect as much (gloss.py).

FACETS = "MULTI_GGX", "GGX"  # distributions that are modelled
SMOOTH = 0.0316  # smoother metal is a perfect mirror to Reframe


def tell_facets(folder, node, roughness):
    if getattr(node, "distribution", "GGX") not in FACETS and (not is_constant(roughness) or roughness > 0.25):
        folder.warn(node, "rough gloss of the distribution %s: taken as GGX" % node.distribution.replace("_", " ").lower())


def glossy(folder, node):
    """Gloss whose colour is the same from everywhere; its energy is kept by a brighter colour."""
    roughness, colour = folder.read(node.inputs["Roughness"]), folder.read(node.inputs["Color"])
    tell_facets(folder, node, roughness)
    out = Surface(base=colour, metallic=1.0, roughness=roughness, normal=folder.normal_of(node), is_flat=True)
    grain.put_on(folder, out, node, folder.read(node.inputs["Anisotropy"]), False)
    rough = known(roughness, BETWEEN)
    straight = mean(rough, views(rough)[1])
    is_multiple = node.distribution == "MULTI_GGX"
    wanted = [mean(rough, gloss_of(rough, lambda c, b=b: b + 0.0 * c, is_multiple)) for b in known(colour, (0.6,) * 3)]
    if is_constant(colour) and is_constant(roughness):
        out.gain = tuple(w / (straight * c) if c > 0.0 else 1.0 for w, c in zip(wanted, colour))
    else:
        base, steep = known(colour, (0.6,) * 3), mean(rough, reflected(rough, schlick))
        out.is_flat = False
        tell_difference(folder, node, farthest([(b * (straight - steep) + steep) / max(w, 1e-3) for b, w in zip(base, wanted)]),
                        "gloss that varies")
    return out


def settle_flat(folder, s):
    """Gloss that stayed alone, by a coat over what its facets lose: glTF's metal is white at grazing angles."""
    if not s.is_flat or s.roughness < SMOOTH:
        return
    if max(s.base) == 0.0:
        s.metallic, s.specular = 0.0, 0.0
        return
    tell_bright(folder, None, s.roughness, s.base)
    straight = mean(s.roughness, views(s.roughness)[1])
    cover(s, s.base, max(s.base), [b * gain * straight for b, gain in zip(s.base, s.gain)])


def cover(s, f0, most, wanted):
    """A coat that reflects f0 straight on and `most` at grazing angles, over a base that makes up for the rest of what is wanted."""
    straight, steep = mean(s.roughness, views(s.roughness)[1]), mean(s.roughness, reflected(s.roughness, schlick))
    f0 = [min(f, max(w - most * steep, 0.0) / (straight - steep)) for f, w in zip(f0, wanted)]
    s.base = tuple(min(max(w - f * (straight - steep) - most * steep, 0.0), 1.0) for f, w in zip(f0, wanted))
    s.specular, s.f0 = most, tuple(f / F0_OF_GLTF / most for f in f0)
    s.metallic, s.transmission, s.ior, s.is_flat, s.added = 0.0, 0.0, 1.5, False, True


def metallic(folder, node):
    """A metal by its colours or by its index."""
    roughness = folder.read(node.inputs["Roughness"])
    tell_facets(folder, node, roughness)
    names, make = (("IOR", "Extinction"), of_conductor) if node.fresnel_type == "PHYSICAL_CONDUCTOR" else (("Base Color", "Edge Tint"), of_metal)
    values = [folder.read(node.inputs[name]) for name in names]
    out = Surface(base=values[0], metallic=1.0, roughness=roughness, normal=folder.normal_of(node))
    grain.put_on(folder, out, node, folder.read(node.inputs["Anisotropy"]), True)
    if not all(is_constant(v) for v in values):
        folder.warn(node, "its %s varies: taken as of metal that is white at its edges" % " or ".join(n.lower() for n in names))
        if make is of_conductor:
            out.base = (0.6,) * 3
        return out
    rough = known(roughness, BETWEEN)
    pairs = [(max(a, 0.0), max(b, 0.0)) for a, b in zip(*values)]
    pairs = [(min(a, 1.0), min(b, 1.0)) for a, b in pairs] if make is of_metal else pairs
    steep = mean(rough, reflected(rough, schlick))
    straight = mean(rough, views(rough)[1])
    wanted = [mean(rough, gloss_of(rough, make(a, b), node.distribution == "MULTI_GGX")) for a, b in pairs]
    base = [max((w - steep) / (straight - steep), 0.0) for w in wanted]
    out.base = tuple(min(b, 1.0) for b in base)
    if max(base) > WHITER and is_constant(roughness):
        tell_bright(folder, node, rough, wanted)
        cover(out, [float(make(a, b)(1.0)) for a, b in pairs], 1.0, wanted)
        return out
    here = [b * (straight - steep) + steep for b in out.base]
    tell_difference(folder, node, farthest([(h + 1e-3) / (w + 1e-3) for h, w in zip(here, wanted)]), "its colour")
    if not is_constant(roughness):
        ratios = []
        for r in FEW:
            at = mean(r, reflected(r, schlick)), mean(r, views(r)[1])
            ratios += [(b * (at[1] - at[0]) + at[0]) / max(mean(r, gloss_of(r, make(*p), node.distribution == "MULTI_GGX")), 1e-3)
                       for b, p in zip(out.base, pairs)]
        tell_spread(folder, node, ratios, "roughness varies, and is taken as %g for its brightness" % BETWEEN)
    return out


def rough_diffuse(colour, roughness):
    """A colour that is as bright for Lambert."""
    return tuple(of_rough_diffuse(min(max(c, 0.0), 1.0), min(max(roughness, 0.0), 1.0)) for c in colour)


def sheen(folder, node, rough, kind):
    """Sheen alone, and a diffuse surface that reflects the rest of what Cycles' does."""
    colour, roughness = (folder.read(node.inputs[name]) for name in ("Color", rough))
    out = Surface(specular=0.0, normal=folder.normal_of(node))
    if is_constant(colour) and is_constant(roughness):
        cloth.tell(folder, node, roughness, kind)
        out.base = cloth.put_on(out, colour, min(max(roughness, 0.0), 1.0), kind)
        return out
    folder.warn(node, "sheen that varies: taken as diffuse")
    share = cloth.mean_of_cycles(known(roughness, BETWEEN), kind)
    out.base = folder.times(colour, (share,) * 3, True)
    return out
