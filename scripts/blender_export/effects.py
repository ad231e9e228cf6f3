"""Effects of the camera and the world: what Reframe has as the "lens" of a camera path, and what it does not have."""
import math

import bpy

from .messages import list_names, warn
from .names import motion_blur_of


def is_box(curve):
    """Is a shutter's curve open for all of its time?"""
    curve.initialize()
    return all(abs(curve.evaluate(curve.curves[0], 0.1 * i) - 1.0) < 1e-3 for i in range(11))


def warn_of_pictures(scene):
    """What Blender does to whole pictures."""
    render, cycles = scene.render, scene.render.engine == "CYCLES"
    if cycles and abs(scene.cycles.film_exposure - 1.0) > 1e-6:
        warn("the film's exposure of %g is ignored: pictures have the scene's own light" % scene.cycles.film_exposure)
    if scene.use_nodes and render.use_compositing and any(n.type not in ("R_LAYERS", "COMPOSITE", "VIEWER") for n in scene.node_tree.nodes):
        warn("the compositor's nodes are left out: pictures are those of the camera")
    if render.use_sequencer and scene.sequence_editor is not None and scene.sequence_editor.sequences:
        warn("the sequencer's strips are left out: the scene itself is exported")
    if render.use_multiview:
        warn("stereoscopy is left out: one camera is exported")
    if cycles and render.use_motion_blur and scene.cycles.rolling_shutter_type != "NONE":
        warn("the rolling shutter is taken as one that opens for all lines at once")
    if cycles and render.use_motion_blur and not is_box(render.motion_blur_shutter_curve):
        warn("the shutter's curve is taken as open all the time")
    if render.use_freestyle:
        warn("Freestyle's lines are left out")
    warn_of_view(scene)
    if cycles:
        warn_of_light(scene)
    warn_of_layers(scene)
    for layer in scene.view_layers:
        if layer.use and layer.material_override is not None:
            warn("view layer '%s' overrides materials by '%s': objects keep their own" % (layer.name, layer.material_override.name))


def warn_of_view(scene):
    """Pictures are scene-linear; the view transform, which every scene has, is not named."""
    view = scene.view_settings
    changes = [("exposure of %g" % view.exposure, view.exposure != 0.0), ("gamma of %g" % view.gamma, view.gamma != 1.0),
               ("look '%s'" % view.look, view.look != "None"), ("curves", view.use_curve_mapping)]
    names = [name for name, is_set in changes if is_set]
    if names:
        warn("the view's %s: left out: pictures have the scene's own light" % ", ".join(names))


def warn_of_light(scene):
    """Light that Cycles leaves out by its settings where they are lower than at first."""
    cycles = scene.cycles
    lows = [("%d in all" % cycles.max_bounces, cycles.max_bounces < 12), ("%d diffuse" % cycles.diffuse_bounces, cycles.diffuse_bounces < 4),
            ("%d glossy" % cycles.glossy_bounces, cycles.glossy_bounces < 4),
            ("%d by transmission" % cycles.transmission_bounces, cycles.transmission_bounces < 12),
            ("%d transparent" % cycles.transparent_max_bounces, cycles.transparent_max_bounces < 8)]
    limits = [name for name, is_low in lows if is_low]
    if limits:
        warn("light ends after few bounces in Blender (%s): it goes on here (see --max-depth)" % ", ".join(limits))
    for switch, what in (("caustics_reflective", "mirrors"), ("caustics_refractive", "glass")):
        if not getattr(cycles, switch):
            warn("caustics by %s are off in Blender: on here" % what)
    if cycles.sample_clamp_direct > 0.0 or 0.0 < cycles.sample_clamp_indirect < 10.0:
        warn("light is clamped in Blender: all of it is here")
    if cycles.use_fast_gi:
        warn("light is approximated after some bounces in Blender (fast GI): not here")
    if scene.render.film_transparent and cycles.film_transparent_glass:
        warn("the film is transparent behind glass in Blender: glass shows the world here")


def warn_of_layers(scene):
    """One view layer is exported, with all that is in it."""
    shown = bpy.context.view_layer
    others = [layer.name for layer in scene.view_layers if layer.use and layer.name != shown.name]
    if others:
        warn("view layers %s: left out: '%s' is exported" % (list_names(others), shown.name))
    for switch, what in (("use_sky", "the world in Blender: exported with it"), ("use_solid", "surfaces in Blender: exported with them")):
        if not getattr(shown, switch):
            warn("view layer '%s' is rendered without %s" % (shown.name, what))


def warn_of_effects(scene, camera):
    if camera.data.dof.use_dof and abs(camera.data.dof.aperture_ratio - 1.0) > 1e-3:
        warn("'%s' has an aperture ratio of %g: exported as 1" % (camera.name, camera.data.dof.aperture_ratio))
    if camera.data.type == "PANO" and camera.data.dof.use_dof:
        warn("'%s' is panoramic: exported without its depth of field" % camera.name)
    warn_of_pictures(scene)
    if scene.render.use_border:
        warn("the render region is ignored: the whole picture is exported")
    out = scene.world.node_tree.get_output_node("CYCLES") if scene.world is not None and scene.world.use_nodes else None
    if out is not None and out.inputs["Volume"].is_linked:
        warn("world '%s' has a volume: left out" % scene.world.name)


def focus_of(camera, projection):
    """The f-number and the distance in focus along the view; None for a camera that is sharp everywhere."""
    dof = camera.data.dof
    if not dof.use_dof or projection == "panoramic":
        return None
    distance = dof.focus_distance
    if dof.focus_object is not None:
        target = dof.focus_object.matrix_world.translation
        if dof.focus_subtarget and dof.focus_object.pose is not None:
            bone = dof.focus_object.pose.bones.get(dof.focus_subtarget)
            target = dof.focus_object.matrix_world @ bone.matrix.translation if bone is not None else target
        distance = abs((camera.matrix_world.normalized().inverted() @ target).z)
    return max(dof.aperture_fstop, 1e-5), max(distance, 1e-5)


def shutter_of(scene):
    """When the shutter opens and closes, in frames from the frame itself; None without motion blur."""
    is_on, length, position = motion_blur_of(scene)
    if not is_on:
        return None
    start = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[position]
    return start * length, (start + 1.0) * length


def lens_of_path(scene, camera, fov, is_focused):
    """The "lens" of a camera path (anim/camera-path.schema.json), without what its keys have; None for a plain one."""
    lens, dof = {}, camera.data.dof
    if is_focused and fov is not None:
        # with the field of view this gives the focal length that Blender divides by the f-number
        lens["sensor"] = float("%.9g" % (2.0 * camera.data.lens * math.tan(math.radians(0.5 * fov))))
    if is_focused:
        if dof.aperture_blades >= 3:
            lens["blades"] = dof.aperture_blades
            # Cycles counts from the middle of a blade
            lens["rotation"] = float("%.9g" % (math.degrees(dof.aperture_rotation) + 180.0 / dof.aperture_blades))
    shutter = shutter_of(scene)
    if shutter is not None and shutter[1] > shutter[0]:
        lens["shutter"] = [float("%.9g" % s) for s in shutter]
    return lens or None
