"""The programs that the add-on runs: another Blender that exports, and `reframe render`. What they say is read while they run."""
import os
import queue
import re
import shlex
import shutil
import subprocess
import sys
import threading

import bpy
from bpy.props import BoolProperty, EnumProperty

ENGINE = "REFRAME"
HERE = os.path.dirname(os.path.realpath(__file__))
EXPORTER = os.path.join(HERE, "export.py")
SAID = re.compile(r"(blender-export|reframe render): ")
PASSES = re.compile(r"passes of '.*': (--.*)")
DONE = re.compile(r"frame \d+/\d+ .* (\d+) %|frame (\d+)/(\d+)")


class Failed(Exception):
    pass


class ExportSettings:
    """Those of the exporter's options that all have."""

    bake: EnumProperty(name="Bake", description="Pixels across of textures that replace what glTF cannot express", default="1024",
                       items=[("0", "Nothing", "What glTF cannot express becomes constant, with a warning")] +
                             [(n, n, "%s pixels across" % n) for n in ("256", "512", "1024", "2048", "4096", "8192")])
    accept_losses: BoolProperty(name="Accept Losses", default=False,
                                description="Export also if a movement is frozen, or the light of the whole picture is not Blender's")

    def export_options(self):
        return [*(["--bake", self.bake] if self.bake != "0" else ["--no-bake"]), *(["--accept-losses"] if self.accept_losses else [])]


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

    def stop(self, seconds=5):
        """Ends it; after so many seconds by force."""
        self.process.terminate()
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


class Heard:
    """What the programs of a render have said so far."""

    def __init__(self):
        self.lost, self.passes, self.last = [], [], ""  # losses and warnings; options that give the passes of the view layer; the last line

    def hear(self, line):
        """Returns the text, and the share that is done if it tells that."""
        text = SAID.sub("", line)
        if text.startswith(("loss: ", "warning: ")) and text not in self.lost:
            self.lost.append(text)
        passes, done = PASSES.fullmatch(text), DONE.match(text)
        if passes is not None:
            self.passes = shlex.split(passes[1])
        self.last = text or self.last
        if done is None:
            return text, None
        return text, int(done[1]) / 100.0 if done[1] is not None else int(done[2]) / int(done[3])

    def why(self, accept_losses):
        """Of a program that failed."""
        losses = [text for text in self.lost if text.startswith("loss: ")]
        if losses and not accept_losses:
            return "\n".join(losses + ["Nothing is exported for what would be lost: change it, or tick Accept Losses"])
        return self.last or "it was stopped"


def program_of(context, addon):
    given = context.preferences.addons[addon].preferences.program
    path = bpy.path.abspath(given) if given else shutil.which("reframe")
    if path is None or not os.path.isfile(path):
        raise Failed("%s: the program is not there: install Reframe, or give its path in the preferences of this add-on" %
                     (given or "reframe"))
    return path


def said_by(command):
    """The exit status of a program that ends at once, and its last line."""
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
                              errors="replace", timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None, ""
    return done.returncode, (done.stdout.strip().splitlines() or [""])[-1]


def check_options(program, options, folder):
    """Finds what is wrong with the program or its options before the export, which may take long: `render` looks at all options, and
    for the denoiser, before it opens the scene."""
    if re.match(r"reframe [\d.]+", said_by([program, "--version"])[1]) is None:
        raise Failed("%s: is not the program reframe: give its path in the preferences of this add-on" % program)
    scene, frames = os.path.join(folder, "no such scene.glb"), os.path.join(folder, "frame.####.exr")
    status, text = said_by([program, "render", scene, "-o", frames, "--overwrite", *options])
    if status is not None and scene not in text:
        raise Failed(SAID.sub("", text))


# The other Blender is without the add-on, so that a scene of its engine would be one of EEVEE there.
SET_UP = "; ".join(("import bpy", "scene = bpy.data.scenes[%r]", "bpy.context.window.scene = scene",
                    "bpy.context.window.view_layer = scene.view_layers[%r]", "scene.render.engine = %r"))


def export_words(file, scene, layer, out, options):
    """The command line that exports a view layer from a copy of the open file, by another Blender with factory settings and no window."""
    program = [bpy.app.binary_path] if bpy.app.binary_path else [sys.executable, "-B", os.path.join(HERE, "as_program.py")]
    scripts = "--enable-autoexec" if bpy.context.preferences.filepaths.use_scripts_auto_execute else "--disable-autoexec"
    engine = scene.render.engine if scene.render.engine != ENGINE else "CYCLES"
    return [*program, "-b", "--factory-startup", scripts, file, "--python-exit-code", "1", "--python-expr",
            SET_UP % (scene.name, layer, engine), "-P", EXPORTER, "--", out, *options]


def save_copy(folder):
    copy = os.path.join(folder, os.path.basename(bpy.data.filepath) or "unsaved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=copy, copy=True, check_existing=False)
    return copy
