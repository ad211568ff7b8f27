"""Curves on a surface as smooth functions: points, frames and how the frames turn.

A strip is given at single places; an edge is the spline through them, from
which the frame R = [tau, V, N] and its change along the curve,

    tau' = kg V + kn N,   V' = -kg tau - tg N,   N' = -kn tau + tg V   (per metre),

are found everywhere in closed form.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip, cross, dot
from georibbon.geometry.rails import interpolant


class Along(NamedTuple):
    """An edge at k places.

    points: (k, 3) metres.  slopes: (k, 3) the points' change by the place, about
    unit.  frames: (k, 3, 3), columns tau, V, N.  turns: (k, 3, 3) 1/m, the
    frames' change by the place.
    """

    points: FloatArray
    slopes: FloatArray
    frames: FloatArray
    turns: FloatArray

    @property
    def normals(self) -> FloatArray:
        """(k, 3) unit."""
        return self.frames[:, :, 2]


@dataclass(frozen=True, eq=False)
class Edge:
    """A strip, or a part of it, as a smooth curve.

    spline: of points and normals, as `interpolant` makes it.  first, last:
    metres, the part that counts; it is run backwards where last < first.
    """

    spline: BSpline
    first: float
    last: float

    @property
    def length(self) -> float:
        """Metres along the curve, negative where it is run backwards."""
        return self.last - self.first

    def at(self, s: FloatArray) -> Along:
        """The curve at places s (k,), metres; tau points the way that places ascend."""
        value, slope, bend = (self.spline(s, nu=order) for order in (0, 1, 2))
        speed = np.sqrt(dot(slope[:, :3], slope[:, :3]))[:, None]
        tau = slope[:, :3] / speed
        tau_turn = rejected(bend[:, :3], tau) / speed
        raw, raw_turn = value[:, 3:], slope[:, 3:]
        along = dot(raw, tau)[:, None]
        upright = raw - along * tau
        tilt = (dot(raw_turn, tau) + dot(raw, tau_turn))[:, None]
        upright_turn = raw_turn - tilt * tau - along * tau_turn
        size = np.sqrt(dot(upright, upright))[:, None]
        normal = upright / size
        normal_turn = rejected(upright_turn, normal) / size
        across_turn = cross(normal_turn, tau) + cross(normal, tau_turn)
        return Along(
            value[:, :3],
            slope[:, :3],
            np.stack([tau, cross(normal, tau), normal], axis=-1),
            np.stack([tau_turn, across_turn, normal_turn], axis=-1),
        )


def edge_of(strip: Strip) -> Edge:
    """The whole strip, of at least four points."""
    return Edge(interpolant(strip), float(strip.s[0]), float(strip.s[-1]))


def rejected(vectors: FloatArray, units: FloatArray) -> FloatArray:
    """(k, 3) vectors without their part along unit vectors (k, 3)."""
    left: FloatArray = vectors - dot(vectors, units)[:, None] * units
    return left
