"""What versions of Blender from 3.4 on call differently: found by what a node, a lamp or an operator offers; by version only what no
name shows.
"""
import bpy

TRIED = (5, 2)  # the newest version known here; later ones are tried, and that is said

PRINCIPLED = {  # sockets of Principled, by the names of Blender 3
    "Specular": "Specular IOR Level", "Emission": "Emission Color", "Clearcoat": "Coat Weight", "Clearcoat Roughness": "Coat Roughness",
    "Transmission": "Transmission Weight", "Sheen": "Sheen Weight", "Subsurface": "Subsurface Weight"}

# How Cycles' lamps radiate, measured with 3.4.1 and 4.3.2: area lamps radiate all of their watts, once pi/4 of them; spots do not
# fall off with the cosine, and their cone is scaled with them.
IS_4 = bpy.app.version >= (4, 0, 0)

# Does Cycles interpolate tables of IES files beyond their ends as if they went on there? Blender 4 takes zeros, which makes a lamp that
# is the same all round 8 % brighter in the mean (13/12: measured with 4.5.15, 5.0.0, 5.2.3).
CLOSES_TABLES = not IS_4 or bpy.app.version >= (5, 0, 0)


def socket(node, name):
    """An input of a Principled node, by the name that Blender 3 has for it."""
    found = node.inputs.get(PRINCIPLED.get(name, name))
    return found if found is not None else node.inputs[name]


def is_principled_2(node):
    """Is it the layered model of Blender 4?"""
    return "Specular IOR Level" in node.inputs


def has_nodes(block):
    """Does a material, a world or a lamp look as its nodes say? Blender 5 has no switch for it but for lamps."""
    switch = block.bl_rna.properties.get("use_nodes")
    is_on = switch is None or getattr(switch, "is_deprecated", False) or block.use_nodes
    return is_on and block.node_tree is not None


def give_nodes(block):
    if not has_nodes(block):
        block.use_nodes = True


def principled_of(tree):
    """The Principled node of a new material."""
    node = next((n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    if node is None:
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        out = next((n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"), None) or tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], out.inputs["Surface"])
    return node


def mixed_inputs(node):
    """The two inputs of a Mix or Math node that it mixes or multiplies, by its type of data."""
    if node.type != "MIX":
        return list(node.inputs[0:2])
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type, "")
    return [s for s in node.inputs if s.identifier in ("A_" + kind, "B_" + kind)]


def curve_lists(holder):
    """The lists of F-curves by which animation data or a strip of it move a data-block: those of the action; where actions have slots
    (from Blender 4.4 on), those of its slot in all the strips of the action's layers."""
    action = holder.action
    if action is None:
        return []
    if not hasattr(holder, "action_slot"):
        return [action.fcurves]
    slot = holder.action_slot
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips] if slot is not None else []
    return [bag.fcurves for bag in bags if bag is not None]


def compositor_of(scene):
    """The compositor's nodes that change pictures, or None."""
    if hasattr(scene, "compositing_node_group"):
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def has_strips(scene):
    """Has the sequencer strips?"""
    editor = scene.sequence_editor
    return editor is not None and len(editor.strips if hasattr(editor, "strips") else editor.sequences) > 0


def adaptive_of(scene, o, modifier):
    """Is adaptive subdivision on for the last modifier of an object? Once an experimental feature of Cycles."""
    if hasattr(modifier, "use_adaptive_subdivision"):
        return modifier.use_adaptive_subdivision
    return scene.cycles.feature_set == "EXPERIMENTAL" and o.cycles.use_adaptive_subdivision


def has_sun_by_angles(node):
    """Is a sky texture of a model that knows the sun's elevation and rotation, not a direction?"""
    return node.sky_type in ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")


def shadow_offset_of(o):
    """How far Cycles moves the origins of shadow rays off coarse faces."""
    return (o if hasattr(o, "shadow_terminator_geometry_offset") else o.cycles).shadow_terminator_geometry_offset


def set_format(settings, file_format):
    """Of the files of renders; Blender 5 asks first for their medium."""
    if hasattr(settings, "media_type"):
        settings.media_type = {"OPEN_EXR_MULTILAYER": "MULTI_LAYER_IMAGE", "FFMPEG": "VIDEO"}.get(file_format, "IMAGE")
    settings.file_format = file_format


def panorama_of(camera):
    """What has the properties of a panorama."""
    return camera if hasattr(camera, "panorama_type") else camera.cycles


def is_eevee(engine):
    return engine.startswith("BLENDER_EEVEE")


def throws_shadow(lamp, engine):
    if is_eevee(engine) or not hasattr(lamp.cycles, "cast_shadow"):
        return lamp.use_shadow
    return lamp.cycles.cast_shadow


def has_transparent_shadow(material):
    return material.use_transparent_shadow if hasattr(material, "use_transparent_shadow") else material.cycles.use_transparent_shadow


def motion_blur_of(scene):
    """Is there motion blur, for how many frames the shutter is open, and where in that time the frame is."""
    render = scene.render
    own = scene.eevee if is_eevee(render.engine) and hasattr(scene.eevee, "use_motion_blur") else render
    if hasattr(own, "motion_blur_position"):
        position = own.motion_blur_position
    else:
        position = scene.cycles.motion_blur_position if render.engine == "CYCLES" else "CENTER"
    return own.use_motion_blur, own.motion_blur_shutter, position


def children_of(particles):
    """The setting of the number of children in the viewport."""
    return "child_percent" if hasattr(particles, "child_percent") else "child_nbr"


def offered(operator, **options):
    """Those of some options that an operator has."""
    names = operator.get_rna_type().properties.keys()
    return {name: value for name, value in options.items() if name in names}
