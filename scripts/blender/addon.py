"""The add-on: File > Export > Reframe (.glb), and Render > Render Animation with Reframe. `pack` makes a zip of it that Blender installs.

The exporter rewrites the scene that it exports, so another Blender runs it, on a copy of the open file, while this one shows its lines.
"""
import os
import queue
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

bl_info = {"name": "Reframe", "author": "Reframe's authors", "version": (0, 0, 0), "blender": (3, 4, 0), "category": "Render",
           "location": "File > Export > Reframe (.glb), Render > Render Animation with Reframe",
           "description": "Exports and renders animations with Reframe"}

EXPORTER = os.path.join(os.path.dirname(os.path.realpath(__file__)), "blender", "export.py")
SAID = re.compile(r"(blender-export|reframe render): ")
PASSES = re.compile(r"passes of '.*': (--.*)")
DONE = re.compile(r"frame \d+/\d+ .* (\d+) %|frame (\d+)/(\d+)")


class Failed(Exception):
    pass


def blender():
    """What starts another Blender: this program, or the Python that has it as a module."""
    return [bpy.app.binary_path] if bpy.app.binary_path else [sys.executable, "-B", os.path.join(os.path.dirname(EXPORTER), "as_program.py")]


class Process:
    """A program whose lines are read while it runs."""

    def __init__(self, command):
        self.lines = queue.Queue()
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                        encoding="utf-8", errors="replace")
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            self.lines.put(line.strip())
        self.lines.put(None)

    def next_line(self, wait):
        """None at the end; "" if there is none yet."""
        try:
            return self.lines.get(block=wait)
        except queue.Empty:
            return ""

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def move_to(source, target):
    """A file or a folder of files, if it is there; files of these names are replaced."""
    if os.path.isdir(source):
        os.makedirs(target, exist_ok=True)
        for name in os.listdir(source):
            move_to(os.path.join(source, name), os.path.join(target, name))
    elif os.path.exists(source):
        shutil.move(source, target)


class Work:
    """Of operators that run programs one after the other: `work` yields what they do and their command lines. In a window Blender goes on
    meanwhile."""

    def begin(self, context):
        self.folder = tempfile.mkdtemp(prefix="reframe-")
        self.steps, self.process, self.timer, self.lost, self.last = self.work(context), None, None, [], ""
        self.passes = []  # the options that give those of the view layer

    def end(self, context):
        self.steps.close()
        if self.process is not None:
            self.process.stop()
        if self.timer is not None:
            context.window_manager.event_timer_remove(self.timer)
            context.window_manager.progress_end()
            context.workspace.status_text_set(None)
        shutil.rmtree(self.folder, ignore_errors=True)

    def hear(self, context, line):
        text = SAID.sub("", line)
        if text.startswith(("loss: ", "warning: ")) and text not in self.lost:
            self.lost.append(text)
        passes = PASSES.fullmatch(text)
        if passes is not None:
            self.passes = shlex.split(passes[1])
        if text:
            self.last = text
        if self.timer is None or not text:
            return
        context.workspace.status_text_set("Reframe: %s (Esc cancels)" % self.last)
        done = DONE.match(text)
        if done is not None:
            share = int(done[1]) / 100.0 if done[1] is not None else int(done[2]) / int(done[3])
            context.window_manager.progress_update(100.0 * share)

    def why(self):
        """Of a program that failed."""
        losses = [text for text in self.lost if text.startswith("loss: ")]
        if losses and not self.accept_losses:
            return "\n".join(losses + ["Nothing is exported for what would be lost: change it, or tick Accept Losses"])
        return self.last or "it was stopped"

    def advance(self, context, wait):
        """Goes on as far as the programs are; returns None until all is done."""
        if self.process is None:
            label, command = next(self.steps)
            self.process = Process(command)
            self.hear(context, label)
        line = self.process.next_line(wait)
        while line:
            self.hear(context, line)
            line = self.process.next_line(wait)
        if line is None:
            if self.process.process.wait() != 0:
                raise Failed(self.why())
            self.process = None

    def go_on(self, context, wait):
        try:
            self.advance(context, wait)
            return None
        except StopIteration:
            state = {"FINISHED"}
            for text in sorted(self.lost):  # losses before warnings
                self.report({"WARNING"}, text[len("warning: "):] if text.startswith("warning: ") else text)
        except Exception as e:  # whatever it is, no folder and no program stays behind
            state = {"CANCELLED"}
            self.report({"ERROR"}, str(e) or type(e).__name__)
        self.end(context)
        return state

    def execute(self, context):
        self.begin(context)
        if bpy.app.background:
            state = None
            while state is None:
                state = self.go_on(context, True)
            return state
        return self.watch(context)

    def watch(self, context):
        """Goes on by a timer's events."""
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.progress_begin(0.0, 100.0)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, "Reframe: cancelled")
            return {"CANCELLED"}
        state = self.go_on(context, False) if event.type == "TIMER" else None
        return state or {"PASS_THROUGH"}

    def cancel(self, context):
        self.end(context)


class Exported:
    """The exporter's options, as properties."""

    frames: StringProperty(name="Frames", description="A-B or A-BxSTEP; empty: the scene's own range and step")
    bake: EnumProperty(name="Bake", description="Pixels across of textures that replace what glTF cannot express", default="1024",
                       items=[("0", "Nothing", "What glTF cannot express becomes constant, with a warning")] +
                             [(n, n, "%s pixels across" % n) for n in ("256", "512", "1024", "2048", "4096", "8192")])
    accept_losses: BoolProperty(name="Accept Losses", default=False,
                                description="Export also if a movement is frozen, or the light of the whole picture is not Blender's")

    def export_to(self, out, more=()):
        """Exports a copy of the open file; what an export that is stopped leaves vanishes with the copy."""
        name = os.path.basename(out)
        copy = os.path.join(self.folder, os.path.basename(bpy.data.filepath) or "unsaved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=copy, copy=True, check_existing=False)
        scripts = "--enable-autoexec" if bpy.context.preferences.filepaths.use_scripts_auto_execute else "--disable-autoexec"
        options = [*more, *(["--bake", self.bake] if self.bake != "0" else ["--no-bake"])]
        if self.frames:
            options += ["--frames", self.frames]
        if self.accept_losses:
            options.append("--accept-losses")
        made = os.path.join(self.folder, name)
        yield "exporting", [*blender(), "-b", "--factory-startup", scripts, copy, "-P", EXPORTER, "--", made, *options]
        base = name[:-len(".glb")]
        for file in (base + "-frames", base + "-sky.exr", name):  # the .glb last, which names the others
            move_to(os.path.join(self.folder, file), os.path.join(os.path.dirname(out), file))


class ExportReframe(bpy.types.Operator, Work, Exported, ExportHelper):
    """Export the scene and its animation for Reframe"""
    bl_idname, bl_label = "export_scene.reframe", "Export Reframe"
    bl_options = {"PRESET"}
    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})
    embed: BoolProperty(name="Embed the Sky", description="Put the map of the sky into the .glb, not into a file beside it", default=False)

    def work(self, context):
        out = bpy.path.abspath(self.filepath)
        yield from self.export_to(out, ["--embed"] if self.embed else [])
        self.report({"INFO"}, "Exported to %s" % out)


class RenderReframe(bpy.types.Operator, Work, Exported):
    """Export the animation, render it with Reframe, and open the frames"""
    bl_idname, bl_label = "render.reframe", "Render Animation with Reframe"
    directory: StringProperty(name="Folder", subtype="DIR_PATH", description="For scene.glb and the frames; empty: a new one",
                              options={"SKIP_SAVE"})
    arguments: StringProperty(name="Options", description="More options of reframe render, such as --noise 0.01 --size 960x540; "
                              "those that give the passes of the view layer are added")

    def invoke(self, context, event):
        self.directory = "//reframe" if bpy.data.filepath else ""
        return context.window_manager.invoke_props_dialog(self, width=400)

    def draw(self, context):
        for name in ("directory", "frames", "arguments", "bake", "accept_losses"):
            self.layout.prop(self, name)

    def work(self, context):
        program, options = program_of(context), shlex.split(self.arguments)
        check_options(program, options, self.folder)
        folder = bpy.path.abspath(self.directory) if self.directory else tempfile.mkdtemp(prefix="reframe-frames-")
        is_new = not self.directory or not os.path.isdir(folder)
        try:
            yield from self.render_to(folder, program, options)
        finally:
            if is_new and os.path.isdir(folder) and not frames_of(folder):
                shutil.rmtree(folder, ignore_errors=True)
        self.report({"INFO"}, "Rendered to %s" % folder)

    def render_to(self, folder, program, options):
        os.makedirs(folder, exist_ok=True)
        scene, frames = os.path.join(folder, "scene.glb"), os.path.join(folder, "frame.####.exr")
        yield from self.export_to(scene)
        started = os.stat(scene).st_mtime
        yield "rendering", [program, "render", scene, "-o", frames, "--overwrite", *self.passes, *options]
        open_frames({n: path for n, path in frames_of(folder).items() if os.stat(path).st_mtime >= started})


def frames_of(folder):
    """The files of frames, by their numbers."""
    return {int(name[6:-4]): os.path.join(folder, name) for name in os.listdir(folder) if re.fullmatch(r"frame\.\d+\.exr", name)}


def said_by(command):
    """The exit status of a program that ends at once, and its last line."""
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
                              errors="replace", timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None, ""
    return done.returncode, (done.stdout.strip().splitlines() or [""])[-1]


def check_options(program, options, folder):
    """Finds what is wrong with the program or its options before the export, which may take long: `render` looks at all options before
    it opens the scene."""
    if re.match(r"reframe [\d.]+", said_by([program, "--version"])[1]) is None:
        raise Failed("%s: is not the program reframe: give its path in the preferences of this add-on" % program)
    scene, frames = os.path.join(folder, "no such scene.glb"), os.path.join(folder, "frame.####.exr")
    status, text = said_by([program, "render", scene, "-o", frames, "--overwrite", *options])
    if status == 2:
        raise Failed(SAID.sub("", text))


def open_frames(paths):
    """As an image, and in a window where there are any."""
    if not paths:
        raise Failed("no frames were written")
    first, last = min(paths), max(paths)
    image = bpy.data.images.load(paths[first], check_existing=True)
    image.name, image.source = "Reframe", "SEQUENCE" if last > first else "FILE"
    image.reload()
    if bpy.app.background:
        return
    bpy.ops.wm.window_new()
    area = bpy.context.window_manager.windows[-1].screen.areas[0]
    area.type = "IMAGE_EDITOR"
    space = area.spaces.active
    space.image = image
    user = space.image_user
    user.frame_start, user.frame_offset, user.frame_duration, user.use_auto_refresh = first, first - 1, last - first + 1, True


def program_of(context):
    given = context.preferences.addons[__package__].preferences.program
    path = bpy.path.abspath(given) if given else shutil.which("reframe")
    if path is None or not os.path.isfile(path):
        raise Failed("%s: the program is not there: install Reframe, or give its path in the preferences of this add-on" %
                     (given or "reframe"))
    return path


class ReframePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH", description="The program reframe; empty: that of the PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


CLASSES = (ReframePreferences, ExportReframe, RenderReframe)


def add_export(menu, context):
    menu.layout.operator(ExportReframe.bl_idname, text="Reframe (.glb)")


def add_render(menu, context):
    menu.layout.operator_context = "INVOKE_DEFAULT"
    menu.layout.operator(RenderReframe.bl_idname, icon="RENDER_ANIMATION")


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_file_export.append(add_export)
    bpy.types.TOPBAR_MT_render.append(add_render)


def unregister():
    bpy.types.TOPBAR_MT_render.remove(add_render)
    bpy.types.TOPBAR_MT_file_export.remove(add_export)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
