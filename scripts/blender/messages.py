"""Warnings and errors. Warnings are printed at once and repeated at the end, where they are read."""
import argparse
import os
import re
import sys

_warnings = []


def printable(text):
    """One line: the names of a .blend may hold anything, also what a terminal obeys."""
    return "".join(c if c.isprintable() else "?" for c in text)


def warn(text):
    text = printable(text)
    _warnings.append(text)
    print("blender-export: warning: " + text, file=sys.stderr)


def note(text):
    print("blender-export: " + text)


def list_names(names):
    more = " and %d more" % (len(names) - 5) if len(names) > 5 else ""
    return ", ".join("'%s'" % n for n in names[:5]) + more


def warnings():
    return list(_warnings)


def repeat_warnings():
    """Prints all warnings again; called last, after Blender's own pages of output."""
    sys.stdout.flush()
    for text in _warnings:
        print("blender-export: warning: " + text, file=sys.stderr)
    sys.stderr.flush()


def fail(text):
    print("blender-export: " + printable(text), file=sys.stderr)
    sys.stderr.flush()
    os._exit(1)  # after an exception Blender would exit with status 0


# The command line: what stands after Blender's own options and --.


def default_bake_cache():
    return os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "reframe", "bake")


def bake_size(text):
    if not text.isdecimal() or not 16 <= int(text) <= 8192:
        raise argparse.ArgumentTypeError("must be 16 to 8192 pixels, got '%s'" % text)
    return int(text)


def parse(about):
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    p = argparse.ArgumentParser(prog="blender -b scene.blend -P export.py --", description=about)
    p.add_argument("out", help="the .glb to write")
    p.add_argument("--camera", help="the camera to bake; default: the scene's active one")
    p.add_argument("--frames", help="A-B or A-BxSTEP; default: the scene's own range and step")
    p.add_argument("--bake", type=bake_size, default=1024, metavar="SIZE",
                   help="pixels across of the largest textures that replace what glTF cannot express; default: 1024")
    p.add_argument("--no-bake", action="store_const", dest="bake", const=0,
                   help="bake nothing: what glTF cannot express becomes constant, with a warning")
    p.add_argument("--bake-cache", metavar="FOLDER", default=default_bake_cache(),
                   help="where bakes are kept for the next time; default: reframe/bake in $XDG_CACHE_HOME or ~/.cache")
    p.add_argument("--embed", action="store_true", help="put the map of the sky into the .glb, not into a file beside it")
    p.add_argument("--overwrite", action="store_true", help="replace files that are there already")
    try:
        args = p.parse_args(own)
    except SystemExit as e:
        os._exit(e.code if isinstance(e.code, int) else 2)
    if not args.out.endswith(".glb"):
        fail("%s: only .glb is written: name it .glb" % args.out)
    folder = os.path.dirname(os.path.abspath(args.out))
    if not os.path.isdir(folder):
        fail("%s: cannot be written: there is no folder %s" % (args.out, folder))
    refuse(args, args.out)
    return args


def refuse(args, path):
    if os.path.lexists(path) and not args.overwrite:
        fail("%s: is there already: give another name or --overwrite" % path)


def frame_range(scene, text):
    """The first frame, the last one, and the step between them."""
    if not text:
        return scene.frame_start, scene.frame_end, scene.frame_step
    match = re.fullmatch(r"(\d+)-(\d+)(?:x([1-9]\d*))?", text)
    if match is None:
        fail("--frames: must be A-B or A-BxSTEP, got '%s'" % text)
    first, last, step = (int(n) for n in match.groups("1"))
    if last < first:
        fail("--frames: %d comes after %d" % (first, last))
    return first, last, step
