"""What a compositor tells things apart by: light groups, names for Cryptomatte, indices; and which options of `reframe render` give the
passes of the view layer.

A custom property of objects and materials holds it, which what replaces them inherits, and the .glb gets it from there.
"""
import bpy

from .messages import note, warn
from .moves import GEOMETRY

TAG = "reframe passes"
AOVS = {"use_pass_z": "depth", "use_pass_normal": "normal", "use_pass_vector": "motion", "use_pass_emit": "emission",
        "use_pass_object_index": "object_index", "use_pass_material_index": "material_index"}
MATTES = {"use_pass_cryptomatte_object": "object", "use_pass_cryptomatte_material": "material", "use_pass_cryptomatte_asset": "asset"}
LEVELS = 6  # of Cryptomatte
PASS_NAMES = "blender5" if bpy.app.version >= (5, 0, 0) else "blender"  # of `reframe render --names`: as this Blender calls passes
CODECS = ("NONE", "ZIPS", "PIZ", "DWAA", "DWAB")  # beside ZIP, which is ours as well
NO_PASSES = ("use_pass_combined", "use_pass_cryptomatte_accurate")

_groups = set()  # names of the light groups of the view layer: Blender ignores others
_sky = None  # the world's
_is_grouped = False  # is anything in one of them?


def group_of(o):
    """Its light group; commas separate names for Reframe."""
    return o.lightgroup.replace(",", ";") if o is not None and o.lightgroup in _groups else ""


def asset_of(o):
    """Cycles' Cryptomatte of assets has the name of the top-most parent; of an instance that of the object which is seen."""
    while o.parent is not None:
        o = o.parent
    return o.name


def begin(scene):
    """Called before anything is replaced."""
    global _sky, _is_grouped
    _groups.update(group.name for group in bpy.context.view_layer.lightgroups)
    _sky = group_of(scene.world)
    _is_grouped = bool(_sky) or any(group_of(o) for o in bpy.context.view_layer.objects)
    for material in bpy.data.materials:
        material[TAG] = {"material": material.name, "pass_index": material.pass_index}
    for o in [o for o in bpy.data.objects if o.type in GEOMETRY or o.type == "LIGHT"]:
        o[TAG] = {"object": o.name, "asset": asset_of(o), "pass_index": o.pass_index, "light_group": group_of(o)}


def taken(item):
    """The tag of an item of the .glb, which is removed."""
    tag = item.get("extras", {}).pop(TAG, {})
    if not item.get("extras", True):
        del item["extras"]
    return tag


def put(item, values):
    """What is not empty goes into the extras that Reframe reads."""
    values = {key: value for key, value in values.items() if value}
    if values:
        extras = item.setdefault("extras", {})
        extras["reframe"] = {**extras.get("reframe", {}), **values}


def write_nodes(gltf):
    """Before nodes are copied."""
    for node in gltf.get("nodes", []):
        tag = taken(node)
        put(node, {"light_group": tag.get("light_group")})
        if "mesh" in node:
            name, asset = tag.get("object", node.get("name")), tag.get("asset")
            put(node, {"pass_index": tag.get("pass_index"), "object": name if name != node.get("name") else None,
                       "asset": asset if asset != name else None})


def write_rest(gltf, own):
    """When nothing is found by the names of materials any more; `own` are the extras of the scene."""
    for material in gltf.get("materials", []):
        tag = taken(material)
        material["name"] = tag.get("material", material.get("name"))  # of parts of one as well: the name is what a matte is picked by
        put(material, {"pass_index": tag.get("pass_index")})
    if _sky and "environment" in own:
        own["environment"]["light_group"] = _sky


def words_of(owner, prefixes, but):
    """The names of the passes that are switched on."""
    return [p.name for p in owner.bl_rna.properties if p.identifier.startswith(prefixes) and p.type == "BOOLEAN" and
            p.identifier not in but and getattr(owner, p.identifier)]


def tell(scene):
    """Which options give the passes of the view layer and the kind of its files, and which passes there are none of."""
    layer, options = bpy.context.view_layer, []
    aovs = [name for key, name in AOVS.items() if getattr(layer, key)]
    if layer.cycles.denoising_store_passes:
        aovs += ["denoise_albedo", "denoise_normal"]
    mattes = [name for key, name in MATTES.items() if getattr(layer, key)]
    if aovs:
        options.append("--aov " + ",".join(aovs))
    if mattes:
        options.append("--cryptomatte " + ",".join(mattes))
        if layer.pass_cryptomatte_depth > LEVELS:
            warn("Cryptomatte of '%s': %d levels here, not %d" % (layer.name, LEVELS, layer.pass_cryptomatte_depth))
    if _is_grouped:
        options.append("--light-groups all")
        if any("," in name for name in _groups):
            warn("light groups of '%s': commas in their names become semicolons" % layer.name)
    settings = scene.render.image_settings
    if options and settings.file_format in ("OPEN_EXR", "OPEN_EXR_MULTILAYER"):
        is_deep, is_lossy = settings.color_depth == "32", settings.exr_codec.startswith("DWA")
        options += ["--float"] if is_deep and not is_lossy else []
        if is_deep and is_lossy:
            warn("files of '%s': colours that %s compresses have 16 bits" % (scene.name, settings.exr_codec))
        options += ["--compression " + settings.exr_codec.lower()] if settings.exr_codec in CODECS else []
    if options:
        note("passes of '%s': %s --names %s" % (layer.name, " ".join(options), PASS_NAMES))
    lost = words_of(layer, "use_pass_", {*AOVS, *MATTES, *NO_PASSES}) + words_of(layer.cycles, ("use_pass_", "pass_"), ())
    lost += ["'%s'" % aov.name for aov in layer.aovs]
    if lost:
        warn("passes of '%s' that are not rendered here: %s" % (layer.name, ", ".join(lost)))
