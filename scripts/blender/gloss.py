"""Diffuse and glossy shaders mixed, where glTF has that as one surface: a base under a coat.

Cycles mixes the two by a share, fixed or Fresnel's of the normal. glTF's coat reflects Schlick's share of the half vector, which
takes it from the base both ways, or not at all (`added`). Base and coat get the means that the two shaders have.
"""
import dataclasses
import functools
import math

import bpy
import numpy

from .channels import BLACK, F0_OF_GLTF, Surface, is_constant
from .versions import IS_4

# of the cosine, which weighs directions of view: of uniform light 1, which surfaces of rooms, that see each other more from the
# front, exceed. Bases are as bright as in Cycles in the mean of these directions: in uniform light up to 2 % darker.
FRONT = 1.25
COSINES = tuple(((i + 0.5) / 6.0) ** (1.0 / (FRONT + 1.0)) for i in range(6))  # that stand for all directions, each for a sixth
VIEWS, STEPS = 48, 24  # steps of the cosine of the direction of view, and of each of two random numbers


def fresnel(cosine, ior):
    inner = numpy.sqrt(numpy.maximum(ior * ior + cosine * cosine - 1.0, 0.0))
    s, p = (cosine - inner) / (cosine + inner), (ior * ior * cosine - inner) / (ior * ior * cosine + inner)
    return 0.5 * (s * s + p * p)


def smith(cosine, alpha):
    return 0.5 * (numpy.sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0)


@functools.lru_cache(maxsize=8)
def lobe(roughness, steps=STEPS):
    """Directions of view and normals of GGX (single scattering; normals that are seen are sampled as in Heitz 2018, 'Sampling the GGX
    distribution of visible normals'): the cosine of the view, that of the half vector, the weight of the view, and what is reflected
    of white light."""
    alpha = max(roughness * roughness, 1e-3)
    middle = lambda n: (numpy.arange(n) + 0.5) / n  # noqa: E731
    cosine, a, b = numpy.meshgrid(middle(VIEWS), middle(steps), middle(steps), indexing="ij")
    sine = numpy.sqrt(1.0 - cosine * cosine)
    long = numpy.sqrt((alpha * sine) ** 2 + cosine * cosine)
    x, z = alpha * sine / long, cosine / long
    r, phi = numpy.sqrt(a), 2.0 * math.pi * b
    t1, s = r * numpy.cos(phi), 0.5 * (1.0 + z)
    t2 = (1.0 - s) * numpy.sqrt(1.0 - t1 * t1) + s * r * numpy.sin(phi)
    t3 = numpy.sqrt(numpy.maximum(1.0 - t1 * t1 - t2 * t2, 0.0))
    # the first tangent is y, the second -z x
    half = numpy.stack([alpha * (t3 * x - t2 * z), alpha * t1, numpy.maximum(t3 * z + t2 * x, 1e-6)])
    half /= numpy.sqrt((half * half).sum(axis=0))
    seen = half[0] * sine + half[2] * cosine
    out = 2.0 * seen * half[2] - cosine
    up = numpy.maximum(out, 1e-6)
    near = 1.0 + smith(cosine, alpha)
    return cosine, seen, (FRONT + 1.0) * cosine**FRONT, numpy.where(out > 0.0, near / (near + smith(up, alpha)), 0.0)


def lobe_under(roughness, curve):
    """Means over directions of view of what GGX reflects of uniform light times a factor of the cosine of the direction of view: of white
    facets, and of Schlick's (1 - cos)^5 of the half vector."""
    cosine, seen, front, gain = lobe(roughness)
    weight = front * gain * curve(cosine)
    return float(weight.mean()), float((weight * (1.0 - seen) ** 5).mean())


def means_of_lobe(roughness, curve):
    """That of white facets with a factor, and both without."""
    return (lobe_under(roughness, curve)[0], *lobe_under(roughness, numpy.ones_like))


def mean_of(function):
    """Of a function of the cosine of the direction of view."""
    cosine = (numpy.arange(200) + 0.5) / 200.0
    return float(((FRONT + 1.0) * cosine**FRONT * function(cosine)).mean())


def diffuse_of_3(roughness):
    """What the diffuse lobe of Blender 3's Principled reflects where Lambert's reflects 1, in the mean of these directions (a line is
    at most .001 off)."""
    return 0.9583 + 0.1001 * roughness


def under(base, gloss, kept, share, reflected, most, grazing):
    """The base under a coat of the colour and roughness of the gloss, whose share is `share` seen straight on and `most` at grazing
    angles. Cycles keeps `kept` of the base, and reflects `reflected` by gloss that is white. `grazing`: as means_of_lobe() has them."""
    out = Surface(base=base.base, metallic=0.0, roughness=gloss.roughness, normal=base.normal, alpha=base.alpha, emission=base.emission,
                  clearcoat=base.clearcoat, clearcoat_roughness=base.clearcoat_roughness, one_sided=base.one_sided)
    out.coat_normal, out.aspect, out.turn = base.coat_normal, gloss.aspect, gloss.turn
    out.is_across, out.tangent = gloss.is_across, gloss.tangent
    brightest = max(gloss.base)
    out.specular = min(most * brightest, 1.0)
    straight, steep = grazing
    f0 = [min(share * c, out.specular) for c in gloss.base]
    lift = [c * reflected * gain - f * (straight - steep) - out.specular * steep for c, gain, f in zip(gloss.base, gloss.gain, f0)]
    if is_constant(base.base):
        out.lift = tuple(lift)
    else:  # nothing is added to an image: the coat reflects it
        f0 = [min(max(f + x / (straight - steep), 0.0), out.specular) for f, x in zip(f0, lift)]
    out.f0 = tuple(f / F0_OF_GLTF / out.specular for f in f0)
    if base.principled and is_constant(base.roughness):
        kept *= diffuse_of_3(base.roughness)
    out.scale, out.added = kept, True
    return out


def cover(s):
    """Lets the coat take from the base both ways what it reflects, as glTF does, where no factor of the base gets above 1 by that."""
    coat = max(s.f0) * F0_OF_GLTF * s.specular
    covered = (1.0 - coat - (s.specular - coat) * mean_of(lambda c: (1.0 - c) ** 5)) ** 2
    if is_constant(s.base) and covered > 0.0 and max(c * s.scale / covered + x for c, x in zip(s.base, s.lift)) <= 1.0:
        s.covered, s.added = covered, False
    return s


def is_diffuse(s):
    return s.base is not None and s.specular == 0.0 and s.metallic in (None, 0.0) and s.transmission in (None, 0.0) and s.sheen == BLACK


def is_gloss(s):
    return (s.metallic == 1.0 and s.transmission in (None, 0.0) and s.clearcoat in (None, 0.0) and s.alpha == 1.0 and
            s.emission == BLACK)


def lobe_of(gloss, curve):
    return means_of_lobe(gloss.roughness if is_constant(gloss.roughness) else 0.0, curve)


def as_coat(a, b, curve, is_fresnel):
    """Diffuse under gloss by a factor of the cosine of the direction of view; None if these are not the two."""
    if not (is_diffuse(a) and is_gloss(b)) or a.normal != b.normal or not is_constant(b.base) or max(b.base) <= 0.0:
        return None
    reflected, straight, steep = lobe_of(b, curve)
    share, most = float(curve(1.0)), 1.0
    if not is_fresnel:  # the share at grazing angles that makes Schlick's as bright
        share = min(share, reflected / straight)
        most = min(max((reflected - share * (straight - steep)) / steep, share, 1e-6), 1.0)
    return cover(under(a, b, 1.0 - mean_of(curve), share, reflected * b.scale, most, (straight, steep)))


def as_gloss(folder, a, b, weights, node):
    """Diffuse and gloss of two colours in fixed shares; None if these are not the two."""
    if not all(is_constant(w) for w in weights):
        return None
    for (base, kept), (gloss, share) in (zip((a, b), weights), zip((b, a), reversed(weights))):
        if not (is_diffuse(base) and is_gloss(gloss)) or base.base == gloss.base or base.base == BLACK:
            continue
        if base.alpha != 1.0 or base.emission != BLACK:
            continue
        if not is_constant(gloss.base):
            folder.warn(node, "a mixture of gloss with a surface of another colour: both have the mean of the two")
        elif gloss.normal == base.normal and max(gloss.base) > 0.0:
            _, straight, steep = lobe_of(gloss, lambda c: c)
            return under(base, gloss, kept, share, share * straight, share, (straight, steep))
    return None


SHINY = 0.2  # reflectance straight on: metal that became a coat (folding.py) has more


def is_metal(s):
    """Gloss, or bright metal, which is a coat."""
    if s.metallic == 1.0 or s.f0 is None or not all(is_constant(v) for v in (s.base, s.f0, s.specular)):
        return s.metallic == 1.0
    return (s.metallic, s.transmission, s.clearcoat) == (0.0, 0.0, 0.0) and F0_OF_GLTF * s.specular * max(three(s.f0)) > SHINY


def three(value):
    return value if isinstance(value, tuple) else (value,) * 3


def parts_of(s, share):
    """What is diffuse, if its base is known, and what is gloss of a surface, with a factor of the cosine of the direction of view."""
    straight, steep = lobe_under(s.roughness, share)
    if s.metallic == 1.0:
        return BLACK, [straight * s.scale * c * gain for c, gain in zip(s.base, s.gain)]
    diffuse = [mean_of(share) * (s.scale * c + x) for c, x in zip(s.base, s.lift)] if is_constant(s.base) else None
    return diffuse, [s.specular * (F0_OF_GLTF * f * (straight - steep) + steep) for f in three(s.f0)]


def as_varnish(folder, a, b, curve, node, kept=None):
    """A surface under gloss by a factor of the cosine of the direction of view, which leaves the rest, or `kept`. The gloss becomes the clear coat where that can be as
    bright, else both have one lobe; None if these are not the two."""
    if not is_metal(b) or a.base is None or a.base in (b.base, BLACK) or a.normal != b.normal or b.emission != BLACK or b.sheen != BLACK:
        return None
    out = dataclasses.replace(a)
    for name, value in (("metallic", 0.0), ("roughness", b.roughness), ("specular", 0.0), ("f0", 0.0), ("transmission", 0.0)):
        setattr(out, name, value if getattr(a, name) is None else getattr(a, name))
    values = (out.metallic, out.roughness, out.specular, out.f0, out.clearcoat, b.base, b.roughness)
    if not all(is_constant(v) for v in values) or is_metal(out) or b.clearcoat != 0.0 or b.transmission not in (None, 0.0):
        return None
    if (out.transmission, a.alpha, b.alpha, a.aspect, b.aspect, a.film, b.film) != (0.0, 1.0, 1.0, 1.0, 1.0, None, None):
        return None
    for s in (out, b):
        if s.principled and s.metallic != 1.0:
            s.scale, s.lift = base_of_principled(s)
            s.principled = False
    kept = kept or (lambda c: 1.0 - curve(c))
    (_, gloss), (more, varnish) = parts_of(out, kept), parts_of(b, curve)
    straight, steep = means_of_lobe(b.roughness, curve)[1:]
    share = mean_of(kept)
    coat = sum(varnish) / 3.0 / (F0_OF_GLTF * (straight - steep) + steep)
    if b.metallic == 1.0 and a.clearcoat == 0.0 and coat <= 1.0 == CLEARCOAT and min(b.base) >= 0.9 * max(b.base):
        out.clearcoat, out.clearcoat_roughness = coat, b.roughness
        left = lambda c: 1.0 - coat * (F0_OF_GLTF + (1.0 - F0_OF_GLTF) * schlick(c))  # noqa: E731
        below = share / (mean_of(left) * average(left))
        straight, steep = lobe_under(out.roughness, lambda c: left(c) ** 2)
    elif out.metallic != 0.0 or not is_constant(a.base) and max(more) > 0.0:
        return None
    else:
        below = share
        parts = sum(gloss), sum(varnish)
        if min(parts) > 0.1 * sum(parts) and abs(out.roughness - b.roughness) > 0.1:
            folder.warn(node, "gloss of two roughnesses: both have the mean of the two")
        out.roughness = (parts[0] * out.roughness + parts[1] * b.roughness) / max(sum(parts), 1e-9)
        out.clearcoat *= share
        most = max(b.base) if b.metallic == 1.0 else b.specular
        out.specular = min(float(kept(0.0)) * out.specular + float(curve(0.0)) * most, 1.0)
        gloss = [g + v for g, v in zip(gloss, varnish)]
        straight, steep = lobe_under(out.roughness, numpy.ones_like)
    out.scale *= below
    out.emission = folder.times(a.emission, (share,) * 3, True)
    f0 = [min(max((g - out.specular * steep) / (straight - steep), 0.0), out.specular) for g in gloss]
    if is_constant(a.base):
        lack = [g - f * (straight - steep) - out.specular * steep for f, g in zip(f0, gloss)]
        out.lift = tuple(below * low + x + d for low, x, d in zip(out.lift, lack, more))
    out.f0 = tuple(f / F0_OF_GLTF / max(out.specular, 1e-6) for f in f0)
    out.principled, out.added = False, True
    return out


# The surfaces of Blender 4, whose layers take from each other what they reflect, as glTF's base under a coat.
#
# Principled, from the top: clear coat, metal, dielectric coat, Lambert. Each layer leaves to those below what its mean over the lights
# leaves, seen from the camera; gloss of the distribution "multiple scattering" keeps the energy that rough facets lose to each other
# (Kulla, Conty 2017, 'Revisiting Physically Based Shading at Imageworks'). glTF's surface has other curves: its base is chosen such that
# both reflect the same of light from all sides, in the mean over directions of view (FRONT).

LOBE_STEPS = 80  # of each of two random numbers, in lobes
METAL_EDGE = 1.0 / 7.0  # the cosine for which the edge tint of metals is defined


@functools.lru_cache(maxsize=None)
def views(roughness):
    """By cosine of the direction of view: its weight, what a lobe of white facets reflects, and the mean of it over uniform light."""
    cosine, _, weight, gain = lobe(roughness, LOBE_STEPS)
    front = weight.mean(axis=(1, 2))
    white = gain.mean(axis=(1, 2))
    across = cosine[:, 0, 0]
    return front / front.mean(), white, float((2.0 * across * white).mean() / (2.0 * across).mean()), across


def mean(roughness, values):
    return float((views(roughness)[0] * values).mean())


def reflected(roughness, reflectance):
    """What facets reflect, by direction of view, of a reflectance by the cosine to the half vector."""
    _, seen, _, gain = lobe(roughness, LOBE_STEPS)
    return (gain * reflectance(seen)).mean(axis=(1, 2))


def kept(roughness, average):
    """What multiple scattering multiplies a lobe by, whose Fresnel factor is `average` for uniform light."""
    _, white, whole, _ = views(roughness)
    many = average * whole / (1.0 - average * (1.0 - whole))
    return 1.0 + many * (1.0 - white) / white


def average(reflectance):
    """Of uniform light."""
    cosine = (numpy.arange(400) + 0.5) / 400.0
    return float((2.0 * cosine * reflectance(cosine)).mean())


def schlick(cosine):
    return numpy.maximum(1.0 - cosine, 0.0) ** 5


def of_metal(f0, tint):
    """F82: Schlick's factor, less a term that makes it `tint` times that at METAL_EDGE."""
    edge = f0 + (1.0 - f0) * schlick(METAL_EDGE)
    b = edge * (1.0 - tint) / (METAL_EDGE * (1.0 - METAL_EDGE) ** 6)
    return lambda c: numpy.clip(f0 + (1.0 - f0) * schlick(c) - b * c * numpy.maximum(1.0 - c, 0.0) ** 6, 0.0, 1.0)


def of_conductor(n, k):
    """Fresnel's equations of an index n + i k, of unpolarised light."""
    def reflectance(c):
        square = n * n + k * k
        parallel = (square * c * c - 2.0 * n * c + 1.0) / (square * c * c + 2.0 * n * c + 1.0)
        across = (square - 2.0 * n * c + c * c) / (square + 2.0 * n * c + c * c)
        return 0.5 * (parallel + across)
    return reflectance


def of_dielectric(f0, tint, ior):
    """Fresnel's equations, from f0 times tint straight on to 1."""
    def reflectance(c):
        share = numpy.clip((fresnel(c, ior) - f0) / (1.0 - f0), 0.0, 1.0)
        return min(f0 * tint, 1.0) * (1.0 - share) + share
    return reflectance


def gloss_of(roughness, reflectance, is_multiple):
    """The mean of a glossy lobe, by direction of view."""
    return reflected(roughness, reflectance) * (kept(roughness, average(reflectance)) if is_multiple else 1.0)


def ior_of(f0):
    root = min(f0, 0.99) ** 0.5
    return (1.0 + root) / (1.0 - root)


def of_rough_diffuse(colour, roughness):
    """The mean of the improved Oren-Nayar model of Fujii, with the multiple scattering that Cycles of Blender 4 adds."""
    across = views(1.0)[3]
    sine, angle = numpy.sqrt(1.0 - across * across), numpy.arccos(across)
    a = 1.0 / (math.pi + roughness * (0.5 * math.pi - 2.0 / 3.0))
    g = sine * (angle - 2.0 / 3.0 - sine * across) + 2.0 / 3.0 * sine / across * (1.0 - sine ** 3)
    once = a * math.pi + roughness * a * g
    if not IS_4:
        return mean(1.0, colour * once)
    whole = a * math.pi + (2.0 * math.pi - 5.6) / 3.0 * roughness * a
    return mean(1.0, colour * (once + colour * colour * whole * (1.0 - once) / (1.0 - colour * (1.0 - whole))))


class Layers:
    """Principled's numbers: `base` and tints are of one channel."""

    def __init__(self, metallic, roughness, ior, level, coat, coat_roughness, coat_ior, is_multiple):
        self.metallic, self.roughness, self.is_multiple = metallic, roughness, is_multiple
        self.f0 = min(2.0 * level * ((ior - 1.0) / (ior + 1.0)) ** 2, 0.98)
        self.coat, self.coat_roughness = coat, coat_roughness
        self.coat_ior = max(coat_ior, 1.0)

    @property
    def white(self):
        return views(self.roughness)[1]

    def above(self):
        """What the clear coat reflects, and what it leaves, by direction of view, but for its tint."""
        if self.coat == 0.0:
            return 0.0, 1.0
        ways = reflected(self.coat_roughness, lambda c: fresnel(c, self.coat_ior))
        # before 4.5 Cycles takes from what is below as a smooth coat would
        taken = ways if bpy.app.version >= (4, 5, 0) else fresnel(views(self.coat_roughness)[3], self.coat_ior)
        return self.coat * ways, 1.0 - self.coat * taken

    def tinted(self, tint):
        """By the way of light through the coat, of length 1 straight on."""
        across = views(self.roughness)[3]
        inner = numpy.sqrt(1.0 - (1.0 - across * across) / self.coat_ior ** 2)
        return 1.0 - self.coat + self.coat * tint ** (1.0 / inner)

    def parts(self, base, specular, coat_tint, brightest, diffuse):
        """What Cycles reflects on average. `specular`: the tint of this channel, `brightest` of all; `diffuse`: of the base alone."""
        coat, left = self.above()
        below = self.metallic * gloss_of(self.roughness, of_metal(min(base, 1.0), min(specular, 1.0)), self.is_multiple) if self.metallic > 0.0 else 0.0
        if self.metallic < 1.0:
            layer = cover = 0.0
            if self.f0 > 0.0:
                ior = ior_of(self.f0)
                layer = gloss_of(self.roughness, of_dielectric(self.f0, specular, ior), self.is_multiple)
                cover = gloss_of(self.roughness, of_dielectric(self.f0, brightest, ior), self.is_multiple)
                cover = cover if self.is_multiple else cover / self.white
            below = below + (1.0 - self.metallic) * (layer + (1.0 - cover) * diffuse)
        return mean(self.roughness, coat + left * self.tinted(coat_tint) * below)

    def shine(self, coat_tint):
        """What the coat leaves of light from below it."""
        return mean(self.roughness, self.above()[1] * self.tinted(coat_tint))


class Shell:
    """glTF's surface, with a coat that is added, as Reframe has it (src/bsdf/ggx.c, layered.c): its mean is that of the coats, and `below`
    times the base."""

    def __init__(self, layers, f0, specular):
        r, m = layers.roughness, layers.metallic
        self.straight, self.steep = layers.white, reflected(r, schlick)
        across = views(r)[3]
        self.clearcoat, coat, over, under = 0.0, 0.0, 1.0, 1.0
        if layers.coat > 0.0:
            one = reflected(layers.coat_roughness, lambda c: F0_OF_GLTF + (1.0 - F0_OF_GLTF) * schlick(c))
            wanted = mean(r, layers.above()[0]) / mean(r, one)
            self.clearcoat = min(wanted, 1.0)
            top = 1.0 - self.clearcoat * (F0_OF_GLTF + (1.0 - F0_OF_GLTF) * schlick(across))
            average_top = 1.0 - self.clearcoat * (F0_OF_GLTF + (1.0 - F0_OF_GLTF) / 21.0)
            coat, over, under = self.clearcoat * one, top * top, top * average_top  # of gloss, and of what is diffuse
        most = (1.0 - m) * specular + m
        self.gloss = mean(r, over * (self.straight - self.steep))  # for each f0
        self.coats = [mean(r, coat + over * ((1.0 - m) * f * (self.straight - self.steep) + most * self.steep)) for f in f0]
        self.below = (1.0 - m) * mean(r, under * numpy.ones(len(across))) + m * self.gloss

        self.held = average(lambda c: max(f0) + (specular - max(f0)) * schlick(c)) * views(r)[2] if m < 1.0 else 0.0

    def reflects(self, base):
        """What it reflects in each colour; base and added coat never more than arrives (src/scene/textured.c)."""
        share = min((1.0 - self.held) / max(*base, 1e-6), 1.0)
        return [c + self.below * share * b for c, b in zip(self.coats, base)]

    def base_for(self, wanted, channel):
        return (wanted - self.coats[channel]) / self.below


# Principled and gloss of Blender 3, beside what glTF's material makes of the same values: what each reflects of uniform light.
#
# Cycles multiplies Smith's masking of both directions, where Reframe's is correlated with height; its coats have Fresnel's factor,
# not Schlick's; its clear coat is a quarter as strong; its diffuse lobe is Disney's.

CLEARCOAT = 0.25 if bpy.app.version < (4, 0, 0) else 1.0  # of glTF's clear coat
SCHLICK = 1.0 / 21.0  # the mean of (1 - cos)^5
REPORTED = 0.02  # differences are named from here on


@functools.lru_cache(maxsize=None)
def lobes(roughness):
    """The cosine of the half vector, and what is reflected of white light here and in Cycles, weighted by directions of view."""
    cosine, seen, front, here = lobe(roughness)
    near = 1.0 + smith(cosine, max(roughness * roughness, 1e-3))
    far = near / numpy.maximum(here, 1e-6) - near  # lobe() reflects near / (near + far)
    return seen, front * here, numpy.where(here > 0.0, front / (1.0 + far), 0.0)


def gloss_of_3(roughness):
    """A factor of the colour of gloss."""
    if not is_constant(roughness) or bpy.app.version >= (4, 0, 0):
        return 1.0
    _, here, cycles = lobes(roughness)
    return min(float(cycles.mean() / here.mean()), 1.0)


def tell_multiple(folder, node, metallic=1.0):
    """Reframe's facets lose what they reflect to each other."""
    rough = folder.read(node.inputs["Roughness"])
    if node.distribution != "MULTI_GGX" or metallic == 0.0:
        return
    lost = 1.0 - float(lobes(rough)[1].mean()) if is_constant(rough) else 0.6
    if lost > REPORTED:
        folder.warn(node, "rough metal of multiple scattering: taken as single scattering, up to %.0f %% darker" % (100.0 * lost))


def base_of_principled(surface):
    """A factor and a colour to add that give a base the brightness of Blender's own, which has another diffuse lobe, another Fresnel
    factor and another clear coat. None where the base colours glass, too, or roughness or metallic varies."""
    s = surface
    if not s.principled or not is_constant(s.roughness) or not is_constant(s.metallic) or s.transmission != 0.0:
        return None
    m, specular = s.metallic, s.specular if is_constant(s.specular) else 1.0
    f0 = (sum(s.f0) / 3.0 if isinstance(s.f0, tuple) else s.f0) * F0_OF_GLTF if is_constant(s.f0) else F0_OF_GLTF
    f0 = min(f0, 0.9) if specular > 0.0 else 0.0
    seen, here, cycles = lobes(s.roughness)
    # of both: what is reflected at normals, and more at grazing angles
    steep, rise = (here * (1.0 - seen) ** 5).mean(), (cycles * (fresnel(seen, (1.0 + f0**0.5) / (1.0 - f0**0.5)) - f0) / (1.0 - f0)).mean()
    straight, level = here.mean() - steep, cycles.mean() - rise
    slope, left = 1.0 - m + m * straight, kept_of_3(s)
    lack = left * ((1.0 - m) * f0 * level + rise) - (1.0 - m) * f0 * straight - ((1.0 - m) * specular + m) * steep
    return left * ((1.0 - m) * diffuse_of_3(s.roughness) / s.left + m * level) / slope, (lack / slope,) * 3


# The clear coat of Blender 3 has longer tails, of roughness 0.25 if smooth, and takes light from what is below only by an error of its
# sampling, from a roughness of 0.018 on. Measured with 3.4.1, within 3 % of the coat, and 2 % of what is below.
COAT_OF_3 = (0.0, 0.5, 1.0), (1.13, 1.13, 1.48)  # what it reflects, of glTF's, by roughness


def strength_of_coat(roughness):
    """Of glTF's clear coat that reflects as much."""
    return CLEARCOAT * (float(numpy.interp(roughness, *COAT_OF_3)) if bpy.app.version < (4, 0, 0) else 1.0)


def kept_of_3(s):
    """How many times as much of what is below Cycles' clear coat leaves as glTF's."""
    if not is_constant(s.clearcoat) or not is_constant(s.clearcoat_roughness) or s.clearcoat == 0.0:
        return 1.0
    rough = s.clearcoat_roughness
    below = (1.0 - strength_of_coat(rough) * s.clearcoat * (F0_OF_GLTF + (1.0 - F0_OF_GLTF) * SCHLICK)) ** 2
    return below ** -(1.0 if rough < 0.018 else min(rough / (0.4 - 0.27 * s.metallic), 1.0))


def tell_held(plan):
    """Base and coat together reflect no more than arrives (src/scene/textured.c), in Blender they do."""
    s = plan.surface
    values = (s.base, s.metallic, s.roughness, s.f0, s.transmission)
    if not s.principled or s.specular == 0.0 or not all(is_constant(v) for v in values) or isinstance(s.f0, tuple):
        return
    f0 = F0_OF_GLTF * s.f0
    factor, summand = base_of_principled(s) or (1.0, BLACK)
    left = (1.0 - (f0 + (1.0 - f0) * SCHLICK) * float(lobes(s.roughness)[1].mean())) / max(factor * max(s.base) + summand[0], 1e-6)
    if s.metallic < 1.0 and s.transmission == 0.0 and left < 1.0 - REPORTED:
        plan.tell(None, "reflects more light than arrives in Blender: its diffuse part is %.0f %% darker in even light" % (100.0 * (1.0 - left)))
