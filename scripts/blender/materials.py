"""Materials as glTF can carry them: what has an equivalent becomes one, what varies is baked into textures."""
import math
import os

import bpy
import numpy
from mathutils import Vector, geometry
from mathutils.bvhtree import BVHTree

from . import attributes, bake, displacement, grain, keyed, shader_tree
from .channels import ADDED, BLACK, COLOURS, Ref, WHITE, is_constant, link_textures, strength_of
from .gloss import base_of_principled
from .messages import warn
from .plans import VARYING, channels_tell, is_ours, make_plan
from .versions import give_nodes, has_nodes, principled_of, socket, socket as input_of


def glow(name, color, strength):
    material = bpy.data.materials.new(name)
    give_nodes(material)
    material.use_backface_culling = True  # one-sided
    principled = principled_of(material.node_tree)
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


def grey_material():
    """What Cycles shows of surfaces without a material: the nodes of a new one, where these have some (in Blender 5), else diffuse grey."""
    material = bpy.data.materials.new("no material")
    if has_nodes(material):
        return material
    give_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    diffuse, out = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (GREY, GREY, GREY, 1.0)
    tree.links.new(diffuse.outputs[0], out.inputs["Surface"])
    return material


def give_grey(objects):
    """What has no material is grey in Blender, not glTF's white metal."""
    grey = None
    for o in objects:
        data = o.data
        empty = [s for s in o.material_slots if s.material is None]
        if not empty and len(o.material_slots) > 0:
            continue
        grey = grey or grey_material()
        if len(o.material_slots) == 0:
            data.materials.append(grey)
        for slot in o.material_slots:
            if slot.material is None:
                slot.material = grey
    for mesh in bpy.data.meshes:  # of objects that are not exported: the exporter looks at all of them
        for i, material in enumerate(mesh.materials if mesh.library is None else []):
            if material is None:
                grey = grey or grey_material()
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
    if is_clear and s.normal is None and has_slabs(o, plan.material):
        warn("%s: glass as a thin box: its sides are taken as thin panes, without refraction" % who)
        return False
    return True


def all_trees():
    return [m.node_tree for m in [*bpy.data.materials, *bpy.data.worlds] if m.node_tree is not None] + [g for g in bpy.data.node_groups if g.type == "SHADER"]


def coordinate_objects():
    """Where the objects stand whose coordinates nodes use: the objects themselves are replaced with all others."""
    return [(tree, node.name, node.object.matrix_world.copy()) for tree in all_trees() for node in tree.nodes
            if node.type == "TEX_COORD" and node.object is not None]


def restore_coordinate_objects(targets):
    for i, (tree, name, matrix) in enumerate(targets):
        empty = bpy.data.objects.new("coordinates %d" % i, None)
        empty.matrix_world = matrix
        tree.nodes[name].object = empty


def carry(scene, args, placed, recorder, recorded, tracks):
    """Replaces materials, in memory only, by what the exporter carries unchanged. `placed` names objects that stand
    for many instances; `recorder` has the camera's frames, `recorded` the states of what changes, whose keys go to `tracks`."""
    tell_missing_libraries()
    bpy.context.view_layer.update()
    objects = [o for o in scene.objects if o.type == "MESH"]
    make_local(objects)
    give_grey(objects)
    attributes.settle(objects, recorded.materials)
    users = {}
    for o in objects:
        for i in used_slots(o):
            users.setdefault(o.material_slots[i].material, []).append((o, i))
    plans = {}
    for material, places in users.items():
        if is_ours(material):
            continue
        try:
            states = recorded.materials.get(material.name_full)
            plans[material] = keyed.plan_of(make_plan, material, places, states) if states is not None else make_plan(material, places)
        except Exception as e:  # a tree that nobody thought of must not cost the scene
            warn("'%s': material '%s': not understood, left to Blender's exporter: %s" % (places[0][0].name, material.name, line_of(e)))
    views = bake.Views(recorder, scene.render.resolution_y * scene.render.resolution_percentage / 100.0, args.bake, placed)
    tell_instances(plans.values(), placed)
    ways = displacement.ways_of(plans.values())
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
    displacement.displace(ways)
    keyed.finish([plan for plan in plans.values() if plan.changes is not None], tracks, patches)


def line_of(error):
    return "%s: %s" % (type(error).__name__, " ".join(str(error).split())[:200])


def tell_instances(plans, placed):
    for plan in plans:
        if plan.copy is not None and (plan.baked or plan.averaged) and any(o.name in placed for o, _ in plan.users):
            if bake.depends_on_place(plan):
                plan.lose(None, "differs between instances: taken as of one at the origin")


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


# Makes the material that Blender's exporter carries, from a plan.

GREY = 0.8  # of Blender's surfaces without a material
MIRROR = 0.0316  # smoother metal is a perfect mirror to Reframe
SMOOTH = 0.1  # of less roughness, lobes are as narrow as those of mirrors (RF_SMOOTH_ALPHA)

NO_COAT = {"extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}

# Principled's coat takes nothing from the base: src/gltf/gltf_material.c
ADDED_COAT = {"reframe": {"coat": "added"}}

patches = {}  # what Blender's exporter cannot write: for glb.finish, by the names of materials


def guess(name):
    """What a channel is taken for if it can be neither carried nor baked."""
    return {"base": (GREY,) * 3, "emission": BLACK, "normal": None, "metallic": 0.0, "roughness": 0.5, "alpha": 1.0,
            "specular": 1.0, "f0": 1.0, "transmission": 0.0, "ior": 1.5, "clearcoat": 0.0, "clearcoat_roughness": 0.0,
            "through_colour": (GREY,) * 3}[name]


def new_material(like, name):
    material = bpy.data.materials.new(name)
    give_nodes(material)
    if like is not None:
        for key in like.keys():
            if key not in ("cycles",):
                material[key] = like[key]
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
    return material, tree, principled_of(tree)


INPUTS = {"base": "Base Color", "metallic": "Metallic", "roughness": "Roughness", "emission": "Emission", "alpha": "Alpha",
          "normal": "Normal"}


def set_constant(principled, name, value):
    socket = input_of(principled, INPUTS[name])
    if name in COLOURS:
        socket.default_value = (*value, 1.0)
    else:
        socket.default_value = value


def build(plan, name, textures=None, means=None, solid=False):
    """The material to export; `textures` feed baked channels, `means` replace others."""
    s, means = plan.surface, means or {}
    material, tree, principled = shell(plan, name)
    lit = 1.0
    value = lambda n: means.get(n, guess(n)) if isinstance(getattr(s, n), Ref) else getattr(s, n)  # noqa: E731
    for n in VARYING:
        socket = input_of(principled, INPUTS[n])
        if n in plan.carried:
            ref = getattr(s, n)
            if n == "emission":
                ref, lit = strength_of(plan.folder, ref)
            tree.links.new(tree.nodes[ref.node].outputs[ref.output], socket)
        elif n == "normal" or n == "emission":
            continue
        elif n in plan.baked and textures is not None and n not in means:
            continue
        else:
            set_constant(principled, n, value(n))
    strength = lit
    if textures is not None:
        shining = link_textures(tree, principled, textures, [n for n in plan.baked if n not in means])
        strength = shining or strength
    if "emission" not in plan.carried and not input_of(principled, "Emission").is_linked:
        light = value("emission")
        strength = max(max(light), 1e-30)
        input_of(principled, "Emission").default_value = (*(c / strength for c in light), 1.0)
    principled.inputs["Emission Strength"].default_value = strength
    input_of(principled, "Specular").default_value = 0.5
    input_of(principled, "Clearcoat").default_value = value("clearcoat")
    input_of(principled, "Clearcoat Roughness").default_value = value("clearcoat_roughness")
    behind = {n.name for n in shader_tree.nodes_behind(tree, list(principled.inputs))} | {principled.name}
    for node in list(tree.nodes):
        if node.name not in behind and node.type != "OUTPUT_MATERIAL":
            tree.nodes.remove(node)
    # what a material says of culling and clipping is for Eevee
    material.use_backface_culling = s.one_sided
    alpha = value("alpha")
    varies = principled.inputs["Alpha"].is_linked
    material.blend_method = "BLEND" if varies or alpha < 1.0 else "OPAQUE"
    added = [(*ADDED[n], textures[n], textures["place"]) for n in sorted(plan.baked & set(ADDED) - set(means))] if textures is not None else []
    patches[material.name] = {**patch_of(plan, value, solid), "name": name, "added": added}  # Blender counts up names that a library has
    if plan.changes is not None:
        plan.changes.made.append((material.name, means, strength))
    return material


def is_like_mirror(material):
    """Has a lobe so narrow that lamps which rays cannot hit are hardly found in it?"""
    node = next((n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None) if has_nodes(material) else None
    pairs = [("Roughness", None), ("Clearcoat Roughness", "Clearcoat")] if node is not None else []
    return any(not input_of(node, r).is_linked and input_of(node, r).default_value < SMOOTH and
               (share is None or input_of(node, share).default_value > 0.0) for r, share in pairs)


def specular_kinds(objects):
    """What of "mirrors", "glass" and "solid glass" there is among the materials of objects, as exported."""
    found = set()
    for material in {s.material for o in objects if o.type == "MESH" for s in o.material_slots if s.material is not None}:
        extensions = patches.get(material.name, {}).get("extensions", {})
        own = material["reframe"]["bsdf"] if is_ours(material) else None
        if own == "glass" or "KHR_materials_transmission" in extensions:
            found |= {"glass", "solid glass"} if own == "glass" or "KHR_materials_volume" in extensions else {"glass"}
        elif own == "mirror" or is_like_mirror(material):
            found.add("mirrors")
    return found


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
        if transmission < 1.0:  # Cycles mixes the two, no coat covers both
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    elif specular < 1.0 or f0 != WHITE:
        extensions["KHR_materials_specular"] = {"specularFactor": specular}
        if f0 != WHITE:
            extensions["KHR_materials_specular"]["specularColorFactor"] = list(f0)
    s = plan.surface
    if s.aspect < 1.0 and transmission == 0.0:
        extensions["KHR_materials_anisotropy"] = grain.extension_of(s)
    if s.film is not None:
        extensions["KHR_materials_iridescence"] = {"iridescenceFactor": 1.0, "iridescenceIor": s.film[1],
                                                   "iridescenceThicknessMinimum": s.film[0], "iridescenceThicknessMaximum": s.film[0]}
    is_like_base = isinstance(s.base, Ref) and s.through_colour == s.base
    if s.through > 0.0:
        extensions["KHR_materials_diffuse_transmission"] = {"diffuseTransmissionFactor": s.through,
                                                            "diffuseTransmissionColorFactor": list(value("through_colour"))}
    if max(s.sheen) > 0.0:
        extensions["KHR_materials_sheen"] = {"sheenColorFactor": list(s.sheen), "sheenRoughnessFactor": s.sheen_roughness}
    scaled = (s.scale / s.covered, s.lift) if (s.scale, s.lift) != (1.0, BLACK) else None
    patch = {"extensions": extensions, "base": base_of_principled(s) or scaled, "is_through_like_base": s.through > 0.0 and is_like_base,
             "roughness": grain.strength_of(s)[1] if s.aspect < 1.0 and transmission == 0.0 else 1.0}
    if (s.principled or s.added) and specular > 0.0 and transmission == 0.0:
        patch["extras"] = ADDED_COAT
    if plan.copy is not None and value("metallic") == 1.0 and value("roughness") < MIRROR and is_constant(s.base):
        if transmission == 0.0 and s.emission == BLACK and s.alpha == 1.0 and s.normal is None and s.specular == 0.0 and s.aspect == 1.0:
            patch["extras"] = {"reframe": {"bsdf": "mirror", "specular": list(s.base)}}
    return patch


# Panes that are modelled as thin boxes: two parallel walls of glass, which together do not deflect light.

THIN = 0.02  # of the root of a wall's area, at most
RIM = 0.2  # of a wall's area, at most, are the faces between the two
TOUCHED = 0.3  # of points of the walls, at most, may lie on something or in it: rims are held by frames
MOST_FACES = 20000  # of a mesh that is looked at
trees = {}  # of the faces of objects, by name


def islands(faces):
    """Lists of the numbers of faces that hang together; `faces` gives the vertices of each."""
    parent = {}

    def root(v):
        while parent.setdefault(v, v) != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    for vertices in faces:
        for v in vertices[1:]:
            parent[root(v)] = root(vertices[0])
    found = {}
    for number, vertices in enumerate(faces):
        found.setdefault(root(vertices[0]), []).append(number)
    return list(found.values())


def walls_of(polygons, points):
    """The faces of the two walls, if these are two parallel walls, close to each other, and the rims between them; with the
    distance of the walls."""
    normal = numpy.array(max(polygons, key=lambda p: p.area).normal)
    heights = points[sorted({v for p in polygons for v in p.vertices})] @ normal
    low, high = heights.min(), heights.max()
    areas, walls = {1: 0.0, -1: 0.0, 0: 0.0}, []
    for p in polygons:
        cosine = float(numpy.dot(normal, p.normal))
        side = 0 if abs(cosine) <= 0.999 else 1 if cosine > 0.0 else -1
        areas[side] += p.area
        if side != 0:
            if numpy.abs(points[list(p.vertices)] @ normal - (high if side == 1 else low)).max() > 0.01 * (high - low) + 1e-7:
                return None, 0.0
            walls.append(p)
    is_slab = abs(areas[1] - areas[-1]) < 0.01 * areas[1] and areas[0] < RIM * areas[1] and high - low < THIN * areas[1] ** 0.5
    return (walls, high - low) if is_slab else (None, 0.0)


def points_of(walls, points):
    """Points and normals all over faces, their number by area."""
    step = (sum(p.area for p in walls) / 200.0) ** 0.5
    for p in walls:
        corners = [Vector(points[v]) for v in p.vertices]
        for i, j, k in geometry.tessellate_polygon([corners]):
            a, b, c = corners[i], corners[j], corners[k]
            n = max(1, round(((b - a).cross(c - a).length / 2.0) ** 0.5 / step))
            for u in range(n):
                for v in range(n):
                    x, y = ((u + 0.5) / n) ** 0.5, (v + 0.5) / n
                    yield a + (b - a) * (x * (1.0 - y)) + (c - a) * (x * y), Vector(p.normal)


def tree_of(o):
    """What casts rays of the world, from a start to an end, at an object."""
    if o.name not in trees:
        trees[o.name] = BVHTree.FromObject(o, bpy.context.evaluated_depsgraph_get())
    tree, inverse = trees[o.name], o.matrix_world.inverted_safe()
    return lambda start, end: hits(tree, inverse @ start, inverse @ end)


def hits(tree, start, end):
    return tree.ray_cast(start, end - start, (end - start).length)[0] is not None


def bounds(o):
    corners = numpy.array([o.matrix_world @ Vector(c) for c in o.bound_box])
    return corners.min(axis=0), corners.max(axis=0)


def is_near(a, b, margin):
    return bool((a[0] <= b[1] + margin).all() and (b[0] <= a[1] + margin).all())


def is_touched(walls, points, thickness, others):
    """Does something lie on the walls, or between them? Then light that it scatters is in the glass."""
    count, touched = 0, 0
    for at, normal in points_of(walls, points):
        count += 1
        # from within the slab, near its other wall, through this one
        start, end = at - normal * (0.99 * thickness), at + normal * (0.05 * thickness)
        touched += any(cast(start, end) for cast in others)
    return touched > TOUCHED * count


def has_slabs(o, material):
    """Is all that has a material of an object such slabs, which nothing touches?"""
    if len(o.data.polygons) > MOST_FACES:
        return False
    mesh = o.data.copy()
    mesh.transform(o.matrix_world)
    if o.matrix_world.determinant() < 0.0:
        mesh.flip_normals()
    points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", points)
    found = all_slabs(o, mesh, points.reshape(-1, 3).astype(numpy.float64), material)
    bpy.data.meshes.remove(mesh)
    return found


def all_slabs(o, mesh, points, material):
    slots = {i for i, slot in enumerate(o.material_slots) if slot.material == material}
    polygons = [p for p in mesh.polygons if p.material_index in slots]
    parts = [[polygons[i] for i in part] for part in islands([list(p.vertices) for p in polygons])]
    slabs = [walls_of(part, points) for part in parts]
    if not slabs or any(walls is None for walls, _ in slabs):
        return False
    here = bounds(o)
    others = [tree_of(other) for other in bpy.context.scene.objects if other.type == "MESH" and other != o and
              other.data.polygons and is_near(here, bounds(other), 0.05 * max(thickness for _, thickness in slabs))]
    for part, (walls, thickness) in zip(parts, slabs):
        if is_touched(walls, points, thickness, others + faces_but(mesh, points, {p.index for p in part})):
            return False
    return True


def faces_but(mesh, points, own):
    """What casts rays at all other faces of a mesh, if there are others."""
    faces = [p.vertices for p in mesh.polygons if p.index not in own]
    tree = BVHTree.FromPolygons([Vector(p) for p in points], faces) if faces else None
    return [] if tree is None else [lambda start, end: hits(tree, start, end)]
