"""Shared by the benchmark scripts: timed runs of reframe, and statistics over them."""
import json
import os
import re
import subprocess
import sys

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
NAME = os.path.basename(sys.argv[0])


def fail(text):
    sys.exit("%s: %s" % (NAME, text))


def numbers(text):
    return [int(n) for n in text.split(",")]


def run(command, output=subprocess.DEVNULL, env=None):
    """Runs a child process, with further environment variables; returns its output, CPU seconds (user + system) and peak resident bytes."""
    # waiting threads sleep instead of spinning, which would count as CPU time and disturb others
    child = subprocess.Popen(command, stdout=output, env={**os.environ, "OMP_WAIT_POLICY": "passive", **(env or {})})
    text = child.stdout.read() if output == subprocess.PIPE else None
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        fail("failed: " + " ".join(command))
    return text, usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss


def make_scene(folder, name):
    scene = os.path.join(folder, name + ".glb")
    run([sys.executable, "-B", os.path.join(TOP, "scenes", "make-%s.py" % name), scene])
    return scene


def make_vase_room(folder):
    return make_scene(folder, "vase-room")


def without(options, *names):
    """Options of render without the named ones and their values; render refuses what is given twice."""
    kept, dropping = [], False
    for option in options:
        dropping = option.split("=")[0] in names if option.startswith("--") else dropping
        kept += [] if dropping else [option]
    return kept


def filter_of(words):
    """Figures are those of the box of one pixel unless another filter is asked for: pictures of whatever settings then differ in noise alone."""
    return [] if any(word.split("=")[0] == "--filter" for word in words) else ["--filter", "box"]


def render(binary, scene, pattern, size, setting, spp, seed, frames="", threads=1, more=(), env=None):
    """Renders with GROUP:TILE, without extra samples unless `more` asks for them; returns the output of `render --json` plus `cpu` seconds and `resident` bytes."""
    group, tile = setting.split(":")
    report = pattern.replace("####.exr", "json")
    command = [binary, "render", scene, "-o", pattern, "--size", size, "--group", group, "--tile", tile, "--spp", str(spp),
               "--seed", str(seed), "--float", "--compression", "none", "--overwrite", "--quiet", "--json", report]
    command += [] if any(word.split("=")[0] in ("--adaptive", "--no-adaptive") for word in more) else ["--no-adaptive"]
    command += ["--threads", str(threads)] if threads else []
    command += ["--frames", frames] if frames else []
    _, cpu, resident = run(command + filter_of(more) + list(more), env=env)
    with open(report) as file:
        result = json.load(file)
    result.update(cpu=cpu, resident=resident)
    return result


def count_instructions(binary, scene, folder, *options):
    """Instructions that one thread executes for a render, loading included, counted by callgrind."""
    out = os.path.join(folder, "calls")
    run(["valgrind", "-q", "--tool=callgrind", "--callgrind-out-file=" + out, binary, "render", scene, "-o", os.path.join(folder, "x.exr"),
         "--overwrite", "--quiet", "--threads", "1", "--memory", "256M", *filter_of(options), *options])
    with open(out) as file:
        return int(re.search(r"^(?:summary|totals): (\d+)", file.read(), re.M).group(1))


def measure(binary, command, image, *arguments):
    """The JSON of a command that has the option --json."""
    more = filter_of(arguments) if command in ("plan", "tune", "cost") else []
    text = run([binary, command, image, *more, *arguments, "--json", "-"], subprocess.PIPE)[0]
    return json.loads(text)


def combine(how, runs):
    """Applies `how` (mean, median) to the floats of nested results; other values are taken from the first run."""
    first = runs[0]
    if isinstance(first, dict):
        return {key: combine(how, [r[key] for r in runs]) for key in first}
    if isinstance(first, list):
        return [combine(how, list(items)) for items in zip(*runs)]
    return how(runs) if isinstance(first, float) else first


def frame_of(pattern, frame):
    return pattern.replace("####", "%04d" % frame)


def make_reference(folder, made, keep, make):
    """Calls make() to render the reference that `made` describes, unless an earlier run left it in the folder."""
    note = os.path.join(folder, "reference.txt")
    if keep and os.path.exists(note) and open(note).read() == made:
        print("reference: kept: " + made, flush=True)
        return
    print("reference: " + made, flush=True)
    if os.path.exists(note):
        os.remove(note)
    make()
    with open(note, "w") as file:
        file.write(made)


def reference_share(spp, reference_spp):
    """The fraction of a squared error that is the reference's own, for `spp` samples measured against
    `reference_spp` of the same kind: mean squares are proportional to 1/samples, and those of both add up."""
    return spp / (spp + reference_spp)


def line_through(a, b):
    """Intercept and slope of the line through two points, such as CPU seconds against samples."""
    slope = (b[1] - a[1]) / (b[0] - a[0])
    return a[1] - slope * a[0], slope
