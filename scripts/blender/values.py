"""Values that change from frame to frame, whatever drives them: the states that materials, lamps and the world are in, and what of
them becomes keys.
"""
import bpy

from . import films, shader_tree
from .moves import animated_paths, trees_within
from .versions import has_nodes

ROOM = 1e-6  # values that differ by less, of 1, are the same


def differs(a, b):
    """Are two numbers, or rows of them, different values? None is none."""
    if a is None or b is None:
        return a is not b
    if isinstance(a, (int, float)):
        return abs(a - b) > ROOM * max(1.0, abs(a), abs(b))
    return any(differs(x, y) for x, y in zip(a, b))


def read_path(owner, path):
    try:
        value = owner.path_resolve(path)
    except (ValueError, TypeError):
        return None  # a key of something that is gone
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


class Source:
    """What may change in a datablock, and the trees within it."""

    def __init__(self, block):
        self.block = block
        trees = trees_within(block.node_tree) if has_nodes(block) else []
        self.paths = [(owner, path) for owner in [block, *trees] for path in sorted(animated_paths(owner))]
        nodes = [(tree, node.name) for tree in trees for node in tree.nodes]
        self.films = [(tree, name) for tree, name in nodes if films.is_film(tree.nodes[name])]
        self.places = [(tree, name) for tree, name in nodes if getattr(tree.nodes[name], "object", None) is not None]

    def may_change(self):
        return bool(self.paths or self.films or self.places)

    def state(self, frame):
        """What tells two states apart."""
        return (tuple(read_path(*pair) for pair in self.paths),
                tuple(films.number_of(tree.nodes[name], frame) for tree, name in self.films),
                tuple(tuple(map(tuple, tree.nodes[name].object.matrix_world)) for tree, name in self.places))


class States:
    """A datablock over the frames: copies that stand still, one for each state, and the number of the state in each frame."""

    def __init__(self, block):
        self.source = Source(block)
        self.copies, self.shown, self.of_frames, self.numbers = [], [], [], {}

    def note(self, frame):
        key = self.source.state(frame)
        if key not in self.numbers:
            self.numbers[key] = len(self.copies)
            self.add(frame)
        self.of_frames.append(self.numbers[key])

    def add(self, frame):
        copy = self.source.block.copy()
        if not isinstance(copy, bpy.types.Light):  # of which lights.py asks what is keyed
            copy.animation_data_clear()
        shown = {}
        if copy.node_tree is not None:
            copy.node_tree.animation_data_clear()
            shader_tree.flatten(copy.node_tree)
            hold_places(copy.node_tree)
            shown = films.shown_in(copy.node_tree, frame)
        self.copies.append(copy)
        self.shown.append(shown)

    def finish(self):
        """All states show the same image of each film, which stands still; `shown` says which it is in truth."""
        for copy in self.copies:
            films.show(copy.node_tree, self.shown[self.of_frames[0]])

    def plays(self, name):
        """The numbers of the images that a node shows in the frames."""
        return [self.shown[i][name][1] for i in self.of_frames]

    def of_each(self, values):
        """For each frame the value of its state."""
        return [values[i] for i in self.of_frames]


def hold_places(tree):
    """Coordinates of an object stay those that it has now."""
    for node in tree.nodes:
        o = getattr(node, "object", None)
        if o is not None:
            place = bpy.data.objects.new("place", None)
            place.matrix_world = o.matrix_world
            node.object = place


class Recorder:
    """Notes frame by frame the states of all that may change."""

    def __init__(self, scene):
        self.materials = self.of(bpy.data.materials)
        self.worlds = self.of([scene.world] if scene.world is not None else [])
        self.lamps = self.of(bpy.data.lights)

    @staticmethod
    def of(blocks):
        states = [States(block) for block in blocks if block.users > 0]
        return {s.source.block.name_full: s for s in states if s.source.may_change()}

    def every(self):
        return [*self.materials.values(), *self.worlds.values(), *self.lamps.values()]

    def note(self, frame):
        for states in self.every():
            states.note(frame)

    def finish(self):
        for states in self.every():
            states.finish()
