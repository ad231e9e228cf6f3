"""Losses, warnings and errors: told together at the end, once, losses first. Blender's own output is hushed."""
import argparse
import os
import re
import shutil
import signal
import sys
import tempfile

import bpy

_losses, _warnings, _folders = [], [], []
_hushed = None  # the file that takes what Blender prints
_out, _err = sys.stdout, sys.stderr


def hush():
    """From now on only what is said here is seen: Blender, its exporter and Cycles print to a file that is deleted."""
    global _hushed, _out, _err
    sys.stdout.flush()
    sys.stderr.flush()
    _out, _err = (open(os.dup(n), "w", encoding="utf-8", errors="replace", buffering=1) for n in (1, 2))
    signal.signal(signal.SIGTERM, lambda number, frame: fail("stopped"))  # which leaves nothing
    _hushed = tempfile.TemporaryFile()
    for n in (1, 2):
        os.dup2(_hushed.fileno(), n)


def blenders_error():
    """What Blender said last that looks like an error, for messages."""
    sys.stdout.flush()
    _hushed.seek(max(os.fstat(_hushed.fileno()).st_size - 65536, 0))
    lines = [line.strip() for line in _hushed.read().decode("utf-8", "replace").splitlines() if "rror" in line]
    return lines[-1] if lines else "Blender does not say why"


def printable(text):
    """One line: the names of a .blend may hold anything, also what a terminal obeys."""
    return "".join(c if c.isprintable() else "?" for c in text)


def add(texts, text):
    text = printable(text)
    if text not in texts:
        texts.append(text)


def lose(text):
    """For what would freeze a movement or change the light of the whole picture: an error, unless --accept-losses is given."""
    add(_losses, text)


def warn(text):
    """For smaller losses."""
    add(_warnings, text)


def note(text):
    print("blender-export: " + printable(text), file=_out, flush=True)


def note_frame(count, every):
    """The frames that were gone through, of all: ten times, where it takes long."""
    if every >= 100 and count * 10 // every > (count - 1) * 10 // every:
        note("frame %d/%d" % (count, every))


def list_names(names):
    """All of them: what is lost is named in full."""
    return ", ".join("'%s'" % n for n in names)


def list_some(names):
    return list_names(names[:5]) + (" and %d more" % (len(names) - 5) if len(names) > 5 else "")


def losses():
    return list(_losses)


def warnings():
    return list(_warnings)


def tell(kind, texts):
    for text in texts:
        print("blender-export: %s: %s" % (kind, text), file=_err)


def refuse_losses(args):
    """Ends the export if something is lost that should not be; called when everything is known, before files are put into place."""
    if _losses and not args.accept_losses:
        tell("loss", _losses)
        fail("nothing is written for what would be lost: change it in Blender, or export without it by --accept-losses")


def tell_all():
    """Called last."""
    tell("loss", _losses)
    tell("warning", _warnings)
    _err.flush()


def folder_beside(path):
    """A folder for files that are moved to where `path` is when they are whole, and vanish if the export fails."""
    _folders.append(tempfile.mkdtemp(prefix=".reframe-", dir=os.path.dirname(os.path.abspath(path))))
    return _folders[-1]


def remove_folders():
    while _folders:
        shutil.rmtree(_folders.pop(), ignore_errors=True)


def fail(text):
    remove_folders()
    print("blender-export: " + printable(text), file=_err)
    _err.flush()
    leave(1)


def leave(status):
    """Ends Blender: after an exception it would exit with status 0. Its folder of temporary files, which it would have removed, goes."""
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    os._exit(status)


# The command line: what stands after Blender's own options and --.


def default_bake_cache():
    return os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "reframe", "bake")


def bake_size(text):
    if not text.isdecimal() or not 16 <= int(text) <= 8192:
        raise argparse.ArgumentTypeError("must be 16 to 8192 pixels, got '%s'" % text)
    return int(text)


def region(text):
    left, bottom, right, top = (int(n) for n in text.split(","))
    if not 0 <= left < right or not 0 <= bottom < top:
        raise argparse.ArgumentTypeError("must be X0,Y0,X1,Y1, got '%s'" % text)
    return left, bottom, right, top


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
    p.add_argument("--accept-losses", action="store_true",
                   help="export also if a movement is frozen, or the light of the whole picture is not Blender's: a warning, not an error")
    p.add_argument("--engine", type=region, metavar="X0,Y0,X1,Y1",
                   help="for the add-on's render engine: only these pixels of the picture, counted from below, and no warnings of what "
                   "Blender does to finished pictures")
    p.add_argument("--overwrite", action="store_true", help="replace files that are there already")
    try:
        args = p.parse_args(own)
    except SystemExit as e:
        sys.stdout.flush()
        sys.stderr.flush()
        leave(e.code if isinstance(e.code, int) else 2)
    if not args.out.endswith(".glb"):
        fail("%s: only .glb is written: name it .glb" % args.out)
    folder = os.path.dirname(os.path.abspath(args.out))
    if not os.path.isdir(folder):
        fail("%s: cannot be written: there is no folder %s" % (args.out, folder))
    refuse(args, args.out)
    if not os.access(folder, os.W_OK | os.X_OK):
        fail("%s: cannot be written: there is no permission to write in %s" % (args.out, folder))
    return args


def refuse(args, path):
    if os.path.lexists(path) and not args.overwrite:
        fail("%s: already exists: give another name or --overwrite" % path)


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
