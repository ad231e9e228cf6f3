"""Which inputs Blender's exporter carries as they are: images in ordinary coordinates."""
import numpy

from .channels import Ref, is_constant

COLOUR_SPACES = ("sRGB",)
DATA_SPACES = ("Non-Color", "Linear", "Linear Rec.709", "Raw")
PICTURES = 64  # an image is grey if the channels of so many of its pixels agree

_grey = {}


def is_read(image):
    """Is the image there? Asking for a pixel loads it."""
    return image is not None and image.size[0] > 0 and (image.has_data or len(image.pixels) > 0)


def is_grey(image):
    key = image.name_full
    if key not in _grey:
        count = image.size[0] * image.size[1]
        pixels = numpy.empty(count * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        some = pixels.reshape(count, image.channels)[::max(count // PICTURES ** 2, 1)]
        _grey[key] = image.channels < 3 or float(abs(some[:, :3] - some[:, :1]).max()) < 0.02
    return _grey[key]


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


def plain_image(node, spaces):
    """Is this an image node whose pixels glTF can carry?"""
    image = node.image
    return (node.type == "TEX_IMAGE" and is_read(image) and image.source in ("FILE", "GENERATED") and not image.is_float and
            node.projection == "FLAT" and node.extension in ("REPEAT", "EXTEND") and
            image.colorspace_settings.name in spaces and coordinates_of(node) is not None)


def image_behind_factor(node):
    """The image node that a node multiplies by a constant, which the exporter makes a factor; else the node itself."""
    if node.type == "MIX" and node.data_type == "RGBA" and node.blend_type == "MULTIPLY" and not node.clamp_result:
        if node.inputs[0].is_linked or node.inputs[0].default_value != 1.0:
            return node
        pair = node.inputs[6:8]
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
    if node.type != "NORMAL_MAP" or node.space != "TANGENT" or node.inputs["Strength"].is_linked:
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
