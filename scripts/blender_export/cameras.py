"""The camera, baked frame by frame, and what else moves."""
import bpy

from .messages import fail, warn


def find_camera(scene, name):
    cameras = [o for o in scene.objects if o.type == "CAMERA"]
    if name is None and scene.camera is not None:
        return scene.camera
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    fail("no camera%s in the scene: it has %s" % (" '%s'" % name if name else "", ", ".join(c.name for c in cameras) or "none"))


def states(scene):
    """The transforms of everything visible or emitting, and the settings of lamps."""
    found = {}
    for o in scene.objects:
        if o.type in ("LIGHT", "MESH", "CURVE", "SURFACE", "META", "FONT") and not o.hide_render:
            numbers = [v for row in o.matrix_world for v in row]
            if o.type == "LIGHT":
                numbers += [o.data.energy, *o.data.color, getattr(o.data, "size", 0.0), getattr(o.data, "spot_size", 0.0)]
            found[o.name] = numbers
    return found


def warn_of_moves(moving):
    if moving:
        names = sorted(moving)
        more = " and %d more" % (len(names) - 5) if len(names) > 5 else ""
        warn("%s%s: moves or changes: taken as in the first frame" % (", ".join("'%s'" % n for n in names[:5]), more))


def bake_camera(scene, camera, first, last):
    """Bakes the camera into a new root camera with a key in every frame; warns of other animation."""
    data = camera.data.copy()
    baked = bpy.data.objects.new(camera.name + " baked", data)
    name = camera.name
    scene.collection.objects.link(baked)
    baked.rotation_mode = "QUATERNION"
    before, start, moving = None, None, set()
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        now = states(scene)
        start = start or now
        moving.update(n for n in now if n in start and max(abs(a - b) for a, b in zip(now[n], start[n])) > 1e-6)
        place, turn, _ = camera.matrix_world.decompose()
        if before is not None and before.dot(turn) < 0.0:
            turn.negate()  # interpolate along the shorter arc
        before = turn.copy()
        baked.location = place
        baked.rotation_quaternion = turn
        baked.keyframe_insert("location", frame=frame)
        baked.keyframe_insert("rotation_quaternion", frame=frame)
    warn_of_moves(moving)
    for curve in baked.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    if data.animation_data is not None:
        warn("the lens of '%s' is animated: the field of view of the first frame is taken" % name)
        data.animation_data_clear()
    scene.frame_set(first)
    places = [(child, child.matrix_world.copy()) for child in camera.children]
    for child, matrix in places:  # lamps attached to the original camera, which is removed
        child.parent = None
        child.matrix_world = matrix
    bpy.data.objects.remove(camera)
    baked.name = name
    scene.camera = baked
