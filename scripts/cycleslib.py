"""Shared by the scripts that compare with Blender's Cycles."""
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
