"""Words for making the scenes of tests inside Blender, beside those of scripts/parity."""
import math
import os

import bpy

from blender.cycles import set_cycles, write_picture
from blender.versions import give_nodes, mixed_inputs, panorama_of, principled_of, set_format, socket  # noqa: F401
from parity.words import add, give, glow, key, lamp_nodes, matte, mix, placed, world  # noqa: F401

BOUNCES = 24


def begin(last=1, first=1, size=None):
    """An empty scene of these frames."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = first, last
    cycles = scene.cycles  # without Blender's limits of light, of which the exporter warns
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = cycles.max_bounces
    cycles.blur_glossy = cycles.sample_clamp_indirect = 0.0
    if size is not None:
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    return scene


def eye(place=(0, -6, 0), turn=(math.pi / 2, 0, 0), name="Eye"):
    """The camera of the scene."""
    o = bpy.context.scene.camera = placed(name, bpy.data.cameras.new(name), place, turn)
    return o


def lamp(kind, name, place=(0, 0, 3), turn=(0, 0, 0), **settings):
    o = placed(name, bpy.data.lights.new(name, kind), place, turn)
    for setting, value in settings.items():
        setattr(o.data, setting, value)
    return o


def compositor(scene):
    """A tree of the compositor without nodes, and its output node."""
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        add_socket(tree, "OUTPUT", "NodeSocketColor", "Image")
        return tree, tree.nodes.new("NodeGroupOutput")
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite")


def save(name):
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(name + ".blend"), check_existing=False)


def write_by_cycles(path, samples, frame=1, bounces=BOUNCES):
    """A picture of the scene, of its size."""
    scene = bpy.context.scene
    render = scene.render
    size = [n * render.resolution_percentage // 100 for n in (render.resolution_x, render.resolution_y)]
    set_cycles(scene, {"size": size, "threads": os.cpu_count(), "samples": samples, "bounces": bounces})
    scene.cycles.transparent_max_bounces = bounces
    render.image_settings.color_mode = "RGB"
    write_picture(scene, os.path.abspath(path), frame)


class Shader:
    """The nodes of a material."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        give_nodes(self.material)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.out = self.add("OutputMaterial")

    def add(self, kind, **inputs):
        return add(self.tree, kind, **inputs)

    def feed(self, into, value):
        give(self.tree, into, value)

    def mix(self, factor, a, b):
        return mix(self.tree, factor, a, b)

    def sum(self, a, b):
        node = self.add("AddShader")
        self.feed(node.inputs[0], a)
        self.feed(node.inputs[1], b)
        return node

    def math(self, kind, operation, a, b):
        """A node Math or VectorMath."""
        node = self.add(kind)
        node.operation = operation
        self.feed(node.inputs[0], a)
        self.feed(node.inputs["Scale" if operation == "SCALE" else 1], b)
        return node

    def done(self, shader, **inputs):
        for name, value in {"Surface": shader, **inputs}.items():
            self.feed(self.out.inputs[name], value)
        return self.material


def grey(value):
    return (value, value, value, 1.0)


def shine(name, colour):
    return glow(colour, 1.0, name)


def add_socket(tree, side, kind, name):
    """A socket of a group; `side`: INPUT or OUTPUT."""
    if hasattr(tree, "interface"):
        tree.interface.new_socket(name, in_out=side, socket_type=kind)
    else:
        (tree.inputs if side == "INPUT" else tree.outputs).new(kind, name)


def geometry_group(o, *chain, name=None):
    """A modifier of o: geometry goes through these nodes, which it returns."""
    tree = bpy.data.node_groups.new(name or o.name, "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        add_socket(tree, side, "NodeSocketGeometry", "Geometry")
    nodes = [tree.nodes.new(kind) for kind in ("NodeGroupInput", *chain, "NodeGroupOutput")]
    for a, b in zip(nodes, nodes[1:]):
        tree.links.new(a.outputs[0], b.inputs[0])
    o.modifiers.new(name or "nodes", "NODES").node_group = tree
    return nodes[1:-1]


def lights_without_shadow(light):
    own = light.cycles if hasattr(light.cycles, "cast_shadow") else light
    setattr(own, "cast_shadow" if own != light else "use_shadow", False)


def moved_to(collection, *objects):
    """From the scene into a collection."""
    for o in objects:
        bpy.context.scene.collection.objects.unlink(o)
        collection.objects.link(o)
    return collection


def instances_of(collection, name="place", place=(0, 0, 0)):
    o = placed(name, None, place)
    o.instance_type, o.instance_collection = "COLLECTION", collection
    return o
