"""The surfaces of Blender 4, whose layers take from each other what they reflect, as glTF's base under a coat.

Principled, from the top: clear coat, metal, dielectric coat, Lambert. Each layer leaves to those below what its mean over the lights
leaves, seen from the camera; gloss of the distribution "multiple scattering" keeps the energy that rough facets lose to each other
(Kulla, Conty 2017, 'Revisiting Physically Based Shading at Imageworks'). glTF's surface has other curves: its base is chosen such that
both reflect the same of light from all sides, in the mean over directions of view (gloss.FRONT).
"""
import functools
import math

import numpy

from .channels import F0_OF_GLTF
from .gloss import fresnel, lobe

STEPS = 80  # of each of two random numbers, in lobes
METAL_EDGE = 1.0 / 7.0  # the cosine for which the edge tint of metals is defined


@functools.lru_cache(maxsize=None)
def views(roughness):
    """By cosine of the direction of view: its weight, what a lobe of white facets reflects, and the mean of it over uniform light."""
    cosine, _, weight, gain = lobe(roughness, STEPS)
    front = weight.mean(axis=(1, 2))
    white = gain.mean(axis=(1, 2))
    across = cosine[:, 0, 0]
    return front / front.mean(), white, float((2.0 * across * white).mean() / (2.0 * across).mean()), across


def mean(roughness, values):
    return float((views(roughness)[0] * values).mean())


def reflected(roughness, reflectance):
    """What facets reflect, by direction of view, of a reflectance by the cosine to the half vector."""
    _, seen, _, gain = lobe(roughness, STEPS)
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


# What Cycles' sheen reflects on average for roughnesses from 0 to 1, measured with 4.3.2: spheres in even light, weighed by FRONT
SHEEN = {"MICROFIBER": (0.0, 0.0003, 0.0043, 0.0199, 0.0506, 0.0962, 0.1545, 0.2216, 0.2931, 0.3645, 0.4319),
         "ASHIKHMIN": (0.0, 0.0020, 0.0183, 0.0521, 0.0987, 0.1532, 0.2115, 0.2699, 0.3262, 0.3789, 0.4274)}


def of_sheen(roughness, kind="MICROFIBER"):
    return float(numpy.interp(roughness, numpy.linspace(0.0, 1.0, 11), SHEEN[kind]))


def of_rough_diffuse(colour, roughness):
    """The mean of the improved Oren-Nayar model of Fujii, with the multiple scattering that Cycles adds."""
    across = views(1.0)[3]
    sine, angle = numpy.sqrt(1.0 - across * across), numpy.arccos(across)
    a = 1.0 / (math.pi + roughness * (0.5 * math.pi - 2.0 / 3.0))
    g = sine * (angle - 2.0 / 3.0 - sine * across) + 2.0 / 3.0 * sine / across * (1.0 - sine ** 3)
    once = a * math.pi + roughness * a * g
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
        # Cycles takes from what is below as a smooth coat would
        return self.coat * ways, 1.0 - self.coat * fresnel(views(self.coat_roughness)[3], self.coat_ior)

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
    """glTF's surface, with a coat that is added, as Reframe has it (src/bsdf/ggx.c, coated.c): its mean is that of the coats, and `below`
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
