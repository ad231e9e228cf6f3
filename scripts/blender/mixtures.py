"""Two shaders mixed, where glTF has that as one surface: panes, glass, coats by what depends on the angle, curtains."""
import math

import numpy

from .channels import BLACK, Surface, WHITE, is_constant
from .gloss import as_coat, as_varnish, fresnel, is_metal, mean_of

SHARP = 0.1  # reflections of a pane are taken as sharp up to this roughness
DENSEST = 20.0  # index of refraction


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


def layer_weight(folder, node, output):
    blend = folder.read(node.inputs["Blend"])
    if not is_constant(blend):
        return None
    if output == "Fresnel":
        ior = 1.0 / (1.0 - min(blend, 0.99999))
        return lambda c: fresnel(c, ior)
    blend = min(max(blend, 0.0), 1.0 - 1e-5)
    power = 2.0 * blend if blend < 0.5 else 0.5 / (1.0 - blend)
    return lambda c: 1.0 - c**power


def ramp_of(ramp):
    """The brightness of a colour ramp."""
    steps = numpy.linspace(0.0, 1.0, 257)
    bright = numpy.array([numpy.dot(ramp.evaluate(x)[:3], (0.2126, 0.7152, 0.0722)) for x in steps])
    return lambda x: numpy.interp(x, steps, bright)


OPERATIONS = {
    "ADD": numpy.add, "SUBTRACT": numpy.subtract, "MULTIPLY": numpy.multiply, "MAXIMUM": numpy.maximum, "MINIMUM": numpy.minimum,
    "POWER": lambda a, b: numpy.maximum(a, 0.0) ** b, "GREATER_THAN": lambda a, b: numpy.greater(a, b) * 1.0,
    "LESS_THAN": lambda a, b: numpy.less(a, b) * 1.0,
}


def curve_of(folder, source):
    """What an output gives, as a function of the cosine of the direction of view; None where it depends on other things too."""
    node = source.node
    if node.type == "FRESNEL":
        ior = folder.read(node.inputs["IOR"])
        return (lambda c: fresnel(c, max(ior, 1e-5))) if is_constant(ior) else None
    if node.type == "LAYER_WEIGHT":
        return layer_weight(folder, node, source.name)
    if node.type == "VALTORGB" and source.name == "Color":
        inner = curve_at(folder, node.inputs[0])
        ramp = ramp_of(node.color_ramp)
        return (lambda c: ramp(inner(c))) if inner is not None else None
    if node.type == "INVERT":
        share, inner = folder.read(node.inputs[0]), curve_at(folder, node.inputs[1])
        return (lambda c: inner(c) + share * (1.0 - 2.0 * inner(c))) if inner is not None and is_constant(share) else None
    if node.type == "MATH" and node.operation in OPERATIONS:
        both = [curve_at(folder, i) for i in node.inputs[:2]]
        if None in both:
            return None
        most = 1.0 if node.use_clamp else math.inf
        least = 0.0 if node.use_clamp else -math.inf
        return lambda c: numpy.clip(OPERATIONS[node.operation](both[0](c), both[1](c)), least, most)
    return None


def curve_at(folder, socket):
    value = folder.read(socket)
    if is_constant(value):
        number = sum(value) / 3.0 if isinstance(value, tuple) else value
        return lambda c: number + 0.0 * c
    return curve_of(folder, socket.links[0].from_socket)


def as_pane(a, b, ior):
    """What is transparent under sharp gloss is a thin pane; None if these are not the two."""
    clear = a.alpha == 0.0
    tinted = a.alpha == 1.0 and a.transmission == 1.0 and a.ior == 1.0
    if not (clear or tinted) or b.metallic != 1.0 or not is_constant(b.roughness) or b.roughness > SHARP:
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


def as_curtain(folder, a, b, t):
    """Diffuse and translucent shaders mixed by a number; None if these are not the two."""
    plain = all(s.specular == 0.0 and s.metallic in (None, 0.0) and s.transmission in (None, 0.0) and s.alpha == 1.0 and s.emission == BLACK and
                s.sheen == BLACK for s in (a, b))
    if not plain or not is_constant(t) or a.through + b.through == 0.0 or a.normal != b.normal:
        return None
    through = [w * s.through for w, s in ((1.0 - t, a), (t, b))]
    left = [w * (1.0 - s.through) for w, s in ((1.0 - t, a), (t, b))]
    mean_of = lambda weights, x, y: folder.blend(x, y, weights[1] / max(sum(weights), 1e-9), True)  # noqa: E731
    out = Surface(base=mean_of(left, a.base, b.base), specular=0.0, normal=a.normal, through=sum(through))
    out.through_colour = mean_of(through, a.through_colour, b.through_colour)
    return out


def index_like(curve):
    """The index whose Fresnel factor has the same mean."""
    low, high, wanted = 1.0, DENSEST, mean_of(curve)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if mean_of(lambda c, n=middle: fresnel(c, n)) < wanted else (low, middle)
    return low


def as_one(folder, a, b, source, node):
    """The surface that is `a` under `b` by a factor that depends on the angle; None where there is none."""
    curve = curve_of(folder, source)
    if curve is None:
        return None
    curve, ior = within(curve), ior_of(folder, source)
    if is_metal(a) and not is_metal(b):
        a, b, curve, ior = b, a, (lambda c, f=curve: 1.0 - f(c)), None
    if not is_metal(b) or b.alpha != 1.0:
        return None
    folder.make_opaque(a, node)
    pane = as_pane(a, b, ior if ior is not None else index_like(curve))
    if pane is not None:
        if b.base != WHITE:
            folder.warn(node, "the colour of its reflection: taken as white")
        if ior is None:
            folder.warn(node, "a factor of its own for what it reflects: taken as Fresnel's of the same mean")
        return pane
    coat = as_coat(a, b, curve, ior is not None) or as_varnish(folder, a, b, curve, node)
    if coat is not None and ior is None:
        folder.warn(node, "a factor of its own for the angle: taken as Schlick's of the same mean")
    if coat is not None and ior is not None and min(b.base) < 0.9 * max(b.base):
        folder.warn(node, "the colour of its reflection: at grazing angles as bright in all colours as in the brightest")
    return coat


def within(curve):
    return lambda c: numpy.clip(curve(c), 0.0, 1.0)
