"""What is to be done about a material: left as it is, replaced, or baked."""
import bpy

from . import displacement, grain, packed, shader_tree
from .channels import ADDED, BLACK, Ref, Surface, WORDS, carried, finish, is_constant, is_missing, number_source
from .folding import Folder, settle_flat
from .gloss import base_of_principled, tell_held
from .messages import lose, warn
from .shader_tree import view_nodes
from .versions import has_nodes, has_transparent_shadow, is_principled_2

VARYING = ("base", "metallic", "roughness", "emission", "alpha", "normal")  # what glTF has textures for
EXPORTED = {"f0": "Specular", "transmission": "Transmission", "clearcoat": "Clearcoat",
            "clearcoat_roughness": "Clearcoat Roughness"}  # whose images the exporter carries from a Principled node


class Plan:
    """A material, what its tree folds into, and what is to be done about it."""

    def __init__(self, material, users):
        self.material, self.users = material, users
        self.copy = self.folder = self.surface = None
        self.carried, self.baked, self.averaged = set(), set(), set()
        self.plain = self.displaces = False
        self.absorption = None  # colour and density of what is inside
        self.lifted = 1.0, BLACK  # the factor and the summand of a base that is baked
        self.lines = []  # that were told
        self.is_quiet = False
        self.changes = None  # keyed.Changes
        self.name = None  # once it is freed

    def who(self):
        names = sorted({o.name for o, _ in self.users})
        more = " and %d more" % (len(names) - 1) if len(names) > 1 else ""
        return "'%s'%s: material '%s'" % (names[0], more, self.name or self.material.name)

    def free_name(self):
        """The name of the material, for the one that replaces it; names of a library stand beside ours."""
        if self.name is None:
            self.name = self.material.name
            if self.material.library is None:
                self.material.name = self.name + " (before export)"
        return self.name

    def line(self, node, text):
        return "%s%s: %s" % (self.who(), ", node '%s'" % node.name if node is not None else "", text)

    def tell(self, node, text):
        line = self.line(node, text)
        self.say(line, warn)

    def lose(self, node, text):
        self.say(self.line(node, text), lose)

    def say(self, line, how):
        if line not in self.lines:
            self.lines.append(line)
            if not self.is_quiet:
                how(line)


def size_of(users):
    """The mean radius of bodies, those of balls that have as much volume for their surface as the boxes around them."""
    sizes = []
    for a, b, c in {o.name: tuple(o.dimensions) for o, _ in users}.values():
        sizes.append(1.5 * a * b * c / max(a * b + b * c + c * a, 1e-12))
    return sum(sizes) / max(len(sizes), 1)


def copy_of(material):
    copy = material.copy()
    if copy.node_tree is not None:
        copy.node_tree.animation_data_clear()
    return copy


def tell_inside(plan, out):
    """Remembers an absorbing inside; says what else is lost with a volume."""
    socket = out.inputs["Volume"]
    if not socket.is_linked:
        return
    node = socket.links[0].from_node
    if node.type == "VOLUME_ABSORPTION" and plan.surface.transmission not in (None, 0.0):
        colour, density = (plan.folder.read(node.inputs[n]) for n in ("Color", "Density"))
        if is_constant(colour) and is_constant(density):
            plan.absorption = (colour, density)
            return
    plan.tell(node, "volume: left out")


def is_ours(material):
    """Does a custom property give the scattering model itself?"""
    own = material.get("reframe")
    return hasattr(own, "keys") and "bsdf" in own.keys()


def make_plan(material, users, still=None):
    """`still`: a copy of a material that changes, as it is in some of the frames; what is lost is not told yet."""
    plan = Plan(material, users)
    plan.is_quiet = still is not None
    if not has_nodes(material):
        plan.surface = finish(Surface(base=tuple((still or material).diffuse_color)[:3], specular=0.0))
        return plan
    plan.copy = still or copy_of(material)
    tree = plan.copy.node_tree
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree is None:
            plan.tell(node, "its group is missing: left out")
    grouped = any(n.type in ("GROUP", "REROUTE") or n.mute for n in tree.nodes)
    shader_tree.flatten(tree)
    plan.folder = folder = Folder(tree, plan.tell)
    folder.lose, folder.size = plan.lose, size_of(users)
    out = tree.get_output_node("CYCLES")
    if out is None:
        plan.tell(None, "no output: taken as black")
        plan.surface = finish(Surface(base=BLACK, specular=0.0))
        return plan
    if out.inputs["Displacement"].is_linked:
        method = displacement.method_of(material)
        plan.displaces = method != "BUMP"
        if method != "DISPLACEMENT":
            displacement.make_bump(tree, out, displacement.scale_of(tree, out, users))
    behind = shader_tree.nodes_behind(tree, [out.inputs["Surface"]])
    asks = bool(nodes_that_ask(behind))
    ray, thin = choose(plan.copy, behind, plan.tell)
    give_constants(tree, ray)
    only_volume = out.inputs["Volume"].is_linked and not out.inputs["Surface"].is_linked
    plan.surface = folder.fold(out.inputs["Surface"]) if not only_volume else Surface(alpha=0.0)
    tell_inside(plan, out)
    is_odd = tell_odd(plan)
    finish(plan.surface)
    settle_flat(folder, plan.surface)
    plan.surface.thin |= thin
    tell_held(plan)
    tell_shadows(plan)
    shine_through(plan)
    tell_images(plan, behind)
    is_packed = packed.settle(folder, plan.surface)
    sort_channels(plan)
    first = out.inputs["Surface"].links[0].from_node if out.inputs["Surface"].is_linked else None
    if still is not None or first is None or first.type != "BSDF_PRINCIPLED" or grouped or is_principled_2(first):
        return plan
    plan.averaged -= {n for n, name in EXPORTED.items() if is_image(folder, first.inputs[name])}
    plan.plain = (not asks and not is_packed and not plan.baked and not plan.averaged and
                  not out.inputs["Displacement"].is_linked and is_only_output(material) and
                  not any(first.inputs[n].is_linked for n in ("Subsurface", "Subsurface Color")) and
                  first.inputs["Subsurface"].default_value == 0.0 and max(plan.surface.sheen) == 0.0 and plan.surface.aspect == 1.0 and
                  not is_odd and not any(is_missing(n) for n in behind))
    return plan


def tell_odd(plan):
    """Constants that no surface has, which are clamped."""
    s = plan.surface
    takes = is_constant(s.emission) and min(s.emission) < 0.0
    if takes:
        plan.tell(None, "takes light away in Blender: does not shine here")
    reflects = s.base is not None and is_constant(s.base) and max(s.base) > 1.0
    if reflects:
        plan.tell(None, "reflects more light than arrives in Blender: its colour is taken as 1 at most")
    return takes or reflects


def tell_shadows(plan):
    s = plan.surface
    passes = s.alpha != 1.0 or s.transmission != 0.0 and s.ior == 1.0
    if passes and not has_transparent_shadow(plan.material):
        plan.tell(None, "has no transparent shadows in Blender: has them here")


def is_image(folder, socket):
    value = folder.read(socket)
    return isinstance(value, Ref) and number_source(folder, value) is not None


def is_only_output(material):
    return sum(n.type == "OUTPUT_MATERIAL" for n in material.node_tree.nodes) == 1


def shine_through(plan):
    """glTF's emission is that of the part of the surface that is there."""
    s, folder = plan.surface, plan.folder
    if s.emission == BLACK or s.alpha == 1.0 or s.alpha == 0.0:
        return
    if is_constant(s.alpha) and is_constant(s.emission):
        s.emission = tuple(c / s.alpha for c in s.emission)
    else:
        s.emission = folder.vector("DIVIDE", s.emission, s.alpha)


def tell_images(plan, nodes):
    for node in nodes:
        if is_missing(node):
            name = node.image.name if node.image is not None else ""
            plan.tell(node, "%s: magenta, as in Cycles" % ("its image '%s' cannot be read" % name if name else "it has no image"))
        elif node.type == "SHADERTORGB":
            plan.tell(node, "a node of Eevee: what it gives in Cycles is taken")
        elif node.type in ("AMBIENT_OCCLUSION", "BEVEL"):
            plan.tell(node, "sees its own object only")


def sort_channels(plan):
    """What varies is carried, baked, or replaced by its mean."""
    s = plan.surface
    plan.carried = carried(plan.folder, s) & {n for n in VARYING if isinstance(getattr(s, n), Ref)}
    grain.settle(plan)
    varying = {n for n in (*VARYING, *ADDED) if isinstance(getattr(s, n), Ref)}
    if isinstance(s.base, Ref) and s.through_colour == s.base:
        varying.discard("through_colour")  # the same texture
    plan.baked = varying - plan.carried
    if "base" in plan.baked and isinstance(s.base, Ref):
        lift(plan)
    if "alpha" in plan.baked:
        plan.baked.add("base")  # they share a texture
    for name in ("specular", "f0", "transmission", "ior", "clearcoat", "clearcoat_roughness"):
        if isinstance(getattr(s, name), Ref):
            plan.averaged.add(name)


def lift(plan):
    """A base that is baked gets the brightness that it has in Blender, of which images that are carried get the factor alone."""
    s, folder = plan.surface, plan.folder
    factor, summand = plan.lifted = base_of_principled(s) or (s.scale / s.covered, s.lift)
    if plan.lifted != (1.0, BLACK):
        s.base = folder.plus(folder.times(s.base, (factor,) * 3, True), summand, True)
        s.added |= s.principled
        s.principled, s.scale, s.lift, s.covered = False, 1.0, BLACK, 1.0


def channels_tell(plan, bakes):
    """Says what a bake cannot keep, or, without baking, all that is lost."""
    for name in sorted(plan.baked | plan.averaged):
        ref = getattr(plan.surface, name)
        if is_constant(ref):
            continue
        node = plan.folder.nodes[ref.node]
        named = named_node(plan, node)
        if name == "grain" and named is node:
            named = None  # it was made here
        if not bakes:
            plan.tell(named, "%s varies and is not baked (--no-bake): taken as constant" % WORDS[name])
        elif name in plan.averaged:
            plan.tell(named, "%s varies: its mean is taken" % WORDS[name])
        for seen in view_nodes(behind(plan, node)) if bakes else []:
            if not shader_tree.is_by_angle(seen):
                plan.tell(seen, "depends on where it is seen from: taken as seen straight on")


def behind(plan, node):
    return shader_tree.nodes_behind(plan.folder.tree, list(node.inputs)) + [node]


def tell_view(plan, least, most):
    """Says how far what is seen differs by the angle from the mean, which was baked."""
    refs = [ref for ref in (getattr(plan.surface, name) for name in sorted(plan.baked | plan.averaged)) if not is_constant(ref)]
    for node in view_nodes([n for ref in refs for n in behind(plan, plan.folder.nodes[ref.node])]):
        if shader_tree.is_by_angle(node):
            plan.tell(node, "depends on where it is seen from: its mean is taken: in Blender %.2g to %.2g times that, by the angle" % (least, most))


def named_node(plan, node):
    """A node that the user knows: itself, or the first of the user's own behind it."""
    own = plan.material.node_tree.nodes
    for n in [node] + shader_tree.nodes_behind(plan.folder.tree, list(node.inputs)):
        if n.name in own and own[n.name].type == n.type:
            return n
    return node


# Shaders that look different to other rays (Light Path): which of their looks serves the picture best.

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
