"""Shared by the scripts that compare with Blender's Cycles, and by their Blender sides."""
import math
import os
import statistics
import subprocess

import benchlib


def run(command):
    """Runs a program without its output, which is printed if it fails."""
    # Debian's Blender looks for its Python modules beside the first python3 in PATH
    path = os.pathsep.join(["/usr/bin", os.environ.get("PATH", "")])
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=dict(os.environ, PATH=path, OMP_WAIT_POLICY="passive"))
    if done.returncode != 0:
        benchlib.fail("failed: %s\n%s" % (" ".join(command), done.stdout.decode(errors="replace")))
    return done.stdout.decode(errors="replace")


def ratio_of(ours, theirs):
    """The ratio of the means over independent seeds, and its standard error by their scatter."""
    a, b = statistics.mean(ours), statistics.mean(theirs)
    if b <= 0.0:
        return math.inf, 0.0
    squares = [statistics.variance(v) / len(v) for v in (ours, theirs)]
    return a / b, (squares[0] + (a / b) ** 2 * squares[1]) ** 0.5 / b


def verdict_of(ratio, error, limit):
    """Whether two standard errors on either side of the ratio are entirely within the limit about 1, or outside it."""
    off = abs(ratio - 1.0)
    return "within" if off + 2.0 * error <= limit else "outside" if off - 2.0 * error > limit else "undecided"


def set_cycles(scene, job):
    """Cycles as Reframe renders: unclamped, all caustics, a box filter, and linear pixels. Runs in Blender."""
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"
    cycles.device, cycles.samples, cycles.pixel_filter_type = "CPU", job["samples"], "BOX"
    cycles.filter_width = 1.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = job["bounces"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = 0.0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
