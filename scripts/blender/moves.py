"""Objects that are hidden in some frames: the viewport, which Blender evaluates outside of a render, follows the render's switch."""
import hashlib

import bpy
import numpy

from .versions import curve_lists

SWITCHES = ("hide_render", "hide_viewport")
OF_RENDERS = ("show_render", "render_levels", "render_steps")  # of modifiers
OF_VIEWPORT = ("show_viewport", "levels", "steps")  # of them in the same order


def lists_of(o):
    """The keys of an object: lists of the F-curves of its action, and of its strips."""
    animation = o.animation_data
    if animation is None:
        return []
    holders = [animation] + [strip for track in animation.nla_tracks for strip in track.strips]
    return [curves for holder in holders for curves in curve_lists(holder)]


def animated_paths(o):
    """The properties of an object that keys, strips or drivers change."""
    curves = [curve for curves in lists_of(o) for curve in curves]
    return {curve.data_path for curve in curves + list(o.animation_data.drivers if o.animation_data is not None else [])}


def follow(o):
    """Drives the viewport's switch by that of renders; the object is evaluated in all frames then, also where it is hidden."""
    for curves in lists_of(o):
        for curve in [c for c in curves if c.data_path == "hide_viewport"]:
            curves.remove(curve)  # Blender hides by the keys before it looks at the driver
    o.driver_remove("hide_viewport")
    driver = o.driver_add("hide_viewport").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "SINGLE_PROP"
    variable.targets[0].id, variable.targets[0].data_path = o, "hide_render"


def follow_modifiers(o):
    """The viewport's keys of what renders have of modifiers, which are not those of renders."""
    for curves in lists_of(o):
        for curve in [c for c in curves if c.data_path.startswith("modifiers[") and c.data_path.endswith(OF_VIEWPORT)]:
            curves.remove(curve)


class Frames:
    """Sets frames, in which the viewport shows what renders do: objects hidden, modifiers switched. Simulations go through all frames
    from their start on, as they do in an animation that is rendered."""

    def __init__(self, scene):
        self.scene, self.start = scene, simulation_start(scene)
        self.switched = [o for o in bpy.data.objects if animated_paths(o) & set(SWITCHES)]
        self.modified = [o for o in bpy.data.objects if changes_in_renders(o)]
        for o in self.switched:
            follow(o)
        for o in self.modified:
            follow_modifiers(o)
        self.last = None

    def go(self, number):
        """Sets a frame, by way of those between it and the last one where simulations need them."""
        if self.start is not None:
            is_next = self.last is not None and self.last < number
            for between in range(self.last + 1 if is_next else min(self.start, number), number):
                self.set(between)
        self.set(number)

    def set(self, number):
        before = [o.hide_viewport for o in self.switched]
        self.scene.frame_set(number)
        if any([settle_renders(o) for o in self.modified]) or before != [o.hide_viewport for o in self.switched]:
            self.scene.frame_set(number)  # Blender hides by the drivers' values one evaluation late
        self.last = number


def settle_renders(o):
    """Gives the viewport what renders have of modifiers in this frame; says whether that is another thing than before."""
    changed = False
    for modifier in o.modifiers:
        for viewport, render in zip(OF_VIEWPORT, OF_RENDERS):
            if hasattr(modifier, viewport) and hasattr(modifier, render) and getattr(modifier, viewport) != getattr(modifier, render):
                setattr(modifier, viewport, getattr(modifier, render))
                changed = True
    return changed


def changes_in_renders(o):
    """Is a modifier switched in renders?"""
    return any(path.startswith("modifiers[") and path.endswith(OF_RENDERS) for path in animated_paths(o))


def simulates(tree):
    return any(node.type == "SIMULATION_OUTPUT" for part in trees_within(tree) for node in part.nodes)


def caches_of(scene):
    """Of simulations: the first frame of each."""
    world = scene.rigidbody_world
    if world is not None and world.enabled and world.collection is not None:
        yield world.point_cache.frame_start
    for o in scene.objects:
        for modifier in o.modifiers:
            if modifier.type in ("CLOTH", "SOFT_BODY"):
                yield modifier.point_cache.frame_start
            elif modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
                yield modifier.domain_settings.cache_frame_start
            elif modifier.type == "DYNAMIC_PAINT" and modifier.canvas_settings is not None:
                yield from (surface.frame_start for surface in modifier.canvas_settings.canvas_surfaces)
            elif modifier.type == "NODES" and simulates(modifier.node_group):
                yield scene.simulation_frame_start if getattr(scene, "use_custom_simulation_range", False) else scene.frame_start
        for system in o.particle_systems:
            if system.settings.physics_type != "NO" or system.settings.type == "HAIR" and system.use_hair_dynamics:
                yield min(system.point_cache.frame_start, int(system.settings.frame_start))


def simulation_start(scene):
    """The first frame of simulations; None without any."""
    return min(caches_of(scene), default=None)


GEOMETRY = ("MESH", "CURVE", "SURFACE", "META", "FONT")


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


def trees_within(tree):
    """A tree and those of its groups."""
    found, left = [], [tree]
    while left:
        tree = left.pop()
        if tree is not None and tree not in found:
            found.append(tree)
            left += [n.node_tree for n in tree.nodes if n.type == "GROUP"]
    return found
