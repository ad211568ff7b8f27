"""Penalised splines: smoothing told as a length, chosen by cross validation where it is not given.

The cubic spline g that minimises

    sum_i w_i d_i |y_i - g(s_i)|² + mu int |g''|² ds,      mu = (cut / 2 pi)^4,

d_i being the spacing at s_i, passes a wave of length W with the gain
1 / (1 + (cut / W)^4): half of it at W = cut, whatever the sampling (Eilers and
Marx, Flexible smoothing with B-splines and penalties, 1996; the penalty here is
the integral itself).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SurfaceError

KNOTS_A_CUT = 8  # a wave of half the cut is still told from none
KNOTS_A_POINT = 4  # at most: below the spacing of the points a cut means nothing more
CUTS_TRIED = 24
FINEST_SHARE = 1 / 250  # of the length: the least cut that is tried
DEGREE = 3


@dataclass(frozen=True, eq=False)
class PenalisedFit:
    """The equations of a penalised spline, banded: (B^T W B + mu P) c = B^T W y.

    s: (n,) metres, ascending strictly, n >= 2.  cut: metres, above 0.
    weights: (n,) not negative, above 0 at two points or more; 1 where not given.
    Raises SurfaceError where they do not determine a spline.
    """

    s: FloatArray
    cut: float
    weights: FloatArray | None = None

    def __post_init__(self) -> None:
        if len(self.s) < 2 or (np.diff(self.s) <= 0.0).any():
            raise SurfaceError(
                f"{len(self.s)} places cannot be smoothed along: at least 2 are needed, ascending"
            )
        if not (np.isfinite(self.cut) and self.cut > 0.0):
            raise SurfaceError(
                f"a smoothing of {1e3 * self.cut:g} mm means nothing: choose a length above 0 mm"
            )
        if self.weights is not None and np.count_nonzero(self.weights > 0.0) < 2:
            raise SurfaceError("fewer than 2 places have a weight: nothing can be smoothed")

    @cached_property
    def knots(self) -> FloatArray:
        """Uniform knots over the places and 3 beyond both ends, at most an eighth cut apart."""
        length = float(self.s[-1] - self.s[0])
        most = KNOTS_A_POINT * len(self.s)
        intervals = int(np.ceil(min(KNOTS_A_CUT * length / self.cut, most)))
        steps = np.arange(-DEGREE, intervals + DEGREE + 1)
        return np.asarray(self.s[0] + length / intervals * steps)

    @cached_property
    def importance(self) -> FloatArray:
        """(n,) metres: the weight of each place times the spacing there."""
        spacing = np.gradient(self.s)
        return spacing if self.weights is None else spacing * self.weights

    @cached_property
    def _basis(self) -> tuple[IntArray, FloatArray]:
        """(n, 4) twice: which basis functions are not 0 at each place, and their values."""
        inside = np.clip(self.s, self.knots[DEGREE], self.knots[-DEGREE - 1])
        rows = BSpline.design_matrix(inside, self.knots, DEGREE)
        columns = rows.indices.reshape(-1, DEGREE + 1).astype(np.int64)
        return columns, rows.data.reshape(-1, DEGREE + 1)

    @cached_property
    def information(self) -> FloatArray:
        """(4, m) the lower bands of B^T W B."""
        columns, values = self._basis
        bands = np.zeros((DEGREE + 1, len(self.knots) - DEGREE - 1))
        weighted = self.importance[:, None] * values
        for below in range(DEGREE + 1):
            for j in range(DEGREE + 1 - below):
                np.add.at(bands[below], columns[:, j], weighted[:, j] * values[:, j + below])
        return bands

    @cached_property
    def _equations(self) -> FloatArray:
        mu = (self.cut / (2.0 * np.pi)) ** 4
        step = float(self.knots[1] - self.knots[0])
        return np.asarray(self.information + mu * roughness_bands(self.information.shape[1], step))

    def spline(self, values: FloatArray) -> BSpline:
        """The spline of values (n,) or (n, c); it is continued beyond its ends as a cubic."""
        columns, basis = self._basis
        flat = values.reshape(len(values), -1)
        right = np.zeros((self.information.shape[1], flat.shape[1]))
        weighted = self.importance[:, None] * basis
        for j in range(DEGREE + 1):
            np.add.at(right, columns[:, j], weighted[:, j : j + 1] * flat)
        solved = solveh_banded(self._equations, right, lower=True)
        return BSpline(self.knots, solved.reshape(-1, *values.shape[1:]), DEGREE)

    @cached_property
    def degrees_of_freedom(self) -> float:
        """The trace of the matrix that takes values to smoothed values."""
        size = self.information.shape[1]
        information = np.zeros((size, size))
        for below, band in enumerate(self.information):
            part = band[: size - below]
            at = np.arange(size - below)
            information[at + below, at] = information[at, at + below] = part
        return float(np.trace(solveh_banded(self._equations, information, lower=True)))

    def cross_validation(self, values: FloatArray) -> float:
        """The generalised cross validation n sum w r² / (n - trace)² of values (n,) or (n, c).

        Craven and Wahba, Smoothing noisy data with spline functions, 1979.
        """
        residuals = (values - self.spline(values)(self.s)).reshape(len(self.s), -1)
        weights = np.ones(len(self.s)) if self.weights is None else self.weights
        left = len(self.s) - self.degrees_of_freedom
        cost = len(self.s) * float(weights @ np.sum(residuals**2, axis=1))
        return cost / left**2 if left > 0.0 else np.inf


def roughness_bands(count: int, step: float) -> FloatArray:
    """(4, count) the lower bands of the integral of g''² for uniform cubic B-splines.

    g'' is linear between knots, its values there the coefficients' second
    differences over step²; an integral of a line's square from a to b is
    (a² + a b + b²) / 3 times the step.
    """
    second = np.array([1.0, -2.0, 1.0])
    bands = np.zeros((DEGREE + 1, count))
    intervals = np.arange(count - DEGREE)
    for first, last, factor in ((0, 0, 1 / 3), (1, 1, 1 / 3), (0, 1, 1 / 6), (1, 0, 1 / 6)):
        for i in range(3):
            for j in range(3):
                row, column = first + i, last + j
                if row >= column:
                    product = factor * second[i] * second[j] / step**3
                    bands[row - column, intervals + column] += product
    return bands


def penalised_spline(
    s: FloatArray, values: FloatArray, cut: float, weights: FloatArray | None = None
) -> BSpline:
    """The penalised spline of values (n,) or (n, c) at s (n,): half of a wave of `cut` passes.

    s: metres, ascending strictly.  cut: metres, above 0.  weights: (n,), 1
    where not given.  Raises SurfaceError as `PenalisedFit` does.
    """
    return PenalisedFit(s, cut, weights).spline(values)


def best_cut(
    s: FloatArray,
    values: FloatArray,
    cuts: Sequence[float] | FloatArray | None = None,
    weights: FloatArray | None = None,
) -> float:
    """The cut of least generalised cross validation, metres.

    cuts: those to try; where not given, 24 from twice the usual spacing to the
    whole length.  Right for noise that is not correlated from place to place.
    """
    tried = cuts_for(s) if cuts is None else np.asarray(cuts)
    scores = [PenalisedFit(s, float(cut), weights).cross_validation(values) for cut in tried]
    return float(tried[int(np.argmin(scores))])


def cuts_for(s: FloatArray) -> FloatArray:
    """(24,) metres: the cuts that mean something for places s (n,)."""
    length = float(s[-1] - s[0])
    finest = max(2.0 * float(np.median(np.diff(s))), FINEST_SHARE * length)
    return np.geomspace(min(finest, length), length, CUTS_TRIED)
