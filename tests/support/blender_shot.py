"""For test_blender_export.c: shot.blend, whose frames, rate, size and lens are not the usual ones.

Coloured cubes that shine, so that Cycles' pictures of frames 101 and 110 (shot-101.exr, shot-110.exr)
have no noise but that of their edges.
"""
import math
import os

import bpy


def shine(name, colour):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    return material


def cycles_picture(scene, frame, path, samples=64):
    scene.frame_set(frame)
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.device, cycles.samples = "CYCLES", "CPU", samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.max_bounces = 0
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    render.use_file_extension, render.filepath = False, os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 101, 110
    render = scene.render
    render.fps, render.fps_base = 30, 1.001
    render.resolution_x, render.resolution_y, render.resolution_percentage = 160, 90, 40
    render.pixel_aspect_x, render.pixel_aspect_y = 1.0, 1.5
    for i in range(30):
        bpy.ops.mesh.primitive_cube_add(size=0.7, location=(i % 6 - 2.5, (i * 7) % 5, i // 6 - 2))
        bpy.context.object.data.materials.append(shine("m%d" % i, (i % 3 + 0.2, (i // 3) % 3 + 0.1, 1.5 - i % 2)))
    data = bpy.data.cameras.new("Eye")
    eye = bpy.data.objects.new("Eye", data)
    scene.collection.objects.link(eye)
    scene.camera = eye
    data.sensor_fit, data.sensor_width, data.sensor_height = "AUTO", 36, 24
    data.shift_x, data.shift_y = 0.12, -0.08
    eye.rotation_euler = (math.radians(85), 0.1, 0)
    for frame, place, lens in ((101, (-1, -7, 0.5), 30), (110, (1, -7, 0), 60)):
        eye.location, data.lens = place, lens
        eye.keyframe_insert("location", frame=frame)
        data.keyframe_insert("lens", frame=frame)
    # frames 104 to 106 are another camera's
    side = bpy.data.objects.new("Side", bpy.data.cameras.new("Side"))
    side.location, side.rotation_euler = (7, 0, 0), (math.radians(90), 0, math.radians(90))
    scene.collection.objects.link(side)
    for frame, camera in ((101, eye), (104, side), (107, eye)):
        scene.timeline_markers.new(camera.name, frame=frame).camera = camera
    bpy.data.objects["Cube"].keyframe_insert("rotation_euler", frame=101)
    bpy.data.objects["Cube"].rotation_euler = (0, 0, 1)
    bpy.data.objects["Cube"].keyframe_insert("rotation_euler", frame=110)
    # behind the camera: what moves by a shape key, and what follows another object
    bpy.ops.mesh.primitive_cube_add(location=(0, -30, 0))
    wave = bpy.context.object
    wave.name = "Wave"
    wave.shape_key_add(name="Basis")
    key = wave.shape_key_add(name="bent")
    key.data[0].co.z += 1.0
    key.keyframe_insert("value", frame=104)
    key.value = 1.0
    key.keyframe_insert("value", frame=106)
    guide = bpy.data.objects.new("guide", None)
    scene.collection.objects.link(guide)
    guide.keyframe_insert("location", frame=101)
    guide.location = (1, 0, 0)
    guide.keyframe_insert("location", frame=110)
    bpy.ops.mesh.primitive_cube_add(location=(0, -40, 0))
    bpy.context.object.name = "Follower"
    follow = bpy.context.object.constraints.new("COPY_LOCATION")
    follow.target, follow.use_offset = guide, True
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("shot.blend"))
    for frame in (101, 110):
        cycles_picture(scene, frame, "shot-%d.exr" % frame)


if __name__ == "__main__":
    main()
