"""Windows of a larger picture: cameras that see a small part of what a scene's camera sees, with its pixels' size."""
import glob
import json
import math
import os

import numpy as np
import OpenImageIO as oiio

import benchlib


def camera_of(spec):
    """Position and directions of the camera of a picture, and how much of the film a tangent of 1 is, upwards and to the right."""
    to_camera, to_film = (np.array(spec.getattribute(name)).reshape(4, 4) for name in ("worldToCamera", "worldToNDC"))
    back = np.linalg.inv(to_camera)
    position, right, up = back[3, :3], back[0, :3], back[1, :3]
    on_film = lambda p: (lambda q: q[:2] / q[3])(np.append(p, 1.0) @ to_film)
    forward = max((back[2, :3], -back[2, :3]), key=lambda d: (np.append(position + d, 1.0) @ to_film)[3])
    middle = on_film(position + forward)
    share = 1.0 if abs(middle[1] - 0.5) < 0.25 else 0.5  # 0 to 1, or -1 to 1
    part = lambda axis, i: share * abs(on_film(position + forward + 1e-3 * axis)[i] - middle[i]) / 1e-3
    return {"position": position, "forward": forward, "up": up, "right": right, "part": (part(right, 0), part(up, 1))}


def key_of(spec, zoom, centre=(0.5, 0.5)):
    """The camera of a picture turned to `centre`, from its left and top edge as shares of its size, with 1 / zoom of its view."""
    c = camera_of(spec)
    ahead = c["forward"] + (centre[0] - 0.5) / c["part"][0] * c["right"] - (centre[1] - 0.5) / c["part"][1] * c["up"]
    distance = np.linalg.norm(ahead)
    return {"position": c["position"].tolist(), "target": (c["position"] + ahead).tolist(),
            "fov": math.degrees(2.0 * math.atan(0.5 / c["part"][1] / zoom / distance))}


def keys(binary, scene, pattern, size, frames, zoom, centre=(0.5, 0.5)):
    """By frame, the camera that sees a window of the scene's picture."""
    benchlib.render(binary, scene, pattern, size, "0:1", 1, 1, frames)
    return {int(name[-8:-4]): key_of(oiio.ImageInput.open(name).spec(), zoom, centre) for name in glob.glob(pattern.replace("####", "*"))}


def write_path(name, keys_of_frames):
    with open(name, "w") as file:
        json.dump({"kind": "keyed", "interpolation": "linear", "keys": [dict(key, frame=f) for f, key in sorted(keys_of_frames.items())]}, file)
    return name
