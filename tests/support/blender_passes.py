"""A scene whose light groups, mattes and indices Blender's compositor takes from Reframe's frames, for test_blender_passes.c:

    blender_make.py -- passes make                      passes.blend, balanced.blend with its groups dimmed, and cycles.exr
    blender_make.py -- passes look FRAME.exr SAMPLES NOISY.exr      what the compositor makes of them, beside cycles.exr
    blender_make.py -- passes mix OUT FRAME.exr...      means of parts of frames whose light groups are mixed anew
"""
import json
import math
import os
import struct

import bpy
import numpy

from blender_words import begin, compositor, give_nodes, instances_of, key, mixed_inputs, moved_to, placed, principled_of, save, set_format, socket

WIDTH, HEIGHT, SAMPLES = 64, 36, 256
SHARES = {"key": 0.3, "fill light": 2.0}
PARTS = (4, 3)  # of a picture, across and down


def painted(name, index, colour, glow=None):
    material = bpy.data.materials.new(name)
    give_nodes(material)
    material.pass_index = index
    node = principled_of(material.node_tree)
    socket(node, "Base Color").default_value = (*colour, 1)
    socket(node, "Specular").default_value = 0.0
    node.inputs["Roughness"].default_value = 1.0
    socket(node, "Emission").default_value = (*(glow or (0, 0, 0)), 1)
    node.inputs["Emission Strength"].default_value = 1.0
    return material


def link(name, data, place, group="", index=0):
    o = placed(name, data, place)
    o.pass_index = index
    if group:
        o.lightgroup = group
    return o


def lamp(name, kind, place, energy, group):
    o = link(name, bpy.data.lights.new(name, kind), place, group)
    o.data.energy = energy
    return o


def box(name, material, place, size, **options):
    bpy.ops.mesh.primitive_cube_add(size=size)
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    mesh.name = "mesh of " + name  # which no pass is to show
    mesh.materials.append(material)
    return link(name, mesh, place, **options)


def switch_on_passes(layer):
    for name in ("z", "normal", "vector", "object_index", "material_index", "mist", "cryptomatte_object", "cryptomatte_material",
                 "cryptomatte_asset"):
        setattr(layer, "use_pass_" + name, True)
    layer.cycles.denoising_store_passes, layer.pass_cryptomatte_depth = True, 8


def make_scene():
    scene, layer = begin(3), bpy.context.view_layer
    for name in SHARES:
        layer.lightgroups.add(name=name)
    red, blue, glow = painted("Red paint", 3, (0.8, 0.1, 0.1)), painted("Blue.001", 7, (0.1, 0.1, 0.8)), painted("Glow", 0, (0, 0, 0), (2, 2, 1))
    floor = box("Floor", blue, (0, 4, -0.05), 1.0, index=4)
    floor.scale = (14, 16, 0.1)
    stand = link("Set", None, (-0.8, 0, 0))
    for name, place, index in (("Left box", (-0.8, 0, 0.6), 1), ("Mid", (0.8, 0.6, 0.6), 2)):
        box(name, red, place, 1.2, index=index).parent = stand
    right = box("Right", red, (1.6, 0, 0.6), 1.2, index=5)
    key(right, "location", ((1, (1.6, 0, 0.6)), (3, (1.6, 0, 1.0))), interpolation="LINEAR")
    stones = moved_to(bpy.data.collections.new("Stones"), box("Stone", blue, (0, 0, 0.3), 0.6, index=9))
    for i, x in enumerate((-2.4, 2.8)):  # an instance is called as what it shows
        instances_of(stones, "Place %d" % i, (x, -0.6, 0)).pass_index = 20 + i
    # a strip of each group, of one material and mesh
    strip = box("Strip", glow, (-3, 3, 2), 0.5, group="key")
    link("Other strip", strip.data, (3, 3, 2), "fill light")
    lamp("Key", "POINT", (-3, -3, 4), 300, "key").data.shadow_soft_size = 0.2
    lamp("Fill", "POINT", (3, -3, 4), 100, "fill light").data.shadow_soft_size = 0.0
    lamp("Top", "AREA", (0, 0, 4.5), 60, "fill light").data.size = 1.0
    world = bpy.data.worlds.new("World")
    give_nodes(world)
    scene.world, world.lightgroup = world, "fill light"
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.8, 1)
    eye = link("Eye", bpy.data.cameras.new("Eye"), (0, 0, 0))
    eye.data.lens, eye.rotation_euler = 40, (math.radians(82), 0, 0)
    key(eye, "location", ((1, (-0.2, -7.5, 2.2)), (3, (0.2, -7.5, 2.1))), interpolation="LINEAR")
    scene.camera = eye
    return scene


def balance(scene):
    """The lamps of both groups by their shares."""
    for o in scene.objects:
        if o.type == "LIGHT":
            o.data.energy *= SHARES[o.lightgroup]
    for o in (scene.objects["Strip"], scene.objects["Other strip"]):
        o.material_slots[0].link = "OBJECT"
        o.material_slots[0].material = o.data.materials[0].copy()
        o.material_slots[0].material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = SHARES[o.lightgroup]
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value *= SHARES[scene.world.lightgroup]


def render_by_cycles(scene, path):
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.device, cycles.samples = "CYCLES", "CPU", SAMPLES
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    settings = render.image_settings
    set_format(settings, "OPEN_EXR_MULTILAYER")
    settings.color_depth, settings.exr_codec = "32", "ZIP"
    render.use_file_extension, render.filepath = False, os.path.abspath(path)
    scene.frame_set(2)
    bpy.ops.render.render(write_still=True)
    settings.color_depth, settings.exr_codec = "16", "ZIPS"  # what is asked of Reframe


def make():
    scene = make_scene()
    switch_on_passes(bpy.context.view_layer)
    render_by_cycles(scene, "cycles.exr")
    save("passes")
    balance(scene)
    scene.world.lightgroup = ""  # those of lamps are enough
    scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "DWAA"
    save("balanced")


def header_of(path):
    """The attributes of an EXR file by name, as bytes (OpenEXR file layout, "Header")."""
    with open(path, "rb") as file:
        data = file.read()
    found, at = {}, 8
    while data[at] != 0:
        name, kind = data[at:data.index(b"\0", at)], None
        at += len(name) + 1
        kind = data[at:data.index(b"\0", at)]
        at += len(kind) + 1
        size = struct.unpack_from("<i", data, at)[0]
        found[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found


def manifests_of(path):
    """By the last word of its layer: names and their numbers."""
    header = header_of(path)
    keys = [key[:-len("name")] for key in header if key.startswith("cryptomatte/") and key.endswith("/name")]
    return {header[key + "name"].decode().split(".")[-1]: json.loads(header[key + "manifest"]) for key in keys}


RENAMED = {"IndexOB": "Object Index", "IndexMA": "Material Index"}  # passes of Cycles in Blender 5


class Compositor:
    """A tree of nodes behind an image; what it makes comes back as arrays, rows from below."""

    def __init__(self, path):
        scene = bpy.context.scene
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
        (self.tree, _), self.scene = compositor(scene), scene
        self.image = self.tree.nodes.new("CompositorNodeImage")
        self.image.image = bpy.data.images.load(os.path.abspath(path))
        self.files = self.tree.nodes.new("CompositorNodeOutputFile")
        layout = self.files.format
        set_format(layout, "OPEN_EXR")
        layout.color_depth, layout.exr_codec, layout.color_mode = "32", "NONE", "RGBA"
        self.folder = os.path.abspath("composed")
        if hasattr(self.files, "file_output_items"):  # Blender 5
            self.files.directory, self.files.file_name = self.folder, ""
            self.files.file_output_items.clear()
        else:
            self.files.base_path = self.folder
            self.files.file_slots.clear()
        self.names = []

    def pass_of(self, name):
        name = name if name in self.image.outputs else RENAMED.get(name, name)
        if name not in self.image.outputs:
            raise AssertionError("no pass '%s': the Image node has %s" % (name, ", ".join(o.name for o in self.image.outputs)))
        return self.image.outputs[name]

    def keep(self, name, output):
        if hasattr(self.files, "file_output_items"):
            self.files.file_output_items.new("RGBA", name)
            into = self.files.inputs[name]
        else:
            self.files.file_slots.new(name)
            into = self.files.inputs[-1]
        self.tree.links.new(output, into)
        self.names.append(name)

    def matte(self, kind, names):
        node = self.tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source, node.image = "IMAGE", self.image.image
        node.layer_name = "ViewLayer.Crypto" + kind
        node.matte_id = names
        return node.outputs["Matte"]

    def mixed(self, kind, first, second, first_factor=1.0):
        """The sum or the product of two sockets."""
        if hasattr(bpy.types, "CompositorNodeMixRGB"):
            node = self.tree.nodes.new("CompositorNodeMixRGB")
            slots = node.inputs[1:3]
        else:
            node = self.tree.nodes.new("ShaderNodeMix")
            node.data_type = "RGBA"
            slots = mixed_inputs(node)
        node.blend_type = kind
        node.inputs[0].default_value = first_factor
        for slot, value in zip(slots, (first, second)):
            if isinstance(value, float):
                slot.default_value = (value, value, value, 1.0)
            else:
                self.tree.links.new(value, slot)
        return next(output for output in node.outputs if output.enabled)

    def run(self):
        bpy.ops.render.render()
        end = ".exr" if hasattr(self.files, "file_output_items") else "%04d.exr" % self.scene.frame_current
        return {name: pixels_of(os.path.join(self.folder, name + end)) for name in self.names}


def pixels_of(path):
    image = bpy.data.images.load(path)
    values = numpy.empty(4 * WIDTH * HEIGHT, numpy.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(HEIGHT, WIDTH, 4).astype(float)


MATTES = {"Object": ["Left box", "Mid", "Right", "Floor", "Stone", "Left box,Right"], "Material": ["Red paint", "Blue.001", "Glow"],
          "Asset": ["Set", "Right", "Stone"]}
PASSES = ("Vector", "Depth", "Normal", "IndexOB", "IndexMA")


def composed(path):
    work = Compositor(path)
    for name in PASSES:
        work.keep(name, work.pass_of(name))
    for kind, picks in MATTES.items():
        for names in picks:
            work.keep(kind + " " + names, work.matte(kind, names))
    return work.run()


def check(is_right, text, *values):
    print(text % values)
    if not is_right:
        raise AssertionError(text % values)


def check_mattes(ours, theirs, samples):
    """Coverages are means over samples of a pixel, in which Cycles and Reframe differ by noise only."""
    for name in [kind + " " + names for kind, picks in MATTES.items() for names in picks]:
        a, b = ours[name][:, :, 0], theirs[name][:, :, 0]
        share = numpy.clip(0.5 * (a + b), 0.0, 1.0)
        noise = numpy.sqrt((share * (1.0 - share) + 1.0 / samples) * (1.0 / samples + 1.0 / SAMPLES))
        worst = (numpy.abs(a - b) / noise).max()
        mean = abs(a.mean() - b.mean()) / max(b.mean(), 1e-3)
        check(b.mean() > 1e-3 and worst < 3.0 and mean < 0.015, "%s: %.4f of the picture, off by %.2f %%, a pixel by %.1f of its noise",
              name, b.mean(), 100.0 * mean, worst)


UNSEEN = ("shader", "object", "Fill", "World", "(null)")  # which no picture shows; Cycles 5 lists lamps and the world


def check_manifests(ours, theirs):
    ours, theirs = manifests_of(ours), manifests_of(theirs)
    check(set(ours) == set(theirs), "layers of mattes: %s", ", ".join(sorted(ours)))
    for layer in ours:
        names = {n: h for n, h in theirs[layer].items() if not n.startswith("default_") and n not in UNSEEN}
        check(all(ours[layer].get(n) == h for n, h in names.items()), "%s: %s", layer, ours[layer])


def check_passes(ours, theirs):
    """Within things, where both see one alone."""
    alone = numpy.zeros((HEIGHT, WIDTH), bool)
    for name in MATTES["Object"][:5]:
        alone |= (ours["Object " + name][:, :, 0] > 0.999) & (theirs["Object " + name][:, :, 0] > 0.999)
    check(alone.mean() > 0.3, "%.2f of the pixels show one object alone", alone.mean())
    for name in ("IndexOB", "IndexMA"):
        off = numpy.abs(ours[name] - theirs[name])[alone][:, 0]
        check(off.max() == 0.0 and len(set(theirs[name][alone][:, 0])) > 1, "%s: off by %g", name, off.max())
    for name in MATTES["Object"][:3]:
        inside = alone & (theirs["Object " + name][:, :, 0] > 0.999)
        for what, channels, room in (("Vector", 4, 0.02), ("Normal", 3, 0.01), ("Depth", 1, 0.02)):
            a, b = (p[what][inside][:, :channels].mean(axis=0) for p in (ours, theirs))
            check(numpy.abs(a - b).max() < room, "%s of '%s': %s, in Cycles %s", what, name, a, b)
    moves = [theirs["Vector"][alone & (theirs["Object " + n][:, :, 0] > 0.999)].mean(axis=0) for n in ("Mid", "Right")]
    check(numpy.abs(moves[0]).min() > 0.05 and abs(moves[1][1] - moves[0][1]) > 1.0, "what moves, moves otherwise: %s, %s", *moves)


def check_sum(frame):
    """Numbers of 16 bits are off by up to 2^-11 of them; so are three here, of which two add up to the third."""
    work = Compositor(frame)
    work.keep("sum", work.mixed("ADD", *(work.pass_of("Combined_" + name) for name in SHARES)))
    work.keep("Combined", work.pass_of("Combined"))
    made = work.run()
    whole = made["Combined"][:, :, :3]
    off = numpy.abs(made["sum"][:, :, :3] - whole)
    check((off <= 2.0**-10 * whole + 1e-6).all() and whole.mean() > 0.05, "the light groups add up to within %.2g of %.2g", off.max(), whole.mean())


def check_denoising(frame):
    """Does the Denoise node take what guides it?"""
    work = Compositor(frame)
    node = work.tree.nodes.new("CompositorNodeDenoise")
    for name, slot in (("Combined", "Image"), ("Denoising Normal", "Normal"), ("Denoising Albedo", "Albedo")):
        work.tree.links.new(work.pass_of(name), node.inputs[slot])
    work.keep("Combined", work.pass_of("Combined"))
    work.keep("denoised", node.outputs[0])
    made = work.run()
    before, after = made["Combined"][:, :, :3], made["denoised"][:, :, :3]
    if (before == after).all():
        print("skipped: this Blender has no OpenImageDenoise")
        return
    rough = [numpy.abs(numpy.diff(p, axis=1)).mean() for p in (before, after)]
    check(rough[1] < rough[0] and abs(after.mean() / before.mean() - 1.0) < 0.05, "denoised: %.4f between pixels, before %.4f", *rough[::-1])


def look(frame, samples, noisy):
    ours, theirs = composed(frame), composed("cycles.exr")
    check_manifests(frame, "cycles.exr")
    check_mattes(ours, theirs, int(samples))
    check_passes(ours, theirs)
    check_sum(frame)
    check_denoising(noisy)
    print("the passes are Blender's")


def parts_of(picture):
    """The means of parts of a picture, of each channel."""
    across, down = WIDTH // PARTS[0], HEIGHT // PARTS[1]
    return [picture[y * down:(y + 1) * down, x * across:(x + 1) * across, c].mean() for y in range(PARTS[1]) for x in range(PARTS[0])
            for c in range(3)]


def mix(out, *frames):
    """A line for each frame: its groups mixed by their shares, then itself."""
    with open(out, "w", encoding="utf-8") as file:
        for frame in frames:
            work = Compositor(frame)
            work.keep("Combined", work.pass_of("Combined"))
            if "Combined_key" in work.image.outputs:
                dimmed = [work.mixed("MULTIPLY", work.pass_of("Combined_" + name), share) for name, share in SHARES.items()]
                work.keep("mixed", work.mixed("ADD", *dimmed))
            made = work.run()
            file.write(" ".join("%.9g" % v for v in parts_of(made.get("mixed", made["Combined"])) + parts_of(made["Combined"])) + "\n")


def main(what, *rest):
    {"make": make, "look": look, "mix": mix}[what](*rest)
