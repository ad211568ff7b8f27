"""A recording's passes as the fit needs them: in units, on the ribbon's grid, with their noise."""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import BoolArray
from georibbon.calibration.model import Calibration
from georibbon.errors import FitError
from georibbon.fitting.grid import Grid, make_grid
from georibbon.fitting.screening import Screened
from georibbon.fitting.sensing import Noise, Observations, SensorArray, observe
from georibbon.fitting.strip import StripProblem, sensed_vectors
from georibbon.recording import Recording
from georibbon.world import field_direction

LEAST_ACCELEROMETERS = 3
LEAST_MAGNETOMETERS = 3


@dataclass(frozen=True, eq=False)
class Capture:
    """What the fit works on: a recording's passes in units, on the ribbon's grid.

    candidates are fitted to `problem`, whose noise counts what all passes
    share as if it were each pass's own.  off: (p, sensors) those that a person
    switched off; they say nothing.
    """

    recording: Recording
    calibration: Calibration
    grid: Grid
    array: SensorArray
    observations: Observations
    problem: StripProblem
    moved: tuple[bool, ...]
    off: BoolArray

    @property
    def noise(self) -> Noise:
        """The noise of each pass's own, without the mounting that all passes share."""
        whole, shared = self.problem.noise.contact, self.calibration.mounting_sigma
        return replace(self.problem.noise, contact=float(np.sqrt(whole**2 - shared**2)))


def prepare(
    recording: Recording,
    calibration: Calibration,
    screened: Screened,
    off: BoolArray | None = None,
) -> Capture:
    """The recording's readings as the fit needs them.

    off: (p, sensors) those that are switched off, where any are.
    Raises `FitError` where a pass has too few sensors that say something.
    """
    ribbon = recording.ribbon
    array = SensorArray.of(ribbon, calibration)
    observed = observe(ribbon, array, screened.mean, screened.sigma)
    if off is None:
        off = np.zeros(observed.present.shape, dtype=bool)
    observed = replace(observed, present=observed.present & ~off)
    _require_sensors(recording, array, observed, off)
    grid = make_grid(ribbon)
    noise = Noise()
    alone = replace(noise, contact=float(np.hypot(noise.contact, calibration.mounting_sigma)))
    vectors = sensed_vectors(array, field_direction(calibration.dip))
    problem = StripProblem(grid, array, observed, vectors, alone)
    return Capture(recording, calibration, grid, array, observed, problem, screened.moved, off)


def _require_sensors(
    recording: Recording, array: SensorArray, observed: Observations, off: BoolArray
) -> None:
    for one, present, silent in zip(recording.passes, observed.present, off, strict=True):
        for kind, mask, least in (
            ("accelerometers", ~array.field, LEAST_ACCELEROMETERS),
            ("magnetometers", array.field, LEAST_MAGNETOMETERS),
        ):
            count = int(np.count_nonzero(present & mask))
            if count < least:
                switched = int(np.count_nonzero(silent & mask))
                remedy = (
                    f"{switched} are switched off: switch some on again"
                    if switched
                    else "check the ribbon and repeat the pass"
                )
                raise FitError(
                    f"pass {one.name}: {count} {kind} say something, at least {least} are needed; "
                    f"{remedy}"
                )
