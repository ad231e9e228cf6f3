"""The camera, frame by frame, as Blender renders with it."""
import math

import bpy
import mathutils

from .effects import focus_of, lens_of_path
from .messages import fail, list_names, note
from .names import panorama_of

SHARP = 1e6  # f-number
Y_UP = mathutils.Quaternion((math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0))  # from Blender's axes to glTF's


def find_camera(scene, name):
    cameras = [o for o in scene.objects if o.type == "CAMERA"]
    if name is None and scene.camera is not None:
        return scene.camera
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    fail("no camera%s in the scene: it has %s" % (" '%s'" % name if name else "", ", ".join(c.name for c in cameras) or "none"))


def tell_others(scene, name):
    """Cameras that are not exported; those that markers switch to are."""
    used = {name, *(marker.camera.name for marker in scene.timeline_markers if marker.camera is not None)}
    others = sorted(o.name for o in scene.objects if o.type == "CAMERA" and o.name not in used)
    if others:
        note("%s: left out: --camera exports another one" % list_names(others))


def rounded(values):
    return [float("%.9g" % v) for v in values]


def film_of(scene):
    """The size of Blender's pictures in pixels."""
    render = scene.render
    share = render.resolution_percentage / 100.0
    return max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)


def projection_of(scene, camera):
    """As a camera path has it; fails for panoramas other than the whole sphere by longitude and latitude."""
    if camera.data.type == "PERSP":
        return "perspective"
    if camera.data.type == "ORTHO":
        return "orthographic"
    panorama = panorama_of(camera.data)
    kind = panorama.panorama_type.lower().replace("_", " ") if scene.render.engine == "CYCLES" else "panoramic, which only Cycles renders"
    if kind != "equirectangular":
        fail("'%s' is %s: of panoramas only equirectangular ones can be exported" % (camera.name, kind))
    whole = (panorama.longitude_min, panorama.longitude_max, panorama.latitude_min, panorama.latitude_max)
    if max(abs(a - b) for a, b in zip(whole, (-math.pi, math.pi, -0.5 * math.pi, 0.5 * math.pi))) > 1e-4:
        fail("'%s' shows a part of the sphere: only whole panoramas can be exported" % camera.name)
    return "panoramic"


def lens_of(scene, camera, depsgraph):
    """The vertical field of view in degrees, or half the height of an orthographic picture; the shift in heights of the picture."""
    kind = projection_of(scene, camera)
    if kind == "panoramic":
        return None, (0.0, 0.0)
    width, height = film_of(scene)
    render = scene.render
    m = camera.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    if kind == "orthographic":
        return 1.0 / m[1][1], (-0.5 * m[0][3] * m[1][1] / m[0][0], -0.5 * m[1][3])
    return math.degrees(2.0 * math.atan(1.0 / m[1][1])), (0.5 * m[0][2] * m[1][1] / m[0][0], 0.5 * m[1][2])


class Recorder:
    """Notes the camera in every frame that it is shown."""

    def __init__(self, scene, camera, follow):
        self.scene, self.camera, self.follow = scene, camera, follow
        self.keys, self.before, self.camera_now = [], None, None
        self.projection = None  # of all frames
        self.focus = []  # of each key: f-number and distance, or None

    def note(self, number, depsgraph):
        # markers in the timeline may change the active camera
        camera = (self.scene.camera if self.follow and self.scene.camera else self.camera).evaluated_get(depsgraph)
        self.camera_now = camera
        place, turn, _ = camera.matrix_world.decompose()
        if self.before is not None and self.before.dot(turn) < 0.0:
            turn.negate()  # interpolate along the shorter arc
        self.before = turn.copy()
        projection = projection_of(self.scene, camera)
        if self.projection not in (None, projection):
            fail("frame %d is %s, those before it are %s: export them one by one by --frames" % (number, projection, self.projection))
        self.projection = projection
        extent, shift = lens_of(self.scene, camera, depsgraph)
        self.keys.append((number, place.copy(), turn.copy(), extent, shift))
        self.focus.append(focus_of(camera, projection))

    def extents(self):
        """By which name a camera path has them."""
        return {"perspective": "fov", "orthographic": "ymag", "panoramic": None}[self.projection]

    def path(self, step):
        """A camera path (anim/camera-path.schema.json) with a key in every frame."""
        render = self.scene.render
        shifts = any(max(abs(s) for s in key[4]) > 1e-7 for key in self.keys)
        path = {"kind": "keyed", "interpolation": "linear", "keys": []}
        if step > 1:
            path["step"] = step
        if self.projection != "perspective":
            path["projection"] = self.projection
        if self.projection != "panoramic" and render.pixel_aspect_x != render.pixel_aspect_y:
            path["pixelAspect"] = float("%.9g" % (render.pixel_aspect_x / render.pixel_aspect_y))
        below = min(self.keys[0][0], 0)
        is_focused = any(focus is not None for focus in self.focus)
        lens = lens_of_path(self.scene, self.camera, self.keys[0][3] if self.projection == "perspective" else None, is_focused)
        if lens is not None:
            path["lens"] = lens
        for (number, place, turn, extent, shift), focus in zip(self.keys, self.focus):
            turn = Y_UP @ turn
            key = {"frame": number - below, "position": rounded((place.x, place.z, -place.y)),
                   "rotation": rounded((turn.x, turn.y, turn.z, turn.w))}
            if extent is not None:
                key[self.extents()] = float("%.9g" % extent)
            if shifts:
                key["shift"] = rounded(shift)
            if is_focused:
                # markers may change to a camera without depth of field
                key["fstop"], key["focus"] = rounded(focus or (SHARP, 10.0))
            path["keys"].append(key)
        return path


def bake_camera(scene, name, recorder):
    """A camera at the root with a key in every frame, for programs that do not know Reframe's path."""
    data = bpy.data.cameras.new(name)
    baked = bpy.data.objects.new(name, data)
    scene.collection.objects.link(baked)
    data.sensor_fit = "VERTICAL"
    if recorder.projection == "perspective":
        data.angle = math.radians(recorder.keys[0][3])
    if recorder.projection == "orthographic":
        data.type, data.ortho_scale = "ORTHO", 2.0 * recorder.keys[0][3]
    baked.rotation_mode = "QUATERNION"
    for number, place, turn, _, _ in recorder.keys:
        baked.location = place
        baked.rotation_quaternion = turn
        baked.keyframe_insert("location", frame=number)
        baked.keyframe_insert("rotation_quaternion", frame=number)
    for curve in baked.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.camera = baked
    return baked
