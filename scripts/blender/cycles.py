"""The Blender side of the comparison with Cycles: renders a .glb with Cycles, matching Reframe's conventions.

  blender -b --factory-startup --python-exit-code 1 -P cycles.py -- JOB.json

The job names the .glb, its frame (from 0), size, samples, seeds, bounces, where Cycles' pictures go and
which of Reframe's to read beside them. The means of all of them are written to the
job's "result", one list of three channels per picture. A job with "frames", "adaptive" and "denoise" is one
of scripts/bench/budget.py, and gets its result.
"""

import json
import math
import os
import struct
import sys

import bmesh
import bpy
import numpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from bench import budget  # noqa: E402
from blender.versions import give_nodes, set_format  # noqa: E402

numpy.bool = bool  # the importer of Blender 3.4 uses a name that numpy has removed


def read_gltf(file_name):
    with open(file_name, "rb") as file:
        head = file.read(20)
        return json.loads(file.read(struct.unpack("<I", head[12:16])[0]))


def extension(description, name):
    return description.get("extensions", {}).get("KHR_materials_" + name, {})


def make_sharp(node):
    """Blender 4 has no such distribution: there a roughness of 0 is sharp."""
    if "SHARP" in node.bl_rna.properties["distribution"].enum_items:
        node.distribution = "SHARP"


def scattering(nodes, description, links=None, image=None):
    """A matching shader. Principled does not match: its diffuse part is at least 10 per cent brighter than Lambert."""
    pbr = description.get("pbrMetallicRoughness", {})
    color = pbr.get("baseColorFactor", [1.0] * 4)[:3] + [1.0]
    if extension(description, "transmission").get("transmissionFactor", 0.0) > 0.0:
        node = nodes.new("ShaderNodeBsdfGlass")
        node.inputs["IOR"].default_value = extension(description, "ior").get("ior", 1.5)
        node.inputs["Roughness"].default_value = 0.0
        make_sharp(node)
    elif pbr.get("metallicFactor", 1.0) > 0.0 and pbr.get("roughnessFactor", 1.0) > 0.03:
        # with metallic 1 there is only the specular lobe, and only then its Fresnel reflectance rises to white
        node = nodes.new("ShaderNodeBsdfPrincipled")
        node.distribution = "GGX"
        node.inputs["Metallic"].default_value = 1.0
        node.inputs["Roughness"].default_value = pbr.get("roughnessFactor", 1.0)
        node.inputs["Base Color"].default_value = color
        return node
    elif pbr.get("metallicFactor", 1.0) > 0.0:
        node = nodes.new("ShaderNodeBsdfGlossy")
        node.inputs["Roughness"].default_value = 0.0
        make_sharp(node)
    else:
        node = nodes.new("ShaderNodeBsdfDiffuse")
        node.inputs["Roughness"].default_value = 0.0
        if image is not None:
            texture = nodes.new("ShaderNodeTexImage")
            texture.image = image
            links.new(texture.outputs["Color"], node.inputs["Color"])
    node.inputs["Color"].default_value = color
    return node


def set_material(material, description):
    give_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    image = next((n.image for n in nodes if n.type == "TEX_IMAGE" and n.label == "BASE COLOR"), None)
    nodes.clear()
    out = nodes.new("ShaderNodeOutputMaterial")
    shader = scattering(nodes, description, links, image).outputs[0]
    emission = description.get("emissiveFactor", [0.0] * 3)
    if max(emission) > 0.0:
        lamp = nodes.new("ShaderNodeEmission")
        lamp.inputs["Color"].default_value = emission + [1.0]
        lamp.inputs["Strength"].default_value = extension(description, "emissive_strength").get("emissiveStrength", 1.0)
        mix, geometry = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeNewGeometry")
        if not description.get("doubleSided", False):  # front side only
            links.new(geometry.outputs["Backfacing"], mix.inputs[0])
        else:
            mix.inputs[0].default_value = 0.0
        links.new(lamp.outputs[0], mix.inputs[1])
        links.new(shader, mix.inputs[2])
        shader = mix.outputs[0]
    links.new(shader, out.inputs["Surface"])


def cut_lamps(emitters):
    """Subdivides emitters: near one of two triangles Cycles is 1 to 2 per cent too dark; 512 are better."""
    for mesh in bpy.data.meshes:
        if any(m is not None and m.name in emitters for m in mesh.materials) and len(mesh.polygons) <= 4:
            work = bmesh.new()
            work.from_mesh(mesh)
            bmesh.ops.dissolve_limit(work, angle_limit=0.01, verts=work.verts, edges=work.edges)
            bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=15, use_grid_fill=True)
            bmesh.ops.triangulate(work, faces=work.faces)
            work.to_mesh(mesh)
            work.free()


def set_world(scene, job, gltf):
    """Black, or the environment of the glTF. The centre of Reframe's map is at Blender's +y, of Blender's at +x."""
    scene.world = bpy.data.worlds.new("world")
    give_nodes(scene.world)
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    color = nodes["Background"].inputs["Color"]
    color.default_value = (0.0, 0.0, 0.0, 1.0)
    environment = gltf["scenes"][0].get("extras", {}).get("reframe", {}).get("environment")
    if environment is None:
        return
    if "map" not in environment:
        color.default_value = (*environment["radiance"], 1.0)
        return
    at, turn, sky = (nodes.new("ShaderNode" + name) for name in ("TexCoord", "Mapping", "TexEnvironment"))
    turn.inputs["Rotation"].default_value = (0.0, 0.0, -0.5 * math.pi)
    sky.image = bpy.data.images.load(os.path.join(os.path.dirname(os.path.abspath(job["scene"])), environment["map"]))
    links.new(at.outputs["Generated"], turn.inputs["Vector"])
    links.new(turn.outputs["Vector"], sky.inputs["Vector"])
    links.new(sky.outputs["Color"], color)


def set_cycles(scene, job):
    """Cycles as Reframe renders: unclamped, all caustics, a box filter, and linear pixels. Runs in Blender."""
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    set_format(render.image_settings, "OPEN_EXR")
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "NONE"
    scene.view_settings.view_transform = "Raw"
    cycles.device, cycles.samples, cycles.pixel_filter_type = "CPU", job["samples"], "BOX"
    cycles.filter_width = 1.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = job["bounces"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = 0.0
    cycles.use_adaptive_sampling = cycles.use_denoising = False


def write_picture(scene, path, frame=None, seed=0):
    """A frame by Cycles, by default the one that the scene is at."""
    if frame is not None:
        scene.frame_set(frame)
    scene.cycles.seed, scene.render.filepath = seed, path
    bpy.ops.render.render(write_still=True)


def write_animations(scene, patterns):
    """All frames by Cycles, once by each pattern, with other seeds."""
    scene.render.use_persistent_data = True
    scene.render.image_settings.color_mode = "RGB"
    for seed, pattern in enumerate(patterns):
        scene.cycles.seed, scene.render.filepath = seed, pattern
        bpy.ops.render.render(animation=True)


def set_up(job, gltf):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    known = bpy.ops.import_scene.gltf.get_rna_type().properties
    mode = next(name for name in ("convert_lighting_mode", "export_import_convert_lighting_mode") if name in known)
    bpy.ops.import_scene.gltf(filepath=job["scene"], **{mode: "COMPAT"})
    for description in gltf.get("materials", []):
        set_material(bpy.data.materials[description["name"]], description)
    if "frames" not in job:
        cut_lamps({d["name"] for d in gltf.get("materials", []) if max(d.get("emissiveFactor", [0.0])) > 0.0})
    for light in bpy.data.lights:
        light.shadow_soft_size = 0.0
    scene = bpy.context.scene
    scene.camera = next(o for o in scene.objects if o.type == "CAMERA")
    scene.camera.data.sensor_fit = "VERTICAL"
    scene.camera.data.angle_y = gltf["cameras"][0]["perspective"]["yfov"]
    scene.camera.data.clip_start = 1e-3
    set_world(scene, job, gltf)
    scene.render.fps = 24
    scene.frame_set(job.get("frame", 0))
    set_cycles(scene, {"samples": 1, **job})


def mean(file_name):
    image = bpy.data.images.load(file_name)
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(len(image.pixels), dtype=numpy.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, image.channels)[:, :3].astype(numpy.float64).mean(axis=0).tolist()


def render_sequence(scene, job):
    scene.render.use_persistent_data = True
    scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = job["adaptive"], job["denoise"]

    def render(frame, samples, seed, path):
        scene.cycles.samples = samples
        write_picture(scene, path or job["result"] + ".exr", frame - 1, seed)

    return budget.sequence(job, render)


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    set_up(job, read_gltf(job["scene"]))
    scene = bpy.context.scene
    if "frames" in job:
        result = render_sequence(scene, job)
    else:
        for seed, name in enumerate(job["cycles"]):
            write_picture(scene, name, seed=seed)
        result = {who: [mean(n) for n in job[who]] for who in ("cycles", "reframe")}
    with open(job["result"], "w", encoding="utf-8") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
