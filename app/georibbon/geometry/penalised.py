"""Penalised splines: smoothing told as a length, chosen by cross validation where it is not given.

The cubic spline g that minimises

    sum_i w_i d_i |y_i - g(s_i)|² + mu int |g^(m)|² ds,      mu = (cut / 2 pi)^2m,

d_i being the spacing at s_i and m, the order, 2 or 3, passes a wave of length W
with the gain 1 / (1 + (cut / W)^2m): half of it at W = cut, whatever the
sampling (Eilers and Marx, Flexible smoothing with B-splines and penalties,
1996; the penalty here is the integral itself).  Order 2 takes the second
derivative to 0 at the ends, order 3 leaves it there, which a curve needs that
is asked how it bends.
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
SHORTEST, LONGEST = 0.05, 20.0  # cuts that differ from none and from a line: of spacing and length
DEGREE = 3
# What an interval adds to the roughness, by its four coefficients: differences, and their products.
DIFFERENCES = np.array([[1.0, -2.0, 1.0, 0.0], [0.0, 1.0, -2.0, 1.0]])
OF_SECOND = DIFFERENCES.T @ np.array([[2.0, 1.0], [1.0, 2.0]]) @ DIFFERENCES / 6.0
OF_THIRD = np.outer(DIFFERENCES[1] - DIFFERENCES[0], DIFFERENCES[1] - DIFFERENCES[0])


@dataclass(frozen=True, eq=False)
class PenalisedFit:
    """The equations of a penalised spline, banded: (B^T W B + mu P) c = B^T W y.

    s: (n,) metres, ascending strictly, n >= order.  cut: metres, above 0.
    weights: (n,) not negative, above 0 at `order` points or more; 1 where not given.
    order: 2 or 3, of the derivative that is kept small.
    Raises SurfaceError where they do not determine a spline.
    """

    s: FloatArray
    cut: float
    weights: FloatArray | None = None
    order: int = 2

    def __post_init__(self) -> None:
        if len(self.s) < self.order or (np.diff(self.s) <= 0.0).any():
            raise SurfaceError(
                f"{len(self.s)} places cannot be smoothed along: at least {self.order} are needed, "
                "ascending"
            )
        if not (np.isfinite(self.cut) and self.cut > 0.0):
            raise SurfaceError(
                f"a smoothing of {1e3 * self.cut:g} mm means nothing: choose a length above 0 mm"
            )
        if self.weights is not None and np.count_nonzero(self.weights > 0.0) < self.order:
            raise SurfaceError(
                f"fewer than {self.order} places have a weight: nothing can be smoothed"
            )

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
        length = float(self.s[-1] - self.s[0])
        # Beyond these it is the interpolant, or a line, but for the digits of the numbers.
        cut = np.clip(self.cut, SHORTEST * length / len(self.s), LONGEST * length)
        mu = float(cut / (2.0 * np.pi)) ** (2 * self.order)
        step = float(self.knots[1] - self.knots[0])
        return np.asarray(
            self.information + mu * roughness_bands(self.information.shape[1], step, self.order)
        )

    def spline(self, values: FloatArray) -> BSpline:
        """The spline of values (n,) or (n, c); it is continued beyond its ends as a cubic."""
        columns, basis = self._basis
        flat = values.reshape(len(values), -1)
        right = np.zeros((self.information.shape[1], flat.shape[1]))
        weighted = self.importance[:, None] * basis
        for j in range(DEGREE + 1):
            np.add.at(right, columns[:, j], weighted[:, j : j + 1] * flat)
        solved = self._solved(right)
        return BSpline(self.knots, solved.reshape(-1, *values.shape[1:]), DEGREE)

    def _solved(self, right: FloatArray) -> FloatArray:
        try:
            return np.asarray(solveh_banded(self._equations, right, lower=True))
        except np.linalg.LinAlgError as error:
            raise SurfaceError(
                "the points lie too unevenly along the curve to be smoothed: spread them evenly"
            ) from error

    @cached_property
    def degrees_of_freedom(self) -> float:
        """The trace of the matrix that takes values to smoothed values."""
        size = self.information.shape[1]
        information = np.zeros((size, size))
        for below, band in enumerate(self.information):
            part = band[: size - below]
            at = np.arange(size - below)
            information[at + below, at] = information[at, at + below] = part
        return float(np.trace(self._solved(information)))

    def cross_validation(self, values: FloatArray) -> float:
        """The generalised cross validation n sum w r² / (n - trace)² of values (n,) or (n, c).

        Craven and Wahba, Smoothing noisy data with spline functions, 1979.
        """
        residuals = (values - self.spline(values)(self.s)).reshape(len(self.s), -1)
        weights = np.ones(len(self.s)) if self.weights is None else self.weights
        left = len(self.s) - self.degrees_of_freedom
        cost = len(self.s) * float(weights @ np.sum(residuals**2, axis=1))
        return cost / left**2 if left > 0.0 else np.inf


def roughness_bands(count: int, step: float, order: int = 2) -> FloatArray:
    """(4, count) the lower bands of the integral of g''² or g'''² for uniform cubic B-splines.

    g'' is linear between knots, its values there the coefficients' second
    differences over step²; an integral of a line's square from a to b is
    (a² + a b + b²) / 3 times the step.  g''' is their third difference over
    step³, the same from knot to knot.
    """
    bands = np.zeros((DEGREE + 1, count))
    intervals = np.arange(count - DEGREE)
    product = OF_SECOND / step**3 if order == 2 else OF_THIRD / step**5
    for row in range(DEGREE + 1):
        for column in range(row + 1):
            bands[row - column, intervals + column] += product[row, column]
    return bands


def penalised_spline(
    s: FloatArray,
    values: FloatArray,
    cut: float,
    weights: FloatArray | None = None,
    order: int = 2,
) -> BSpline:
    """The penalised spline of values (n,) or (n, c) at s (n,): half of a wave of `cut` passes.

    s: metres, ascending strictly.  cut: metres, above 0.  weights: (n,), 1
    where not given.  order: 2 or 3.  Raises SurfaceError as `PenalisedFit` does.
    """
    return PenalisedFit(s, cut, weights, order).spline(values)


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
