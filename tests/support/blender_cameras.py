"""For test_blender_cameras.c: cameras.blend with matte and shining balls under a grey sky, seen by a camera with depth of
field, an orthographic one with depth of field and a shifted picture, and a panoramic one; Cycles' pictures of each with the
box filter (NAME.exr), and that of the first without its lens (Sharp.exr).
"""
import math
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
sys.dont_write_bytecode = True
from blender_both import panorama_of  # noqa: E402

SAMPLES = int(os.environ.get("CYCLES_SAMPLES", "96"))
CAMERAS = ("Lens", "Flat", "Round")


def material(name, colour, strength):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    kind = "ShaderNodeEmission" if strength > 0.0 else "ShaderNodeBsdfDiffuse"
    shader, out = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*colour, 1)
    if strength > 0.0:
        shader.inputs["Strength"].default_value = strength
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return made


def set_up(scene):
    scene.frame_start = scene.frame_end = 1
    world = bpy.data.worlds.new("sky")
    scene.world, world.use_nodes = world, True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.5, 0.6, 1)
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(material("floor", (0.5, 0.45, 0.4), 0.0))
    for i in range(12):
        bpy.ops.mesh.primitive_cube_add(size=0.8, location=((i % 4) * 1.4 - 2.1, 1.8 * (i // 4), 0.4), rotation=(0, 0, 0.4 * i))
        colour = (0.1 + 0.8 * (i % 3 == 0), 0.1 + 0.8 * (i % 3 == 1), 0.1 + 0.8 * (i % 2))
        bpy.context.object.data.materials.append(material("m%d" % i, colour, 3.0 if i % 5 == 2 else 0.0))


def add_camera(scene, name, place, turn):
    data = bpy.data.cameras.new(name)
    eye = bpy.data.objects.new(name, data)
    eye.location, eye.rotation_euler = place, [math.radians(a) for a in turn]
    scene.collection.objects.link(eye)
    data.clip_start = 1e-3
    return data


def add_cameras(scene):
    lens = add_camera(scene, "Lens", (0.3, -3.0, 1.6), (72, 5, 4))
    lens.lens, lens.dof.use_dof, lens.dof.focus_distance, lens.dof.aperture_fstop = 35.0, True, 4.2, 0.07
    lens.dof.aperture_blades, lens.dof.aperture_rotation = 5, 0.3
    flat = add_camera(scene, "Flat", (0.5, -4.0, 3.0), (60, 0, 10))
    flat.type, flat.ortho_scale, flat.shift_x, flat.shift_y = "ORTHO", 7.0, 0.08, -0.05
    flat.dof.use_dof, flat.dof.focus_distance, flat.dof.aperture_fstop = True, 5.0, 1.2
    add_camera(scene, "Round", (0.2, 0.9, 1.1), (80, 10, 50)).type = "PANO"
    panorama_of(bpy.data.cameras["Round"]).panorama_type = "EQUIRECTANGULAR"


def render(scene, camera, path):
    scene.camera, scene.render.filepath = bpy.data.objects[camera], os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_up(scene)
    add_cameras(scene)
    render_settings, cycles = scene.render, scene.cycles
    render_settings.engine, cycles.device, cycles.samples = "CYCLES", "CPU", SAMPLES
    render_settings.resolution_x, render_settings.resolution_y, render_settings.resolution_percentage = 96, 54, 100
    render_settings.threads_mode, render_settings.threads = "FIXED", 2
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.max_bounces = cycles.diffuse_bounces = 2
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0
    settings = render_settings.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    render_settings.use_file_extension = False
    for name in CAMERAS:
        render(scene, name, name + ".exr")
    bpy.data.cameras["Lens"].dof.use_dof = False
    render(scene, "Lens", "Sharp.exr")
    bpy.data.cameras["Lens"].dof.use_dof = True
    # what Blender does to whole pictures, and the export is to tell
    cycles.film_exposure, render_settings.use_multiview, scene.use_nodes = 2.0, True, True
    scene.node_tree.nodes.new("CompositorNodeBlur")
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("cameras.blend"))


main()
