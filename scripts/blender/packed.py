"""Roughness and metallic that are a channel of an image, or a linear function of one: packed as a grey image in place of a bake."""
import numpy

from .channels import COLOUR_SPACES, DATA_SPACES, Ref, coordinates_of, is_clear, number_source, picture, plain_image

LUMINANCE = (0.2126729, 0.7151522, 0.0721750, 0.0)  # by which Cycles makes a number of a colour
CHANNELS = {"Red": 0, "Green": 1, "Blue": 2, "R": 0, "G": 1, "B": 2, "X": 0, "Y": 1, "Z": 2}  # of nodes that separate
STEEPEST = 4.0  # gain, beyond which steps of 8 bits are seen

_made = {}  # images, by what they show


def linear(socket):
    """(image node, weights of R, G, B and A, gain, offset) of what an output gives, with None for the weights of a colour; else None."""
    node = socket.node
    if node.type == "TEX_IMAGE":
        is_whole = plain_image(node, COLOUR_SPACES + DATA_SPACES, deep=True)
        return (node, (0.0, 0.0, 0.0, 1.0) if socket.name == "Alpha" else None, 1.0, 0.0) if is_whole else None
    if node.type in ("SEPARATE_COLOR", "SEPXYZ", "SEPRGB", "RGBTOBW") and getattr(node, "mode", "RGB") == "RGB":
        found = behind(node.inputs[0])
        if found is None or found[1] is not None:
            return None
        weights = LUMINANCE if node.type == "RGBTOBW" else tuple(float(i == CHANNELS[socket.name]) for i in range(4))
        return found[0], weights, *found[2:]
    if node.type == "INVERT" and not node.inputs[0].is_linked:
        share = node.inputs[0].default_value
        return scaled(behind(node.inputs[1]), 1.0 - 2.0 * share, share)
    if node.type == "MATH" and not node.use_clamp and node.operation in ("ADD", "SUBTRACT", "MULTIPLY"):
        first, second = node.inputs[:2]
        if first.is_linked == second.is_linked:
            return None
        found, value = as_number(behind(first if first.is_linked else second)), (second if first.is_linked else first).default_value
        if node.operation == "MULTIPLY":
            return scaled(found, value, 0.0)
        sign = -1.0 if node.operation == "SUBTRACT" else 1.0
        return scaled(found, 1.0, sign * value) if first.is_linked else scaled(found, sign, value)
    return None


def behind(socket):
    return linear(socket.links[0].from_socket) if socket.is_linked and socket.links[0].is_valid else None


def as_number(found):
    return found if found is None or found[1] is not None else (found[0], LUMINANCE, *found[2:])


def scaled(found, gain, offset):
    return found and (*found[:2], gain * found[2], gain * found[3] + offset)


def image_of(image, weights, gain, offset):
    key = image.name_full, weights, gain, offset
    if key not in _made:
        width, height = image.size
        pixels = numpy.empty(width * height * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(height, width, image.channels)
        if image.channels < 4:  # grey, or without alpha
            pixels = numpy.dstack([pixels[:, :, :1]] * 3 + [numpy.ones_like(pixels[:, :, :1])]) if image.channels < 3 else numpy.dstack(
                [pixels, numpy.ones_like(pixels[:, :, :1])])
        if image.colorspace_settings.name in COLOUR_SPACES and not image.is_float:
            rgb = pixels[:, :, :3]
            pixels[:, :, :3] = numpy.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        value = gain * (pixels @ numpy.array(weights, numpy.float32)) + offset
        _made[key] = picture(image.name + " as a number", value[:, :, None])
    return _made[key]


def is_as_stored(image, weights):
    """Does Cycles show the pixels of an image as they are stored, and not by their alpha?"""
    if not is_clear(image):
        return True
    return image.alpha_mode != "NONE" if weights[3] > 0.0 else image.alpha_mode == "CHANNEL_PACKED" and not image.is_float


def settle(folder, surface):
    """Feeds roughness and metallic from packed images where these are all that is behind them; returns whether it did."""
    found, places = {}, set()
    for name in ("roughness", "metallic"):
        ref = getattr(surface, name)
        source = number_source(folder, ref) if isinstance(ref, Ref) else None
        if isinstance(ref, Ref) and source is None:
            function = as_number(linear(folder.socket(ref)))
            if function is None or abs(function[2]) > STEEPEST or not is_as_stored(function[0].image, function[1]):
                return False
            found[name], source = function, function[0]
        places |= {coordinates_of(source)} if source is not None else set()
    if len(places) > 1:
        return False  # they share a texture
    for name, (source, *function) in found.items():
        node = folder.nodes.new("ShaderNodeTexImage")
        node.name = "reframe " + name
        node.image, node.interpolation, node.extension = image_of(source.image, *function), source.interpolation, source.extension
        if source.inputs["Vector"].is_linked:
            folder.tree.links.new(source.inputs["Vector"].links[0].from_socket, node.inputs["Vector"])
        setattr(surface, name, folder.ref(node.outputs["Color"]))
    return bool(found)
