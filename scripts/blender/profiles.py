"""How lamps shine to each side, as tables over angles: IES files as Cycles takes them, and the edges of spots' cones.

The angles are those of Reframe (src/scene/profile.h): vertical 0 is the lamp's -z, horizontal 0 its -y, 90 its -x.
"""
import math
import os

import bpy
import numpy

from .versions import CLOSES_TABLES, IS_4, curve_lists

WATTS = 4.0 * math.pi / 177.83  # of a lamp, for each candela of a file
TOLERANCE = 0.002  # of the most, that the table may be off between its angles
MOST = 40000  # values

tables = {}  # of lamp data, by name, until `write`


class Refused(Exception):
    pass


# IES files.


def numbers_after_tilt(text):
    lines = text.splitlines()
    at = next((i for i, line in enumerate(lines) if line.startswith("TILT=")), None)
    if at is None:
        raise Refused("no line begins with TILT=")
    tilt = lines[at][5:].strip()
    if tilt not in ("NONE", "INCLUDE"):
        raise Refused("TILT names another file: write TILT=NONE")
    try:
        values = [float(word) for word in " ".join(lines[at + 1:]).replace(",", " ").split()]
    except ValueError:
        raise Refused("it has something other than numbers after TILT=") from None
    return values[2 + 2 * int(values[1]):] if tilt == "INCLUDE" and len(values) > 1 else values


def read_ies(text):
    """Vertical and horizontal angles, degrees, of a whole turn, and candela: a row for each horizontal angle."""
    values = numbers_after_tilt(text)
    if len(values) < 13:
        raise Refused("it ends too early")
    down, around, kind = (int(v) for v in values[3:6])
    if kind != 1:
        raise Refused("only photometry of type C (1) is read: convert the file")
    rest = numpy.array(values[13:])
    if down < 2 or around < 1 or len(rest) < down + around + down * around:
        raise Refused("it ends too early")
    vertical, horizontal = rest[:down], rest[down:down + around]
    table = rest[down + around:down + around + down * around].reshape(around, down) * (values[2] * values[10] * values[11])
    if not (numpy.isfinite(rest).all() and (numpy.diff(vertical) > 0.0).all() and (numpy.diff(horizontal) > 0.0).all()):
        raise Refused("its angles do not ascend")
    return (vertical, *whole_turn(horizontal, table))


def whole_turn(angles, table):
    """The parts that a file leaves out since they are like others (LM-63-2002), where Cycles has them."""
    if angles[0] == 90.0:
        angles = angles - 90.0
    if angles[0] != 0.0:
        raise Refused("its horizontal angles begin at %g degrees" % angles[0])
    if len(angles) == 1:
        return numpy.array([0.0, 360.0]), table[[0, 0]]
    for end in (90.0, 180.0):
        if angles[-1] == end:
            angles, table = numpy.append(angles, 2.0 * end - angles[-2::-1]), numpy.append(table, table[-2::-1], axis=0)
    if angles[-1] != 360.0 and 360.0 - angles[-1] in (angles[-1] - angles[-2], angles[1] - angles[0]):
        angles, table = numpy.append(angles, 360.0), numpy.append(table, table[:1], axis=0)
    if angles[-1] != 360.0:
        raise Refused("its horizontal angles end at %g degrees" % angles[-1])
    return angles, table


def cubic(a, b, c, d, x):
    """The cubic through b and c with the slopes of Catmull and Rom."""
    return 0.5 * (((d + 3.0 * (b - c) - a) * x + 2.0 * a - 5.0 * b + 4.0 * c - d) * x + c - a) * x + b


def interval(angles, x):
    i = numpy.clip(numpy.searchsorted(angles, x, side="right") - 1, 0, len(angles) - 2)
    return i, (x - angles[i]) / (angles[i + 1] - angles[i])


class Ies:
    """A file's candela in each direction, as Cycles interpolates it: in Blender 4, all that is beyond the table counts as 0, also where a
    whole turn closes, and at the zenith; Blender 3 sees nothing of a file that begins at 90 degrees."""

    def __init__(self, text):
        self.vertical, self.horizontal, table = read_ies(text)
        first = self.vertical[0]
        if not IS_4 and first not in (0.0, 90.0):
            raise Refused("its vertical angles begin at %g degrees" % first)
        if not IS_4 and first == 90.0:
            table = 0.0 * table
        closes = 1.0 if CLOSES_TABLES else 0.0
        above, below = table[:, 1:2] * (first == 0.0), table[:, -1:] * closes
        table = numpy.concatenate((above, table, below), axis=1)
        self.table = numpy.concatenate((table[-2:-1] * closes, table, table[1:2] * closes))

    def __call__(self, directions):
        """Candela in directions of the lamp's own space, by their last axis."""
        x, y, z = numpy.moveaxis(directions / numpy.linalg.norm(directions, axis=-1, keepdims=True), -1, 0)
        v, h = numpy.degrees(numpy.arccos(numpy.clip(-z, -1.0, 1.0))), numpy.degrees(numpy.arctan2(x, y)) + 180.0
        (r, s), (c, t) = interval(self.vertical, v), interval(self.horizontal, h)
        rows = [cubic(*(self.table[c + i, r + k] for k in range(4)), s) for i in range(4)]
        inside = (v >= self.vertical[0]) & (v < self.vertical[-1])
        return numpy.where(inside, numpy.maximum(cubic(*rows, t), 0.0), 0.0)


def text_of(node):
    """The text of the file that a node names."""
    if node.mode == "INTERNAL":
        if node.ies is None:
            raise Refused("it names no text")
        return node.ies.as_string()
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    try:
        with open(path, encoding="latin-1") as file:
            return file.read()
    except OSError as e:
        raise Refused("'%s' cannot be read: %s" % (os.path.basename(path), e.strerror)) from None


def turning(socket):
    """What the Vector of a node does to directions of the lamp's own space: nothing but Mapping nodes behind its normal is known."""
    if not socket.is_linked:
        return lambda d: d
    source = socket.links[0].from_socket
    node = source.node
    if node.type == "TEX_COORD" and source.name == "Normal":
        return lambda d: d
    plain = node.type == "MAPPING" and not any(s.is_linked for s in node.inputs[1:])
    if not plain:
        raise Refused("its Vector is neither the normal of Texture Coordinate nor a Mapping of it")
    before = turning(node.inputs[0])
    place, scale = (numpy.array(node.inputs[n].default_value) if n in node.inputs and node.inputs[n].enabled else default
                    for n, default in (("Location", numpy.zeros(3)), ("Scale", numpy.ones(3))))
    turn = numpy.array(node.inputs["Rotation"].default_value.to_matrix())
    scale = numpy.where(scale == 0.0, 1e-9, scale)
    if node.vector_type == "TEXTURE":
        return lambda d: ((before(d) - place) @ turn) / scale
    if node.vector_type == "NORMAL":
        return lambda d: (before(d) / scale) @ turn.T
    return lambda d: (before(d) * scale) @ turn.T + (place if node.vector_type == "POINT" else 0.0)


# Tables.


def directions(vertical, horizontal):
    v, h = numpy.radians(vertical)[None, :], numpy.radians(horizontal)[:, None]
    return numpy.stack((-numpy.sin(v) * numpy.sin(h), -numpy.sin(v) * numpy.cos(h), -numpy.cos(v) + 0.0 * h), axis=-1)


def refine(function, angles, others, axis, most):
    """Adds the angles between which a table would be off."""
    for _ in range(6):
        between = 0.5 * (angles[1:] + angles[:-1])
        at = (lambda a: function(directions(a, others))) if axis else (lambda a: function(directions(others, a)))
        here, wanted = numpy.moveaxis(at(angles), axis, 0), numpy.moveaxis(at(between), axis, 0)
        off = numpy.abs(0.5 * (here[1:] + here[:-1]) - wanted).max(axis=1) > TOLERANCE * most
        if not off.any() or (len(angles) + off.sum()) * len(others) > MOST:
            break
        angles = numpy.sort(numpy.append(angles, between[off]))
    return angles


def tabulate(function, vertical, horizontal):
    """Of a function of directions: angles and values, a row for each horizontal angle."""
    most = function(directions(vertical, horizontal)).max()
    vertical = refine(function, vertical, horizontal, 1, most)
    if len(horizontal) > 1:
        horizontal = refine(function, horizontal, vertical, 0, most)
    return vertical, horizontal, function(directions(vertical, horizontal))


def mean_over_sphere(function):
    v = (numpy.arange(720) + 0.5) * 0.25
    values = function(directions(v, (numpy.arange(72) + 0.5) * 5.0)).mean(axis=0)
    weights = numpy.sin(numpy.radians(v))
    return float((values * weights).sum() / weights.sum())


def own_space(lamp):
    """From the frame of the exported node, whose scale counts for nothing, to world space, and how the lamp turns and scales."""
    m = numpy.array(lamp.matrix_world.to_3x3())
    z = m[:, 2] / numpy.linalg.norm(m[:, 2])
    x = m[:, 0] - z * (z @ m[:, 0])
    x /= numpy.linalg.norm(x)
    return numpy.stack((x, numpy.cross(z, x), z), axis=1), m


def has_keyed_cone(light):
    """Does the cone of lamp data change?"""
    data = light.animation_data
    if light.type != "SPOT" or data is None:
        return False
    curves = list(data.drivers) + [curve for curves in curve_lists(data) for curve in curves]
    return any(curve.data_path.startswith("spot_") for curve in curves)


def cone_of(lamp):
    """The part of a spot's intensity in each direction of its node's frame. Cycles' spots fall off smoothly at the edge; in Blender 3
    with the cosine too; in Blender 4 their cones are scaled with them."""
    light, (frame, m) = lamp.data, own_space(lamp)
    least = math.cos(0.5 * light.spot_size)
    edge = max((1.0 - least) * light.spot_blend, 1e-6)
    turn = numpy.linalg.inv(m) @ frame if IS_4 else numpy.eye(3)

    def falloff(d):
        local = d @ turn.T
        cosine = -local[..., 2] / numpy.linalg.norm(local, axis=-1)
        t = numpy.clip((cosine - least) / edge, 0.0, 1.0)
        return t * t * (3.0 - 2.0 * t) * (1.0 if IS_4 else cosine)
    return falloff


def is_round(lamp):
    """Is a lamp's cone the same around its axis?"""
    x, y, z = lamp.matrix_world.to_3x3().col
    lengths, crossed = (x.length, y.length), max(abs(x.dot(y)), abs(x.dot(z)), abs(y.dot(z)))
    return not IS_4 or max(lengths) - min(lengths) < 1e-3 * max(lengths) and crossed < 1e-4 * max(lengths) * max(*lengths, z.length)


def end_of(cone, horizontal):
    """The vertical angle beyond which a cone is dark, degrees."""
    fine = numpy.linspace(0.0, 180.0, 1801)
    lit = numpy.flatnonzero(cone(directions(fine, horizontal)).max(axis=0) > 0.0)
    return fine[min(lit[-1] + 1, 1800)] if len(lit) else 180.0


def of_cone(lamp, fitted):
    """Gives a spot the table of its cone; `fitted`: by what its energy is multiplied in glTF."""
    cone = cone_of(lamp)
    horizontal = numpy.array([0.0]) if is_round(lamp) else numpy.linspace(0.0, 360.0, 25)
    vertical, horizontal, values = tabulate(cone, numpy.linspace(0.0, end_of(cone, horizontal), 25), horizontal)
    keep(lamp, vertical, horizontal, values / fitted)


def of_file(lamp, ies, turn, fitted):
    """Gives a lamp the table of a file, and of its cone if it is a spot. Returns what else its energy is multiplied by in glTF, so that
    the mean is right without the table."""
    frame, m = own_space(lamp)
    cone, into = cone_of(lamp) if lamp.data.type == "SPOT" else None, m.T @ frame

    def whole(d):
        found = WATTS * ies(turn(d @ into.T))
        return found * cone(d) if cone is not None else found
    as_it_is = cone is None and numpy.allclose(turn(numpy.eye(3)), numpy.eye(3)) and numpy.allclose(into / into[0, 0], numpy.eye(3), atol=1e-3)
    vertical, horizontal = (ies.vertical, ies.horizontal) if as_it_is else (numpy.linspace(0.0, 180.0, 73), numpy.linspace(0.0, 360.0, 37))
    if cone is not None:
        vertical = numpy.linspace(0.0, end_of(cone, horizontal), 49)
    share = mean_over_sphere(whole) / (mean_over_sphere(cone) if cone is not None else 1.0)
    if share > 0.0:
        vertical, horizontal, values = tabulate(whole, vertical, horizontal)
        keep(lamp, vertical, horizontal, values / (share * fitted))
    return share


def keep(lamp, vertical, horizontal, values):
    if (numpy.abs(values - values[:1]) < 1e-4 * values.max()).all():
        horizontal, values = numpy.array([0.0]), values[:1]
    tables[lamp.data.name] = {"vertical": numbers(vertical), "horizontal": numbers(horizontal), "relative": numbers(values.ravel())}


def numbers(values):
    return [float("%.6g" % v) for v in values]


def write(gltf):
    """Puts the tables where Blender's exporter has written the lamps."""
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        if light.get("name") in tables:
            light.setdefault("extras", {}).setdefault("reframe", {})["profile"] = tables[light["name"]]
