"""Blender's glTF exporter, and what is put right in the .glb afterwards."""
import os

import bpy
import numpy

from . import extents, films, passes, profiles
from .glb_data import Data, FLOAT, read, write
from .gloss import strength_of_coat
from .materials import patches
from .messages import blenders_error, fail, folder_beside, losses, remove_folders, warnings
from .versions import offered

if "bool" not in vars(numpy):
    numpy.bool = bool  # the exporter of Blender 3.4 uses a name that numpy 1.24 has removed


def export(out):
    """Writes a .glb in a folder of its own; returns its path."""
    path = os.path.join(folder_beside(out), os.path.basename(out))
    operator = bpy.ops.export_scene.gltf
    operator(
        filepath=path, export_format="GLB", export_cameras=True, export_lights=True, export_extras=True, export_apply=True,
        use_renderable=True,  # skips objects hidden from render: cutters, targets, parents
        export_yup=True, export_animations=True, export_frame_range=True, export_force_sampling=False,
        # glTF multiplies by vertex colours whether the material uses them or not: they are baked
        **offered(operator, export_colors=False, export_vertex_color="NONE",
                  convert_lighting_mode="COMPAT", export_import_convert_lighting_mode="COMPAT"))
    if not os.path.exists(path):
        fail("%s: was not written: %s" % (out, blenders_error()))
    return path


def restore_booleans(gltf):
    """Custom properties have no booleans, which Reframe's `visible` needs."""
    for scene in gltf.get("scenes", []):
        environment = scene.get("extras", {}).get("reframe", {}).get("environment", {})
        if isinstance(environment.get("visible"), int):
            environment["visible"] = bool(environment["visible"])


def set_value(item, path, value):
    """A property by its path, as keys have it."""
    *way, last = path.split("/")
    for name in way:
        item = item.setdefault(name, {})
    item[last] = value


def add_texture(gltf, data, image):
    """Puts a packed image into the file; returns the number of its texture."""
    images, textures = gltf.setdefault("images", []), gltf.setdefault("textures", [])
    known = next((i for i, other in enumerate(images) if other.get("name") == image.name), None)
    if known is None:
        images.append({"bufferView": data.view(bytes(image.packed_file.data)), "mimeType": "image/png", "name": image.name})
        known = len(images) - 1
    textures.append({"source": known})
    return len(textures) - 1


def add_textures(material, patch, gltf, data):
    """Those of extensions, and what light shines through with the colours of the base."""
    for extension, key, image, place in patch.get("added", []):
        material.setdefault("extensions", {}).setdefault(extension, {})[key] = {"index": add_texture(gltf, data, image), "texCoord": place}
        if key == "diffuseTransmissionColorTexture":
            material["extensions"][extension]["diffuseTransmissionColorFactor"] = [1.0] * 3
    if patch.get("is_through_like_base"):
        base, through = (material.get("pbrMetallicRoughness", {}), material["extensions"]["KHR_materials_diffuse_transmission"])
        through["diffuseTransmissionColorFactor"] = base.get("baseColorFactor", [1.0] * 4)[:3]
        if "baseColorTexture" in base:
            through["diffuseTransmissionColorTexture"] = base["baseColorTexture"]


def add_extensions(gltf, data):
    """The extensions of materials that the exporter cannot write."""
    used = set(gltf.get("extensionsUsed", []))
    for material in gltf.get("materials", []):
        patch = patches.get(material.get("name"), {})
        material["name"] = patch.get("name", material.get("name"))
        if patch.get("extensions"):
            material.setdefault("extensions", {}).update(patch["extensions"])
            used.update(patch["extensions"])
        coat = material.get("extensions", {}).get("KHR_materials_clearcoat")
        if coat is not None:
            coat["clearcoatFactor"] = strength_of_coat(coat.get("clearcoatRoughnessFactor", 0.0)) * coat.get("clearcoatFactor", 0.0)
        if patch.get("base") is not None:
            factor, summand = patch["base"]
            part = material.setdefault("pbrMetallicRoughness", {})
            colour = part.get("baseColorFactor", [1.0] * 4)
            added = (0.0,) * 3 if "baseColorTexture" in part else summand
            part["baseColorFactor"] = [min(max(c * factor + x, 0.0), 1.0) for c, x in zip(colour, added)] + [colour[3]]
        if patch.get("roughness", 1.0) != 1.0:
            part = material.setdefault("pbrMetallicRoughness", {})
            part["roughnessFactor"] = patch["roughness"] * part.get("roughnessFactor", 1.0)
        add_textures(material, patch, gltf, data)
        for path, value in patch.get("first", {}).items():
            set_value(material, path, value)
        used.update(material.get("extensions", {}))
        if patch.get("blends"):
            material["alphaMode"] = "BLEND"
        if "extras" in patch:
            material.setdefault("extras", {}).update(patch["extras"])
    if used:
        gltf["extensionsUsed"] = sorted(used)


def add_shot(gltf, shot):
    """Size, rate and the camera's path (extras that src/gltf/gltf_shot.c reads)."""
    for scene in gltf.get("scenes", []):
        own = scene.setdefault("extras", {}).setdefault("reframe", {})
        own.setdefault("render", shot["render"])
        own.setdefault("view", shot["view"])
    for node in gltf.get("nodes", []):
        if "camera" in node and node.get("name") == shot["camera"]:
            node.setdefault("extras", {})["reframe"] = {"path": shot["path"]}


def add_instances(gltf, data, placed):
    """Places the meshes of nodes by EXT_mesh_gpu_instancing."""
    for node in gltf.get("nodes", []):
        matrices = placed.get(node.get("name"))
        if matrices is None or "mesh" not in node:
            continue
        parts = [m.decompose() for m in matrices]
        columns = {"TRANSLATION": ("VEC3", [(p.x, p.z, -p.y) for p, _, _ in parts]),
                   "ROTATION": ("VEC4", [(q.x, q.z, -q.y, q.w) for _, q, _ in parts]),
                   "SCALE": ("VEC3", [(s.x, s.z, s.y) for _, _, s in parts])}
        attributes = {name: data.accessor(numpy.array(values, numpy.float32), FLOAT, kind) for name, (kind, values) in columns.items()}
        node.setdefault("extensions", {})["EXT_mesh_gpu_instancing"] = {"attributes": attributes}
        gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "EXT_mesh_gpu_instancing"})


def finish(path, shot, placed, tracks, deforming):
    """Puts right in the file what the exporter could not write, and adds what it does not know."""
    gltf, rest = read(path)
    data = Data(gltf, rest)
    restore_booleans(gltf)
    add_shot(gltf, shot)
    passes.write_nodes(gltf)
    deforming.write(gltf, data, tracks, placed)
    # those that move have nodes of their own, and are the last
    still = {name: matrices[:len(matrices) - len(tracks.flocks.get(name, []))] for name, matrices in placed.items()}
    still = {name: matrices for name, matrices in still.items() if matrices}
    tracks.write(gltf, data, still)
    extents.write(gltf)
    profiles.write(gltf)
    add_extensions(gltf, data)
    films.add_to(gltf)
    add_instances(gltf, data, still)
    add_map(gltf, data)
    add_keys_of_sky(gltf)
    passes.write_rest(gltf, ours(gltf))
    add_warnings(gltf)
    write(path, gltf, data.chunk())


# What goes into the .glb besides the exporter's own: the map of the sky, and the warnings.

_map, _embed = None, False  # where the map of the sky is until it is put into the file or its place


def map_path(args):
    """Where the map is rendered to."""
    global _map, _embed
    _map, _embed = os.path.join(folder_beside(args.out), "sky.exr"), args.embed
    return _map


def place_of_map(args):
    return os.path.abspath(args.out)[:-len(".glb")] + "-sky.exr"


def put_in_place(args, written):
    """Moves the files to where they were asked for, when nothing can go wrong any more."""
    if _map is not None and not _embed:
        os.replace(_map, place_of_map(args))
    films.put_in_place()
    os.replace(written, args.out)
    remove_folders()


def ours(gltf):
    """The extras that Reframe reads, of the scene that it renders."""
    scene = gltf["scenes"][gltf.get("scene", 0)]
    return scene.setdefault("extras", {}).setdefault("reframe", {})


def add_map(gltf, data):
    """Puts the map that waits into the file."""
    environment = gltf["scenes"][gltf.get("scene", 0)].get("extras", {}).get("reframe", {}).get("environment", {})
    if not _embed or "map" not in environment:
        return
    with open(_map, "rb") as file:
        environment["bufferView"] = data.view(file.read())
    del environment["map"]


keys_of_sky = []  # of the environment, which custom properties cannot hold


def add_keys_of_sky(gltf):
    if not keys_of_sky:
        return
    environment = ours(gltf).setdefault("environment", {})
    environment.update(interpolation="linear", keys=keys_of_sky)
    if "radiance" in keys_of_sky[0]:
        environment.pop("radiance", None)


def add_warnings(gltf):
    """For `reframe info` to repeat."""
    for key, texts in (("export_losses", losses()), ("export_warnings", warnings())):
        if texts:
            ours(gltf)[key] = texts
