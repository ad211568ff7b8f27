"""Passes at common parameters: what patches are laid between."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from georibbon.arrays import BoolArray, FloatArray
from georibbon.geometry.components import crossed, dotted, outer
from georibbon.geometry.frames import Strip, dot, frames_from, unit

PINCHED = 1e-3
SMALLEST = 1e-150  # a length that is divided by in the place of none


@dataclass(frozen=True, eq=False)
class Rails:
    """All strips at common parameters.

    points: (p, k, 3) metres.  frames: (p, k, 3, 3), columns tau, V, N.
    """

    points: FloatArray
    frames: FloatArray

    @cached_property
    def chords(self) -> FloatArray:
        """(p-1, k, 3) metres, from each strip to the next."""
        return np.diff(self.points, axis=0)

    @cached_property
    def gaps(self) -> FloatArray:
        """(p-1, k) metres between matched points of neighbours."""
        length: FloatArray = np.sqrt(dot(self.chords, self.chords))
        return length

    @property
    def pinched(self) -> BoolArray:
        """(p-1, k) where neighbours lie within a millimetre of each other."""
        near: BoolArray = self.gaps < PINCHED
        return near


@dataclass(frozen=True, eq=False)
class Rates:
    """How rails go on: their derivatives by the common parameter.

    points: (p, k, 3).  frames: (p, k, 3, 3), columns those of tau, V and N, 1/m.
    """

    points: FloatArray
    frames: FloatArray


def interpolant(strip: Strip) -> BSpline:
    """A spline through a strip's points and normals: s -> (..., 6); quintic, cubic under 6 points.

    A strip needs 4 points.
    """
    degree = 5 if len(strip.s) > 5 else 3
    return make_interp_spline(
        strip.s, np.concatenate([strip.points, strip.normals], axis=1), k=degree
    )


def sampled(spline: BSpline, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (k, 3) and frames (k, 3, 3) of an interpolated strip at s (k,).

    The tangent is the curve's own, the normal made square to it.
    """
    values = spline(s)
    tangents = unit(spline(s, nu=1)[:, :3])
    return values[:, :3], frames_from(tangents, values[:, 3:])


def sampled_all(splines: Sequence[BSpline], places: FloatArray) -> Rails:
    """All strips at their own places (p, k), metres."""
    raw = raw_values(splines, places, 2)
    ahead, _ = length_divided(raw[1, :3])
    upright, _ = length_divided(raw[0, 3:] - dotted(raw[0, 3:], ahead) * ahead)
    return Rails(outer(raw[0, :3]), joined(ahead, crossed(upright, ahead), upright))


def sampled_moving(
    splines: Sequence[BSpline], places: FloatArray, rates: FloatArray
) -> tuple[Rails, Rates]:
    """All strips at their own places (p, k), metres, that change at rates (p, k)."""
    raw = raw_values(splines, places, 3)
    ahead, speed = length_divided(raw[1, :3])
    bend = raw[2, :3]
    turn = (bend - dotted(bend, ahead) * ahead) / speed
    facing, change = raw[0, 3:], raw[1, 3:]
    along = dotted(facing, ahead)
    upright, size = length_divided(facing - along * ahead)
    lean = change - (dotted(change, ahead) + dotted(facing, turn)) * ahead - along * turn
    tilt = (lean - dotted(lean, upright) * upright) / size
    sideways = crossed(tilt, ahead) + crossed(upright, turn)
    rails = Rails(outer(raw[0, :3]), joined(ahead, crossed(upright, ahead), upright))
    moves = joined(rates * turn, rates * sideways, rates * tilt)
    return rails, Rates(outer(rates * raw[1, :3]), moves)


def raw_values(splines: Sequence[BSpline], places: FloatArray, orders: int) -> FloatArray:
    """(orders, 6, p, k) points and normals as interpolated, and their derivatives by arc length."""
    raw = np.empty((orders, 6, *places.shape))
    for i, (spline, s) in enumerate(zip(splines, places, strict=True)):
        for order in range(orders):
            raw[order, :, i] = spline(s, nu=order).T
    return raw


def length_divided(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(3, ...) vectors divided by their lengths, and these (...)."""
    length = np.maximum(np.sqrt(dotted(vectors, vectors)), SMALLEST)
    return vectors / length, length


def joined(ahead: FloatArray, across: FloatArray, upright: FloatArray) -> FloatArray:
    """(p, k, 3, 3) frames with columns (3, p, k); in memory column by column."""
    return np.stack([ahead, across, upright]).transpose(2, 3, 1, 0)
