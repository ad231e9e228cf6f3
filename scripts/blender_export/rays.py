"""Shaders that look different to other rays (Light Path): which of their looks serves the picture best."""
import bpy

from . import shader_tree
from .channels import BLACK, finish, is_constant
from .folding import Folder

OUTPUTS = {  # of Light Path, at the first hit of a ray
    "camera": {"Is Camera Ray": 1.0},
    "shadow": {"Is Shadow Ray": 1.0, "Ray Depth": 1.0},
    "diffuse": {"Is Diffuse Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0},
}


def nodes_that_ask(nodes):
    return [n for n in nodes if n.type == "LIGHT_PATH" and any(o.is_linked for o in n.outputs)]


def give_constants(tree, ray):
    """Replaces what Light Path gives by its values for a kind of ray; returns the names of the nodes that asked for it."""
    asked = set()
    for node in nodes_that_ask(tree.nodes):
        for output in node.outputs:
            value = OUTPUTS[ray].get(output.name, 0.0)
            for target in [link.to_socket for link in output.links]:
                asked.add(target.node.name)
                for link in list(target.links):
                    tree.links.remove(link)
                room = getattr(target.default_value, "__len__", None)
                target.default_value = value if room is None else (value,) * room()
    return asked


def seen_by(material, ray):
    """The surface that a kind of ray meets, and whether its emission varies and differs between them."""
    copy = material.copy()
    tree = copy.node_tree
    shader_tree.flatten(tree)
    asked = give_constants(tree, ray)
    surface = finish(Folder(tree, lambda node, text: None).fold(tree.get_output_node("CYCLES").inputs["Surface"]))
    differs = False
    if not is_constant(surface.emission):
        node = tree.nodes[surface.emission.node]
        differs = any(n.name in asked for n in shader_tree.nodes_behind(tree, list(node.inputs)) + [node])
    bpy.data.materials.remove(copy)
    return surface, differs


def passes(surface):
    """Does light go straight through, at most tinted?"""
    return surface.alpha == 0.0 or (surface.alpha == 1.0 and surface.transmission == 1.0 and surface.ior == 1.0)


def choose(material, nodes, tell):
    """The kind of ray whose look is taken, and whether that is a thin pane. Without Light Path: the camera's, no."""
    asking = nodes_that_ask(nodes)
    if not asking:
        return "camera", False
    (camera, _), (shadow, _), (diffuse, differs) = (seen_by(material, ray) for ray in ("camera", "shadow", "diffuse"))
    if differs or camera.emission != diffuse.emission:
        hidden = camera.alpha == 0.0 and diffuse.emission != BLACK
        tell(asking[0], "hidden from the camera, but lights the scene: seen by all rays" if hidden else
             "shines differently to the camera: taken as it lights the scene")
        return "diffuse", False
    if is_constant(camera.transmission) and camera.transmission > 0.0 and passes(shadow):
        tell(asking[0], "glass that lets shadow rays pass: taken as a thin pane")
        return "camera", True
    tell(asking[0], "looks different to other rays: taken as the camera sees it")
    return "camera", False
