"""Films: image sequences and movies as textures. While the exporter works, an image that stands still takes their place in the nodes;
in the .glb it names a sequence of files (extras that src/gltf/gltf_texture.c reads).
"""
import os
import re
import shutil
import urllib.parse

import bpy
import numpy

from .messages import folder_beside, refuse, warn
from .versions import give_nodes, set_format

KINDS = ("SEQUENCE", "MOVIE")
READ = (".png", ".jpg", ".jpeg", ".webp")  # files that are copied as they are
MAGENTA = (1.0, 0.0, 1.0, 1.0)  # Cycles' colour for what is missing

_stills = {}  # (name of the film, number): the image that stands for it
_stood_for = {}  # by the name of such an image: the film
_movies = {}  # by name: the folder of the frames that were decoded
_missing = {}  # by name: the numbers and paths of files that are not there
_sequences = {}  # by the name of an image of the .glb: its extras
_folder, _url, _args = None, None, None  # where the files of sequences go
_frames, _rate = [], 24.0  # that are exported


def is_film(node):
    """Does an image node show a film? Cycles does so in every render, whether or not the viewport is refreshed."""
    image = getattr(node, "image", None)
    return image is not None and image.source in KINDS and node.type in ("TEX_IMAGE", "TEX_ENVIRONMENT")


def number_of(node, frame):
    """The number of the image that is shown in a frame, as Blender counts (BKE_image_user_frame_get)."""
    user = node.image_user
    count, number = user.frame_duration, frame - user.frame_start + 1
    if count <= 0:
        return 0
    if user.use_cyclic:
        number = (number - 1) % count + 1
    return min(max(number, 0), count) + user.frame_offset


def path_of(image, number):
    """The file of a number of a sequence."""
    path = bpy.path.abspath(image.filepath, library=image.library)
    head, name = os.path.split(path)
    runs = list(re.finditer(r"\d+", os.path.splitext(name)[0]))
    if not runs:
        return path
    start, end = runs[-1].span()
    return os.path.join(head, "%s%0*d%s" % (name[:start], end - start, number, name[end:]))


def decode(image, numbers):
    """Renders frames of a movie as PNGs, whose colours are those of the movie, by Cycles: a plane that shines, which fills the picture."""
    folder = _movies.get(image.name_full) or folder_beside(_args.out)
    _movies[image.name_full] = folder
    left = [n for n in numbers if not os.path.exists(os.path.join(folder, "%06d.png" % n))]
    width, height = image.size
    if not left or width * height == 0:
        return folder
    scene, shown = bpy.data.scenes.new("reframe movie"), bpy.data.images.load(bpy.path.abspath(image.filepath, library=image.library))
    shown.colorspace_settings.name = "Non-Color"
    mesh, eye, material = bpy.data.meshes.new("movie"), bpy.data.cameras.new("movie"), bpy.data.materials.new("movie")
    x, y = 0.5 * width, 0.5 * height
    mesh.from_pydata([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new().data.foreach_set("uv", (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0))
    mesh.materials.append(material)
    give_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    node, shine, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("TexImage", "Emission", "OutputMaterial"))
    node.image, node.interpolation = shown, "Closest"
    node.image_user.frame_duration, node.image_user.frame_start, node.image_user.use_auto_refresh = max(max(left), 1), 1, True
    tree.links.new(node.outputs["Color"], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], out.inputs["Surface"])
    eye.type, eye.ortho_scale, eye.clip_end = "ORTHO", float(max(width, height)), 10.0
    objects = [bpy.data.objects.new("movie", data) for data in (mesh, eye)]
    objects[1].location = (0.0, 0.0, 5.0)
    for o in objects:
        scene.collection.objects.link(o)
    scene.camera = objects[1]
    render = scene.render
    render.engine, scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", "CPU", 1, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width, render.dither_intensity = "BOX", 0.01, 0.0
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    set_format(render.image_settings, "PNG")
    render.image_settings.color_mode, render.use_file_extension = "RGB", False
    scene.view_settings.view_transform = "Raw"
    before = bpy.context.window.scene
    bpy.context.window.scene = scene
    for n in left:
        scene.frame_set(n)
        render.filepath = os.path.join(folder, "%06d.png" % n)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.context.window.scene = before
    bpy.data.scenes.remove(scene)
    for o in objects:
        bpy.data.objects.remove(o)
    bpy.data.meshes.remove(mesh)
    bpy.data.cameras.remove(eye)
    bpy.data.materials.remove(material)
    bpy.data.images.remove(shown)
    return folder


def file_of(film, number):
    if film.source == "MOVIE":
        return os.path.join(decode(film, [number]), "%06d.png" % number)
    return path_of(film, number)


def still_of(film, number):
    """An image that stands still, of one number of a film."""
    key = (film.name_full, number)
    if key in _stills:
        return _stills[key]
    path, image = file_of(film, number), None
    if os.path.exists(path):
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = film.colorspace_settings.name or "sRGB"  # of movies that nobody looked at it is empty
        image.alpha_mode = film.alpha_mode
        image.pack()
        image.filepath_raw = ""  # after which Blender's exporter would name it
    else:
        _missing.setdefault(film.name, {})[number] = os.path.normpath(path)
        image = bpy.data.images.new("missing", 4, 4)
        image.pixels.foreach_set(numpy.tile(numpy.array(MAGENTA, numpy.float32), 16))
        image.pack()
    image.name = "film %d" % len(_stills)  # without a suffix, which Blender's exporter would cut off
    _stills[key] = image
    _stood_for[image.name] = film
    return image


def tell_missing():
    """Once for each film, however many of its files are not there."""
    for name, paths in _missing.items():
        few = paths[min(paths)] + (" and %d other files of it are" % (len(paths) - 1) if len(paths) > 2 else
                                   " and %s are" % paths[max(paths)] if len(paths) == 2 else " is")
        warn("image '%s': %s missing: magenta, as in Cycles" % (name, few))
    _missing.clear()


def shown_in(tree, frame):
    """The films of a tree and the numbers of the images that they show in a frame, by the names of nodes."""
    return {node.name: (node.image, number_of(node, frame)) for node in tree.nodes if is_film(node)}


def show(tree, shown):
    """Puts images that stand still in the place of films."""
    for name, (film, number) in shown.items():
        tree.nodes[name].image = still_of(film, number)


# The files of sequences.


def begin(args, frames, rate):
    """Where files will go, a folder beside the .glb, and for which frames; `rate`: of them per second, as numerator and denominator."""
    global _args, _frames, _rate
    _args, _frames, _rate = args, list(frames), rate[0] / rate[1]


def place():
    return os.path.abspath(_args.out)[:-len(".glb")] + "-frames"


def folder():
    global _folder, _url
    if _folder is None:
        refuse(_args, place())
        _folder, _url = folder_beside(_args.out), urllib.parse.quote(os.path.basename(place()))
    return _folder


def put_in_place():
    if _folder is None:
        return
    os.makedirs(place(), exist_ok=True)
    for name in os.listdir(_folder):
        os.replace(os.path.join(_folder, name), os.path.join(place(), name))


def pattern_of(name, suffix):
    """A name that no other sequence has, of characters that no address treats as its own."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-") or "film"
    taken = {s["frames"] for s in _sequences.values()}
    count, base = 1, plain
    folder()
    while "%s/%s.####%s" % (_url, base, suffix) in taken:
        count, base = count + 1, "%s-%d" % (plain, count + 1)
    return base + ".####" + suffix


def name_of(pattern, number):
    return os.path.join(folder(), pattern.replace("####", "%04d" % number))


def timing(numbers):
    """How a sequence shows these images in the exported frames: the numbers of its files, and the rest of its extras."""
    frames, rate = [f - min(_frames[0], 1) for f in _frames], _rate  # of which 0 is at 0 s
    step = frames[1] - frames[0] if len(frames) > 1 else 1
    low, high = min(numbers), max(numbers)
    length = high - low + 1
    if step == 1 and low >= 0:
        off = next((n - f for n, f in zip(numbers, frames) if low < n < high), numbers[-1] - frames[-1])
        if all(n == min(max(f + off, low), high) for n, f in zip(numbers, frames)):
            return list(range(low, high + 1)), {"first": low, "last": high, "start": (low - off) / rate, "fps": rate}
        if all(n == low + (f + off - low) % length for n, f in zip(numbers, frames)):
            turns = max(-((frames[0] + off - low) // length), 0)
            return list(range(low, high + 1)), {"first": low, "last": high, "start": (low - off - turns * length) / rate, "fps": rate,
                                                "repeat": "loop"}
    return None, {"first": 1, "last": len(frames), "start": frames[0] / rate, "fps": rate / step}


def write(image, numbers):
    """The files of a film, for which an image stands; `numbers` are those that the exported frames show."""
    film = _stood_for[image.name]
    if film.source == "MOVIE":
        decode(film, sorted(set(numbers)))
    suffix = os.path.splitext(file_of(film, numbers[0]))[1].lower()
    suffix = suffix if suffix in READ else ".png"
    pattern = pattern_of(film.name, suffix)
    files, extras = timing(numbers)
    pairs = [(n, n) for n in files] if files is not None else list(enumerate(numbers, 1))
    for to, number in pairs:
        copy(film, number, name_of(pattern, to))
    _sequences[image.name] = {"frames": "%s/%s" % (_url, pattern), **extras}


def copy(film, number, path):
    source = file_of(film, number)
    if os.path.exists(source) and os.path.splitext(source)[1].lower() == os.path.splitext(path)[1]:
        shutil.copyfile(source, path)
        return
    copy = still_of(film, number).copy()
    copy.filepath_raw, copy.file_format = path, "PNG"
    copy.save()
    bpy.data.images.remove(copy)


def add_baked(image, pictures):
    """Packed images of 8 bits, one for each frame, as the sequence for which the first stands."""
    pattern, count = pattern_of(image.name, ".png"), 0
    for picture in pictures:
        count += 1
        with open(name_of(pattern, count), "wb") as file:
            file.write(picture.packed_file.data)
        bpy.data.images.remove(picture)
    _sequences[image.name] = {"frames": "%s/%s" % (_url, pattern), **timing(list(range(1, count + 1)))[1]}


def add_to(gltf):
    """Names the sequences in the .glb."""
    tell_missing()
    for image in gltf.get("images", []):
        extras = _sequences.get(image.get("name"))
        if extras is not None:
            image.setdefault("extras", {})["reframe"] = extras
