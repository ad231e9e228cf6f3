"""Displacement: of materials that only bump by it, as a Bump node; of others, of the vertices, as far as Cycles evaluates it."""
import bpy
import numpy

from . import bake, shader_tree
from .messages import warn
from .shapes import SHAPE
from .versions import give_nodes


def method_of(material):
    """BUMP, DISPLACEMENT or BOTH: of Cycles; Eevee knows bumps alone."""
    return getattr(material, "displacement_method", None) or material.cycles.displacement_method


NORMALS = ("Normal", "Clearcoat Normal", "Coat Normal")


def height_of(tree, socket):
    """The node and the value that tell how far a displacement goes along the normal."""
    node = socket.links[0].from_node
    if node.type == "DISPLACEMENT" and not node.inputs["Normal"].is_linked:
        product = tree.nodes.new("ShaderNodeMath")
        product.operation = "MULTIPLY"
        for name, target in zip(("Height", "Scale"), product.inputs):
            shader_tree.connect(tree, node.inputs[name], target)
        return product.outputs[0]
    geometry, product = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
    product.operation = "DOT_PRODUCT"
    tree.links.new(socket.links[0].from_socket, product.inputs[0])
    tree.links.new(geometry.outputs["Normal"], product.inputs[1])
    return product.outputs["Value"]


def make_bump(tree, out, scale):
    """Feeds a bump of the displacement to all normals that have no source of their own, as Cycles does. `scale`: of the object."""
    targets = [i for n in shader_tree.nodes_behind(tree, [out.inputs["Surface"]]) for i in n.inputs
               if i.name in NORMALS and not i.is_linked and n.type != "NORMAL"]
    bump = tree.nodes.new("ShaderNodeBump")
    bump.name = "Displacement as a bump"
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 1.0, scale
    tree.links.new(height_of(tree, out.inputs["Displacement"]), bump.inputs["Height"])
    for target in targets:
        tree.links.new(bump.outputs[0], target)


def scale_of(tree, out, users):
    """By what objects make their displacement larger, which is in their own space unless its node says otherwise."""
    node = out.inputs["Displacement"].links[0].from_node
    if node.type != "DISPLACEMENT" or node.space != "OBJECT":
        return 1.0
    return users[0][0].matrix_world.to_scale().length / 3.0 ** 0.5 if users else 1.0


# How far vertices go: the displacement is emitted, and baked to colours of the vertices.

COLOURS = "reframe displacement"


def emits(plan, sign):
    """A copy of a material that emits its displacement, in the directions of one sign; black without one."""
    if plan is None or not plan.displaces:
        material = bpy.data.materials.new(COLOURS)
        give_nodes(material)
        tree, vector = material.node_tree, None
        tree.nodes.clear()
    else:
        material = plan.copy.copy()
        tree = material.node_tree
        old = tree.get_output_node("CYCLES")
        vector = old.inputs["Displacement"].links[0].from_socket
        for node in [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"]:
            tree.nodes.remove(node)
    out, emission = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    if vector is not None:
        signed, part = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeVectorMath")
        signed.operation, part.operation = "MULTIPLY", "MAXIMUM"
        signed.inputs[1].default_value, part.inputs[1].default_value = (sign,) * 3, (0.0,) * 3
        tree.links.new(vector, signed.inputs[0])
        tree.links.new(signed.outputs[0], part.inputs[0])
        tree.links.new(part.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    return material


def way_of(o, plans):
    """How far each vertex of an object goes, in the world; `plans` by slot."""
    part = bake.own_mesh(o)
    part.polygons.foreach_set("use_smooth", numpy.ones(len(part.polygons), bool))  # vertices go along their smooth normals
    colours = part.color_attributes.new(COLOURS, "FLOAT_COLOR", "POINT")
    part.color_attributes.active_color = colours
    stage, way = bake.Stage(o, part), numpy.zeros((len(part.vertices), 3), numpy.float32)
    stage.scene.render.bake.target = "VERTEX_COLORS"
    try:
        for sign in (1.0, -1.0):
            made = [emits(plans.get(i), sign) for i in range(len(stage.o.material_slots))]
            for slot, material in zip(stage.o.material_slots, made):
                slot.material = material
            bpy.ops.object.bake(type="EMIT")
            found = numpy.empty(4 * len(way), numpy.float32)
            part.color_attributes[COLOURS].data.foreach_get("color", found)
            way += sign * numpy.nan_to_num(found.reshape(-1, 4)[:, :3])
            for material in made:
                bpy.data.materials.remove(material)
    finally:
        stage.close()
    return way


def ways_of(plans):
    """By object how far its vertices go, before its mesh is unwrapped and its textures are baked, as they are for Cycles."""
    users = {}
    for plan in plans:
        for o, slot in plan.users:
            users.setdefault(o, {})[slot] = plan
    ways = {}
    for o, slots in users.items():
        displaced = [plan for plan in slots.values() if plan.displaces]
        if not displaced:
            continue
        if o.data.get(SHAPE) is not None:
            displaced[0].tell(None, "displacement of vertices that deform ('%s'): left out" % o.name)
            continue
        try:
            ways[o] = way_of(o, slots)
        except Exception as e:  # Blender's bake fails for reasons of its own
            warn("'%s': displacement of vertices: left out: %s" % (o.name, " ".join(str(e).split())[:200]))
    return ways


def displace(ways):
    for o, way in ways.items():
        if o.data.users > 1:
            o.data = o.data.copy()
        if o.data.has_custom_normals:
            with bpy.context.temp_override(object=o, active_object=o):
                bpy.ops.mesh.customdata_custom_splitnormals_clear()
        inverse = numpy.array(o.matrix_world.to_3x3().inverted_safe(), numpy.float32)
        places = numpy.empty(3 * len(o.data.vertices), numpy.float32)
        o.data.vertices.foreach_get("co", places)
        o.data.vertices.foreach_set("co", (places.reshape(-1, 3) + way @ inverse.T).ravel())
        o.data.update()
