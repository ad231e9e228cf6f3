"""`bench/run rivals`: the same animation by other renderers as people use them, at equal CPU seconds."""
import glob
import json
import os
import re
import shutil
import subprocess

import budget
import numpy as np
import pictures
import runs

BOUNCES = 10  # Reframe counts vertices after the camera: two more
DEPTH = BOUNCES + 2
HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = os.path.expanduser("~/.cache/reframe/rivals/bin/python")
DISPLAY = "standard_fhd"
GREY = 0.18  # the median brightness of a reference, on the display
AGREE = 0.01
COLUMNS = ["scene, renderer", "samples", "start-up", "CPU s a frame", "mean", "relMSE", "efficiency", "sRGB", "F1, %", "JOD"]
TEXT = ("Frames %s of %s, box filter, %d bounces, %d seeds, one thread; each renderer has the CPU seconds of Reframe's groups with `--spp %d`, start-up apart: process, loading and a "
        "frame of one sample (of LuxCore also what it builds for each frame). Simplified to what all treat alike: materials are Lambert with their textures of colour, perfect mirrors that reflect all, or clear smooth glass; no gloss, "
        "relief, masks, textures of emission. *Cycles* (Blender %s) samples adaptively, *denoised* by OIDN; *LuxCore* %s is its path tracer with Sobol numbers, *Mitsuba* %s its path tracer, variant %s; "
        "other settings are their defaults, random numbers change from frame to frame. Each is judged against its own reference of about %d times its samples, whose own error is subtracted, but not in JOD; of "
        "Reframe against 8:3x3 with %d times `--spp`. *Mean*: of the reference over Reframe's. *sRGB*: root mean square error of the values of a display, with %.2g as median brightness. *F1*: relative "
        "flicker in place. *JOD*: ColorVideoVDP, display %s, by which 10 is no difference.")
KEPT = ("KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_volume")


def simplify(source, folder):
    """A copy with materials that all treat alike, and the sky beside it; its path."""
    sky = None
    if source.endswith(".json"):
        with open(source, encoding="utf-8") as file:
            told = json.load(file)
        sky = told.get("environment", {}).get("map")
        if set(told) - {"scene", "environment"} or set(told.get("environment", {})) - {"map"}:
            runs.fail("%s: rivals get no more of a scene file than its .glb and the map of its sky" % source)
        sky, source = (name and os.path.join(os.path.dirname(os.path.abspath(source)), name) for name in (sky, told["scene"]))
    gltf, rest = runs.read_glb(source)
    if "KHR_lights_punctual" in gltf.get("extensions", {}):
        runs.fail("%s: has point lights, which rivals do not get" % source)
    for material in gltf["materials"]:
        base, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
        glass = "KHR_materials_transmission" in extensions
        mirror = not glass and base.get("metallicFactor", 1.0) >= 0.5 and base.get("roughnessFactor", 1.0) < 0.04
        color = {} if glass or mirror else {key: base[key] for key in ("baseColorFactor", "baseColorTexture") if key in base}
        if "baseColorTexture" in color:
            color["baseColorFactor"] = [1.0] * 4
        kept = {name: extensions[name] for name in KEPT[:2] if name in extensions}
        kept.update({KEPT[3]: {"transmissionFactor": 1.0}, KEPT[4]: {"thicknessFactor": 1.0}} if glass else {} if mirror else {KEPT[2]: {"specularFactor": 0.0}})
        name, emission, sides = material.get("name"), material.get("emissiveFactor", [0.0] * 3), material.get("doubleSided", False)
        material.clear()
        material.update(name=name, emissiveFactor=emission, doubleSided=sides and not any(emission), extensions=kept, pbrMetallicRoughness={
            "baseColorFactor": [1.0] * 4, **color, "metallicFactor": float(mirror), "roughnessFactor": 0.0 if glass or mirror else 1.0})
    gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), *KEPT})
    for scene in gltf["scenes"]:
        scene["extras"] = {"reframe": {"environment": {"map": os.path.basename(sky)}}} if sky else {}
    if sky:
        shutil.copyfile(sky, os.path.join(folder, os.path.basename(sky)))
    path = os.path.join(folder, "scene.glb")
    runs.write_glb(path, gltf, rest)
    return path


def says(*command):
    """What a program prints, or None where it cannot be had."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    except OSError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def find(args, say):
    """Versions of the rivals by names; those that are missing are told."""
    version = says(args.blender, "-c", "import bpy; print(bpy.app.version_string)") if "python" in os.path.basename(args.blender) else says(args.blender, "--version")
    found = {"Cycles": version and re.search(r"\d+\.[\d.]+", version).group(0)}
    for name, package in (("LuxCore", "pyluxcore"), ("Mitsuba", "mitsuba"), ("JOD", "cvvdp")):
        found[name] = says(args.rivals, "-c", "import numpy, PIL; from importlib.metadata import version; print(version('%s'))" % package)
    if found["Mitsuba"]:  # which aborts with an LLVM that is too old: $DRJIT_LIBLLVM_PATH names another
        found["variant"] = "llvm_ad_rgb" if says(args.rivals, "-c", "import mitsuba as mi; mi.set_variant('llvm_ad_rgb'); mi.render(mi.load_dict({'type': 'scene', 'i': {'type': 'path'}, 'e': {'type': 'constant'}, 's': {'type': 'sphere'}}), spp=1).numpy()") is not None else "scalar_rgb"
    for name, package in (("Cycles", "Blender 5, by --blender"), ("LuxCore", "pyluxcore"), ("Mitsuba", "mitsuba"), ("JOD", "cvvdp")):
        if found[name] is None:
            say("skipped: %s: there is no %s%s" % (name, package, "" if name == "Cycles" else " with numpy and pillow in %s" % args.rivals))
    return {name: told for name, told in found.items() if told}


def work(args, job, base):
    """Runs rival.py; returns its result."""
    job["result"] = base + ".result.json"
    with open(base + ".job.json", "w", encoding="utf-8") as file:
        json.dump(job, file)
    runs.run_quietly([args.rivals, os.path.join(HERE, "rival.py"), base + ".job.json"])
    with open(job["result"], encoding="utf-8") as file:
        return json.load(file)


class Shot:
    """An animation of a simplified scene, and who renders it."""
    def __init__(self, args, found, name, source, size, frames, say):
        self.args, self.found, self.name, self.size, self.frames, self.say = args, found, name, size, frames, say
        self.folder = os.path.join(args.out, "rivals-" + name)
        os.makedirs(self.folder, exist_ok=True)
        self.scene = simplify(source, self.folder)
        first, last = runs.numbers(frames.replace("-", ","))
        self.listed = list(range(first, last + 1))
        self.startup = self.by_reframe("startup", runs.PLAIN, 1, 1, frames=str(first))["cpu"]

    def by_reframe(self, label, setting, samples, seed, threads=1, more=(), frames=None):
        done = runs.render(self.args.binary, self.scene, os.path.join(self.folder, label + ".####.exr"), self.size, setting, samples, seed, frames or self.frames, threads,
                           ["--filter", "box", "--max-depth", str(DEPTH), *([] if setting == runs.PLAIN else ["--adaptive=auto"]), *more, *self.args.options])
        self.say("%s, Reframe, %s, %d samples, seed %d: %.1f CPU s" % (self.name, label, samples, seed, done["cpu"]))
        return done

    def load(self, pattern):
        paths = [runs.frame_of(pattern, f) for f in self.listed]
        return np.stack([pictures.read(p) if p.endswith(".exr") else np.load(p) for p in paths])

    def reframe(self, seconds, setting, samples, seeds, more=()):
        """A row; samples 0: those that fit."""
        def took(n):
            return self.by_reframe("try", setting, n, 1, more=more)["cpu"] - self.startup
        samples, made, cpu = samples or budget.samples_for(seconds, took, 3), [], []
        for seed in seeds:
            done = self.by_reframe("picture", setting, samples, seed, more=more)
            cpu.append(done["cpu"] - self.startup)
            made.append(self.load(os.path.join(self.folder, "picture.####.exr")))
        return {"samples": done["frames"][len(self.listed) // 2]["native_spp"], "startup": self.startup, "cpu": np.mean(cpu), "pictures": made}

    def rival(self, who, label, seeds, threads=1, **more):
        """A row of another renderer: `samples`, or `seconds` of the whole shot."""
        base = os.path.join(self.folder, label)
        suffix = "exr" if who == "Cycles" else "npy"
        job = {"renderer": who.lower(), "scene": self.scene, "size": runs.numbers(self.size.replace("x", ",")), "depth": DEPTH, "bounces": BOUNCES, "threads": threads,
               "variant": self.found.get("variant"), "frames": self.listed, "adaptive": False, "denoise": False, **more,
               "runs": [{"seed": seed, "pattern": "%s.%d.####.%s" % (base, seed, suffix)} for seed in seeds]}
        if "seconds" in job:
            job["seconds"] /= len(self.listed)
        if who == "Cycles":
            job["result"] = base + ".result.json"
            runs.run_in_blender(self.args.blender, "cycles.py", job, base)
            with open(job["result"], encoding="utf-8") as file:
                result = json.load(file)
        else:
            result = work(self.args, job, base)
        self.say("%s, %s, %d samples: %.1f CPU s" % (self.name, label, result["samples"], np.mean(result["cpu"])))
        return {**result, "cpu": np.mean(result["cpu"]), "pictures": [self.load(run["pattern"]) for run in job["runs"]]}

    def reference(self, who, samples):
        """Both halves of the converged animation of a renderer; kept."""
        folder, seeds = os.path.join(self.folder, "reference-" + who), (9001, 9002)
        os.makedirs(folder, exist_ok=True)

        def make():
            for path in glob.glob(os.path.join(folder, "*.npy")):
                os.remove(path)
            if who == "Reframe":
                made = []
                for seed in seeds:
                    self.by_reframe("reference", "8:3x3", samples // 2, seed, 0)
                    made.append(self.load(os.path.join(self.folder, "reference.####.exr")))
            else:
                made = self.rival(who, "reference-" + who, seeds, os.cpu_count(), samples=samples // 2)["pictures"]
            np.save(os.path.join(folder, "halves.npy"), np.stack(made))

        kept = os.path.join(folder, "reference.txt")
        if os.path.exists(kept):  # samples that fit into seconds differ a little from run to run
            before = re.search(r" (\d+) samples", open(kept, encoding="utf-8").read())
            samples = int(before.group(1)) if before and 0.5 * samples < int(before.group(1)) < 4.0 * samples else samples
        runs.make_reference(folder, " ".join([who, self.found.get(who, ""), self.name, self.size, self.frames, "%d samples" % samples, *(self.args.options if who == "Reframe" else [])]), make)
        return np.load(os.path.join(folder, "halves.npy"))


def figures(seen, halves, stops):
    """relMSE, error of sRGB values and relative F1 in percent, without the reference's own."""
    reference, own = halves.mean(0), (halves[0] - halves[1]) / 2
    below, light = pictures.denominators(reference), 2.0 ** stops
    relmse = np.mean([pictures.squares(p - reference) / below for p in seen]) - (pictures.squares(own) / below).mean()
    shown = [pictures.srgb(p * light) for p in (reference, *halves)]
    on_display = np.mean([(pictures.srgb(p * light) - shown[0]) ** 2 for p in seen]) - ((shown[1] - shown[2]) ** 2).mean() / 4
    flicker = np.mean([pictures.relative_f1_squared(p - reference, below) for p in seen]) - pictures.relative_f1_squared(own, below)
    return {"relmse": relmse, "srgb": max(on_display, 0.0) ** 0.5, "f1": 100 * max(flicker, 0.0) ** 0.5}


def judge(args, shot, rows, halves, stops):
    """JOD of each row, in the mean of its seeds."""
    pairs = []
    for number, (label, row) in enumerate(rows.items()):
        for seed, picture in enumerate(row["pictures"]):
            paths = [os.path.join(shot.folder, "shown.%d.%d.%s.npy" % (number, seed, what)) for what in ("test", "reference")]
            for path, made in zip(paths, (picture, halves[label.split(",")[0]].mean(0))):
                np.save(path, pictures.srgb(made * 2.0 ** stops).astype(np.float32))
            pairs.append(paths)
    jod = work(args, {"renderer": "cvvdp", "threads": 1, "display": DISPLAY, "pairs": pairs}, os.path.join(shot.folder, "cvvdp"))["jod"]
    return np.array(jod).reshape(len(rows), -1).mean(1)


def ranks(values):
    return np.argsort(np.argsort(values))


def measure(args, found, name, source, size, frames, spp, factor, seeds, table, measured, say):
    """The rows of a scene."""
    shot, rows, halves = Shot(args, found, name, source, size, frames, say), {}, {}
    groups = shot.reframe(0, args.settings or "auto:auto", spp, seeds)
    seconds, halves["Reframe"] = groups["cpu"], shot.reference("Reframe", factor * spp)
    if "Mitsuba" in found:
        rows["Mitsuba"] = shot.rival("Mitsuba", "Mitsuba", seeds, seconds=seconds)
        halves["Mitsuba"] = shot.reference("Mitsuba", factor * rows["Mitsuba"]["samples"])
        means = [halves[who].mean(axis=(1, 2, 3, 4)) for who in ("Mitsuba", "Reframe")]
        ratio, error = means[0].mean() / means[1].mean(), sum((np.ptp(m) / 2 / m.mean()) ** 2 for m in means) ** 0.5
        say("%s: mean of Mitsuba over that of Reframe: %.4f +- %.4f" % (name, ratio, error))
        if abs(ratio - 1.0) > AGREE + 2.0 * error:
            table.text += " %s: left out, since Mitsuba's mean is %.4f of Reframe's." % (name, ratio)
            return
    if "LuxCore" in found:
        rows["LuxCore"] = shot.rival("LuxCore", "LuxCore", seeds, seconds=seconds)
        halves["LuxCore"] = shot.reference("LuxCore", factor * rows["LuxCore"]["samples"])
    if "Cycles" in found:
        for label, denoise in (("Cycles", False), ("Cycles, denoised", True)):
            rows[label] = shot.rival("Cycles", label, seeds, seconds=seconds, adaptive=True, denoise=denoise)
        halves["Cycles"] = shot.reference("Cycles", factor * rows["Cycles"]["samples"])
    rows["Reframe, path tracing"] = shot.reframe(seconds, runs.PLAIN, 0, seeds)
    rows["Reframe, groups"] = groups
    if says(args.binary, "render", shot.scene, "-o", os.path.join(shot.folder, "try.exr"), "--frames", "1", "--size", "8x8", "--spp", "1", "--denoise", "--overwrite", "--quiet") is None:
        say("skipped: Reframe, denoised: there is no Open Image Denoise")
    else:
        rows["Reframe, denoised"] = shot.reframe(seconds, "auto:rooks16", 0, seeds, ["--denoise"])
    ours = halves["Reframe"].mean()
    stops = np.log2(GREY / np.median(halves["Reframe"]))
    jod = judge(args, shot, rows, halves, stops) if "JOD" in found else [np.nan] * len(rows)
    order = sorted(zip(rows.items(), jod), key=lambda pair: ("Cycles", "LuxCore", "Mitsuba", "Reframe").index(pair[0][0].split(",")[0]))
    first = None
    for (label, row), value in order:
        who = label.split(",")[0]
        row.update(figures(row["pictures"], halves[who], stops), jod=value)
        first = first or row
        table.add("%s, %s" % (name, label), row["samples"], row["startup"], row["cpu"] / len(shot.listed), "%.4f" % (halves[who].mean() / ours), row["relmse"],
                  pictures.gain(first, row), row["srgb"], row["f1"], value if np.isnan(value) else "%.2f" % value)
        measured.append(row)
    if args.picture and "Cycles" in rows:
        middle, half = len(shot.listed) // 2, halves["Reframe"].shape[3] // 2
        left, right = (rows[label]["pictures"][0][middle] for label in ("Cycles", "Reframe, groups"))
        pictures.write_png(args.picture, np.concatenate([left[:, :half], right[:, half:]], axis=1), stops)


def agreement(measured):
    """How well JOD and our figures agree, as a sentence."""
    judged = [row for row in measured if np.isfinite(row["jod"])]
    if len(judged) < 3:
        return ""
    jod = ranks([row["jod"] for row in judged])
    told = ["%.2f with %s" % (np.corrcoef(jod, ranks([-row[key] for row in judged]))[0, 1], name) for key, name in (("relmse", "relMSE"), ("srgb", "sRGB"), ("f1", "F1"))]
    return " Rank correlation of JOD over the %d rows: %s." % (len(judged), ", ".join(told))
