"""Rows of numbers, one for each shape, as sums of a few rows: what keys, bones and lattices deform is linear in few values.

The rows are those of the singular value decomposition, by the eigenvectors of the rows' products, which need not be in memory at once.
As many are taken as bring every number near enough.
"""
import numpy

AT_ONCE = 1 << 23  # numbers in memory


class Rows:
    """`read(first, last)`: of vertices, as an array (count, 3 (last - first)); `vertices`: of each row."""

    def __init__(self, count, vertices, read):
        self.count, self.vertices, self.read = count, vertices, read

    def chunks(self):
        step = max(AT_ONCE // (3 * self.count), 1)
        for first in range(0, self.vertices, step):
            last = min(first + step, self.vertices)
            yield first, last, self.read(first, last).astype(numpy.float64)


def bytes_of(changed, vertices):
    """Of an accessor in which so many vertices are not zero."""
    return numpy.minimum(16 * changed, 12 * vertices)


def factors(rows, error):
    """The weights (count, few) of few rows, which are the products of the transposed weights and the rows. No number is off by more than
    `error`; None where the rows themselves take less room."""
    products, changed, ever = numpy.zeros((rows.count, rows.count)), numpy.zeros(rows.count, numpy.int64), 0
    for _, _, chunk in rows.chunks():
        products += chunk @ chunk.T
        is_changed = chunk.reshape(rows.count, -1, 3).any(axis=2)
        changed += is_changed.sum(axis=1)
        ever += int(is_changed.any(axis=0).sum())
    values, vectors = numpy.linalg.eigh(products)
    values, vectors = numpy.maximum(values[::-1], 0.0), vectors[:, ::-1]
    left = numpy.append(numpy.cumsum(values[::-1])[::-1], 0.0)  # the squares that so many rows leave
    count = int(numpy.argmax(left <= rows.count * 3 * rows.vertices * error**2))
    whole = int(bytes_of(changed, rows.vertices).sum())
    while count < rows.count and count * int(bytes_of(ever, rows.vertices)) < whole:
        weights = vectors[:, :count]
        if all(numpy.abs(chunk - weights @ (weights.T @ chunk)).max(initial=0.0) <= error for _, _, chunk in rows.chunks()):
            return weights
        count += max(count // 8, 1)
    return numpy.zeros((rows.count, 0)) if whole == 0 else None


def summed(rows, weights):
    """The few rows (few, vertices, 3) of such weights, as an iterator over them."""
    step = max(AT_ONCE // max(3 * rows.vertices, 1), 1)
    for start in range(0, weights.shape[1], step):
        some = weights[:, start:start + step]
        made = numpy.empty((some.shape[1], 3 * rows.vertices), numpy.float32)
        for first, last, chunk in rows.chunks():
            made[:, 3 * first:3 * last] = some.T @ chunk
        yield from made.reshape(some.shape[1], -1, 3)
