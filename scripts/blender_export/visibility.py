"""What is hidden from some kinds of rays in Blender, lights without shadows, or is not read at all: named, object by object."""
import bpy

from .messages import list_names, warn
from .moves import GEOMETRY
from .names import throws_shadow

WAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")
UNREAD = {"VOLUME": "a volume", "CURVES": "hair curves", "GPENCIL": "grease pencil", "GREASEPENCIL": "grease pencil", "POINTCLOUD": "a point cloud"}


def maker_of(instance):
    """The object that makes an instance, or what is no instance itself."""
    return (instance.parent if instance.is_instance else instance.object).original


def shown_by(instance):
    """The object whose shape is seen."""
    return (instance.instance_object if instance.is_instance else instance.object).original


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
    """`lamps`: with the rays that do not see them. Cycles' camera sees none unless that is asked for: lights.InView tells of those."""
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


def tell_linking(lamps):
    """Objects with light linking, which Blender 4 has."""
    linked = [(o, o.light_linking) for o in lamps if hasattr(o, "light_linking")]
    tell([o for o, link in linked if link.receiver_collection is not None], "lights some objects only in Blender (light linking): all here")
    tell([o for o, link in linked if link.blocker_collection is not None],
         "only some objects throw its shadows in Blender (shadow linking): all do here")


class Rendered:
    """All that is rendered, also as instances: which objects are reported of."""

    def __init__(self, depsgraph, holes):
        self.objects = {}  # by full name: the original, and the rays for which it is hidden in one of its places
        self.kinds = {}  # by what becomes of them, originals by full name
        self.holes, self.catchers = {}, {}
        for instance in depsgraph.object_instances:
            if instance.is_instance or instance.show_self:
                self.note(instance, holes)

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


def tell_what_differs(scene, depsgraph, holes):
    """Called before the objects are replaced; they are shown as rendered."""
    found = Rendered(depsgraph, holes)
    tell_lamps(found.of_types("LIGHT"), scene.render.engine)
    tell_linking([o for o, _ in found.of_types("LIGHT", *GEOMETRY)])
    tell(found.holes.values(), "left out: holdouts do not exist in Reframe")
    tell_shapes(found.of_types(*GEOMETRY))
    tell(found.catchers.values(), "a shadow catcher in Blender: an ordinary surface here")
    for kind, what in UNREAD.items():
        tell(found.kinds.get(kind, {}).values(), "%s: left out" % what)
    by_layer = [layer for layer in layer_collections(bpy.context.view_layer.layer_collection) if layer.indirect_only]
    if by_layer:
        warn("%s: collections that the camera does not see in Blender: seen by all rays here" % list_names([c.name for c in by_layer]))
