"""Where passes and ties lie on a surface."""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from georibbon.arrays import FloatArray
from georibbon.errors import SettingsError
from georibbon.geometry.closest import closest_point
from georibbon.geometry.frames import Strip
from georibbon.geometry.geodesics import directions_at, trace
from georibbon.geometry.reference import ReferenceSurface
from georibbon.simulation.settings import LayoutSettings
from georibbon.simulation.surfaces import SurfaceKind

SAMPLES_PER_METRE = 400
TOLERANCE = 1e-9
"""Of the integration: a nanometre, far below anything a ribbon sees."""


def lay_passes(
    surface: ReferenceSurface, kind: SurfaceKind, layout: LayoutSettings, length: float
) -> dict[str, Strip]:
    """The passes and ties as strips in the workpiece frame, by name: P1, ..., T1, ...

    The passes' middles lie on the geodesic that crosses the layout's start
    square to its heading, `spacing` apart; each pass runs half its length both
    ways from its middle, square to that geodesic but for the fan.
    """
    s = samples(length)
    uv, forward = _middles(surface, kind, layout)
    passes = _run(surface, uv, forward, s - length / 2, "P")
    return passes | _lay_ties(surface, layout, passes, s)


def samples(length: float) -> FloatArray:
    """(n,) the distances along a ribbon at which its curve is kept."""
    return np.linspace(0.0, length, round(SAMPLES_PER_METRE * length) + 1)


def _middles(
    surface: ReferenceSurface, kind: SurfaceKind, layout: LayoutSettings
) -> tuple[FloatArray, FloatArray]:
    """(n, 2) parameters of the passes' middles and (n, 3) the passes' directions there.

    Raises `SettingsError` for a start off the surface.
    """
    start = np.array([kind.start if layout.start is None else layout.start])
    if not _within(surface, start):
        (u0, v0), (u1, v1) = surface.lower, surface.upper
        raise SettingsError(
            f"the start {start[0, 0]:g},{start[0, 1]:g} is off the surface; give u from {u0:g} to "
            f"{u1:g} and v from {v0:g} to {v1:g}"
        )
    heading = kind.heading if layout.heading is None else layout.heading
    across = directions_at(surface, start, np.radians([heading + 90.0]))
    offsets = np.asarray(steps(layout) * _spacing(kind, layout), dtype=np.float64)
    uv, cross = trace(surface, start, across, offsets, TOLERANCE)
    strip = cross[0]
    fan = np.radians(fan_angles(layout))[:, None]
    return uv[:, 0], -strip.conormals * np.cos(fan) + strip.tangents * np.sin(fan)


def steps(layout: LayoutSettings) -> FloatArray:
    """(n,) the passes' places, counted from the middle."""
    return np.asarray(np.arange(layout.passes) - (layout.passes - 1) / 2, dtype=np.float64)


def _spacing(kind: SurfaceKind, layout: LayoutSettings) -> float:
    return kind.spacing if layout.spacing is None else layout.spacing


def fan_angles(layout: LayoutSettings) -> FloatArray:
    """(n,) degrees that each pass is turned off square."""
    if layout.fan_kind == "spread":
        return np.asarray(layout.fan * steps(layout))
    return np.asarray(layout.fan * (np.arange(layout.passes) % 2 - 0.5))


def _lay_ties(
    surface: ReferenceSurface,
    layout: LayoutSettings,
    passes: Mapping[str, Strip],
    s: FloatArray,
) -> dict[str, Strip]:
    """Geodesics square to the middle pass, their middles upon it."""
    if layout.ties == 0:
        return {}
    middle = passes[middle_pass(layout)]
    index = np.rint(tie_places(layout) * (len(s) - 1)).astype(np.int64)
    uv = closest_point(surface, middle.points[index]).uv
    return _run(surface, uv, middle.conormals[index], s - s[-1] / 2, "T")


def middle_pass(layout: LayoutSettings) -> str:
    """The name of the pass that the ties are square to."""
    return f"P{(layout.passes + 1) // 2}"


def tie_places(layout: LayoutSettings) -> FloatArray:
    """(t,) where the ties cross the middle pass, as fractions of the ribbon."""
    return np.array(layout.tie_places or np.linspace(0.1, 0.9, layout.ties + 2)[1:-1])


def _run(
    surface: ReferenceSurface,
    uv: FloatArray,
    directions: FloatArray,
    s: FloatArray,
    letter: str,
) -> dict[str, Strip]:
    """Geodesics named by `letter`; raises `SettingsError` where one leaves the surface."""
    paths, strips = trace(surface, uv, directions, s, TOLERANCE)
    for k, strip in enumerate(strips):
        if not np.isfinite(strip.frames).all() or not _within(surface, paths[:, k]):
            raise SettingsError(
                f"{letter}{k + 1} runs off the surface: choose another start, heading or spacing, "
                "fewer passes or a shorter ribbon"
            )
    return {f"{letter}{k + 1}": strip for k, strip in enumerate(strips)}


def _within(surface: ReferenceSurface, uv: FloatArray) -> bool:
    """Whether all of uv (m, 2) lie in the surface's box, periodic parameters aside."""
    inside = (uv >= surface.lower) & (uv <= surface.upper) | (np.array(surface.periods) > 0)
    return bool(inside.all())


class Curve:
    """A strip's points and frames at any arc length, by cubic Hermite interpolation."""

    def __init__(self, strip: Strip) -> None:
        """Of the strip as given."""
        self.strip = strip
        self._points = CubicHermiteSpline(strip.s, strip.points, strip.tangents)

    def points(self, s: FloatArray) -> FloatArray:
        """(n, 3) points at s (n,)."""
        return np.asarray(self._points(s), dtype=np.float64)

    def tangents(self, s: FloatArray) -> FloatArray:
        """(n, 3) derivatives by arc length at s (n,)."""
        return np.asarray(self._points(s, 1), dtype=np.float64)


def crossing(a: Strip, b: Strip, tolerance: float = 1e-6) -> tuple[float, float] | None:
    """The distances along two strips of one surface at which they meet, or None.

    tolerance: metres by which they may miss each other.  From the nearest pair
    of samples, by Gauss-Newton on the difference.
    """
    gaps = np.linalg.norm(a.points[:, None] - b.points[None], axis=2)
    i, j = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    first, second = Curve(a), Curve(b)
    at = np.array([a.s[i], b.s[j]])
    for _ in range(8):
        gap = first.points(at[:1])[0] - second.points(at[1:])[0]
        slopes = np.stack([first.tangents(at[:1])[0], -second.tangents(at[1:])[0]], axis=1)
        at = at - np.linalg.lstsq(slopes, gap)[0]
    inside = 0 <= at[0] <= a.s[-1] and 0 <= at[1] <= b.s[-1]
    gap = first.points(at[:1])[0] - second.points(at[1:])[0]
    if not inside or np.linalg.norm(gap) > tolerance:
        return None
    return float(at[0]), float(at[1])
