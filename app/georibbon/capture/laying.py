"""A plan laid on an assumed surface: where its passes, ties and measurements would be."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.capture.plan import CapturePlan, PlannedLayout, places, tie_places
from georibbon.errors import SettingsError
from georibbon.fitting.grid import Grid, Shape, integrate_frames, integrate_positions, make_grid
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import Bonnet, Cylinder, Plane, ReferenceSurface
from georibbon.recording import Crossing, Distance, Mark, Pass, Recording, Workpiece
from georibbon.ribbon import Readings, Ribbon
from georibbon.rotations import log
from georibbon.simulation.capture import frames_at
from georibbon.simulation.layout import Curve, crossing, lay_passes
from georibbon.simulation.settings import LayoutSettings
from georibbon.simulation.surfaces import surface_kind

Likeness = Literal["flat", "gentle", "bent"]
LIKENESSES: tuple[Likeness, ...] = ("flat", "gentle", "bent")
WORDS: dict[Likeness, str] = {
    "flat": "a level, flat panel",
    "gentle": "a gently domed and rippled panel, like a car bonnet",
    "bent": "a pipe that every pass bends over by about 120°",
}
# Passes, at least and at most, and passes times sensors; more change the figures little and take
# long.  Ties likewise.
LEAST_LAID, MOST_LAID, MOST_SENSORS = 3, 12, 384
MOST_TIES, MOST_TIE_SENSORS = 12, 1536
SIZE = 0.96  # m, the ribbon for which the surfaces' proportions are meant
TURN = 2.1  # radians that a pass bends by on the bent surface
BONNET_REACH = 0.6  # m from side to side of the passes on an ordinary bonnet
MEETING = 0.005  # m by which a tie and a pass of the fitted curves may miss each other


@dataclass(frozen=True, eq=False)
class Laid:
    """p passes and ties where a plan would have them, in the workpiece frame, metres.

    shape, origins (p, 3): as the fit describes them; points: (p, nodes, 3),
    frames: (p, nodes, 3, 3) of the same.  recording: names and survey, without
    frames.  pass_count: the passes, which come before the ties.  words: the
    surface.
    """

    grid: Grid
    shape: Shape
    origins: FloatArray
    points: FloatArray
    frames: FloatArray
    recording: Recording
    pass_count: int
    words: str

    def measured(self, share: float) -> "Laid":
        """The same with every standard deviation of the survey a share of what it was."""
        of = self.recording
        return replace(
            self,
            recording=replace(
                of,
                marks=tuple(replace(one, sigma=share * one.sigma) for one in of.marks),
                distances=tuple(replace(one, sigma=share * one.sigma) for one in of.distances),
                crossings=tuple(replace(one, sigma=share * one.sigma) for one in of.crossings),
            ),
        )

    def with_heading(self, heading: float) -> "Laid":
        """The same with the workpiece's heading told, radians."""
        piece = Workpiece(True, float(np.degrees(heading)))
        return replace(self, recording=replace(self.recording, workpiece=piece))


def lay_plan(ribbon: Ribbon, plan: CapturePlan, likeness: Likeness) -> Laid:
    """The plan's first passes (`MOST_LAID` at most) and ties on a surface of a kind.

    Of a ribbon with many sensors fewer of both.
    Raises SettingsError for a kind that is not known.
    """
    sensors = len(ribbon.sensors)
    most = min(max(MOST_SENSORS // sensors, LEAST_LAID), MOST_LAID)
    most_ties = min(max(MOST_TIE_SENSORS // sensors, LEAST_LAID), MOST_TIES)
    count, ties = min(max(plan.passes, 2), most), min(plan.ties, most_ties)
    strips = _strips(likeness, ribbon.length, count, plan.layout.spacing, ties)
    grid = make_grid(ribbon)
    shape, origins = _fitted(grid, list(strips.values()))
    frames = integrate_frames(grid, shape)
    points = integrate_positions(grid, shape, frames) + origins[:, None]
    names = list(strips)
    curves = {name: Strip(grid.nodes, points[k], frames[k]) for k, name in enumerate(names)}
    words = WORDS[likeness]
    if count < plan.passes:
        words += f", the first {count} passes only"
    if ties < plan.ties:
        words += f", {ties} ties only"
    recording = _recording(ribbon, plan.layout, curves, count)
    return Laid(grid, shape, origins, points, frames, recording, count, words)


@lru_cache(maxsize=32)  # while a plan is thought about, most of what changes is measurements
def _strips(
    likeness: Likeness, length: float, passes: int, spacing: float, ties: int
) -> Mapping[str, Strip]:
    """The true curves, by name, passes before ties."""
    layout = LayoutSettings(
        passes=passes, spacing=spacing, ties=ties, tie_places=tie_places(ties), heading=0.0
    )
    surface = _surface(likeness, length, passes, spacing)
    return lay_passes(surface, surface_kind("plane"), layout, length)


def _surface(likeness: Likeness, length: float, passes: int, spacing: float) -> ReferenceSurface:
    """A surface of a kind, in proportion to the ribbon and large enough for ties beside it."""
    scale = length / SIZE
    size = 2.0 * (length + passes * spacing)
    if likeness == "flat":
        return Plane(0.0, size, size)
    if likeness == "bent":
        return Cylinder(length / TURN, size)
    if likeness == "gentle":
        across = max(scale, passes * spacing / BONNET_REACH)
        return Bonnet(0.3 / scale, 0.9 / across, 0.02 * scale, 0.7 * scale, size, size)
    raise SettingsError(f"there is no kind of surface {likeness!r}; give flat, gentle or bent")


def _fitted(grid: Grid, strips: list[Strip]) -> tuple[Shape, FloatArray]:
    """The strips' rates as the fit's splines, nearest in the turns of the steps."""
    frames = np.stack([frames_at(strip, grid.nodes) for strip in strips])
    steps = np.swapaxes(frames[:, :-1], -1, -2) @ frames[:, 1:]
    turns = log(steps.reshape(-1, 3, 3)).reshape(*steps.shape[:2], 3)
    rates = turns[..., :2] / grid.steps[:, None]
    wide = np.moveaxis(rates, 0, 1).reshape(len(grid.steps), -1)
    found = np.linalg.lstsq(grid.mean, wide, rcond=None)[0]
    coefficients = np.moveaxis(found.reshape(-1, len(strips), 2), 0, 2)
    origins = np.stack([strip.points[0] for strip in strips])
    return Shape(frames[:, 0], np.ascontiguousarray(coefficients)), origins


def _recording(
    ribbon: Ribbon, layout: PlannedLayout, curves: dict[str, Strip], count: int
) -> Recording:
    names = list(curves)
    passes, ties = names[:count], names[count:]
    nothing = Readings(np.zeros(0), np.zeros((0, len(ribbon.columns))))
    marks = tuple(
        Mark(name, at, _point(curves[name], at), layout.mark_sigma)
        for name in passes
        for at in places(layout.marks, ribbon.length)
    )
    distances = tuple(
        Distance((p, q), (at, at), _apart(curves[p], curves[q], at), layout.distance_sigma)
        for p, q in pairwise(passes)
        for at in places(layout.distances, ribbon.length)
    )
    met = {(p, t): crossing(curves[p], curves[t], MEETING) for t in ties for p in passes}
    crossings = tuple(
        Crossing(pair, at, layout.crossing_sigma) for pair, at in met.items() if at is not None
    )
    there = tuple(Pass(name, "tie" if name in ties else "pass", nothing) for name in names)
    return Recording(ribbon, (), there, marks, distances, crossings, Workpiece(True))


def _point(curve: Strip, at: float) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in Curve(curve).points(np.array([at]))[0])
    return x, y, z


def _apart(one: Strip, other: Strip, at: float) -> float:
    return float(np.linalg.norm(np.subtract(_point(one, at), _point(other, at))))
