"""Curves from unit tangents and frames: cubic splines on the sphere, integrated.

The unit tangents of a curve are points of the unit sphere.  They are
interpolated by unrolling: the sphere rolls without slipping or turning along
the great arcs between the samples onto a plane, a cubic spline is laid through
the plane's points, and the result is wrapped back (Jupp and Kent, Fitting
smooth paths to spherical data, 1987).  The curve through the origin is the
integral of the tangents; its error falls with the fourth power of the pitch.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.errors import FitError
from georibbon.geometry.frames import (
    Strip,
    arc_angles,
    frames_from,
    minimising_frame,
    rotations_between,
    transported,
    unit,
)

GREATEST_STEP = np.radians(120.0)
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


class TangentSpline(Protocol):
    """Unit tangents along a curve, given at s (n,); called with (k,) parameters: (k, 3)."""

    @property
    def s(self) -> FloatArray:
        """(n,) where they are given, ascending."""

    def __call__(self, s: FloatArray, /) -> FloatArray:
        """(k, 3) unit tangents at s (k,)."""


MakeSpline = Callable[[FloatArray, FloatArray], TangentSpline]
"""What makes a spline of parameters (n,) and unit tangents (n, 3)."""


@dataclass(frozen=True, eq=False)
class SphericalSpline:
    """A twice differentiable curve on the unit sphere through given directions.

    s: (n,) float64, n >= 2, strictly ascending.  tangents: (n, 3) float64, unit.
    Called with (k,) parameters it gives (k, 3) unit vectors.  It is continued
    by at most half a pitch beyond either end; farther out the direction stays.
    Raises FitError where two neighbours lie more than 120 degrees apart, where
    s does not ascend, or where a number is not finite.
    """

    s: FloatArray
    tangents: FloatArray

    def __post_init__(self) -> None:
        check_directions(self.s, self.tangents)

    def __call__(self, s: FloatArray) -> FloatArray:
        """(k, 3) unit directions at the parameters s (k,)."""
        s = held_near(self.s, s)
        k = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        share = ((s - self.s[k]) / (self.s[k + 1] - self.s[k]))[:, None]
        chord = self._plane[k] + share * (self._plane[k + 1] - self._plane[k])
        offset = self._spline(s) - chord
        base, first, second = self._rolled(k, share)
        return wrapped(base, offset[:, :1] * first + offset[:, 1:] * second)

    def _rolled(
        self, k: NDArray[np.intp], share: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The points at a share of the great arc from sample k on, and the basis carried there."""
        axis = unit(np.cross(self.tangents[k], self.tangents[k + 1]))
        angle = share * arc_angles(self.tangents[k], self.tangents[k + 1])[:, None]
        basis = self._basis[k]
        return (
            rotated(self.tangents[k], axis, angle),
            rotated(basis[:, :, 0], axis, angle),
            rotated(basis[:, :, 1], axis, angle),
        )

    @cached_property
    def _basis(self) -> FloatArray:
        """(n, 3, 2) two tangent directions of the sphere, carried from sample to sample."""
        start = frames_from(self.tangents[:1], any_normal(self.tangents[0])[None])[0, :, 1:]
        return transported(rotations_between(self.tangents[:-1], self.tangents[1:]), start)

    @cached_property
    def _plane(self) -> FloatArray:
        """(n, 2) the samples unrolled to the plane."""
        steps = unrolled_steps(self.tangents)
        local = np.einsum("kij,ki->kj", self._basis[:-1], steps)
        return np.concatenate([np.zeros((1, 2)), np.cumsum(local, axis=0)])

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.s, self._plane)


def check_directions(s: FloatArray, tangents: FloatArray) -> None:
    """Raise FitError unless unit tangents (n, 3) at s (n,) can be interpolated on the sphere."""
    check_knots(s, tangents)
    angles = arc_angles(tangents[:-1], tangents[1:])
    if angles.max() > GREATEST_STEP:
        k = int(np.argmax(angles))
        raise FitError(
            f"neighbouring tangents at {s[k]:.3f} m and {s[k + 1]:.3f} m point "
            f"{np.degrees(angles[k]):.0f}° apart, at most 120° can be interpolated: "
            "check the sensors there or lay the ribbon in a wider bend"
        )


def check_knots(s: FloatArray, values: FloatArray) -> None:
    """Raise FitError unless s (n,) ascends strictly, n >= 2, and all numbers are finite."""
    if len(s) < 2 or len(s) != len(values):
        raise FitError(
            f"{len(s)} positions with {len(values)} directions cannot give a curve: "
            "at least 2 of each are needed, as many of one as of the other"
        )
    if not (np.isfinite(s).all() and np.isfinite(values).all()):
        raise FitError("a direction along the ribbon is not a number: leave that sensor out")
    if (np.diff(s) <= 0.0).any():
        raise FitError(
            "positions along the ribbon do not ascend strictly: sort them and remove doubles"
        )


def any_normal(direction: FloatArray) -> FloatArray:
    """(3,) some vector well away from the direction (3,): the axis least along it."""
    axis: FloatArray = np.eye(3)[np.argmin(np.abs(direction))]
    return axis


def rotated(vectors: FloatArray, axis: FloatArray, angle: FloatArray) -> FloatArray:
    """(k, 3) vectors turned about unit (or zero) axes (k, 3) by angles (k, 1): Rodrigues."""
    along = np.sum(axis * vectors, axis=1, keepdims=True)
    cosine, sine = np.cos(angle), np.sin(angle)
    square = np.cross(axis, vectors)
    turned: FloatArray = cosine * vectors + sine * square + (1.0 - cosine) * along * axis
    return turned


def unrolled_steps(tangents: FloatArray) -> FloatArray:
    """(n-1, 3) logarithms on the sphere: at each of (n, 3) directions, towards the next."""
    here, there = tangents[:-1], tangents[1:]
    ahead = unit(there - np.sum(here * there, axis=1, keepdims=True) * here)
    return ahead * arc_angles(here, there)[:, None]


def wrapped(base: FloatArray, step: FloatArray) -> FloatArray:
    """(k, 3) exponential on the sphere: from the unit base (k, 3) along the tangent step (k, 3)."""
    angle: FloatArray = np.linalg.norm(step, axis=1, keepdims=True)
    return unit(np.cos(angle) * base + np.sinc(angle / np.pi) * step)


def held_near(knots: FloatArray, s: FloatArray) -> FloatArray:
    """(k,) parameters kept within half a pitch of the knots (n,)."""
    first, last = knots[1] - knots[0], knots[-1] - knots[-2]
    return np.clip(s, knots[0] - 0.5 * first, knots[-1] + 0.5 * last)


def integrate_tangents(spline: TangentSpline, s_out: FloatArray) -> FloatArray:
    """(k, 3) points of the curve with these tangents, the first at the origin.

    s_out: (k,) metres, ascending.  Four-point Gauss quadrature on every
    interval between the spline's knots and s_out.
    """
    inside = (spline.s > s_out[0]) & (spline.s < s_out[-1])
    nodes = np.union1d(spline.s[inside], s_out)
    half = 0.5 * np.diff(nodes)[:, None]
    middle = 0.5 * (nodes[:-1] + nodes[1:])[:, None]
    tangents = spline((middle + half * GAUSS_POINTS).ravel()).reshape(-1, len(GAUSS_POINTS), 3)
    steps = np.einsum("g,kgi->ki", GAUSS_WEIGHTS, tangents) * half
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return points[np.searchsorted(nodes, s_out)]


def curve_from_tangents(
    s_knots: FloatArray,
    tangents: FloatArray,
    s_out: FloatArray,
    made: MakeSpline = SphericalSpline,
) -> FloatArray:
    """(k, 3) points, metres, of the unit speed curve with the tangents (n, 3) at s_knots (n,).

    s_out: (k,) metres, ascending; the first point is the origin.  made: the
    spline of the tangents.  Raises FitError as that does.
    """
    return integrate_tangents(made(s_knots, tangents), s_out)


def interpolate_frames(
    s_knots: FloatArray,
    frames: FloatArray,
    s_out: FloatArray,
    made: MakeSpline = SphericalSpline,
) -> Strip:
    """The strip at s_out (k,), metres, ascending, from frames (n, 3, 3) at s_knots (n,).

    Frames have the columns tau, V, N.  made: the spline of the tangents; the
    points are its integral from the origin, and the normal's roll angle in a
    rotation minimising frame is a cubic spline.  Raises FitError as the
    tangents' spline does.
    """
    spline = made(s_knots, frames[:, :, 0])
    nodes = np.union1d(s_knots, s_out)
    points, tangents = integrate_tangents(spline, nodes), spline(nodes)
    first = minimising_frame(points, tangents, any_normal(tangents[0]))
    second = np.cross(tangents, first)
    at = np.searchsorted(nodes, s_knots)
    normals = frames[:, :, 2]
    roll = np.unwrap(
        np.arctan2(np.sum(normals * second[at], axis=1), np.sum(normals * first[at], axis=1))
    )
    at = np.searchsorted(nodes, s_out)
    angle = CubicSpline(s_knots, roll)(held_near(s_knots, s_out))[:, None]
    turned = np.cos(angle) * first[at] + np.sin(angle) * second[at]
    return Strip(s_out, points[at] - points[at[0]], frames_from(tangents[at], turned))
