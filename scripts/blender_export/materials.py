"""Materials as glTF can carry them: what has an equivalent becomes one, what varies is baked into textures."""
import os

import bpy
import numpy

from . import bake, slabs
from .build import ADDED_COAT, GREY, MIRROR, NO_COAT, build, patches
from .channels import is_constant
from .disney import base_of_principled
from .messages import warn
from .names import socket
from .plans import channels_tell, is_ours, make_plan


def glow(name, color, strength):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.use_backface_culling = True  # one-sided
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0, 0, 0, 1)
    principled.inputs["Roughness"].default_value = 1.0
    socket(principled, "Specular").default_value = 0.0
    socket(principled, "Emission").default_value = (*color, 1)
    principled.inputs["Emission Strength"].default_value = strength
    patches[material.name] = NO_COAT
    return material


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


def transmits(plan):
    return plan.surface is not None and plan.surface.transmission != 0.0


def is_solid(plan, o):
    """Is it a body that refracts? Says why not."""
    s = plan.surface
    if not transmits(plan) or s.thin or s.ior == 1.0:
        return False
    who = "'%s': material '%s'" % (o.name, plan.name or plan.material.name)
    if not o.visible_shadow:
        warn("%s: glass without a shadow: taken as a thin pane" % who)
        return False
    if not is_closed(o.data):
        warn("%s: glass on a mesh that is not closed: taken as a thin pane" % who)
        return False
    is_clear = is_constant(s.roughness) and s.roughness < MIRROR and s.transmission == 1.0 and plan.absorption is None
    if is_clear and s.normal is None and slabs.has_slabs(o, plan.material):
        warn("%s: glass as a thin box: its sides are taken as panes, which bend nothing" % who)
        return False
    return True


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


def carry(scene, args, placed, recorder):
    """Replaces materials, in memory only, by what the exporter carries unchanged. `placed` names objects that stand
    for many instances; `recorder` has the camera's frames."""
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
    views = bake.Views(recorder, scene.render.resolution_y * scene.render.resolution_percentage / 100.0, args.bake, placed)
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
    new += bake.bake_objects(to_bake, views, args.bake_cache, is_solid, build) if to_bake else []
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
    if plan.plain and s.transmission == 0.0:
        plan.material.use_backface_culling = False
        plan.material.blend_method = "OPAQUE" if s.alpha == 1.0 else "BLEND"
        patches[plan.material.name] = {**(NO_COAT if s.specular == 0.0 else {"extras": ADDED_COAT}), "base": base_of_principled(s)}
        return []
    kinds = {}
    for o, i in plan.users:
        kinds.setdefault(is_solid(plan, o), []).append((o, i))
    made = []
    for name, (solid, places) in zip(names_for(plan, len(kinds)), kinds.items()):
        material = build(plan, name, solid=solid)
        made += [(o, i, material) for o, i in places]
    return made
