"""Makes scenes of tests inside Blender, and Cycles' pictures of them:

    blender -b --factory-startup --python-exit-code 9 -P blender_make.py -- MODULE [--samples N] [SCENE ...]

writes SCENE.blend for these functions of blender_MODULE.py and, with --samples, SCENE-FRAME.exr of the frames that they return, by
default the first. A module with a main() gets all the words behind its name.
"""
import argparse
import importlib
import os
import sys

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.realpath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "scripts")]
import blender_words  # noqa: E402


def main():
    name, *words = sys.argv[sys.argv.index("--") + 1:]
    module = importlib.import_module("blender_" + name)
    if hasattr(module, "main"):
        module.main(*words)
        return
    p = argparse.ArgumentParser()
    p.add_argument("--samples", type=int, default=0)
    p.add_argument("scenes", nargs="+")
    args = p.parse_args(words)
    for scene in args.scenes:
        getattr(module, "set_up", lambda: None)()
        frames = getattr(module, scene)()
        blender_words.save(scene)
        for frame in (frames or (1,)) if args.samples else ():
            blender_words.write_by_cycles("%s-%d.exr" % (scene, frame), args.samples, frame)


main()
