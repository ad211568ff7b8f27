"""Passes at common parameters: what patches are laid between."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from georibbon.arrays import BoolArray, FloatArray
from georibbon.geometry.frames import Strip, dot, frames_from, unit

PINCHED = 1e-3


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
