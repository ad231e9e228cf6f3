"""Makes the material that Blender's exporter carries, from a plan."""
import math

import bpy

from . import shader_tree
from .channels import BLACK, COLOURS, Ref, WHITE, is_constant
from .disney import base_of_principled
from .images import strength_of
from .names import socket as input_of
from .plans import VARYING
from .textures import link_textures

GREY = 0.8  # of Blender's surfaces without a material
MIRROR = 0.0316  # smoother metal is a perfect mirror to Reframe

NO_COAT = {"extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}

# Principled's coat takes nothing from the base: src/scene/gltf/gltf_lobe.c
ADDED_COAT = {"reframe": {"coat": "added"}}

patches = {}  # what Blender's exporter cannot write: for glb.finish, by the names of materials


def guess(name):
    """What a channel is taken for if it can be neither carried nor baked."""
    return {"base": (GREY,) * 3, "emission": BLACK, "normal": None, "metallic": 0.0, "roughness": 0.5, "alpha": 1.0,
            "specular": 1.0, "f0": 1.0, "transmission": 0.0, "ior": 1.5, "clearcoat": 0.0, "clearcoat_roughness": 0.0}[name]


def new_material(like, name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    if like is not None:
        for key in like.keys():
            if key not in ("cycles",):
                material[key] = like[key]
    return material


def shell(plan, name):
    """A material with a Principled node, and the plan's nodes where images are carried."""
    if plan.carried:
        material = plan.copy.copy()
        material.name = name
        tree = material.node_tree
        for node in list(tree.nodes):
            if node.type == "OUTPUT_MATERIAL":
                tree.nodes.remove(node)
        principled, out = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(principled.outputs[0], out.inputs["Surface"])
        return material, tree, principled
    material = new_material(plan.material, name)
    tree = material.node_tree
    return material, tree, tree.nodes["Principled BSDF"]


INPUTS = {"base": "Base Color", "metallic": "Metallic", "roughness": "Roughness", "emission": "Emission", "alpha": "Alpha",
          "normal": "Normal"}


def set_constant(principled, name, value):
    socket = input_of(principled, INPUTS[name])
    if name in COLOURS:
        socket.default_value = (*value, 1.0)
    else:
        socket.default_value = value


def build(plan, name, textures=None, means=None, solid=False):
    """The material to export; `textures` feed baked channels, `means` replace others."""
    s, means = plan.surface, means or {}
    material, tree, principled = shell(plan, name)
    lit = 1.0
    value = lambda n: means.get(n, guess(n)) if isinstance(getattr(s, n), Ref) else getattr(s, n)  # noqa: E731
    for n in VARYING:
        socket = input_of(principled, INPUTS[n])
        if n in plan.carried:
            ref = getattr(s, n)
            if n == "emission":
                ref, lit = strength_of(plan.folder, ref)
            tree.links.new(tree.nodes[ref.node].outputs[ref.output], socket)
        elif n == "normal" or n == "emission":
            continue
        elif n in plan.baked and textures is not None and n not in means:
            continue
        else:
            set_constant(principled, n, value(n))
    strength = lit
    if textures is not None:
        shining = link_textures(tree, principled, textures, [n for n in plan.baked if n not in means])
        strength = shining or strength
    if "emission" not in plan.carried and not input_of(principled, "Emission").is_linked:
        light = value("emission")
        strength = max(max(light), 1e-30)
        input_of(principled, "Emission").default_value = (*(c / strength for c in light), 1.0)
    principled.inputs["Emission Strength"].default_value = strength
    input_of(principled, "Specular").default_value = 0.5
    input_of(principled, "Clearcoat").default_value = value("clearcoat")
    input_of(principled, "Clearcoat Roughness").default_value = value("clearcoat_roughness")
    behind = {n.name for n in shader_tree.nodes_behind(tree, list(principled.inputs))} | {principled.name}
    for node in list(tree.nodes):
        if node.name not in behind and node.type != "OUTPUT_MATERIAL":
            tree.nodes.remove(node)
    # what a material says of culling and clipping is for Eevee
    material.use_backface_culling = s.one_sided
    alpha = value("alpha")
    varies = principled.inputs["Alpha"].is_linked
    material.blend_method = "BLEND" if varies or alpha < 1.0 else "OPAQUE"
    patches[material.name] = {**patch_of(plan, value, solid), "name": name}  # Blender counts up names that a library has
    return material


def patch_of(plan, value, solid):
    """Extensions of glTF that the exporter cannot write from a Principled node."""
    extensions = {}
    specular, f0, transmission = value("specular"), value("f0"), value("transmission")
    f0 = f0 if isinstance(f0, tuple) else (f0,) * 3
    if transmission > 0.0:
        extensions["KHR_materials_transmission"] = {"transmissionFactor": transmission}
        extensions["KHR_materials_ior"] = {"ior": max(value("ior"), 1.0)}
        if solid:
            inside = {"thicknessFactor": 1.0}
            if plan.absorption is not None and plan.absorption[1] > 0.0:
                colour, density = plan.absorption
                inside["attenuationDistance"] = 1.0 / density
                inside["attenuationColor"] = [math.exp(min(max(c, 0.0), 1.0) - 1.0) for c in colour]
            extensions["KHR_materials_volume"] = inside
        if transmission < 1.0:  # Cycles mixes the two, no coat covers both
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    elif specular < 1.0 or f0 != WHITE:
        extensions["KHR_materials_specular"] = {"specularFactor": specular}
        if f0 != WHITE:
            extensions["KHR_materials_specular"]["specularColorFactor"] = list(f0)
    s = plan.surface
    scaled = (s.scale / s.covered, s.lift) if (s.scale, s.lift) != (1.0, BLACK) else None
    patch = {"extensions": extensions, "base": base_of_principled(s) or scaled}
    if (s.principled or s.added) and specular > 0.0 and transmission == 0.0:
        patch["extras"] = ADDED_COAT
    if plan.copy is not None and value("metallic") == 1.0 and value("roughness") < MIRROR and is_constant(s.base):
        if transmission == 0.0 and s.emission == BLACK and s.alpha == 1.0 and s.normal is None and s.specular == 0.0:
            patch["extras"] = {"reframe": {"bsdf": "mirror", "specular": list(s.base)}}
    return patch
