"""Principled and gloss of Blender 3, beside what glTF's material makes of the same values: what each reflects of uniform light.

Cycles multiplies Smith's masking of both directions, where Reframe's is correlated with height; its coats have Fresnel's factor,
not Schlick's; its clear coat is a quarter as strong; its diffuse lobe is Disney's.
"""
import functools

import bpy
import numpy

from .channels import BLACK, F0_OF_GLTF, is_constant
from .gloss import diffuse_of_3, fresnel, lobe, smith

CLEARCOAT = 0.25 if bpy.app.version < (4, 0, 0) else 1.0  # of glTF's clear coat
SCHLICK = 1.0 / 21.0  # the mean of (1 - cos)^5
TOLD = 0.02  # differences are named from here on


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
    if lost > TOLD:
        folder.warn(node, "rough metal of multiple scattering: taken as single scattering, up to %.0f %% darker" % (100.0 * lost))


def lack_of_coat(f0, roughness):
    """What a coat reflects more in Cycles than here."""
    root = min(max(f0, 0.0), 0.9) ** 0.5
    seen, here, cycles = lobes(roughness)
    return float((cycles * fresnel(seen, (1.0 + root) / (1.0 - root)) - here * (f0 + (1.0 - f0) * (1.0 - seen) ** 5)).mean())


def base_of_principled(surface):
    """A factor and a colour to add that give a base the brightness of Blender's own, which has another diffuse lobe and another coat.
    None where the base colours metal and other things too."""
    s = surface
    if not s.principled or not is_constant(s.roughness) or s.metallic not in (0.0, 1.0) or s.transmission != 0.0:
        return None
    if s.metallic == 1.0:
        return gloss_of_3(s.roughness), BLACK
    coated = is_constant(s.f0) and not isinstance(s.f0, tuple) and s.specular != 0.0
    f0 = F0_OF_GLTF * s.f0 if coated else 0.0
    factor, lack = diffuse_of_3(s.roughness), lack_of_coat(f0, s.roughness) if coated else 0.0
    if is_constant(s.clearcoat) and is_constant(s.clearcoat_roughness) and s.clearcoat > 0.0:
        share = CLEARCOAT * s.clearcoat
        below = (1.0 - share * (F0_OF_GLTF + (1.0 - F0_OF_GLTF) * SCHLICK)) ** 2  # what the clear coat leaves, where Cycles' adds to it
        lack += share * lack_of_coat(F0_OF_GLTF, s.clearcoat_roughness) + (1.0 - below) * (f0 + (1.0 - f0) * SCHLICK)
        # smooth clear coats darken what is below in Cycles too, rough ones do not: measured with 3.4.1, within 2 %
        below **= min(s.clearcoat_roughness / 0.4, 1.0)
        factor, lack = factor / below, lack / below
    return factor, (lack,) * 3


def tell_held(plan):
    """Base and coat together reflect no more than arrives (src/scene/textured.c), in Blender they do."""
    s = plan.surface
    values = (s.base, s.metallic, s.roughness, s.f0, s.transmission)
    if not s.principled or s.specular == 0.0 or not all(is_constant(v) for v in values) or isinstance(s.f0, tuple):
        return
    f0 = F0_OF_GLTF * s.f0
    left = (1.0 - (f0 + (1.0 - f0) * SCHLICK) * float(lobes(s.roughness)[1].mean())) / max(*s.base, 1e-6)
    if s.metallic < 1.0 and s.transmission == 0.0 and left < 1.0 - TOLD:
        plan.tell(None, "reflects more light than arrives in Blender: its diffuse part is %.0f %% darker" % (100.0 * (1.0 - left)))
