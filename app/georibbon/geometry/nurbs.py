"""Rational bicubic B-spline surfaces (NURBS) with their derivatives.

p = A / w with A the B-spline surface of the weighted control points and w that
of the weights (Piegl and Tiller, The NURBS Book, 1997, 4.4); its derivatives
follow from A = w p by the product rule,

    p_u = (A_u - w_u p) / w,   p_uv = (A_uv - w_u p_v - w_v p_u - w_uv p) / w,
    p_uu = (A_uu - 2 w_u p_u - w_uu p) / w,   and so in v.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.cubic_basis import DEGREE, CubicBasis, check_cubic_knots, cubic_basis
from georibbon.geometry.reference import Jet, ReferenceSurface


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
    def _bases(self) -> tuple[CubicBasis, CubicBasis]:
        return cubic_basis(self.knots_u), cubic_basis(self.knots_v)

    @cached_property
    def _weighted(self) -> FloatArray:
        """(m, n, 4) the control points times their weights, and the weights."""
        weights = self.weights[..., None]
        return np.concatenate([self.net * weights, weights], axis=2)
