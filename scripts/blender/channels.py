"""The channels of glTF's material, which a shader tree is folded into."""
import dataclasses
import math
from collections import namedtuple

import bpy
import numpy

from . import films
from .versions import mixed_inputs, socket

Ref = namedtuple("Ref", "node output")  # a channel that varies: name of the node, number of its output

F0_OF_GLTF = 0.04  # reflectance of an index of 1.5, which KHR_materials_specular multiplies
LAYER = "reframe bake"  # the coordinates of the baked textures
NUMBERS = ("alpha", "roughness", "metallic")  # baked together, in R, G and B
MEANS = (("specular", "f0", "transmission"), ("ior", "clearcoat", "clearcoat_roughness"))
WORDS = {"base": "colour", "metallic": "metallic", "roughness": "roughness", "emission": "emission", "alpha": "alpha",
         "normal": "normal", "specular": "specular", "f0": "specular", "transmission": "transmission", "ior": "IOR",
         "clearcoat": "clearcoat", "clearcoat_roughness": "roughness of the clearcoat",
         "through_colour": "colour of what shines through", "coat_normal": "normal of the clearcoat", "grain": "direction of anisotropy"}
ADDED = {  # textures that Blender's exporter does not write: extension and key
    "through_colour": ("KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture"),
    "coat_normal": ("KHR_materials_clearcoat", "clearcoatNormalTexture"), "grain": ("KHR_materials_anisotropy", "anisotropyTexture")}
DIRECTIONS = ("normal", "coat_normal", "grain")


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
    through: float = 0.0  # share of the base that shines through, in another colour
    through_colour: object = (1.0, 1.0, 1.0)
    one_sided: bool = False
    thin: bool = False  # what it transmits is not refracted, also on a closed mesh
    principled: bool = False  # Blender's own model, or a mixture with it
    added: bool = False  # the coat takes nothing from the base
    scale: float = 1.0  # of the base, and
    lift: tuple = (0.0, 0.0, 0.0)  # what is added to it, when it is exported: images are carried unchanged
    is_flat: bool = False  # metal whose colour is the same at all angles
    gain: tuple = (1.0, 1.0, 1.0)  # of gloss whose facets lose no light to each other
    covered: float = 1.0  # of the base, on average, what the coat leaves: it is divided by this
    aspect: float = 1.0  # gloss is wider along its tangent by this, and narrower across it (grain.py)
    turn: object = 0.0  # of the tangent, in turns
    is_across: bool = False
    tangent: object = None  # a Ref; None: around the z axis
    grain: object = None  # a Ref to the pixels of the texture of directions
    coat_normal: object = None  # a Ref, or None
    film: object = None  # its thickness in nanometres and its index
    sheen: tuple = (0.0, 0.0, 0.0)
    sheen_roughness: float = 0.0
    left: float = 1.0  # of the base of Blender 3's Principled, by sheen, which takes nothing there


WHITE, BLACK, MAGENTA = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 1.0)
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


# Which inputs Blender's exporter carries as they are: images in ordinary coordinates.

COLOUR_SPACES = ("sRGB",)
DATA_SPACES = ("Non-Color", "Linear", "Linear Rec.709", "Raw")
PICTURES = 64  # an image is grey if the channels of so many of its pixels agree

_grey = {}


def is_read(image):
    """Is the image there? Asking for a pixel loads it."""
    return image is not None and image.size[0] > 0 and (image.has_data or len(image.pixels) > 0)


def is_missing(node):
    """Does Cycles show magenta for want of the image?"""
    return node.type == "TEX_IMAGE" and not is_read(node.image)


def is_grey(image):
    key = image.name_full
    if key not in _grey:
        count = image.size[0] * image.size[1]
        pixels = numpy.empty(count * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        some = pixels.reshape(count, image.channels)[::max(count // PICTURES ** 2, 1)]
        _grey[key] = image.channels < 3 or float(abs(some[:, :3] - some[:, :1]).max()) < 0.02
    return _grey[key]


_clear = {}


def is_clear(image):
    """Has a part of an image less than full alpha?"""
    key = image.name_full
    if key not in _clear:
        pixels = numpy.empty(len(image.pixels), numpy.float32)
        image.pixels.foreach_get(pixels)
        _clear[key] = image.channels == 4 and float(pixels[3::4].min()) < 0.999
    return _clear[key]


def is_dimmed(node):
    """Does Cycles show colours times alpha? It does so for bytes of both kinds of alpha where no link asks for it."""
    return node.image.alpha_mode in ("STRAIGHT", "PREMUL") and not node.outputs["Alpha"].is_linked and is_clear(node.image)


def coordinates_of(node):
    """A hashable description of the coordinates of an image node, or None if glTF has none such."""
    turn = ()
    if not node.inputs["Vector"].is_linked:
        return "", turn
    source = node.inputs["Vector"].links[0].from_socket
    if source.node.type == "MAPPING":
        mapping = source.node
        if mapping.vector_type != "POINT" or any(i.is_linked for i in mapping.inputs[1:]):
            return None
        where, angle, scale = (tuple(mapping.inputs[n].default_value) for n in ("Location", "Rotation", "Scale"))
        if angle[0] != 0.0 or angle[1] != 0.0 or not mapping.inputs["Vector"].is_linked:
            return None
        turn = (where[:2], angle[2], scale[:2])
        source = mapping.inputs["Vector"].links[0].from_socket
    if source.node.type == "UVMAP" and not source.node.from_instancer:
        return source.node.uv_map, turn
    if source.node.type == "TEX_COORD" and source.name == "UV" and not source.node.from_instancer:
        return "", turn
    return None


def plain_image(node, spaces, deep=False):
    """Is this an image node whose pixels glTF can carry? `deep`: also if they have more than 8 bits."""
    image = node.image
    return (node.type == "TEX_IMAGE" and is_read(image) and image.source in ("FILE", "GENERATED") and (deep or not image.is_float) and
            node.projection == "FLAT" and node.extension in ("REPEAT", "EXTEND") and
            image.colorspace_settings.name in spaces and coordinates_of(node) is not None and not is_dimmed(node))


def image_behind_factor(node):
    """The image node that a node multiplies by a constant, which the exporter makes a factor; else the node itself."""
    if node.type == "MIX" and node.data_type == "RGBA" and node.blend_type == "MULTIPLY" and not node.clamp_result:
        if node.inputs[0].is_linked or node.inputs[0].default_value != 1.0:
            return node
        pair = mixed_inputs(node)
    elif node.type == "MATH" and node.operation == "MULTIPLY" and not node.use_clamp:
        pair = node.inputs[0:2]
    else:
        return node
    linked = [s for s in pair if s.is_linked]
    numbers = [v for s in pair if not s.is_linked for v in (s.default_value if s.type == "RGBA" else (s.default_value,))]
    if len(linked) != 1 or min(numbers) < 0.0 or max(numbers) > 1.0:
        return node
    source = linked[0].links[0].from_socket
    return source.node if source.name == "Color" or source.node.type == "SEPARATE_COLOR" else node


def strength_of(folder, ref):
    """Where emission is a colour times a number: the colour, and the number."""
    node = folder.nodes[ref.node]
    if node.type != "VECT_MATH" or node.operation != "MULTIPLY" or not node.inputs[0].is_linked or node.inputs[1].is_linked:
        return ref, 1.0
    factor = tuple(node.inputs[1].default_value)
    return (folder.ref(node.inputs[0].links[0].from_socket), factor[0]) if len(set(factor)) == 1 else (ref, 1.0)


def colour_source(folder, ref):
    node = folder.nodes[ref.node]
    behind = image_behind_factor(node)
    if behind != node:
        return behind if plain_image(behind, COLOUR_SPACES) else None
    if node.type == "TEX_IMAGE" and node.outputs[ref.output].name == "Color" and plain_image(node, COLOUR_SPACES):
        return node
    return None


def number_source(folder, ref):
    """The image node behind a number: the channel of an image, or a grey image."""
    node = image_behind_factor(folder.nodes[ref.node])
    if node != folder.nodes[ref.node] and node.type == "TEX_IMAGE":
        return node if plain_image(node, DATA_SPACES) and is_grey(node.image) else None
    if node.type == "SEPARATE_COLOR" and node.mode == "RGB" and node.inputs[0].is_linked:
        source = node.inputs[0].links[0].from_socket
        good = source.node.type == "TEX_IMAGE" and source.name == "Color" and plain_image(source.node, DATA_SPACES)
        return source.node if good else None
    if node.type == "TEX_IMAGE" and node.outputs[ref.output].name == "Color" and plain_image(node, DATA_SPACES):
        return node if is_grey(node.image) else None
    return None


def normal_source(folder, ref):
    node = folder.nodes[ref.node]
    if node.type != "NORMAL_MAP" or node.space != "TANGENT" or getattr(node, "convention", "OPENGL") != "OPENGL" or node.inputs["Strength"].is_linked:
        return None
    if not node.inputs["Color"].is_linked:
        return None
    source = node.inputs["Color"].links[0].from_socket
    good = source.node.type == "TEX_IMAGE" and source.name == "Color" and plain_image(source.node, DATA_SPACES)
    if not good or coordinates_of(source.node)[0] not in ("", node.uv_map):
        return None
    return source.node


def alpha_source(folder, ref, base):
    """The alpha of the image whose colours are the base; of any image if the base is constant."""
    node = folder.nodes[ref.node]
    if node.type != "TEX_IMAGE" or node.outputs[ref.output].name != "Alpha" or not plain_image(node, COLOUR_SPACES):
        return None
    if is_constant(base):
        return node
    other = colour_source(folder, base)
    same = other is not None and other.image == node.image and coordinates_of(other) == coordinates_of(node)
    return node if same else None


def carried(folder, s):
    """The names of the channels that vary and that the exporter carries as they are."""
    found = set()
    if isinstance(s.base, Ref) and colour_source(folder, s.base):
        found.add("base")
    if isinstance(s.emission, Ref) and colour_source(folder, strength_of(folder, s.emission)[0]):
        found.add("emission")
    if isinstance(s.normal, Ref) and normal_source(folder, s.normal):
        found.add("normal")
    if isinstance(s.alpha, Ref) and alpha_source(folder, s.alpha, s.base):
        found.add("alpha")
    if isinstance(s.alpha, Ref) and "alpha" not in found:
        found.discard("base")  # they share a texture
    if "alpha" not in found and isinstance(s.base, Ref) and "base" not in found:
        found.discard("alpha")
    numbers = {n: number_source(folder, getattr(s, n)) for n in ("metallic", "roughness") if isinstance(getattr(s, n), Ref)}
    places = {coordinates_of(node) if node is not None else None for node in numbers.values()}
    if len(places) == 1 and None not in places:
        found.update(numbers)
    return found


# Baked pixels as images of 8 bits, and the nodes that show them to the exporter.

STEP = 0.6 / 255.0  # a texture that varies less is a constant


def srgb(linear):
    linear = numpy.clip(linear, 0.0, 1.0)
    return numpy.where(linear <= 0.0031308, linear * 12.92, 1.055 * numpy.power(linear, 1.0 / 2.4) - 0.055)


def picture(name, rgb, alpha=None, data=True):
    """A packed image of 8 bits from encoded values."""
    height, width = rgb.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=alpha is not None, is_data=data)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[:, :, :3] = rgb
    if alpha is not None:
        pixels[:, :, 3] = alpha
        image.alpha_mode = "CHANNEL_PACKED"
    image.pixels.foreach_set(numpy.clip(pixels, 0.0, 1.0).ravel())
    image.pack()
    return image


def is_flat(pixels):
    return float((pixels.max(axis=(0, 1)) - pixels.min(axis=(0, 1))).max()) < STEP


def make_textures(name, result):
    """The images of a job by channel, with the files of those that change."""
    frames = result.get("frames", [result])
    varies = any("numbers" in r and r["numbers"][:, :, 0].min() < 1.0 - STEP for r in frames)
    strength = max(max(float(r["emission"].max()) for r in frames), 1e-6) if "emission" in result else 1.0
    textures = {kind: show() for kind, show in pictures_of(name, result, varies, strength).items()}
    for kind, image in textures.items():
        parts = (kind, "numbers") if kind == "base" and varies else (kind,)
        if any(not numpy.array_equal(r[part], result[part]) for r in frames for part in parts):
            films.add_baked(image, (pictures_of(name, r, varies, strength)[kind]() for r in frames))
    if "emission" in textures:
        textures["emission"] = textures["emission"], strength
    return textures


def pictures_of(name, result, has_alpha, strength):
    """By channel what makes the image."""
    found = {}
    numbers = result.get("numbers")
    if "base" in result:
        alpha = numbers[:, :, 0] if has_alpha else None
        found["base"] = lambda: picture(name + " base", srgb(result["base"]), alpha, data=False)
    if "emission" in result:
        found["emission"] = lambda: picture(name + " emission", srgb(result["emission"] / strength), data=False)
    if "normal" in result:
        found["normal"] = lambda: picture(name + " normal", result["normal"])
    for n in ("coat_normal", "grain"):
        if n in result:
            found[n] = lambda n=n: picture("%s %s" % (name, n.replace("_", " ")), result[n])
    if "through_colour" in result:
        found["through_colour"] = lambda: picture(name + " through", srgb(result["through_colour"]), data=False)
    if numbers is not None:
        found["numbers"] = lambda: picture(name + " roughness, metallic", numpy.concatenate((numpy.ones_like(numbers[:, :, :1]), numbers[:, :, 1:]), 2))
    return found


def over_time(result, kind):
    """The pixels of a pass; where it changes, the least and the most of those of each frame."""
    if kind not in result:
        return None
    frames = {id(r[kind]): r[kind] for r in result.get("frames", [result])}.values()
    if len(frames) == 1:
        return result[kind]
    return numpy.stack([[f(pixels, axis=(0, 1)) for f in (numpy.min, numpy.max)] for pixels in frames]).astype(numpy.float32)


def means_of(plan, result):
    """Constants for the channels of a plan that do not vary after all, or whose mean is taken."""
    means = {}
    numbers = over_time(result, "numbers")
    alpha_varies = "alpha" in plan.baked and not is_flat(numbers[:, :, 0:1])
    for n in plan.baked:
        if n in NUMBERS:
            pixels = numbers[:, :, NUMBERS.index(n)][:, :, None]
        else:
            pixels = over_time(result, n)
        if is_flat(pixels) and n not in DIRECTIONS and not (n == "base" and alpha_varies):
            mean = pixels.mean(axis=(0, 1))
            means[n] = tuple(float(max(v, 0.0)) for v in mean) if len(mean) == 3 else float(min(max(mean[0], 0.0), 1.0))
    for i, group in enumerate(MEANS):
        for n, pixels in zip(group, numpy.moveaxis(result.get("means %d" % i, numpy.zeros((1, 1, 3))), 2, 0)):
            if n in plan.averaged:
                means[n] = float(max(pixels.mean(), 0.0))
    return means


def link_textures(tree, principled, textures, names):
    """Feeds channels from images over the baked coordinates; returns the strength of a baked emission."""
    place = tree.nodes.new("ShaderNodeUVMap")
    place.uv_map = LAYER

    def show(image):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.extension = image, "EXTEND"
        tree.links.new(place.outputs[0], node.inputs["Vector"])
        return node

    strength = None
    if "base" in names or "alpha" in names:
        node = show(textures["base"])
        tree.links.new(node.outputs["Color"], principled.inputs["Base Color"])
        if "alpha" in names:
            tree.links.new(node.outputs["Alpha"], principled.inputs["Alpha"])
    if "emission" in names:
        image, strength = textures["emission"]
        tree.links.new(show(image).outputs["Color"], socket(principled, "Emission"))
    if "normal" in names:
        node = tree.nodes.new("ShaderNodeNormalMap")
        node.uv_map = LAYER
        tree.links.new(show(textures["normal"]).outputs["Color"], node.inputs["Color"])
        tree.links.new(node.outputs[0], principled.inputs["Normal"])
    if "metallic" in names or "roughness" in names:
        split = tree.nodes.new("ShaderNodeSeparateColor")
        tree.links.new(show(textures["numbers"]).outputs["Color"], split.inputs[0])
        for n, channel in (("metallic", "Blue"), ("roughness", "Green")):
            if n in names:
                tree.links.new(split.outputs[channel], principled.inputs[n.capitalize()])
    return strength
