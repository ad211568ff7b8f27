"""What one capture measured, in memory: poses, passes and survey.

The same data whether it came from a recording folder, a session file, the
simulator or a ribbon.  Lengths in metres, angles in degrees (as people write
them down), counts as they came.
"""

from dataclasses import dataclass
from typing import Literal

from georibbon.ribbon import Readings, Ribbon

PassKind = Literal["pass", "tie"]


@dataclass(frozen=True)
class Workpiece:
    """The frame in which marks are given.

    level: its z axis is vertical.  heading: the known rotation from magnetic
    axes to the workpiece's, degrees counter-clockwise seen from above
    (world = Rz(heading) workpiece), or None where it is to be solved for.
    """

    level: bool = True
    heading: float | None = None


@dataclass(frozen=True, eq=False)
class Pose:
    """The ribbon held still on its bar: the attitude asked for, and what it said.

    The nominal attitude is Rz(heading) Ry(-pitch) Rx(roll), degrees, from
    ribbon to world up to one unknown rotation about the vertical.
    table: the bar lies with its face on one and the same nearly level table.
    """

    name: str
    roll: float
    heading: float
    pitch: float
    table: bool
    readings: Readings


@dataclass(frozen=True, eq=False)
class Pass:
    """The ribbon held still on the surface: a curve of it, or a tie across curves."""

    name: str
    kind: PassKind
    readings: Readings


@dataclass(frozen=True)
class Mark:
    """The measured position, in the workpiece frame, of the point `at` of a pass."""

    pass_name: str
    at: float
    position: tuple[float, float, float]
    sigma: float


@dataclass(frozen=True)
class Distance:
    """The measured straight distance between points of two passes."""

    passes: tuple[str, str]
    at: tuple[float, float]
    distance: float
    sigma: float


@dataclass(frozen=True)
class Crossing:
    """The point where two passes meet."""

    passes: tuple[str, str]
    at: tuple[float, float]
    sigma: float


@dataclass(frozen=True, eq=False)
class Recording:
    """Everything one capture measured.

    `workpiece` None: no workpiece frame was described; it is then taken as
    level, with its heading unknown.
    """

    ribbon: Ribbon
    poses: tuple[Pose, ...]
    passes: tuple[Pass, ...]
    marks: tuple[Mark, ...] = ()
    distances: tuple[Distance, ...] = ()
    crossings: tuple[Crossing, ...] = ()
    workpiece: Workpiece | None = None
    title: str | None = None
