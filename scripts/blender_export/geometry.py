"""Geometry as Blender renders it: modifiers at render level, instances realised, hidden objects left out.

Every object becomes one without parents, constraints, modifiers and animation: only the
camera moves in Reframe. Instances share one mesh, which `glb` places by
EXT_mesh_gpu_instancing.
"""
import bpy
import mathutils

from .messages import list_names, note, warn
from .moves import GEOMETRY

UNREAD = {"VOLUME": "a volume", "CURVES": "hair curves", "GPENCIL": "grease pencil", "POINTCLOUD": "a point cloud"}
RENDER_LEVELS = (("levels", "render_levels"), ("steps", "render_steps"), ("viewport_resolution", "resolution"),
                 ("show_viewport", "show_render"))


def layer_collections(root):
    yield root
    for child in root.children:
        yield from layer_collections(child)


def hidden_ways(o):
    """The rays for which an object is hidden."""
    ways = ("camera", "diffuse", "glossy", "transmission", "shadow")
    return [way for way in ways if not getattr(o, "visible_" + way)]


def settle_modifiers(o):
    for modifier in o.modifiers:
        for viewport, render in RENDER_LEVELS:
            if hasattr(modifier, viewport) and hasattr(modifier, render):
                setattr(modifier, viewport, getattr(modifier, render))
    for system in o.particle_systems:
        settings = system.settings
        settings.display_percentage = 100
        settings.display_method = "RENDER"
        settings.child_nbr = settings.rendered_child_count
        settings.display_step = settings.render_step


def settle_data(data):
    """Resolutions of curves and metaballs."""
    if isinstance(data, bpy.types.MetaBall):
        data.resolution = data.render_resolution
    elif isinstance(data, bpy.types.Curve):
        data.resolution_u = data.render_resolution_u or data.resolution_u
        data.resolution_v = data.render_resolution_v or data.resolution_v


def settle(scene):
    """Makes the viewport show what is rendered: outside of a render Blender evaluates for the viewport."""
    view_layer = bpy.context.view_layer
    visible = {o.name for o in view_layer.objects if o.visible_get()}
    render = scene.render
    render.simplify_subdivision = render.simplify_subdivision_render
    render.simplify_child_particles = render.simplify_child_particles_render
    for collection in bpy.data.collections:
        collection.hide_viewport = collection.hide_render
    for layer in layer_collections(view_layer.layer_collection):
        if not layer.exclude:
            layer.hide_viewport = False
    for o in bpy.data.objects:
        o.hide_viewport = o.hide_render
        o.show_instancer_for_viewport = o.show_instancer_for_render
        settle_modifiers(o)
        settle_data(o.data)
    for o in view_layer.objects:
        o.hide_set(False)
    view_layer.update()
    left = sorted(n for n in visible if not bpy.data.objects[n].visible_get() and bpy.data.objects[n].type in GEOMETRY + ("LIGHT",))
    if left:
        note("%s: left out, as hidden in renders" % list_names(left))


def held_out(view_layer):
    """Names of objects that leave a hole in Blender's pictures, by themselves or by their collection."""
    names = {o.name for o in view_layer.objects if o.is_holdout}
    for layer in layer_collections(view_layer.layer_collection):
        if layer.holdout:
            names.update(o.name for o in layer.collection.all_objects)
    return names


def is_left_out(o, holes):
    return o.name in holes or len(hidden_ways(o)) == 5


def warn_of_the_rest(objects, holes):
    def tell(chosen, text):
        names = sorted(o.name for o in chosen)
        if names:
            warn("%s: %s" % (list_names(names), text))

    shapes = [o for o in objects if o.type in GEOMETRY and not o.hide_render]
    tell([o for o in shapes if o.name in holes], "left out: holdouts do not exist in Reframe")
    tell([o for o in shapes if o.name not in holes and 0 < len(hidden_ways(o)) < 5],
         "hidden from some kinds of rays in Blender: seen by all here")
    tell([o for o in shapes if o.is_shadow_catcher], "a shadow catcher in Blender: an ordinary surface here")
    for kind, what in UNREAD.items():
        tell([o for o in objects if o.type == kind and not o.hide_render], "%s: left out" % what)
    tell([o for o in shapes if any(s.settings.type == "HAIR" and s.settings.render_type == "PATH" for s in o.particle_systems)],
         "hair: left out")


def has_shear(matrix):
    place, turn, scale = matrix.decompose()
    again = mathutils.Matrix.LocRotScale(place, turn, scale)
    size = max(abs(v) for row in matrix for v in row)
    return any(abs(a - b) > 1e-5 * size for row, other in zip(matrix, again) for a, b in zip(row, other))


def is_plain(o):
    """Is its mesh in the file what is rendered?"""
    return o.type == "MESH" and not o.modifiers and o.data.shape_keys is None and not o.particle_systems


class Builder:
    """Collects new objects while the depsgraph is read; nothing may be removed before it is done."""

    def __init__(self, depsgraph):
        self.depsgraph = depsgraph
        self.old = list(bpy.data.objects)
        self.meshes = {}  # by the evaluated data that they are made from
        self.objects = []  # (new object, name, matrix)
        self.instances = {}  # by the same: (name, mesh, matrices)

    def mesh_of(self, o):
        original = o.original
        if is_plain(original) and o.data.original == original.data:
            return original.data
        key = o.data.as_pointer() if o.data is not None else 0
        if key not in self.meshes:
            mesh = bpy.data.meshes.new_from_object(o, preserve_all_data_layers=True, depsgraph=self.depsgraph)
            if mesh is not None and isinstance(original.data, bpy.types.Mesh):
                mesh.use_auto_texspace = False  # generated coordinates stay those of the mesh as modelled
                mesh.texspace_location = original.data.texspace_location
                mesh.texspace_size = original.data.texspace_size
            self.meshes[key] = mesh
        return self.meshes[key]

    def place(self, o, name, data, matrix):
        new = bpy.data.objects.new(name, data)
        for key in o.original.keys():
            new[key] = o.original[key]
        for to, slot in zip(new.material_slots, o.original.material_slots):
            if slot.link == "OBJECT" and o.data is not None and data == o.original.data:
                to.link, to.material = "OBJECT", slot.material
        self.objects.append((new, name, matrix))

    def add_shape(self, o, matrix, own):
        mesh = self.mesh_of(o)
        if mesh is None or not mesh.polygons:
            return
        if has_shear(matrix):
            mesh = mesh.copy()
            mesh.transform(matrix)
            self.place(o, o.original.name, mesh, mathutils.Matrix())
        elif own:
            self.place(o, o.original.name, mesh, matrix)
        else:
            self.instances.setdefault(mesh.name, (o, mesh, []))[2].append(matrix)

    def add(self, instance, holes):
        o = instance.object
        if is_left_out(o.original, holes) or not (instance.is_instance or instance.show_self):
            return
        matrix = instance.matrix_world.copy()
        if o.type == "LIGHT":
            self.place(o, o.original.name, o.original.data, matrix)
        elif o.type in GEOMETRY:
            self.add_shape(o, matrix, not instance.is_instance)

    def finish(self, scene):
        """Replaces all objects; returns the matrices of instances by the name of their object."""
        placed = {}
        for o, mesh, matrices in self.instances.values():
            if len(matrices) == 1:
                self.place(o, o.original.name, mesh, matrices[0])
                continue
            self.place(o, o.original.name + " instances", mesh, mathutils.Matrix())
            placed[self.objects[-1][0]] = matrices
        bpy.data.batch_remove(self.old)
        for new, name, matrix in self.objects:
            scene.collection.objects.link(new)
            new.name = name
            new.matrix_world = matrix
        return {new.name: matrices for new, matrices in placed.items()}


def realise(scene):
    """Makes plain objects of what is rendered in this frame; returns the matrices of instances by object name."""
    view_layer = bpy.context.view_layer
    holes = held_out(view_layer)
    warn_of_the_rest(view_layer.objects, holes)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    builder = Builder(depsgraph)
    for instance in depsgraph.object_instances:
        builder.add(instance, holes)
    return builder.finish(scene)
