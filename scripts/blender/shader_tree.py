"""A shader tree made simple: one level, without groups, reroutes and muted nodes."""
import math

import bpy

from .channels import BLACK, MAGENTA, Ref, WHITE, is_constant, is_missing

# properties of the editor, and those that copying a node by its values must not touch
SKIPPED = {"rna_type", "name", "label", "location", "width", "width_hidden", "height", "dimensions", "select", "parent", "color",
           "use_custom_color", "show_options", "show_preview", "show_texture", "hide", "mute", "type", "inputs", "outputs",
           "internal_links", "interface", "is_active_output", "node_tree", "target", "location_absolute", "color_tag", "warning_propagation"}
DEEPEST = 16  # levels of groups


def copy_ramp(source, target):
    target.color_mode, target.interpolation = source.color_mode, source.interpolation
    target.hue_interpolation = source.hue_interpolation
    while len(target.elements) > 1:
        target.elements.remove(target.elements[-1])
    target.elements[0].position = source.elements[0].position
    target.elements[0].color = source.elements[0].color
    for element in list(source.elements)[1:]:
        new = target.elements.new(element.position)
        new.color = element.color


def copy_curves(source, target):
    for name in ("use_clip", "clip_min_x", "clip_min_y", "clip_max_x", "clip_max_y", "extend", "black_level", "white_level"):
        setattr(target, name, getattr(source, name))
    for old, new in zip(source.curves, target.curves):
        while len(new.points) > 2:
            new.points.remove(new.points[1])
        while len(new.points) < len(old.points):
            new.points.new(0.5, 0.5)
        for a, b in zip(old.points, new.points):
            b.location, b.handle_type = a.location, a.handle_type
    target.update()


def copy_values(source, target):
    """Copies what a node is set to, except its sockets."""
    for p in source.bl_rna.properties:
        if p.identifier in SKIPPED or p.identifier.startswith("bl_"):
            continue
        value = getattr(source, p.identifier, None)
        if p.type == "POINTER" and isinstance(value, bpy.types.ColorRamp):
            copy_ramp(value, getattr(target, p.identifier))
        elif p.type == "POINTER" and isinstance(value, bpy.types.CurveMapping):
            copy_curves(value, getattr(target, p.identifier))
        elif p.type == "POINTER" and p.is_readonly and value is not None and not isinstance(value, bpy.types.ID):
            copy_values(value, getattr(target, p.identifier))
        elif p.type != "COLLECTION" and not p.is_readonly:
            try:
                setattr(target, p.identifier, value)
            except (TypeError, AttributeError, ValueError):
                pass  # an enumerator of a list that is empty, and the like


def copy_node(tree, source):
    node = tree.nodes.new(source.bl_idname)
    if hasattr(source, "node_tree"):
        node.node_tree = source.node_tree
    copy_values(source, node)
    for a, b in zip(source.inputs, node.inputs):
        if hasattr(a, "default_value") and hasattr(b, "default_value"):
            b.default_value = a.default_value
    if source.type in ("VALUE", "RGB", "NORMAL"):
        node.outputs[0].default_value = source.outputs[0].default_value
    node.mute = source.mute
    return node


def constant(tree, value):
    """An output socket of a constant."""
    if isinstance(value, (int, float)):
        node = tree.nodes.new("ShaderNodeValue")
        node.outputs[0].default_value = value
    else:
        node = tree.nodes.new("ShaderNodeCombineXYZ")
        for i in range(3):
            node.inputs[i].default_value = value[i]
    return node.outputs[0]


def set_to(tree, target, value):
    """Gives an input that is linked a constant: its own, where it has one."""
    room = len(target.default_value) if hasattr(getattr(target, "default_value", None), "__len__") else 1
    if not hasattr(target, "default_value") or target.hide_value:
        tree.links.new(constant(tree, value), target)
        return
    for link in list(target.links):
        tree.links.remove(link)
    if room == 1:
        target.default_value = value if isinstance(value, float) else sum(value) / 3.0
    else:
        target.default_value = ((value,) * 3 + (1.0,) if isinstance(value, float) else (*value, 1.0))[:room]


def connect(tree, source, target):
    """Feeds an input from where another input is fed, or with its constant."""
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)
    elif hasattr(source, "default_value") and hasattr(target, "default_value") and not source.hide_value:
        tree.links.new(constant(tree, value_of(source)), target)


def value_of(socket):
    """The constant of a socket: a number, or three."""
    value = socket.default_value
    return float(value) if isinstance(value, (int, float)) else tuple(value)[:3]


def bypass(tree, node, source_of):
    """Removes a node; source_of gives for an output the input that takes its place, or None."""
    for output in node.outputs:
        source = source_of(output)
        for target in [link.to_socket for link in output.links]:
            if source is not None:
                connect(tree, source, target)
            else:
                for link in list(target.links):
                    tree.links.remove(link)
    tree.nodes.remove(node)


def through_muted(node):
    ways = {link.to_socket.identifier: link.from_socket for link in node.internal_links}
    return lambda output: ways.get(output.identifier)


def by_identifier(sockets, like):
    """The socket of a copied node, or None where it does not have it."""
    return next((s for s in sockets if s.identifier == like.identifier), None)


def inline(tree, group):
    """Replaces a group by copies of its nodes."""
    inner = group.node_tree
    copies = {n.name: copy_node(tree, n) for n in inner.nodes if n.type not in ("GROUP_INPUT", "GROUP_OUTPUT", "FRAME")}
    outer = {s.identifier: s for s in group.inputs}
    results = [n for n in inner.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]

    def feed(link, target):
        source = link.from_node
        if source.type == "GROUP_INPUT":
            if link.from_socket.identifier in outer:
                connect(tree, outer[link.from_socket.identifier], target)
        else:
            output = by_identifier(copies[source.name].outputs, link.from_socket)
            if output is not None:
                tree.links.new(output, target)

    for link in inner.links:
        if link.to_node.name in copies and link.from_socket.enabled:
            target = by_identifier(copies[link.to_node.name].inputs, link.to_socket)
            if target is not None:
                feed(link, target)
    for output in group.outputs:
        targets = [link.to_socket for link in output.links]
        for target in targets:
            for link in list(target.links):
                tree.links.remove(link)
            given = next((s for n in results for s in n.inputs if s.identifier == output.identifier), None)
            if given is None:
                continue
            if given.is_linked:
                feed(given.links[0], target)
            elif hasattr(given, "default_value") and hasattr(target, "default_value") and not given.hide_value:
                tree.links.new(constant(tree, value_of(given)), target)
    tree.nodes.remove(group)


def drop_node(tree, node):
    bypass(tree, node, lambda output: None)


def flatten(tree):
    """Simplifies a tree that belongs to nobody else."""
    for _ in range(DEEPEST):
        groups = [n for n in tree.nodes if n.type == "GROUP" and not n.mute]
        if not groups:
            break
        for group in groups:
            if group.node_tree is None:
                drop_node(tree, group)
            else:
                inline(tree, group)
    for node in list(tree.nodes):
        if node.type == "REROUTE":
            bypass(tree, node, lambda output: node.inputs[0])
        elif node.mute and node.type != "OUTPUT_MATERIAL":
            bypass(tree, node, through_muted(node))
        elif node.type == "FRAME":
            tree.nodes.remove(node)


def nodes_behind(tree, sockets):
    """All nodes that feed some inputs."""
    found, left = {}, [link.from_node for s in sockets for link in s.links]
    while left:
        node = left.pop()
        if node.name not in found:
            found[node.name] = node
            left += [link.from_node for i in node.inputs for link in i.links]
    return list(found.values())


def pin_coordinates(tree, name):
    """Names the set of texture coordinates that nodes use by default, so that another may become the default."""
    def given():
        node = tree.nodes.new("ShaderNodeUVMap")
        node.uv_map = name
        return node.outputs[0]

    for node in list(tree.nodes):
        if node.type == "TEX_IMAGE" and not node.inputs["Vector"].is_linked:
            tree.links.new(given(), node.inputs["Vector"])
        elif node.type == "TEX_COORD":
            for target in [link.to_socket for link in node.outputs["UV"].links]:
                tree.links.new(given(), target)
        elif node.type in ("UVMAP", "NORMAL_MAP", "TANGENT") and not node.uv_map:
            node.uv_map = name


# Nodes whose value depends on where a surface is seen from.

VIEW = {"FRESNEL": None, "LAYER_WEIGHT": None, "CAMERA": None, "TEX_COORD": ("Camera", "Window", "Reflection"),
        "NEW_GEOMETRY": ("Incoming",)}


def view_nodes(nodes):
    """Those of some nodes that depend on where they are seen from."""
    found = []
    for node in nodes:
        if node.type in VIEW:
            names = VIEW[node.type]
            if names is None or any(node.outputs[n].is_linked for n in names):
                found.append(node)
    return found


def is_by_angle(node):
    """Does it depend on the angle between the normal and the direction of view alone?"""
    return node.type in ("FRESNEL", "LAYER_WEIGHT", "NEW_GEOMETRY")


def see_at(tree, cosine):
    """Lets a bake, which sees everything straight on, show it at an angle: by shorter normals, of which nodes take the cosine."""
    nodes = [n for n in view_nodes(list(tree.nodes)) if is_by_angle(n)]
    if cosine == 1.0 or not nodes:
        return
    geometry, short = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
    short.operation = "SCALE"
    short.inputs["Scale"].default_value = cosine
    tree.links.new(geometry.outputs["Normal"], short.inputs[0])
    for node in nodes:
        targets = [link.to_socket for link in node.outputs["Incoming"].links] if node.type == "NEW_GEOMETRY" else [node.inputs["Normal"]]
        for target in targets:
            tree.links.new(short.outputs[0], target)


# What the inputs of shaders get: constants, or outputs of nodes, and what is calculated of the two.

CALCULATE = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b if b != 0.0 else 0.0,
    "MAXIMUM": max,
    "MINIMUM": min,
    "GREATER_THAN": lambda a, b: float(a > b),
    "LESS_THAN": lambda a, b: float(a < b),
}


def grey_of(colour):
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), colour))


class Values:
    """A shader tree, in which nodes are put that calculate; `warn(node, text)` tells what is lost."""

    def __init__(self, tree, warn):
        self.tree, self.nodes, self.warn = tree, tree.nodes, warn
        self.lose = warn  # for what changes the light of the whole picture

    def ref(self, socket):
        return Ref(socket.node.name, list(socket.node.outputs).index(socket))

    def socket(self, ref):
        return self.nodes[ref.node].outputs[ref.output]

    def read(self, socket):
        """The value that an input has."""
        if not socket.is_linked or not socket.links[0].is_valid:
            return value_of(socket)
        source = socket.links[0].from_socket
        kind, colour = source.node.type, socket.type in ("RGBA", "VECTOR")
        if is_missing(source.node):
            value = MAGENTA if source.name == "Color" else WHITE
            return value if colour else grey_of(value)
        if kind == "RGB":
            value = value_of(source)
            return value if colour else grey_of(value)
        if kind == "VALUE":
            value = value_of(source)
            return (value,) * 3 if colour else value
        if kind == "COMBXYZ" and not any(i.is_linked for i in source.node.inputs):
            value = tuple(i.default_value for i in source.node.inputs)
            return value if colour else sum(value) / 3.0
        if kind == "BLACKBODY" and colour and not source.node.inputs[0].is_linked:
            return colour_of(source.node.inputs[0].default_value)
        value = self.calculated(source.node) if kind == "MATH" else None
        if value is not None:
            return (value,) * 3 if colour else value
        return self.ref(source)

    def calculated(self, node):
        """What a Math node makes of constants; None if they are not, or by an operation that is not listed."""
        operation = CALCULATE.get(node.operation)
        values = [self.read(i) for i in node.inputs[:2]]
        if operation is None or not all(isinstance(v, float) for v in values):
            return None
        value = operation(*values)
        return min(max(value, 0.0), 1.0) if node.use_clamp else value

    def put(self, value, socket):
        if isinstance(value, Ref):
            self.tree.links.new(self.socket(value), socket)
        else:
            room = getattr(socket.default_value, "__len__", None)
            if room is None:
                socket.default_value = value if isinstance(value, (int, float)) else sum(value) / 3.0
            else:
                three = (value,) * 3 if isinstance(value, (int, float)) else tuple(value)
                socket.default_value = (three + (1.0,))[:room()]

    def vector(self, operation, *values):
        node = self.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for value, socket in zip(values, node.inputs):
            self.put(value, socket)
        return self.ref(node.outputs[0])

    def number(self, operation, *values, clamp=False):
        node = self.nodes.new("ShaderNodeMath")
        node.operation, node.use_clamp = operation, clamp
        for value, socket in zip(values, node.inputs):
            self.put(value, socket)
        return self.ref(node.outputs[0])

    def times(self, a, b, colour=False):
        """The product; b is a number or a colour, a colour only where `colour` is true."""
        if is_constant(a) and is_constant(b):
            if not colour:
                return a * b
            a, b = ((v,) * 3 if isinstance(v, (int, float)) else v for v in (a, b))
            return tuple(x * y for x, y in zip(a, b))
        for one, other in ((a, b), (b, a)):
            if one == 1.0 or one == WHITE:
                return other
            if one == 0.0 or one == BLACK:
                return BLACK if colour else 0.0
        return self.vector("MULTIPLY", a, b) if colour else self.number("MULTIPLY", a, b)

    def plus(self, a, b, colour=False):
        if is_constant(a) and is_constant(b):
            return tuple(x + y for x, y in zip(a, b)) if colour else a + b
        for one, other in ((a, b), (b, a)):
            if one == 0.0 or one == BLACK:
                return other
        return self.vector("ADD", a, b) if colour else self.number("ADD", a, b)

    def rest(self, t):
        return 1.0 - t if is_constant(t) else self.number("SUBTRACT", 1.0, t)

    def blend(self, a, b, t, colour=False):
        """a for t = 0, b for t = 1; what one side leaves open is the other's."""
        if a is None or b is None or a == b:
            return b if a is None else a
        if t == 0.0:
            return a
        if t == 1.0:
            return b
        return self.plus(self.times(a, self.rest(t), colour), self.times(b, t, colour), colour)


# The colour of a black body, as Cycles' node gives it: linear Rec. 709 of luminance 1.

# x, y, z of the CIE 1931 observer: weight, peak in nm, widths below and above (Wyman, Sloan, Shirley 2013, JCGT 2(2), table 1)
LOBES = (((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
         ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
         ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)))
FROM_XYZ = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))
SECOND = 0.014388  # hc/k, m K


def observer(lobes, nm):
    return sum(w * math.exp(-0.5 * ((nm - peak) / (below if nm < peak else above)) ** 2) for w, peak, below, above in lobes)


def colour_of(kelvin):
    kelvin = min(max(kelvin, 800.0), 12000.0)  # between which Cycles' colours change
    waves = [(nm, 1.0 / (nm ** 5 * math.expm1(SECOND / (nm * 1e-9 * kelvin)))) for nm in range(380, 781, 5)]
    xyz = [sum(observer(lobes, nm) * light for nm, light in waves) for lobes in LOBES]
    return tuple(max(sum(a * v for a, v in zip(row, xyz)) / xyz[1], 0.0) for row in FROM_XYZ)
