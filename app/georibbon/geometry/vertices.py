"""The vertices of all patches on one grid: where they lie and which way they face."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.components import crossed, dotted, inner, outer
from georibbon.geometry.patch import Lines, basis


def vertices_of(
    lines: Lines, counts: IntArray, upright: bool = False
) -> tuple[FloatArray, FloatArray]:
    """(k, w, 3) points and (k, w, 3) unit normals, with counts (p-1,) columns a patch.

    Neighbouring patches share the vertices on the pass between them, which
    carry the pass's own normals.  Where a patch is folded the normals are those
    of both passes, blended; upright: it is known that none is.
    """
    control, slope = (one.transpose(0, 3, 1, 2) for one in (lines.control, lines.slope))
    ends = np.cumsum(counts)
    shape = 3, control.shape[2], 1 + int(ends[-1])
    points, along, across = (np.empty(shape) for _ in range(3))
    for i, here in enumerate(columns_between(ends)):
        value, rate, shares = columns_of(int(counts[i]), control.shape[-1], i == 0)
        np.matmul(slope[i], value, out=along[..., here])
        np.matmul(control[i], rate, out=across[..., here])
        np.matmul(control[i], value, out=points[..., here])
        lift = None if lines.cells is None else lines.cells.lifts[i]
        if lift is not None and lines.u is not None:
            for of, more in zip((points, along, across), lift.at(lines.u, shares[1]), strict=True):
                of[..., here] += inner(more)
    normals, square = lines.rails.frames[..., 2], crossed(along, across)
    facing = divided_by_length(square if upright else unfolded(square, normals, counts))
    for column, upward in zip((0, *ends), normals, strict=True):
        facing[:, column] = upward
    return outer(points), facing


def columns_between(ends: IntArray) -> Iterator[slice]:
    """Which columns each patch gives, that end at `ends` (p-1,): the first all, others not
    their first.
    """
    begin = 0
    for end in ends.tolist():
        yield slice(begin, end + 1)
        begin = end + 1


def unfolded(square: FloatArray, normals: FloatArray, counts: IntArray) -> FloatArray:
    """(3, k, w) the same vectors, but where they face away from the blended normals these.

    normals: (p, k, 3) those of the passes.
    """
    blend = blended_normals(normals, counts)
    sense = dotted(square, blend)
    return square if sense.min() > 0.0 else np.where(sense > 0.0, square, blend)


def divided_by_length(vectors: FloatArray) -> FloatArray:
    """(k, w, 3) unit vectors, of vectors (3, k, w); a zero vector stays zero."""
    length = dotted(vectors, vectors)
    np.sqrt(length, out=length)
    if not length.all():
        length[length == 0.0] = 1.0
    units = np.empty((*length.shape, 3))
    for i, component in enumerate(vectors):
        np.divide(component, length, out=units[..., i])
    return units


def blended_normals(normals: FloatArray, counts: IntArray) -> FloatArray:
    """(3, k, w) the normals (p, k, 3) of passes, blended linearly between neighbours."""
    both = np.stack([normals[:-1], normals[1:]]).transpose(1, 3, 2, 0)
    ends = np.cumsum(counts)
    blend = np.empty((3, normals.shape[1], 1 + int(ends[-1])))
    for i, here in enumerate(columns_between(ends)):
        np.matmul(both[i], columns_of(int(counts[i]), 4, i == 0)[2], out=blend[..., here])
    return blend


@lru_cache(maxsize=256)
def columns_of(count: int, rows: int, first: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """For the columns at 1/count, 2/count to 1, and before them 0 where they are the first:

    the Hermite functions (rows, count), their derivatives, and either pass's shares (2, count).
    """
    v = np.arange(0 if first else 1, count + 1) / count
    value, rate = (np.ascontiguousarray(basis(v, order, rows).T) for order in (0, 1))
    shares = np.stack([1.0 - v, v])
    for made in (value, rate, shares):
        made.flags.writeable = False
    return value, rate, shares
