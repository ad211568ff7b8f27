"""Which sensors spoke in a pass, and whether the ribbon lay still: before any fit.

Nothing is left out silently: every sensor that is set aside has a notice.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.model import Calibration
from georibbon.notices import Notice
from georibbon.recording import Pass
from georibbon.ribbon import Readings, Ribbon
from georibbon.stillness import still_means

FULL_SCALE = 32767  # counts are signed 16-bit numbers on the wire
# Frames alike to the last count that prove a sensor dead: a live one's noise moves it sooner.
ALIKE_FRAMES = 10
MOST_RAILED = 0.1  # share of an axis's values at the end of its range
STILL_FRAMES = 10  # fewer show neither spread nor drift
LEAST_SPREAD = 1e-6  # g
MOVED_SPREAD = 3.0  # times the usual spread of the frames
MOVED_DRIFT = 0.004  # g between the first and the last third: a quarter of a degree


@dataclass(frozen=True, eq=False)
class Screened:
    """Still means of b passes (b, c), their standard deviations, and what was set aside.

    mean: counts, NaN for every axis of a sensor that is set aside in that pass.
    moved: (b,) passes during which the ribbon was not still.
    """

    mean: FloatArray
    sigma: FloatArray
    moved: tuple[bool, ...]
    notices: tuple[Notice, ...]


def screen(ribbon: Ribbon, passes: Sequence[Pass], calibration: Calibration) -> Screened:
    """Means of all passes, without dead, saturated or missing sensors."""
    means, sigmas, notices = [], [], []
    for one in passes:
        readings, railed = _without_railed(one.readings)
        still = still_means(readings)
        mean = still.mean.copy()
        used = [i for i, model in enumerate(calibration.sensors) if model.used]
        for i in used:
            sensor, where = ribbon.sensors[i], ribbon.slices[i]
            fault = _fault(readings.counts[:, where], railed[:, where])
            if fault is not None:
                code, words = fault
                mean[where] = np.nan
                message = f"pass {one.name}: sensor {sensor.name} {words}; it is left out there"
                notices.append(Notice(code, message, one.name, sensor.name))
                railed[:, where] = False
        if railed.any():
            notices.append(_railed_notice(one, int(railed.sum())))
        means.append(mean)
        sigmas.append(still.sigma)
    moved = _moved(ribbon, passes)
    notices += _still_notices(passes, moved)
    return Screened(np.array(means), np.array(sigmas), moved, tuple(notices))


def _without_railed(readings: Readings) -> tuple[Readings, BoolArray]:
    """The readings without the values at the end of the range, and which these are (m, c)."""
    with np.errstate(invalid="ignore"):
        railed = np.abs(readings.counts) >= FULL_SCALE
    return Readings(readings.t, np.where(railed, np.nan, readings.counts)), railed


def _railed_notice(one: Pass, values: int) -> Notice:
    message = (
        f"pass {one.name}: {values} value{'' if values == 1 else 's'} at the end of the sensors' "
        "range are left out; if this comes back, look at the ribbon's connection"
    )
    return Notice("values-saturated", message, one.name)


def _fault(counts: FloatArray, railed: BoolArray) -> tuple[str, str] | None:
    """A notice's code and words for a sensor (m, axes) that says nothing of use."""
    if (railed.mean(axis=0) > MOST_RAILED).any():
        return "sensor-saturated", "is at the end of its range"
    present = np.isfinite(counts)
    if not present.any(axis=0).all():
        return "sensor-dead", "has an axis without a single value"
    spread = np.nanmax(counts, axis=0) - np.nanmin(counts, axis=0)
    if present.sum(axis=0).min() >= ALIKE_FRAMES and (spread == 0).all():
        return "sensor-dead", "says the same in every frame"
    return None


def _moved(ribbon: Ribbon, passes: Sequence[Pass]) -> tuple[bool, ...]:
    """Whether the accelerometers' frames spread or drift as those of a ribbon at rest do not."""
    sensors = ribbon.indices("accelerometer")
    columns = np.concatenate(
        [np.arange(ribbon.slices[i].start, ribbon.slices[i].stop) for i in sensors]
    )
    unit = np.repeat(
        [ribbon.sensors[i].counts_per_unit for i in sensors],
        [ribbon.sensors[i].axes for i in sensors],
    )
    figures = [_restlessness(one.readings.counts[:, columns] / unit) for one in passes]
    usual = max(float(np.median([white for white, _, _ in figures])), LEAST_SPREAD)
    return tuple(
        spread > MOVED_SPREAD * usual or drift > MOVED_DRIFT for _, spread, drift in figures
    )


def _restlessness(values: FloatArray) -> tuple[float, float, float]:
    """Of frames (m, c), g: white noise, whole spread and drift, each the median over the axes.

    All zero where there are too few values to tell.
    """
    steps = np.diff(values, axis=0)
    filled = (np.isfinite(values).sum(axis=0) >= STILL_FRAMES) & (
        np.isfinite(steps).sum(axis=0) >= STILL_FRAMES // 2
    )
    if not filled.any():
        return 0.0, 0.0, 0.0
    values, steps = values[:, filled], steps[:, filled]
    white = np.nanstd(steps, axis=0) / np.sqrt(2.0)
    drift = [_drift(column[np.isfinite(column)]) for column in values.T]
    spread = np.nanstd(values, axis=0)
    return float(np.median(white)), float(np.median(spread)), float(np.median(drift))


def _drift(values: FloatArray) -> float:
    """How far the mean of the last third lies from that of the first."""
    third = len(values) // 3
    return float(abs(values[-third:].mean() - values[:third].mean()))


def _still_notices(passes: Sequence[Pass], moved: Sequence[bool]) -> list[Notice]:
    out = []
    for one, yes in zip(passes, moved, strict=True):
        frames = len(one.readings.counts)
        if yes:
            message = (
                f"pass {one.name}: the ribbon moved while it was read; hold it still for a second "
                "and repeat the pass"
            )
            out.append(Notice("pass-moved", message, one.name))
        elif frames < STILL_FRAMES:
            message = (
                f"pass {one.name}: {frames} frame{'' if frames == 1 else 's'} cannot show whether "
                f"the ribbon lay still; read it for a second, at least {STILL_FRAMES} frames"
            )
            out.append(Notice("pass-short", message, one.name))
    return out
