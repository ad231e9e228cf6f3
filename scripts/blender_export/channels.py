"""The channels of glTF's material, which a shader tree is folded into."""
import dataclasses
import math
from collections import namedtuple

Ref = namedtuple("Ref", "node output")  # a channel that varies: name of the node, number of its output

F0_OF_GLTF = 0.04  # reflectance of an index of 1.5, which KHR_materials_specular multiplies
LAYER = "reframe bake"  # the coordinates of the baked textures
NUMBERS = ("alpha", "roughness", "metallic")  # baked together, in R, G and B
MEANS = (("specular", "f0", "transmission"), ("ior", "clearcoat", "clearcoat_roughness"))
WORDS = {"base": "colour", "metallic": "metallic", "roughness": "roughness", "emission": "emission", "alpha": "alpha",
         "normal": "normal", "specular": "specular", "f0": "specular", "transmission": "transmission", "ior": "IOR",
         "clearcoat": "clearcoat", "clearcoat_roughness": "roughness of the clearcoat"}


@dataclasses.dataclass
class Surface:
    """Channels are numbers, colours of three, or a Ref; None where the shader leaves it open."""
    base: object = None
    metallic: object = None
    roughness: object = None
    specular: object = None  # 0: Lambert, 1: a dielectric coat over it
    f0: object = None  # of the coat, relative to F0_OF_GLTF
    transmission: object = None
    ior: object = None
    clearcoat: object = 0.0
    clearcoat_roughness: object = 0.0
    alpha: object = 1.0
    emission: object = (0.0, 0.0, 0.0)
    normal: object = None  # a Ref, or None
    one_sided: bool = False
    thin: bool = False  # what it transmits is not refracted, also on a closed mesh
    principled: bool = False  # Blender's own model, or a mixture with it
    added: bool = False  # the coat takes nothing from the base
    scale: float = 1.0  # of the base, and
    lift: tuple = (0.0, 0.0, 0.0)  # what is added to it, when it is exported: images are carried unchanged
    is_flat: bool = False  # metal whose colour is the same at all angles
    gain: tuple = (1.0, 1.0, 1.0)  # of gloss whose facets lose no light to each other
    covered: float = 1.0  # of the base, on average, what the coat leaves: it is divided by this


WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
COLOURS = ("base", "emission")


def is_constant(value):
    return not isinstance(value, Ref)


def f0_of(ior):
    return ((ior - 1.0) / (ior + 1.0)) ** 2 / F0_OF_GLTF


def finish(surface):
    """Closes what was left open, clamps constants; emission becomes that of the part which is there."""
    s = surface
    for name, value in (("base", WHITE), ("metallic", 0.0), ("roughness", 1.0), ("specular", 0.0), ("f0", 1.0),
                        ("transmission", 0.0), ("ior", 1.5)):
        if getattr(s, name) is None:
            setattr(s, name, value)
    for name in ("metallic", "roughness", "specular", "transmission", "clearcoat", "clearcoat_roughness", "alpha"):
        if is_constant(getattr(s, name)):
            setattr(s, name, min(max(float(getattr(s, name)), 0.0), 1.0))
    if is_constant(s.base):
        s.base = tuple(min(max(c, 0.0), 1.0) for c in s.base)
    if is_constant(s.emission):
        s.emission = tuple(c if c > 0.0 and math.isfinite(c) else 0.0 for c in s.emission)
    return s
