"""How much light Cycles' limits of bounces and its filter of glossy paths cut: two small renders of a frame, with them and without."""
import os
import shutil
import tempfile

import bpy
import numpy

from .messages import warn

ACROSS, SAMPLES = 64, 32
TRANSPARENT = 64  # surfaces that light passes straight on, in the render without limits
LEAST = 0.02  # of the light, below which nothing is said


def limits_of(cycles):
    """Those that are lower than the number of bounces in all, which is exported, the filter and the clamps, as text."""
    kinds = [("diffuse", cycles.diffuse_bounces), ("glossy", cycles.glossy_bounces), ("transmission", cycles.transmission_bounces)]
    found = ["%d %s" % (count, name) for name, count in kinds if count < cycles.max_bounces]
    found = ["%s bounces of %d" % (", ".join(found), cycles.max_bounces)] if found else []
    if cycles.transparent_max_bounces < 8:  # than at first
        found.append("%d transparent" % cycles.transparent_max_bounces)
    return found + [name for name, value in (("Filter Glossy", cycles.blur_glossy), ("Clamp Direct", cycles.sample_clamp_direct),
                                             ("Clamp Indirect", cycles.sample_clamp_indirect)) if value > 0.0]


class Settings:
    """Properties that are set for a while."""

    def __init__(self):
        self.before = []

    def set(self, owner, **values):
        for name, value in values.items():
            if hasattr(owner, name):
                self.before.append((owner, name, getattr(owner, name)))
                setattr(owner, name, value)

    def restore(self):
        for owner, name, value in reversed(self.before):
            setattr(owner, name, value)


def mean_of(scene, path):
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(path)
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    channels = image.channels
    bpy.data.images.remove(image)
    return float(pixels.reshape(-1, channels)[:, :3].mean())


def light_cut(scene, camera):
    """The part of the light of the present frame that is missing in Blender, of what it has."""
    render, cycles, settings = scene.render, scene.cycles, Settings()
    folder = tempfile.mkdtemp(prefix="reframe-")
    share = 100.0 * ACROSS / max(render.resolution_x, render.resolution_y)
    try:
        settings.set(scene, camera=camera)
        settings.set(render, resolution_percentage=max(int(share + 0.5), 1), use_compositing=False, use_sequencer=False, use_border=False,
                     use_multiview=False, use_motion_blur=False, filepath="", use_file_extension=False, use_freestyle=False)
        settings.set(render.image_settings, media_type="IMAGE")  # of Blender 5, which asks for it first
        settings.set(render.image_settings, file_format="OPEN_EXR", color_depth="32", exr_codec="NONE")
        settings.set(cycles, device="CPU", samples=SAMPLES, use_adaptive_sampling=False, use_denoising=False, seed=0, time_limit=0.0)
        few = mean_of(scene, os.path.join(folder, "few.exr"))
        most = cycles.max_bounces
        settings.set(cycles, diffuse_bounces=most, glossy_bounces=most, transmission_bounces=most, transparent_max_bounces=TRANSPARENT,
                     blur_glossy=0.0, sample_clamp_direct=0.0, sample_clamp_indirect=0.0)
        all_of_it = mean_of(scene, os.path.join(folder, "all.exr"))
    finally:
        settings.restore()
        shutil.rmtree(folder, ignore_errors=True)
    return all_of_it / few - 1.0 if few > 0.0 else 0.0


def tell_limits(scene, camera):
    """Says what the limits cut, where it is a part of the light that is seen."""
    limits = limits_of(scene.cycles) if scene.render.engine == "CYCLES" else []
    if not limits:
        return
    try:
        cut = light_cut(scene, camera)
    except RuntimeError as e:
        warn("light ends by limits in Blender (%s): all of it is here; how much more was not to be measured: %s" %
             (", ".join(limits), " ".join(str(e).split())[:200]))
        return
    if abs(cut) > LEAST:
        warn("light ends by limits in Blender (%s): all of it is here, %.0f %% %s in frame %d" %
             (", ".join(limits), 100.0 * abs(cut), "more" if cut > 0.0 else "less", scene.frame_current))
