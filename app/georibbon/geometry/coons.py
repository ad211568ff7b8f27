"""The Coons patch between four geodesics with their normals.

The bicubically blended Coons patch (Coons 1964; Gordon 1969) is the Boolean sum

    F = P1 + P2 - P1P2
    P1 = H0(v) c0(u) + H1(v) F_v(u,0) + H2(v) F_v(u,1) + H3(v) c1(u)
    P2 = H0(u) d0(v) + H1(u) F_u(0,v) + H2(u) F_u(1,v) + H3(u) d1(v)

of the Hermite patches between the curves v = 0, 1 and those at u = 0, 1; P1P2 is
the bicubic patch that both agree on at the corners.  With cross derivatives in
the tangent planes of the curves, F_v(u,0) = x(u) V + y(u) tau, the patch has the
given normals along all four, which are then geodesics of it, and it meets any
other surface with these normals smoothly.

x and y are cubic between the corners, where F_v is the other curve's own
derivative.  Their slopes there give F_uv.  Its tangential part is free: the
mean of what x, y linear along either curve would give.  Its normal part is not:
either curve demands the other's derivative times its own N', and the two agree
only where the local condition of Farouki, Szafran and Biard (2009) holds (see
`georibbon.geometry.meetings`).  Both are honoured as in Gregory's patch (1974):
P1P2 takes (v w_c + u w_d) / (u + v) for the twist at the corner (0, 0), w_c that
of the curves v = const, w_d of the others, so that boundaries and normals are
exact even where the condition fails; the patch is then C1, not C2, at the corner.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.checks import Check, graded
from georibbon.geometry.edges import Along, Edge, edge_of
from georibbon.geometry.frames import Strip, cross, dot, unit
from georibbon.geometry.meetings import Corner, corner_of
from georibbon.geometry.patch import basis

CORNER_LIMIT = 1e-6  # m that curves may miss each other at a corner
NORMALS_LIMIT = 1e-4  # radians between their normals there
OBLIQUE_LIMIT = 30.0  # degrees
TWIST_LIMIT = 1.0  # 1/m
AGREE_LIMITS = (3.0, 15.0)  # degrees

CORNERS = ((0, 0), (1, 0), (0, 1), (1, 1))  # of (u, v)
HERMITE_ROWS = ((0, 1), (3, 2))  # the Hermite functions of value and slope at 0, at 1


class CoonsGrid(NamedTuple):
    """A patch on a grid: points, F_u, F_v, unit normals, each (k, m, 3)."""

    points: FloatArray
    along: FloatArray
    across: FloatArray
    normals: FloatArray


class Field(NamedTuple):
    """A boundary curve and the cross derivative along it.

    edge: the curve.  x, y: (4,) Hermite coefficients (value, slope at 0, slope,
    value at 1) of the cross derivative along V and tau, metres.
    """

    edge: Edge
    x: FloatArray
    y: FloatArray

    def at(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Curve, its derivative, cross derivative and its derivative at t (k,): (k, 3) each."""
        length = self.edge.length
        here = self.edge.at(self.edge.first + t * length)
        value, rate = basis(t), basis(t, 1)
        tau, across = here.frames[..., 0], here.frames[..., 1]
        tau_turn, across_turn = length * here.turns[..., 0], length * here.turns[..., 1]
        x, y = (value @ self.x)[:, None], (value @ self.y)[:, None]
        dx, dy = (rate @ self.x)[:, None], (rate @ self.y)[:, None]
        turning = dx * across + x * across_turn + dy * tau + y * tau_turn
        return here.points, length * here.slopes, x * across + y * tau, turning


@dataclass(frozen=True, eq=False)
class CoonsPatch:
    """A Coons patch F(u, v), u and v from 0 to 1.

    along: the fields of the curves v = 0 and v = 1; across: those of u = 0 and u = 1.
    corners: (2, 2, 3) F(0..1, 0..1); leave: (2, 2, 2, 3) F_u, F_v there; twists:
    (2, 2, 2, 3) F_uv as the curves v = const and as those u = const demand it.
    side: 1 or -1, which makes F_u x F_v face as the given normals do.
    """

    along: tuple[Field, Field]
    across: tuple[Field, Field]
    corners: FloatArray
    leave: FloatArray
    twists: FloatArray
    side: float

    def at(self, u: FloatArray, v: FloatArray) -> CoonsGrid:
        """The patch on the grid u (k,), v (m,)."""
        hu, hv, du, dv = basis(u), basis(v), basis(u, 1), basis(v, 1)
        rows, row_rates = stacked(self.along, u)
        columns, column_rates = stacked(self.across, v)
        both, both_u, both_v = self._common(u, v)

        def summed(
            over_v: FloatArray, r: FloatArray, over_u: FloatArray, c: FloatArray
        ) -> FloatArray:
            total: FloatArray = np.einsum("mi,ikx->kmx", over_v, r)
            total += np.einsum("ki,imx->kmx", over_u, c)
            return total

        points = summed(hv, rows, hu, columns) - both
        along = summed(hv, row_rates, du, columns) - both_u
        across = summed(dv, rows, hu, column_rates) - both_v
        return CoonsGrid(points, along, across, self.side * unit(cross(along, across)))

    def _common(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """P1P2 and its derivatives by u and v, (k, m, 3) each."""
        common = np.einsum("ki,ijx,mj->kmx", basis(u), self._bicubic, basis(v))
        by_u = np.einsum("ki,ijx,mj->kmx", basis(u, 1), self._bicubic, basis(v))
        by_v = np.einsum("ki,ijx,mj->kmx", basis(u), self._bicubic, basis(v, 1))
        for a, b in CORNERS:
            half = 0.5 * (self.twists[0, a, b] - self.twists[1, a, b])
            share, share_u, share_v = gregory(u if a == 0 else 1.0 - u, v if b == 0 else 1.0 - v)
            i, j = HERMITE_ROWS[a][1], HERMITE_ROWS[b][1]
            hu, hv = basis(u)[:, i, None], basis(v)[:, j]
            du, dv = basis(u, 1)[:, i, None], basis(v, 1)[:, j]
            common += (hu * hv * share)[..., None] * half
            by_u += (du * hv * share + (1 - 2 * a) * hu * hv * share_u)[..., None] * half
            by_v += (hu * dv * share + (1 - 2 * b) * hu * hv * share_v)[..., None] * half
        return common, by_u, by_v

    @cached_property
    def _bicubic(self) -> FloatArray:
        """(4, 4, 3) the Hermite coefficients of P1P2, with the mean of both twists."""
        found = np.empty((4, 4, 3))
        for a, b in CORNERS:
            (i, di), (j, dj) = HERMITE_ROWS[a], HERMITE_ROWS[b]
            found[i, j] = self.corners[a, b]
            found[di, j], found[i, dj] = self.leave[a, b]
            found[di, dj] = 0.5 * (self.twists[0, a, b] + self.twists[1, a, b])
        return found


def coons_patch(bottom: Strip, top: Strip, left: Strip, right: Strip) -> CoonsPatch:
    """The patch between four strips: bottom and top run along u, left and right along v.

    Bottom joins the starts, top the ends of left and right.  Each strip has four
    points or more; u and v are their places' shares.  Normals may face either
    side, all of them the same.
    Raises SurfaceError where curves or normals disagree at a corner, or where
    two curves run along each other there.
    """
    along = edge_of(bottom), edge_of(top)
    across = edge_of(left), edge_of(right)
    ends = [[(at_share(along[b], a), at_share(across[a], b)) for b in (0, 1)] for a in (0, 1)]
    for a, b in CORNERS:
        check_corner(*ends[a][b], f"u = {a}, v = {b}")
    leave = np.empty((2, 2, 2, 3))
    for a, b in CORNERS:
        one, other = ends[a][b]
        leave[a, b] = along[b].length * one.slopes[0], across[a].length * other.slopes[0]
    plain = [plain_field(along[b], leave[:, b, 1]) for b in (0, 1)]
    plain += [plain_field(across[a], leave[a, :, 0]) for a in (0, 1)]
    free = twists_of(plain).mean(axis=0)
    wanted = free[:, 0], free[:, 1], free[0], free[1]
    fields = [twisted(field, twist) for field, twist in zip(plain, wanted, strict=True)]
    corners = np.array([[ends[a][b][0].points[0] for b in (0, 1)] for a in (0, 1)])
    upright = cross(leave[0, 0, 0], leave[0, 0, 1]) @ ends[0][0][0].normals[0]
    side = 1.0 if upright > 0.0 else -1.0
    low, high, first, last = fields
    return CoonsPatch((low, high), (first, last), corners, leave, twists_of(fields), side)


def twists_of(fields: Sequence[Field]) -> FloatArray:
    """(2, 2, 2, 3) F_uv at the corners (u, v), as bottom and top demand it, and as left and right.

    fields: of bottom, top, left, right.
    """
    bottom, top, left, right = (field.at(np.array([0.0, 1.0]))[3] for field in fields)
    return np.stack([np.stack([bottom, top], axis=1), np.stack([left, right])])


def at_share(edge: Edge, share: float) -> Along:
    """The edge at a share of its length."""
    return edge.at(np.array([edge.first + share * edge.length]))


def check_corner(one: Along, other: Along, where: str) -> None:
    """Raise SurfaceError unless two curves meet, with one normal, at an angle."""
    apart = float(np.linalg.norm(one.points[0] - other.points[0]))
    corner = corner_of(one, other)
    advice = "bring the curves and their normals to one crossing first"
    if apart > CORNER_LIMIT:
        raise SurfaceError(
            f"the curves at the corner {where} lie {1e3 * apart:.4f} mm apart, "
            f"{1e3 * CORNER_LIMIT:g} mm at most is allowed: {advice}"
        )
    if corner.normals > NORMALS_LIMIT or corner.side < 0.0:
        raise SurfaceError(
            f"the normals of the curves at the corner {where} lie "
            f"{np.degrees(corner.normals):.3f}° apart or face opposite sides, "
            f"{np.degrees(NORMALS_LIMIT):.3f}° at most is allowed: {advice}"
        )
    if abs(np.sin(corner.angle)) < 1e-3:
        raise SurfaceError(
            f"the curves at the corner {where} run along each other; four curves that cross "
            "are needed: choose others"
        )


def plain_field(edge: Edge, leave: FloatArray) -> Field:
    """The field whose cross derivative is `leave` (2, 3) at the ends, x and y linear between."""
    frames = edge.at(np.array([edge.first, edge.last])).frames
    x, y = dot(leave, frames[..., 1]), dot(leave, frames[..., 0])
    return Field(edge, linear(x), linear(y))


def linear(ends: FloatArray) -> FloatArray:
    """(4,) the Hermite coefficients of the line between two values (2,)."""
    return np.array([ends[0], ends[1] - ends[0], ends[1] - ends[0], ends[1]])


def twisted(field: Field, twist: FloatArray) -> Field:
    """The field with other slopes at its ends, so that F_uv there has the tangential part given.

    twist: (2, 3) metres; its normal part does not count.
    """
    lacking = twist - field.at(np.array([0.0, 1.0]))[3]
    frames = field.edge.at(np.array([field.edge.first, field.edge.last])).frames
    x, y = field.x.copy(), field.y.copy()
    x[1:3] += dot(lacking, frames[..., 1])
    y[1:3] += dot(lacking, frames[..., 0])
    return Field(field.edge, x, y)


def stacked(fields: Sequence[Field], t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(4, k, 3) curve, cross derivatives, curve of two opposite fields, and their derivatives."""
    (c0, dc0, x0, dx0), (c1, dc1, x1, dx1) = (field.at(t) for field in fields)
    return np.stack([c0, x0, x1, c1]), np.stack([dc0, dx0, dx1, dc1])


def gregory(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(v - u) / (u + v) on a grid u (k,), v (m,), and its derivatives; 0 at the corner itself."""
    u, v = u[:, None], v[None]
    total = u + v
    apart = total > 0.0
    scale = np.where(apart, 1.0 / np.where(apart, total, 1.0), 0.0)
    return (v - u) * scale, -2.0 * v * scale**2, 2.0 * u * scale**2


def existence(bottom: Strip, top: Strip, left: Strip, right: Strip) -> tuple[Check, ...]:
    """Whether one smooth surface can hold four strips as geodesics, as checks with advice.

    Strips as for `coons_patch`, which may miss each other at the corners.  For
    all four corners: the curves' angle, how far their normals disagree (the
    global condition, with one orientation all around) and the residual of the
    local condition, 1/m.
    """
    along = [edge_of(strip) for strip in (bottom, top)]
    across = [edge_of(strip) for strip in (left, right)]
    names = (("bottom", "top"), ("left", "right"))
    found: list[Check] = []
    sides = []
    for a, b in CORNERS:
        one, other = at_share(along[b], a), at_share(across[a], b)
        corner = corner_of(one, other)
        found += corner_checks(corner, f"{names[0][b]}-{names[1][a]}")
        sides.append((corner.side, float(np.sign(corner.angle))))
    return (*found, orientation(sides))


def corner_checks(corner: Corner, where: str) -> tuple[Check, Check, Check]:
    """The checks of one crossing: its angle, its normals, the local condition."""
    return crossing_angle(corner, where), normals_agree(corner, where), twist_agrees(corner, where)


def crossing_angle(corner: Corner, where: str) -> Check:
    """How obliquely two curves cross: the acute angle between them."""
    angle = acute(corner)
    verdict = graded(-angle, -OBLIQUE_LIMIT, -1e-6)
    message = f"{where} cross at {angle:.0f}°"
    if verdict != "pass":
        message += f", {OBLIQUE_LIMIT:.0f}° at least is expected: lay them across each other"
    return Check("corner-angle", verdict, angle, "°", where, message)


def acute(corner: Corner) -> float:
    """Degrees, the angle between the two curves as lines, at most 90."""
    return float(np.degrees(np.arcsin(min(abs(np.sin(corner.angle)), 1.0))))


def normals_agree(corner: Corner, where: str) -> Check:
    """How far the normals of two curves disagree at their crossing."""
    angle = float(np.degrees(corner.normals))
    verdict = graded(angle, *AGREE_LIMITS)
    message = f"the normals of {where} differ by {angle:.2f}° where they cross"
    if verdict != "pass":
        message += (
            f", {AGREE_LIMITS[0]:.0f}° at most is expected: one of them may have lain twisted "
            "or not quite on the surface there; lay it again"
        )
    return Check("corner-normals", verdict, angle, "°", where, message)


def twist_agrees(corner: Corner, where: str) -> Check:
    """How far two curves see another twist of the surface at their crossing."""
    residual = abs(corner.residual)
    verdict = graded(residual, TWIST_LIMIT, np.inf)
    message = f"the twists of {where} differ by {residual:.2f} 1/m where they cross"
    if verdict != "pass":
        message += (
            f", {TWIST_LIMIT:.0f} 1/m at most is expected of curves on one smooth surface: "
            "the surface is bent a little to hold both; lay one of them again"
        )
    return Check("corner-twist", verdict, residual, "1/m", where, message)


def orientation(sides: Sequence[tuple[float, float]]) -> Check:
    """Whether all normals face one side of one loop: agreeing in pairs, turning the same way."""
    facing = {side for side, _ in sides}
    turning = {turn for _, turn in sides}
    good = facing == {1.0} and len(turning) == 1
    message = "the normals along the four curves face one side of one surface"
    if not good:
        message = (
            "the normals along the four curves do not face one side of one surface: turn over "
            "those of a curve that lay upside down, or give the four curves in their order"
        )
    value = 0.0 if good else 180.0
    return Check("corner-orientation", "pass" if good else "fail", value, "°", "cell", message)
