"""Exports a .blend as .glb for Reframe, in background mode:

    blender -b scene.blend -P scripts/blender/export.py -- out.glb [--camera NAME] [--frames A-B[xSTEP]]
        [--bake SIZE | --no-bake] [--bake-cache FOLDER] [--embed] [--accept-losses]
        [--overwrite]

Uses Blender's own glTF exporter and adds what it leaves out. The camera is baked
frame by frame, whatever animates it (parents, constraints, drivers), and so is all that
moves, appears or disappears. Area lights
become one-sided emissive quads or discs, as bright as in Cycles. Point, spot and sun lamps
are written in W/sr and W/m2 (the exporter's "unitless" mode), as Reframe expects
them. A world of constant colour becomes the environment in the scene's custom
property `reframe`; any other world (a rotated environment texture, a sky, any nodes)
is rendered by Cycles to a map, out-sky.exr beside out.glb, to which that property
refers; --embed puts it into the .glb. Materials that have an equivalent in glTF are
carried; what varies otherwise (procedural textures, mixes of shaders by a texture) is
baked by Cycles into textures of SIZE pixels. Custom properties are kept. What cannot be
exported is named at the end, with object and node. If that freezes a movement, or changes
the light of the whole picture, nothing is written; --accept-losses makes warnings of such
errors. The warnings stand in the .glb for `reframe info`. The .blend is never changed.
"""
import fractions
import os
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the installed or checked-out script
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

import bpy  # noqa: E402
from blender.messages import fail, frame_range, hush, note, note_frame, parse, refuse_losses, tell_all, warn  # noqa: E402

try:
    import numpy  # noqa: F401
except ImportError:  # Debian's Blender 4 comes without it
    fail("this Blender's Python has no numpy, which its glTF exporter needs: install it (Debian: python3-numpy)")
from blender import cameras, films, geometry, glb, lamp_keys, lights, materials, movement, moves, passes, pilot, sky, tracks, values  # noqa: E402
from blender.versions import TRIED  # noqa: E402


def watch(scene, camera, follow, numbers):
    """Goes through the frames; returns the recorders of the camera, of values and of what is rendered. Ends in the first."""
    frames = moves.Frames(scene)
    frames.go(numbers[0])
    recorder = cameras.Recorder(scene, camera, follow)
    world = movement.Recorder(numbers, geometry.Seen(geometry.held_out(bpy.context.view_layer)))
    clipped, in_view = cameras.Clipping(scene), lights.InView(scene, bpy.context.evaluated_depsgraph_get())
    recorded = values.Recorder(scene)
    few = {numbers[0], numbers[len(numbers) // 2], numbers[-1]}  # casting rays takes time
    for number in numbers:
        frames.go(number)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        recorder.note(number, depsgraph)
        world.note(number, depsgraph)
        in_view.note(recorder.camera_now, depsgraph)
        recorded.note(number)
        if number in few:
            clipped.note(recorder.camera_now, depsgraph, number)
        note_frame(numbers.index(number) + 1, len(numbers))
    clipped.tell()
    world.finish()
    frames.set(numbers[0])
    recorded.finish()
    return recorder, recorded, world, in_view.places


def rate_of(scene):
    fps = fractions.Fraction(scene.render.fps) / fractions.Fraction(scene.render.fps_base).limit_denominator(10000)
    return [fps.numerator, fps.denominator]


def main():
    args = parse(__doc__.split("\n")[0])
    hush()
    scene = bpy.context.scene
    scene.pop("reframe_render", None)  # the settings of the render engine are no part of the scene
    first, last, step = frame_range(scene, args.frames)
    if bpy.app.version[:2] > TRIED:
        warn("Blender %d.%d is newer than those that this exporter was tried with, up to %d.%d" % (*bpy.app.version[:2], *TRIED))
    cameras.begin(args)
    films.begin(args, range(first, last + 1, step), rate_of(scene))
    camera = cameras.find_camera(scene, args.camera)
    name = camera.name
    scene.frame_set(first)
    sky.refuse_early(scene, args)
    cameras.warn_of_effects(scene, camera)
    pilot.tell_limits(scene, camera)
    geometry.settle(scene)
    passes.begin(scene)
    recorder, recorded, world, in_view = watch(scene, camera, args.camera is None, range(first, last + 1, step))
    scene.frame_start, scene.frame_end = first, last  # only now: simulations begin where the scene does
    cameras.tell_others(scene, name)
    if first == last and cameras.shutter_of(scene) is not None:
        warn("a frame alone has no motion blur: export those before and after it, too, and render it by --frames")
    if first < 1:
        warn("glTF has no time before frame 1: frame %d is called 1, and so on" % first)
    film = {"size": list(cameras.film_of(scene)), "fps": rate_of(scene)}
    if scene.render.film_transparent:
        film["alpha"] = True
    if scene.render.engine == "CYCLES":
        film["max_depth"] = scene.cycles.max_bounces + 2  # vertices: the first surface and the light count as well
    shot = {"render": film, "view": cameras.view_of(scene), "camera": name, "path": recorder.path(step)}
    moved = tracks.Tracks(range(first, last + 1, step), rate_of(scene), cameras.middle_of_shutter(scene))
    targets = materials.coordinate_objects()
    placed = geometry.realise(scene, world, moved)
    materials.restore_coordinate_objects(targets)
    cameras.bake_camera(scene, name, recorder)
    materials.carry(scene, args, placed, recorder, recorded, moved)
    changing = lamp_keys.begin(scene, recorded)
    lights.carry(scene, in_view, placed, moved)
    lamp_keys.finish(scene, changing, moved, materials.patches)
    sky.keep_world(scene, args, recorded, moved)
    world.deforming.prepare()
    written = glb.export(args.out)
    glb.finish(written, shot, placed, moved, world.deforming)
    passes.tell(scene)
    refuse_losses(args)
    glb.put_in_place(args, written)
    note("%s: frames %d to %d" % (args.out, first, last))
    tell_all()


try:
    main()
except Exception as e:  # report any exception of Blender as one line and an exit status
    lines = [line.strip() for line in str(e).splitlines() if line.strip() and not line.startswith("Location:")]
    fail("%s: %s" % (type(e).__name__, lines[-1] if lines else "no details"))
