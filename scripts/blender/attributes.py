"""Attribute nodes that ask objects, what makes instances of them, or the view layer for a value: each becomes that value, in a copy of the
material for every set of values that its objects have.
"""
import bpy

from . import shader_tree
from .moves import trees_within
from .versions import has_nodes

ASKING = ("OBJECT", "INSTANCER", "VIEW_LAYER")


def asking_nodes(tree):
    return [n for n in tree.nodes if n.type == "ATTRIBUTE" and n.attribute_type in ASKING and n.attribute_name]


def value_in(block, name):
    """A custom property, or another one by its path, as Cycles takes it: four numbers; None if there is none."""
    if block is None:
        return None
    for path in ('["%s"]' % bpy.utils.escape_identifier(name), name):
        try:
            value = block.path_resolve(path)
        except (ValueError, TypeError):
            continue
        if isinstance(value, (bool, int, float)):
            return (float(value),) * 3 + (1.0,)
        try:
            numbers = [float(v) for v in value][:4]
        except (TypeError, ValueError):
            continue
        return tuple(numbers + [0.0, 0.0, 0.0, 1.0][len(numbers):])
    return None


def value_of(node, o):
    """What a node gives on an object; black where nothing has it."""
    scene = bpy.context.scene
    blocks = (bpy.context.view_layer, scene, scene.world) if node.attribute_type == "VIEW_LAYER" else (o, o.data)
    return next((v for v in (value_in(block, node.attribute_name) for block in blocks) if v is not None), (0.0, 0.0, 0.0, 0.0))


def give_values(tree, values):
    """Puts constants in the place of nodes."""
    for node, value in zip(asking_nodes(tree), values):
        for output in node.outputs:
            number = {"Fac": sum(value[:3]) / 3.0, "Factor": sum(value[:3]) / 3.0, "Alpha": value[3]}.get(output.name)
            for target in [link.to_socket for link in output.links]:
                shader_tree.set_to(tree, target, number if number is not None else value[:3])
        tree.nodes.remove(node)


def settle(objects, changing):
    """`changing`: the names of materials that have keys, which stay as they are."""
    copies, flat = {}, {}
    for o in objects:
        for slot in o.material_slots:
            material = slot.material
            if material is None or material.name_full in changing or not has_nodes(material):
                continue
            if not any(asking_nodes(tree) for tree in trees_within(material.node_tree)):
                continue
            if material not in flat:
                flat[material] = material.copy()
                shader_tree.flatten(flat[material].node_tree)
            values = tuple(value_of(node, o) for node in asking_nodes(flat[material].node_tree))
            if (material, values) not in copies:
                made = copies[material, values] = flat[material].copy()
                give_values(made.node_tree, values)
            if o.data.users > 1:
                slot.link = "OBJECT"
            slot.material = copies[material, values]
    for material in flat.values():
        bpy.data.materials.remove(material)
