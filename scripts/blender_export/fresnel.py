"""Two shaders mixed by Fresnel's factor, where glTF has that as one surface."""
from .channels import Surface, WHITE, is_constant
from .gloss import as_coat

SHARP = 0.1  # reflections of a pane are taken as sharp up to this roughness


def ior_of(folder, source):
    """The index of a Fresnel or Layer Weight node's output; None if it is not constant or no Fresnel factor."""
    node = source.node
    if node.type == "FRESNEL":
        ior = folder.read(node.inputs["IOR"])
    elif node.type == "LAYER_WEIGHT" and source.name == "Fresnel":
        blend = folder.read(node.inputs["Blend"])
        ior = 1.0 / (1.0 - min(blend, 0.99999)) if is_constant(blend) else None
    else:
        ior = None
    return ior if ior is not None and is_constant(ior) else None


def as_pane(a, b, ior):
    """What is transparent under sharp gloss is a thin pane; None if these are not the two."""
    clear = a.alpha == 0.0
    tinted = a.alpha == 1.0 and a.transmission == 1.0 and a.ior == 1.0
    if not (clear or tinted) or not is_constant(b.roughness) or b.roughness > SHARP:
        return None
    return Surface(base=WHITE if clear else a.base, metallic=0.0, roughness=0.0, specular=1.0, transmission=1.0, ior=max(ior, 1.0),
                   thin=True)


def as_glass(folder, node, source):
    """Refraction and reflection mixed by Fresnel's factor are glass; None if these are not the two."""
    below, above = (i.links[0].from_node if i.is_linked else None for i in node.inputs[1:3])
    if below is None or above is None or below.type != "BSDF_REFRACTION" or above.type != "BSDF_GLOSSY":
        return None
    if source is None or ior_of(folder, source) is None:
        return None
    glass, gloss = folder.of_bsdf_glass(below), folder.of_bsdf_glossy(above)
    if gloss.base != WHITE:
        folder.warn(node, "the colour of its reflection: taken as white")
    if gloss.roughness != glass.roughness:
        folder.warn(node, "the roughness of its reflection: taken as that of its refraction")
    return glass


def as_one(folder, a, b, source, node):
    """The surface that is `a` under `b` by a factor; None where there is none."""
    ior = ior_of(folder, source)
    if ior is None or b.metallic != 1.0 or b.alpha != 1.0:
        return None
    pane = as_pane(a, b, ior)
    if pane is None and is_constant(b.base) and min(b.base) < 0.9 * max(b.base):
        folder.warn(node, "the colour of its reflection: at grazing angles as bright in all colours as in the brightest")
    if pane is not None and b.base != WHITE:
        folder.warn(node, "the colour of its reflection: taken as white")
    return pane if pane is not None else as_coat(a, b, ior)
