"""The add-on: the render engine (engine.py), File > Export > Reframe (.glb), and Render > Render Animation with Reframe. `pack` makes a zip
of it that Blender installs.

The exporter rewrites the scene that it exports, so another Blender runs it, on a copy of the open file, while this one shows its lines.
"""
import os
import re
import shlex
import shutil
import tempfile

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .blender import engine
from .blender.programs import ExportSettings, Failed, Heard, Process, check_options, export_words, program_of, save_copy

bl_info = {"name": "Reframe", "author": "Reframe's authors", "version": (0, 0, 0), "blender": (3, 4, 0), "category": "Render",
           "location": "Render Engine, File > Export > Reframe (.glb), Render > Render Animation with Reframe",
           "description": "Exports and renders animations with Reframe"}


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
        self.steps, self.process, self.timer, self.heard = self.work(context), None, None, Heard()

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
        text, share = self.heard.hear(line)
        if self.timer is None or not text:
            return
        context.workspace.status_text_set("Reframe: %s (Esc cancels)" % text)
        if share is not None:
            context.window_manager.progress_update(100.0 * share)

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
                raise Failed(self.heard.why(self.accept_losses))
            self.process = None

    def go_on(self, context, wait):
        try:
            self.advance(context, wait)
            return None
        except StopIteration:
            state = {"FINISHED"}
            for text in sorted(self.heard.lost):  # losses before warnings
                self.report({"WARNING"}, text.removeprefix("warning: "))
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


class Exported(ExportSettings):
    """The exporter's options, as properties."""

    frames: StringProperty(name="Frames", description="A-B or A-BxSTEP; empty: the scene's own range and step")

    def export_to(self, out, more=()):
        """Exports a copy of the open file; what an export that is stopped leaves vanishes with the copy."""
        name = os.path.basename(out)
        copy = save_copy(self.folder)
        options = [*more, *self.export_options()]
        if self.frames:
            options += ["--frames", self.frames]
        made = os.path.join(self.folder, name)
        yield "exporting", export_words(copy, bpy.context.scene, bpy.context.view_layer.name, made, options)
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
        program, options = program_of(context, __package__), shlex.split(self.arguments)
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
        yield "rendering", [program, "render", scene, "-o", frames, "--overwrite", *self.heard.passes, *options]
        open_frames({n: path for n, path in frames_of(folder).items() if os.stat(path).st_mtime >= started})


def frames_of(folder):
    """The files of frames, by their numbers."""
    return {int(name[6:-4]): os.path.join(folder, name) for name in os.listdir(folder) if re.fullmatch(r"frame\.\d+\.exr", name)}


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
    engine.register()
    bpy.types.TOPBAR_MT_file_export.append(add_export)
    bpy.types.TOPBAR_MT_render.append(add_render)


def unregister():
    bpy.types.TOPBAR_MT_render.remove(add_render)
    bpy.types.TOPBAR_MT_file_export.remove(add_export)
    engine.unregister()
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
