"""For test_blender_addon.c: installs the add-on from its zip, exports, renders, and takes it away again, all by its operators.

    blender -b --factory-startup -P blender_addon.py -- ZIP PROGRAM
"""
import os
import sys
import tempfile
import time
import types

import bpy

ZIP, PROGRAM = (os.path.abspath(name) for name in sys.argv[sys.argv.index("--") + 1:])
IS_EXTENSION = bpy.app.version >= (4, 2)
NAME = "bl_ext.user_default.reframe" if IS_EXTENSION else "reframe"


def install():
    if IS_EXTENSION:
        bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    else:
        bpy.ops.preferences.addon_install(filepath=ZIP)
        bpy.ops.preferences.addon_enable(module=NAME)
    bpy.context.preferences.addons[NAME].preferences.program = PROGRAM


def make_scene():
    """A lit cube before a moving camera."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 5, 7
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.render.film_transparent = True
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    camera = scene.camera
    for frame, x in ((5, 7.0), (7, 8.0)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("shot.blend"))
    camera.lock_location[0] = True  # not saved


def folders():
    """Those of temporary files that the add-on and its Blenders make."""
    return {name for name in os.listdir(tempfile.gettempdir()) if name.startswith("reframe-")}


def state():
    return [(o.name, o.type, tuple(o.location), o.data and o.data.name) for o in bpy.data.objects], bpy.data.filepath, len(bpy.data.meshes)


def expect_error(part, operator, **properties):
    try:
        operator(**properties)
    except RuntimeError as e:
        assert part in str(e), "'%s' is not in: %s" % (part, e)
    else:
        raise AssertionError("no error: " + part)


def check_operators():
    before = state()
    assert bpy.ops.export_scene.reframe(filepath=os.path.abspath("alone.glb"), frames="5-6") == {"FINISHED"}
    assert os.path.getsize("alone.glb") > 1000
    assert bpy.ops.render.reframe(directory="//frames", arguments="--spp 2 --group 0 --json frames/r.json") == {"FINISHED"}
    assert sorted(os.listdir("frames")) == ["frame.%04d.exr" % n for n in (5, 6, 7)] + ["r.json", "scene.glb"], os.listdir("frames")
    image = bpy.data.images["Reframe"]
    assert image.source == "SEQUENCE" and os.path.basename(image.filepath) == "frame.0005.exr", (image.source, image.filepath)
    one = bpy.data.images.load(os.path.abspath("frames/frame.0007.exr"))
    assert tuple(one.size) == (32, 24) and one.channels == 4, (*one.size, one.channels)
    layer = bpy.context.view_layer
    layer.use_pass_z = True
    assert bpy.ops.render.reframe(directory="//passes", frames="5-5", arguments="--spp 2 --group 0") == {"FINISHED"}
    layer.use_pass_z = False
    with open("passes/frame.0005.exr", "rb") as file:
        assert b"ViewLayer.Depth.Z" in file.read(), "the view layer's passes are not rendered"
    assert state() == before and bpy.context.scene.camera.lock_location[0], "the open file was changed"
    scene = bpy.context.scene
    scene.render.engine, scene.reframe_render.samples, old = "REFRAME", 2, scene.render.engine
    assert bpy.ops.render.render() == {"FINISHED"}  # more of the engine: blender_engine.py
    scene.render.engine = old


def check_film():
    """What a scene with an image sequence needs beside its .glb arrives there, and is rendered."""
    for number in (5, 6, 7):
        image = bpy.data.images.new("picture", 4, 4)
        image.filepath_raw, image.file_format = os.path.abspath("film.%04d.png" % number), "PNG"
        image.save()
        bpy.data.images.remove(image)
    cube = bpy.data.objects["Cube"]
    plain, painted = cube.data.materials[0], bpy.data.materials.new("screen")
    if painted.node_tree is None:
        painted.use_nodes = True
    tree = painted.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(os.path.abspath("film.0005.png"))
    node.image.source = "SEQUENCE"
    node.image_user.frame_duration, node.image_user.frame_start, node.image_user.frame_offset = 3, 5, 4
    node.image_user.use_auto_refresh = True
    tree.links.new(node.outputs["Color"], next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"])
    cube.data.materials[0] = painted
    files = ["film-0005-png.%04d.png" % number for number in (5, 6, 7)]
    for _ in range(2):  # over files that are there already, too
        assert bpy.ops.export_scene.reframe(filepath=os.path.abspath("shown.glb"), frames="5-7") == {"FINISHED"}
        assert sorted(os.listdir("shown-frames")) == files, os.listdir("shown-frames")
    assert bpy.ops.render.reframe(directory="//film", frames="5-7", arguments="--spp 2 --group 0") == {"FINISHED"}
    assert sorted(os.listdir("film")) == ["frame.%04d.exr" % n for n in (5, 6, 7)] + ["scene-frames", "scene.glb"], os.listdir("film")
    cube.data.materials[0] = plain


def check_errors():
    bpy.context.scene.render.use_multiview = True  # of which the exporter warns
    assert bpy.ops.export_scene.reframe(filepath=os.path.abspath("warned.glb"), frames="5-5") == {"FINISHED"}
    bpy.context.scene.render.use_multiview = False
    world = bpy.context.scene.world
    world.cycles_visibility.diffuse = False
    expect_error("Accept Losses", bpy.ops.export_scene.reframe, filepath=os.path.abspath("lost.glb"), frames="5-5")
    assert not os.path.exists("lost.glb")
    assert bpy.ops.export_scene.reframe(filepath=os.path.abspath("lost.glb"), frames="5-5", accept_losses=True) == {"FINISHED"}
    world.cycles_visibility.diffuse = True
    expect_error("--spp: expected", bpy.ops.render.reframe, directory="//wrong", frames="5-5", arguments="--spp none")
    expect_error("--bogus: no such option", bpy.ops.render.reframe, directory="//wrong", frames="5-5", arguments="--bogus")
    expect_error("Nobody", bpy.ops.render.reframe, directory="", frames="5-5", arguments="--camera Nobody")
    bpy.context.preferences.addons[NAME].preferences.program = sys.executable
    expect_error("is not the program reframe", bpy.ops.render.reframe, directory="//wrong", frames="5-5")
    assert not os.path.exists("wrong"), "what was wrong was found after the export"
    bpy.context.preferences.addons[NAME].preferences.program = "/no/such/program"
    expect_error("/no/such/program: the program is not there", bpy.ops.render.reframe, directory="//frames")


def check_window():
    """What the events of a window do: lines reach the status bar, and Esc ends the program."""
    texts, shares, said = [], [], []

    def nothing(*args, **named):
        pass

    manager = types.SimpleNamespace(event_timer_add=lambda seconds, window: "timer", event_timer_remove=nothing, progress_begin=nothing,
                                    progress_end=nothing, progress_update=shares.append, modal_handler_add=nothing)
    context = types.SimpleNamespace(window_manager=manager, window=None, workspace=types.SimpleNamespace(status_text_set=texts.append))

    class Slow(sys.modules[NAME].Work):
        def work(self, context):
            yield "going", ["sh", "-c", "echo 'frame 1/4  25 %  0:01 spent' >&2; exec sleep 1000"]

    slow = Slow()
    slow.report = lambda kind, text: said.append(text)
    slow.begin(context)
    assert slow.watch(context) == {"RUNNING_MODAL"}
    until = time.monotonic() + 60.0
    while not shares and time.monotonic() < until:
        assert slow.modal(context, types.SimpleNamespace(type="TIMER", value="NOTHING")) == {"PASS_THROUGH"}
        time.sleep(0.01)
    assert shares == [25.0] and texts == ["Reframe: going (Esc cancels)", "Reframe: frame 1/4  25 %  0:01 spent (Esc cancels)"], (shares, texts)
    program = slow.process.process
    assert program.poll() is None
    assert slow.modal(context, types.SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    assert program.poll() is not None and texts[-1] is None and said == ["Reframe: cancelled"] and not os.path.exists(slow.folder)


def remove():
    bpy.ops.preferences.addon_disable(module=NAME)
    assert not hasattr(bpy.types, "RENDER_OT_reframe") and NAME not in bpy.context.preferences.addons
    for menu in (bpy.types.TOPBAR_MT_render, bpy.types.TOPBAR_MT_file_export):
        assert not any(f.__module__ == NAME for f in menu.draw._draw_funcs), "a menu keeps its line"
    bpy.ops.preferences.addon_enable(module=NAME)  # a second time
    bpy.ops.preferences.addon_disable(module=NAME)


install()
make_scene()
before = folders()
check_operators()
check_film()
check_errors()
check_window()
assert folders() == before, folders() - before
remove()
print("the add-on works")
