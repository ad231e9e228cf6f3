"""Glossy, Metallic, Sheen and rough Diffuse of Blender 4 as surfaces of glTF that reflect as much (layers.py)."""
from .channels import BLACK, F0_OF_GLTF, Surface, is_constant
from .layered import BETWEEN, FEW, WHITER, farthest, known, tell_difference, tell_spread
from .layers import gloss_of, mean, of_conductor, of_metal, of_rough_diffuse, of_sheen, reflected, schlick, views

FACETS = "MULTI_GGX", "GGX"  # distributions that are modelled
SMOOTH = 0.0316  # smoother metal is a perfect mirror to Reframe


def tell_facets(folder, node, roughness):
    if getattr(node, "distribution", "GGX") not in FACETS and (not is_constant(roughness) or roughness > 0.25):
        folder.warn(node, "rough gloss of the distribution %s: taken as GGX" % node.distribution.replace("_", " ").lower())


def glossy(folder, node):
    """Gloss whose colour is the same from everywhere; its energy is kept by a brighter colour."""
    roughness, colour = folder.read(node.inputs["Roughness"]), folder.read(node.inputs["Color"])
    if folder.read(node.inputs["Anisotropy"]) != 0.0:
        folder.warn(node, "anisotropy: taken as equally rough in all directions")
    tell_facets(folder, node, roughness)
    out = Surface(base=colour, metallic=1.0, roughness=roughness, normal=folder.normal_of(node), is_flat=True)
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


def settle_flat(s):
    """Gloss that stayed alone, by a coat over what its facets lose: glTF's metal is white at grazing angles."""
    if not s.is_flat or s.roughness < SMOOTH:
        return
    if max(s.base) == 0.0:
        s.metallic, s.specular = 0.0, 0.0
        return
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
    if folder.read(node.inputs["Anisotropy"]) != 0.0:
        folder.warn(node, "anisotropy: taken as equally rough in all directions")
    tell_facets(folder, node, roughness)
    names, make = (("IOR", "Extinction"), of_conductor) if node.fresnel_type == "PHYSICAL_CONDUCTOR" else (("Base Color", "Edge Tint"), of_metal)
    values = [folder.read(node.inputs[name]) for name in names]
    out = Surface(base=values[0], metallic=1.0, roughness=roughness, normal=folder.normal_of(node))
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


def sheen(folder, node):
    """Diffuse of the same brightness."""
    colour, roughness = (folder.read(node.inputs[name]) for name in ("Color", "Roughness"))
    share = of_sheen(known(roughness, BETWEEN), node.distribution)
    return Surface(base=folder.times(colour, (share,) * 3, True), specular=0.0, normal=folder.normal_of(node))
