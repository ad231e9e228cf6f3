"""Geometry as Blender renders it: modifiers at render level, instances realised, hidden objects left out.

Every object becomes one without parents, constraints, modifiers and animation; how it moves was recorded frame by frame
(`movement`), and is written by `tracks`. Instances share one mesh: those that stand still are placed by
EXT_mesh_gpu_instancing, the others by a node each.
"""
import bpy
import mathutils
import numpy

from . import coincident, shapes
from .messages import list_names, list_some, note, warn
from .movement import maker_of, shown_by
from .moves import GEOMETRY, animated_paths
from .versions import adaptive_of, children_of, shadow_offset_of, throws_shadow

ADAPTIVE_LEVELS, ADAPTIVE_FACES = 5, 250000  # at most, in the place of adaptive subdivision
COARSE = 0.87  # the cosine of 30 degrees
FEW_INSTANCES = 4  # of which each becomes an object
RENDER_LEVELS = (("levels", "render_levels"), ("steps", "render_steps"), ("viewport_resolution", "resolution"),
                 ("show_viewport", "show_render"))


def settle_modifiers(o):
    for modifier in o.modifiers:
        for viewport, render in RENDER_LEVELS:
            if hasattr(modifier, viewport) and hasattr(modifier, render):
                setattr(modifier, viewport, getattr(modifier, render))
    for system in o.particle_systems:
        settings = system.settings
        settings.display_percentage = 100
        settings.display_method = "RENDER"
        setattr(settings, children_of(settings), settings.rendered_child_count)
        settings.display_step = settings.render_step


def settle_adaptive(scene, objects):
    """Cycles' adaptive subdivision follows the camera, on top of what the modifier does: further levels in its place."""
    if scene.render.engine != "CYCLES":
        return
    for o in objects:
        last = o.modifiers[-1] if o.type == "MESH" and o.modifiers else None
        if last is None or last.type != "SUBSURF" or not last.show_render or not adaptive_of(scene, o, last):
            continue
        more, faces = 0, len(o.data.polygons) * 4 ** last.render_levels
        while more < ADAPTIVE_LEVELS and 4 * faces <= ADAPTIVE_FACES:
            more, faces = more + 1, 4 * faces
        subdivision = o.modifiers.new("adaptive", "SUBSURF")
        subdivision.subdivision_type, subdivision.uv_smooth = last.subdivision_type, last.uv_smooth
        subdivision.levels = subdivision.render_levels = more
        warn("'%s': adaptive subdivision: taken as %d further levels" % (o.name, more))


def settle_data(data):
    """Resolutions of curves and metaballs."""
    if isinstance(data, bpy.types.MetaBall):
        data.resolution = data.render_resolution
    elif isinstance(data, bpy.types.Curve):
        data.resolution_u = data.render_resolution_u or data.resolution_u
        data.resolution_v = data.render_resolution_v or data.resolution_v


def settle(scene):
    """Makes the viewport show what is rendered: outside of a render Blender evaluates for the viewport."""
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")  # a mesh that was saved while it was edited looks empty
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
    settle_adaptive(scene, [o for o in bpy.data.objects if not o.hide_render])
    for o in view_layer.objects:
        o.hide_set(False)
    view_layer.update()
    left = sorted(n for n in visible if not bpy.data.objects[n].visible_get() and bpy.data.objects[n].type in GEOMETRY + ("LIGHT",) and
                  "hide_render" not in animated_paths(bpy.data.objects[n]))
    if left:
        note("%s: left out, as hidden in renders" % list_some(left))


def has_shear(matrix):
    place, turn, scale = matrix.decompose()
    again = mathutils.Matrix.LocRotScale(place, turn, scale)
    size = max(abs(v) for row in matrix for v in row)
    return any(abs(a - b) > 1e-5 * size for row, other in zip(matrix, again) for a, b in zip(row, other))


def is_pattern(o):
    """Is it there only for the vertices or faces of an ancestor to repeat it?"""
    parent = o.parent
    while parent is not None and not (o.type != "META" and parent.instance_type in ("VERTS", "FACES")):
        parent = parent.parent
    return parent is not None


class Builder:
    """Makes the new objects, beside the old ones, which it replaces in the end. `world`: what was recorded."""

    def __init__(self, world):
        self.world = world
        self.old = list(bpy.data.objects)
        self.objects = []  # (new object, name, matrix, how it moves, when it is there)
        self.placed = []  # (new object, numbers of its instances that stand still, of those that do not)

    def place(self, original, name, data, matrix, path=None, flags=None):
        new = bpy.data.objects.new(name, data)
        for key in original.keys():
            new[key] = original[key]
        new.color, new.pass_index = original.color, original.pass_index  # materials may ask for them
        new.visible_shadow = original.visible_shadow
        for to, slot in zip(new.material_slots, original.material_slots):
            if slot.link == "OBJECT" and data == original.data:
                to.link, to.material = "OBJECT", slot.material
        self.objects.append((new, name, matrix, path, flags))
        return new

    def place_shape(self, original, mesh, number, within):
        """`within`: the frames in which it has this mesh, or None for all."""
        matrix, path = self.world.matrix(number), self.world.path(number)
        flags = self.world.flags.get(number)
        if within is not None:
            flags = within if flags is None else flags & within
            if not flags.any():
                return
        if path is None and has_shear(matrix):
            mesh, matrix = shapes.transformed(mesh, matrix), mathutils.Matrix()
        self.place(original, original.name, mesh, matrix, path, flags)

    def add(self, shape):
        """All things of a shape, in the order in which they were first seen."""
        if shape.is_lamp:
            for number in sorted(shape.things, key=lambda n: self.world.instanced[n]):
                path = self.world.path(number)
                self.place(shape.original, shape.original.name, shape.original.data, self.world.matrix(number),
                           path.unsheared() if path is not None else None, self.world.flags.get(number))
            return
        for mesh, within in self.world.meshes(shape):
            if mesh is not None and mesh.polygons:
                self.add_mesh(shape, mesh, within)

    def add_mesh(self, shape, mesh, within):
        world = self.world
        single = [n for n in shape.things if not world.instanced[n]]
        instances = [n for n in shape.things if world.instanced[n]]
        sheared = [n for n in instances if world.path(n) is None and has_shear(world.matrix(n))]
        straight = [n for n in instances if n not in set(sheared)]
        few = len(straight) <= FEW_INSTANCES or within is not None
        for number in single + sheared + (straight if few else []):
            self.place_shape(shape.original, mesh, number, within)
        if not few:
            new = self.place(shape.original, shape.original.name + " instances", mesh, mathutils.Matrix())
            still = [n for n in straight if world.is_still(n)]
            self.placed.append((new, still, [n for n in straight if not world.is_still(n)]))

    def finish(self, scene, tracks):
        """Replaces all objects; returns the matrices of instances by the name of their object, those that stand still first."""
        bpy.data.batch_remove(self.old)
        for new, name, matrix, path, flags in self.objects:
            scene.collection.objects.link(new)
            new.name = name  # which Blender 3 may take from another one
            new.matrix_world = matrix
        for new, _, _, path, flags in self.objects:
            if path is not None:
                tracks.place(new.name, path)
            if flags is not None:
                tracks.visible(new.name, flags)
        world, placed = self.world, {}
        for new, still, moving in self.placed:
            placed[new.name] = [world.matrix(n) for n in still + moving]
            if moving:
                tracks.flock(new.name, [(world.path(n) or world.rest(n), world.flags.get(n)) for n in moving])
        return placed


def realise(scene, world, tracks):
    """Makes plain objects of all that was recorded; returns the matrices of instances by object name."""
    tell_what_differs(scene, world.seen.rendered)
    builder = Builder(world)
    for shape in world.shapes.values():
        builder.add(shape)
    return builder.finish(scene, tracks)


# What is hidden from some kinds of rays in Blender, lights without shadows, or is not read at all: named, object by object.

WAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")
UNREAD = {"VOLUME": "a volume", "CURVES": "hair curves", "GPENCIL": "grease pencil", "GREASEPENCIL": "grease pencil", "POINTCLOUD": "a point cloud"}


def hidden_ways(instance):
    """The rays for which it is hidden, by itself or by what makes it."""
    pair = (maker_of(instance), shown_by(instance))
    return {way for way in WAYS if not all(getattr(o, "visible_" + way) for o in pair)}


def layer_collections(root):
    yield root
    for child in root.children:
        yield from layer_collections(child)


def held_out(view_layer):
    """Names of objects that leave a hole in Blender's pictures, by themselves or by their collection."""
    names = {o.name for o in view_layer.objects if o.is_holdout}
    for layer in layer_collections(view_layer.layer_collection):
        if layer.holdout:
            names.update(o.name for o in layer.collection.all_objects)
    return names


def is_left_out(instance, holes):
    """A lamp is as bright where it is held out; what no rays but those of shadows meet is no lamp. Instances are held out by what makes them."""
    hidden = hidden_ways(instance)
    if instance.object.type == "LIGHT":
        return not set(WAYS) - {"shadow"} - hidden
    return maker_of(instance).name in holes or len(hidden) == len(WAYS)


def tell(chosen, text):
    names = sorted(o.name for o in chosen)
    if names:
        warn("%s: %s" % (list_names(names), text))


def tell_lamps(lamps, engine):
    """`lamps`: with the rays that do not see them. Cycles' camera sees none unless that is asked for."""
    lamps = [(o, ways) for o, ways in lamps if not (o.data.type == "AREA" and o.data.cycles.is_portal)]
    tell([o for o, _ in lamps if not throws_shadow(o.data, engine)], "lights through everything in Blender: throws shadows here")
    tell([o for o, ways in lamps if ways - {"camera", "shadow"}], "hidden from some kinds of rays in Blender: lights all surfaces here")
    tell([o for o, _ in lamps if engine == "CYCLES" and o.data.cycles.max_bounces < min(bpy.context.scene.cycles.max_bounces, 1024)],
         "lights by few bounces in Blender: by all here")
    seen = [o for o, ways in lamps if "camera" not in ways and (o.data.type == "SPOT" and o.data.shadow_soft_size > 0.0 or
                                                                o.data.type == "SUN" and o.data.angle > 0.0)]
    tell(seen, "seen by the camera in Blender: not seen here")


def tell_shapes(shapes):
    """`shapes`: with the rays that do not see them."""
    tell([o for o, ways in shapes if ways - {"shadow"}], "hidden from some kinds of rays in Blender: seen by all here")
    tell([o for o, ways in shapes if ways == {"shadow"}], "throws no shadow in Blender: throws one here, unless it is of glass")
    tell([o for o, _ in shapes if any(s.settings.type == "HAIR" and s.settings.render_type == "PATH" for s in o.particle_systems)],
         "hair: left out")


def is_coarse(o, depsgraph):
    """Are corners on a quarter of its surface shaded by normals far from those of their faces?"""
    evaluated = o.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    count = shapes.array_of(mesh.polygons, "loop_total", 1, numpy.int32)
    face = shapes.array_of(mesh.polygons, "normal", 3, numpy.float32).reshape(-1, 3).repeat(count, axis=0)
    area = (shapes.array_of(mesh.polygons, "area", 1, numpy.float32) / count).repeat(count)
    is_off = (shapes.normals_of(mesh) * face).sum(axis=1) < COARSE
    evaluated.to_mesh_clear()
    return area[is_off].sum() > 0.25 * area.sum()


def tell_coarse(shapes_seen):
    """Cycles moves the origins of shadow rays off coarse faces towards the smooth surface that their normals mean."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    tell([o for o in shapes_seen if shadow_offset_of(o) > 0.0 and is_coarse(o, depsgraph)],
         "large smooth faces: up to 20 % darker where they turn from the light")


def tell_linking(lamps):
    """Objects with light linking, which Blender 4 has."""
    linked = [(o, o.light_linking) for o in lamps if hasattr(o, "light_linking")]
    tell([o for o, link in linked if link.receiver_collection is not None], "lights some objects only in Blender (light linking): all here")
    tell([o for o, link in linked if link.blocker_collection is not None],
         "only some objects throw its shadows in Blender (shadow linking): all do here")


class Seen:
    """Decides what is rendered, and keeps what is reported of."""

    def __init__(self, holes):
        self.holes, self.rendered = holes, Rendered()

    def __call__(self, instance):
        if instance.is_instance or instance.show_self:
            self.rendered.note(instance, self.holes)
        # text, curves and metaballs come twice: as themselves, and as the mesh that they become
        if instance.object.type not in ("LIGHT", "MESH") or is_left_out(instance, self.holes):
            return False
        return instance.is_instance or instance.show_self and not is_pattern(instance.object.original)


class Rendered:
    """All that is rendered, also as instances: which objects are reported of."""

    def __init__(self):
        self.objects = {}  # by full name: the original, and the rays for which it is hidden in one of its places
        self.kinds = {}  # by what becomes of them, originals by full name
        self.holes, self.catchers = {}, {}

    def note(self, instance, holes):
        shown, maker = shown_by(instance), maker_of(instance)
        if is_left_out(instance, holes):
            if maker.name in holes:
                self.holes[maker.name_full] = maker
            return
        self.kinds.setdefault(instance.object.type, {})[shown.name_full] = shown
        self.objects.setdefault(shown.name_full, (shown, set()))[1].update(hidden_ways(instance))
        if shown.type in GEOMETRY and (shown.is_shadow_catcher or maker.is_shadow_catcher):
            self.catchers[shown.name_full] = shown

    def of_types(self, *types):
        return [pair for pair in self.objects.values() if pair[0].type in types]


def tell_what_differs(scene, found):
    """Called before the objects are replaced."""
    tell_lamps(found.of_types("LIGHT"), scene.render.engine)
    tell_linking([o for o, _ in found.of_types("LIGHT", *GEOMETRY)])
    tell(found.holes.values(), "left out: holdouts do not exist in Reframe")
    tell_shapes(found.of_types(*GEOMETRY))
    if scene.render.engine == "CYCLES":
        tell_coarse([o for o, _ in found.of_types(*GEOMETRY)])
        coincident.warn_of({o.name_full for o, _ in found.of_types(*GEOMETRY)})
    tell(found.catchers.values(), "a shadow catcher in Blender: an ordinary surface here")
    for kind, what in UNREAD.items():
        tell(found.kinds.get(kind, {}).values(), "%s: left out" % what)
    by_layer = [layer for layer in layer_collections(bpy.context.view_layer.layer_collection) if layer.indirect_only]
    if by_layer:
        warn("%s: collections that the camera does not see in Blender: seen by all rays here" % list_names([c.name for c in by_layer]))
