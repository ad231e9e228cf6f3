"""For test_blender_shapes.c: shapes.blend, of all that deforms or changes its topology, rigs.blend, of what deforms by few values in many
frames, and their corners in three frames, shapes.bin and rigs.bin: for each frame two whole numbers, the frame and the corners, and for
each corner position and normal in glTF's axes, as floats.
"""
import math
import struct

import bpy
import numpy

from blender_words import begin, geometry_group, instances_of, key, placed, save

LAST = 8
places = list(range(100))


def place():
    """Beside the objects that are there; of 2 m, as all of them."""
    i = places.pop(0)
    return 4 * (i % 5) - 8, 4 * (i // 5) - 4, 0


def add(name, data):
    return placed(name, data, place())


def grid(name, n, smooth=True, materials=()):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=n, y_subdivisions=n, size=2)
    made = bpy.context.object
    o = add(name, made.data)
    bpy.data.objects.remove(made)
    for material in materials:
        o.data.materials.append(material)
    for p in o.data.polygons:
        p.use_smooth, p.material_index = smooth, p.index % max(len(materials), 1)
    return o


def keyed(owner, path, *values):
    """Keys at the first and the last frame."""
    key(owner, path, zip((1, bpy.context.scene.frame_end), values))


def wave(o):
    modifier = o.modifiers.new("wave", "WAVE")
    modifier.height, modifier.width, modifier.speed, modifier.time_offset = 0.5, 0.7, 0.2, -20
    return modifier


def arm(o):
    """Two bones along x, of which the second one turns."""
    bones = placed("bones", bpy.data.armatures.new("bones"), o.location)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    for i in range(2):
        bone = bones.data.edit_bones.new("b%d" % i)
        bone.head, bone.tail = (i - 1, 0, 0), (i, 0, 0)
    bones.data.edit_bones["b1"].parent = bones.data.edit_bones["b0"]
    bpy.ops.object.mode_set(mode="OBJECT")
    groups = [o.vertex_groups.new(name="b%d" % i) for i in range(2)]
    for v in o.data.vertices:
        groups[0].add([v.index], 0.5 - 0.5 * v.co.x, "REPLACE")
        groups[1].add([v.index], 0.5 + 0.5 * v.co.x, "REPLACE")
    pose = bones.pose.bones["b1"]
    pose.rotation_mode = "XYZ"
    keyed(pose, "rotation_euler", (0, 0, 0), (0.4, 1.2, 0.3))
    modifier = o.modifiers.new("pose", "ARMATURE")
    modifier.object = bones
    return modifier


def finish(scene, name, middle):
    """With a camera; and the corners in the first, a middle, and the last frame."""
    eye = scene.camera = add("Eye", bpy.data.cameras.new("Eye"))
    eye.location, eye.rotation_euler = (0, -22, 8), (1.2, 0, 0)
    save(name)
    with open(name + ".bin", "wb") as file:
        for frame in range(1, scene.frame_end + 1):
            scene.frame_set(frame)
            if frame in (1, middle, scene.frame_end):
                rows = corners(bpy.context.evaluated_depsgraph_get())
                file.write(struct.pack("<2i", frame, len(rows)) + rows.astype(numpy.float32).tobytes())


def tube(name):
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.3, depth=2, rotation=(0, math.pi / 2, 0))
    made = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=6)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.transform_apply(location=False)
    o = add(name, made.data)
    bpy.data.objects.remove(made)
    for p in o.data.polygons:
        p.use_smooth = True
    return o


def again(o):
    """An instance of an object."""
    group = bpy.data.collections.get(o.name) or bpy.data.collections.new(o.name)
    if not group.objects:
        group.objects.link(o)
        group.instance_offset = o.location
    return instances_of(group, "again", place())


def rigs():
    """Two keys, one of them driven; a tube that bones bend, shown again by an instance that turns; others keep their volume or
    have many instances."""
    scene = begin(40)
    keys = grid("two keys", 30)
    for name in ("Basis", "up", "wide"):
        keys.shape_key_add(name=name)
    blocks = keys.data.shape_keys.key_blocks
    for v, w in zip(blocks["up"].data, blocks["wide"].data):
        v.co.z += 0.3 * math.sin(3 * v.co.x)
        w.co.x *= 1.0 + 0.3 * w.co.y
    blocks["up"].driver_add("value").driver.expression = "0.5 + 0.5 * sin(frame)"
    keyed(blocks["wide"], "value", 1.0, 0.2)
    bent = tube("bent")
    arm(bent)
    bent.vertex_groups[1].remove([0])  # which stays at rest, as nothing else moves it
    bent.vertex_groups[0].remove([0])
    thick = tube("thick")
    arm(thick).use_deform_preserve_volume = True
    keyed(again(bent), "rotation_euler", (0, 0, 0), (0, 1, 2))
    many = tube("many")  # instances have no skins
    arm(many)
    for i in range(6):
        again(many).rotation_euler = (0, 0, i)
    finish(scene, "rigs", 17)


def main():
    scene = begin(LAST)
    two = [bpy.data.materials.new("m%d" % i) for i in range(2)]
    o = grid("smooth", 8, materials=two)
    wave(o)
    keyed(o, "location", o.location.copy(), (o.location.x, o.location.y, 0.5))
    flat = grid("flat", 8, smooth=False, materials=two)
    wave(flat)
    flat.modifiers.new("split", "EDGE_SPLIT").split_angle = 0.3
    cloth = grid("cloth", 10)
    cloth.vertex_groups.new(name="pin").add([0, 10], 1.0, "REPLACE")
    cloth.modifiers.new("cloth", "CLOTH").settings.vertex_group_mass = "pin"
    soft = grid("soft", 6)
    soft.modifiers.new("soft", "SOFT_BODY").settings.use_goal = False
    keys = grid("keys", 6, smooth=False)
    for name in ("Basis", "up", "wide"):
        keys.shape_key_add(name=name)
    for v in keys.data.shape_keys.key_blocks["up"].data:
        v.co.z += math.sin(3 * v.co.x)
    for v in keys.data.shape_keys.key_blocks["wide"].data:
        v.co.x *= 1.0 + 0.3 * v.co.y
    keyed(keys.data.shape_keys.key_blocks["up"], "value", 0.0, 1.0)
    keyed(keys.data.shape_keys.key_blocks["wide"], "value", 1.0, 0.2)
    skin = grid("skin", 6, materials=two)
    arm(skin)
    after = skin.modifiers.new("after", "SUBSURF")
    after.levels = after.render_levels = 1
    lattice = add("lattice", bpy.data.lattices.new("lattice"))
    in_lattice = grid("in lattice", 6)
    in_lattice.location = lattice.location
    in_lattice.modifiers.new("lattice", "LATTICE").object = lattice
    lattice.scale = (2, 2, 2)
    for name in ("Basis", "bulge"):
        lattice.shape_key_add(name=name)
    lattice.data.shape_keys.key_blocks["bulge"].data[0].co = (-1, -1, 2)
    keyed(lattice.data.shape_keys.key_blocks["bulge"], "value", 0.0, 1.0)
    array = grid("array", 2, smooth=False).modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_constant_offset = False, True
    array.constant_offset_displace = (0, 0, 0.3)
    keyed(array, "count", 1, 4)
    wave(bpy.data.objects["array"])
    balls = [add("ball", bpy.data.metaballs.new("ball")), add("ball.001", bpy.data.metaballs.new("ball"))]
    for ball in balls:
        ball.data.elements.new().radius = 1.0
        ball.data.resolution = ball.data.render_resolution = 0.5
    keyed(balls[1], "location", (balls[0].location.x + 2.5, balls[0].location.y, 0), (balls[0].location.x + 0.8, balls[0].location.y, 0))
    text = add("text", bpy.data.curves.new("text", "FONT"))
    text.data.body, text.data.bevel_depth = "S", 0.03
    text.data.driver_add("bevel_resolution").driver.expression = "frame // 4"
    shift, = geometry_group(grid("nodes", 3), "GeometryNodeSetPosition")  # nothing but the nodes change
    keyed(shift.inputs["Offset"], "default_value", (0, 0, 0), (0, 0, 0.7))
    # as instances: some stand still, one moves
    for i in range(6):
        last = again(keys)
        last.rotation_euler = (0, 0, i)
    keyed(last, "scale", (1, 1, 1), (0.5, 0.5, 0.5))
    # and once more, sheared and mirrored by its parent
    parent, bent = add("parent", None), add("bent", keys.data)
    parent.scale = (1, -0.5, 1)
    bent.parent, bent.location, bent.rotation_euler = parent, (0, 0, 0), (0, 0, 0.6)
    finish(scene, "shapes", 4)
    places[:] = range(100)
    rigs()


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=1, keepdims=True)


def corners(depsgraph):
    """Position and normal of each corner in the world, in glTF's axes."""
    found = []
    for instance in depsgraph.object_instances:
        if instance.object.type != "MESH":
            continue
        mesh = instance.object.data
        if instance.object.name.startswith("ball"):  # Blender 3 shades metaballs by normals of their field, which meshes lack
            mesh = instance.object.original.evaluated_get(depsgraph).to_mesh()
        places, normals = (numpy.empty(3 * n, numpy.float32) for n in (len(mesh.vertices), len(mesh.loops)))
        vertices = numpy.empty(len(mesh.loops), numpy.int32)
        mesh.vertices.foreach_get("co", places)
        mesh.loops.foreach_get("vertex_index", vertices)
        if hasattr(mesh, "calc_normals_split"):
            mesh.calc_normals_split()
            mesh.loops.foreach_get("normal", normals)
        else:
            mesh.corner_normals.foreach_get("vector", normals)
        matrix = numpy.array(instance.matrix_world)
        turn = numpy.linalg.inv(matrix[:3, :3]) * numpy.sign(numpy.linalg.det(matrix[:3, :3]))
        places = places.reshape(-1, 3)[vertices] @ matrix[:3, :3].T + matrix[:3, 3]
        found.append(numpy.concatenate((places, unit(normals.reshape(-1, 3) @ turn)), axis=1))
    return numpy.concatenate(found)[:, [0, 2, 1, 3, 5, 4]] * (1, 1, -1, 1, 1, -1)
