"""Makes a scene of this folder and renders it with Cycles; for scripts/blender-parity.

  blender -b --factory-startup --python-exit-code 1 -P make.py -- JOB.json
"""
import json
import os
import sys

import bpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from blender.cycles import set_cycles, write_picture  # noqa: E402
from parity import moving, rooms, still  # noqa: E402,F401
from parity.words import Absent, SCENES, SIZE  # noqa: E402


def make(job):
    """The .blend of a scene; returns the frames that are compared, and the samples of a seed."""
    build, frames, samples = SCENES[job["scene"]]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 20 if len(frames) > 1 else 1
    set_cycles(scene, {"size": SIZE, "threads": job["threads"], "samples": samples, "bounces": 16})
    bpy.ops.wm.save_as_mainfile(filepath=job["blend"])  # so that files go beside it
    build()
    bpy.ops.wm.save_as_mainfile(filepath=job["blend"], compress=True)
    return frames, samples


def render(job, frames):
    scene = bpy.context.scene
    scene.render.image_settings.color_mode = "RGB"
    for seed in range(job["seeds"]):
        for frame in frames:
            write_picture(scene, job["pattern"] % (seed + 1, frame), frame, seed)


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    told = {"frames": [], "samples": 0}
    try:
        told["frames"], told["samples"] = make(job)
        render(job, told["frames"])
    except Absent as error:
        told["absent"] = str(error.__cause__ or error)
    with open(job["made"], "w", encoding="utf-8") as file:
        json.dump(told, file)


main()
