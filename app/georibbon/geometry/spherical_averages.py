"""Directions interpolated by weighted averages on the sphere.

The spherical average of directions c_i with weights w_i is the direction q with
the least sum of w_i times the squared angle to c_i.  With the cubic B-splines
as weights it is a twice differentiable curve; its control directions are found
so that it runs through given ones (Buss and Fillmore, Spherical averages and
applications to spherical splines and interpolation, 2001).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import FitError
from georibbon.geometry.frames import cross, dot, unit
from georibbon.geometry.spherical import check_directions, held_near, wrapped

MOST_STEPS, MOST_ROUNDS = 30, 400
SETTLED = 2e-13  # radians
LEAST_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class AverageSpline:
    """A twice differentiable curve on the unit sphere through given directions.

    s: (n,) float64, n >= 2, strictly ascending.  tangents: (n, 3) float64, unit.
    Called with (k,) parameters it gives (k, 3) unit vectors.  The B-splines are
    those of the plane's cubic spline without knots at the second and the second
    last of s; of fewer than four directions their degree is one less than their
    number.  Beyond the ends it is continued by at most half a pitch.  Raises
    FitError as `SphericalSpline` does, and where the directions turn so much
    that they have no average.
    """

    s: FloatArray
    tangents: FloatArray

    def __post_init__(self) -> None:
        check_directions(self.s, self.tangents)

    def __call__(self, s: FloatArray) -> FloatArray:
        """(k, 3) unit directions at the parameters s (k,)."""
        first, weights = self._basis(held_near(self.s, s))
        return weighted_average(self._controls[_run(first, weights)], weights)

    @cached_property
    def _knots(self) -> FloatArray:
        degree = min(3, len(self.s) - 1)
        inner = self.s[2:-2] if degree == 3 else self.s[:0]
        ends = np.full(degree + 1, self.s[0]), np.full(degree + 1, self.s[-1])
        return np.concatenate([ends[0], inner, ends[1]])

    def _basis(self, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """The number (k,) of the first B-spline that counts at s (k,), and the weights (k, d+1)."""
        degree = min(3, len(self.s) - 1)
        matrix = BSpline.design_matrix(s, self._knots, degree, extrapolate=True)
        shape = (len(s), degree + 1)
        return matrix.indices.reshape(shape)[:, 0].astype(np.int64), matrix.data.reshape(shape)

    @cached_property
    def _controls(self) -> FloatArray:
        """(n, 3) the directions whose averages at s are the tangents.

        Each round corrects them by what a plane's spline would need to make up
        for what is missed; by half of it wherever that brings them no nearer.
        """
        first, weights = self._basis(self.s)
        run = _run(first, weights)
        matrix = np.zeros((len(self.s), len(self.s)))
        np.put_along_axis(matrix, run, weights, axis=1)
        inverse = np.linalg.inv(matrix)
        controls, share, before = unit(inverse @ self.tangents), 1.0, np.inf
        for _ in range(MOST_ROUNDS):
            gap = self.tangents - weighted_average(controls[run], weights)
            away = float(np.abs(gap).max())
            if away <= SETTLED:
                return controls
            if away > before:
                share = max(share / 2.0, LEAST_SHARE)
            before, missed = away, inverse @ gap
            missed -= dot(missed, controls)[:, None] * controls
            controls = wrapped(controls, share * missed)
        raise FitError(_TURNS)


_TURNS = (
    "the tangents turn too much from one to the next to be interpolated by averages: take unrolled "
    "tangents, or lay the ribbon in a wider bend"
)


def _run(first: IntArray, weights: FloatArray) -> IntArray:
    """(k, w) the numbers of the directions that weights (k, w) belong to."""
    return first[:, None] + np.arange(weights.shape[1])


def weighted_average(directions: FloatArray, weights: FloatArray) -> FloatArray:
    """(k, 3) the spherical averages of unit directions (k, w, 3) with weights (k, w).

    The weights of each sum to one.  By Newton's method from the plain mean.
    Raises FitError where it does not settle: directions all around the sphere
    have no average.
    """
    q = unit(np.einsum("kw,kwi->ki", weights, directions))
    for _ in range(MOST_STEPS):
        step = _newton_step(q, directions, weights)
        q = wrapped(q, step)
        if not np.abs(step).max() > SETTLED:
            break
    else:
        raise FitError(_TURNS)
    return q


def _newton_step(q: FloatArray, directions: FloatArray, weights: FloatArray) -> FloatArray:
    """(k, 3) tangent steps from q (k, 3) to where the sum of the squared angles is least.

    A direction at the angle t along the unit tangent u has the gradient t u and
    the Hessian u u^T + t cot t (1 - u u^T).
    """
    along = directions - dot(directions, q[:, None])[..., None] * q[:, None]
    sine = np.sqrt(dot(along, along))
    angle = np.arctan2(sine, dot(directions, q[:, None]))
    ahead = along / np.where(sine > 0.0, sine, 1.0)[..., None]
    first = unit(cross(q, np.eye(3)[np.argmin(np.abs(q), axis=1)]))
    basis = np.stack([first, cross(q, first)], axis=1)
    local = np.einsum("kai,kwi->kwa", basis, ahead)
    flat = np.where(angle > 1e-6, angle / np.tan(np.maximum(angle, 1e-6)), 1.0) * weights
    gradient = np.einsum("kw,kwa->ka", weights * angle, local)
    hessian = np.einsum("kw,kwa,kwb->kab", weights - flat, local, local)
    hessian += np.sum(flat, axis=1)[:, None, None] * np.eye(2)
    det = hessian[:, 0, 0] * hessian[:, 1, 1] - hessian[:, 0, 1] ** 2
    if not (np.abs(det) > 1e-12).all():
        raise FitError(_TURNS)
    x = (hessian[:, 1, 1] * gradient[:, 0] - hessian[:, 0, 1] * gradient[:, 1]) / det
    y = (hessian[:, 0, 0] * gradient[:, 1] - hessian[:, 0, 1] * gradient[:, 0]) / det
    step: FloatArray = x[:, None] * basis[:, 0] + y[:, None] * basis[:, 1]
    return step
