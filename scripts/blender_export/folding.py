"""A shader tree folded into the channels of glTF's material: mixes of shaders become mixes of channels."""
from . import layered, metals
from .channels import BLACK, F0_OF_GLTF, Ref, Surface, WHITE, is_constant
from .disney import gloss_of_3, tell_multiple
from .fresnel import as_glass, as_one
from .gloss import as_gloss
from .names import IS_4, is_principled_2
from .values import Values

LEFT_OUT = {  # shaders without equivalent, and what is kept of them
    "BSDF_TRANSLUCENT": "light that shines through: taken as diffuse",
    "SUBSURFACE_SCATTERING": "subsurface scattering: taken as diffuse",
    "BSDF_VELVET": "velvet: taken as diffuse",
    "BSDF_TOON": "toon shading: taken as diffuse",
    "BSDF_HAIR": "hair: taken as diffuse",
    "BSDF_HAIR_PRINCIPLED": "hair: taken as diffuse",
    "EEVEE_SPECULAR": "a shader of Eevee: taken as diffuse",
    "HOLDOUT": "a holdout: taken as black",
}


class Folder(Values):
    """Surfaces of the shaders of a tree."""

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
        self.warn(node, LEFT_OUT[node.type])
        colour = next((i for i in node.inputs if i.name in ("Color", "Diffuse Color", "Base Color")), None)
        return Surface(base=self.read(colour) if colour is not None and node.type != "HOLDOUT" else BLACK, specular=0.0,
                       normal=self.normal_of(node))

    def normal_of(self, node):
        socket = node.inputs.get("Normal")
        value = self.read(socket) if socket is not None and socket.is_linked else None
        return value if isinstance(value, Ref) else None

    def of_bsdf_sheen(self, node):
        self.warn(node, "sheen: taken as diffuse")
        return metals.sheen(self, node)

    def of_bsdf_diffuse(self, node):
        roughness, colour = (self.read(node.inputs[name]) for name in ("Roughness", "Color"))
        if roughness != 0.0:
            self.warn(node, "its roughness (Oren-Nayar): taken as Lambert")
            if IS_4 and is_constant(roughness) and is_constant(colour):
                colour = metals.rough_diffuse(colour, roughness)
        return Surface(base=colour, specular=0.0, normal=self.normal_of(node))

    def of_bsdf_glossy(self, node):
        if "Anisotropy" in node.inputs and node.type == "BSDF_GLOSSY":
            return metals.glossy(self, node)
        if node.type == "BSDF_GLOSSY" and getattr(node, "distribution", "") == "SHARP":
            roughness = 0.0
        else:
            roughness = self.read(node.inputs["Roughness"])
            tell_multiple(self, node)
        return Surface(base=self.read(node.inputs["Color"]), metallic=1.0, roughness=roughness, normal=self.normal_of(node),
                       scale=gloss_of_3(roughness) if node.distribution == "GGX" else 1.0)

    def of_bsdf_metallic(self, node):
        return metals.metallic(self, node)

    def of_bsdf_anisotropic(self, node):
        if self.read(node.inputs["Anisotropy"]) != 0.0:
            self.warn(node, "anisotropy: taken as equally rough in all directions")
        return self.of_bsdf_glossy(node)

    def of_bsdf_glass(self, node):
        self.tell_distribution(node)
        if IS_4 and node.type == "BSDF_GLASS" and self.read(node.inputs["Color"]) != WHITE:
            self.warn(node, "the colour of its reflection: taken as white")
        roughness = 0.0 if node.distribution == "SHARP" else self.read(node.inputs["Roughness"])
        return Surface(base=self.read(node.inputs["Color"]), metallic=0.0, roughness=roughness, specular=1.0, transmission=1.0,
                       ior=self.read(node.inputs["IOR"]), normal=self.normal_of(node))

    def tell_distribution(self, node):
        """Beckmann's facets lose less light to each other than those of GGX, multiple scattering none."""
        rough = self.read(node.inputs["Roughness"])
        if node.distribution in ("BECKMANN", "MULTI_GGX") and (not is_constant(rough) or rough > 0.25):
            self.warn(node, "rough glass of the distribution %s: taken as GGX, up to 4 %% darker" % node.distribution.replace("_", " ").lower())

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
        # a pane that neither bends nor reflects, only tints
        return Surface(base=colour, metallic=0.0, roughness=0.0, specular=1.0, transmission=1.0, ior=1.0)

    def of_emission(self, node):
        light = self.times(self.read(node.inputs["Color"]), self.read(node.inputs["Strength"]), True)
        return Surface(base=BLACK, specular=0.0, emission=light)

    of_background = of_emission

    def of_bsdf_principled(self, node):
        if is_principled_2(node):
            return layered.principled(self, node)
        get = lambda name: self.read(node.inputs[name])  # noqa: E731
        for name, what in (("Subsurface", "subsurface scattering: taken as diffuse"), ("Sheen", "sheen: left out"),
                           ("Anisotropic", "anisotropy: taken as equally rough in all directions")):
            if get(name) != 0.0:
                self.warn(node, what)
        tell_multiple(self, node, get("Metallic"))
        if get("Transmission") != 0.0 and (not is_constant(get("Roughness")) or get("Roughness") > 0.25):
            self.warn(node, "rough glass: up to 7 % brighter or darker than in Blender, with a roughness above 0.7 up to a third brighter")
        base = self.blend(get("Base Color"), get("Subsurface Color"), get("Subsurface"), True)
        specular, ior = get("Specular"), get("IOR")
        alpha = get("Alpha")
        light = self.times(get("Emission"), self.times(get("Emission Strength"), alpha), True)
        coat = 0.0 if specular == 0.0 else 1.0  # without it Cycles leaves the lobe out, also at grazing angles
        return Surface(base=base, metallic=get("Metallic"), roughness=get("Roughness"), specular=coat,
                       f0=self.times(specular, 0.08 / F0_OF_GLTF), transmission=get("Transmission"), ior=ior,
                       clearcoat=get("Clearcoat"), clearcoat_roughness=get("Clearcoat Roughness"), alpha=alpha, emission=light,
                       normal=self.normal_of(node), principled=True)

    # mixtures

    def fold_mix(self, node):
        factor = node.inputs[0]
        source = factor.links[0].from_socket if factor.is_linked else None
        if (glass := as_glass(self, node, source)) is not None:
            return glass
        a, b = self.fold(node.inputs[1]), self.fold(node.inputs[2])
        if source is not None and source.node.type == "NEW_GEOMETRY" and source.name == "Backfacing":
            if b.emission != a.emission:
                a.one_sided = b.emission == BLACK and a.emission != BLACK
            elif b != a:
                self.warn(node, "its back looks different: taken as the front")
            return a
        if source is not None and source.node.type in ("FRESNEL", "LAYER_WEIGHT"):
            one = as_one(self, a, b, source, node)
            if one is not None:
                return one
        t = self.read(factor)
        if is_constant(t):
            t = min(max(t, 0.0), 1.0)
        else:
            t = self.number("ADD", t, 0.0, clamp=True)
        return self.mixed(a, b, t, node)

    def mixed(self, a, b, t, node):
        if t == 0.0:
            return a
        if t == 1.0:
            return b
        self.settle_base(a)
        self.settle_base(b)
        one = as_gloss(self, a, b, (self.rest(t), t), node)
        if one is not None:
            return one
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
        """In a mixture the base itself is scaled, and no coat takes from it."""
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
            if one.base == BLACK and one.alpha == 1.0 and one.specular == 0.0 and one.transmission in (None, 0.0):
                other.emission = self.plus(other.emission, one.emission, True)
                if other.alpha == 0.0:
                    self.warn(node, "light of a surface that is not there otherwise: it hides half of what is behind")
                    other.alpha, other.base, other.specular = 0.5, BLACK, 0.0
                return other
        if a.alpha == 0.0 or b.alpha == 0.0:
            self.warn(node, "a sum with what passes straight through: taken as half of each")
            return self.mixed(a, b, 0.5, node)
        self.settle_base(a)
        self.settle_base(b)
        one = as_gloss(self, a, b, (1.0, 1.0), node)
        if one is not None:
            return one
        weights = [sum(s.base) if s.base is not None and is_constant(s.base) else None for s in (a, b)]
        t = 0.5 if None in weights or sum(weights) == 0.0 else weights[1] / sum(weights)
        light = self.plus(a.emission, b.emission, True)
        base = self.plus(a.base, b.base, True)
        out = self.mixed(a, b, t, node)
        out.base = tuple(min(c, 1.0) for c in base) if is_constant(base) else self.vector("MINIMUM", base, WHITE)
        out.emission = light
        return out
