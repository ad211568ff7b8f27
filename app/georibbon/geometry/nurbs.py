"""Rational bicubic B-spline surfaces (NURBS) with their derivatives.

p = A / w with A the B-spline surface of the weighted control points and w that
of the weights (Piegl and Tiller, The NURBS Book, 1997, 4.4); its derivatives
follow from A = w p by the product rule,

    p_u = (A_u - w_u p) / w,   p_uv = (A_uv - w_u p_v - w_v p_u - w_uv p) / w,
    p_uu = (A_uu - 2 w_u p_u - w_uu p) / w,   and so in v.
"""

from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import NamedTuple

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SurfaceError
from georibbon.geometry.reference import Jet, ReferenceSurface

DEGREE = 3


@dataclass(frozen=True, eq=False)
class NurbsSurface(ReferenceSurface):
    """A rational bicubic B-spline surface.

    net: (m, n, 3) float64, metres, m and n at least 4.  weights: (m, n), above
    zero.  knots_u: (m + 4,), knots_v: (n + 4,), not descending, clamped or not;
    u runs from the fourth of its knots to the fourth from its end, v likewise.
    The normals point outwards where the net's rows (u) and columns (v) turn as
    x and y do seen from outside.

    Within the box a knot that stands twice breaks the second derivatives, one
    that stands three times the first; there they are those beyond it.  Outside
    the box the surface goes on as the end span does.  Raises SurfaceError for
    what is no such surface.
    """

    net: FloatArray
    weights: FloatArray
    knots_u: FloatArray
    knots_v: FloatArray

    def __post_init__(self) -> None:
        if self.net.ndim != 3 or self.net.shape[2] != 3 or min(self.net.shape[:2]) <= DEGREE:
            raise SurfaceError(
                f"a control net of shape {self.net.shape} is found; (m, n, 3) is expected, "
                "with m and n at least 4"
            )
        if self.weights.shape != self.net.shape[:2]:
            raise SurfaceError(
                f"{self.weights.shape} weights are found for a control net of "
                f"{self.net.shape[:2]} points; give one for each point"
            )
        if not (np.isfinite(self.net).all() and np.isfinite(self.weights).all()):
            raise SurfaceError("a control point or a weight is not a number: give finite ones")
        if self.weights.min() <= 0.0:
            raise SurfaceError(
                f"a weight of {self.weights.min():g} is found; all must be above zero"
            )
        check_cubic_knots(self.knots_u, self.net.shape[0])
        check_cubic_knots(self.knots_v, self.net.shape[1])

    @property
    def lower(self) -> tuple[float, float]:
        """Where u and v begin."""
        return (float(self.knots_u[DEGREE]), float(self.knots_v[DEGREE]))

    @property
    def upper(self) -> tuple[float, float]:
        """Where u and v end."""
        return (float(self.knots_u[-DEGREE - 1]), float(self.knots_v[-DEGREE - 1]))

    def jet(self, uv: FloatArray) -> Jet:
        """The quotient A / w and its derivatives."""
        first_u, bu = self._bases[0](uv[:, 0])
        first_v, bv = self._bases[1](uv[:, 1])
        four = np.arange(DEGREE + 1)
        local = self._weighted[
            (first_u[:, None] + four)[:, :, None], (first_v[:, None] + four)[:, None, :]
        ]
        rows = np.einsum("dni,nijk->dnjk", bu, local)
        both = np.einsum("enj,dnjk->denk", bv, rows)
        a, w = both[..., :3], both[..., 3:] / both[0, 0, :, 3:]
        a = a / both[0, 0, :, 3:]
        p = a[0, 0]
        pu, pv = a[1, 0] - w[1, 0] * p, a[0, 1] - w[0, 1] * p
        return Jet(
            p,
            pu,
            pv,
            a[2, 0] - 2 * w[1, 0] * pu - w[2, 0] * p,
            a[1, 1] - w[1, 0] * pv - w[0, 1] * pu - w[1, 1] * p,
            a[0, 2] - 2 * w[0, 1] * pv - w[0, 2] * p,
        )

    @cached_property
    def _bases(self) -> tuple["CubicBasis", "CubicBasis"]:
        return cubic_basis(self.knots_u), cubic_basis(self.knots_v)

    @cached_property
    def _weighted(self) -> FloatArray:
        """(m, n, 4) the control points times their weights, and the weights."""
        weights = self.weights[..., None]
        return np.concatenate([self.net * weights, weights], axis=2)


def check_cubic_knots(knots: FloatArray, count: int) -> None:
    """Raise SurfaceError unless knots are those of a continuous cubic with `count` controls."""
    if knots.shape != (count + DEGREE + 1,):
        raise SurfaceError(
            f"{knots.size} knots are found for {count} control points; {count + DEGREE + 1} are "
            "expected, four more than points"
        )
    if not np.isfinite(knots).all() or (np.diff(knots) < 0.0).any():
        raise SurfaceError("the knots are not finite numbers that do not descend: sort them")
    if not knots[DEGREE] < knots[count]:
        raise SurfaceError("the knots leave no parameter between the fourth and the fourth last")
    inner = knots[(knots > knots[DEGREE]) & (knots < knots[count])]
    if len(inner) and np.unique(inner, return_counts=True)[1].max() > DEGREE:
        raise SurfaceError(
            "a knot stands four times or more inside, which tears the surface; at most three "
            "times is expected"
        )


class CubicBasis(NamedTuple):
    """Cubic B-splines, span by span as cubics in the distance from where the span starts.

    starts: (k,), of the spans, ascending.  first: (k,), the number of the first
    of the four B-splines that are not zero in a span.  powers: (k, 4, 4), the
    factors of 1, h, h² and h³ in each of the four.
    """

    starts: FloatArray
    first: IntArray
    powers: FloatArray

    def __call__(self, at: FloatArray) -> tuple[IntArray, FloatArray]:
        """The first (n,) of the four at parameters (n,), and (3, n, 4) values and two derivatives.

        Beyond the ends as in the end spans.
        """
        span = np.maximum(np.searchsorted(self.starts, at, side="right") - 1, 0)
        h = at - self.starts[span]
        terms = np.zeros((3, len(at), DEGREE + 1))
        terms[0, :, 0] = terms[1, :, 1] = 1.0
        terms[0, :, 1], terms[1, :, 2], terms[2, :, 2] = h, 2.0 * h, 2.0
        terms[0, :, 2] = h * h
        terms[0, :, 3], terms[1, :, 3], terms[2, :, 3] = h**3, 3.0 * h * h, 6.0 * h
        return self.first[span], np.einsum("dnp,npf->dnf", terms, self.powers[span])


def cubic_basis(knots: FloatArray) -> CubicBasis:
    """The cubic B-splines of knots (m + 4,), as `check_cubic_knots` wants them.

    By the recurrence of Cox and de Boor at the spans' starts: the values there
    and three derivatives make the cubics.
    """
    inside = knots[DEGREE : len(knots) - DEGREE]
    span = DEGREE + np.flatnonzero(np.diff(inside) > 0.0)
    starts = knots[span]
    orders = [np.ones((len(span), 1))]
    for degree in range(1, DEGREE + 1):
        slopes = [_difference(knots, span, one, degree) for one in orders]
        orders = [_raised(knots, span, orders[0], starts), *slopes]
    powers = np.stack([one / factorial(k) for k, one in enumerate(orders)], axis=1)
    return CubicBasis(starts, span - DEGREE, powers)


def _supports(knots: FloatArray, span: IntArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Where the `degree` B-splines of one degree less begin and end, each (n, degree)."""
    first = span[:, None] - degree + 1 + np.arange(degree)
    return knots[first], knots[first + degree]


def _raised(knots: FloatArray, span: IntArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """(n, d + 1) B-splines of degree d, from those of one degree less (n, d)."""
    start, end = _supports(knots, span, values.shape[1])
    share = values / (end - start)
    raised = np.zeros((len(values), values.shape[1] + 1))
    raised[:, 1:] = (at[:, None] - start) * share
    raised[:, :-1] += (end - at[:, None]) * share
    return raised


def _difference(knots: FloatArray, span: IntArray, values: FloatArray, degree: int) -> FloatArray:
    """(n, d + 1) derivatives of B-splines of degree d, from (n, d) of one degree less."""
    start, end = _supports(knots, span, degree)
    share = degree * values / (end - start)
    slopes = np.zeros((len(values), degree + 1))
    slopes[:, 1:] = share
    slopes[:, :-1] -= share
    return slopes


def clamped_knots(count: int) -> FloatArray:
    """(count + 4,) evenly spaced knots from 0 to 1, the end ones four times."""
    inner = np.linspace(0.0, 1.0, count - DEGREE + 1)
    return np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])
