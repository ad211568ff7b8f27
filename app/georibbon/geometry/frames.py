"""Curves on a surface with their frames.

A strip is one pass as a curve: its points by arc length and, at each, the
right-handed frame R = [tau, V, N]: tangent along the ribbon, conormal across
it, surface normal; V = N x tau.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.rotations import log, skew


@dataclass(frozen=True, eq=False)
class Strip:
    """A pass's curve with its frames.

    s: (n,) float64, metres, ascending.  points: (n, 3) float64, metres.
    frames: (n, 3, 3) float64, columns tau, V, N, orthonormal, right-handed.
    """

    s: FloatArray
    points: FloatArray
    frames: FloatArray

    @property
    def tangents(self) -> FloatArray:
        """(n, 3) unit tangents, along the ribbon."""
        return self.frames[:, :, 0]

    @property
    def conormals(self) -> FloatArray:
        """(n, 3) unit conormals V = N x tau, across the ribbon."""
        return self.frames[:, :, 1]

    @property
    def normals(self) -> FloatArray:
        """(n, 3) unit normals, out of the surface."""
        return self.frames[:, :, 2]

    def reversed(self) -> "Strip":
        """The same curve run backwards: s -> L - s, tau -> -tau, V -> -V, N kept."""
        frames = self.frames[::-1] * np.array([-1.0, -1.0, 1.0])
        return Strip(self.s[-1] - self.s[::-1], self.points[::-1], frames)


def curvatures(strip: Strip) -> tuple[FloatArray, FloatArray]:
    """Normal curvature k and geodesic torsion t of a strip of two points or more: (n,) each, 1/m.

    Positive curvature bends towards the normal, tau' . N = k, and V' . N = t.
    With w the rotation vector from one frame to the next divided by the step,
    k = -w2 and t = w1 between two points; at a point the mean of both sides.
    """
    rates = body_rates(strip)
    return -rates[:, 1], rates[:, 0]


def body_rates(strip: Strip) -> FloatArray:
    """(n, 3) 1/m: how the frames of a strip of two points or more turn about their own axes.

    The rotation vector from one frame to the next divided by the step is right
    to second order in its middle; at a point the mean of both sides stands, at
    an end the one.
    """
    turns = np.swapaxes(strip.frames[:-1], -1, -2) @ strip.frames[1:]
    rates = log(turns) / np.diff(strip.s)[:, None]
    return 0.5 * (np.vstack((rates[:1], rates)) + np.vstack((rates, rates[-1:])))


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """(...) the dot products of vectors (..., 3); many times faster than a sum over three."""
    product: FloatArray = (
        first[..., 0] * second[..., 0]
        + first[..., 1] * second[..., 1]
        + first[..., 2] * second[..., 2]
    )
    return product


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """(..., 3) the cross products of vectors (..., 3); faster than numpy's on many."""
    product = np.empty(np.broadcast_shapes(first.shape, second.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        product[..., i] = first[..., j] * second[..., k] - first[..., k] * second[..., j]
    return product


def unit(vectors: FloatArray) -> FloatArray:
    """(..., 3) vectors divided by their lengths; a zero vector stays zero."""
    length = np.sqrt(dot(vectors, vectors))[..., None]
    units: FloatArray = vectors / np.where(length > 0.0, length, 1.0)
    return units


def frames_from(tangents: FloatArray, normals: FloatArray) -> FloatArray:
    """(..., 3, 3) frames [tau, V, N]: tau kept, N made square to it, V = N x tau.

    tangents: (..., 3) unit.  normals: (..., 3), not along the tangents.
    """
    along = dot(normals, tangents)[..., None]
    squared = unit(normals - along * tangents)
    return np.stack([tangents, cross(squared, tangents), squared], axis=-1)


def interpolated(at: FloatArray, s: FloatArray, values: FloatArray) -> FloatArray:
    """(k, c) the columns of values (n, c), given at s (n,) ascending, linearly at `at` (k,)."""
    return np.stack([np.interp(at, s, column) for column in values.T], axis=1)


def arc_angles(first: FloatArray, second: FloatArray) -> FloatArray:
    """(...) radians between vectors (..., 3): atan2(|a x b|, a.b), exact near zero too."""
    square = cross(first, second)
    angles: FloatArray = np.arctan2(np.sqrt(dot(square, square)), dot(first, second))
    return angles


def rotations_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """(n, 3, 3) the smallest rotations that take unit vectors (n, 3) into unit vectors (n, 3).

    (a.b) I + [w]x + w w^T / (1 + a.b) with w = a x b; not defined for opposite vectors.
    """
    w = np.cross(first, second)
    outer = w[:, :, None] * w[:, None, :]
    cosine = np.sum(first * second, axis=1)[:, None, None]
    rotations: FloatArray = cosine * np.eye(3) + skew(w) + outer / (1.0 + cosine)
    return rotations


def transported(steps: FloatArray, start: FloatArray) -> FloatArray:
    """(n+1, 3, ...) the start (3, ...) carried along by the matrices (n, 3, 3), one by one."""
    carried = [start]
    for step in steps:
        carried.append(step @ carried[-1])
    return np.stack(carried)


def minimising_frame(points: FloatArray, tangents: FloatArray, start: FloatArray) -> FloatArray:
    """(n, 3) a unit normal field that does not turn about the curve.

    points: (n, 3) metres, no two neighbours equal.  tangents: (n, 3) unit.
    start: (3,) not along the first tangent.  Double reflection (Wang, Jüttler,
    Zheng and Liu, Computation of rotation minimizing frames, 2008): fourth
    order in the spacing.
    """
    first = reflections(np.diff(points, axis=0))
    mirrored = np.einsum("kij,kj->ki", first, tangents[:-1])
    steps = reflections(tangents[1:] - mirrored) @ first
    begin = frames_from(tangents[:1], start[None])[0, :, 2]
    return transported(steps, begin)


def reflections(across: FloatArray) -> FloatArray:
    """(n, 3, 3) the reflections I - 2 v v^T / v.v in the planes square to v (n, 3)."""
    squared = np.sum(across * across, axis=1)[:, None, None]
    mirrors: FloatArray = np.eye(3) - 2.0 * across[:, :, None] * across[:, None, :] / squared
    return mirrors
