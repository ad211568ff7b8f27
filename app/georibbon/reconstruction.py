"""From a recording to a surface: the one pure function, its settings and its result."""

from dataclasses import dataclass
from typing import Literal

from georibbon.calibration.model import Calibration
from georibbon.geometry.frames import Strip
from georibbon.geometry.surface import Surface
from georibbon.notices import Notice
from georibbon.recording import PassKind
from georibbon.ribbon import FloatArray, Ribbon

Method = Literal["ribbon", "paper"]
Verdict = Literal["good", "acceptable", "redo"]


@dataclass(frozen=True)
class Quality:
    """The verdict on one pass, and why."""

    verdict: Verdict
    reason: str


@dataclass(frozen=True, eq=False)
class FittedPass:
    """One pass as fitted, in the workpiece frame.

    strip: n points of the curve.  covariance: (n, 3, 3) float64, m², of each
    point's position.  normal_sigma: (n,) float64, radians, standard deviation
    of each normal's direction (root of the mean of its two components'
    variances).  residuals: (sensors, 3) float64, each sensor axis's residual
    divided by its standard deviation, NaN where the sensor has no such axis or
    was not used.  residual_rms: root mean square of those that are used.
    smoothing: metres, the detail that is still followed.  sensors_ignored:
    names.
    """

    name: str
    kind: PassKind
    strip: Strip
    covariance: FloatArray
    normal_sigma: FloatArray
    residuals: FloatArray
    residual_rms: float
    smoothing: float
    sensors_ignored: tuple[str, ...]
    quality: Quality


@dataclass(frozen=True)
class SurveyResidual:
    """One observation of the survey after the fit.

    residual: metres, measured minus fitted (norm for a position); ratio: that
    divided by the observation's standard deviation.
    """

    kind: Literal["mark", "distance", "crossing"]
    passes: tuple[str, ...]
    at: tuple[float, ...]
    residual: float
    sigma: float
    ratio: float


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """The result: calibrated, placed, checked passes and their surface.

    All in the workpiece frame, metres.  `surface` is None where it was not
    asked for.
    """

    ribbon: Ribbon
    method: Method
    calibration: Calibration
    passes: tuple[FittedPass, ...]
    survey: tuple[SurveyResidual, ...]
    surface: Surface | None
    notices: tuple[Notice, ...]
