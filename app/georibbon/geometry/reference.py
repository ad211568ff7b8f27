"""Reference surfaces: analytic and B-spline surfaces whose every property is known.

A reference surface is a map p(u, v) with its first and second derivatives.
They are what the simulator lays its ribbons on and what results are scored
against.  All are vectorised: ``uv`` is (n, 2), every value (n, 3).  Lengths in
metres, angular parameters in radians.  The normal, cross(p_u, p_v) normalised,
points outwards on every surface here.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from georibbon.arrays import FloatArray
from georibbon.geometry.cubic_basis import CubicBasis, cubic_basis


class Jet(NamedTuple):
    """A surface's points and derivatives up to the second order, each (n, 3), metres."""

    p: FloatArray
    pu: FloatArray
    pv: FloatArray
    puu: FloatArray
    puv: FloatArray
    pvv: FloatArray

    @property
    def normals(self) -> FloatArray:
        """(n, 3) unit normals, outwards."""
        cross = np.cross(self.pu, self.pv)
        return np.asarray(cross / np.linalg.norm(cross, axis=1, keepdims=True), dtype=np.float64)


class ReferenceSurface(ABC):
    """A parametric surface with its derivatives.

    `lower`, `upper`: the corners of the box of (u, v) within which the surface
    is searched for closest points.  `periods`: the period of u and of v, 0
    where the parameter is not periodic.
    """

    @property
    @abstractmethod
    def lower(self) -> tuple[float, float]:
        """The least u and v."""

    @property
    @abstractmethod
    def upper(self) -> tuple[float, float]:
        """The greatest u and v."""

    @property
    def periods(self) -> tuple[float, float]:
        """The periods of u and v; 0: not periodic."""
        return (0.0, 0.0)

    @abstractmethod
    def jet(self, uv: FloatArray) -> Jet:
        """The points and derivatives at uv (n, 2)."""

    def points(self, uv: FloatArray) -> FloatArray:
        """(n, 3) points at uv (n, 2)."""
        return self.jet(uv).p

    def normals(self, uv: FloatArray) -> FloatArray:
        """(n, 3) outward unit normals at uv (n, 2)."""
        return self.jet(uv).normals


def _stack(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> FloatArray:
    """(n, 3) from three columns, each (n,) or a number."""
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1).astype(np.float64)


class Height(NamedTuple):
    """A height function's value and derivatives at n places, each (n,)."""

    z: FloatArray
    zx: FloatArray
    zy: FloatArray
    zxx: FloatArray
    zxy: FloatArray
    zyy: FloatArray


class RectangleSurface(ReferenceSurface):
    """A surface over a rectangle centred at the origin; length, width: metres, of u and v."""

    length: float
    width: float

    @property
    def lower(self) -> tuple[float, float]:
        """The rectangle's least corner."""
        return (-self.length / 2, -self.width / 2)

    @property
    def upper(self) -> tuple[float, float]:
        """The rectangle's greatest corner."""
        return (self.length / 2, self.width / 2)


class HeightSurface(RectangleSurface):
    """A surface z = f(x, y) over a rectangle centred at the origin; outwards is up."""

    @abstractmethod
    def height(self, x: FloatArray, y: FloatArray) -> Height:
        """f and its derivatives at x, y, each (n,)."""

    def jet(self, uv: FloatArray) -> Jet:
        """p = (u, v, f(u, v))."""
        x, y = uv[:, 0], uv[:, 1]
        h = self.height(x, y)
        zero = np.zeros_like(x)
        one = np.ones_like(x)
        return Jet(
            _stack(x, y, h.z),
            _stack(one, zero, h.zx),
            _stack(zero, one, h.zy),
            _stack(zero, zero, h.zxx),
            _stack(zero, zero, h.zxy),
            _stack(zero, zero, h.zyy),
        )


@dataclass(frozen=True)
class Plane(RectangleSurface):
    """A plane through the origin, tilted about the x axis: 0 level, 90 a vertical wall.

    tilt: degrees; at 90 the plane faces -y.  length, width: metres.
    """

    tilt: float = 0.0
    length: float = 3.0
    width: float = 3.0

    def jet(self, uv: FloatArray) -> Jet:
        """p = (u, v cos t, v sin t)."""
        cos, sin = np.cos(np.radians(self.tilt)), np.sin(np.radians(self.tilt))
        u, v = uv[:, 0], uv[:, 1]
        zero = np.zeros((len(uv), 3))
        across = np.tile([0.0, cos, sin], (len(uv), 1))
        along = np.tile([1.0, 0.0, 0.0], (len(uv), 1))
        return Jet(_stack(u, v * cos, v * sin), along, across, zero, zero, zero)


@dataclass(frozen=True)
class Ellipsoid(ReferenceSurface):
    """An ellipsoid with semi-axes a, b, c (metres) along x, y, z.

    u turns about the y axis from the top towards +x, v is the latitude towards
    +y: the poles, where the map is singular, lie at the sides, so that passes
    may run over the top.
    """

    a: float = 0.6
    b: float = 0.6
    c: float = 0.6

    @property
    def lower(self) -> tuple[float, float]:
        """Once around, nearly pole to pole."""
        return (-np.pi, -1.45)

    @property
    def upper(self) -> tuple[float, float]:
        """Once around, nearly pole to pole."""
        return (np.pi, 1.45)

    @property
    def periods(self) -> tuple[float, float]:
        """u is an angle."""
        return (2 * np.pi, 0.0)

    def jet(self, uv: FloatArray) -> Jet:
        """p = (a cos v sin u, b sin v, c cos v cos u)."""
        a, b, c = self.a, self.b, self.c
        su, cu = np.sin(uv[:, 0]), np.cos(uv[:, 0])
        sv, cv = np.sin(uv[:, 1]), np.cos(uv[:, 1])
        return Jet(
            _stack(a * cv * su, b * sv, c * cv * cu),
            _stack(a * cv * cu, 0.0, -c * cv * su),
            _stack(-a * sv * su, b * cv, -c * sv * cu),
            _stack(-a * cv * su, 0.0, -c * cv * cu),
            _stack(-a * sv * cu, 0.0, c * sv * su),
            _stack(-a * cv * su, -b * sv, -c * cv * cu),
        )


@dataclass(frozen=True)
class Cone(ReferenceSurface):
    """A circular cone, its apex at the origin, its axis pointing down.

    half_angle: degrees between axis and side.  length: metres of side covered.
    u is the azimuth, v the distance from the apex along the side.
    """

    half_angle: float = 40.0
    length: float = 2.0

    @property
    def lower(self) -> tuple[float, float]:
        """Once around; the apex left out."""
        return (-np.pi, 0.02)

    @property
    def upper(self) -> tuple[float, float]:
        """Once around, down to `length`."""
        return (np.pi, self.length)

    @property
    def periods(self) -> tuple[float, float]:
        """u is an angle."""
        return (2 * np.pi, 0.0)

    def jet(self, uv: FloatArray) -> Jet:
        """p = v (sin a cos u, -sin a sin u, -cos a): clockwise, so that the normal is out."""
        sin, cos = np.sin(np.radians(self.half_angle)), np.cos(np.radians(self.half_angle))
        su, cu, v = np.sin(uv[:, 0]), np.cos(uv[:, 0]), uv[:, 1]
        return Jet(
            _stack(v * sin * cu, v * sin * -su, -v * cos),
            _stack(v * sin * -su, v * sin * -cu, np.zeros_like(v)),
            _stack(sin * cu, sin * -su, -cos),
            _stack(v * sin * -cu, v * sin * su, np.zeros_like(v)),
            _stack(sin * -su, sin * -cu, np.zeros_like(v)),
            np.zeros((len(uv), 3)),
        )


@dataclass(frozen=True)
class Torus(ReferenceSurface):
    """A torus about the y axis (a pipe bent in a vertical plane) or, laid flat, about z.

    major, minor: metres, the radius of the centre line and of the tube.
    upright: True: the centre line lies in the x-z plane, u = 0 at its lowest
    point; v = 0 on the outside of the bend.  False: it lies level, u = 0 on
    the -y side, and v = 0 on top.
    """

    major: float = 0.5
    minor: float = 0.2
    upright: bool = False

    @property
    def lower(self) -> tuple[float, float]:
        """Once around both ways."""
        return (-np.pi, -np.pi)

    @property
    def upper(self) -> tuple[float, float]:
        """Once around both ways."""
        return (np.pi, np.pi)

    @property
    def periods(self) -> tuple[float, float]:
        """Both are angles."""
        return (2 * np.pi, 2 * np.pi)

    def jet(self, uv: FloatArray) -> Jet:
        """Tube of radius r about the circle of radius R, v turning about the tube."""
        turn = 0.0 if self.upright else np.pi / 2
        v = uv[:, 1] + turn
        su, cu, sv, cv = np.sin(uv[:, 0]), np.cos(uv[:, 0]), np.sin(v), np.cos(v)
        r, rho = self.minor, self.major + self.minor * cv
        flat = Jet(
            _ring(rho, su, -cu, r * sv),
            _ring(rho, cu, su, 0.0),
            _ring(-r * sv, su, -cu, r * cv),
            _ring(rho, -su, cu, 0.0),
            _ring(-r * sv, cu, su, 0.0),
            _ring(-r * cv, su, -cu, -r * sv),
        )
        if not self.upright:
            return flat
        return Jet(*(_stand(value) for value in flat))


def _ring(rho: FloatArray, x: FloatArray, y: FloatArray, z: ArrayLike) -> FloatArray:
    return _stack(rho * x, rho * y, z)


def _stand(value: FloatArray) -> FloatArray:
    """Turned a quarter about x: the -y side becomes the lowest, z becomes -y."""
    return _stack(value[:, 0], -value[:, 2], value[:, 1])


@dataclass(frozen=True)
class Cylinder(ReferenceSurface):
    """A circular cylinder.

    radius, length: metres.  upright: False: it lies along y, u = 0 on top, u
    turning towards +x; True: it stands along z, u = 0 facing -y (a curved
    vertical wall).
    """

    radius: float = 0.5
    length: float = 3.0
    upright: bool = False

    @property
    def lower(self) -> tuple[float, float]:
        """Once around, end to end."""
        return (-np.pi, -self.length / 2)

    @property
    def upper(self) -> tuple[float, float]:
        """Once around, end to end."""
        return (np.pi, self.length / 2)

    @property
    def periods(self) -> tuple[float, float]:
        """u is an angle."""
        return (2 * np.pi, 0.0)

    def jet(self, uv: FloatArray) -> Jet:
        """p = (r sin u, v, r cos u), or standing (r sin u, -r cos u, v)."""
        r, v = self.radius, uv[:, 1]
        su, cu = np.sin(uv[:, 0]), np.cos(uv[:, 0])
        zero = np.zeros((len(uv), 3))
        lying = Jet(
            _stack(r * su, v, r * cu),
            _stack(r * cu, 0.0, -r * su),
            _stack(np.zeros_like(v), 1.0, 0.0),
            _stack(-r * su, 0.0, -r * cu),
            zero,
            zero,
        )
        if not self.upright:
            return lying
        return Jet(*(_stand(value) for value in lying))


@dataclass(frozen=True)
class Saddle(HeightSurface):
    """z = (x² / rx - y² / ry) / 2: hollow along x, arched along y; radii in metres."""

    radius_x: float = 1.0
    radius_y: float = 0.8
    length: float = 2.0
    width: float = 2.0

    def height(self, x: FloatArray, y: FloatArray) -> Height:
        """The quadratic and its derivatives."""
        kx, ky = 1 / self.radius_x, 1 / self.radius_y
        one = np.ones_like(x)
        return Height(
            (kx * x**2 - ky * y**2) / 2, kx * x, -ky * y, kx * one, np.zeros_like(x), -ky * one
        )


@dataclass(frozen=True)
class Bonnet(HeightSurface):
    """A car bonnet: gently domed, with ripples along it, so that passes have inflections.

    z = -x² crown_x / 2 - y² crown_y / 2 + ripple cos(k x + 0.6) cos(1.5 y),
    k = 2 pi / wavelength.  Crowns in 1/m, ripple and wavelength in metres.
    """

    crown_x: float = 0.3
    crown_y: float = 0.9
    ripple: float = 0.02
    wavelength: float = 0.7
    length: float = 2.4
    width: float = 2.4

    def height(self, x: FloatArray, y: FloatArray) -> Height:
        """Crown plus ripple and derivatives."""
        k, q, a = 2 * np.pi / self.wavelength, 1.5, self.ripple
        cx, sx, cy, sy = np.cos(k * x + 0.6), np.sin(k * x + 0.6), np.cos(q * y), np.sin(q * y)
        return Height(
            -(self.crown_x * x**2 + self.crown_y * y**2) / 2 + a * cx * cy,
            -self.crown_x * x - a * k * sx * cy,
            -self.crown_y * y - a * q * cx * sy,
            -self.crown_x - a * k**2 * cx * cy,
            a * k * q * sx * sy,
            -self.crown_y - a * q**2 * cx * cy,
        )


@dataclass(frozen=True)
class Seat(HeightSurface):
    """A moulded seat: a level pan that turns up into a leaning back, hollow across.

    z = slope (x + sqrt(x² + bend²)) / 2 + hollow y² / 2.  slope: of the back;
    bend: metres, how softly the pan turns; hollow: 1/m.
    """

    slope: float = 1.6
    bend: float = 0.3
    hollow: float = 0.7
    length: float = 2.4
    width: float = 2.4

    def height(self, x: FloatArray, y: FloatArray) -> Height:
        """The hyperbola's branch plus the hollow, and derivatives."""
        root = np.hypot(x, self.bend)
        zero = np.zeros_like(x)
        return Height(
            self.slope * (x + root) / 2 + self.hollow * y**2 / 2,
            self.slope * (1 + x / root) / 2,
            self.hollow * y,
            self.slope * self.bend**2 / root**3 / 2,
            zero,
            zero + self.hollow,
        )


@dataclass(frozen=True)
class Hull(ReferenceSurface):
    """A boat's hull lying keel up: elliptic sections that grow narrow towards both ends.

    The section at x has the half-beam w(x) = beam/2 (1 - (x/l)²) and the
    height depth (1 - (x/l)²/2), l = length/2.  u is x (metres), v the angle
    from the keel towards -y.
    """

    length: float = 2.6
    beam: float = 0.9
    depth: float = 0.4

    @property
    def lower(self) -> tuple[float, float]:
        """Short of the ends, where the section vanishes."""
        return (-0.45 * self.length, -1.6)

    @property
    def upper(self) -> tuple[float, float]:
        """Short of the ends, where the section vanishes."""
        return (0.45 * self.length, 1.6)

    def jet(self, uv: FloatArray) -> Jet:
        """p = (u, w(u) sin v, d(u) cos v)."""
        u, s, c = uv[:, 0], np.sin(uv[:, 1]), np.cos(uv[:, 1])
        q = 4 / self.length**2
        b, d = self.beam / 2, self.depth
        w, wu, wuu = b * (1 - q * u**2), -2 * b * q * u, -2 * b * q
        h, hu, huu = d * (1 - q * u**2 / 2), -d * q * u, -d * q
        return Jet(
            _stack(u, w * s, h * c),
            _stack(np.ones_like(u), wu * s, hu * c),
            _stack(np.zeros_like(u), w * c, -h * s),
            _stack(np.zeros_like(u), wuu * s, huu * c),
            _stack(np.zeros_like(u), wu * c, -hu * s),
            _stack(np.zeros_like(u), -w * s, -h * c),
        )


@dataclass(frozen=True, eq=False)
class BSplineSurface(ReferenceSurface):
    """A uniform bicubic B-spline surface.

    net: (m, n, 3) float64, metres, m and n at least 4; its normals point
    outwards where the net's rows (u) and columns (v) turn as x and y do seen
    from outside.  u runs over [0, m - 3], v over [0, n - 3].
    """

    net: FloatArray

    @property
    def lower(self) -> tuple[float, float]:
        """(0, 0)."""
        return (0.0, 0.0)

    @property
    def upper(self) -> tuple[float, float]:
        """The numbers of spans."""
        return (self.net.shape[0] - 3.0, self.net.shape[1] - 3.0)

    def jet(self, uv: FloatArray) -> Jet:
        """Tensor products of the cubic basis and its derivatives; outside: the end span's cubic."""
        (first_u, bu), (first_v, bv) = (
            basis(column) for basis, column in zip(self._bases, uv.T, strict=True)
        )
        four = np.arange(4)
        local = self.net[(first_u[:, None] + four)[:, :, None], (first_v[:, None] + four)[:, None]]
        rows = np.einsum("dni,nijk->dnjk", bu, local)
        values = np.einsum("enj,dnjk->denk", bv, rows)
        return Jet(
            values[0, 0], values[1, 0], values[0, 1], values[2, 0], values[1, 1], values[0, 2]
        )

    @cached_property
    def _bases(self) -> tuple[CubicBasis, CubicBasis]:
        m, n = self.net.shape[:2]
        return cubic_basis(np.arange(-3.0, m + 1.0)), cubic_basis(np.arange(-3.0, n + 1.0))
