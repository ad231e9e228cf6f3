"""World matrices over time, as translations, rotations and scales that are right between the frames as well."""
import numpy

SHEAR = 2e-5  # the cosine between axes that are taken as square
FLAT = 1e-6  # of its greatest scale: what is smaller along an axis has no direction there


class Path:
    """Places, rotations (w, x, y, z) and scales by frame. With shear, all act upon a thing that another turn (`inner`) has turned."""

    def __init__(self, places, turns, scales, inner=None):
        self.places, self.turns, self.scales, self.inner = places, turns, scales, inner

    def unsheared(self):
        """The rotation alone of what is sheared, for lamps."""
        if self.inner is None:
            return self
        return Path(self.places, product(self.turns, self.inner), numpy.abs(self.scales))


def product(a, b):
    """Of quaternions w, x, y, z."""
    (aw, ax, ay, az), (bw, bx, by, bz) = numpy.moveaxis(a, -1, 0), numpy.moveaxis(b, -1, 0)
    return numpy.stack((aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
                        aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw), axis=-1)


def quaternions_of(matrices):
    """Of rotation matrices (..., 3, 3): w, x, y, z. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1(3), 1978."""
    m = matrices
    trace = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    squares = numpy.stack([trace] + [m[..., i, i] for i in range(3)], axis=-1)
    largest = squares.argmax(axis=-1)
    w = numpy.stack((1.0 + trace, m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]), axis=-1)
    found = w
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        q = numpy.empty_like(w)
        q[..., 0] = m[..., k, j] - m[..., j, k]
        q[..., 1 + i] = 1.0 + m[..., i, i] - m[..., j, j] - m[..., k, k]
        q[..., 1 + j] = m[..., j, i] + m[..., i, j]
        q[..., 1 + k] = m[..., k, i] + m[..., i, k]
        found = numpy.where((largest == i + 1)[..., None], q, found)
    return found / numpy.linalg.norm(found, axis=-1, keepdims=True)


SIGNS = {1: numpy.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], numpy.float64),
         -1: numpy.array([(-1, -1, -1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)], numpy.float64)}


def completed(axes, known, before):
    """A rotation with the known ones of three axes, as near to the one before as can be."""
    count = int(known.sum())
    if count == 0:
        return before
    axes = axes.copy()
    if count == 1:
        i = int(numpy.flatnonzero(known)[0])
        j = (i + 1) % 3
        other = before[:, j] - axes[:, i] * (axes[:, i] @ before[:, j])
        if numpy.linalg.norm(other) < 1e-3:
            other = numpy.cross(axes[:, i], numpy.eye(3)[numpy.abs(axes[:, i]).argmin()])
        axes[:, j] = other / numpy.linalg.norm(other)
        known = known.copy()
        known[j] = True
    i = int(numpy.flatnonzero(~known)[0])
    axes[:, i] = numpy.cross(axes[:, (i + 1) % 3], axes[:, (i + 2) % 3])
    return axes


def follow_axes(axes, lengths, known):
    """Rotations and signed scales of one thing whose axes vanish in some frames, or that turns into its mirror image."""
    whole = known.all(axis=1)
    hands = numpy.sign(numpy.linalg.det(axes))
    first = int(numpy.flatnonzero(whole)[0]) if whole.any() else None
    hand = int(hands[first]) if first is not None else 1
    signs = SIGNS[hand][0]
    before = axes[first] * signs if first is not None else numpy.eye(3)
    turns, scales = numpy.empty_like(axes), lengths.copy()
    for f in range(len(axes)):
        if whole[f] and int(hands[f]) != hand:
            hand = int(hands[f])
            tries = axes[f][None] * SIGNS[hand][:, None, :]
            signs = SIGNS[hand][(tries * before).sum(axis=(1, 2)).argmax()]
        before = axes[f] * signs if whole[f] else completed(axes[f] * signs, known[f], before)
        turns[f] = before
        scales[f] = lengths[f] * signs
    return turns, scales


def without_shear(linear):
    """Rotations and scales of things (count, frames, 3, 3), and which of them are sheared in some frame. A mirror image has three
    negative scales, as Blender decomposes it, unless it was none before."""
    lengths = numpy.linalg.norm(linear, axis=2)
    known = lengths > FLAT * numpy.maximum(lengths.max(axis=(1, 2), keepdims=True), 1e-30)
    axes = linear / numpy.where(known, lengths, 1.0)[:, :, None, :]
    gram = numpy.abs(numpy.swapaxes(axes, 2, 3) @ axes)
    both = known[..., :, None] & known[..., None, :] & ~numpy.eye(3, dtype=bool)
    sheared = (numpy.where(both, gram, 0.0) > SHEAR).any(axis=(1, 2, 3))
    hands = numpy.where(numpy.linalg.det(axes) < 0.0, -1.0, 1.0)
    turns, scales = axes * hands[..., None, None], lengths * hands[..., None]
    special = ~known.all(axis=(1, 2)) | (hands != hands[:, :1]).any(axis=1)
    for i in numpy.flatnonzero(special & ~sheared):
        turns[i], scales[i] = follow_axes(axes[i], lengths[i], known[i])
    return turns, scales, sheared


def near_before(v, before):
    """The columns of V, in the order and with the signs that make it a rotation as near to the one before as can be."""
    best, found = -numpy.inf, None
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        tried = v[:, order]
        for signs in SIGNS[1 if numpy.linalg.det(tried) > 0.0 else -1]:
            score = ((tried * signs) * before).sum()
            if score > best:
                best, found = score, (list(order), signs)
    return found


def with_shear(linear):
    """One thing (frames, 3, 3) as M = U S V^T, by the singular value decomposition: rotations, scales, inner rotations."""
    u, s, vt = numpy.linalg.svd(linear)
    outer, scales, inner = numpy.empty_like(linear), numpy.empty_like(s), numpy.empty_like(linear)
    before = numpy.eye(3)
    for f in range(len(linear)):
        v = vt[f].T
        order, signs = near_before(v, before)
        before = v[:, order] * signs
        turned = u[f][:, order] * signs
        hand = 1.0 if numpy.linalg.det(turned) > 0.0 else -1.0
        outer[f], scales[f], inner[f] = turned * hand, s[f][order] * hand, before.T
    return outer, scales, inner


def decompose(matrices):
    """The paths of things (count, frames, 4, 4)."""
    linear = matrices[:, :, :3, :3]
    turns, scales, sheared = without_shear(linear)
    places = matrices[:, :, :3, 3].astype(numpy.float32)
    found = []
    for i in range(len(matrices)):
        if sheared[i]:
            outer, stretch, inner = with_shear(linear[i])
            found.append(Path(places[i], quaternions_of(outer), stretch, quaternions_of(inner)))
        else:
            found.append(Path(places[i], quaternions_of(turns[i]).astype(numpy.float32), scales[i].astype(numpy.float32)))
    return found
