"""The camera, frame by frame, as Blender renders with it."""
import math

import bpy
import mathutils

from .messages import fail, list_names, list_some, lose, note, warn
from .versions import compositor_of, curve_lists, has_nodes, has_strips, motion_blur_of, panorama_of

SHARP = 1e6  # f-number
CUT = 1e-4  # frames between the last key before a cut and the first one behind it
_region = None  # of the picture, that the render engine asks for: left, bottom, right, top in pixels
Y_UP = mathutils.Quaternion((math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0))  # from Blender's axes to glTF's


def find_camera(scene, name):
    cameras = [o for o in scene.objects if o.type == "CAMERA"]
    if name is None and scene.camera is not None:
        return scene.camera
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    if not cameras:
        fail("no camera in the scene: add one")
    fail("no camera '%s' in the scene: it has %s" % (name, ", ".join(c.name for c in cameras)))


def tell_others(scene, name):
    """Cameras that are not exported; those that markers switch to are."""
    used = {name, *(marker.camera.name for marker in scene.timeline_markers if marker.camera is not None)}
    others = sorted(o.name for o in scene.objects if o.type == "CAMERA" and o.name not in used)
    if others:
        note("%s: left out: --camera exports another one" % list_some(others))


def rounded(values):
    return [float("%.9g" % v) for v in values]


def begin(args):
    global _region
    _region = args.engine


def film_of(scene):
    """The size of the exported pictures in pixels."""
    if _region is not None:
        return _region[2] - _region[0], _region[3] - _region[1]
    return picture_of(scene)


def picture_of(scene):
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
    if camera.data.type != "PANO":
        fail("'%s' is of the type %s: its rays are known to Blender alone" % (camera.name, camera.data.type.lower()))
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
    width, height = picture_of(scene)
    render = scene.render
    m = camera.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    if _region is not None:
        left, bottom, right, top = _region
        for row, low, high, size in ((0, left, right, width), (1, bottom, top, height)):
            scale, middle = size / (high - low), (low + high) / size - 1.0
            m[row][row], m[row][2], m[row][3] = m[row][row] * scale, (m[row][2] + middle) * scale, (m[row][3] - middle) * scale
    if kind == "orthographic":
        return 1.0 / m[1][1], (-0.5 * m[0][3] * m[1][1] / m[0][0], -0.5 * m[1][3])
    return math.degrees(2.0 * math.atan(1.0 / m[1][1])), (0.5 * m[0][2] * m[1][1] / m[0][0], 0.5 * m[1][2])


class Recorder:
    """Notes the camera in every frame that it is shown."""

    def __init__(self, scene, camera, follow):
        self.scene, self.camera, self.follow = scene, camera, follow
        self.keys, self.before, self.camera_now = [], {}, None
        self.active = None  # the camera of the last key
        self.cuts = {}  # by the number of the frame that another camera begins with: where the one before is then, and the other was
        self.bound = [m.camera for m in scene.timeline_markers if m.camera is not None] if follow else []
        self.last = {}  # the keys of these in the frame before
        self.projection = None  # of all frames
        self.focus = []  # of each key: f-number and distance, or None

    def note(self, number, depsgraph):
        # markers in the timeline may change the active camera
        active = self.scene.camera if self.follow and self.scene.camera else self.camera
        camera = active.evaluated_get(depsgraph)
        self.camera_now = camera
        projection = projection_of(self.scene, camera)
        if self.projection not in (None, projection):
            fail("frame %d is %s, those before it are %s: export them one by one by --frames" % (number, projection, self.projection))
        self.projection = projection
        key = self.key_of(number, camera, depsgraph)
        if self.active not in (None, active):
            self.cuts[number] = self.key_of(number, self.active.evaluated_get(depsgraph), depsgraph), self.last.get(active.name_full, key)
        self.active = active
        self.keys.append(key)
        self.focus.append(focus_of(camera, projection))
        self.last = {o.name_full: self.key_of(number, o.evaluated_get(depsgraph), depsgraph) for o in self.bound
                     if projection_of(self.scene, o) == projection}

    def key_of(self, number, camera, depsgraph):
        place, turn, _ = camera.matrix_world.decompose()
        before = self.before.get(camera.name_full)
        if before is not None and before.dot(turn) < 0.0:
            turn.negate()  # interpolate along the shorter arc
        self.before[camera.name_full] = turn.copy()
        extent, shift = lens_of(self.scene, camera, depsgraph)
        return number, place.copy(), turn.copy(), extent, shift

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
        below = min(self.keys[0][0], 1) - 1
        is_focused = any(focus is not None for focus in self.focus)
        lens = lens_of_path(self.scene, self.camera, self.keys[0][3] if self.projection == "perspective" else None, is_focused)
        if lens is not None:
            path["lens"] = lens
        for (number, place, turn, extent, shift), focus, is_cut in self.keys_with_cuts():
            turn = Y_UP @ turn
            key = {"frame": float("%.9g" % (number - below)), "position": rounded((place.x, place.z, -place.y)),
                   "rotation": rounded((turn.x, turn.y, turn.z, turn.w))}
            if key["frame"] == int(key["frame"]):
                key["frame"] = int(key["frame"])
            if is_cut:
                key["cut"] = True
            if extent is not None:
                key[self.extents()] = float("%.9g" % extent)
            if shifts:
                key["shift"] = rounded(shift)
            if is_focused:
                # markers may change to a camera without depth of field
                key["fstop"], key["focus"] = rounded(focus or (SHARP, 10.0))
            path["keys"].append(key)
        return path

    def keys_with_cuts(self):
        """The keys with their focus, and whether a cut is there. With motion blur, both cameras go on until half-way between what the
        shutter sees of the frames on either side, as in Blender."""
        blurs = shutter_of(self.scene) is not None
        for i, (key, focus) in enumerate(zip(self.keys, self.focus)):
            number = key[0]
            at = number + min(middle_of_shutter(self.scene), 0.49) - 0.5
            if number not in self.cuts or not blurs:
                yield key, focus, number in self.cuts
                continue
            before, (ends, begins) = self.keys[i - 1], self.cuts[number]
            at = max(at, before[0] + 0.01)
            yield between(before, ends, at - CUT), self.focus[i - 1], False
            yield between(begins, key, at), focus, True
            yield key, focus, False


def between(a, b, number):
    """The key at a time between two others."""
    if a[0] == b[0]:
        return number, *b[1:]
    t = (number - a[0]) / (b[0] - a[0])
    extent = a[3] + t * (b[3] - a[3]) if a[3] is not None else None
    return number, a[1].lerp(b[1], t), a[2].slerp(b[2], t), extent, [x + t * (y - x) for x, y in zip(a[4], b[4])]


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
    for curves in curve_lists(baked.animation_data):
        for curve in curves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
    scene.camera = baked
    return baked


# Effects of the camera and the world: what Reframe has as the "lens" of a camera path, and what it does not have.


def is_box(curve):
    """Is a shutter's curve open for all of its time?"""
    curve.initialize()
    return all(abs(curve.evaluate(curve.curves[0], 0.1 * i) - 1.0) < 1e-3 for i in range(11))


PLAIN_COMPOSITOR = ("R_LAYERS", "COMPOSITE", "VIEWER", "GROUP_OUTPUT", "REROUTE", "FRAME")  # nodes that leave pictures as they are


def warn_of_pictures(scene):
    """What Blender does to whole pictures."""
    render, cycles = scene.render, scene.render.engine == "CYCLES"
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if space != "Linear Rec.709":
        lose("the working colour space is %s: its colours are taken as those of Linear Rec.709" % space)
    if _region is None:
        warn_of_finish(scene, cycles)
    if render.use_multiview:
        warn("stereoscopy is left out: one camera is exported")
    if cycles and render.use_motion_blur and scene.cycles.rolling_shutter_type != "NONE":
        warn("the rolling shutter is taken as one that opens for all lines at once")
    if cycles and render.use_motion_blur and not is_box(render.motion_blur_shutter_curve):
        warn("the shutter's curve is taken as open all the time")
    if cycles and render.use_simplify:
        warn_of_culling(scene)
    if render.use_freestyle:
        warn("Freestyle's lines are left out")
    if cycles:
        warn_of_light(scene)
    warn_of_layers(scene)
    for layer in scene.view_layers:
        if layer.use and layer.material_override is not None:
            warn("view layer '%s' overrides materials by '%s': objects keep their own" % (layer.name, layer.material_override.name))


def warn_of_culling(scene):
    """Objects that Cycles leaves out by where the camera is."""
    for switch, where in (("use_camera_cull", "outside of the camera's view"), ("use_distance_cull", "far from the camera")):
        names = [o.name for o in scene.objects if getattr(o.cycles, switch)] if getattr(scene.cycles, switch) else []
        if names:
            warn("%s: left out where they are %s in Blender (culling): always there here" % (list_some(names), where))


def warn_of_finish(scene, cycles):
    """What Blender does to finished pictures; those of the render engine go through it."""
    render = scene.render
    if cycles and abs(scene.cycles.film_exposure - 1.0) > 1e-6:
        warn("the film's exposure of %g is taken as one of the view: files have the scene's own light" % scene.cycles.film_exposure)
    compositor = compositor_of(scene) if render.use_compositing else None
    if compositor is not None and any(n.type not in PLAIN_COMPOSITOR for n in compositor.nodes):
        warn("the compositor's nodes are left out: pictures are those of the camera")
    if render.use_sequencer and has_strips(scene):
        warn("the sequencer's strips are left out: the scene itself is exported")
    warn_of_view(scene)


def warn_of_view(scene):
    if scene.view_settings.use_curve_mapping:
        warn("the view's curves are left out")
    if scene.display_settings.display_device != "sRGB":
        warn("the display '%s': pictures are shown as for sRGB" % scene.display_settings.display_device)


def view_of(scene):
    """How pictures are shown (extras that src/scene/shared_json.c reads); files are scene-linear."""
    view = scene.view_settings
    film = math.log2(scene.cycles.film_exposure) if scene.render.engine == "CYCLES" and scene.cycles.film_exposure > 0.0 else 0.0
    return {"transform": view.view_transform, "look": view.look, "exposure": float("%.6g" % (view.exposure + film)),
            "gamma": float("%.6g" % view.gamma)}


def warn_of_light(scene):
    """Light that Cycles leaves out by its switches; what its limits cut is measured (pilot.py)."""
    cycles = scene.cycles
    for switch, what in (("caustics_reflective", "mirrors"), ("caustics_refractive", "glass")):
        if not getattr(cycles, switch):
            warn("caustics by %s are off in Blender: on here" % what)
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
    if scene.render.use_border and _region is None:
        warn("the render region is ignored: the whole picture is exported")
    out = scene.world.node_tree.get_output_node("CYCLES") if scene.world is not None and has_nodes(scene.world) else None
    if out is not None and out.inputs["Volume"].is_linked:
        lose("world '%s' has a volume, which takes light on its way: left out" % scene.world.name)


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


def middle_of_shutter(scene):
    """Of the time that the shutter is open, in frames from the frame itself."""
    shutter = shutter_of(scene)
    return 0.0 if shutter is None else 0.5 * (shutter[0] + shutter[1])


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


# What Blender's cameras cut off before clip start and behind clip end, and Reframe shows.

ACROSS = 9  # rays in each direction of the picture


def rays_of(scene, camera):
    """Origins and directions of rays all over the picture; a direction has length 1 along the view."""
    corners = camera.data.view_frame(scene=scene)
    right, top, left = corners[0], corners[0], corners[2]
    matrix = camera.matrix_world.normalized()
    for i in range(ACROSS):
        for k in range(ACROSS):
            x = left.x + (right.x - left.x) * (i + 0.5) / ACROSS
            y = left.y + (top.y - left.y) * (k + 0.5) / ACROSS
            if camera.data.type == "ORTHO":
                yield matrix @ mathutils.Vector((x, y, 0.0)), matrix.to_3x3() @ mathutils.Vector((0.0, 0.0, -1.0))
            else:
                yield matrix.translation, matrix.to_3x3() @ (mathutils.Vector((x, y, left.z)) / -left.z)


class Clipping:
    """Looks in some frames for surfaces that are cut off."""

    def __init__(self, scene):
        self.scene, self.near, self.far = scene, {}, {}

    def note(self, camera, depsgraph, number):
        if camera.data.type == "PANO":
            return
        start, end = camera.data.clip_start, camera.data.clip_end
        for origin, way in rays_of(self.scene, camera):
            hit, place, _, _, o, _ = self.scene.ray_cast(depsgraph, origin, way)
            if not hit:
                continue
            depth = (place - origin).dot(way) / way.length_squared
            if depth < start:
                self.near.setdefault((camera.name, o.name), number)
            elif depth > end:
                self.far.setdefault((camera.name, o.name), number)

    def tell(self):
        for (camera, name), number in sorted(self.near.items()):
            warn("'%s': nearer to '%s' than its clip start in frame %d: seen here, and may hide what is behind" % (name, camera, number))
        for (camera, name), number in sorted(self.far.items()):
            warn("'%s': farther from '%s' than its clip end in frame %d: seen here" % (name, camera, number))
