"""Cubic B-splines of any knots, and their derivatives."""

from math import factorial
from typing import NamedTuple

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SurfaceError

DEGREE = 3


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
