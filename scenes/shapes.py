"""Vectors and meshes for the scene scripts of this folder."""

import math


# Vectors are tuples of three floats.
def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return (a[0] / length, a[1] / length, a[2] / length)


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


class Mesh:
    """Vertices with normals and UVs, and counter-clockwise triangles."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []
        self.tangents = []  # empty, or one per vertex: x y z and the sign of the bitangent

    def vertex(self, position, normal, uv):
        self.positions.append(position)
        self.normals.append(normal)
        self.uvs.append(uv)
        return len(self.positions) - 1

    def quad(self, corner, u, v):
        """A parallelogram; its front faces u x v."""
        normal = normalize(cross(u, v))
        first = self.vertex(corner, normal, (0.0, 1.0))
        self.vertex(add(corner, u), normal, (1.0, 1.0))
        self.vertex(add(add(corner, u), v), normal, (1.0, 0.0))
        self.vertex(add(corner, v), normal, (0.0, 0.0))
        for i in (0, 1, 2, 0, 2, 3):
            self.indices.append(first + i)

    def grid(self, points, rows, columns):
        """Adds a grid of (rows + 1) x (columns + 1) vertices from points(row, column), without
        the degenerate triangles at poles."""
        first = len(self.positions)
        for row in range(rows + 1):
            for column in range(columns + 1):
                self.vertex(*points(row, column))
        for row in range(rows):
            for column in range(columns):
                a = first + row * (columns + 1) + column
                b, c, d = a + 1, a + columns + 2, a + columns + 1
                for triangle in ((a, b, c), (a, c, d)):
                    p = [self.positions[i] for i in triangle]
                    if p[0] != p[1] and p[1] != p[2] and p[2] != p[0]:
                        self.indices.extend(triangle)


def make_quad(corner, u, v):
    mesh = Mesh()
    mesh.quad(corner, u, v)
    return mesh


def make_box(size, turn=0.0):
    """A box around the origin, standing on y = 0, rotated about y."""
    w, h, d = size
    c, s = math.cos(turn), math.sin(turn)
    x, y, z = (w * c, 0.0, -w * s), (0.0, h, 0.0), (d * s, 0.0, d * c)
    corner = (-0.5 * (x[0] + z[0]), 0.0, -0.5 * (x[2] + z[2]))
    minus = lambda a: (-a[0], -a[1], -a[2])
    mesh = Mesh()
    mesh.quad(add(corner, z), x, y)
    mesh.quad(add(corner, x), minus(x), y)
    mesh.quad(corner, z, y)
    mesh.quad(add(add(corner, x), z), minus(z), y)
    mesh.quad(add(add(corner, y), z), x, minus(z))
    mesh.quad(corner, x, z)
    return mesh


def make_sphere(radius, columns, rows):
    def point(row, column):
        theta, phi = math.pi * row / rows, 2.0 * math.pi * (column % columns) / columns
        ring = 0.0 if row in (0, rows) else math.sin(theta)
        normal = (ring * math.sin(phi), math.cos(theta), ring * math.cos(phi))
        position = tuple(radius * x for x in normal)
        return position, normal, (column / columns, row / rows)

    mesh = Mesh()
    # Rows go down and columns to the right as seen from outside: clockwise.
    mesh.grid(lambda row, column: point(row, columns - column), rows, columns)
    return mesh


def profile_point(profile, t):
    """Point and derivative of the Catmull-Rom curve through the profile, t in
    [0, 1]. The curve is mirrored at the axis, so it meets the axis at right angles."""
    n = len(profile) - 1
    x = t * n
    i = min(int(x), n - 1)
    x -= i
    p1, p2 = profile[i], profile[i + 1]
    p0 = profile[i - 1] if i > 0 else (-profile[1][0], profile[1][1])
    p3 = profile[i + 2] if i + 2 <= n else (-profile[n - 1][0], profile[n - 1][1])
    point, slope = [], []
    for a, b, c, d in zip(p0, p1, p2, p3):
        k1, k2, k3 = 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c)
        point.append(b + x * (k1 + x * (k2 + x * k3)))
        slope.append(k1 + x * (2.0 * k2 + x * 3.0 * k3))
    return point, slope


def make_lathe(profile, columns, rows):
    """A surface of revolution about the y axis. The profile is (radius, height) along
    the wall, from the axis at the bottom over the outside; it ends on the axis."""
    def point(row, column):
        (radius, height), (dr, dh) = profile_point(profile, row / rows)
        pole = row in (0, rows)
        radius = 0.0 if pole else radius
        phi = 2.0 * math.pi * (column % columns) / columns
        s, c = math.sin(phi), math.cos(phi)
        if pole:
            normal = (0.0, -1.0 if row == 0 else 1.0, 0.0)
        else:
            normal = normalize((dh * s, -dr, dh * c))
        return (radius * s, height, radius * c), normal, (column / columns, 1.0 - row / rows)

    mesh = Mesh()
    mesh.grid(point, rows, columns)
    return mesh


def make_room(low, high):
    """The six sides of a closed room, by name, facing inwards. On the walls the
    texture's left is the viewer's left."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    x, y, z = (x1 - x0, 0.0, 0.0), (0.0, y1 - y0, 0.0), (0.0, 0.0, z1 - z0)
    minus_x, minus_z = (x0 - x1, 0.0, 0.0), (0.0, 0.0, z0 - z1)
    return {
        "floor": make_quad((x0, y0, z1), x, minus_z),
        "ceiling": make_quad((x0, y1, z0), x, z),
        "back wall": make_quad((x0, y0, z0), x, y),
        "left wall": make_quad((x0, y0, z1), minus_z, y),
        "right wall": make_quad((x1, y0, z0), z, y),
        "front wall": make_quad((x1, y0, z1), minus_x, y),
    }
