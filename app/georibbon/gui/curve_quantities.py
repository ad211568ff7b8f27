"""What can be drawn along a pass: values, units, and how they are thinned; without Qt."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.geometry.frames import curvatures
from georibbon.gui.language import N_
from georibbon.reconstruction import FittedPass
from georibbon.recording import Pass
from georibbon.ribbon import AXIS_LETTERS, Ribbon, SensorKind

Measure = Literal["length", "curvature", "ratio", "sigmas", "counts"]
UNITS: dict[Measure, str] = {
    "curvature": "1/m", "ratio": "", "sigmas": "σ", "counts": N_("counts"),
}  # fmt: skip
MOST_POINTS = 20_000  # of one plot; more are thinned


@dataclass(frozen=True, eq=False)
class Run:
    """One quantity along one pass.

    s: (n,) metres along the pass; values: (n,) in metres, 1/m, or as they are;
    NaN where there is none.  names: (n,) of the sensors' axes, or nothing for
    what is known everywhere between the points.
    """

    s: FloatArray
    values: FloatArray
    names: tuple[str, ...] = ()

    def at(self, s: float) -> tuple[float, float, str]:
        """(place, value, name) at s metres: between points, or of the nearest sensor.

        Of a sensor's axes the one with the largest value; (s, NaN, "") where
        there is none.
        """
        known = np.isfinite(self.values)
        if not known.any():
            return s, float("nan"), ""
        if not self.names:
            return s, float(np.interp(s, self.s[known], self.values[known])), ""
        away = np.where(known, np.abs(self.s - s), np.inf)
        close = np.nonzero(away == away.min())[0]
        best = close[np.argmax(np.abs(self.values[close]))]
        return float(self.s[best]), float(self.values[best]), self.names[best]


@dataclass(frozen=True)
class Source:
    """What a quantity is taken from: a fitted pass, its ribbon, and what it was fitted to."""

    fitted: FittedPass
    ribbon: Ribbon
    raw: Pass | None


@dataclass(frozen=True)
class Quantity:
    """What can be drawn.

    group: the heading it stands under; text: its name; stems: whether it is
    drawn as stems from zero, one a sensor's axis, and not as a line.
    """

    id: str
    group: str
    text: str
    measure: Measure
    of: Callable[[Source], Run]
    stems: bool = False


def _along(values: Callable[[FittedPass], FloatArray]) -> Callable[[Source], Run]:
    return lambda source: Run(source.fitted.strip.s, values(source.fitted))


def _residuals(source: Source) -> Run:
    """Every sensor axis's residual by its standard deviation."""
    sensors = source.ribbon.sensors
    s = np.repeat([one.position for one in sensors], 3)
    names = tuple(one.name + letter for one in sensors for letter in AXIS_LETTERS)
    return Run(s, source.fitted.residuals.reshape(-1), names)


def _raw(kind: SensorKind, axis: int) -> Callable[[Source], Run]:
    """The mean count of one axis of every sensor of a kind."""

    def of(source: Source) -> Run:
        ribbon, raw = source.ribbon, source.raw
        there = [i for i in ribbon.indices(kind) if ribbon.sensors[i].axes > axis]
        sensors = [ribbon.sensors[i] for i in there]
        columns = [ribbon.slices[i].start + axis for i in there]
        known = raw is not None and raw.readings.counts.shape[1] == len(ribbon.columns)
        values = _mean(raw.readings.counts[:, columns]) if known else np.full(len(there), np.nan)
        return Run(
            np.array([one.position for one in sensors], dtype=np.float64),
            values,
            tuple(one.name + AXIS_LETTERS[axis] for one in sensors),
        )

    return of


def _mean(counts: FloatArray) -> FloatArray:
    """(c,) means of the finite ones of (m, c) counts; NaN where there is none."""
    known = np.isfinite(counts)
    number = np.count_nonzero(known, axis=0)
    total = np.sum(np.where(known, counts, 0.0), axis=0)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _tangent(axis: int) -> Callable[[Source], Run]:
    return _along(lambda one: one.strip.frames[:, axis, 0])


def _position(axis: int) -> Callable[[Source], Run]:
    return _along(lambda one: one.strip.points[:, axis])


_SHAPE, _FIT, _READ = N_("Shape"), N_("Fit"), N_("Raw readings")
QUANTITIES: tuple[Quantity, ...] = (
    Quantity("curvature", _SHAPE, N_("Normal curvature"), "curvature",
             _along(lambda one: curvatures(one.strip)[0])),
    Quantity("torsion", _SHAPE, N_("Geodesic torsion"), "curvature",
             _along(lambda one: curvatures(one.strip)[1])),
    Quantity("tangent-x", _SHAPE, N_("Tangent, x"), "ratio", _tangent(0)),
    Quantity("tangent-y", _SHAPE, N_("Tangent, y"), "ratio", _tangent(1)),
    Quantity("tangent-z", _SHAPE, N_("Tangent, z"), "ratio", _tangent(2)),
    Quantity("x", _SHAPE, N_("Position, x"), "length", _position(0)),
    Quantity("y", _SHAPE, N_("Position, y"), "length", _position(1)),
    Quantity("z", _SHAPE, N_("Position, z"), "length", _position(2)),
    Quantity("sigma", _FIT, N_("Uncertainty (1σ)"), "length",
             _along(lambda one: one.position_sigma)),
    Quantity("residuals", _FIT, N_("Residuals by sensor"), "sigmas", _residuals, stems=True),
    Quantity("accelerometer-x", _READ, N_("Accelerometers, x"), "counts",
             _raw("accelerometer", 0)),
    Quantity("accelerometer-y", _READ, N_("Accelerometers, y"), "counts",
             _raw("accelerometer", 1)),
    Quantity("accelerometer-z", _READ, N_("Accelerometers, z"), "counts",
             _raw("accelerometer", 2)),
    Quantity("magnetometer-x", _READ, N_("Magnetometers, x"), "counts", _raw("magnetometer", 0)),
    Quantity("magnetometer-y", _READ, N_("Magnetometers, y"), "counts", _raw("magnetometer", 1)),
    Quantity("magnetometer-z", _READ, N_("Magnetometers, z"), "counts", _raw("magnetometer", 2)),
)  # fmt: skip
RAW = _READ  # the group of what needs the recording
FIRST = ("curvature", "sigma")


def thinned(x: FloatArray, y: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """At most about `most` of the (n,) points, so that no peak is lost: each part's extremes.

    The points are cut into parts of equal length; of each its first, lowest,
    highest and last point stay, in their order.
    """
    if len(x) <= most:
        return x, y
    parts = np.array_split(np.arange(len(x)), max(most // 4, 1))
    keep: BoolArray = np.zeros(len(x), dtype=bool)
    for part in parts:
        values = y[part]
        keep[[part[0], part[-1]]] = True
        if np.isfinite(values).any():
            keep[[part[np.nanargmin(values)], part[np.nanargmax(values)]]] = True
    return x[keep], y[keep]


def stems(runs: Sequence[Run], width: float) -> list[tuple[FloatArray, FloatArray]]:
    """For each of several runs the pairs of points of its stems, (2n,) places and values each.

    All stems of one place stand side by side within `width` metres, the runs in
    their order and the axes in theirs.
    """
    drawn = []
    for k, run in enumerate(runs):
        known = np.isfinite(run.values)
        slot = 3 * k + np.arange(len(run.s)) % 3
        x = run.s + (slot - (3 * len(runs) - 1) / 2) * width / (3 * len(runs))
        y = np.stack((np.zeros(len(run.s)), run.values), axis=-1)
        drawn.append((np.repeat(x[known], 2), y[known].reshape(-1)))
    return drawn


def closest(places: FloatArray) -> float:
    """The shortest step between different (n,) places, metres; 0.01 where there is none."""
    steps = np.diff(np.unique(places))
    return float(steps.min()) if len(steps) else 0.01


def table(
    shown: Sequence[Quantity],
    runs: Sequence[tuple[str, Sequence[Run]]],
    in_unit: Callable[[Measure, FloatArray], FloatArray],
    heads: Sequence[str],
    place: str,
) -> str:
    """What is drawn as CSV: what is known everywhere first, and then what sensors have.

    runs: each pass's name with one run a quantity.  in_unit: values in the
    person's unit.  heads: the quantities' names with their units; place: that of
    the arc length.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for by_sensor in (False, True):
        chosen = [k for k in range(len(shown)) if bool(runs and runs[0][1][k].names) == by_sensor]
        if not runs or not chosen:
            continue
        writer.writerow(
            ["pass", *(["sensor"] if by_sensor else []), place, *(heads[k] for k in chosen)]
        )
        for name, of in runs:
            for row in _rows([of[k] for k in chosen], [shown[k].measure for k in chosen], in_unit):
                writer.writerow([name, *row])
    return text.getvalue()


def _rows(
    runs: Sequence[Run],
    measures: Sequence[Measure],
    in_unit: Callable[[Measure, FloatArray], FloatArray],
) -> list[list[str]]:
    """One row a place, or a sensor's axis; an empty cell where there is no value."""
    found: dict[tuple[str, float], list[str]] = {}
    for k, (run, measure) in enumerate(zip(runs, measures, strict=True)):
        names = run.names or ("",) * len(run.s)
        values = in_unit(measure, run.values)
        for name, s, value in zip(names, run.s, values, strict=True):
            cells = found.setdefault((name, float(s)), [""] * len(runs))
            cells[k] = f"{value:.9g}" if np.isfinite(value) else ""
    places = in_unit("length", np.array([s for _, s in found]))
    return [
        [*([name] if name else []), f"{place:.9g}", *cells]
        for (name, _), place, cells in zip(found, places, found.values(), strict=True)
        if any(cells)
    ]
