"""Shapes as arrays: tubes along curves, and one small solid at each of many places.

Their triangles depend on counts alone, so that what moves is written into the
arrays that are drawn.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.frames import unit


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles (m, 3) over points (n, 3) with unit normals (n, 3)."""

    points: FloatArray
    normals: FloatArray
    triangles: IntArray


def tubes(curves: Sequence[FloatArray], radius: float, sides: int) -> Solid:
    """Round tubes of `sides` faces along curves of (n, 3) points each, n at least 2.

    Around every point of a curve there are `sides` points, and one at each end
    of the curve.
    """
    points: list[FloatArray] = []
    normals: list[FloatArray] = []
    triangles: list[IntArray] = []
    start = 0
    for alike in _runs_of_one_length(curves):
        rings, ends = _ring_directions(alike, sides)
        count, size = alike.shape[:2]
        walls = alike[:, :, None] + radius * rings
        for middle, ending, into in (
            (walls, alike[:, [0, -1]], points),
            (rings, ends, normals),
        ):
            flat = middle.reshape(count, size * sides, 3)
            into.append(np.concatenate((flat, ending), axis=1).reshape(-1, 3))
        each = size * sides + 2
        offsets = start + each * np.arange(count)
        triangles.append((offsets[:, None, None] + _tube_triangles(size, sides)).reshape(-1, 3))
        start += count * each
    return Solid(np.concatenate(points), np.concatenate(normals), np.concatenate(triangles))


def _runs_of_one_length(curves: Sequence[FloatArray]) -> list[FloatArray]:
    """(k, n, 3) for every run of k neighbouring curves of n points."""
    return [np.stack(list(group)) for _, group in groupby(curves, key=len)]


def around(values: Sequence[FloatArray], sides: int) -> FloatArray:
    """Values (n,) of each curve as values of the points of its tube."""
    return np.concatenate(
        [part for one in values for part in (np.repeat(one, sides), one[[0, -1]])]
    )


def _ring_directions(curves: FloatArray, sides: int) -> tuple[FloatArray, FloatArray]:
    """(k, n, sides, 3) unit vectors from the points of k curves square to them.

    They turn about a curve as a direction does that it nowhere runs along: the
    one in which it extends least.  And (k, 2, 3) the directions out of its ends.
    """
    steps = np.diff(curves, axis=1)
    first, last = steps[:, :1], steps[:, -1:]
    tangents = unit(np.concatenate((first, steps[:, :-1] + steps[:, 1:], last), axis=1))
    least = np.linalg.eigh(tangents.swapaxes(1, 2) @ tangents)[1][:, None, :, 0]
    across = unit(np.cross(least, tangents))[:, :, None]
    third = np.cross(tangents[:, :, None], across)
    turn = (2.0 * np.pi * np.arange(sides) / sides)[:, None]
    rings: FloatArray = across * np.cos(turn) + third * np.sin(turn)
    return rings, unit(np.concatenate((-first, last), axis=1))


@cache
def _tube_triangles(count: int, sides: int) -> IntArray:
    number = np.arange(count * sides).reshape(count, sides)
    following = np.roll(number, -1, axis=1)
    a, b, c, d = number[:-1], following[:-1], following[1:], number[1:]
    walls = np.stack((a, b, c, a, c, d), axis=-1).reshape(-1, 3)
    first, last = np.full(sides, count * sides), np.full(sides, count * sides + 1)
    shut = [
        np.stack((following[0], number[0], first), axis=-1),
        np.stack((number[-1], following[-1], last), axis=-1),
    ]
    return np.concatenate((walls, *shut))


def stamped(solid: Solid, places: FloatArray, size: float | FloatArray) -> Solid:
    """A solid, `size` (one, or one for each) times as large, at each of k places (k, 3)."""
    count = len(solid.points)
    offsets = count * np.arange(len(places))
    return Solid(
        (places[:, None] + np.reshape(size, (-1, 1, 1)) * solid.points).reshape(-1, 3),
        np.tile(solid.normals, (len(places), 1)),
        (offsets[:, None, None] + solid.triangles).reshape(-1, 3),
    )


@cache
def ball(cuts: int = 2) -> Solid:
    """A ball of radius 1: an octahedron whose faces are cut in four so often, and rounded."""
    points = np.vstack((np.eye(3), -np.eye(3)))
    triangles = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )
    for _ in range(cuts):
        points, triangles = _cut_in_four(points, triangles)
    return Solid(points, points, triangles)


def _cut_in_four(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Every triangle of a closed round mesh cut at the middles of its edges."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    pairs, which = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(points) + which.reshape(-1, 3)).T
    a, b, c = triangles.T
    cut = np.stack((a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca), axis=-1).reshape(-1, 3)
    return np.concatenate((points, unit(points[pairs].sum(axis=1)))), cut


@cache
def die() -> Solid:
    """A cube of half-width 1 with sharp edges."""
    points: list[FloatArray] = []
    normals, triangles = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            corner = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])[:: int(side)]
            face = np.insert(corner.astype(float), axis, side, axis=1)
            if axis == 1:
                face = face[::-1]
            start = 4 * len(points)
            points.append(face)
            normals.append(np.tile(np.insert(np.zeros(2), axis, side), (4, 1)))
            triangles.append(np.array([[0, 1, 2], [0, 2, 3]]) + start)
    return Solid(np.concatenate(points), np.concatenate(normals), np.concatenate(triangles))
