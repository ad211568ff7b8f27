"""What ties add to the patches between passes, so that the surface runs through them.

Between two passes the Hermite patch is P1(u, v).  A tie crosses it along the line
u = U(v), straight from its crossing with the first pass to that with the second.
The bicubically blended Coons patch over the cells that passes and ties enclose is
the Boolean sum P1 + P2 - P2P1, that is

    F = P1 + sum over ties t of  h_t(u, v) A_t(v) + g_t(u, v) B_t(v)

    A_t(v)  from P1 to the tie, C_t(v) - P1(U_t(v), v)
    B_t(v)  what P1_u lacks of the tie's tangent plane, -(P1_u . N_t) N_t

with h_t, g_t the cubic Hermite functions along u of value and slope at the tie,
which vanish, value and slope, at the neighbouring ties; outside the first and the
last tie they fade out over some reach.  Where A, B, A', B' vanish on the passes,
F keeps the passes and their normals whatever lies beside, and is once continuously
differentiable across the ties.  For A' = 0 the lines across must leave the passes
as the ties do: F_v(u, 0) is steered within the tangent plane by
sum of h_t(u, 0) (x_t V + y_t tau), and alike at v = 1.  How ties are brought to
pass all this is told in `georibbon.geometry.cells`.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.rails import Rails

STEP_U = 1e-5  # m
STEP_V = 1e-4


class Blends(NamedTuple):
    """The functions h and g of T ties on a grid with their derivatives, (T, k, m) each."""

    h: FloatArray
    g: FloatArray
    h_u: FloatArray
    g_u: FloatArray
    h_v: FloatArray
    g_v: FloatArray


class Lift(NamedTuple):
    """What is added to a patch on a grid: to its points, F_u and F_v, (k, m, 3) each."""

    points: FloatArray
    along: FloatArray
    across: FloatArray


@dataclass(frozen=True, eq=False)
class PatchLift:
    """What T ties add to one patch, in the order of u.

    crossings: (T, 2) the parameters u at which they cross the first pass and the
    second.  reach: metres of u over which they fade out before the first and
    after the last.  steer: (T, 2, 2) metres, x along V and y along tau, at the
    first pass and the second.  parts: spline of v -> (T, 2, 3), A and B.
    """

    crossings: FloatArray
    reach: tuple[float, float]
    steer: FloatArray
    parts: CubicSpline

    def blends(self, u: FloatArray, v: FloatArray) -> Blends:
        """The blending functions on the grid u (k,), v (m,)."""
        slope = np.diff(self.crossings, axis=1)
        lines = self.crossings[:, :1] + slope * v
        gaps, gap_rates = np.diff(lines, axis=0), np.diff(slope, axis=0)
        before, after = (np.full((1, len(v)), reach) for reach in self.reach)
        still = np.zeros((1, 1))
        away = u[:, None] - lines[:, None]
        right = away >= 0.0
        width = np.where(
            right,
            np.concatenate([gaps, after])[:, None],
            np.concatenate([before, gaps])[:, None],
        )
        width_v = np.where(
            right,
            np.concatenate([gap_rates, still])[:, None],
            np.concatenate([still, gap_rates])[:, None],
        )
        side = np.where(right, 1.0, -1.0)
        x = np.minimum(side * away / width, 1.0)
        x_u, x_v = side / width, -(side * slope[:, None] + x * width_v) / width
        one, other = (2.0 * x - 3.0) * x * x + 1.0, ((x - 2.0) * x + 1.0) * x
        # At x = 1 both derivatives vanish by themselves.
        one_x, other_x = 6.0 * x * (x - 1.0), (3.0 * x - 4.0) * x + 1.0
        return Blends(
            one,
            side * width * other,
            one_x * x_u,
            other_x,
            one_x * x_v,
            side * (width_v * other + width * other_x * x_v),
        )

    def at(self, u: FloatArray, v: FloatArray) -> Lift:
        """What is added on the grid u (k,), v (m,)."""
        on = self.blends(u, v)
        value, rate = self.parts(v), self.parts(v, nu=1)

        def summed(h: FloatArray, g: FloatArray, parts: FloatArray) -> FloatArray:
            of = "tkm,mtx->kmx"
            total: FloatArray = np.einsum(of, h, parts[:, :, 0]) + np.einsum(of, g, parts[:, :, 1])
            return total

        return Lift(
            summed(on.h, on.g, value),
            summed(on.h_u, on.g_u, value),
            summed(on.h_v, on.g_v, value) + summed(on.h, on.g, rate),
        )

    def bends(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What is added to F_uu, F_uv and F_vv, (k, m, 3) each, by differences."""
        more_u, less_u = self.at(u + STEP_U, v), self.at(u - STEP_U, v)
        more_v, less_v = self.at(u, v + STEP_V), self.at(u, v - STEP_V)
        return (
            (more_u.along - less_u.along) / (2.0 * STEP_U),
            (more_v.along - less_v.along) / (2.0 * STEP_V),
            (more_v.across - less_v.across) / (2.0 * STEP_V),
        )

    def steering(self, frames: FloatArray, u: FloatArray) -> FloatArray:
        """(2, k, 3) what is added to F_v on the two passes, with frames (2, k, 3, 3), at u (k,)."""
        shares = self.blends(u, np.array([0.0, 1.0])).h
        xy = np.einsum("tke,tec->ekc", shares, self.steer)
        steering: FloatArray = xy[..., :1] * frames[..., 1] + xy[..., 1:] * frames[..., 0]
        return steering


@dataclass(frozen=True, eq=False)
class Cells:
    """What ties add to all patches; None for those that they leave as they are."""

    lifts: tuple[PatchLift | None, ...]

    def steered(self, control: FloatArray, rails: Rails, u: FloatArray) -> FloatArray:
        """The cubic control (p-1, k, 4, 3) of all patches at u (k,), steered into the ties."""
        steered = control.copy()
        for i, lift in enumerate(self.lifts):
            if lift is not None:
                steered[i, :, 1:3] += np.swapaxes(lift.steering(rails.frames[i : i + 2], u), 0, 1)
        return steered
