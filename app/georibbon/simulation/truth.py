"""The truth of a virtual capture."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from georibbon.calibration.model import Calibration
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import ReferenceSurface


@dataclass(frozen=True, eq=False)
class Truth:
    """What a recording should give back.

    surface: the surface's name; parameters: those it was made with; shape: the
    surface itself, None where it is not known.  strips: each pass's and tie's
    true curve, workpiece frame.  yaw_degrees: world = Rz(yaw) workpiece.
    calibration: the sensors' true models, None where they are not known.
    """

    surface: str
    strips: Mapping[str, Strip]
    yaw_degrees: float
    parameters: Mapping[str, float] = field(default_factory=dict)
    shape: ReferenceSurface | None = None
    calibration: Calibration | None = None
