"""Blender as a Python module (`pip install bpy`), used like the program: a part of its command line, in its order.

    python as_program.py -b [--factory-startup] [--enable-autoexec | --disable-autoexec] [FILE.blend] [--python-exit-code N]
        [-E ENGINE] [--python-expr TEXT] [-P FILE.py] [-- WORDS]
    python as_program.py --version

A module starts from factory settings; there is no window, and no event loop.
"""
import os
import runpy
import sys
import traceback

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path = [folder for folder in sys.path if folder != HERE]  # whose cycles.py is not Blender's

import bpy  # noqa: E402


def run(words):
    """Does what the words say; returns the exit status."""
    status, autoexec = 0, False
    words = iter(words)
    for word in words:
        if word == "--":
            break
        if word in ("-b", "--background", "--factory-startup", "-noaudio"):
            continue
        if word in ("--enable-autoexec", "-y", "--disable-autoexec", "-Y"):
            autoexec = word in ("--enable-autoexec", "-y")
        elif word == "--version":
            print("Blender %s" % bpy.app.version_string)
        elif word in ("-E", "--engine"):
            bpy.context.scene.render.engine = next(words)
        elif word == "--python-exit-code":
            status = int(next(words))
        elif word in ("-P", "--python", "--python-expr"):
            if not succeeds(word, next(words)) and status != 0:
                return status
        elif word.startswith("-"):
            print("%s: not known to a Python with bpy" % word, file=sys.stderr)
            return 2
        else:
            try:
                bpy.ops.wm.open_mainfile(filepath=os.path.abspath(word), use_scripts=autoexec)
            except RuntimeError as error:
                print("Error: %s" % error, file=sys.stderr)
                return 1
    return 0


def succeeds(word, text):
    """Runs a script or a line of Python as Blender does."""
    try:
        if word == "--python-expr":
            exec(compile(text, "<python-expr>", "exec"), {"__name__": "__main__"})
        else:
            runpy.run_path(text, run_name="__main__")
    except SystemExit as end:  # which ends Blender, too
        raise end
    except BaseException:
        traceback.print_exc()
        return False
    return True


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
