"""Nodes that give something only while rendering, or only to those who look from somewhere."""

VIEW = {"FRESNEL": None, "LAYER_WEIGHT": None, "CAMERA": None, "TEX_COORD": ("Camera", "Window", "Reflection"),
        "NEW_GEOMETRY": ("Incoming",)}


def give_constants(tree, warn):
    """Replaces what a node gives only while rendering by its value for a camera ray at the front."""
    for node in list(tree.nodes):
        if node.type == "LIGHT_PATH":
            used = [o for o in node.outputs if o.is_linked]
            if used:
                warn(node, "looks different to other rays: taken as the camera sees it")
            for output in used:
                value = 1.0 if output.name == "Is Camera Ray" else 0.0
                for target in [link.to_socket for link in output.links]:
                    for link in list(target.links):
                        tree.links.remove(link)
                    if getattr(target.default_value, "__len__", None) is None:
                        target.default_value = value
                    else:
                        for i in range(3):
                            target.default_value[i] = value


def view_nodes(nodes):
    """Those of some nodes that depend on where they are seen from."""
    found = []
    for node in nodes:
        if node.type in VIEW:
            names = VIEW[node.type]
            if names is None or any(node.outputs[n].is_linked for n in names):
                found.append(node)
    return found
