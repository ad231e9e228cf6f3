"""Anisotropic gloss as KHR_materials_anisotropy: how strong it is, and along what."""
import math

from .channels import LAYER, Ref, coordinates_of, is_constant, normal_source

LEAST = 0.01  # of the share by which Blender's roughnesses differ


def of_principled(amount):
    """Roughness is divided and multiplied by this root: along the tangent and across it."""
    return math.sqrt(1.0 - 0.9 * min(max(amount, 0.0), 1.0))


def put_on(folder, surface, node, amount, is_principled):
    """Notes the anisotropy of a node; `amount` is its value of it."""
    if amount == 0.0:
        return
    if not is_constant(amount):
        folder.warn(node, "anisotropy varies: taken as 0.5")
        amount = 0.5
    surface.aspect = of_principled(amount) if is_principled else 1.0 - min(abs(amount), 0.99)
    turn = node.inputs.get("Rotation") or node.inputs.get("Anisotropic Rotation")
    surface.turn = folder.read(turn) if turn is not None else 0.0
    surface.is_across = not is_principled and amount > 0.0
    tangent = node.inputs.get("Tangent")
    surface.tangent = folder.read(tangent) if tangent is not None and tangent.is_linked else None
    if not is_constant(surface.roughness):
        folder.warn(node, "anisotropy of a roughness that varies: taken as of a roughness of 0.5")


def strength_of(surface):
    """glTF's strength, and the factor of the roughness."""
    alpha = (surface.roughness if is_constant(surface.roughness) else 0.5) ** 2
    wide, narrow = min(alpha / surface.aspect, 1.0), alpha * surface.aspect
    return math.sqrt(max(wide - narrow, 0.0) / max(1.0 - narrow, 1e-6)), math.sqrt(surface.aspect)


def angle_of(surface):
    return 2.0 * math.pi * surface.turn + (0.5 * math.pi if surface.is_across else 0.0)


def is_along_coordinates(plan):
    """Is the tangent that which a glTF has without a texture: along its first coordinates?"""
    s = plan.surface
    if s.tangent is None or s.normal is not None or s.coat_normal is not None or not is_constant(s.turn):
        return False
    node = plan.folder.nodes[s.tangent.node]
    if node.type != "TANGENT" or node.direction_type != "UV_MAP":
        return False
    layers = [next((layer.name for layer in o.data.uv_layers if layer.active_render), None) for o, _ in plan.users]
    return None not in layers and all(node.uv_map in ("", name) for name in layers)


def settle(plan):
    """Makes the texture's directions, where coordinates do not give them."""
    s, folder = plan.surface, plan.folder
    if s.aspect > 1.0 - LEAST or s.transmission != 0.0 or is_along_coordinates(plan):
        return
    frame = LAYER
    if "normal" in plan.carried:  # whose tangents those of the mesh are
        frame = coordinates_of(normal_source(folder, s.normal))[0]

    def tangent(kind, name=""):
        node = folder.nodes.new("ShaderNodeTangent")
        node.direction_type, node.uv_map = kind, name
        return folder.ref(node.outputs[0])

    def dot(a, b):
        ref = folder.vector("DOT_PRODUCT", a, b)
        return Ref(ref.node, list(folder.nodes[ref.node].outputs).index(folder.nodes[ref.node].outputs["Value"]))

    normal = folder.ref(folder.nodes.new("ShaderNodeNewGeometry").outputs["Normal"])
    along, first = s.tangent if s.tangent is not None else tangent("RADIAL"), tangent("UV_MAP", frame)
    x, y = dot(along, first), dot(along, folder.vector("CROSS_PRODUCT", normal, first))
    if is_constant(s.turn):
        cosine, sine = math.cos(angle_of(s)), math.sin(angle_of(s))
    else:
        angle = folder.number("MULTIPLY_ADD", s.turn, 2.0 * math.pi, 0.5 * math.pi if s.is_across else 0.0)
        cosine, sine = folder.number("COSINE", angle), folder.number("SINE", angle)
    product = lambda a, b: folder.number("MULTIPLY", a, b)  # noqa: E731
    join = folder.nodes.new("ShaderNodeCombineXYZ")
    folder.put(folder.number("SUBTRACT", product(x, cosine), product(y, sine)), join.inputs[0])
    folder.put(folder.number("ADD", product(x, sine), product(y, cosine)), join.inputs[1])
    unit = folder.vector("NORMALIZE", folder.ref(join.outputs[0]))
    s.grain = folder.vector("MULTIPLY_ADD", unit, (0.5, 0.5, 0.0), (0.5, 0.5, 1.0))


def extension_of(surface):
    strength, _ = strength_of(surface)
    turn = 0.0 if isinstance(surface.grain, Ref) or not is_constant(surface.turn) else angle_of(surface)
    return {"anisotropyStrength": strength, "anisotropyRotation": turn}
