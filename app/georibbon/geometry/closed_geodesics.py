"""Geodesics that have a closed form: on cones and spheres; and Clairaut's constant.

A cone unrolls to the plane, where a geodesic is a straight line.  With a the
angle between axis and side, r0 the slant distance from the apex where it is
least, s the arc length from there and phi the azimuth,

    r = hypot(r0, s),   phi = phi0 + atan(s / r0) / sin a,

that is r = r0 / cos((phi - phi0) sin a), and with the normal outwards

    k = tau'.N = -r0² cot(a) / r³,   t = V'.N = r0 s cot(a) / r³

as the azimuth grows.  (Sprynski et al. 2008 print the height of their cone as
atan a times the distance from the axis; it must be 1 / tan a, or the curves
are no geodesics.)
"""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, cross, dot, frames_from, unit
from georibbon.geometry.reference import Cone


def cone_geodesic(cone: Cone, nearest: float, azimuth: float, s: FloatArray) -> Strip:
    """The geodesic of a cone that comes no nearer to its axis than `nearest` metres.

    azimuth: radians, where it is nearest; the azimuth grows along it, as the
    cone's u.  s: (n,) ascending signed distances from there, metres; the strip's
    arc length starts at 0, where s is least.  Raises SurfaceError where it
    would run through the apex or cross itself behind it, which it does on
    cones sharper than 30 degrees.
    """
    if not (np.isfinite(nearest) and nearest > 0.0):
        raise SurfaceError(
            f"the geodesic is to come {nearest:g} m near to the cone's axis: give a distance above "
            "zero, for only straight sides run through the apex"
        )
    sine = np.sin(np.radians(cone.half_angle))
    slant = nearest / sine
    _check_crossing(slant, sine, s)
    rho = np.hypot(slant, s)
    jet = cone.jet(np.stack([azimuth + np.arctan(s / slant) / sine, rho], axis=1))
    tangents = jet.pu * (slant / (rho**2 * sine))[:, None] + jet.pv * (s / rho)[:, None]
    return Strip(s - s[0], jet.p, frames_from(unit(tangents), jet.normals))


def _check_crossing(slant: float, sine: float, s: FloatArray) -> None:
    """A point and its mirror image behind the apex coincide at half a turn either way."""
    if np.pi * sine >= np.pi / 2:
        return
    limit = slant * np.tan(np.pi * sine)
    if -s[0] >= limit and s[-1] >= limit:
        raise SurfaceError(
            f"the geodesic crosses itself {limit:.3f} m before and beyond its point nearest to the "
            f"cone's axis, and {-s[0]:.3f} m before to {s[-1]:.3f} m beyond are asked for: end it "
            "earlier on one side"
        )


def cone_distances(cone: Cone, nearest: float, angles: FloatArray) -> FloatArray:
    """(n,) signed distances along a cone's geodesic to azimuths from its point nearest to the axis.

    nearest: metres, as in `cone_geodesic`.  angles: (n,) radians, less than a
    quarter turn over the sine of the half angle, where the geodesic has gone to
    infinity; raises SurfaceError from there on.
    """
    sine = np.sin(np.radians(cone.half_angle))
    most = np.pi / 2 / sine
    if np.abs(angles).max() >= most:
        raise SurfaceError(
            f"a geodesic turns by {np.degrees(most):.1f}° about this cone's axis either way at "
            f"most, and {np.degrees(np.abs(angles).max()):.1f}° are asked for: give less"
        )
    return np.asarray(nearest / sine * np.tan(angles * sine))


def cone_curvatures(cone: Cone, nearest: float, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Normal curvature and geodesic torsion V' . N, (n,) each, 1/m, of `cone_geodesic`.

    As `georibbon.geometry.frames.curvatures` gives them; the source paper's torsion is N' . V.
    """
    half = np.radians(cone.half_angle)
    slant = nearest / np.sin(half)
    rho = np.hypot(slant, s)
    return -(slant**2) / np.tan(half) / rho**3, slant * s / np.tan(half) / rho**3


def sphere_geodesic(
    radius: float, point: FloatArray, direction: FloatArray, s: FloatArray
) -> Strip:
    """The great circle of a sphere about the origin through a point, its frames outwards.

    point: (3,), not zero, taken onto the sphere; direction: (3,), made unit and
    tangent.  s: (n,) ascending signed distances from the point, metres.  Raises
    SurfaceError where it would run over itself, or has no direction.
    """
    if s[-1] - s[0] > 2 * np.pi * radius:
        raise SurfaceError(
            f"a great circle of a sphere of {radius:g} m is {2 * np.pi * radius:.3f} m long, and "
            f"{s[-1] - s[0]:.3f} m are asked for: it would run over itself; give less"
        )
    up = unit(point)
    along = unit(direction)
    ahead = along - dot(along, up) * up
    if not np.linalg.norm(ahead) > 1e-9:
        raise SurfaceError(
            "the direction stands upright on the sphere, or is none: give one along its surface"
        )
    ahead = unit(ahead)
    cosine, sine = np.cos(s / radius)[:, None], np.sin(s / radius)[:, None]
    normals = cosine * up + sine * ahead
    return Strip(s - s[0], radius * normals, frames_from(cosine * ahead - sine * up, normals))


def clairaut(strip: Strip, axis: FloatArray) -> FloatArray:
    """(n,) metres: the distance from an axis times the cosine of the angle to the parallels.

    axis: (3,) unit, through the origin.  Constant along the geodesics of a
    surface of revolution about it (Clairaut's relation), with the sign of the
    turn about it; its size is the least distance that the geodesic can come to
    the axis.
    """
    return dot(cross(strip.points, strip.tangents), axis)
