"""What Blender's cameras cut off before clip start and behind clip end, and Reframe shows."""
import mathutils

from .messages import warn

ACROSS = 9  # rays in each direction of the picture


def rays_of(scene, camera):
    """Origins and directions of rays all over the picture; a direction has length 1 along the view."""
    corners = camera.data.view_frame(scene=scene)
    right, top, left = corners[0], corners[0], corners[2]
    matrix = camera.matrix_world.normalized()
    for i in range(ACROSS):
        for k in range(ACROSS):
            x = left.x + (right.x - left.x) * (i + 0.5) / ACROSS
            y = left.y + (top.y - left.y) * (k + 0.5) / ACROSS
            if camera.data.type == "ORTHO":
                yield matrix @ mathutils.Vector((x, y, 0.0)), matrix.to_3x3() @ mathutils.Vector((0.0, 0.0, -1.0))
            else:
                yield matrix.translation, matrix.to_3x3() @ (mathutils.Vector((x, y, left.z)) / -left.z)


class Clipping:
    """Looks in some frames for surfaces that are cut off."""

    def __init__(self, scene):
        self.scene, self.near, self.far = scene, {}, {}

    def note(self, camera, depsgraph, number):
        if camera.data.type == "PANO":
            return
        start, end = camera.data.clip_start, camera.data.clip_end
        for origin, way in rays_of(self.scene, camera):
            hit, place, _, _, o, _ = self.scene.ray_cast(depsgraph, origin, way)
            if not hit:
                continue
            depth = (place - origin).dot(way) / way.length_squared
            if depth < start:
                self.near.setdefault((camera.name, o.name), number)
            elif depth > end:
                self.far.setdefault((camera.name, o.name), number)

    def tell(self):
        for (camera, name), number in sorted(self.near.items()):
            warn("'%s': nearer to '%s' than its clip start in frame %d: seen here, and may hide what is behind" % (name, camera, number))
        for (camera, name), number in sorted(self.far.items()):
            warn("'%s': farther from '%s' than its clip end in frame %d: seen here" % (name, camera, number))
