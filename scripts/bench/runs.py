"""Runs of reframe and Blender for the scripts that measure: timed renders, the JSON of other commands, scenes, and .glb files as JSON."""
import json
import os
import re
import struct
import subprocess
import sys

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.join(TOP, "build", "reframe")
BLENDER = os.path.join(TOP, "scripts", "blender")
PLAIN = "0:1"  # GROUP:TILE of path tracing
SPOT_CONE = 0.1  # radians: its mean cosine is 0.9975
ADAPTIVE = ("--adaptive", "--no-adaptive")


def fail(text):
    sys.exit("%s: %s" % (os.path.basename(sys.argv[0]), text))


def numbers(text):
    return [int(n) for n in text.split(",")]


def run(command, output=subprocess.DEVNULL, env=None):
    """Runs a child process; returns its output, CPU seconds (user + system) and peak resident bytes."""
    # waiting threads sleep instead of spinning, which would count as CPU time
    child = subprocess.Popen(command, stdout=output, env={**os.environ, "OMP_WAIT_POLICY": "passive", **(env or {})})
    text = child.stdout.read() if output == subprocess.PIPE else None
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        fail("failed: " + " ".join(command))
    return text, usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss


def make_scene(folder, name, *options):
    """Generates a scene of the project; NAME may be a file, too."""
    if os.path.exists(name):
        return name
    scene = os.path.join(folder, "-".join([name, *(o.strip("-") for o in options)]) + ".glb")
    run([sys.executable, "-B", os.path.join(TOP, "scenes", "make-%s.py" % name), scene, *options])
    return scene


def write_scene_file(folder, name, base, **more):
    """A scene file that adds to a .glb, or to another scene file; returns its path."""
    with open(base, "rb") as file:
        told = json.load(file) if base.endswith(".json") else {"scene": base}
    beside = os.path.dirname(os.path.abspath(base))
    told["scene"] = os.path.join(beside, os.path.abspath(told["scene"]) if not base.endswith(".json") else told["scene"])
    if "map" in told.get("environment", {}):
        told["environment"]["map"] = os.path.join(beside, told["environment"]["map"])
    path = os.path.join(folder, name + ".json")
    with open(path, "w") as file:
        json.dump({**told, **more}, file, indent=1)
    return path


def without(options, *names):
    """Options of render without the named ones and their values; render refuses what is given twice."""
    kept, dropping = [], False
    for option in options:
        dropping = option.split("=")[0] in names if option.startswith("--") else dropping
        kept += [] if dropping else [option]
    return kept


def render(binary, scene, pattern, size, setting, spp, seed, frames="", threads=1, more=(), env=None):
    """Renders with GROUP:TILE, without extra samples unless `more` asks for them; returns the output of `render --json` plus
    `cpu` seconds and `resident` bytes. threads 0: all."""
    group, tile = setting.split(":")
    report = pattern.replace("####.exr", "json")
    command = [binary, "render", scene, "-o", pattern, "--size", size, "--group", group, "--tile", tile, "--spp", str(spp),
               "--seed", str(seed), "--float", "--compression", "none", "--overwrite", "--quiet", "--json", report]
    command += [] if any(word.split("=")[0] in ADAPTIVE for word in more) else ["--no-adaptive"]
    command += ["--threads", str(threads)] if threads else []
    command += ["--frames", frames] if frames else []
    _, cpu, resident = run([*command, *more], env=env)
    with open(report) as file:
        result = json.load(file)
    result.update(cpu=cpu, resident=resident)
    return result


def ask(binary, command, *words):
    """The JSON that a command prints."""
    return json.loads(run([binary, command, *words, "--json", "-"], subprocess.PIPE)[0])


def count_instructions(binary, scene, folder, *options):
    """Instructions of rf_render by one thread, loading left out, counted by callgrind."""
    out = os.path.join(folder, "calls")
    run(["valgrind", "-q", "--tool=callgrind", "--toggle-collect=rf_render", "--toggle-collect=rf_check_built", "--callgrind-out-file=" + out,
         binary, "render", scene, "-o", os.path.join(folder, "x.exr"), "--overwrite", "--quiet", "--threads", "1", "--memory", "256M", *options])
    with open(out) as file:
        return int(re.search(r"^(?:summary|totals): (\d+)", file.read(), re.M).group(1))


def frame_of(pattern, frame):
    return pattern.replace("####", "%04d" % frame)


def make_reference(folder, made, make):
    """Calls make() to render the reference that `made` describes, unless an earlier run left it in the folder."""
    note = os.path.join(folder, "reference.txt")
    if os.path.exists(note) and open(note).read() == made:
        print("reference: kept: " + made, file=sys.stderr, flush=True)
        return
    print("reference: " + made, file=sys.stderr, flush=True)
    if os.path.exists(note):
        os.remove(note)
    make()
    with open(note, "w") as file:
        file.write(made)


def read_glb(path):
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        fail("%s: is no .glb file" % path)
    length = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + length]), data[20 + length:]


def write_glb(path, gltf, rest):
    text = json.dumps(gltf).encode("utf-8")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest)


def animate(gltf, rest, target, times, rows):
    """Adds a channel of linear keys to the first animation; returns the binary part, which its numbers are added to."""
    accessors = []
    for values in ([(t,) for t in times], rows):
        kind = {1: "SCALAR", 3: "VEC3"}[len(values[0])]
        rest += b"\0" * (-len(rest) % 4)
        data = struct.pack("<%df" % (len(values) * len(values[0])), *(x for row in values for x in row))
        gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(rest) - 8, "byteLength": len(data)})
        rest += data
        gltf["accessors"].append({"bufferView": len(gltf["bufferViews"]) - 1, "componentType": 5126, "count": len(values), "type": kind,
                                  "min": [min(column) for column in zip(*values)], "max": [max(column) for column in zip(*values)]})
        accessors.append(len(gltf["accessors"]) - 1)
    animation = gltf["animations"][0]
    animation["samplers"].append({"input": accessors[0], "output": accessors[1]})
    animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})
    gltf["buffers"][0]["byteLength"] = len(rest) - 8
    return struct.pack("<I", len(rest) - 8) + rest[4:]


def beside_blender():
    """The environment of programs beside Debian's Blender, which looks for its Python modules beside the first python3 in PATH."""
    return {**os.environ, "PATH": os.pathsep.join(["/usr/bin", os.environ.get("PATH", "")]), "OMP_WAIT_POLICY": "passive"}


def in_blender(blender, script, *words, blend=None):
    """The command that runs a script inside Blender (a program, or a Python with bpy), in a .blend or an empty scene."""
    return [sys.executable, "-B", os.path.join(BLENDER, "run"), "--with", blender, "-b", "--factory-startup", *([blend] if blend else []), "--python-exit-code", "1", "-P", script, "--", *words]


def run_quietly(command):
    """Runs a program without its output, which is printed if it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=beside_blender(), check=False)
    if done.returncode != 0:
        fail("failed: %s\n%s" % (" ".join(command), done.stdout.decode(errors="replace")))
    return done.stdout.decode(errors="replace")


def run_in_blender(blender, script, job, base):
    with open(base + ".job.json", "w", encoding="utf-8") as file:
        json.dump(job, file)
    run_quietly(in_blender(blender, os.path.join(BLENDER, script), base + ".job.json"))


def make_equal(source, made):
    """A copy of the .glb, simplified to what both renderers treat alike: materials that are neither metal nor glass become Lambert
    (Cycles' Fresnel mix conserves energy differently), clear coats go, glass absorbs nothing, and spots get a narrow cone with a
    hard edge (within the cone, Cycles' spots fall off with the cosine, glTF's are uniform)."""
    gltf, rest = read_glb(source)
    for material in gltf.get("materials", []):
        extensions = material.setdefault("extensions", {})
        extensions.pop("KHR_materials_clearcoat", None)
        if "KHR_materials_volume" in extensions:
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
        if material.get("pbrMetallicRoughness", {}).get("metallicFactor", 1.0) == 0.0 and "KHR_materials_transmission" not in extensions:
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    sky = os.path.splitext(source)[0] + "-sky.hdr"
    if os.path.exists(sky):
        gltf["scenes"][0]["extras"] = {"reframe": {"environment": {"map": os.path.basename(sky)}}}
    gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "KHR_materials_specular"})
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        if light["type"] == "spot":
            light["spot"] = {"innerConeAngle": SPOT_CONE - 1e-4, "outerConeAngle": SPOT_CONE}
    write_glb(made, gltf, rest)
