"""Rooms in which lamps, materials and lenses change: cases of moving_rooms.py."""
import copy
import math

from glb import lambert, material
from moving_rooms import (FRAMES, GLOSSY, HALF, LACQUER, LAST, MIRROR, WHITE, Way, furnish, pane, shining, view)
from pictures import png
from shapes import add, make_box, make_quad, make_sphere, mix

STRENGTH = "extensions/KHR_materials_emissive_strength/emissiveStrength"
ROUGHNESS, METALLIC = ("pbrMetallicRoughness/%sFactor" % name for name in ("roughness", "metallic"))
TRANSFORM = "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/"
DIMMED = [4.0, 3.0, 2.5, 1.5, 1.0, 0.3, 0.1]
DARK = [5.0, 2.0, 0.0, 0.0, 1.0, 3.0, 0.0]  # dimmed to nothing in some frames


def between(first, last):
    """A value for each frame."""
    mixed = [mix(first, last, f / LAST) if isinstance(first, tuple) else first + (last - first) * f / LAST for f in range(FRAMES)]
    return mixed


def point(intensity=3.0, color=(1.0, 0.9, 0.8)):
    return {"type": "point", "intensity": intensity, "color": list(color)}


def spot(intensity=8.0, inner=0.3, outer=0.6):
    return {"type": "spot", "intensity": intensity, "spot": {"innerConeAngle": inner, "outerConeAngle": outer}}


def lit_room(name, strength=5.0, **named):
    """A room with a lamp that stands still and is as it is, so that it lights all frames; 0: without."""
    room = view(name, **named)
    furnish(room, lamp=False)
    if strength > 0.0:
        room.still("lamp", make_quad((-0.4, 2.95, -0.4), (0.8, 0.0, 0.0), (0.0, 0.0, 0.8)), shining("lamp", strength))
    return room


def dimmer(name="dimmer", values=DIMMED, strength=5.0):
    """A lamp is dimmed beside one that is not."""
    room = lit_room(name, strength)
    room.light("dimmed", point(), Way((1.0, 1.9, 0.3)), {"intensity": values})
    return room


def glow():
    """Two panels dim, one of them by its colour and to nothing; a ball glows."""
    room = lit_room("glow")
    red, ball = dict(shining("red", 6.0)), material("ball", [0.4, 0.4, 0.4], emissive=[0.2, 0.6, 1.0])
    room.still("panel", make_quad((-1.9, 0.8, 0.6), (0.0, 0.0, -1.2), (0.0, 0.8, 0.0)), shining("panel", 4.0))
    room.still("red panel", make_quad((1.9, 0.9, -1.2), (0.0, 0.0, 1.0), (0.0, 0.7, 0.0)), red)
    room.still("ball", make_sphere(0.25, 8, 6), ball, (0.4, 0.3, -0.2))
    room.changes = {"panel": {STRENGTH: DIMMED}, "ball": {STRENGTH: DIMMED[::-1]},
                    "red": {"emissiveFactor": [(1.0, 0.4, 0.1), (0.8, 0.1, 0.0), (0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (0.2, 0.4, 1.0),
                                               (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)]}}
    return room


def blackout():
    """All light is dimmed to nothing in the frame in the middle, and in others."""
    room = dimmer("blackout", DARK, 0.0)
    room.still("panel", make_quad((-1.9, 0.8, 0.6), (0.0, 0.0, -1.2), (0.0, 0.8, 0.0)), shining("panel", 4.0))
    room.changes["panel"] = {STRENGTH: [1.0, 5.0, 3.0, 0.0, 0.0, 2.0, 4.0]}
    return room


def switches():
    """A lamp is shown at times, another is switched by steps."""
    room = lit_room("switches")
    room.light("shown", point(4.0), Way((1.0, 1.9, 0.3), shown=HALF))
    room.light("stepped", point(color=(0.4, 0.6, 1.0)), Way((-1.1, 2.0, 0.6)), {"intensity": [5.0, 0.0, 0.0, 5.0, 5.0, 0.0, 5.0]}, True)
    return room


def colors():
    """The colour of a lamp changes, and its intensity."""
    room = lit_room("colors", 3.0)
    room.light("lamp", point(), Way((1.0, 1.9, 0.3)), {
        "color": [(1.0, 0.1, 0.0), (0.8, 0.3, 0.0), (0.4, 0.6, 0.1), (0.0, 1.0, 0.3), (0.0, 0.5, 0.7), (0.1, 0.1, 1.0), (1.0, 1.0, 1.0)],
        "intensity": between(2.0, 6.0)})
    return room


def six():
    """Six lamps are dimmed, each in its own way."""
    room = lit_room("six", 2.0)
    for k in range(6):
        place = (-1.2 + 1.2 * (k % 3), 1.8 + 0.1 * k, 0.7 - 0.9 * (k // 3))
        color = ((1.0, 0.2, 0.2), (0.2, 1.0, 0.2), (0.2, 0.2, 1.0))[k % 3]
        room.light("lamp %d" % k, point(color=color), Way(place), {"intensity": [abs(math.sin(1.3 * k + 0.9 * f)) * 2.0 for f in range(FRAMES)]})
    return room


def seen():
    """More light is seen to dim than there are parts: a sky, four panels, one of them by rough glass, and a mirror that shines."""
    room = lit_room("seen", 3.0, sky={"radiance": [0.3, 0.5, 0.9]})
    room.things = [t for t in room.things if t.name not in ("ceiling", "back wall")]
    for k in range(4):
        name, corner = "panel %d" % k, (-1.5 + 0.8 * k, 0.9, -1.9)
        room.still(name, make_quad(corner, (0.5, 0.0, 0.0), (0.0, 0.6, 0.0)), shining(name, 3.0))
        room.changes[name] = {STRENGTH: [0.2 + 3.0 * abs(math.sin(1.3 * k + 0.9 * f)) for f in range(FRAMES)]}
    glow = dict(copy.deepcopy(MIRROR), name="glow", emissiveFactor=[1.0, 0.8, 0.6])
    room.still("glow", make_quad((1.9, 0.5, -1.4), (0.0, 0.0, 1.4), (0.0, 1.2, 0.0)), glow)
    room.changes["glow"] = {"emissiveFactor": [(c, 0.5, 1.0 - c) for c in between(0.1, 0.9)]}
    glass = dict(pane("glass"), pbrMetallicRoughness={"roughnessFactor": 0.3, "metallicFactor": 0.0})
    glass["extensions"]["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    room.still("glass", make_box((0.6, 0.8, 0.1)), glass, (0.3, 0.8, -1.2))
    room.sky_keys = [{"strength": v} for v in DARK]
    return room


def passing(name="passing"):
    """A lamp passes, and a spot that turns on an arm; the mirror sees them all."""
    room = lit_room(name, 3.0)
    room.still("mirror", make_quad((-1.95, 0.5, 1.0), (0.0, 0.0, -2.0), (0.0, 1.6, 0.0)), MIRROR)
    room.light("passing", point(), Way((-1.2, 2.0, 0.7), (1.2, 1.7, -0.2)))
    arm = Way((0.4, 2.3, 0.2), None, "y", -0.5, 0.9)
    room.light("spot", spot(), Way((0.3, 0.0, 0.0), None, "x", -0.9, -1.5, under=arm))
    return room


def matt():
    """A lamp passes over a floor, and nothing is glossy."""
    room = view("matt")
    room.still("floor", make_quad((-2.0, 0.0, 2.0), (4.0, 0.0, 0.0), (0.0, 0.0, -4.0)), lambert("matt", [0.7, 0.6, 0.5]))
    room.light("passing", point(), Way((-1.2, 1.0, 0.2), (1.2, 0.7, -1.2)))
    return room


def cones():
    """The cone of one spot changes, the range of another lamp, and both stand still."""
    room = lit_room("cones", 3.0)
    down = Way((0.5, 2.4, 0.0), None, "x", -1.2)
    room.light("spot", spot(12.0), down, {"spot/innerConeAngle": between(0.05, 0.5), "spot/outerConeAngle": between(0.2, 0.9)})
    room.light("range", point(4.0), Way((-1.0, 1.8, 0.6)), {"range": between(3.0, 1.2)})
    return room


def torch():
    """A shining quad moves and turns, another swings on an arm and dims; a mirror sees them."""
    room = lit_room("torch", 3.0)
    room.still("mirror", make_quad((-1.95, 0.5, 1.0), (0.0, 0.0, -2.0), (0.0, 1.6, 0.0)), MIRROR)
    quad = make_quad((-0.3, -0.2, 0.0), (0.6, 0.0, 0.0), (0.0, 0.4, 0.0))
    room.move("torch", quad, shining("torch", 8.0), [Way((-1.0, 1.4, -0.2), (0.8, 1.9, 0.3), "y", -0.8, 1.3)])
    arm = Way((0.2, 2.6, -0.5), None, "z", -0.6, 0.7)
    room.move("swing", copy.deepcopy(quad), shining("swing", 4.0), [Way((0.0, -0.8, 0.0), None, "x", 0.5, under=arm)])
    room.changes["swing"] = {STRENGTH: DIMMED}
    return room


def sun(name="sun", angles=(0.5, -0.7)):
    """The sun travels over a room without a ceiling, under a faint sky."""
    room = view(name, sky={"radiance": [0.3, 0.35, 0.5]})
    furnish(room, lamp=False, ceiling=False)
    tilt = Way((0.0, 0.0, 0.0), None, "z", *angles)
    room.light("sun", {"type": "directional", "intensity": 4.0, "color": [1.0, 0.9, 0.7]}, Way((0.0, 5.0, 0.0), None, "x", -1.3, under=tilt))
    return room


def checks(x, y):
    return (0.8, 0.7, 0.5) if (x // 4 + y // 4) % 2 else (0.2, 0.3, 0.5)


def surfaces(name="surfaces"):
    """The colour, roughness and metallic factor of surfaces change, and the place of a texture."""
    room = lit_room(name, 9.0)
    room.textures = [("checks", png(16, 16, checks))]
    board = lambert("board", [1.0, 1.0, 1.0])
    board["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    room.still("board", make_quad((0.2, 0.6, -1.9), (1.5, 0.0, 0.0), (0.0, 1.4, 0.0)), board)
    room.still("box", make_box((0.5, 0.8, 0.5)), material("box", [0.8, 0.6, 0.4], roughness=0.4), (0.7, 0.0, -0.5))
    room.still("plate", make_box((0.7, 0.1, 0.5)), lambert("plate", [0.5, 0.5, 0.5]), (-0.2, 0.4, 0.2))
    room.changes = {"plate": {"pbrMetallicRoughness/baseColorFactor": between((0.9, 0.1, 0.1, 1.0), (0.1, 0.3, 0.9, 1.0))},
                    "box": {ROUGHNESS: between(0.2, 0.8), METALLIC: between(1.0, 0.0)},
                    "board": {TRANSFORM + "offset": between((0.0, 0.0), (0.7, 0.4)), TRANSFORM + "rotation": between(0.0, 0.9),
                              TRANSFORM + "scale": between((1.0, 1.0), (2.0, 1.4))}}
    return room


def stripes(frame):
    """An image of a film: the first is black, and sizes differ."""
    def pixel(x, y):
        return (0.0, 0.0, 0.0) if frame == 0 else (0.9, 0.8, 0.3) if (x + frame) % 4 < 2 else (0.1, 0.15 * frame, 0.6)
    return png(8 + 4 * (frame % 3), 6, pixel)


def holes(frame):
    return png(8, 8, lambda x, y: (0.8, 0.3, 0.2, 1.0 if (x + frame) % 5 < 3 else 0.0))


def poster():
    """Films are the colour of a board, and the holes in a curtain."""
    room = lit_room("poster", 9.0)
    board, curtain = lambert("board", [1.0, 1.0, 1.0]), dict(lambert("curtain", [1.0, 1.0, 1.0]), alphaMode="MASK")
    for number, look in enumerate((board, curtain)):
        look["pbrMetallicRoughness"]["baseColorTexture"] = {"index": number}
    room.still("board", make_quad((0.2, 0.6, -1.9), (1.5, 0.0, 0.0), (0.0, 1.4, 0.0)), board)
    room.still("curtain", make_quad((-1.2, 0.3, 0.2), (0.9, 0.0, 0.1), (0.0, 1.2, 0.0)), curtain)
    room.films = {"board": [stripes(f) for f in range(FRAMES)], "curtain": [holes(f) for f in range(FRAMES)]}
    return room


def cinema():
    """A screen plays a film, beside a faint lamp."""
    room = lit_room("cinema", 1.0)
    screen = dict(shining("screen", 6.0), emissiveTexture={"index": 0})
    room.still("screen", make_quad((-1.9, 0.6, 1.0), (0.0, 0.0, -2.0), (0.0, 1.4, 0.0)), screen)
    room.films = {"film": [stripes(f) for f in range(FRAMES)]}
    return room


def heavens(name="heavens"):
    """The sky turns over a room without a ceiling and changes in strength, to nothing."""
    room = view(name, sky={"radiance": [1.0, 1.0, 1.0]})
    furnish(room, lamp=False, ceiling=False)
    room.sky_map = 16, 8, lambda x, y: (4.0, 3.0, 2.0) if x in (2, 3) and y == 1 else (0.2, 0.3, 0.1 * y)
    room.sky_keys = [{"rotation": 65.0 * f, "strength": (1.0, 0.5, 2.0, 0.0, 1.0, 0.2, 3.0)[f]} for f in range(FRAMES)]
    return room


def dawn():
    """The same sky everywhere changes in strength, beside a lamp."""
    room = lit_room("dawn", 3.0, sky={"radiance": [0.3, 0.5, 0.9]})
    room.things = [t for t in room.things if "ceiling" not in t.name]
    room.sky_keys = [{"strength": v} for v in DARK]
    return room


def zoom():
    """The lens zooms, while a lamp is dimmed."""
    room = dimmer("zoom")
    room.yfov = [70.0, 62.0, 54.0, 47.0, 41.0, 36.0, 32.0]
    return room


def everything():
    """Lamps that are dimmed, switched and pass, a torch and a floor that becomes rough, with mirrors, a pane and a box that moves."""
    room = passing("everything")
    room.light("dimmed", point(), Way((1.0, 1.9, 0.3)), {"intensity": DARK})
    room.light("shown", point(2.0), Way((-0.3, 2.2, 0.8), shown=HALF))
    room.still("pane", make_quad((0.2, 0.3, 0.1), (1.0, 0.0, 0.2), (0.0, 1.2, 0.0)), pane("pane"))
    room.still("glossy", make_quad((1.6, 0.4, -1.4), (0.0, 0.0, 1.2), (0.0, 1.2, 0.0)), GLOSSY)
    quad = make_quad((-0.2, -0.2, 0.0), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0))
    room.move("torch", quad, shining("torch", 8.0), [Way((0.4, 1.0, -1.2), (-0.4, 1.6, -0.9), "y", -0.8, 0.9)])
    room.move("box", make_box((0.4, 0.9, 0.3)), WHITE, [Way((-0.9, 0.4, 0.4), (0.7, 0.6, 0.6), "y", 0.0, 1.0)])
    room.changes[LACQUER["name"]] = {ROUGHNESS: between(0.2, 0.6)}
    return room


# ---- Hard cases ----

def extremes():
    """The intensities of a lamp are 1e-30 to 1e9."""
    return dimmer("extremes", [1e-30, 1e-20, 1e-10, 1.0, 1e3, 1e6, 1e9])


def jumps():
    """A lamp is elsewhere in the frame in the middle."""
    room = lit_room("jumps", 3.0)
    left, right = (-1.2, 2.0, 0.7), (1.2, 1.7, -0.2)
    room.light("lamp", point(), Way([left, left, left, right, left, left, left]))
    return room


def sinks():
    """A lamp sinks through a block into the floor; in the middle it is just above the block."""
    room = lit_room("sinks", 3.0)
    top = (-0.8, 0.7, -0.9)
    room.light("lamp", point(1.0), Way([add(top, (0.0, y, 0.0)) for y in (0.5, 0.2, 0.05, 1e-3, -1e-3, -0.3, -0.9)]))
    return room


def horizon():
    """The sun sets: in the middle it is at the horizon."""
    room = sun("horizon", (-0.3, 0.3))
    room.changing_lamps[0].way = Way((0.0, 5.0, 0.0), None, "x", -0.3, 0.3)
    room.things = [t for t in room.things if "wall" not in t.name]
    return room


def shrinks():
    """What shines shrinks to a point and less."""
    room = lit_room("shrinks", 3.0)
    quad = make_quad((-0.3, 0.0, 0.2), (0.6, 0.0, 0.0), (0.0, 0.0, -0.4))
    sizes = [(s, s, s) for s in (1.0, 0.3, 1e-2, 1e-4, 0.0, 1e-6, 0.5)]
    room.move("ember", quad, shining("ember", 5.0), [Way((0.5, 0.6, 0.2), None, "y", 0.0, 1.0, scale=sizes)])
    return room


def polishes():
    """The roughness of a metal goes through 0."""
    room = lit_room("polishes", 9.0)
    room.still("plate", make_quad((-1.0, 0.4, -0.8), (2.0, 0.0, 0.0), (0.0, 1.2, 0.0)), material("plate", [0.8, 0.7, 0.6], metallic=1.0))
    room.changes["plate"] = {ROUGHNESS: [0.5, 0.2, 0.05, 0.0, 0.01, 0.1, 1.0]}
    return room


def primaries():
    """Each lamp has one of red, green and blue: one is dimmed, one stands still, one passes, and a torch moves; a mirror sees them."""
    room = lit_room("primaries", 0.0)
    red, green, blue = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
    quad = make_quad((-0.3, -0.2, 0.0), (0.6, 0.0, 0.0), (0.0, 0.4, 0.0))
    room.still("mirror", make_quad((-1.95, 0.5, 1.0), (0.0, 0.0, -2.0), (0.0, 1.6, 0.0)), MIRROR)
    room.still("lamp", make_quad((-0.4, 2.95, -0.4), (0.8, 0.0, 0.0), (0.0, 0.0, 0.8)), dict(shining("lamp", 5.0), emissiveFactor=green))
    room.light("dimmed", point(color=red), Way((1.0, 1.9, 0.3)), {"intensity": DIMMED})
    room.light("passing", point(color=green), Way((-1.2, 2.0, 0.7), (1.2, 1.7, -0.2)))
    room.move("torch", quad, dict(shining("torch", 8.0), emissiveFactor=blue), [Way((-1.0, 1.4, -0.2), (0.8, 1.9, 0.3), "y", -0.8, 1.3)])
    return room


CASES = (dimmer, glow, blackout, switches, colors, six, seen, passing, matt, cones, torch, sun, surfaces, poster, cinema, heavens, dawn,
         zoom, everything, extremes, jumps, sinks, horizon, shrinks, polishes, primaries)
