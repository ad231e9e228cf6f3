"""Triangles and boxes of models as Blender imports them, at the first and the middle frame of their animation: for `validate imports`.

  blender -b -P imports.py -- JOB.json   # {"files": [...], "result": FILE}
"""
import json
import os
import sys

import bpy

IMPORTERS = {".fbx": (bpy.ops.import_scene, "fbx"), ".dae": (bpy.ops.wm, "collada_import"), ".obj": (bpy.ops.wm, "obj_import"), ".glb": (bpy.ops.import_scene, "gltf")}


def measure(frame):
    """Triangles of all meshes, as instances show them, and their box."""
    bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
    graph, count, low, high = bpy.context.evaluated_depsgraph_get(), 0, [1e300] * 3, [-1e300] * 3
    for instance in graph.object_instances:
        if instance.object.type != "MESH":
            continue
        mesh = instance.object.to_mesh()
        mesh.calc_loop_triangles()
        count += len(mesh.loop_triangles)
        for v in {v for t in mesh.loop_triangles for v in t.vertices}:
            p = instance.matrix_world @ mesh.vertices[v].co
            low, high = [min(a, b) for a, b in zip(low, p)], [max(a, b) for a, b in zip(high, p)]
        instance.object.to_mesh_clear()
    return {"triangles": count, "box": [low, high] if count else None}


def measure_file(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    module, name = IMPORTERS[os.path.splitext(path)[1].lower()]
    try:
        getattr(module, name)(filepath=path)
    except (RuntimeError, AttributeError) as error:
        lines = [line for line in str(error).strip().splitlines() if not line.startswith("Location:")]
        return {"error": lines[-1]}
    ranges = [action.frame_range for action in bpy.data.actions]
    first, last = (min(r[0] for r in ranges), max(r[1] for r in ranges)) if ranges else (1, 1)
    return {"poses": [measure(first), measure((first + last) / 2)]}


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    with open(job["result"], "w", encoding="utf-8") as file:
        json.dump([measure_file(path) for path in job["files"]], file)


main()
