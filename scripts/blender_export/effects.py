"""Effects of the camera and the world: what Reframe has as the "lens" of a camera path, and what it does not have."""
import math

from .messages import warn


def warn_of_effects(scene, camera):
    if camera.data.dof.use_dof and abs(camera.data.dof.aperture_ratio - 1.0) > 1e-3:
        warn("'%s' has an aperture ratio of %g: exported as 1" % (camera.name, camera.data.dof.aperture_ratio))
    if camera.data.type == "PANO" and camera.data.dof.use_dof:
        warn("'%s' is panoramic: exported without its depth of field" % camera.name)
    if scene.render.use_border and scene.render.use_crop_to_border:
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
    render = scene.render
    if render.engine == "BLENDER_EEVEE":
        if not scene.eevee.use_motion_blur:
            return None
        length, position = scene.eevee.motion_blur_shutter, scene.eevee.motion_blur_position
    else:
        if not render.use_motion_blur:
            return None
        length = render.motion_blur_shutter
        position = scene.cycles.motion_blur_position if render.engine == "CYCLES" else "CENTER"
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
