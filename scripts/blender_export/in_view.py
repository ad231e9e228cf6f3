"""Which point and area lamps come into the picture, where Cycles' camera does not see them."""
import math

from bpy_extras.object_utils import world_to_camera_view

from .messages import list_names, warn
from .visibility import hidden_ways, shown_by

DISC_CORNERS = 64


def corners_of(light):
    """The outline of a flat shape in x and y, counter-clockwise seen from -z, and its area."""
    x = 0.5 * light.size
    y = 0.5 * (light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    if light.shape in ("SQUARE", "RECTANGLE"):
        return [(-x, -y, 0), (-x, y, 0), (x, y, 0), (x, -y, 0)], 4 * x * y
    turns = [-2 * math.pi * i / DISC_CORNERS for i in range(DISC_CORNERS)]
    area = 0.5 * DISC_CORNERS * math.sin(2 * math.pi / DISC_CORNERS) * x * y
    return [(x * math.cos(a), y * math.sin(a), 0) for a in turns], area


def place_of(lamp, matrix=None):
    """What tells lamps apart, also where instances show one several times: its data, and where it stands."""
    return lamp.data.name_full, tuple(matrix.translation if matrix is not None else lamp.location)


def extent_of(lamp, scale):
    """The radius of a sphere around what shines."""
    if lamp.data.type != "AREA":
        return lamp.data.shadow_soft_size
    corners, _ = corners_of(lamp.data)
    return max(math.hypot(x * scale.x, y * scale.y) for x, y, _ in corners)


def unseen_lamps(depsgraph):
    """The lamps, and the matrices of them, that stand in the scene and that the camera does not see."""
    found = []
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT" and instance.object.data.type in ("POINT", "AREA"):
            if (instance.is_instance or instance.show_self) and "camera" in hidden_ways(instance):
                found.append((shown_by(instance), instance.matrix_world.copy()))
    return found


class InView:
    """Notes them frame by frame: `depsgraph` is that of the first frame, as lamps are exported."""

    def __init__(self, scene, depsgraph):
        self.scene, self.lamps = scene, unseen_lamps(depsgraph)
        self.places, self.flat = set(), set()  # of point lamps; names of area lamps

    def note(self, camera):
        for lamp, matrix in self.lamps:
            x, y, depth = world_to_camera_view(self.scene, camera, matrix.translation)
            size = extent_of(lamp, matrix.to_scale())
            edge = 0.05 + size / max(depth, 1e-3)
            if camera.data.type == "PANO" or depth > -size and -edge < x < 1.0 + edge and -edge < y < 1.0 + edge:
                if lamp.data.type == "POINT":
                    self.places.add(place_of(lamp, matrix))
                elif lamp.data.energy > 0.0 and not lamp.data.cycles.is_portal:
                    self.flat.add(lamp.name)

    def tell(self):
        if self.flat:
            warn("%s: an area lamp that the camera does not see in Blender: may be in view here, and hides what is behind" %
                 list_names(sorted(self.flat)))
