"""Which material the camera sees in each pixel, for the benchmark scripts: a copy of the scene, in which every material
emits its number, rendered with one sample per pixel and no light but that."""
import json
import os
import struct

import benchlib
import picturelib

STEPS = 4096  # more materials than that are not told apart


def read_glb(path):
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        benchlib.fail("%s: materials are told apart in .glb files only" % path)
    length = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + length]), data[20 + length:]


def write_glb(path, gltf, rest):
    text = json.dumps(gltf).encode("utf-8")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest)


def describe(material):
    """Name and what decides how it reflects; textures and the JSON of a scene file may say otherwise."""
    base, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
    rough = base.get("roughnessFactor", 1.0)
    if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0) > 0.0:
        kind = "glass" if "KHR_materials_volume" in extensions else "pane"
    elif base.get("metallicFactor", 1.0) >= 0.5:
        kind = "metal"
    elif extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0) == 0.0:
        return "%s (matte)" % material.get("name", "?")
    else:
        kind = "dielectric"
    return "%s (%s %.2g)" % (material.get("name", "?"), kind, rough)


def number(gltf):
    """Replaces every material by one that emits its number; returns what the numbers stand for."""
    materials = gltf.setdefault("materials", [])
    names = [describe(m) for m in materials] + ["no material"]
    for mesh in gltf.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive.setdefault("material", len(materials))
            primitive.get("extensions", {}).pop("KHR_materials_variants", None)
    alpha = [{key: m[key] for key in ("alphaMode", "alphaCutoff") if key in m} for m in materials] + [{}]
    base = [m.get("pbrMetallicRoughness", {}) for m in materials] + [{}]
    gltf["materials"] = [dict(a, pbrMetallicRoughness=b, doubleSided=True, emissiveFactor=[(i + 1) / STEPS, 1, 0])
                         for i, (a, b) in enumerate(zip(alpha, base))]
    for scene in gltf.get("scenes", []):
        scene.pop("extras", None)
    return names


def numbered_scene(scene, folder):
    """The copy of a .glb, or of a scene file (.json) and its .glb."""
    wrapped = None
    source = scene
    if scene.endswith(".json"):
        with open(scene) as file:
            wrapped = json.load(file)
        source = os.path.join(os.path.dirname(scene), wrapped["scene"])
    gltf, rest = read_glb(source)
    names = number(gltf)
    made = os.path.join(folder, "numbered.glb")
    write_glb(made, gltf, rest)
    if wrapped is not None:
        camera = wrapped.get("camera")
        if isinstance(camera, str) and os.path.exists(os.path.join(os.path.dirname(scene), camera)):
            wrapped["camera"] = os.path.abspath(os.path.join(os.path.dirname(scene), camera))
        kept = {key: value for key, value in wrapped.items() if key in ("camera", "render")}
        made = os.path.join(folder, "numbered.json")
        with open(made, "w") as file:
            json.dump(dict(kept, scene="numbered.glb"), file)
    return made, names


def seen(binary, scene, folder, size, frames, options=()):
    """For each frame and material the pixels that show it: {frame: {name: [pixel, ...]}}."""
    made, names = numbered_scene(scene, folder)
    pattern = os.path.join(folder, "materials.####.exr")
    options = benchlib.without(options, "--max-depth", "--adaptive", "--no-adaptive")
    done = benchlib.render(binary, made, pattern, size, "0:1", 1, 1, frames, None, [*options, "--max-depth", "1"])
    result = {}
    for frame in (f["frame"] for f in done["frames"]):
        _, _, (red, green, _) = picturelib.read(benchlib.frame_of(pattern, frame))
        pixels = result[frame] = {}
        for at, (r, g) in enumerate(zip(red, green)):
            name = names[round(STEPS * r / g) - 1] if g > 0.0 else "background"
            pixels.setdefault(name, []).append(at)
    return result


def split_edges(found, width, height):
    """Of one frame: the pixels next to another material apart from those inside."""
    name = {at: n for n, pixels in found.items() for at in pixels}
    result = {}
    for at, own in name.items():
        x, y = at % width, at // width
        around = (j * width + i for j in range(max(y - 1, 0), min(y + 2, height)) for i in range(max(x - 1, 0), min(x + 2, width)))
        where = "edge" if any(name[other] != own for other in around) else "inside"
        result.setdefault("%s %s" % (own, where), []).append(at)
    return result
