"""Principled of Blender 4 as a surface of glTF that reflects as much (layers.py)."""
from .channels import BLACK, F0_OF_GLTF, Surface, WHITE, f0_of, is_constant
from .layers import Layers, Shell, of_rough_diffuse, of_sheen
from .names import socket

TOLD = 0.015  # differences are named from here on
BETWEEN = 0.5  # what is taken for a roughness that varies
FEW = 0.25, 0.85  # roughnesses for which that is checked
LEFT_OUT = (("Subsurface", "subsurface scattering: taken as diffuse"), ("Anisotropic", "anisotropy: taken as equally rough in all directions"),
            ("Diffuse Roughness", "its diffuse roughness (Oren-Nayar): taken as Lambert"))
WHITER = 1.01  # than white: from here on metal becomes a coat


def known(value, otherwise):
    return value if is_constant(value) else otherwise


def tell_difference(folder, node, ratio, why):
    """`ratio`: of what is reflected here and in Blender."""
    if abs(ratio - 1.0) > TOLD:
        folder.warn(node, "%s: reflects up to %.0f %% %s than in Blender" % (why, 100.0 * abs(ratio - 1.0), "less" if ratio < 1.0 else "more"))


def tell_spread(folder, node, ratios, why):
    most = max(abs(r - 1.0) for r in ratios)
    if most > TOLD:
        folder.warn(node, "%s: what it reflects differs from Blender's by up to %.0f %%" % (why, 100.0 * most))


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
    for name, what in LEFT_OUT:
        if (name in node.inputs or name == "Subsurface") and folder.read(socket(node, name)) != 0.0:
            folder.warn(node, what)
    film = node.inputs.get("Thin Film Thickness")
    thickness = folder.read(film) if film is not None else 0.0
    if not is_constant(thickness) or thickness > 0.1:  # nanometres
        folder.warn(node, "a thin film: left out")
    if folder.read(socket(node, "Clearcoat")) != 0.0 and node.inputs["Coat Normal"].is_linked:
        folder.warn(node, "the normal of the clear coat: taken as that of the shape")


class Principled:
    """The node's values."""

    def __init__(self, folder, node):
        get = lambda name: folder.read(socket(node, name))  # noqa: E731
        self.folder, self.node = folder, node
        self.base, self.metallic, self.roughness = get("Base Color"), get("Metallic"), get("Roughness")
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

    def sheen_of(self, weight, roughness):
        """What it reflects on average, in each colour."""
        if weight == 0.0:
            return BLACK
        tint = tint_of(self.folder, self.node, "Sheen Tint")
        values = (weight, roughness, self.base, self.metallic)
        if self.transmission != 0.0 or not all(is_constant(v) for v in values):
            self.folder.warn(self.node, "sheen: left out")
            return BLACK
        self.folder.warn(self.node, "sheen: its light is taken as diffuse")
        return tuple(min(max(weight, 0.0) * t * of_sheen(roughness), 1.0) for t in tint)

    def layers(self, roughness=None, metallic=None):
        within = lambda v: min(max(v, 0.0), 1.0)  # noqa: E731
        return Layers(within(known(self.metallic, 0.0) if metallic is None else metallic),
                      within(known(self.roughness, BETWEEN) if roughness is None else roughness), max(known(self.ior, 1.5), 1e-3),
                      max(known(self.level, 0.5), 0.0), within(known(self.coat, 0.0)), within(known(self.coat_roughness, 0.03)),
                      known(self.coat_ior, 1.5), self.is_multiple)

    def wanted(self, layers, base):
        below = [layers.parts(b, t, c, max(self.tint), of_rough_diffuse(min(b, 1.0), self.diffuse_roughness) if self.diffuse_roughness > 0.0 else b)
                 for b, t, c in zip(base, self.tint, self.coat_tint)]
        return [s + (1.0 - max(self.sheen)) * b for s, b in zip(self.sheen, below)]

    def f0_of(self, layers):
        return [min(layers.f0 * t, 1.0) for t in self.tint]

    def opaque(self):
        layers = self.layers()
        out = Surface(base=self.base, metallic=self.metallic, roughness=self.roughness, specular=1.0 if layers.f0 > 0.0 else 0.0,
                      transmission=0.0, ior=1.5, clearcoat=self.coat, clearcoat_roughness=self.coat_roughness,
                      normal=self.folder.normal_of(self.node))
        f0 = self.f0_of(layers)
        f0 = self.fit(out, layers, f0) if is_constant(self.base) and is_constant(self.metallic) else self.fit_image(out, layers, f0)
        out.f0 = f0[0] / F0_OF_GLTF if len(set(f0)) == 1 else tuple(f / F0_OF_GLTF for f in f0)
        if not is_constant(self.level):
            out.f0 = self.folder.times(self.level, 2.0 * f0_of(known(self.ior, 1.5)))
        elif not is_constant(self.ior):
            self.folder.warn(self.node, "IOR varies: taken as 1.5")
        self.tell_varying(out, f0)
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
            shell = Shell(self.layers(metallic=0.0), f0, 1.0)
            bases = [shell.base_for(w, i) for i, w in enumerate(wanted)]
        out.base = tuple(min(max(b, 0.0), 1.0) for b in bases)
        if is_constant(self.coat):
            out.clearcoat = shell.clearcoat
        ratios = [(h + 1e-3) / (w + 1e-3) for h, w in zip(shell.reflects(out.base), wanted)]
        tell_difference(self.folder, self.node, farthest(ratios), "its colour")
        return f0

    def fit_image(self, out, layers, f0):
        """Images are scaled only: the coat makes up for what they cannot."""
        shell = Shell(layers, f0, out.specular)
        low, high = (0.2, 0.8) if layers.metallic == 1.0 else (0.0, 1.0)
        dark, bright = (self.wanted(layers, (b,) * 3) for b in (low, high))
        slopes = [(b - a) / (high - low) for a, b in zip(dark, bright)]
        out.scale, out.added = min(sum(slopes) / 3.0 / shell.below, 1.0), True
        if is_constant(self.coat):
            out.clearcoat = shell.clearcoat
        if layers.metallic < 1.0 and out.specular > 0.0:
            each = (1.0 - layers.metallic) * shell.gloss
            f0 = [min(max(f + (d - s * low - c) / each, 0.0), 1.0) for f, d, s, c in zip(f0, dark, slopes, shell.coats)]
            shell = Shell(layers, f0, out.specular)
        wanted = self.wanted(layers, (0.6,) * 3)
        here = [c + shell.below * out.scale * 0.6 for c in shell.coats]
        tell_difference(self.folder, self.node, farthest([h / w for h, w in zip(here, wanted)]), "an image as the colour of rough metal"
                        if layers.metallic > 0.5 else "an image as its colour")
        return f0

    def tell_varying(self, out, f0):
        """What a roughness or metal that varies makes of it."""
        several = []
        if not is_constant(self.roughness):
            several.append(("roughness varies, and is taken as %g for its brightness" % BETWEEN, [self.layers(roughness=r) for r in FEW]))
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
                ratios += [(h + 1e-3) / (w + 1e-3) for h, w in zip(shell.reflects(here), self.wanted(layers, base))]
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
        if is_constant(base):
            base = tuple(min(max(c, 0.0), 1.0) ** 0.5 for c in base)  # Cycles takes the root at each surface
        else:
            root = self.folder.nodes.new("ShaderNodeGamma")
            root.inputs["Gamma"].default_value = 0.5
            self.folder.put(base, root.inputs["Color"])
            base = self.folder.ref(root.outputs[0])
        return Surface(base=base, metallic=self.metallic, roughness=self.roughness, specular=1.0, f0=1.0, transmission=1.0, ior=self.ior,
                       clearcoat=self.coat, clearcoat_roughness=self.coat_roughness, normal=self.folder.normal_of(self.node))


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
    out.alpha = folder.read(node.inputs["Alpha"])
    light = folder.times(folder.read(socket(node, "Emission")), folder.times(folder.read(node.inputs["Emission Strength"]), out.alpha), True)
    layers = values.layers()
    if (layers.coat > 0.0 or values.sheen != BLACK) and light != BLACK:
        light = folder.times(light, tuple((1.0 - max(values.sheen)) * layers.shine(t) for t in values.coat_tint), True)
    out.emission = light
    return out
