"""Effects of the camera and the world that Reframe does not have."""
from .messages import warn


def warn_of_effects(scene, camera):
    if camera.data.dof.use_dof:
        warn("'%s' has depth of field: Reframe's cameras are sharp everywhere" % camera.name)
    if scene.render.use_border and scene.render.use_crop_to_border:
        warn("the render region is ignored: the whole picture is exported")
    if scene.render.use_motion_blur or scene.eevee.use_motion_blur:
        warn("motion blur is on: Reframe renders without it")
    out = scene.world.node_tree.get_output_node("CYCLES") if scene.world is not None and scene.world.use_nodes else None
    if out is not None and out.inputs["Volume"].is_linked:
        warn("world '%s' has a volume: left out" % scene.world.name)
