"""A shader tree made simple: one level, without groups, reroutes and muted nodes."""
import bpy

# properties of the editor, and those that copying a node by its values must not touch
SKIPPED = {"rna_type", "name", "label", "location", "width", "width_hidden", "height", "dimensions", "select", "parent", "color",
           "use_custom_color", "show_options", "show_preview", "show_texture", "hide", "mute", "type", "inputs", "outputs",
           "internal_links", "interface", "is_active_output", "node_tree", "target"}
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
            tree.links.new(copies[source.name].outputs[list(source.outputs).index(link.from_socket)], target)

    for link in inner.links:
        if link.to_node.name in copies and link.from_socket.enabled:
            feed(link, copies[link.to_node.name].inputs[list(link.to_node.inputs).index(link.to_socket)])
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
