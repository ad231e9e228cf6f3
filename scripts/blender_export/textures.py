"""Baked pixels as images of 8 bits, and the nodes that show them to the exporter."""
import bpy
import numpy

from .channels import LAYER, MEANS, NUMBERS
from .names import socket

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
    """The images of a job by channel."""
    textures = {}
    numbers = result.get("numbers")
    alpha = numbers[:, :, 0] if numbers is not None else None
    if "base" in result:
        varies = alpha is not None and alpha.min() < 1.0 - STEP
        textures["base"] = picture(name + " base", srgb(result["base"]), alpha if varies else None, data=False)
    if "emission" in result:
        strength = max(float(result["emission"].max()), 1e-6)
        textures["emission"] = (picture(name + " emission", srgb(result["emission"] / strength), data=False), strength)
    if "normal" in result:
        textures["normal"] = picture(name + " normal", result["normal"])
    if numbers is not None:
        both = numbers.copy()
        both[:, :, 0] = 1.0
        textures["numbers"] = picture(name + " roughness, metallic", both)
    return textures


def means_of(plan, result):
    """Constants for the channels of a plan that do not vary after all, or whose mean is taken."""
    means = {}
    numbers = result.get("numbers")
    alpha_varies = "alpha" in plan.baked and not is_flat(numbers[:, :, 0:1])
    for n in plan.baked:
        if n in NUMBERS:
            pixels = numbers[:, :, NUMBERS.index(n)][:, :, None]
        else:
            pixels = result[n]
        if is_flat(pixels) and n != "normal" and not (n == "base" and alpha_varies):
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
