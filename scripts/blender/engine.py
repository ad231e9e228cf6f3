"""The render engine. Blender asks it for one frame at a time; of an animation it exports once, runs one `reframe render` for all frames,
which share paths, and gives each to Blender when it is finished.
"""
import atexit
import json
import os
import re
import shlex
import shutil
import sys
import tempfile
import threading
import time

import bpy
import numpy
from bpy.app.handlers import persistent

from . import engine_panels, exr
from .passes import PASS_NAMES
from .programs import ENGINE, Failed, Heard, Process, check_options, export_words, program_of, save_copy

FINISHED = re.compile(r"frame \d+/\d+  number (-?\d+) ")
KNOWN = re.compile(r"(Combined.*|Depth|Normal|Vector|Emit|Emission|IndexOB|IndexMA|(Object|Material) Index|"
                   r"Crypto(Object|Material|Asset)\d\d|Denoising (Normal|Albedo))")

_run = None  # of the animation that Blender renders


class Stopped(Exception):
    """By Esc."""


def pass_name(name):
    """As our files have it."""
    return name.replace(",", ";").replace(".", "_")


def passes_of(scene, layer):
    """Names, channels and types of the passes that are switched on and rendered here, as Cycles calls them in this Blender."""
    try:
        from cycles.engine import list_render_passes
    except ImportError:
        return [("Combined", "RGBA", "COLOR")]
    return [p for p in list_render_passes(scene, layer) if KNOWN.fullmatch(pass_name(p[0]))]


def picture_of(scene):
    """Its width and height."""
    return [max(int(n * scene.render.resolution_percentage / 100.0), 1) for n in (scene.render.resolution_x, scene.render.resolution_y)]


def region_of(scene):
    """The pixels that are rendered: left, bottom, right, top, rounded as Blender does."""
    render, (width, height) = scene.render, picture_of(scene)
    if not render.use_border:
        return 0, 0, width, height
    return tuple(int(numpy.float32(share) * numpy.float32(size)) for share, size in (
        (render.border_min_x, width), (render.border_min_y, height), (render.border_max_x, width), (render.border_max_y, height)))


def in_main_thread(engine, call):
    """Renders in a window have a thread of their own, in which nothing may be saved. The main thread may wait for this one, to quit."""
    if threading.get_ident() == threading.main_thread().ident:
        return call()
    done, made, is_wanted = threading.Event(), [], [True]

    def run():
        try:
            made.append(call() if is_wanted[0] else None)
        except Exception as e:  # for the thread that waits
            made.append(e)
        done.set()

    bpy.app.timers.register(run)
    while not done.wait(0.05):
        if engine.test_break():
            is_wanted[0] = False
            raise Stopped
    if isinstance(made[0], Exception):
        raise Failed(str(made[0]))
    return made[0]


def frames_of(scene):
    """The frames of the animation from this one on that Blender will ask for."""
    render = scene.render
    every = range(scene.frame_start, scene.frame_end + 1, scene.frame_step)
    frames = [n for n in every if n >= scene.frame_current]
    if not render.use_overwrite and not render.is_movie_format:
        frames = [n for n in frames if not os.path.exists(bpy.path.abspath(render.frame_path(frame=n)))]
    return frames if scene.frame_current in frames else [scene.frame_current]


def list_of(frames):
    """As --frames has them."""
    first, last, step = frames[0], frames[-1], (frames[1:] or [frames[0] + 1])[0] - frames[0]
    if len(frames) > 1 and frames == list(range(first, last + 1, step)):
        return "%d-%dx%d" % (first, last, step)
    return ",".join(map(str, frames))


def is_one_of_several(engine):
    """An animation, not a frame by itself, which Blender's option -f renders as an animation of one."""
    words = sys.argv[:sys.argv.index("--")] if "--" in sys.argv else sys.argv
    return engine.is_animation and not (bpy.app.background and {"-f", "--render-frame"} & set(words))


class Run:
    """An export, the `reframe render` of some of its frames, and what is known of them."""

    def __init__(self, engine, scene, layer):
        self.scene, self.settings, self.region, self.layer = scene.name, scene.reframe_render, region_of(scene), layer
        self.exported = self.region if scene.camera is None or scene.camera.data.type != "PANO" else (0, 0, *picture_of(scene))
        self.threads = ["--threads", str(scene.render.threads)] if scene.render.threads_mode == "FIXED" else []
        self.process, self.heard, self.finished = None, Heard(), set()
        self.temporary = tempfile.mkdtemp(prefix="reframe-")
        if is_one_of_several(engine):
            self.frames, self.folder = frames_of(scene), self.folder_of_animation()
            first, last, step = scene.frame_start, scene.frame_end, scene.frame_step
        else:
            self.frames, self.folder = [scene.frame_current], self.temporary
            beside = 1 if scene.render.use_motion_blur else 0  # what moves is known from the frames around
            first, last, step = scene.frame_current - beside, scene.frame_current + beside, 1
        if not first <= self.frames[0] <= self.frames[-1] <= last:
            first, last = min(first, self.frames[0]), max(last, self.frames[-1])
        self.range = "%d-%dx%d" % (first, last, step)
        self.offset = max(1 - first, 0)  # between numbers of frames: ours begin at 1
        name = bpy.path.clean_name(scene.name)
        self.glb, self.pattern = (os.path.join(self.folder, name + end) for end in (".glb", ".####.exr"))

    def folder_of_animation(self):
        """Where frames stay, so that a render which was stopped goes on."""
        given = self.settings.folder
        if given.startswith("//") and not bpy.data.filepath:
            given = os.path.join(bpy.app.tempdir, given[2:])
        return os.path.abspath(bpy.path.abspath(given))

    def file_of(self, number):
        return self.pattern.replace("####", "%04d" % (number + self.offset))

    def start(self, engine, program):
        alone = len(self.frames) == 1 and self.folder == self.temporary
        settings = [*(["--group", "0"] if alone else self.settings.group_options()), *self.threads, *self.settings.render_options(),
                    "--names", PASS_NAMES, "--float", "--compression", "zip", "--resume", "--overwrite"]
        check_options(program, settings, self.temporary)
        os.makedirs(self.folder, exist_ok=True)
        options = ["--engine", ",".join(map(str, self.exported)), "--frames", self.range, "--overwrite", *self.settings.export_options()]
        copy = in_main_thread(engine, lambda: save_copy(self.temporary))
        self.run(engine, "exporting", export_words(copy, bpy.data.scenes[self.scene], self.layer, self.glb, options))
        for text in sorted(self.heard.lost):  # losses before warnings
            engine.report({"WARNING"}, text.removeprefix("warning: "))
        command = [program, "render", self.glb, "-o", self.pattern, "--frames", list_of([n + self.offset for n in self.frames]),
                   *self.heard.passes, *settings]
        self.find_finished(engine, command)
        engine.report({"INFO"}, shlex.join(command))
        if len(self.finished) < len(self.frames):
            self.process, self.heard.last = Process(command), "rendering"

    def run(self, engine, label, command, is_checked=True):
        """Runs a program to its end."""
        engine.update_stats("", "Reframe: " + label)
        self.process = Process(command)
        self.listen(engine, lambda: False, is_checked)

    def find_finished(self, engine, command):
        """Which frames are there from an earlier start, and are of the same render."""
        if not any(os.path.exists(self.file_of(n)) for n in self.frames):
            return
        path = os.path.join(self.temporary, "check.json")
        self.run(engine, "looking for finished frames", [*command, "--check", "--json", path], is_checked=False)
        if not os.path.exists(path):
            raise Failed(self.heard.last)
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        left = {n for kind in ("missing", "other", "unreadable", "damaged") for n in found[kind]}
        self.finished = {n for n in self.frames if n + self.offset not in left}

    def listen(self, engine, is_enough, is_checked=True):
        """Hears what the program says, until it is enough or the program ends."""
        while not is_enough():
            if engine.test_break():
                raise Stopped
            line = self.process.next_line(False)
            if line is None:
                status, self.process = self.process.process.wait(), None
                if is_checked and status != 0:
                    raise Failed(self.heard.why(self.settings.accept_losses))
                return
            if line:
                self.hear(engine, line)
            else:
                time.sleep(0.02)

    def hear(self, engine, line):
        text, share = self.heard.hear(line)
        finished = FINISHED.match(text)
        if finished is not None:
            self.finished.add(int(finished[1]) - self.offset)
        if text != line or share is not None or finished is not None:  # not what Blender says
            engine.update_stats("", "Reframe: " + text)
        if share is not None:
            engine.update_progress(share)

    def wait_for(self, engine, number):
        """The file of a frame."""
        engine.update_stats("", "Reframe: " + self.heard.last)
        if self.process is not None:
            self.listen(engine, lambda: number in self.finished)
        if number not in self.finished:
            raise Failed("frame %d was not rendered: %s" % (number, self.heard.last))
        return self.file_of(number)

    def end(self):
        if self.process is not None:
            self.process.stop(30)  # it saves what it has of the frames in work
        self.process = None
        shutil.rmtree(self.temporary, ignore_errors=True)


@persistent
def end_run(*args):
    """Also called when Blender has rendered all, or stops."""
    global _run
    if _run is not None:
        _run.end()
    _run = None


def run_of(engine, scene, layer):
    """That which renders the present frame."""
    global _run
    number = scene.frame_current
    if _run is None or _run.scene != scene.name or number not in _run.frames:
        end_run()
        program = program_of(bpy.context, __package__.rpartition(".")[0])
        _run = Run(engine, scene, layer)
        _run.start(engine, program)
    return _run


class ReframeRender(bpy.types.RenderEngine):
    """Renders by `reframe render`"""
    bl_idname, bl_label = ENGINE, "Reframe"
    bl_use_eevee_viewport = True  # in Material Preview
    bl_use_shading_nodes_custom = False  # Cycles' nodes
    bl_use_preview = False

    def update_render_passes(self, scene=None, renderlayer=None):
        for name, channels, kind in passes_of(scene, renderlayer):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        scene, layer = depsgraph.scene, depsgraph.view_layer.name
        used = [one.name for one in scene.view_layers if one.use]
        if not scene.render.use_single_layer and layer != used[0]:
            return  # one view layer is rendered; the exporter names the others
        try:
            run = run_of(self, scene, layer)
            self.give(scene, layer, run, run.wait_for(self, scene.frame_current))
            if not is_one_of_several(self) or scene.frame_current == run.frames[-1]:
                end_run()
        except Stopped:
            end_run()
        except (Failed, OSError, RuntimeError, ValueError) as e:
            end_run()
            self.report({"ERROR"}, str(e))  # which also ends an animation

    def give(self, scene, layer, run, path):
        """Hands a frame over."""
        pictures, manifest = pictures_of(path)
        left, bottom, right, top = run.region
        width, height, wide, high = right - left, top - bottom, run.exported[2] - run.exported[0], run.exported[3] - run.exported[1]
        x, y = left - run.exported[0], bottom - run.exported[1]
        exposure = scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0
        for name, channels, _ in passes_of(scene, scene.view_layers[layer]):
            if name != "Combined":
                self.add_pass(name, len(channels), channels, layer=layer)
        result = self.begin_result(0, 0, width, height, layer=layer)
        if (result.resolution_x, result.resolution_y) != (width, height):
            self.end_result(result, cancel=True)
            raise Failed("Blender asks for %dx%d pixels, not for %dx%d" % (result.resolution_x, result.resolution_y, width, height))
        for one in result.layers[0].passes:
            planes = pictures.get(pass_name(one.name))
            if planes is None:
                continue
            shape = next(iter(planes.values())).shape
            if shape != (high, wide):
                self.end_result(result, cancel=True)
                raise Failed("frames are %dx%d, not %dx%d as Blender's: take --size out of the options" % (*shape[::-1], wide, high))
            values = numpy.ones((height, width, one.channels), numpy.float32)  # of alpha where there is none
            for i, letter in enumerate(one.channel_id):
                if letter in planes:
                    values[:, :, i] = planes[letter][::-1][y:y + height, x:x + width]
            if one.name.startswith("Combined") or one.name in ("Emit", "Emission"):
                values[:, :, :3] *= exposure
            fill(one.rect, values)
        for field, value in manifest.items():
            self.get_result().stamp_data_add_field(field, layer + value[len("ViewLayer"):] if field.endswith("/name") else value)
        self.end_result(result)


def fill(rect, values):
    """Old versions of Blender count pixels, new ones their channels as well."""
    try:
        rect.foreach_set(values.ravel())
    except TypeError:
        rect.foreach_set(values.reshape(-1, values.shape[-1]))


def pictures_of(path):
    """By pass and channel, and what tells names from the numbers of Cryptomatte."""
    channels, header = exr.read(path)
    found = {}
    for full, values in channels.items():
        name, letter = full.split(".", 1)[1].rsplit(".", 1)
        found.setdefault(name, {})[letter] = values
    return found, {key: value.decode("utf-8") for key, value in header.items() if key.startswith("cryptomatte/")}


HANDLERS = (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel, bpy.app.handlers.load_pre)


def register():
    bpy.utils.register_class(ReframeRender)
    engine_panels.register()
    for handlers in HANDLERS:
        handlers.append(end_run)
    atexit.register(end_run)


def unregister():
    end_run()
    atexit.unregister(end_run)
    for handlers in HANDLERS:
        handlers.remove(end_run)
    engine_panels.unregister()
    bpy.utils.unregister_class(ReframeRender)
