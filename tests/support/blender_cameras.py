"""For test_blender_cameras.c: cameras.blend with matte and shining balls under a grey sky, seen by a camera with depth of
field, an orthographic one with depth of field and a shifted picture, and a panoramic one; Cycles' pictures of each with the
box filter (NAME.exr), and that of the first without its lens (Sharp.exr).
"""
import math
import os

import bpy

from blender_words import begin, compositor, glow, matte, panorama_of, placed, save, world, write_by_cycles

SAMPLES = int(os.environ.get("CYCLES_SAMPLES", "96"))
CAMERAS = ("Lens", "Flat", "Round")


def set_up():
    world((0.4, 0.5, 0.6))
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(matte((0.5, 0.45, 0.4), "floor"))
    for i in range(12):
        bpy.ops.mesh.primitive_cube_add(size=0.8, location=((i % 4) * 1.4 - 2.1, 1.8 * (i // 4), 0.4), rotation=(0, 0, 0.4 * i))
        colour = (0.1 + 0.8 * (i % 3 == 0), 0.1 + 0.8 * (i % 3 == 1), 0.1 + 0.8 * (i % 2))
        bpy.context.object.data.materials.append(glow(colour, 3.0, "m%d" % i) if i % 5 == 2 else matte(colour, "m%d" % i))


def add_camera(name, place, turn):
    data = placed(name, bpy.data.cameras.new(name), place, [math.radians(a) for a in turn]).data
    data.clip_start = 1e-3
    return data


def add_cameras():
    lens = add_camera("Lens", (0.3, -3.0, 1.6), (72, 5, 4))
    lens.lens, lens.dof.use_dof, lens.dof.focus_distance, lens.dof.aperture_fstop = 35.0, True, 4.2, 0.07
    lens.dof.aperture_blades, lens.dof.aperture_rotation = 5, 0.3
    flat = add_camera("Flat", (0.5, -4.0, 3.0), (60, 0, 10))
    flat.type, flat.ortho_scale, flat.shift_x, flat.shift_y = "ORTHO", 7.0, 0.08, -0.05
    flat.dof.use_dof, flat.dof.focus_distance, flat.dof.aperture_fstop = True, 5.0, 1.2
    add_camera("Round", (0.2, 0.9, 1.1), (80, 10, 50)).type = "PANO"
    panorama_of(bpy.data.cameras["Round"]).panorama_type = "EQUIRECTANGULAR"


def render(camera, path):
    bpy.context.scene.camera = bpy.data.objects[camera]
    write_by_cycles(path, SAMPLES, bounces=2)


def main():
    scene = begin(size=(96, 54))
    set_up()
    add_cameras()
    scene.camera = bpy.data.objects[CAMERAS[0]]
    # what Blender does to whole pictures, and the export is to tell
    scene.cycles.film_exposure, scene.render.use_multiview = 2.0, True
    tree, _ = compositor(scene)
    tree.nodes.new("CompositorNodeBlur")
    save("cameras")
    scene.cycles.film_exposure, scene.render.use_multiview, scene.render.use_compositing = 1.0, False, False
    for name in CAMERAS:
        render(name, name + ".exr")
    bpy.data.cameras["Lens"].dof.use_dof = False
    render("Lens", "Sharp.exr")
