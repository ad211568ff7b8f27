"""The verdict on each pass after the fit: which sensors disagree, and whether to lay it again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.fitting.capture import Capture
from georibbon.fitting.result import PassesFit
from georibbon.fitting.strip import ROBUST_LIMIT
from georibbon.notices import Notice
from georibbon.ribbon import Ribbon

Verdict = Literal["good", "acceptable", "redo"]

# Normalised residuals of a sensor: from here on it is named; from there on (a weight under a
# tenth) it has no say and counts as ignored.
NAMED = 5.0
IGNORED = ROBUST_LIMIT * np.sqrt(10.0)
ACCEPTABLE_RESIDUAL = 1.5  # rms of normalised residuals; about 0.8 where all is as assumed
REDO_RESIDUAL = 2.5
ACCEPTABLE_IGNORED = 0.0  # shares of a pass's sensors
REDO_IGNORED = 0.25
REDO_ASTRAY = 0.1
MOST_LISTED = 8  # names in one reason; the result holds them all
MOST_ASTRAY = 0.12  # share of all sensors of all passes: beyond it no sensor is to blame
ACCEPTABLE_SIGMA = 0.003  # m, the mean standard deviation of a pass's position
REDO_SIGMA = 0.010
STEEP_NORMAL = 0.2  # the normal's vertical part: less than 12 degrees from a vertical wall
STEEP_SHARE = 0.5  # of a pass


@dataclass(frozen=True)
class Assessment:
    """One pass's residual rms (normalised), ignored sensors, verdict and reason."""

    residual_rms: float
    ignored: tuple[str, ...]
    verdict: Verdict
    reason: str


def assess(
    capture: Capture, fit: PassesFit, missed: Mapping[str, int]
) -> tuple[tuple[Assessment, ...], tuple[Notice, ...]]:
    """Every pass's assessment, and notices of all sensors that disagree.

    missed: by the pass's name, how many observations of the survey miss it.
    """
    ribbon = capture.recording.ribbon
    size = np.where(fit.present, np.linalg.norm(fit.residuals, axis=2), 0.0)
    sigma = np.sqrt(np.trace(fit.covariance, axis1=2, axis2=3)).mean(axis=1)
    astray = float((size > NAMED)[fit.present].mean())
    often = _often(size) if astray <= MOST_ASTRAY else np.ones(size.shape[1], dtype=bool)
    notices = (
        _often_notices(ribbon, often) if astray <= MOST_ASTRAY else [_calibration_notice(astray)]
    )
    passes = []
    for p, one in enumerate(capture.recording.passes):
        notices += _pass_notices(ribbon, one.name, size[p], often)
        notices += _wall_notices(ribbon, one.name, fit.frames[p])
        passes.append(
            _assess_pass(capture, fit, p, size[p], float(sigma[p]), missed.get(one.name, 0))
        )
    return tuple(passes), tuple(notices)


def _calibration_notice(astray: float) -> Notice:
    return Notice(
        "calibration-doubtful",
        f"{100 * astray:.0f} % of the sensors, over all passes, agree with no curve: the "
        "calibration does not fit these readings; it is of another ribbon, or the ribbon has "
        "changed: calibrate again",
    )


def _often(size: FloatArray) -> BoolArray:
    """(sensors,) those that disagree in most passes, of three or more."""
    passes = len(size)
    return np.asarray((size > NAMED).sum(axis=0) > max(passes / 2, 2))


def _often_notices(ribbon: Ribbon, often: BoolArray) -> list[Notice]:
    return [
        Notice(
            "sensor-outlier",
            f"sensor {sensor.name} disagrees with the others in most passes; it counts for less "
            "there: calibrate again, and if it stays so, have it looked at",
            sensor=sensor.name,
        )
        for sensor, yes in zip(ribbon.sensors, often, strict=True)
        if yes
    ]


def _pass_notices(ribbon: Ribbon, name: str, size: FloatArray, often: BoolArray) -> list[Notice]:
    """Sensors that disagree in this pass: neighbouring magnetometers are a disturbed field."""
    out = []
    near = _disturbed(ribbon, size)
    for i, sensor in enumerate(ribbon.sensors):
        if size[i] <= NAMED or often[i]:
            continue
        if near[i]:
            message = (
                f"pass {name}: the field is disturbed at magnetometer {sensor.name} "
                f"({sensor.position:.3f} m) and its neighbours ({size[i]:.0f} standard "
                "deviations); take steel and magnets away and repeat the pass"
            )
            out.append(Notice("field-disturbed", message, name, sensor.name))
        else:
            message = (
                f"pass {name}: sensor {sensor.name} is {size[i]:.0f} standard deviations off "
                "what its neighbours say; it counts for less: see that the ribbon lies flat there"
            )
            out.append(Notice("sensor-outlier", message, name, sensor.name))
    return out


def _wall_notices(ribbon: Ribbon, name: str, frames: FloatArray) -> list[Notice]:
    """A steep pass of a ribbon whose magnetometers have two axes: its heading is weak there."""
    three = any(ribbon.sensors[i].axes == 3 for i in ribbon.indices("magnetometer"))
    steep = np.abs(frames[:, 2, 2]) < STEEP_NORMAL
    if three or steep.mean() <= STEEP_SHARE:
        return []
    message = (
        f"pass {name}: most of it lies on a steep wall, where 2-axis magnetometers tell the "
        "heading badly; mark more points of it, or lay it level with a 3-axis ribbon"
    )
    return [Notice("steep-wall", message, name)]


def _disturbed(ribbon: Ribbon, size: FloatArray) -> BoolArray:
    """(sensors,) magnetometers of which the next one along the ribbon disagrees as well."""
    order = sorted(ribbon.indices("magnetometer"), key=lambda i: ribbon.sensors[i].position)
    out = np.zeros(len(size), dtype=bool)
    for one, following in pairwise(order):
        if size[one] > NAMED and size[following] > NAMED:
            out[one] = out[following] = True
    return out


def _assess_pass(
    capture: Capture, fit: PassesFit, p: int, size: FloatArray, sigma: float, missed: int
) -> Assessment:
    """The verdict on one pass: the worst of what is found, each with its reason."""
    present = fit.present[p]
    asked = ~capture.off[p]
    trusted = present & (size <= IGNORED)
    axes = capture.array.axes.sum(axis=1)
    rms = float(np.sqrt(np.sum(size[trusted] ** 2) / max(axes[trusted].sum(), 1)))
    sensors = capture.recording.ribbon.sensors
    left_out = asked & ~trusted
    ignored = tuple(s.name for s, yes in zip(sensors, left_out, strict=True) if yes)
    share = len(ignored) / len(sensors)
    astray = present & (size > IGNORED) & ~_disturbed(capture.recording.ribbon, size)
    findings: list[tuple[bool, bool, str]] = [
        (capture.moved[p], capture.moved[p], "the ribbon moved while it was read"),
        (fit.ambiguous[p], fit.ambiguous[p], "two shapes fit alike"),
        (
            share > ACCEPTABLE_IGNORED,
            share > REDO_IGNORED,
            f"{len(ignored)} of {len(sensors)} sensors left out ({_listed(ignored)})",
        ),
        (
            astray.mean() > REDO_ASTRAY,
            astray.mean() > REDO_ASTRAY,
            f"{np.count_nonzero(astray)} live sensors agree with no curve: the ribbon did not lie "
            "flat, or the surface has detail finer than its sensors",
        ),
        (
            rms > ACCEPTABLE_RESIDUAL,
            rms > REDO_RESIDUAL,
            f"the readings are {rms:.1f} times as far off the curve as expected",
        ),
        (
            sigma > ACCEPTABLE_SIGMA,
            sigma > REDO_SIGMA,
            f"its position is known to {1e3 * sigma:.0f} mm only",
        ),
        (missed > 0, missed > 1, f"it misses {missed} of the survey's measurements"),
    ]
    verdict, reason = _worst(findings)
    return Assessment(rms, ignored, verdict, reason)


def _listed(names: tuple[str, ...]) -> str:
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(names[:MOST_LISTED]) + more


def _worst(findings: Sequence[tuple[bool, bool, str]]) -> tuple[Verdict, str]:
    redo = [words for _, bad, words in findings if bad]
    if redo:
        return "redo", "; ".join(redo)
    doubtful = [words for doubt, _, words in findings if doubt]
    if doubtful:
        return "acceptable", "; ".join(doubtful)
    return "good", "all sensors agree with the curve"
