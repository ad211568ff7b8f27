"""Strips from curves as they come: with or without arc length and normals, exact or noisy.

Where nobody says how much to smooth, the noise of the points says it: that part
of them which differences of high order leave.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import BSpline

from georibbon.arrays import FloatArray
from georibbon.errors import SettingsError, SurfaceError
from georibbon.geometry.binormals import (
    bend_of,
    normals_from_bend,
    straight_stretches,
)
from georibbon.geometry.correspondence import agreement, aligned, arrange
from georibbon.geometry.frames import Strip, cross, dot, frames_from
from georibbon.geometry.frenet import curvature_vectors, curve_through
from georibbon.geometry.penalised import best_cut, penalised_spline
from georibbon.geometry.settings import NORMAL_RULES, NormalRule, require_one_of
from georibbon.geometry.spherical import GAUSS_POINTS, GAUSS_WEIGHTS

LEAST_POINTS = 4
MOST_CUT = 10.0  # m
SAME = 1e-9  # of the length: points nearer to each other are one
LEAST_SQUARE = 0.1  # the sine of the least angle between a normal and its tangent
LENGTH_MISFIT = 0.05  # of the length, between s and the points
ORDERS = (4, 6, 8)  # of the differences that tell noise
MOST_WINDOWS = 5000
LEAST_NOISE = 1e-7  # m: points less noisy are taken as they are
LEAST_ROLL_NOISE = 1e-4  # radians: normals less noisy likewise
CURVATURE_NOISE = 0.01  # 1/m: what the positions' smoothing leaves of noise
LEFT_OF_WHITE = np.sqrt(np.pi / 9.0)
BEND_LENGTH = 0.64  # m: the normals' cut is the geometric mean of this and the positions'
FINEST_BEND = 0.02  # m
BEND_SHARE, FINEST_SHARE = 2.0, 0.04  # both at most, of the length: small objects bend sharply
MEDIAN_OF_CHI_SQUARE = {1: 0.4549, 2: 1.3863, 3: 2.3660}


@dataclass(frozen=True)
class FramingSettings:
    """How a curve becomes a strip.

    normals: by which rule they are found where there are none (see
    `georibbon.geometry.binormals.normals_from_bend`).  normal_cut: metres, the
    detail of the normals' roll that is smoothed away; position_cut: metres, of
    the points.  Of both, 0 smooths nothing and None takes what the noise asks for.
    Raises SettingsError for what means nothing.
    """

    normals: NormalRule = "doubled-angle"
    normal_cut: float | None = None
    position_cut: float | None = None

    def __post_init__(self) -> None:
        require_one_of("rule for normals", self.normals, NORMAL_RULES)
        for name, cut in (("normals", self.normal_cut), ("positions", self.position_cut)):
            if cut is not None and not 0.0 <= cut <= MOST_CUT:
                raise SettingsError(
                    f"the smoothing of {name} is {1e3 * cut:g} mm; it must be a length from 0 to "
                    f"{1e3 * MOST_CUT:g} mm"
                )


@dataclass(frozen=True, eq=False)
class Framed:
    """A strip made of a curve, and how.

    noise: metres, of the points, each axis.  position_cut, normal_cut: metres,
    the smoothing done, 0 for none.  measured: whether normals were given.
    straight: (from, to) metres of stretches that are too straight to tell
    normals, where they were not given.
    """

    strip: Strip
    noise: float
    position_cut: float
    normal_cut: float
    measured: bool
    straight: tuple[tuple[float, float], ...]


USUAL = FramingSettings()


def framed(
    points: FloatArray,
    s: FloatArray | None = None,
    normals: FloatArray | None = None,
    settings: FramingSettings = USUAL,
) -> Strip:
    """The strip of a curve: see `frame_curve`."""
    return frame_curve(points, s, normals, settings).strip


def frame_curve(
    points: FloatArray,
    s: FloatArray | None = None,
    normals: FloatArray | None = None,
    settings: FramingSettings = USUAL,
) -> Framed:
    """The strip of a curve, and how it was made.

    points: (n, 3) metres, n >= 4, in order along the curve.  s: (n,) metres,
    ascending, its arc length; that of a spline through the points where not
    given.  normals: (n, 3) of any length; made square to the curve.  Without
    them they follow from how the curve bends, up to one sign for the curve.
    Raises SurfaceError where they do not make a strip.
    """
    check_curve(points, s, normals)
    places = arc_length(points) if s is None else s - s[0]
    noise = noise_of(places, points, 2 if s is None else 3)
    cut = position_cut(places, noise) if settings.position_cut is None else settings.position_cut
    if s is None and cut > 0.0:  # noise lengthens a curve
        places = arc_length(points, cut)
    curve = curve_through(places, points, cut)
    smooth = curve(places) if cut > 0.0 else points
    return _with_normals(curve, places, smooth, normals, settings, noise, cut)


def faced(strips: Sequence[Strip], free: Sequence[bool]) -> tuple[Strip, ...]:
    """Strips whose sides are free, such as those of normals found, faced as the others are.

    strips: two or more, any order and run.  free: for each whether its normals
    have one sign free.  Where all are free they face up (z), on the whole.
    """
    found = arrange(strips)
    flipped = dict(zip(found.order, found.flipped, strict=True))
    fixed = [flipped[i] for i, loose in enumerate(free) if not loose]
    if fixed:
        other = 2 * sum(fixed) > len(fixed)
    else:
        other = sum(float(one.normals[:, 2].mean()) for one in found.strips) < 0.0
    return tuple(
        aligned(strip, False, bool(loose and flipped[i] != other))
        for i, (strip, loose) in enumerate(zip(strips, free, strict=True))
    )


def faced_as(strip: Strip, others: Sequence[Strip]) -> Strip:
    """A strip across others, faced as they are where they lie nearest to it."""
    facing = sum(agreement(one, strip)[1] for one in others)
    return aligned(strip, False, facing < 0.0)


def _with_normals(
    curve: BSpline,
    s: FloatArray,
    points: FloatArray,
    normals: FloatArray | None,
    settings: FramingSettings,
    noise: float,
    cut: float,
) -> Framed:
    tangents, bent = curvature_vectors(curve, s)
    bend = bend_of(s, points, tangents, bent)
    if normals is None:
        over = settings.normal_cut
        over = bend_cut(s, cut) if over is None else over
        found = normals_from_bend(bend, settings.normals, over)
        straight = straight_stretches(bend, over)
        return Framed(
            Strip(s, points, frames_from(tangents, found)), noise, cut, over, False, straight
        )
    check_square(normals, tangents)
    roll = bend.roll(normals)
    over = roll_cut(s, roll) if settings.normal_cut is None else settings.normal_cut
    if over > 0.0:
        normals = bend.normals(penalised_spline(s, roll, over)(s))
    return Framed(Strip(s, points, frames_from(tangents, normals)), noise, cut, over, True, ())


def check_curve(points: FloatArray, s: FloatArray | None, normals: FloatArray | None) -> None:
    """Raise SurfaceError unless these are enough different, finite points with what belongs."""
    count = len(points)
    if points.shape != (count, 3) or count < LEAST_POINTS:
        raise SurfaceError(
            f"it has {count} point{'s' * (count != 1)}, at least {LEAST_POINTS} are needed"
        )
    for values, what, size in ((s, "arc lengths", 1), (normals, "normals", 3)):
        if values is not None and values.size != size * count:
            raise SurfaceError(
                f"it has {count} points and {len(values)} {what}: give as many of one as of the "
                "other, or none"
            )
    for values, what in ((points, "coordinates"), (s, "arc lengths"), (normals, "normals")):
        if values is not None and not np.isfinite(values).all():
            raise SurfaceError(f"not all of its {what} are finite numbers: leave these points out")
    steps = np.diff(points, axis=0)
    chords = np.sqrt(dot(steps, steps))
    if (chords <= SAME * chords.sum()).any():
        k = int(np.argmin(chords))
        raise SurfaceError(f"its points {k + 1} and {k + 2} are the same: leave one of them out")
    if s is not None:
        check_arc_length(s, float(chords.sum()))


def check_arc_length(s: FloatArray, chords: float) -> None:
    """Raise SurfaceError unless s (n,) ascends and is as long as the chords together, metres."""
    if (np.diff(s) <= SAME * abs(s[-1] - s[0])).any():
        k = int(np.argmin(np.diff(s)))
        raise SurfaceError(
            f"its arc length does not ascend from point {k + 1} to {k + 2}: sort the points, or "
            "leave s out"
        )
    length = float(s[-1] - s[0])
    if abs(length - chords) > LENGTH_MISFIT * chords:
        raise SurfaceError(
            f"its arc length runs over {length:.4g} m while its points span {chords:.4g} m from "
            "one to the next: both must have the same unit; correct s or leave it out"
        )


def check_square(normals: FloatArray, tangents: FloatArray) -> None:
    """Raise SurfaceError where a normal (n, 3) vanishes or lies along the curve."""
    across = cross(normals, tangents)
    sine = np.sqrt(dot(across, across))
    short = sine <= LEAST_SQUARE * np.sqrt(dot(normals, normals))
    if short.any():
        k = int(np.argmax(short))
        raise SurfaceError(
            f"its normal at point {k + 1} is zero or lies along the curve, it must stand across: "
            "correct it, or give no normals"
        )


def arc_length(points: FloatArray, cut: float = 0.0) -> FloatArray:
    """(n,) metres from 0: that of a spline through points (n, 3), or smoothed over `cut` metres.

    The spline's parameter is the chords' length; four-point Gauss quadrature
    of its speed from point to point.  Raises SurfaceError where it stands still.
    """
    steps = np.diff(points, axis=0)
    chords = np.concatenate([[0.0], np.cumsum(np.sqrt(dot(steps, steps)))])
    curve = curve_through(chords, points, cut)
    half = 0.5 * np.diff(chords)[:, None]
    velocity = curve(0.5 * (chords[:-1] + chords[1:])[:, None] + half * GAUSS_POINTS, nu=1)
    lengths = np.sum(GAUSS_WEIGHTS * np.sqrt(dot(velocity, velocity)), axis=1) * half[:, 0]
    if (lengths <= SAME * lengths.sum()).any():
        raise SurfaceError(
            "its points fall together where a smooth curve runs through them: put them in order "
            "along the curve, or smooth less"
        )
    return np.concatenate([[0.0], np.cumsum(lengths)])


def noise_of(s: FloatArray, values: FloatArray, shown: int | None = None) -> float:
    """The standard deviation of noise in values (n, c) at s (n,), each column, in their unit.

    The median of differences of the fourth, sixth and eighth order, the least
    of the three: differences of noise stay as large as it is, those of a smooth
    curve vanish with the order.  c is 1 or 3.  shown: in how many directions the
    noise shows, all where not given; 2 of 3 where s is the length of the points
    themselves, which hides it along the curve.  0 for fewer than 13 places.
    """
    if len(s) < ORDERS[-1] + 5:
        return 0.0
    least = min(_difference(s, values, order) for order in ORDERS)
    return float(np.sqrt(least / MEDIAN_OF_CHI_SQUARE[shown or values.shape[1]]))


def _difference(s: FloatArray, values: FloatArray, order: int) -> float:
    """The median square of the divided differences of an order, their coefficients of length 1."""
    every = 1 + len(s) // MOST_WINDOWS
    windows = sliding_window_view(s, order + 1)[::every]
    scaled = windows * (order / (windows[:, -1:] - windows[:, :1]))
    apart = scaled[:, :, None] - scaled[:, None, :] + np.eye(order + 1)
    factors = 1.0 / np.prod(apart, axis=2)
    factors /= np.sqrt(np.sum(factors**2, axis=1, keepdims=True))
    parts = sliding_window_view(values, order + 1, axis=0)[::every]
    found = np.einsum("kj,kcj->kc", factors, parts)
    return float(np.median(np.sum(found**2, axis=1)))


def position_cut(s: FloatArray, noise: float) -> float:
    """Metres: the smoothing that leaves so little of the points' noise that curvature is told.

    White noise of deviation e at spacing d leaves, on each axis, the curvature
    sqrt(pi / 9) e sqrt(d / cut) (2 pi / cut)², the integral of its spectrum
    under the spline's gain; the cut that makes this 0.01 1/m is taken.  0 for
    noise below a ten thousandth of a millimetre.
    """
    if noise < LEAST_NOISE:
        return 0.0
    length = float(s[-1] - s[0])
    spacing = length / (len(s) - 1)
    rate = LEFT_OF_WHITE * (2.0 * np.pi) ** 2 / CURVATURE_NOISE
    return float(min((rate * noise * np.sqrt(spacing)) ** 0.4, 0.5 * length, MOST_CUT))


def bend_cut(s: FloatArray, cut: float) -> float:
    """Metres: the smoothing of normals that are found, of points smoothed over `cut` metres."""
    length = float(s[-1] - s[0])
    finest = min(FINEST_BEND, FINEST_SHARE * length)
    return max(float(np.sqrt(min(BEND_LENGTH, BEND_SHARE * length) * cut)), finest)


def roll_cut(s: FloatArray, roll: FloatArray) -> float:
    """Metres: the smoothing of roll angles (n,) at s (n,) that cross validation chooses.

    0 where they are less noisy than a ten thousandth of a radian.
    """
    if noise_of(s, roll[:, None]) < LEAST_ROLL_NOISE:
        return 0.0
    return best_cut(s, roll)
