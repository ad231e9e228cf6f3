"""For test_blender_engine.c: renders by the engine as F12 and Ctrl-F12 do.

    blender -b --factory-startup -P blender_engine.py -- ZIP PROGRAM
"""
import os
import re
import sys
import types
import zipfile

import bpy
import numpy

ZIP, PROGRAM = (os.path.abspath(name) for name in sys.argv[sys.argv.index("--") + 1:])
zipfile.ZipFile(ZIP).extractall("addons")
sys.path.insert(0, os.path.abspath("addons"))
bpy.ops.preferences.addon_enable(module="reframe")
from reframe.blender import engine, exr  # noqa: E402
from reframe.blender.versions import panorama_of  # noqa: E402

LAYER = "Main layer"
FRAMES = (5, 7, 9)


def make_scene():
    """A lit cube before a moving camera, and two view layers, of which the second is rendered."""
    scene, layer = bpy.context.scene, bpy.context.scene.view_layers[0]
    layer.name, layer.use = "Unused", False
    layer = scene.view_layers.new(LAYER)
    scene.frame_start, scene.frame_end, scene.frame_step = FRAMES[0], FRAMES[-1], 2
    render, settings = scene.render, scene.reframe_render
    render.engine, render.resolution_x, render.resolution_y, render.resolution_percentage = "REFRAME", 80, 50, 80
    camera = scene.camera
    for frame, x in ((FRAMES[0], 7.0), (FRAMES[-1], 8.0)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
    for name in ("z", "normal", "vector", "emit", "object_index", "cryptomatte_object"):
        setattr(layer, "use_pass_" + name, True)
    layer.cycles.denoising_store_passes, bpy.data.objects["Cube"].pass_index = True, 3
    settings.samples, settings.is_group_auto, settings.group = 8, False, 1
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    if hasattr(render.image_settings, "use_exr_interleave"):
        render.image_settings.use_exr_interleave = True  # in one part
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("shot.blend"))
    return scene


def use_program():
    """One that notes its calls."""
    with open("program", "w", encoding="utf-8") as file:
        file.write("#!/bin/sh\necho \"$*\" >> calls\nexec '%s' \"$@\"\n" % PROGRAM)
    os.chmod("program", 0o755)
    bpy.context.preferences.addons["reframe"].preferences.program = os.path.abspath("program")


def renders():
    """The calls that rendered, since this was asked before."""
    with open("calls", encoding="utf-8") as file:
        calls = [line for line in file if line.startswith("render ") and " --check " not in line and "no such scene" not in line]
    os.remove("calls")
    return calls


def rendered(path):
    """By pass and channel, as Reframe calls them."""
    channels, header = exr.read(path)
    found = {}
    for full, values in channels.items():
        layer, name, letter = re.fullmatch(r"(.*?)\.(.*)\.(.)", full).groups()
        assert layer in (LAYER, "Unused", "ViewLayer"), full
        found[engine.pass_name(name), letter] = values
    return found, header


def check_animation(scene):
    scene.render.filepath = os.path.abspath("out/shot.")
    assert bpy.ops.render.render(animation=True) == {"FINISHED"}
    assert sorted(os.listdir("out")) == ["shot.%04d.exr" % n for n in FRAMES], os.listdir("out")
    assert sorted(os.listdir("reframe")) == ["Scene.%04d.exr" % n for n in FRAMES] + ["Scene.glb"], os.listdir("reframe")
    calls = renders()
    assert len(calls) == 1 and "--frames 5-9x2 " in calls[0] and " --group 1 " in calls[0], calls
    for number in FRAMES:
        ours, header = rendered("reframe/Scene.%04d.exr" % number)
        whole, blenders = rendered("out/shot.%04d.exr" % number)
        assert ours["Combined", "R"].shape == (40, 64) and 0.01 < ours["Combined", "R"].mean() < 1.0
        light, index = ("Emission", "Object Index") if bpy.app.version >= (5, 0, 0) else ("Emit", "IndexOB")
        assert {"Depth", "Normal", "Vector", light, index, "CryptoObject00", "Denoising Albedo"} <= {name for name, _ in ours}
        for key, values in ours.items():
            assert key in whole and (values == whole[key]).all(), "frame %d: the pass %s is not Blender's" % (number, key)
        names = [key for key in header if key.startswith("cryptomatte/") and key.endswith("/manifest")]
        assert names and all(blenders[key] == header[key] for key in names), "the names of Cryptomatte are lost"


def check_still(scene):
    """A frame by itself, and a part of it."""
    render = scene.render
    scene.frame_set(7)
    pictures = {}
    for name, border in (("whole", False), ("part", True)):
        render.use_border = render.use_crop_to_border = border
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.33, 0.8, 0.2, 0.73
        render.filepath = os.path.abspath(name + ".exr")
        assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
        pictures[name] = rendered(name + ".exr")[0]["Depth", "Z"]
    scene.camera.data.type = "PANO"  # of which no part can be exported
    panorama_of(scene.camera.data).panorama_type = "EQUIRECTANGULAR"
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    assert rendered("part.exr")[0]["Combined", "R"].shape == pictures["part"].shape
    scene.camera.data.type, render.use_border = "PERSP", False
    part = pictures["whole"][40 - int(0.73 * 40):40 - int(0.2 * 40), int(0.33 * 64):int(0.8 * 64)]
    assert part.shape == pictures["part"].shape, (part.shape, pictures["part"].shape)
    cube = (part < 100.0) & (pictures["part"] < 100.0)
    assert cube.mean() > 0.5 and numpy.abs(part - pictures["part"])[cube].mean() < 0.03, "the region is another one"  # by a pixel: 0.1
    assert ["--frames 7 " in call and " --group 0 " in call for call in renders()] == [True] * 3


class Esc:
    """An engine in which Esc is pressed when the first frame is finished."""
    is_animation, is_pressed = True, False

    def update_stats(self, stats, text):
        self.is_pressed = self.is_pressed or engine.FINISHED.match(text.removeprefix("Reframe: ")) is not None

    def test_break(self):
        return self.is_pressed

    def report(self, kind, text):
        pass

    def update_progress(self, share):
        pass


def check_stop(scene):
    """What is finished stays, and the next start goes on."""
    settings = scene.reframe_render
    settings.samples, settings.arguments = 2000, "--threads 1"
    scene.render.filepath = os.path.abspath("out/shot.")
    scene.frame_set(FRAMES[0])
    stopped = Esc()
    run = engine.Run(stopped, scene, LAYER)
    try:
        run.start(stopped, PROGRAM)
        run.wait_for(stopped, FRAMES[-1])
        raise AssertionError("it was not stopped")
    except engine.Stopped:
        run.end()
    assert FRAMES[0] in run.finished and FRAMES[-1] not in run.finished and not os.path.exists(run.temporary)
    before = os.stat("reframe/Scene.0005.exr").st_mtime_ns
    assert bpy.ops.render.render(animation=True) == {"FINISHED"}
    assert os.stat("reframe/Scene.0005.exr").st_mtime_ns == before, "a finished frame was rendered again"
    for number in (5, 9):
        ours, blenders = (rendered(name % number)[0]["Combined", "R"] for name in ("reframe/Scene.%04d.exr", "out/shot.%04d.exr"))
        assert (ours == blenders).all(), "frame %d is not the one that was rendered" % number
    settings.samples, settings.arguments = 8, ""


def check_errors(scene):
    for settings, part in (({"arguments": "--spp none"}, "--spp: expected"), ({"arguments": "--size 20x10"}, "frames are 20x10, not 64x40"),
                           ({"program": "/no/such"}, "/no/such: the program is not there")):
        scene.reframe_render.arguments = settings.get("arguments", "")
        scene.render.filepath = os.path.abspath("failed/shot.")
        if "program" in settings:
            bpy.context.preferences.addons["reframe"].preferences.program = settings["program"]
        try:
            bpy.ops.render.render(animation=True)
            raise AssertionError("no error: " + part)
        except RuntimeError as e:
            assert part in str(e), e
    scene.reframe_render.arguments = ""
    assert not os.path.exists("failed")


def check_panels():
    def shown(engine):
        return {p.__name__ for p in engine_panels.panels() if engine in getattr(p, "COMPAT_ENGINES", ())}

    engine_panels = engine.engine_panels
    names = shown("REFRAME")
    assert {"CYCLES_MATERIAL_PT_surface", "CYCLES_LIGHT_PT_light", "CYCLES_WORLD_PT_surface", "REFRAME_PT_sampling"} <= names, names
    assert not names & {"CYCLES_RENDER_PT_sampling", "CYCLES_RENDER_PT_light_paths", "CYCLES_MATERIAL_PT_preview"}, names
    polls = [poll for poll, _ in engine.engine_panels._polls]
    assert polls and all(poll(types.SimpleNamespace(engine=name)) for poll in polls for name in ("CYCLES", "REFRAME"))
    bpy.ops.preferences.addon_disable(module="reframe")
    assert not any(poll(types.SimpleNamespace(engine="REFRAME")) for poll in polls)
    assert not {n for n in shown("REFRAME") if not n.startswith("REFRAME")} and {"CYCLES_RENDER_PT_sampling"} <= shown("CYCLES")
    assert not hasattr(bpy.types.Scene, "reframe_render")


use_program()
shot = make_scene()
check_animation(shot)
check_still(shot)
check_errors(shot)
use_program()
check_stop(shot)  # last, since Blender's exit status tells of the last render
check_panels()
print("the engine works")
