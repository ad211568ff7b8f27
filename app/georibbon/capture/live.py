"""The curve of the ribbon as it lies now, from every displayed frame's readings.

The fit starts from the shape of a moment before, which takes a few steps.  Such
a fit can be caught in a false minimum, or left behind when the ribbon is lifted
and laid elsewhere: the cost of the readings then rises, and all starts are tried
anew, one with each update, so that no update takes long.
"""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration
from georibbon.capture.disturbance import Disturbed, expected_without, find_disturbed
from georibbon.errors import FitError
from georibbon.fitting.candidates import find_candidates
from georibbon.fitting.capture import LEAST_ACCELEROMETERS, LEAST_MAGNETOMETERS
from georibbon.fitting.grid import (
    Shape,
    differentiate_positions,
    integrate_frames,
    make_grid,
)
from georibbon.fitting.placing import AMBIGUOUS_WITHIN
from georibbon.fitting.sensing import Noise, SensorArray, observe
from georibbon.fitting.smoothing import (
    best_lengths,
    information_density,
    length_of_weight,
    weight_of_length,
)
from georibbon.fitting.start import find_starts
from georibbon.fitting.strip import (
    Linearised,
    StripProblem,
    Strips,
    fit_strips,
    follow_shape,
    linearise,
    robust_cost,
    sensed_vectors,
    summarise,
    whiten,
)
from georibbon.geometry.frames import Strip
from georibbon.ribbon import Ribbon
from georibbon.stillness import FULL_SCALE
from georibbon.threads import one_thread
from georibbon.world import field_direction

WARM_STEPS, RIVAL_STEPS = 6, 12
# The readings' cost scatters by about ten from laying to laying, and more while the ribbon is
# moved; a rise by more than this, and this share, is no scatter.
RISEN, RISEN_SHARE = 40.0, 0.5
POOR = 3.0  # the readings' cost for each axis, about 0.7 where all is as assumed
SOON, OFTEN = 20, 100  # updates from one trial of starts to the next: where lost, where not
SAME_SHAPE = 0.1  # shapes whose frames differ nowhere by more (about 6 degrees) are one
# As much may frames differ from one update to the next (about 3 degrees: one frame is noisy).
SETTLED = 0.05


@dataclass(frozen=True, eq=False)
class LiveCurve:
    """The ribbon's curve by the readings of a moment, at the n + 1 nodes of its grid.

    strip: s from the ribbon's start, points from its start point at the origin,
    frames; in magnetic axes (x east, y north, z up).  normal_curvature,
    geodesic_torsion: (n + 1,) 1/m; positive curvature bends towards the normal,
    tau' = curvature N and V' = torsion N.  covariance: (n + 1, 3, 3) m², of the
    points relative to the start; sigma: (n + 1,) m, the root of its trace.
    residuals: (sensors,) normalised, NaN for a sensor that says nothing.
    misfit: rms of the normalised residuals of all axes, about 0.8 where all is
    as assumed.  smoothing: metres.  disturbed: sensors that do not agree with
    their neighbours.  ambiguous: another shape fits the readings as well.
    settled: whether the curve is the same as at the update before and all
    starts have been tried for the place where it lies.
    """

    strip: Strip
    normal_curvature: FloatArray
    geodesic_torsion: FloatArray
    covariance: FloatArray
    sigma: FloatArray
    residuals: FloatArray
    misfit: float
    smoothing: float
    disturbed: tuple[Disturbed, ...]
    ambiguous: bool
    settled: bool


@dataclass(frozen=True, eq=False)
class _Place:
    """A strip (b = 1) with what it is linearised to."""

    strips: Strips
    white: FloatArray
    linear: Linearised

    @property
    def readings_cost(self) -> float:
        """What the readings cost, without the smoothing."""
        return float(robust_cost(self.strips.squares).sum())


def _place(problem: StripProblem, shape: Shape, smoothing: FloatArray) -> _Place:
    white = whiten(problem, shape)
    linear = linearise(problem, shape, white)
    return _Place(summarise(problem, shape, smoothing, white, linear), white, linear)


class LiveFit:
    """Follows the ribbon: one pass fitted again and again, from where it was."""

    def __init__(self, ribbon: Ribbon, calibration: Calibration) -> None:
        self._ribbon = ribbon
        self._array = SensorArray.of(ribbon, calibration)
        self._grid = make_grid(ribbon)
        self._vectors = sensed_vectors(self._array, field_direction(calibration.dip))
        usual = Noise()
        contact = float(np.hypot(usual.contact, calibration.mounting_sigma))
        self._noise = replace(usual, contact=contact)
        self._last: Strips | None = None
        self._frames: FloatArray | None = None
        self._rivals: list[Shape] = []  # starts that are still to be tried
        self._since = 0  # updates since they were found
        self._usual = np.inf  # the least cost of the readings since all were tried
        self._lost = self._twin = self._ambiguous = False

    def update(
        self, mean: FloatArray, sigma: FloatArray, smoothing: float | None = None
    ) -> LiveCurve:
        """The curve by the readings of a moment.

        mean, sigma: (c,) counts, of one frame or a short average, and its
        standard deviation; NaN where a value was lost.  smoothing: metres, the
        least detail to be followed; None: chosen by the evidence whenever all
        starts are tried.

        Raises `FitError` where too few sensors say something.
        """
        with one_thread():
            problem = self._problem(mean, sigma)
            place = self._follow(problem, smoothing)
            self._last = place.strips
            return self._told(problem, place)

    def _problem(self, mean: FloatArray, sigma: FloatArray) -> StripProblem:
        with np.errstate(invalid="ignore"):
            spoken = np.where(np.abs(mean) < FULL_SCALE, mean, np.nan)
        observed = observe(self._ribbon, self._array, spoken[None], sigma[None])
        for kind, mask, least in (
            ("accelerometers", ~self._array.field, LEAST_ACCELEROMETERS),
            ("magnetometers", self._array.field, LEAST_MAGNETOMETERS),
        ):
            count = int(np.count_nonzero(observed.present[0] & mask))
            if count < least:
                raise FitError(
                    f"{count} {kind} say something, at least {least} are needed to show the "
                    "ribbon; look at its connection"
                )
        return StripProblem(self._grid, self._array, observed, self._vectors, self._noise)

    def _follow(self, problem: StripProblem, smoothing: float | None) -> _Place:
        """Where the ribbon is, from where it was, or from another start that fits better."""
        self._since += 1
        if self._last is None:
            return self._begin(problem, smoothing)
        weight = self._last.smoothing
        if smoothing is not None:
            weight = weight_of_length(np.array([smoothing]), information_density(problem))
        shape = follow_shape(problem, self._last.shape, weight, WARM_STEPS)
        place = _place(problem, shape, weight)
        if self._rivals:
            place = self._rival(problem, place)
            if not self._rivals:
                return self._tried(problem, place, smoothing)
        self._look(problem, place)
        return place

    def _begin(self, problem: StripProblem, smoothing: float | None) -> _Place:
        """The first curve: all starts at once, however long it takes."""
        asked = np.array([np.nan if smoothing is None else smoothing])
        found = find_candidates(problem, asked)[0]
        self._ambiguous = bool(np.sum(found.cost <= found.cost[0] + AMBIGUOUS_WITHIN) > 1)
        place = _place(problem, found.shape.take([0]), found.smoothing[:1])
        self._usual = place.readings_cost
        return place

    def _look(self, problem: StripProblem, place: _Place) -> None:
        """Whether the readings still cost about what they did; if not, or now and then: starts."""
        cost = place.readings_cost
        self._lost = cost > self._usual + max(RISEN, RISEN_SHARE * self._usual)
        poor = cost > POOR * self._axes(problem)
        self._usual = min(self._usual, cost)
        if not self._rivals and self._since >= (SOON if self._lost or poor else OFTEN):
            starts = find_starts(problem).shape
            self._rivals = [starts.take([k]) for k in range(len(starts.start))]
            self._since, self._twin = 0, False

    def _rival(self, problem: StripProblem, place: _Place) -> _Place:
        """The better one of a place and that from the next start, by the same readings."""
        start = self._rivals.pop(0)
        rival = fit_strips(problem, start, place.strips.smoothing, RIVAL_STEPS)
        gain = float(place.strips.cost[0] - rival.cost[0])
        if gain > AMBIGUOUS_WITHIN:
            self._twin = False
            return _place(problem, rival.shape, rival.smoothing)
        if gain > -AMBIGUOUS_WITHIN:
            away = integrate_frames(self._grid, rival.shape) - place.linear.turns.frames
            self._twin |= bool(np.abs(away).max() > SAME_SHAPE)
        return place

    def _tried(self, problem: StripProblem, place: _Place, smoothing: float | None) -> _Place:
        """All starts have been tried: what the readings cost now is usual here."""
        self._lost, self._ambiguous = False, self._twin
        self._usual = place.readings_cost
        if smoothing is None:
            length = best_lengths(problem, place.strips)
            weight = weight_of_length(length, information_density(problem))
            return _place(problem, place.strips.shape, weight)
        return place

    def _axes(self, problem: StripProblem) -> int:
        """How many axes say something."""
        return int(self._array.axes[problem.observations.present[0]].sum())

    def _told(self, problem: StripProblem, place: _Place) -> LiveCurve:
        strips, linear = place.strips, place.linear
        points, moves = differentiate_positions(self._grid, strips.shape, linear.turns)
        covariance = moves[0] @ np.linalg.inv(strips.normal[0]) @ np.swapaxes(moves[0], 1, 2)
        frames = linear.turns.frames[0]
        same = self._frames is not None and np.abs(frames - self._frames).max() <= SETTLED
        self._frames = frames
        present, squares = problem.observations.present[0], strips.squares[0]
        rates = strips.shape.rates[0] @ self._grid.at_nodes.T
        length = length_of_weight(strips.smoothing[0], information_density(problem))
        expected = expected_without(problem, linear, strips.normal, place.white)
        return LiveCurve(
            strip=Strip(self._grid.nodes, points[0], frames),
            normal_curvature=-rates[1],
            geodesic_torsion=rates[0],
            covariance=covariance,
            sigma=np.sqrt(np.trace(covariance, axis1=1, axis2=2)),
            residuals=np.where(present, np.sqrt(squares), np.nan),
            misfit=float(np.sqrt(squares[present].sum() / self._axes(problem))),
            smoothing=float(length),
            disturbed=find_disturbed(self._ribbon, problem, expected),
            ambiguous=self._ambiguous,
            settled=bool(same and not self._lost),
        )
