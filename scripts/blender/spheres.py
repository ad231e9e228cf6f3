"""The Blender side of the comparison of materials: a .blend of spheres, one for each material, rendered with Cycles.

  blender -b --factory-startup --python-exit-code 1 -P spheres.py -- JOB.json

In the scene "even" the spheres hang far apart in a uniform white world, in "sun" under a sun from above the
camera's left, in "room" in a closed grey room under one lamp. The camera looks at sphere N in frame N. The job's
"made" lists the materials in this order, and those that this version of Blender lacks. Written for Blender 3.4 and 4.3.
"""

import json
import math
import os
import sys

import bpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from blender.cycles import set_cycles, write_animations  # noqa: E402
from blender.versions import give_nodes  # noqa: E402

RADIUS = 0.5
DISTANCE = 5.0  # of the camera from a sphere
COLUMNS = 7
SPACING = {"even": 6.0, "sun": 6.0, "room": 2.5}  # so far apart that what one lacks is little to the others

RED, BLUE, GOLD = (0.6, 0.05, 0.03), (0.1, 0.3, 0.7), (1.0, 0.77, 0.34)

SOCKETS = {  # of the Principled BSDF, in 3.4 and in 4.3, where the names differ
    "specular": ("Specular", "Specular IOR Level"), "transmission": ("Transmission", "Transmission Weight"),
    "coat": ("Clearcoat", "Coat Weight"), "coat_roughness": ("Clearcoat Roughness", "Coat Roughness"),
    "sheen": ("Sheen", "Sheen Weight"), "subsurface": ("Subsurface", "Subsurface Weight"), "film": ("Thin Film Thickness",),
    "coat_normal": ("Clearcoat Normal", "Coat Normal"), "film_ior": ("Thin Film IOR",),
}


class Absent(Exception):
    """This version of Blender has no such node or socket."""


class Shader:
    """A few words for making nodes."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        give_nodes(self.material)
        self.tree, self.height = self.material.node_tree, None
        self.tree.nodes.clear()

    def add(self, kind, **inputs):
        if not hasattr(bpy.types, "ShaderNode" + kind) and kind != "BsdfGlossy":  # which 4.3 knows by another name
            raise Absent
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in inputs.items():
            self.feed(node, name, value)
        return node

    def feed(self, node, name, value):
        names = SOCKETS.get(name, (name.replace("_", " ").title().replace("Ior", "IOR"),))
        socket = next((node.inputs[n] for n in names if n in node.inputs), None)
        if socket is None:
            raise Absent
        if isinstance(value, (bpy.types.Node, bpy.types.NodeSocket)):
            self.tree.links.new(value.outputs[0] if isinstance(value, bpy.types.Node) else value, socket)
        elif isinstance(value, tuple):
            socket.default_value = (*value, 1.0)[:len(socket.default_value)]
        else:
            socket.default_value = value

    def of_two(self, kind, a, b, factor=None):
        node = self.tree.nodes.new("ShaderNode" + kind)
        for socket, value in zip(node.inputs, (a, b) if factor is None else (factor, a, b)):
            self.tree.links.new(value.outputs[0], socket)
        return node

    def ramp(self, factor, *colours):
        node = self.tree.nodes.new("ShaderNodeValToRGB")
        for element, (position, value) in zip(node.color_ramp.elements, colours):
            element.position, element.color = position, (*value, 1.0)
        self.tree.links.new(factor, node.inputs[0])
        return node

    def done(self, shader):
        out = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.tree.links.new(shader.outputs[0], out.inputs["Surface"])
        if self.height is not None:
            self.tree.links.new(self.height.outputs[0], out.inputs["Displacement"])
        return self.material


def bsdf(kind, **inputs):
    return lambda s: s.add("Bsdf" + kind, **inputs)


def principled(colour=(0.8, 0.8, 0.8), **inputs):
    return bsdf("Principled", base_color=colour, **inputs)


def metal_of(distribution):
    """Versions have different defaults."""
    def make(s):
        node = s.add("BsdfPrincipled", base_color=GOLD, metallic=1.0, roughness=0.6)
        node.distribution = distribution
        return node
    return make


def tinted_specular(s):
    """A share of the base colour in 3.4, a colour in 4.3."""
    node = s.add("BsdfPrincipled", base_color=RED, specular=1.0)
    tint = node.inputs["Specular Tint"]
    tint.default_value = (*RED, 1.0) if hasattr(tint.default_value, "__len__") else 1.0
    return node


def gloss_by_fresnel(s):
    return s.of_two("MixShader", s.add("BsdfDiffuse", color=BLUE), s.add("BsdfGlossy", color=(1.0, 1.0, 1.0), roughness=0.3), s.add("Fresnel", ior=1.5))


def curtain(s):
    share = s.add("Value")
    share.outputs[0].default_value = 0.6
    return s.of_two("MixShader", s.add("BsdfDiffuse", color=BLUE), s.add("BsdfTranslucent", color=(0.9, 0.6, 0.4)), share)


def glowing(s):
    return s.of_two("AddShader", s.add("BsdfDiffuse", color=BLUE), s.add("Emission", color=(1.0, 0.5, 0.2), strength=0.5))


def velvet(roughness, distribution="ASHIKHMIN"):
    """Velvet became Sheen in 4.0."""
    def make(s):
        if hasattr(bpy.types, "ShaderNodeBsdfVelvet"):
            if distribution != "ASHIKHMIN":
                raise Absent
            return s.add("BsdfVelvet", color=(0.8, 0.8, 0.8), sigma=roughness)
        node = s.add("BsdfSheen", color=(0.8, 0.8, 0.8), roughness=roughness)
        node.distribution = distribution
        return node
    return make


def facing_colour(s):
    return s.add("BsdfDiffuse", color=s.ramp(s.add("LayerWeight", blend=0.4).outputs["Facing"], (0.25, (1.0, 1.0, 1.0)), (0.8, (0.1, 0.1, 0.5))))


def facing_gloss(s):
    factor = s.ramp(s.add("LayerWeight", blend=0.3).outputs["Facing"], (0.1, (0.05,) * 3), (0.9, (0.9,) * 3))
    return s.of_two("MixShader", s.add("BsdfDiffuse", color=BLUE), s.add("BsdfGlossy", color=(1.0, 1.0, 1.0), roughness=0.25), factor)


def rim_light(s):
    factor = s.ramp(s.add("Fresnel", ior=1.3).outputs[0], (0.05, (0.0,) * 3), (0.4, (1.0, 0.6, 0.2)))
    return s.of_two("AddShader", s.add("BsdfDiffuse", color=BLUE), s.add("Emission", color=factor, strength=0.5))


def noise(s):
    return s.tree.nodes.new("ShaderNodeTexNoise").outputs["Fac"]


def bump_only(s):
    s.height = s.add("Displacement", height=noise(s), scale=0.2)
    return s.add("BsdfDiffuse", color=(0.8, 0.8, 0.8))


def bumpy_coat(s):
    return s.add("BsdfPrincipled", base_color=RED, coat=1.0, coat_normal=s.add("Bump", height=noise(s), distance=0.1), roughness=0.6)


def brushed(**inputs):
    """Along the coordinates of the mesh."""
    def make(s):
        tangent = s.tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
        return s.add("BsdfPrincipled", base_color=GOLD, metallic=1.0, tangent=tangent, **inputs)
    return make


def leaf(s):
    """Half of it shines through; both by a texture."""
    stripes = s.ramp(noise(s), (0.4, (0.1, 0.5, 0.05)), (0.6, (0.4, 0.6, 0.1)))
    share = s.add("Value")
    share.outputs[0].default_value = 0.5
    return s.of_two("MixShader", s.add("BsdfDiffuse", color=stripes), s.add("BsdfTranslucent", color=stripes), share)


def subsurface(radius):
    """The BSDF of that name; radii in metres, of spheres of half a metre."""
    return lambda s: s.add("SubsurfaceScattering", color=(0.8, 0.5, 0.4), scale=radius, radius=(1.0, 0.6, 0.4))


MATERIALS = {
    "matte": principled(specular=0.0),
    "default": principled(),
    "plastic .2": principled(BLUE, roughness=0.2),
    "plastic 1": principled(BLUE, roughness=1.0),
    "dark": principled((0.02, 0.02, 0.02), roughness=0.3),
    "saturated": principled((0.9, 0.05, 0.02)),
    "specular .8": principled(BLUE, specular=0.8, roughness=0.3),
    "IOR 1.8": principled(BLUE, ior=1.8, roughness=0.3),
    "specular tint": tinted_specular,
    "gold .1": principled(GOLD, metallic=1.0, roughness=0.1),
    "gold .3": principled(GOLD, metallic=1.0, roughness=0.3),
    "gold .8": principled(GOLD, metallic=1.0, roughness=0.8),
    "white metal 1": principled((1.0, 1.0, 1.0), metallic=1.0, roughness=1.0),
    "single GGX": metal_of("GGX"),
    "multiple GGX": metal_of("MULTI_GGX"),
    "half metal": principled(GOLD, metallic=0.5),
    "coat": principled(RED, coat=1.0),
    "rough coat": principled(RED, coat=1.0, coat_roughness=0.4),
    "glass": principled((1.0, 1.0, 1.0), transmission=1.0, roughness=0.0, ior=1.45),
    "rough glass": principled((1.0, 1.0, 1.0), transmission=1.0, roughness=0.3, ior=1.45),
    "anisotropic": principled(GOLD, metallic=1.0, roughness=0.4, anisotropic=0.8),
    "sheen": principled(RED, sheen=1.0),
    "subsurface": principled((0.8, 0.5, 0.4), subsurface=1.0),
    "diffuse": bsdf("Diffuse", color=(0.8, 0.8, 0.8)),
    "rough diffuse": bsdf("Diffuse", color=(0.8, 0.8, 0.8), roughness=1.0),
    "glossy BSDF": bsdf("Glossy", color=(0.9, 0.9, 0.9), roughness=0.3),
    "rough glossy BSDF": bsdf("Glossy", color=(0.9, 0.9, 0.9), roughness=0.8),
    "anisotropic BSDF": bsdf("Anisotropic", color=(0.9, 0.9, 0.9), roughness=0.4, anisotropy=0.8),
    "glass BSDF": bsdf("Glass", ior=1.45, roughness=0.0),
    "rough glass BSDF": bsdf("Glass", ior=1.45, roughness=0.3),
    "gloss by Fresnel": gloss_by_fresnel,
    "translucent": bsdf("Translucent", color=(0.8, 0.8, 0.8)),
    "curtain": curtain,
    "glowing": glowing,
    "velvet": velvet(1.0),
    "velvet .3": velvet(0.3),
    "microfibres": velvet(0.7, "MICROFIBER"),
    "microfibres .3": velvet(0.3, "MICROFIBER"),
    "cloth": principled(RED, sheen=0.7, sheen_roughness=0.4),
    "tinted sheen": principled(RED, sheen=1.0, sheen_tint=1.0),
    "facing colour": facing_colour,
    "facing gloss": facing_gloss,
    "rim light": rim_light,
    "bump only": bump_only,
    "bumpy coat": bumpy_coat,
    "brushed": brushed(roughness=0.3, anisotropic=0.7),
    "brushed round": brushed(roughness=0.3, anisotropic=1.0, anisotropic_rotation=0.25),
    "brushed plastic": principled(BLUE, roughness=0.4, anisotropic=0.9),
    "leaf": leaf,
    "subsurface .01": subsurface(0.01),
    "subsurface .1": subsurface(0.1),
    "subsurface .5": subsurface(0.5),
    "film": principled((0.02, 0.02, 0.02), roughness=0.2, film=400.0, film_ior=1.8),
    "film on glass": principled((1.0, 1.0, 1.0), transmission=1.0, roughness=0.0, film=300.0),
    "rough Principled": principled(diffuse_roughness=1.0, specular=0.0),
    "coat tint": principled(coat=1.0, coat_tint=(0.9, 0.5, 0.2)),
    "thin film": principled(GOLD, metallic=1.0, roughness=0.3, film=400.0),
    "metallic BSDF": bsdf("Metallic", base_color=GOLD, edge_tint=(1.0, 0.9, 0.7), roughness=0.3),
}


def make_materials(wanted):
    made, absent = [], []
    unknown = [name for name in wanted if name not in MATERIALS]
    if unknown:
        sys.exit("--materials: there is no '%s', but %s" % (unknown[0], ", ".join(MATERIALS)))
    for name in wanted:
        shader = Shader(name)
        try:
            made.append(shader.done(MATERIALS[name](shader)))
        except Absent:
            bpy.data.materials.remove(shader.material)
            absent.append(name)
    if not made:
        sys.exit("--materials: this Blender has none of them")
    return made, absent


def last_added(name, material):
    o = bpy.context.object
    o.name = name
    o.data.materials.append(material)
    return o


def put_spheres(materials, spacing):
    """In rows from the origin upwards; returns their places."""
    places = [(spacing * (i % COLUMNS), 0.0, spacing * (i // COLUMNS)) for i in range(len(materials))]
    for place, material in zip(places, materials):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6, radius=RADIUS, location=place)
        bpy.ops.object.shade_smooth()
        last_added("ball " + material.name, material)
    return places


def put_room(places, spacing):
    """Grey walls around the spheres and the camera's path, and a lamp below the whole ceiling."""
    high = [max(p[i] for p in places) + spacing for i in range(3)]
    low = [min(p[i] for p in places) - spacing for i in range(3)]
    low[1] = -DISTANCE - 1.0
    size, middle = [a - b for a, b in zip(high, low)], [0.5 * (a + b) for a, b in zip(high, low)]
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=middle)
    walls = Shader("wall")
    room = last_added("room", walls.done(walls.add("BsdfDiffuse", color=(0.6, 0.6, 0.6))))
    room.scale = size
    room.data.flip_normals()
    # cut into many faces: near one of two triangles Cycles is 1 to 2 per cent too dark
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=16, y_subdivisions=16, size=1.0, location=(middle[0], middle[1], high[2] - 0.05))
    lamp = Shader("lamp")
    last_added("lamp", lamp.done(lamp.add("Emission", strength=1.5))).scale = (0.7 * size[0], 0.7 * size[1], 1.0)


def put_sun(scene):
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.0, 0.0, (0.7, -0.5, 0.0)
    scene.collection.objects.link(sun)


def put_camera(scene, places, fill):
    """Looks at each sphere in a frame of its own; `fill` of the picture's width is the silhouette's."""
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
    camera.data.angle = 2.0 * math.atan(RADIUS / math.sqrt(DISTANCE * DISTANCE - RADIUS * RADIUS) / fill)
    for i, (x, y, z) in enumerate(places):
        camera.location = (x, y - DISTANCE, z)
        camera.keyframe_insert("location", frame=i + 1)
    scene.frame_start, scene.frame_end = 1, len(places)


def put_world(scene, brightness):
    scene.world = bpy.data.worlds.new("world")
    give_nodes(scene.world)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*(brightness,) * 3, 1.0)
    scene.world.cycles.sampling_method = "NONE"  # scattered rays alone have the least noise in even light


def make(job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_cycles(scene, job)
    made, absent = make_materials(job["materials"] or list(MATERIALS))
    spacing = SPACING[job["light"]]
    places = put_spheres(made, spacing)
    put_world(scene, 1.0 if job["light"] == "even" else 0.0)
    if job["light"] == "room":
        put_room(places, spacing)
    if job["light"] == "sun":
        put_sun(scene)
    put_camera(scene, places, job["fill"])
    bpy.ops.wm.save_as_mainfile(filepath=job["blend"])
    with open(job["made"], "w", encoding="utf-8") as file:
        json.dump({"made": [m.name for m in made], "absent": absent, "version": bpy.app.version_string}, file)


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    make(job)
    write_animations(bpy.context.scene, job["cycles"])


main()
