"""Materials that change: which of their channels become keys, which become image sequences, and which are lost by name."""
import contextlib
import math

from . import bake, films, shader_tree
from .channels import (ADDED, BLACK, Ref, WORDS, alpha_source, colour_source, coordinates_of, image_behind_factor, is_constant,
                       normal_source, number_source, strength_of)
from .gloss import base_of_principled
from .messages import warn
from .values import differs
from .versions import mixed_inputs

KEYED = ("base", "metallic", "roughness", "emission", "alpha", "normal")
CHANNELS = (*KEYED, *ADDED)
STILL = ("specular", "f0", "transmission", "ior", "clearcoat", "clearcoat_roughness", "through", "through_colour", "sheen",
         "sheen_roughness", "aspect", "turn", "film")  # no keys are read of these
NAMES = {"through": "share of what shines through", "sheen": "sheen", "sheen_roughness": "sheen", "aspect": "anisotropy",
         "turn": "direction of anisotropy", "film": "thin film"}
TEXTURES = {"base": "pbrMetallicRoughness/baseColorTexture", "alpha": "pbrMetallicRoughness/baseColorTexture",
            "metallic": "pbrMetallicRoughness/metallicRoughnessTexture", "roughness": "pbrMetallicRoughness/metallicRoughnessTexture",
            "emission": "emissiveTexture", "normal": "normalTexture"}
WHITE = (1.0, 1.0, 1.0)
TOLD = 0.02  # smaller changes of what has no keys are not


def signature(plan, ref):
    """What a channel that varies is made of, as text."""
    tree = plan.folder.tree
    node = plan.folder.nodes[ref.node]
    behind = shader_tree.nodes_behind(tree, list(node.inputs)) + [node]
    return repr((ref, bake.of_nodes(tree, behind)))


def factor_behind(node):
    """The constant that a node multiplies an image by, as a colour (channels.image_behind_factor)."""
    if image_behind_factor(node) == node:
        return WHITE
    pair = mixed_inputs(node)
    value = next(shader_tree.value_of(s) for s in pair if not s.is_linked)
    return value if isinstance(value, tuple) else (value,) * 3


class Look:
    """A channel in one state: what it shows, by what that is multiplied, and where the image of it lies."""

    def __init__(self, plan, name):
        s, folder = plan.surface, plan.folder
        self.value = getattr(s, name)
        self.shows, self.factor, self.place, self.node = "constant", WHITE, None, None
        if is_constant(self.value):
            return
        ref, strength = strength_of(folder, self.value) if name == "emission" else (self.value, 1.0)
        self.factor = (strength,) * 3
        if name not in plan.carried:
            self.shows = signature(plan, ref)
            return
        self.node = {"base": lambda: colour_source(folder, ref), "emission": lambda: colour_source(folder, ref),
                     "normal": lambda: normal_source(folder, ref), "alpha": lambda: alpha_source(folder, ref, s.base),
                     "metallic": lambda: number_source(folder, ref), "roughness": lambda: number_source(folder, ref)}[name]()
        first = folder.nodes[ref.node]
        if first != self.node and name in ("base", "emission", "metallic", "roughness"):
            self.factor = tuple(a * b for a, b in zip(self.factor, factor_behind(first)))
        uv, self.place = coordinates_of(self.node)
        socket = first.inputs["Strength"].default_value if name == "normal" else ref.output
        self.shows = repr((self.node.image.name, uv, self.node.extension, self.node.interpolation, socket))


class Changes:
    """What changes of a plan: `plans` are of its states, of which the plan itself is one."""

    def __init__(self, plan, plans, states):
        self.plan, self.plans, self.states = plan, plans, states
        self.number = plans.index(plan)
        self.looks = {n: [Look(p, n) for p in plans] for n in CHANNELS}
        self.played = set()  # channels of which every frame has a bake of its own
        self.keyed = set()
        self.made = []  # names of materials in Blender, with what their bakes left constant, and the strength of their emission
        for name in CHANNELS:
            self.sort(name)
        self.join()
        for p in plans:
            p.carried, p.baked, p.averaged = plan.carried, plan.baked, plan.averaged
        self.tell()

    def sort(self, name):
        """Keys, or an image for each frame?"""
        looks, plan = self.looks[name], self.plan
        lit = [look for look in looks if not (name == "emission" and look.value == BLACK)]
        shown = {look.shows for look in lit}
        if len(shown) > 1 or (name in plan.baked and self.shows_film(name)):
            plan.carried.discard(name)
            plan.baked.add(name)
            self.played.add(name)
        elif shown == {"constant"} or not shown:
            if name in KEYED and any(differs(look.value, looks[0].value) for look in looks):
                self.keyed.add(name)
        elif name in KEYED and (len({self.factor(name, i) for i in range(len(looks))}) > 1 or len({look.place for look in lit}) > 1):
            self.keyed.add(name)

    def shows_film(self, name):
        """Does a channel that is baked show the frames of a film?"""
        plan, states = self.plan, self.states
        value = getattr(plan.surface, name)
        if is_constant(value):
            return False
        node = plan.folder.nodes[value.node]
        behind = shader_tree.nodes_behind(plan.folder.tree, list(node.inputs)) + [node]
        return any(len(set(states.plays(n.name))) > 1 for n in behind if n.name in states.shown[0])

    def join(self):
        """Channels that share a texture are baked together."""
        plan = self.plan
        for pair in (("base", "alpha"), ("metallic", "roughness")):
            if not self.played & set(pair):
                continue
            for name in pair:
                if plan.carried & {name} or name == "base":
                    plan.carried.discard(name)
                    plan.baked.add(name)
                if name in plan.baked:
                    self.played.add(name)
                    self.keyed.discard(name)
        if "base" in plan.baked and "base" in self.keyed and self.looks["base"][0].shows == "constant":
            self.played.add("base")  # the texture of its alpha has its colour
            self.keyed.discard("base")

    def tell(self):
        first = self.plans[self.states.of_frames[0]].surface
        for name in STILL:
            values = [getattr(p.surface, name) for p in self.plans]
            if all(is_constant(v) for v in values) and any(is_other(v, getattr(first, name)) for v in values):
                self.plan.lose(None, "its %s changes: taken as in one of the frames" % (NAMES.get(name) or WORDS[name]))

    def plan_at(self, i):
        """The plan of an exported frame, if its bakes change."""
        return self.plans[self.states.of_frames[i]] if self.played else self.plan

    @contextlib.contextmanager
    def films_at(self, i):
        """Shows films as in an exported frame."""
        tree, states = self.plan_at(i).copy.node_tree, self.states
        films.show(tree, states.shown[states.of_frames[i]])
        yield
        films.show(tree, states.shown[states.of_frames[0]])

    def factor(self, name, i):
        """What the texture of a channel is multiplied by in a state, or its value."""
        look = self.looks[name][i]
        if look.shows == "constant":
            return look.value
        return look.factor

    def of_each(self, value):
        return self.states.of_each([value(i) for i in range(len(self.plans))])

    # keys

    def base(self, i, mean):
        """glTF's factor of the base colour in a state; `mean` stands for a base that was baked and does not vary."""
        plan, look, s = self.plans[i], self.looks["base"][i], self.plans[i].surface
        scaled = (s.scale / s.covered, s.lift) if (s.scale, s.lift) != (1.0, BLACK) else None
        factor, summand = base_of_principled(s) or scaled or (1.0, BLACK)
        is_textured = look.shows != "constant" and mean is None
        colour = mean or (look.factor if is_textured else look.value)
        alpha = s.alpha if is_constant(s.alpha) else 1.0
        return [min(max(c * factor + (0.0 if is_textured else x), 0.0), 1.0) for c, x in zip(colour, summand)] + [alpha]

    def write(self, name, tracks, means, strength):
        """Keys for a material of this name; returns what stands in it in the first frame, by path. `strength`: of the texture of its
        emission."""
        found = {}

        def key(path, values):
            if path not in found:
                tracks.material(name, path, values)
                found[path] = values[0]

        if self.keyed & {"base", "alpha", "roughness", "metallic"} and "base" not in self.played:
            values = self.of_each(lambda i: self.base(i, means.get("base")))
            if any(differs(v, values[0]) for v in values):
                key("pbrMetallicRoughness/baseColorFactor", values)
        for n in ("metallic", "roughness"):
            if n in self.keyed:
                key("pbrMetallicRoughness/%sFactor" % n, self.of_each(lambda i, n=n: mean(self.factor(n, i))))
        if "emission" in self.keyed:
            self.write_emission(key, strength)
        for n in KEYED:
            if n in self.keyed and any(look.place != self.looks[n][0].place for look in self.looks[n]):
                self.write_place(n, key)
        return found

    def write_emission(self, key, strength):
        values = [self.factor("emission", i) for i in range(len(self.plans))]
        if all(look.shows == "constant" for look in self.looks["emission"]):
            most = max(max(v) for v in values) or 1.0
            key("emissiveFactor", self.of_each(lambda i: [c / most for c in values[i]]))
            key("extensions/KHR_materials_emissive_strength/emissiveStrength", [most] * len(self.states.of_frames))
            return
        own = values[self.number][0]
        key("emissiveFactor", [WHITE] * len(self.states.of_frames))
        key("extensions/KHR_materials_emissive_strength/emissiveStrength",
            self.of_each(lambda i: strength * (values[i][0] / own if own > 0.0 else 0.0)))

    def write_place(self, name, key):
        """The transform of a texture: Blender's turns about the lower left corner, glTF's about the upper left one, downwards."""
        def transform(i):
            place = self.looks[name][i].place or self.looks[name][self.number].place
            (x, y), turn, (width, height) = place if place else ((0.0, 0.0), 0.0, (1.0, 1.0))
            return [x - height * math.sin(turn), 1.0 - y - height * math.cos(turn)], turn, [width, height]
        path = TEXTURES[name] + "/extensions/KHR_texture_transform/"
        for k, member in enumerate(("offset", "rotation", "scale")):
            key(path + member, self.of_each(lambda i, k=k: transform(i)[k]))

    # image sequences

    def play(self):
        """Writes the films that are carried as they are."""
        for name in sorted(self.plan.carried):
            node = self.looks[name][self.number].node
            states = self.states
            if node is None or node.name not in states.shown[0] or len(set(states.plays(node.name))) < 2:
                continue
            films.write(node.image, states.plays(node.name))


def finish(plans, tracks, patches):
    """Writes the keys of materials that change, and the files of their films."""
    for plan in plans:
        plan.changes.play()
        for name, means, strength in plan.changes.made:
            patch = patches.setdefault(name, {})
            patch["first"] = plan.changes.write(name, tracks, means, strength)
            patch["blends"] = "alpha" in plan.changes.keyed


def is_other(a, b):
    """Do values, each a number or three, differ by more than some of their own makes of rounding and of other channels?"""
    if a is None or b is None:
        return a is not b
    pairs = zip(*(v if isinstance(v, tuple) else (v,) * 3 for v in (a, b)))
    return any(abs(x - y) > TOLD * max(abs(x), abs(y), 0.1) for x, y in pairs)


def mean(value):
    return sum(value) / 3.0 if isinstance(value, tuple) else value


def richness(plan):
    """The state that is the plan's own is that in which most varies, and then the brightest."""
    s = plan.surface
    varies = sum(isinstance(getattr(s, n), Ref) for n in CHANNELS)
    if is_constant(s.emission):
        return varies, sum(s.emission)
    return varies, 3.0 * strength_of(plan.folder, s.emission)[1]


def plan_of(make_plan, material, places, states):
    """The plan of a material that may change."""
    plans = [make_plan(material, places, copy) for copy in states.copies]
    plan = max(plans, key=richness)
    for line in dict.fromkeys(line for p in plans for line in p.lines):
        warn(line)
    for p in plans:
        p.is_quiet = False
    if len(plans) > 1:
        plan.changes = Changes(plan, plans, states)
    return plan
