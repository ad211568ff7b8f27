"""How good what was taken is, in words: of a calibration, of a pass as it lies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.calibration.model import Calibration
from georibbon.capture.disturbance import Disturbed, names_of
from georibbon.capture.live import LiveCurve
from georibbon.fitting.assessment import (
    ACCEPTABLE_RESIDUAL,
    MOST_LISTED,
    REDO_IGNORED,
    REDO_RESIDUAL,
    Verdict,
)
from georibbon.ribbon import Ribbon
from georibbon.session.words import counted


@dataclass(frozen=True)
class PassVerdict:
    """The verdict on one pass by itself, before the survey has its say, and why."""

    verdict: Verdict
    reason: str


def quality_words(calibration: Calibration) -> str:
    """The expected errors of a calibration, and what was noticed, in one line."""
    quality = calibration.quality
    words = "calibrated"
    if quality is not None:
        words += (
            f" from {counted(quality.poses, 'pose')}: tilt {quality.tilt:.2f}°, heading "
            f"{quality.heading:.2f}°, common to all {quality.gauge:.2f}°"
        )
    notices = [notice.message for notice in calibration.notices]
    return "; ".join([words, *notices])


def verdict_on(ribbon: Ribbon, curve: LiveCurve) -> PassVerdict:
    """The verdict on a pass as its curve shows it: how well all sensors agree, and which do not."""
    bad = [one for one in curve.disturbed if one.grade == "bad"]
    if len(bad) > REDO_IGNORED * len(curve.residuals):
        return PassVerdict("redo", f"{_named(bad)} disagree; take away what is magnetic")
    misfit = _misfit(ribbon, curve)
    words = f"the sensors miss the curve by {misfit:.1f} of their standard deviations"
    if misfit > REDO_RESIDUAL:
        return PassVerdict("redo", f"{words}; press the ribbon down along its whole length")
    if curve.disturbed:
        more = _more(len(curve.disturbed) - 1)
        return PassVerdict("acceptable", f"{curve.disturbed[0].reason}{more}")
    if misfit > ACCEPTABLE_RESIDUAL:
        return PassVerdict("acceptable", words)
    if curve.ambiguous:
        words = "another shape fits as well, which the survey or the other passes may settle"
        return PassVerdict("acceptable", words)
    return PassVerdict("good", "all sensors agree with one curve")


def _misfit(ribbon: Ribbon, curve: LiveCurve) -> float:
    """Rms of the normalised residuals of the axes of all sensors that are not disturbed."""
    astray = names_of(curve.disturbed)
    kept = np.array([sensor.name not in astray for sensor in ribbon.sensors])
    kept &= np.isfinite(curve.residuals)
    axes = np.array([sensor.axes for sensor in ribbon.sensors])
    return float(np.sqrt(np.sum(curve.residuals[kept] ** 2) / max(int(axes[kept].sum()), 1)))


def curve_words(curve: LiveCurve) -> str:
    """The live curve in a few words."""
    disturbed = f", {counted(len(curve.disturbed), 'sensor')} disturbed" if curve.disturbed else ""
    return f"misfit {curve.misfit:.2f}{disturbed}{'' if curve.settled else ', settling'}"


def _named(disturbed: Sequence[Disturbed]) -> str:
    names = names_of(disturbed)
    return ", ".join(names[:MOST_LISTED]) + (" and others" if len(names) > MOST_LISTED else "")


def _more(others: int) -> str:
    return f" (and {counted(others, 'sensor')} more)" if others else ""
