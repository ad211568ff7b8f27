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
from georibbon.ribbon import KINDS, Ribbon
from georibbon.stillness import MOST_RAILED, still_means, without_railed

# Frames alike to the last count that prove a sensor dead where the others' noise moves them.
ALIKE_FRAMES = 10
MOST_QUIET = 0.5  # share of the sensors of a kind that may say the same in every frame
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
    frozen = _frozen(ribbon, passes)
    for one in passes:
        readings, railed = without_railed(one.readings)
        still = still_means(readings)
        mean = still.mean.copy()
        for i, (code, words) in _faults(ribbon, readings.counts, railed, frozen).items():
            if calibration.sensors[i].used:
                sensor = ribbon.sensors[i].name
                message = f"pass {one.name}: sensor {sensor} {words}; it is left out there"
                notices.append(Notice(code, message, one.name, sensor))
            mean[ribbon.slices[i]] = np.nan
            railed[:, ribbon.slices[i]] = False
        if railed.any():
            notices.append(_railed_notice(one, int(railed.sum())))
        means.append(mean)
        sigmas.append(still.sigma)
    moved = _moved(ribbon, passes)
    notices += _still_notices(passes, moved)
    return Screened(np.array(means), np.array(sigmas), moved, tuple(notices))


def _frozen(ribbon: Ribbon, passes: Sequence[Pass]) -> BoolArray:
    """(sensors,) those that say one and the same in all of several passes."""
    counts = np.concatenate([one.readings.counts for one in passes])
    alike = _alike(counts) & (len(passes) > 1)
    return np.array([alike[where].all() for where in ribbon.slices])


def _alike(counts: FloatArray) -> BoolArray:
    """(c,) columns of which all values, enough of them, are the same."""
    present = np.isfinite(counts)
    highest = np.where(present, counts, -np.inf).max(axis=0)
    lowest = np.where(present, counts, np.inf).min(axis=0)
    return np.asarray((present.sum(axis=0) >= ALIKE_FRAMES) & (highest == lowest))


def _faults(
    ribbon: Ribbon, counts: FloatArray, railed: BoolArray, frozen: BoolArray
) -> dict[int, tuple[str, str]]:
    """By the sensor's number a notice's code and words, for those that say nothing of use."""
    frames, alike = np.isfinite(counts).sum(axis=0), _alike(counts)
    stuck = np.array([alike[where].all() for where in ribbon.slices])
    for kind in KINDS:
        # Sensors that are all quiet are no fault: only one that is so among livelier ones.
        mates = list(ribbon.indices(kind))
        if mates and stuck[mates].mean() > MOST_QUIET:
            stuck[mates] = False
    stuck |= frozen
    out: dict[int, tuple[str, str]] = {}
    for i, where in enumerate(ribbon.slices):
        if (railed[:, where].mean(axis=0) > MOST_RAILED).any():
            out[i] = ("sensor-saturated", "is at the end of its range")
        elif (frames[where] == 0).any():
            out[i] = ("sensor-dead", "has an axis without a single value")
        elif stuck[i]:
            out[i] = ("sensor-dead", "says the same in every frame")
    return out


def _railed_notice(one: Pass, values: int) -> Notice:
    message = (
        f"pass {one.name}: {values} value{'' if values == 1 else 's'} at the end of the sensors' "
        "range are left out; if this comes back, look at the ribbon's connection"
    )
    return Notice("values-saturated", message, one.name)


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
    figures = [
        _restlessness(without_railed(one.readings)[0].counts[:, columns] / unit) for one in passes
    ]
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
