"""Nodes whose value depends on where a surface is seen from."""

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
