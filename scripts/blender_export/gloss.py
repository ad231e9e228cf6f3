"""Diffuse and glossy shaders mixed, where glTF has that as one surface: a base under a coat.

Cycles mixes the two by a share, fixed or Fresnel's of the normal. glTF's coat reflects Schlick's share of the half vector, which
takes it from the base both ways, or not at all (`added`). Base and coat get the means that the two shaders have.
"""
import functools
import math

import numpy

from .channels import BLACK, F0_OF_GLTF, Surface, f0_of, is_constant

# of the cosine, which weighs directions of view: of uniform light 1, which surfaces of rooms, that see each other more from the
# front, exceed. Bases are as bright as in Cycles in the mean of these directions: in uniform light up to 2 % darker.
FRONT = 1.25
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


@functools.lru_cache(maxsize=None)
def means_of_lobe(roughness, ior):
    """Means over directions of view of what GGX reflects of uniform light times Fresnel's factor of the direction of view, and times 1
    and Schlick's (1 - cos)^5 of the half vector."""
    cosine, seen, front, gain = lobe(roughness)
    weight = front * gain
    mean = lambda f: float((weight * f).mean())  # noqa: E731
    return mean(fresnel(cosine, ior)), mean(1.0), mean((1.0 - seen) ** 5)


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
    return s.base is not None and s.specular == 0.0 and s.metallic in (None, 0.0) and s.transmission in (None, 0.0)


def is_gloss(s):
    return (s.metallic == 1.0 and s.transmission in (None, 0.0) and s.clearcoat in (None, 0.0) and s.alpha == 1.0 and
            s.emission == BLACK)


def lobe_of(gloss, ior):
    return means_of_lobe(gloss.roughness if is_constant(gloss.roughness) else 0.0, ior)


def as_coat(a, b, ior):
    """Diffuse under gloss by Fresnel's factor; None if these are not the two."""
    if not (is_diffuse(a) and is_gloss(b)) or a.normal != b.normal or not is_constant(b.base) or max(b.base) <= 0.0:
        return None
    reflected, straight, steep = lobe_of(b, ior)
    kept = 1.0 - mean_of(lambda c: fresnel(c, ior))
    reflected *= b.scale
    return cover(under(a, b, kept, min(F0_OF_GLTF * f0_of(ior), 1.0), reflected, 1.0, (straight, steep)))


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
            _, straight, steep = lobe_of(gloss, 1.5)
            return under(base, gloss, kept, share, share * straight, share, (straight, steep))
    return None
