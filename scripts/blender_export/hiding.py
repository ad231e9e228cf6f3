"""Objects that are hidden in some frames: the viewport, which Blender evaluates outside of a render, follows the render's switch."""
import bpy

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
