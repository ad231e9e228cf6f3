"""Renders frames of a .glb by Mitsuba 3 or LuxCore, or judges sequences by ColorVideoVDP: runs in a Python that has those packages.

    PYTHON rival.py JOB.json

The .glb is one that rivals.simplify() made: Lambert materials, perfect mirrors, clear glass, one-sided emitters, a sky. The job names
its "renderer", "scene", "size", "depth" and "threads", and what budget.sequence() reads; "result" is the file for what that returns.
"""
import io
import json
import os
import struct
import sys
import time

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import budget  # noqa: E402

TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
PASS = 64  # samples that Mitsuba holds at a time
FPS = 24


def turned(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Scene:
    """Per material one mesh in world space; the camera's matrix by frames, which are keys of its path."""
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        length = struct.unpack("<I", data[12:16])[0]
        self.gltf, self.binary = json.loads(data[20:20 + length]), data[28 + length:]
        self.meshes, self.cameras = {}, {}
        for node in self.gltf["scenes"][0]["nodes"]:
            self.visit(node, np.eye(4))
        environment = self.gltf["scenes"][0].get("extras", {}).get("reframe", {}).get("environment")
        self.sky = environment and os.path.join(os.path.dirname(os.path.abspath(path)), environment["map"])

    def values(self, number):
        accessor = self.gltf["accessors"][number]
        view, width, kind = self.gltf["bufferViews"][accessor["bufferView"]], WIDTHS[accessor["type"]], np.dtype(TYPES[accessor["componentType"]])
        at, step = view.get("byteOffset", 0) + accessor.get("byteOffset", 0), view.get("byteStride", width * kind.itemsize)
        return np.ndarray((accessor["count"], width), kind, self.binary, at, (step, kind.itemsize))

    def visit(self, number, above):
        node, matrix = self.gltf["nodes"][number], np.eye(4)
        moves = {c["target"]["path"]: c["sampler"] for a in self.gltf.get("animations", []) for c in a["channels"] if c["target"].get("node") == number}
        if "matrix" in node:
            matrix = np.array(node["matrix"]).reshape(4, 4).T
        else:
            matrix[:3, :3] = turned(*node.get("rotation", (0, 0, 0, 1))) * node.get("scale", (1, 1, 1))
            matrix[:3, 3] = node.get("translation", (0, 0, 0))
        if "camera" in node:
            samplers = [self.gltf["animations"][0]["samplers"][moves[path]] for path in ("translation", "rotation")]
            places, turns = (self.values(s["output"]) for s in samplers)
            for time, place, turn in zip(self.values(samplers[0]["input"])[:, 0], places, turns):
                key = np.eye(4)
                key[:3, :3], key[:3, 3] = turned(*turn), place
                self.cameras[round(float(time) * FPS) + 1] = above @ key
            self.fov = np.degrees(self.gltf["cameras"][node["camera"]]["perspective"]["yfov"])
        for primitive in self.gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            self.add(primitive, above @ matrix)
        for child in node.get("children", []):
            self.visit(child, above @ matrix)

    def add(self, primitive, matrix):
        points, uvs, normals = (self.values(primitive["attributes"][name]).astype(np.float64) for name in ("POSITION", "TEXCOORD_0", "NORMAL"))
        normals = normals @ np.linalg.inv(matrix[:3, :3])
        triangles = self.values(primitive["indices"]).reshape(-1, 3).astype(np.uint32)
        parts = self.meshes.setdefault(primitive["material"], [[], [], [], []])
        first = sum(map(len, parts[0]))
        for part, values in zip(parts, (points @ matrix[:3, :3].T + matrix[:3, 3], normals / np.linalg.norm(normals, axis=1, keepdims=True), uvs,
                                        triangles[:, ::-1 if np.linalg.det(matrix[:3, :3]) < 0 else 1] + first)):
            part.append(values)

    def parts(self):
        """Number, kind, colour (or linear pixels), index of refraction, radiance, and points, normals, UVs and triangles of each material."""
        for number, parts in self.meshes.items():
            material = self.gltf["materials"][number]
            base, extensions = material["pbrMetallicRoughness"], material.get("extensions", {})
            kind = "mirror" if base["metallicFactor"] else "glass" if "KHR_materials_transmission" in extensions else "lambert"
            color = np.array(base["baseColorFactor"][:3])
            if "baseColorTexture" in base:
                color = color * self.texture(base["baseColorTexture"]["index"])
            radiance = np.array(material.get("emissiveFactor", [0.0] * 3)) * extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
            yield number, kind, color, extensions.get("KHR_materials_ior", {}).get("ior", 1.5), radiance, [np.concatenate(p) for p in parts]

    def texture(self, number):
        from PIL import Image
        view = self.gltf["bufferViews"][self.gltf["images"][self.gltf["textures"][number]["source"]]["bufferView"]]
        begin = view.get("byteOffset", 0)
        pixels = np.asarray(Image.open(io.BytesIO(self.binary[begin:begin + view["byteLength"]])).convert("RGB")) / 255.0
        return np.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4)


def mitsuba(job):
    import drjit
    import mitsuba as mi
    mi.set_variant(job["variant"])
    scene, (width, height) = Scene(job["scene"]), job["size"]
    made = {"type": "scene", "integrator": {"type": "path", "max_depth": job["depth"]}}
    if scene.sky:
        to_world = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
        made["sky"] = {"type": "envmap", "filename": scene.sky, "to_world": to_world}
    for number, kind, color, ior, radiance, (points, normals, uvs, triangles) in scene.parts():
        bsdf = {"lambert": {"type": "twosided", "bsdf": {"type": "diffuse"}}, "mirror": {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}},
                "glass": {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}}[kind]
        if kind == "lambert":
            bsdf["bsdf"]["reflectance"] = {"type": "rgb", "value": color.tolist()} if color.ndim == 1 else {
                "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(color, np.float32)), "raw": True}
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf)
        if radiance.any():
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": radiance.tolist()}})
        mesh = mi.Mesh("m%d" % number, len(points), len(triangles), has_vertex_normals=True, has_vertex_texcoords=True, props=properties)
        into = mi.traverse(mesh)
        for name, values in (("vertex_positions", points), ("vertex_normals", normals), ("vertex_texcoords", uvs), ("faces", triangles)):
            into[name] = np.ravel(values).astype(np.uint32 if name == "faces" else np.float32)
        into.update()
        made["m%d" % number] = mesh
    loaded = mi.load_dict(made)
    drjit.set_thread_count(job["threads"])  # with one thread, a sky is never loaded

    def render(frame, samples, seed, path):
        sensor = mi.load_dict({"type": "perspective", "fov": scene.fov, "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e4,
                               "to_world": mi.ScalarTransform4f(scene.cameras[frame] @ np.diag([-1.0, 1.0, -1.0, 1.0])), "sampler": {"type": "independent"},
                               "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "component_format": "float32", "pixel_format": "rgb"}})
        pixels, done = 0.0, 0
        while done < samples:
            count = min(samples - done, PASS)
            pixels = pixels + count / samples * np.array(mi.render(loaded, sensor=sensor, spp=count, seed=(seed * 4099 + done) % 2 ** 32), np.float64)
            done += count
        if path:
            np.save(path, pixels)

    return render


def luxcore(job):
    import pyluxcore
    pyluxcore.Init()
    glb, scene, (width, height) = Scene(job["scene"]), pyluxcore.Scene(), job["size"]

    def properties(**values):
        made = pyluxcore.Properties()
        for name, value in values.items():
            made.Set(pyluxcore.Property(name.replace("__", "."), value))
        return made

    def camera(frame):
        matrix = glb.cameras[frame]
        at, ahead, up = matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1]
        return properties(scene__camera__type="perspective", scene__camera__lookat__orig=at.tolist(), scene__camera__lookat__target=(at + ahead).tolist(),
                          scene__camera__up=up.tolist(), scene__camera__fieldofview=glb.fov, scene__camera__lensradius=0.0,
                          scene__camera__screenwindow=[-width / height, width / height, -1.0 - 2.0 / height, 1.0 - 2.0 / height])  # else a row too low

    def image(name, pixels):
        scene.DefineImageMap(name, np.ascontiguousarray(pixels, np.float32), 1.0, 3, pixels.shape[1], pixels.shape[0])

    scene.Parse(camera(job["frames"][0]))
    if glb.sky:
        scene.Parse(pyluxcore.Properties().SetFromString("scene.lights.sky.type = infinite\nscene.lights.sky.file = \"%s\"\nscene.lights.sky.gamma = 1.0\n"
                                                         "scene.lights.sky.transformation = 0 0 1 0 1 0 0 0 0 1 0 0 0 0 0 1" % glb.sky))
    for number, kind, color, ior, radiance, (points, normals, uvs, triangles) in glb.parts():
        name, text = "m%d" % number, []
        if kind == "lambert":
            if color.ndim > 1:
                image(name, color)
                text += ["scene.textures.%s.type = imagemap" % name, "scene.textures.%s.file = %s" % (name, name), "scene.textures.%s.gamma = 1.0" % name]
            text += ["scene.materials.%s.type = matte" % name, "scene.materials.%s.kd = %s" % (name, name if color.ndim > 1 else "%g %g %g" % tuple(color))]
        elif kind == "mirror":
            text += ["scene.materials.%s.type = mirror" % name, "scene.materials.%s.kr = 1 1 1" % name]
        else:
            text += ["scene.materials.%s.type = glass" % name, "scene.materials.%s.kr = 1 1 1" % name, "scene.materials.%s.kt = 1 1 1" % name,
                     "scene.materials.%s.interiorior = %g" % (name, ior)]
        if radiance.any():
            text += ["scene.materials.%s.emission = %g %g %g" % (name, *radiance), "scene.materials.%s.emission.gain = 1 1 1" % name]
        text += ["scene.objects.%s.shape = %s" % (name, name), "scene.objects.%s.material = %s" % (name, name)]
        scene.DefineMesh(name, *([tuple(row) for row in values.tolist()] for values in (points, triangles, normals, uvs)), None, None)
        scene.Parse(pyluxcore.Properties().SetFromString("\n".join(text)))

    def render(frame, samples, seed, path):
        scene.Parse(camera(frame))
        config = pyluxcore.RenderConfig(pyluxcore.Properties().SetFromString("\n".join([
            "renderengine.type = PATHCPU", "renderengine.seed = %d" % seed, "sampler.type = SOBOL", "native.threads.count = %d" % job["threads"],
            "path.pathdepth.total = %d" % job["depth"], *("path.pathdepth.%s = %d" % (kind, job["depth"]) for kind in ("diffuse", "glossy", "specular")),
            "path.clamping.variance.maxvalue = 0", "film.width = %d" % width, "film.height = %d" % height, "film.filter.type = NONE",
            "film.outputs.0.type = RGB", "film.outputs.0.filename = x.exr", "film.noiseestimation.warmup = 0", "batch.haltspp = %d 0" % samples])), scene)
        session = pyluxcore.RenderSession(config)
        session.Start()  # which builds all anew
        begin = budget.cpu_seconds()
        while not session.HasDone():
            time.sleep(0.02)
            session.UpdateStats()
        took = budget.cpu_seconds() - begin
        session.Stop()
        film, pixels = session.GetFilm(), np.zeros((height, width, 3), np.float32)
        film.GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
        if path:
            np.save(path, pixels[::-1].astype(np.float64))
        return took

    return render


def cvvdp(job):
    """JOD of sequences of values of a display, frames by rows, columns and channels."""
    import torch
    from pycvvdp import cvvdp as metric
    torch.set_num_threads(job["threads"])
    judge, jod = metric(display_name=job["display"]), []
    for test, reference in job["pairs"]:
        both = [np.load(path).astype(np.float32) for path in (test, reference)]
        jod.append(float(judge.predict(*both, dim_order="FHWC", frames_per_second=FPS)[0]))
    return {"jod": jod}


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    if job["renderer"] == "cvvdp":
        result = cvvdp(job)
    else:
        result = budget.sequence(job, {"mitsuba": mitsuba, "luxcore": luxcore}[job["renderer"]](job))
    with open(job["result"], "w", encoding="utf-8") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
