"""Exports a .blend as .glb for Reframe, in background mode:

    blender -b scene.blend -P scripts/blender/export.py -- out.glb [--camera NAME] [--frames A-B[xSTEP]]
        [--bake SIZE | --no-bake] [--bake-cache FOLDER] [--embed] [--overwrite]

Uses Blender's own glTF exporter and adds what it leaves out. The camera is baked
frame by frame, whatever animates it (parents, constraints, drivers). Area lights
become one-sided emissive quads or discs, as bright as in Cycles. Point, spot and sun lamps
are written in W/sr and W/m2 (the exporter's "unitless" mode), as Reframe expects
them. A world of constant colour becomes the environment in the scene's custom
property `reframe`; any other world (a rotated environment texture, a sky, any nodes)
is rendered by Cycles to a map, out-sky.exr beside out.glb, to which that property
refers; --embed puts it into the .glb. Materials that have an equivalent in glTF are
carried; what varies otherwise (procedural textures, mixes of shaders by a texture) is
baked by Cycles into textures of SIZE pixels. Custom properties are kept. Anything that
cannot be exported gives a warning, with object and node; all warnings are repeated at
the end, and stand in the .glb for `reframe info`. The .blend is never changed.
"""
import fractions
import os
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the installed or checked-out script
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

import bpy  # noqa: E402
from blender.messages import fail, frame_range, parse, repeat_warnings, warn  # noqa: E402

try:
    import numpy  # noqa: F401
except ImportError:  # Debian's Blender 4 comes without it
    fail("this Blender's Python has no numpy, which its glTF exporter needs: install it (Debian: python3-numpy)")
from blender import cameras, geometry, glb, lights, materials, moves, sky  # noqa: E402


def watch(scene, camera, follow, numbers):
    """Goes through the frames; returns the camera's recorder and the names of what else moves. Ends in the first."""
    frames = moves.Frames(scene)
    frames.set(numbers[0])
    recorder, watcher = cameras.Recorder(scene, camera, follow), moves.Watcher(scene, bpy.context.view_layer)
    clipped, in_view = cameras.Clipping(scene), lights.InView(scene, bpy.context.evaluated_depsgraph_get())
    few = {numbers[0], numbers[len(numbers) // 2], numbers[-1]}  # counting instances takes time
    for number in numbers:
        frames.set(number)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        recorder.note(number, depsgraph)
        watcher.note(depsgraph, number in few)
        in_view.note(recorder.camera_now)
        if number in few:
            clipped.note(recorder.camera_now, depsgraph, number)
    clipped.tell()
    in_view.tell()
    frames.set(numbers[0])
    return recorder, watcher.finish(bpy.context.evaluated_depsgraph_get()), in_view.places


def rate_of(scene):
    fps = fractions.Fraction(scene.render.fps) / fractions.Fraction(scene.render.fps_base).limit_denominator(10000)
    return [fps.numerator, fps.denominator]


def main():
    args = parse(__doc__.split("\n")[0])
    scene = bpy.context.scene
    first, last, step = frame_range(scene, args.frames)
    scene.frame_start, scene.frame_end = first, last
    camera = cameras.find_camera(scene, args.camera)
    name = camera.name
    scene.frame_set(first)
    sky.refuse_early(scene, args)
    cameras.warn_of_effects(scene, camera)
    geometry.settle(scene)
    recorder, moving, in_view = watch(scene, camera, args.camera is None, range(first, last + 1, step))
    cameras.tell_others(scene, name)
    if first < 0:
        warn("frame numbers start at 0 in Reframe: frame %d is called 0, and so on" % first)
    shot = {"render": {"size": list(cameras.film_of(scene)), "fps": rate_of(scene)}, "moving": moving, "camera": name,
            "path": recorder.path(step)}
    targets = materials.coordinate_objects()
    placed = geometry.realise(scene)
    materials.restore_coordinate_objects(targets)
    cameras.bake_camera(scene, name, recorder)
    materials.carry(scene, args, placed, recorder)
    lights.carry(scene, in_view, placed)
    sky.keep_world(scene, args)
    glb.export(os.path.abspath(args.out))
    if not os.path.exists(args.out):
        fail("%s: was not written: see Blender's messages above" % args.out)
    glb.finish(args.out, shot, placed)
    print("blender-export: %s: frames %d to %d" % (args.out, first, last))
    repeat_warnings()


try:
    main()
except Exception as e:  # report any exception of Blender as one line and an exit status
    lines = [line.strip() for line in str(e).splitlines() if line.strip() and not line.startswith("Location:")]
    fail("%s: %s" % (type(e).__name__, lines[-1] if lines else "no details"))
