"""Sheen and velvet as KHR_materials_sheen, which reflects as much on average and looks about alike.

glTF's sheen is Charlie, of Conty and Kulla ('Production Friendly Microfacet Sheen BRDF', 2017), over a base of which it leaves
min(1 - m E(o), 1 - m E(i)); E: its directional albedo, m: the brightest of its colour. Cycles' are other models, that reflect more
at high roughness: the rest of them is diffuse.
"""
import functools
import math

import numpy

from .channels import is_constant
from .gloss import FRONT

COSINES = (numpy.arange(40) + 0.5) / 40.0
STEPS = 64  # of each coordinate of the other direction

# What Cycles' sheen reflects on average for roughnesses from 0 to 1, measured with 4.3.2: spheres in even light, weighed by FRONT
MEANS = {"MICROFIBER": (0.0, 0.0004, 0.0070, 0.0238, 0.0582, 0.1043, 0.1624, 0.2290, 0.2998, 0.3703, 0.4370),
         "ASHIKHMIN": (0.0, 0.0044, 0.0264, 0.0592, 0.1110, 0.1658, 0.2238, 0.2818, 0.3374, 0.3894, 0.4372)}
# The roughness and the colour of white sheen in glTF that are nearest, over a diffuse rest: by the root mean square over directions of
# view off by 0.02 (MICROFIBER) and 0.1 (ASHIKHMIN) at most
LIKE = {"MICROFIBER": ((0.1, 0.13, 0.15, 0.23, 0.33, 0.43, 0.58, 0.77, 0.77, 0.76, 0.75),
                       (0.0, 0.025, 0.3, 0.565, 0.825, 1.0, 1.0, 0.95, 0.95, 0.925, 0.875)),
        "ASHIKHMIN": ((0.1, 0.13, 0.2, 0.3, 0.45, 0.59, 0.74, 0.9, 0.9, 0.9, 0.9),
                      (0.0, 0.225, 0.75, 0.97, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0))}
# Sheen of Principled in 3.4, (1 - cos)^5 of the angle to the half vector: likewise, measured with 3.4.1
OF_PRINCIPLED = (0.00996, 0.4, 0.107)

FLAT_MICROFIBRES = 0.5  # below this roughness


def tell(folder, node, roughness=1.0, kind="ASHIKHMIN"):
    """Under a sun the models differ, by spheres of scripts/validate materials."""
    more = 80 if kind == "MICROFIBER" and roughness < FLAT_MICROFIBRES else 20
    folder.warn(node, "sheen: as bright as in Blender in even light, under a sun up to %d %% brighter" % more)


def charlie_l(x, alpha):
    t = (1.0 - alpha) ** 2
    a, b, c, d, e = (high + (low - high) * t for high, low in (
        (21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801), (-1.97760, -1.27393), (-4.32054, -4.85967)))
    return a / (1.0 + b * x**c) + d * x + e


def charlie_lambda(cosine, alpha):
    return numpy.exp(numpy.where(cosine < 0.5, charlie_l(cosine, alpha), 2.0 * charlie_l(0.5, alpha) - charlie_l(1.0 - cosine, alpha)))


def limit(cosine, roughness):
    """What keeps rough fits from reflecting more than arrives: src/bsdf/layered.c."""
    r = min(roughness, 0.5)
    return numpy.minimum(1.0, (5.07 - 5.08 * r) * r + cosine * (4.145 + 10.47 * cosine / roughness))


@functools.lru_cache(maxsize=None)
def albedo(roughness):
    """Of white sheen, by COSINES."""
    alpha, middle = roughness * roughness, (numpy.arange(STEPS) + 0.5) / STEPS
    o, i, phi = numpy.meshgrid(COSINES, middle, math.pi * middle, indexing="ij")
    across = 2.0 - o * o - i * i + 2.0 * numpy.sqrt((1.0 - o * o) * (1.0 - i * i)) * numpy.cos(phi)
    sine = numpy.sqrt(across / ((o + i) ** 2 + across))
    spread = (2.0 + 1.0 / alpha) * sine ** (1.0 / alpha) * numpy.minimum(limit(o, roughness), limit(i, roughness))
    return (spread / ((1.0 + charlie_lambda(o, alpha) + charlie_lambda(i, alpha)) * 4.0 * o)).mean(axis=(1, 2))


def seen(values):
    return float(((FRONT + 1.0) * COSINES**FRONT * values).mean())


def reflected(roughness):
    """What white sheen reflects on average."""
    return seen(albedo(round(roughness, 3)))


def left(colour, roughness):
    """What it leaves of a diffuse base on average."""
    most = max(colour)
    if most == 0.0:
        return 1.0
    each = 1.0 - most * albedo(round(roughness, 3))
    return seen((2.0 * COSINES * numpy.minimum(each[:, None], each[None, :])).mean(axis=1))


def mean_of_cycles(roughness, kind):
    return float(numpy.interp(roughness, numpy.linspace(0.0, 1.0, 11), MEANS[kind]))


def like(roughness, kind):
    """Roughness and brightness of glTF's sheen."""
    return tuple(float(numpy.interp(roughness, numpy.linspace(0.0, 1.0, 11), row)) for row in LIKE[kind])


def put_on(surface, colour, roughness, kind):
    """Gives a surface the part of Cycles' sheen that is glTF's; returns the rest, as the colour of a diffuse surface below it."""
    share = mean_of_cycles(roughness, kind)
    rough, bright = like(roughness, kind)
    surface.sheen = tuple(min(max(c, 0.0) * bright, 1.0) for c in colour)
    surface.sheen_roughness = rough
    below = left(surface.sheen, rough)
    return tuple(max(c * share - s * reflected(rough), 0.0) / below for c, s in zip(colour, surface.sheen))


def put_on_principled(surface, weight, tint, base):
    """The sheen of Principled in Blender 3."""
    _, rough, bright = OF_PRINCIPLED
    luminance = 0.2126 * base[0] + 0.7152 * base[1] + 0.0722 * base[2] if is_constant(base) else 0.0
    tone = tuple(c / luminance for c in base) if luminance > 0.0 else (1.0, 1.0, 1.0)
    surface.sheen = tuple(min(weight * bright * (1.0 + (c - 1.0) * tint), 1.0) for c in tone)
    surface.sheen_roughness = rough
