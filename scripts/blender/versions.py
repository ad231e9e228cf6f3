"""What Blender 3 and 4 call differently: found by what a node, a lamp or an operator offers; by version only what no name shows."""
import bpy

PRINCIPLED = {  # sockets of Principled, by the names of Blender 3
    "Specular": "Specular IOR Level", "Emission": "Emission Color", "Clearcoat": "Coat Weight", "Clearcoat Roughness": "Coat Roughness",
    "Transmission": "Transmission Weight", "Sheen": "Sheen Weight", "Subsurface": "Subsurface Weight"}

# How Cycles' lamps radiate, measured with 3.4.1 and 4.3.2: area lamps radiate all of their watts, once pi/4 of them; spots do not
# fall off with the cosine, and their cone is scaled with them.
IS_4 = bpy.app.version >= (4, 0, 0)


def socket(node, name):
    """An input of a Principled node, by the name that Blender 3 has for it."""
    found = node.inputs.get(PRINCIPLED.get(name, name))
    return found if found is not None else node.inputs[name]


def is_principled_2(node):
    """Is it the layered model of Blender 4?"""
    return "Specular IOR Level" in node.inputs


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
