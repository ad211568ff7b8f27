"""Which sensors spoke in a pass, and whether the ribbon lay still: before any fit.

Nothing is left out silently: every sensor that is set aside has a notice.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration
from georibbon.notices import Notice
from georibbon.recording import Pass
from georibbon.ribbon import Ribbon
from georibbon.stillness import still_means

FULL_SCALE = 32767  # counts are signed 16-bit numbers on the wire
# Frames alike to the last count that prove a sensor dead: a live one's noise moves it sooner.
ALIKE_FRAMES = 10
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
        still = still_means(one.readings)
        mean = still.mean.copy()
        for i, sensor in enumerate(ribbon.sensors):
            if not calibration.sensors[i].used:
                continue
            fault = _fault(one.readings.counts[:, ribbon.slices[i]])
            if fault is not None:
                code, words = fault
                mean[ribbon.slices[i]] = np.nan
                message = f"pass {one.name}: sensor {sensor.name} {words}; it is left out there"
                notices.append(Notice(code, message, one.name, sensor.name))
        means.append(mean)
        sigmas.append(still.sigma)
    moved = _moved(ribbon, passes)
    notices += [_moved_notice(one) for one, yes in zip(passes, moved, strict=True) if yes]
    return Screened(np.array(means), np.array(sigmas), moved, tuple(notices))


def _fault(counts: FloatArray) -> tuple[str, str] | None:
    """A notice's code and words for a sensor (m, axes) that says nothing of use."""
    present = np.isfinite(counts)
    if not present.any(axis=0).all():
        return "sensor-dead", "has an axis without a single value"
    if (np.abs(np.where(present, counts, 0.0)) >= FULL_SCALE).any():
        return "sensor-saturated", "is at the end of its range"
    frames = present.sum(axis=0).min()
    spread = np.nanmax(counts, axis=0) - np.nanmin(counts, axis=0)
    if frames >= ALIKE_FRAMES and (spread == 0).all():
        return "sensor-dead", "says the same in every frame"
    return None


def _moved(ribbon: Ribbon, passes: Sequence[Pass]) -> tuple[bool, ...]:
    """Whether the accelerometers' frames spread or drift as those of a ribbon at rest do not."""
    columns = np.concatenate(
        [
            np.arange(ribbon.slices[i].start, ribbon.slices[i].stop)
            for i in ribbon.indices("accelerometer")
        ]
    )
    unit = np.concatenate(
        [
            np.full(ribbon.sensors[i].axes, ribbon.sensors[i].counts_per_unit)
            for i in ribbon.indices("accelerometer")
        ]
    )
    spreads, drifts = [], []
    for one in passes:
        counts = one.readings.counts[:, columns] / unit
        third = max(len(counts) // 3, 1)
        with np.errstate(invalid="ignore"):
            spreads.append(_middle(np.diff(counts, axis=0).std(axis=0), counts.std(axis=0)))
            change = counts[-third:].mean(axis=0) - counts[:third].mean(axis=0)
        drifts.append(float(np.nanmedian(np.abs(change))) if np.isfinite(change).any() else 0.0)
    usual = float(np.median([spread for spread, _ in spreads])) or 1e-9
    return tuple(
        bool(slow > MOVED_SPREAD * usual or drift > MOVED_DRIFT)
        for (_, slow), drift in zip(spreads, drifts, strict=True)
    )


def _middle(fast: FloatArray, slow: FloatArray) -> tuple[float, float]:
    """Medians over the axes of the white part of the spread, and of the spread as a whole."""
    if not np.isfinite(slow).any():
        return 0.0, 0.0
    return float(np.nanmedian(fast)) / np.sqrt(2.0), float(np.nanmedian(slow))


def _moved_notice(one: Pass) -> Notice:
    message = (
        f"pass {one.name}: the ribbon moved while it was read; hold it still for a second and "
        "repeat the pass"
    )
    return Notice("pass-moved", message, one.name)
