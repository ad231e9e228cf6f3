"""Materials as glTF can carry them."""
import bpy


def glow(name, color, strength):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.use_backface_culling = True  # one-sided
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0, 0, 0, 1)
    principled.inputs["Roughness"].default_value = 1.0
    principled.inputs["Specular"].default_value = 0.0
    principled.inputs["Emission"].default_value = (*color, 1)
    principled.inputs["Emission Strength"].default_value = strength
    return material
