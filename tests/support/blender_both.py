"""What Blender 3 and 4 call differently, for the scripts that make the scenes of tests."""
import bpy

PRINCIPLED = {"Specular": "Specular IOR Level", "Emission": "Emission Color", "Subsurface": "Subsurface Weight", "Sheen": "Sheen Weight"}


def socket(node, name):
    """An input of a Principled node by the name that Blender 3 has for it."""
    found = node.inputs.get(PRINCIPLED.get(name, name))
    return found if found is not None else node.inputs[name]


def add_socket(tree, side, kind, name):
    """A socket of a group; `side`: INPUT or OUTPUT."""
    if hasattr(tree, "interface"):
        tree.interface.new_socket(name, in_out=side, socket_type=kind)
    else:
        (tree.inputs if side == "INPUT" else tree.outputs).new(kind, name)


def geometry_tree(name):
    """A group that takes and gives geometry."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        add_socket(tree, side, "NodeSocketGeometry", "Geometry")
    return tree


def lights_without_shadow(light):
    own = light.cycles if hasattr(light.cycles, "cast_shadow") else light
    setattr(own, "cast_shadow" if own != light else "use_shadow", False)


def panorama_of(camera):
    return camera if hasattr(camera, "panorama_type") else camera.cycles
