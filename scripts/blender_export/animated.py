"""What changes by keys, drivers or frames of a film within a tree of nodes, all of which is taken as in the first frame."""
from .hiding import animated_paths

FILMS = ("SEQUENCE", "MOVIE")


def trees_within(tree):
    """A tree and those of its groups."""
    found, left = [], [tree]
    while left:
        tree = left.pop()
        if tree is not None and tree not in found:
            found.append(tree)
            left += [n.node_tree for n in tree.nodes if n.type == "GROUP"]
    return found


def is_film(node):
    """Does an image node show another picture in another frame?"""
    if getattr(node, "image", None) is None or node.image.source not in FILMS:
        return False
    user = getattr(node, "image_user", None)
    return user is not None and user.use_auto_refresh and user.frame_duration > 1


def tell_animation(tree, tell):
    """Calls tell(node, text) for each node that changes; the node is None for what is not of one node."""
    for part in trees_within(tree):
        for path in sorted(animated_paths(part)):
            tell(part.nodes.get(path.split('"')[1]) if path.startswith('nodes["') else None, "animated or driven: taken as in the first frame")
        for node in part.nodes:
            if is_film(node):
                tell(node, "shows the frames of a film: taken as in the first frame")
