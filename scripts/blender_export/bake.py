"""Bakes what glTF cannot express into textures, with Cycles, object by object.

A channel that varies is wired into an emission, so a bake gives its values and not light; the normal is baked as
such. Objects that share a mesh share the bake, unless their materials depend on the object.
"""
import math
import time

import bpy
import mathutils

from . import bake_cache
from .bake_object import add_layer, bake_part, faces_of, loops_of, own_mesh, part_of
from .channels import MEANS, NUMBERS, WORDS
from .messages import printable, warn
from .textures import make_textures, means_of

SMALLEST = 128  # pixels across
SIDES = 3.0  # pixels of a texture's side for each pixel across the object: it shows the back as well
MOST_VIEWS = 50
OWN_PLACE = {"OBJECT_INFO": None, "PARTICLE_INFO": None, "HAIR_INFO": None, "VECT_TRANSFORM": None, "CAMERA": None,
             "AMBIENT_OCCLUSION": None, "BEVEL": None, "TEX_POINTDENSITY": None,
             "NEW_GEOMETRY": ("Position", "Normal", "True Normal", "Incoming", "Parametric"),
             "TEX_COORD": ("Camera", "Window", "Reflection")}


class Job:
    """Objects that share a bake: one mesh, and the plans of those of its slots that need one."""

    def __init__(self, plans, own_place):
        self.objects, self.plans, self.own_place = [], plans, own_place

    def passes(self):
        wanted = set().union(*(p.baked for p in self.plans.values()))
        averaged = set().union(*(p.averaged for p in self.plans.values()))
        found = [n for n in ("base", "emission", "normal") if n in wanted]
        found += ["numbers"] if wanted & set(NUMBERS) else []
        return found + ["means %d" % i for i, group in enumerate(MEANS) if averaged & set(group)]

    def words(self):
        names = set().union(*(p.baked | p.averaged for p in self.plans.values()))
        return ", ".join(dict.fromkeys(WORDS[n] for n in WORDS if n in names))


def depends_on_place(plan):
    """Do two objects with the same mesh look different?"""
    for node in plan.copy.node_tree.nodes:
        if node.type in OWN_PLACE and (OWN_PLACE[node.type] is None or any(node.outputs[n].is_linked for n in OWN_PLACE[node.type])):
            return True
        if node.type == "TEX_COORD" and node.object is not None or node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
            return True
    return False


def sort_jobs(to_bake):
    jobs = {}
    for o, plans in to_bake.items():
        own_place = any(depends_on_place(p) for p in plans.values())
        key = (o.name,) if own_place else (o.data.name_full, tuple(sorted((i, p.material.name_full) for i, p in plans.items())))
        jobs.setdefault(key, Job(plans, own_place)).objects.append(o)
    return list(jobs.values())


class Views:
    """From where objects are seen, which decides on the size of their textures."""

    def __init__(self, recorder, height, largest, placed):
        keys = recorder.keys
        few = keys[::max(len(keys) // MOST_VIEWS, 1)] + keys[-1:]
        self.parallel = recorder.projection == "orthographic"

        def focal(extent):
            """In pixels; of an orthographic camera pixels per metre, of a panorama pixels per radian."""
            if self.parallel:
                return 0.5 * height / extent
            return height / math.pi if extent is None else 0.5 * height / math.tan(0.5 * math.radians(extent))

        self.eyes = [(place, focal(extent)) for _, place, _, extent, _ in few]
        self.largest, self.placed = largest, placed

    def pixels(self, o):
        """How large an object is in the picture at most; infinite where the camera is in or near it."""
        if o.name in self.placed:
            return math.inf
        corners = [o.matrix_world @ mathutils.Vector(c) for c in o.bound_box]
        centre = sum(corners, mathutils.Vector()) / 8.0
        radius = max((c - centre).length for c in corners)
        if self.parallel:
            return max(2.0 * radius * focal for _, focal in self.eyes)
        near = [((place - centre).length, focal) for place, focal in self.eyes]
        return max(2.0 * radius / d * focal if d > 2.0 * radius else math.inf for d, focal in near)

    def side(self, job):
        pixels = max(self.pixels(o) for o in job.objects)
        side = min(SMALLEST, self.largest)
        while side < min(SIDES * pixels, self.largest):
            side *= 2
        return min(side, self.largest)


def bake_job(job, side, cache):
    """Bakes, or takes from the cache; gives the objects their new mesh. Returns the pixels, and whether they were baked."""
    first = job.objects[0]
    mesh = own_mesh(first)
    faces = faces_of(mesh, job.plans)
    if not faces.any():
        return mesh, None, False, None
    loops = loops_of(mesh, faces)
    part = part_of(mesh, faces)
    key = bake_cache.key(first, part, job, side)
    result = cache.find(key)
    fresh = result is None or len(result["uv"]) != len(loops)
    if fresh:
        result = bake_part(first, part, job, side)
        cache.keep(key, result)
    else:
        bpy.data.meshes.remove(part)
    add_layer(mesh, result["uv"], loops)
    return mesh, result, fresh, key


def bake_objects(to_bake, views, folder, is_solid, build):
    """Bakes what the plans of objects ask for; returns the slots (object, number, material) to be set."""
    jobs, cache = sort_jobs(to_bake), bake_cache.Cache(folder)
    new, made, known = [], {}, {}
    for i, job in enumerate(jobs):
        start, side = time.monotonic(), views.side(job)
        name = job.objects[0].name
        try:
            mesh, result, fresh, key = bake_job(job, side, cache)
        except Exception as e:  # Blender's bake fails for reasons of its own
            warn("'%s': could not be baked: taken as constant: %s" % (name, " ".join(str(e).split())[:200]))
            mesh, result, fresh, key = job.objects[0].data, None, False, None
        solid = {slot: is_solid(p, job.objects[0]) for slot, p in job.plans.items()}
        same = (key, tuple(sorted((slot, id(p), solid[slot]) for slot, p in job.plans.items())))
        materials = known.get(same) if key is not None else None
        if materials is None:
            materials = known[same] = make_materials(job, name, result, solid, made, build)
        for o in job.objects:
            o.data = mesh
            new += [(o, slot, material) for slot, material in materials.items()]
        if result is None:
            continue
        print("blender-export: baked %d of %d: '%s' at %dx%d: %s: %s" % (i + 1, len(jobs), printable(name), side, side, job.words(),
              "%.1f s" % (time.monotonic() - start) if fresh else "from the cache"), flush=True)
    cache.tell()
    return new


def make_materials(job, name, result, solid, made, build):
    """The materials of the slots of a job; `made` counts those of each plan. Without pixels they are constant."""
    textures = make_textures(name, result) if result is not None else None
    materials = {}
    for slot, plan in job.plans.items():
        made[plan] = made.get(plan, 0) + 1
        plain = plan.free_name()
        means = means_of(plan, result) if result is not None else None
        materials[slot] = build(plan, plain if made[plan] == 1 else "%s %s" % (plain, name), textures, means, solid[slot])
    return materials
