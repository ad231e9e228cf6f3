"""Materials as glTF can carry them: what has an equivalent becomes one, what varies is baked into textures."""
import math
import os

import bpy
import numpy

from . import bake, shader_tree
from .images import carried, is_read, number_source
from .messages import warn
from .surface import BLACK, COLOURS, Folder, Ref, Surface, WHITE, finish, give_constants, is_constant, view_nodes

GREY = 0.8  # of Blender's surfaces without a material
VARYING = ("base", "metallic", "roughness", "emission", "alpha", "normal")  # what glTF has textures for
MIRROR = 0.0316  # smoother metal is a perfect mirror to Reframe

EXPORTED = {"f0": "Specular", "transmission": "Transmission", "clearcoat": "Clearcoat",
            "clearcoat_roughness": "Clearcoat Roughness"}  # whose images the exporter carries from a Principled node

patches = {}  # what Blender's exporter cannot write: for glb.finish, by the names of materials


def glow(name, color, strength):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.use_backface_culling = True  # one-sided
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0, 0, 0, 1)
    principled.inputs["Roughness"].default_value = 1.0
    principled.inputs["Specular"].default_value = 0.0
    principled.inputs["Emission"].default_value = (*color, 1)
    principled.inputs["Emission Strength"].default_value = strength
    return material


class Plan:
    """A material, what its tree folds into, and what is to be done about it."""

    def __init__(self, material, users):
        self.material, self.users = material, users
        self.copy = self.folder = self.surface = None
        self.carried, self.baked, self.averaged = set(), set(), set()
        self.plain = False
        self.absorption = None  # colour and density of what is inside
        self.said = set()
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

    def tell(self, node, text):
        line = "%s%s: %s" % (self.who(), ", node '%s'" % node.name if node is not None else "", text)
        if line not in self.said:
            self.said.add(line)
            warn(line)


def copy_of(material):
    copy = material.copy()
    if copy.node_tree is not None:
        copy.node_tree.animation_data_clear()
    return copy


def tell_animation(plan):
    """Materials are taken as in the first frame."""
    trees, left = [], [plan.material.node_tree]
    while left:
        tree = left.pop()
        if tree is not None and tree not in trees:
            trees.append(tree)
            left += [n.node_tree for n in tree.nodes if n.type == "GROUP"]
    for tree in trees:
        moving = tree.animation_data
        if moving is None:
            continue
        curves = list(moving.drivers) + (list(moving.action.fcurves) if moving.action is not None else [])
        for path in sorted({c.data_path for c in curves}):
            node = tree.nodes.get(path.split('"')[1]) if path.startswith('nodes["') else None
            plan.tell(node, "animated or driven: taken as in the first frame")


def tell_inside(plan, out):
    """Remembers an absorbing inside; says what else is lost with volume and displacement."""
    socket = out.inputs["Displacement"]
    if socket.is_linked:
        plan.tell(socket.links[0].from_node, "displacement: left out")
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


def make_plan(material, users):
    plan = Plan(material, users)
    if not material.use_nodes or material.node_tree is None:
        plan.surface = finish(Surface(base=tuple(material.diffuse_color)[:3], specular=0.0))
        return plan
    tell_animation(plan)
    plan.copy = copy_of(material)
    tree = plan.copy.node_tree
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree is None:
            plan.tell(node, "its group is missing: left out")
    grouped = any(n.type in ("GROUP", "REROUTE") or n.mute for n in tree.nodes)
    shader_tree.flatten(tree)
    plan.folder = folder = Folder(tree, plan.tell)
    out = tree.get_output_node("CYCLES")
    if out is None:
        plan.tell(None, "no output: taken as black")
        plan.surface = finish(Surface(base=BLACK, specular=0.0))
        return plan
    behind = shader_tree.nodes_behind(tree, [out.inputs["Surface"]])
    give_constants(tree, plan.tell)
    only_volume = out.inputs["Volume"].is_linked and not out.inputs["Surface"].is_linked
    plan.surface = folder.fold(out.inputs["Surface"]) if not only_volume else Surface(alpha=0.0)
    tell_inside(plan, out)
    finish(plan.surface)
    shine_through(plan)
    tell_images(plan, behind)
    sort_channels(plan)
    first = out.inputs["Surface"].links[0].from_node if out.inputs["Surface"].is_linked else None
    if first is not None and first.type == "BSDF_PRINCIPLED" and not grouped:
        plan.averaged -= {n for n, name in EXPORTED.items() if is_image(folder, first.inputs[name])}
    plan.plain = (first is not None and first.type == "BSDF_PRINCIPLED" and not grouped and not plan.baked and not plan.averaged and
                  is_only_output(material) and not any(first.inputs[n].is_linked for n in ("Subsurface", "Subsurface Color")) and
                  first.inputs["Subsurface"].default_value == 0.0)
    return plan


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
        if node.type == "TEX_IMAGE" and not is_read(node.image):
            name = node.image.name if node.image is not None else ""
            plan.tell(node, "%s: magenta, as in Cycles" % ("its image '%s' cannot be read" % name if name else "it has no image"))
        elif node.type == "SHADERTORGB":
            plan.tell(node, "a node of Eevee: what it gives in Cycles is taken")
        elif node.type in ("AMBIENT_OCCLUSION", "BEVEL"):
            plan.tell(node, "sees its own object only")


def sort_channels(plan):
    """What varies is carried, baked, or replaced by its mean."""
    s = plan.surface
    varying = {n for n in VARYING if isinstance(getattr(s, n), Ref)}
    plan.carried = carried(plan.folder, s) & varying
    plan.baked = varying - plan.carried
    if "alpha" in plan.baked:
        plan.baked.add("base")  # they share a texture
    for name in ("specular", "f0", "transmission", "ior", "clearcoat", "clearcoat_roughness"):
        if isinstance(getattr(s, name), Ref):
            plan.averaged.add(name)


def channels_tell(plan, bakes):
    """Says what a bake cannot keep, or, without baking, all that is lost."""
    tree = plan.folder.tree
    for name in sorted(plan.baked | plan.averaged):
        ref = getattr(plan.surface, name)
        if is_constant(ref):
            continue
        node = plan.folder.nodes[ref.node]
        named = named_node(plan, node)
        if not bakes:
            plan.tell(named, "%s varies and is not baked (--no-bake): taken as constant" % bake.WORDS[name])
        elif name in plan.averaged:
            plan.tell(named, "%s varies: its mean is taken" % bake.WORDS[name])
        behind = shader_tree.nodes_behind(tree, list(node.inputs)) + [node]
        for seen in view_nodes(behind) if bakes else []:
            plan.tell(seen, "depends on where it is seen from: taken as seen straight on")


def named_node(plan, node):
    """A node that the user knows: itself, or the first of the user's own behind it."""
    own = plan.material.node_tree.nodes
    for n in [node] + shader_tree.nodes_behind(plan.folder.tree, list(node.inputs)):
        if n.name in own and own[n.name].type == n.type:
            return n
    return node


# building

def guess(name):
    """What a channel is taken for if it can be neither carried nor baked."""
    return {"base": (GREY,) * 3, "emission": BLACK, "normal": None, "metallic": 0.0, "roughness": 0.5, "alpha": 1.0,
            "specular": 1.0, "f0": 1.0, "transmission": 0.0, "ior": 1.5, "clearcoat": 0.0, "clearcoat_roughness": 0.0}[name]


def new_material(like, name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    if like is not None:
        for key in like.keys():
            if key not in ("cycles",):
                material[key] = like[key]
        material.use_backface_culling = like.use_backface_culling
        material.blend_method, material.alpha_threshold = like.blend_method, like.alpha_threshold
    return material


def shell(plan, name):
    """A material with a Principled node, and the plan's nodes where images are carried."""
    if plan.carried:
        material = plan.copy.copy()
        material.name = name
        tree = material.node_tree
        for node in list(tree.nodes):
            if node.type == "OUTPUT_MATERIAL":
                tree.nodes.remove(node)
        principled, out = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(principled.outputs[0], out.inputs["Surface"])
        return material, tree, principled
    material = new_material(plan.material, name)
    tree = material.node_tree
    return material, tree, tree.nodes["Principled BSDF"]


INPUTS = {"base": "Base Color", "metallic": "Metallic", "roughness": "Roughness", "emission": "Emission", "alpha": "Alpha",
          "normal": "Normal"}


def set_constant(principled, name, value):
    socket = principled.inputs[INPUTS[name]]
    if name in COLOURS:
        socket.default_value = (*value, 1.0)
    else:
        socket.default_value = value


def build(plan, name, textures=None, means=None, solid=False):
    """The material to export; `textures` feed baked channels, `means` replace others."""
    s, means = plan.surface, means or {}
    material, tree, principled = shell(plan, name)
    value = lambda n: means.get(n, guess(n)) if isinstance(getattr(s, n), Ref) else getattr(s, n)  # noqa: E731
    for n in VARYING:
        socket = principled.inputs[INPUTS[n]]
        if n in plan.carried:
            ref = getattr(s, n)
            tree.links.new(tree.nodes[ref.node].outputs[ref.output], socket)
        elif n == "normal" or n == "emission":
            continue
        elif n in plan.baked and textures is not None and n not in means:
            continue
        else:
            set_constant(principled, n, value(n))
    strength = 1.0
    if textures is not None:
        strength = bake.link_textures(tree, principled, textures, [n for n in plan.baked if n not in means])
    if "emission" not in plan.carried and not principled.inputs["Emission"].is_linked:
        light = value("emission")
        strength = max(max(light), 1e-30)
        principled.inputs["Emission"].default_value = (*(c / strength for c in light), 1.0)
    principled.inputs["Emission Strength"].default_value = strength
    principled.inputs["Specular"].default_value = 0.5
    principled.inputs["Clearcoat"].default_value = value("clearcoat")
    principled.inputs["Clearcoat Roughness"].default_value = value("clearcoat_roughness")
    principled.inputs["Clearcoat"].default_value = value("clearcoat")
    behind = {n.name for n in shader_tree.nodes_behind(tree, list(principled.inputs))} | {principled.name}
    for node in list(tree.nodes):
        if node.name not in behind and node.type != "OUTPUT_MATERIAL":
            tree.nodes.remove(node)
    if s.one_sided:
        material.use_backface_culling = True
    alpha = value("alpha")
    varies = principled.inputs["Alpha"].is_linked
    if varies or alpha < 1.0:
        material.blend_method = "CLIP" if plan.material is not None and plan.material.blend_method == "CLIP" else "BLEND"
    else:
        material.blend_method = "OPAQUE"
    patches[material.name] = {**patch_of(plan, value, solid), "name": name}  # Blender counts up names that a library has
    return material


def patch_of(plan, value, solid):
    """Extensions of glTF that the exporter cannot write from a Principled node."""
    extensions = {}
    specular, f0, transmission = value("specular"), value("f0"), value("transmission")
    f0 = f0 if isinstance(f0, tuple) else (f0,) * 3
    if transmission > 0.0:
        extensions["KHR_materials_transmission"] = {"transmissionFactor": transmission}
        extensions["KHR_materials_ior"] = {"ior": max(value("ior"), 1.0)}
        if solid:
            inside = {"thicknessFactor": 1.0}
            if plan.absorption is not None and plan.absorption[1] > 0.0:
                colour, density = plan.absorption
                inside["attenuationDistance"] = 1.0 / density
                inside["attenuationColor"] = [math.exp(min(max(c, 0.0), 1.0) - 1.0) for c in colour]
            extensions["KHR_materials_volume"] = inside
    elif specular < 1.0 or f0 != WHITE:
        extensions["KHR_materials_specular"] = {"specularFactor": specular}
        if f0 != WHITE:
            extensions["KHR_materials_specular"]["specularColorFactor"] = list(f0)
    patch = {"extensions": extensions}
    s = plan.surface
    if plan.copy is not None and value("metallic") == 1.0 and value("roughness") < MIRROR and is_constant(s.base):
        if transmission == 0.0 and s.emission == BLACK and s.alpha == 1.0 and s.normal is None and s.specular == 0.0:
            patch["extras"] = {"reframe": {"bsdf": "mirror", "specular": list(s.base)}}
    return patch


# objects

def is_closed(mesh):
    """Has every edge two faces?"""
    if not mesh.polygons:
        return False
    edges = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("edge_index", edges)
    return bool((numpy.bincount(edges, minlength=len(mesh.edges)) == 2).all())


def used_slots(o):
    """The numbers of the material slots that faces use."""
    if len(o.material_slots) < 2:
        return range(len(o.material_slots))
    indices = numpy.empty(len(o.data.polygons), numpy.int32)
    o.data.polygons.foreach_get("material_index", indices)
    return sorted({min(max(int(i), 0), len(o.material_slots) - 1) for i in numpy.unique(indices)})


def make_local(objects):
    """What comes from a library cannot be changed, a copy of it can."""
    for o in objects:
        if o.data.library is not None:
            o.data.make_local()


def tell_missing_libraries():
    for library in bpy.data.libraries:
        if not os.path.exists(bpy.path.abspath(library.filepath)):
            warn("library '%s' is missing: what comes from it is left out" % library.filepath)


def give_grey(objects):
    """What has no material is grey in Blender, not glTF's white metal."""
    grey = None
    for o in objects:
        data = o.data
        empty = [s for s in o.material_slots if s.material is None]
        if not empty and len(o.material_slots) > 0:
            continue
        if grey is None:
            grey = bpy.data.materials.new("no material")
            grey.diffuse_color = (GREY, GREY, GREY, 1.0)
            grey.use_nodes = False
        if len(o.material_slots) == 0:
            data.materials.append(grey)
        for slot in o.material_slots:
            if slot.material is None:
                slot.material = grey
    for mesh in bpy.data.meshes:  # of objects that are not exported: the exporter looks at all of them
        for i, material in enumerate(mesh.materials if mesh.library is None else []):
            if material is None:
                grey = grey or bpy.data.materials.new("no material")
                mesh.materials[i] = grey


def needs_solid(plan):
    return plan.surface is not None and plan.surface.transmission != 0.0


def all_trees():
    return [m.node_tree for m in bpy.data.materials if m.node_tree is not None] + [g for g in bpy.data.node_groups if g.type == "SHADER"]


def coordinate_objects():
    """Where the objects stand whose coordinates nodes use: the objects themselves are replaced with all others."""
    return [(tree, node.name, node.object.matrix_world.copy()) for tree in all_trees() for node in tree.nodes
            if node.type == "TEX_COORD" and node.object is not None]


def restore_coordinate_objects(targets):
    for i, (tree, name, matrix) in enumerate(targets):
        empty = bpy.data.objects.new("coordinates %d" % i, None)
        empty.matrix_world = matrix
        tree.nodes[name].object = empty


def carry(scene, args, placed):
    """Replaces materials, in memory only, by what the exporter carries unchanged. `placed` names objects that stand
    for many instances."""
    tell_missing_libraries()
    bpy.context.view_layer.update()
    objects = [o for o in scene.objects if o.type == "MESH"]
    make_local(objects)
    give_grey(objects)
    users = {}
    for o in objects:
        for i in used_slots(o):
            users.setdefault(o.material_slots[i].material, []).append((o, i))
    plans = {}
    for material, places in users.items():
        if is_ours(material):
            continue
        try:
            plans[material] = make_plan(material, places)
        except Exception as e:  # a tree that nobody thought of must not cost the scene
            warn("'%s': material '%s': not understood, left to Blender's exporter: %s" % (places[0][0].name, material.name, line_of(e)))
    tell_instances(plans.values(), placed)
    to_bake = {}
    new = []  # slots are set at the end: plans compare with the originals
    for material, plan in plans.items():
        if plan.baked or plan.averaged:
            channels_tell(plan, args.bake > 0)
        if (plan.baked or plan.averaged) and args.bake > 0:
            for o, i in plan.users:
                to_bake.setdefault(o, {})[i] = plan
        else:
            new += carry_plan(plan)
    new += bake.bake_objects(to_bake, args, is_closed, build) if to_bake else []
    for o, i, material in new:
        o.material_slots[i].material = material


def line_of(error):
    return "%s: %s" % (type(error).__name__, " ".join(str(error).split())[:200])


def tell_instances(plans, placed):
    for plan in plans:
        if plan.copy is not None and (plan.baked or plan.averaged) and any(o.name in placed for o, _ in plan.users):
            if bake.depends_on_place(plan):
                plan.tell(None, "differs between instances: taken as of one at the origin")


def names_for(plan, count):
    """Frees the name of the original for the first of the materials that replace it."""
    name = plan.free_name()
    return [name if i == 0 else "%s %d" % (name, i + 1) for i in range(count)]


def carry_plan(plan):
    """The slots of a material that needs no bake, with what replaces it."""
    s = plan.surface
    if plan.plain and s.transmission == 0.0 and (s.alpha == 1.0 or plan.material.blend_method != "OPAQUE"):
        return []
    kinds = {}
    for o, i in plan.users:
        solid = needs_solid(plan) and s.ior != 1.0 and is_closed(o.data)
        if needs_solid(plan) and s.ior != 1.0 and not solid:
            warn("'%s': material '%s': glass on a mesh that is not closed: taken as a thin pane" % (o.name, plan.name or plan.material.name))
        kinds.setdefault(solid, []).append((o, i))
    made = []
    for name, (solid, places) in zip(names_for(plan, len(kinds)), kinds.items()):
        material = build(plan, name, solid=solid)
        made += [(o, i, material) for o, i in places]
    return made
