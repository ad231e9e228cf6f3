"""Objects that are hidden in some frames: the viewport, which Blender evaluates outside of a render, follows the render's switch."""
import hashlib

import bpy
import numpy

from .messages import list_names, warn

SWITCHES = ("hide_render", "hide_viewport")
OF_RENDERS = ("show_render", "render_levels", "render_steps")  # of modifiers, whose viewport's values are set once


def actions_of(o):
    """The keys of an object: those of its action, and of its strips."""
    animation = o.animation_data
    if animation is None:
        return []
    actions = [animation.action] + [strip.action for track in animation.nla_tracks for strip in track.strips]
    return [action for action in actions if action is not None]


def animated_paths(o):
    """The properties of an object that keys, strips or drivers change."""
    curves = [curve for action in actions_of(o) for curve in action.fcurves]
    return {curve.data_path for curve in curves + list(o.animation_data.drivers if o.animation_data is not None else [])}


def follow(o):
    """Drives the viewport's switch by that of renders; the object is evaluated in all frames then, also where it is hidden."""
    for action in actions_of(o):
        for curve in [c for c in action.fcurves if c.data_path == "hide_viewport"]:
            action.fcurves.remove(curve)  # Blender hides by the keys before it looks at the driver
    o.driver_remove("hide_viewport")
    driver = o.driver_add("hide_viewport").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "SINGLE_PROP"
    variable.targets[0].id, variable.targets[0].data_path = o, "hide_render"


class Frames:
    """Sets frames, with all objects hidden that are hidden in renders of them."""

    def __init__(self, scene):
        self.scene = scene
        self.switched = [o for o in bpy.data.objects if animated_paths(o) & set(SWITCHES)]
        for o in self.switched:
            follow(o)

    def set(self, number):
        before = [o.hide_viewport for o in self.switched]
        self.scene.frame_set(number)
        if before != [o.hide_viewport for o in self.switched]:
            self.scene.frame_set(number)  # Blender hides by the drivers' values one evaluation late


def changes_in_renders(o):
    """Is a modifier switched in renders? In the viewport it is as in the first frame."""
    return any(path.startswith("modifiers[") and path.endswith(OF_RENDERS) for path in animated_paths(o))


# What moves or changes, and is not exported: everything but the camera.

GEOMETRY = ("MESH", "CURVE", "SURFACE", "META", "FONT")
LAMP = ("energy", "size", "size_y", "spread", "spot_size", "spot_blend", "shadow_soft_size", "angle")  # each for some kinds


def state_of(o):
    """The transform of an object that is visible or emits, and the settings of a lamp."""
    numbers = [v for row in o.matrix_world for v in row]
    if o.type == "LIGHT":
        numbers += [*o.data.color, *(getattr(o.data, name, 0.0) for name in LAMP)]
    return numbers


def carried_by(mesh):
    """Texture coordinates, colours and other attributes, and the materials of faces: each with a name and the length of its values."""
    kinds = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3), "FLOAT2": ("vector", 2),
             "FLOAT": ("value", 1), "INT": ("value", 1)}
    found = [(layer.data, "uv", 2) for layer in mesh.uv_layers] + [(mesh.polygons, "material_index", 1)]
    return found + [(a.data, *kinds[a.data_type]) for a in mesh.attributes if a.data_type in kinds and a.name != "position"]


def shape_of(o):
    """A digest of an evaluated object's own shape, and of what its vertices, corners and faces carry for materials."""
    digest = hashlib.md5(repr([tuple(corner) for corner in o.bound_box]).encode())
    if o.type == "MESH":
        points = numpy.empty(3 * len(o.data.vertices), numpy.float32)
        o.data.vertices.foreach_get("co", points)
        digest.update(points.tobytes())
        for values, name, width in carried_by(o.data):
            numbers = numpy.empty(width * len(values), numpy.float32)
            values.foreach_get(name, numbers)
            digest.update(numbers.tobytes())
    return digest.digest()


def instances_of(depsgraph):
    """Number and mean place of the instances by the object that makes them."""
    found = {}
    for instance in depsgraph.object_instances:
        if instance.is_instance and instance.parent is not None:
            count, total = found.get(instance.parent.name, (0, numpy.zeros(16)))
            found[instance.parent.name] = count + 1, total + numpy.array(instance.matrix_world).ravel()
    return found


def is_shown(o):
    """Is it an object that is seen, emits, or makes instances?"""
    return o.type in ("LIGHT", *GEOMETRY) or o.instance_type != "NONE"


class Watcher:
    """Compares the frames with the first one; `view_layer` shows what is rendered."""

    def __init__(self, scene, view_layer):
        self.scene, self.first, self.moving = scene, None, set()
        # what is hidden by its collection is so in all frames
        self.objects = [o for o in view_layer.objects if is_shown(o) and (o.visible_get() or o.hide_render)]
        self.hidden = set()  # names of those that are hidden in some frames
        self.shapes = {}  # by name, of objects whose geometry Blender has updated
        self.instances = None
        self.updated = set()  # names of objects that Blender has made anew for this frame
        bpy.app.handlers.frame_change_post.append(self.collect)

    def collect(self, scene, depsgraph):
        """The list of updates is there only during this call."""
        self.updated |= {u.id.name for u in depsgraph.updates if u.is_updated_geometry and isinstance(u.id, bpy.types.Object)}

    def note(self, depsgraph, with_instances):
        now = {o.name: state_of(o.evaluated_get(depsgraph)) for o in self.objects if not o.hide_render}
        if self.first is None:
            self.first = now
            self.moving = {o.name for o in self.objects if o.name in now and changes_in_renders(o)}
        self.hidden |= set(now) ^ set(self.first)
        self.moving.update(n for n in now
                           if n in self.first and max(abs(a - b) for a, b in zip(now[n], self.first[n])) > 1e-6)
        for name in self.updated & set(now) - self.moving:
            o = self.scene.objects[name]
            if o.type in GEOMETRY:
                self.shapes.setdefault(o.name, set()).add(shape_of(o.evaluated_get(depsgraph)))
        self.updated.clear()
        if with_instances:
            found = instances_of(depsgraph)
            self.instances = found if self.instances is None else self.instances
            for name in set(found) | set(self.instances):
                a, b = found.get(name), self.instances.get(name)
                if a is None or b is None or a[0] != b[0] or not numpy.allclose(a[1], b[1], rtol=1e-6, atol=1e-5):
                    self.moving.add(name)

    def finish(self, depsgraph):
        """Called in the first frame again; returns the names, sorted."""
        bpy.app.handlers.frame_change_post.remove(self.collect)
        for name, shapes in self.shapes.items():
            if shapes - {shape_of(self.scene.objects[name].evaluated_get(depsgraph))}:
                self.moving.add(name)
        for names, what in ((self.moving - self.hidden, "moves or changes"), (self.hidden, "hidden in some of the frames")):
            if names:
                warn("%s: %s: not exported; as in the first frame, by `reframe render --freeze` alone" % (list_names(sorted(names)), what))
        return sorted(self.moving | self.hidden)


# What changes by keys, drivers or frames of a film within a tree of nodes, all of which is taken as in the first frame.

FILMS = ("SEQUENCE", "MOVIE")


def trees_within(tree):
    """A tree and those of its groups."""
    found, left = [], [tree]
    while left:
        tree = left.pop()
        if tree is not None and tree not in found:
            found.append(tree)
            left += [n.node_tree for n in tree.nodes if n.type == "GROUP"]
    return found


def is_film(node):
    """Does an image node show another picture in another frame?"""
    if getattr(node, "image", None) is None or node.image.source not in FILMS:
        return False
    user = getattr(node, "image_user", None)
    return user is not None and user.use_auto_refresh and user.frame_duration > 1


def tell_animation(tree, tell):
    """Calls tell(node, text) for each node that changes; the node is None for what is not of one node."""
    for part in trees_within(tree):
        for path in sorted(animated_paths(part)):
            tell(part.nodes.get(path.split('"')[1]) if path.startswith('nodes["') else None, "animated or driven: taken as in the first frame")
        for node in part.nodes:
            if is_film(node):
                tell(node, "shows the frames of a film: taken as in the first frame")
