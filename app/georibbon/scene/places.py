"""Where a result's sensors, frames, survey and border are to be drawn: arrays alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import interpolated
from georibbon.geometry.mesh import boundary_edges
from georibbon.geometry.surface import Surface
from georibbon.reconstruction import FittedPass, Reconstruction, SurveyResidual
from georibbon.ribbon import Ribbon

_NEAR = 1e-6  # m: a place this near to an end is on it


@dataclass(frozen=True, eq=False)
class Survey:
    """Where the survey's observations are on the fitted curves, metres.

    points: (k, 3) marks, and the middles of crossings.  ends: (e, 3) both fitted
    ends of distances.  gaps: (2, 3) of each crossing, from one curve to the
    other.  spans: (2, 3) of each distance.
    """

    points: FloatArray
    ends: FloatArray
    gaps: list[FloatArray]
    spans: list[FloatArray]


def survey_places(result: Reconstruction) -> Survey:
    """The places of all observations of passes that are in the result, where these reach them."""
    reach = {one.name: (one.strip.s[0] - _NEAR, one.strip.s[-1] + _NEAR) for one in result.passes}
    seen = [one for one in result.survey if reach.keys() >= set(one.passes) and _is_on(one, reach)]
    fitted = _fitted_ends(result, seen)
    points = [ends.mean(axis=0) for one, ends in zip(seen, fitted, strict=True) if _is_place(one)]
    gaps = [ends for one, ends in zip(seen, fitted, strict=True) if one.kind == "crossing"]
    spans = [ends for one, ends in zip(seen, fitted, strict=True) if one.kind == "distance"]
    bare = np.empty((0, 3))
    return Survey(np.array(points).reshape(-1, 3), np.concatenate([bare, *spans]), gaps, spans)


def _is_on(seen: SurveyResidual, reach: Mapping[str, tuple[float, float]]) -> bool:
    """Whether none of it lies on an end that was cut off."""
    return all(
        reach[name][0] <= at <= reach[name][1]
        for name, at in zip(seen.passes, seen.at, strict=True)
    )


def _is_place(seen: SurveyResidual) -> bool:
    return seen.kind != "distance"


def _fitted_ends(result: Reconstruction, seen: Sequence[SurveyResidual]) -> list[FloatArray]:
    """For each observation the (passes, 3) fitted points that it speaks of."""
    owners = [name for one in seen for name in one.passes]
    at = np.array([s for one in seen for s in one.at])
    points = np.empty((len(owners), 3))
    for fitted in result.passes:
        here = [k for k, name in enumerate(owners) if name == fitted.name]
        if here:
            points[here] = interpolated(at[here], fitted.strip.s, fitted.strip.points)
    counts = np.cumsum([len(one.passes) for one in seen])
    return np.split(points, counts[:-1]) if len(seen) else []


@dataclass(frozen=True, eq=False)
class SensorPlaces:
    """The sensors of all passes.

    points: (k, 3) metres.  frames: (k, 3, 3), columns tau, V, N.  used: (k,), whether it counts.
    """

    points: FloatArray
    frames: FloatArray
    used: np.ndarray[tuple[int], np.dtype[np.bool_]]


def sensor_places(result: Reconstruction) -> SensorPlaces:
    """Where every sensor lies on every pass, as far as the pass reaches."""
    parts = [_on_pass(fitted, result.ribbon) for fitted in result.passes]
    points, frames, used = zip(*parts, strict=True)
    return SensorPlaces(np.concatenate(points), np.concatenate(frames), np.concatenate(used))


def _on_pass(
    fitted: FittedPass, ribbon: Ribbon
) -> tuple[FloatArray, FloatArray, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
    strip = fitted.strip
    s = np.array([sensor.position for sensor in ribbon.sensors])
    ignored = np.array([sensor.name in fitted.sensors_ignored for sensor in ribbon.sensors])
    used = np.isfinite(fitted.residuals).any(axis=1) & ~ignored
    inside = (s >= strip.s[0]) & (s <= strip.s[-1])
    nearest = np.abs(strip.s[:, None] - s[inside]).argmin(axis=0)
    points = interpolated(s[inside], strip.s, strip.points)
    return points, strip.frames[nearest], used[inside]


def border(surface: Surface) -> list[FloatArray]:
    """The mesh's border as curves of (n, 3) points."""
    points, (rows, columns) = surface.mesh.vertices, surface.shape
    if rows * columns == len(points) and min(rows, columns) > 1:
        number = np.arange(rows * columns).reshape(rows, columns)
        sides = (number[0], number[1:, -1], number[-1, -2::-1], number[-2::-1, 0])
        return [points[np.concatenate(sides)]]
    return list(points[boundary_edges(surface.mesh)])


def grid(low: FloatArray, high: FloatArray, step: float, level: float) -> list[FloatArray]:
    """Lines of a level square grid from corner to corner (2,), as (2, 3) arrays."""
    lines = []
    for axis in (0, 1):
        for at in np.arange(low[axis], high[axis] + step / 2, step):
            ends = np.full((2, 3), level)
            ends[:, axis] = at
            ends[:, 1 - axis] = low[1 - axis], high[1 - axis]
            lines.append(ends)
    return lines
