"""Whether the ribbon lies still, told with every frame, and the mean of what it said meanwhile.

Every figure comes from sums of whole counts over the last half second, brought
up to date frame by frame and therefore exact; so it matters nothing how the
frames were cut into blocks on their way.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.model import Calibration
from georibbon.device.frames import Frame
from georibbon.device.rolling import LearnedNoise, Rolling, StillRun
from georibbon.ribbon import Readings, Ribbon, SensorKind
from georibbon.stillness import FULL_SCALE, StillMeans

State = Literal["still", "moving", "disturbed"]

WINDOW = 0.5  # s, over which the spread is taken
LEAST_FRAMES = 10  # fewer show no spread
KEPT = 3.0  # s of a still run's frames
MOST_SPREAD = 3.0  # times the axis' own noise
# Where the field changes, accelerometers that spread by more tell a motion, not a magnet.
QUIET_SPREAD = 2.0
# Of the mean since the ribbon came to rest; in g, and for magnetometers in the local field.
MOST_DRIFT: dict[SensorKind, float] = {"accelerometer": 0.001, "magnetometer": 0.02}
# A mean over half a second has noise of its own: a drift exceeds it by this much, or is none.
DRIFT_SIGMAS = 5.0
# A rest begins when the halves of half a second differ by no more than noise explains, all
# accelerometers taken together: a sum of squares' own scatter, so many times.
SWAY_SIGMAS = 4.0
# A sensor's own noise, whatever it seems to be: below the least nobody minds a motion; above
# the most it is none of a sensor at rest.
LEAST_NOISE: dict[SensorKind, float] = {"accelerometer": 0.0003, "magnetometer": 0.003}
MOST_NOISE: dict[SensorKind, float] = {"accelerometer": 0.01, "magnetometer": 0.03}
# A 3-axis magnetometer's length against the local field's.
SUSPECT_LENGTH, BAD_LENGTH = 0.04, 0.10
# Nobody lifts a ribbon and lays it down again in less; beyond it nobody knows what it did.
LONGEST_GAP = 0.25  # s
LONGEST_GAP_FRAMES = 5
# Sensors that may be at odds with all others, as long as none is beside another: one, or this
# share.
ODD_SHARE = 0.1
LEAST_FOR_ODD = 3
MOST_LISTED = 4  # names in one reason


@dataclass(frozen=True)
class Stillness:
    """What the frames up to now tell.

    state: "moving" also where too little has come to tell; "disturbed" where
    the accelerometers lie still and the field changes (seconds are then 0 and
    there is no window), or is not as strong as where it was calibrated (seconds
    go on).  seconds: how long it has lain still.  reason: a sentence.  spread:
    of the most restless accelerometer axis over half a second, times its own
    noise; drift: of an accelerometer axis' mean since it came to rest, mg;
    both without single sensors at odds with all others.  sensors: the names of
    those that the reason is about.
    """

    state: State
    seconds: float
    reason: str
    spread: float
    drift: float
    sensors: tuple[str, ...] = ()


class StillnessMonitor:
    """Watches a ribbon's frames: still, moving or disturbed.

    Still: over the last half second no accelerometer axis spreads by three
    times its own noise, and no mean has drifted by 1 mg since the ribbon came
    to rest (nor by five times what noise does to it).  The rest begins when the last
    of the hand's sway is out of that half second.  A single sensor that is
    restless among quiet neighbours is named and does not count.  Values that
    were lost or are at the end of the range are left out, and an axis of which
    less than half is there; a gap in time ends what was still where it is
    longer than a quarter of a second (and than five frames).  Magnetometers are
    watched likewise, for a magnet that passes.

    calibration: tells each sensor's scale, which sensors are used, and for
    3-axis magnetometers the field's strength; without it the nominal scale is taken.
    """

    def __init__(self, ribbon: Ribbon, calibration: Calibration | None = None) -> None:
        self._size = max(LEAST_FRAMES, round(WINDOW * ribbon.rate))
        self._gap = max(LONGEST_GAP, LONGEST_GAP_FRAMES / ribbon.rate)
        kept = max(self._size, round(KEPT * ribbon.rate))
        self._scale = _scales(ribbon, calibration)
        self._most_drift = _by_kind(ribbon, MOST_DRIFT)
        self._rolling = Rolling(self._size, kept, len(ribbon.columns))
        self._noise = LearnedNoise(
            self._size,
            self._scale * _by_kind(ribbon, LEAST_NOISE),
            self._scale * _by_kind(ribbon, MOST_NOISE),
        )
        used = np.array(
            [calibration is None or calibration.sensors[i].used for i in range(len(ribbon.sensors))]
        )
        self._accelerometers = _Mates(ribbon, np.array(ribbon.indices("accelerometer")), used)
        self._magnetometers = _Mates(ribbon, np.array(ribbon.indices("magnetometer")), used)
        self._strength = None if calibration is None else _Strength(ribbon, calibration)
        self.reset()

    def feed(self, frames: Sequence[Frame]) -> Stillness:
        """Take further frames, in their order; what is told after the last of them."""
        for frame in frames:
            self._take(frame)
        return self._told

    def window(self) -> Readings | None:
        """The frames of the present still run, its last three seconds at most; None: not still."""
        return None if self._run is None else self._rolling.readings(self._run.frames)

    def means(self) -> StillMeans | None:
        """The means over the whole of the present still run, in counts; None: not still."""
        return None if self._run is None else self._run.means()

    def reset(self) -> None:
        """Forget the frames and what was still; the noise that was learned stays."""
        self._begin(Stillness("moving", 0.0, "too little has come to tell", 0.0, 0.0))

    def _begin(self, told: Stillness) -> None:
        self._rolling.clear()
        self._noise.interrupt()
        self._run: StillRun | None = None
        self._waited = 0  # frames for the end of a sway
        self._since = 0  # frames that may be averaged together
        self._told = told

    def _take(self, frame: Frame) -> None:
        rolling = self._rolling
        if rolling.frames and not 0.0 < frame.t - rolling.last_time <= self._gap:
            words = "frames are missing: nobody knows what the ribbon did meanwhile"
            self._begin(Stillness("moving", 0.0, words, 0.0, 0.0))
        counts = frame.counts.astype(np.int64)
        present = np.abs(counts) < FULL_SCALE
        counts[~present] = 0
        rolling.append(frame.t, counts, present)
        rest = self._run is not None and self._run.frames >= self._size
        self._noise.append(counts, present, rest)
        self._since += 1
        if self._run is not None:
            self._run.append(frame.t, counts, present)
        if rolling.full:
            self._judge()

    def _judge(self) -> None:
        figures = self._figures()
        moved = self._accelerometers.judge(figures)
        if moved.silent or moved.restless:
            self._stop(_silent() if moved.silent else _moving(moved))
            return
        passed = self._magnetometers.judge(figures)
        if passed.restless:
            quiet = moved.spread < QUIET_SPREAD
            self._stop(_passing(passed, moved) if quiet else _stirring(moved))
            return
        if self._run is None:
            if self._since < self._size or self._sways():
                return
            self._waited = 0
            self._run = StillRun(max(1, self._size // 10), self._rolling)
        weak = None if self._strength is None else self._strength.judge(figures)
        self._told = _resting(self._run.seconds, moved, passed, weak)

    def _sways(self) -> bool:
        """Whether the window still holds the end of a motion, which would spoil the mean of a run.

        That is waited for half a window at most: noise of a strange kind is no reason to
        wait for ever, and what drifts on is found from the run's mean.
        """
        columns = self._accelerometers.columns
        most = 1.0 + SWAY_SIGMAS * np.sqrt(2.0 / len(columns))
        swaying = self._waited < self._size // 2 and self._rolling.sway(columns) > most
        self._waited += swaying
        return swaying

    def _figures(self) -> "_Figures":
        mean, spread, enough = self._rolling.statistics()
        noise = self._noise.sigma
        if self._run is None:
            drift, frames = self._rolling.halves(), self._size // 2
        else:
            drift, frames = mean - self._run.anchor, self._size
        own = DRIFT_SIGMAS * np.sqrt(2.0 / frames) * self._noise.slow
        limit = np.maximum(self._most_drift * self._scale, own)
        return _Figures(
            mean=mean,
            spread=np.where(enough, spread / noise, 0.0),
            drift=np.where(enough, np.abs(drift) / self._scale, 0.0),
            drifting=np.where(enough, np.abs(drift) / limit, 0.0),
            enough=enough,
        )

    def _stop(self, told: Stillness) -> None:
        """The ribbon is not still; what comes will not be averaged with what came before."""
        if self._run is not None:
            self._run, self._since = None, 0
        self._told = told


@dataclass(frozen=True, eq=False)
class _Figures:
    """Of every column (c,): mean, counts; spread, times its noise; drift, units and times its
    limit; whether enough of its values came."""

    mean: FloatArray
    spread: FloatArray
    drift: FloatArray
    drifting: FloatArray
    enough: BoolArray


@dataclass(frozen=True)
class _Finding:
    """What one kind of sensors shows: whether they are restless; the names of those that are,
    or of the odd ones that do not count; and the greatest figures of those that count."""

    restless: bool
    names: tuple[str, ...]
    spread: float
    drift: float
    silent: bool = False


class _Mates:
    """The used sensors of one kind, in their order along the ribbon."""

    def __init__(self, ribbon: Ribbon, indices: np.ndarray, used: BoolArray) -> None:
        kept = sorted(
            (int(i) for i in indices if used[i]), key=lambda i: ribbon.sensors[i].position
        )
        self._names = [ribbon.sensors[i].name for i in kept]
        slices = [ribbon.slices[i] for i in kept]
        self.columns = np.array([k for one in slices for k in range(one.start, one.stop)], int)
        self._starts = np.cumsum([0, *(one.stop - one.start for one in slices)])[:-1].astype(int)

    def judge(self, figures: _Figures) -> _Finding:
        """Whether these sensors are restless, more of them than may be at odds with the others."""
        if not self._names:
            return _Finding(False, (), 0.0, 0.0, silent=True)
        spread, drift, drifting = (
            np.maximum.reduceat(values[self.columns], self._starts)
            for values in (figures.spread, figures.drift, figures.drifting)
        )
        over = (spread > MOST_SPREAD) | (drifting > 1.0)
        restless = too_many(over)
        counted = np.ones_like(over) if restless else ~over
        return _Finding(
            restless,
            tuple(self._names[k] for k in np.flatnonzero(over)),
            float(spread[counted].max(initial=0.0)),
            float(drift[counted].max(initial=0.0)),
            silent=not figures.enough[self.columns].any(),
        )


class _Strength:
    """How far each 3-axis magnetometer's reading is from the local field's strength."""

    def __init__(self, ribbon: Ribbon, calibration: Calibration) -> None:
        kept = [
            i
            for i in ribbon.indices("magnetometer")
            if ribbon.sensors[i].axes == 3 and calibration.sensors[i].used
        ]
        kept.sort(key=lambda i: ribbon.sensors[i].position)
        models = [calibration.sensors[i] for i in kept]
        self._names = [model.name for model in models]
        self._columns = np.array([ribbon.slices[i].start + np.arange(3) for i in kept], int)
        self._inverse = np.array([np.linalg.pinv(model.gain) for model in models]).reshape(-1, 3, 3)
        self._bias = np.array([model.bias for model in models]).reshape(-1, 3)

    def judge(self, figures: _Figures) -> _Finding:
        """Restless: too many are off by what is suspect; spread is the greatest share it is off."""
        if not self._names:
            return _Finding(False, (), 0.0, 0.0)
        seen = self._inverse @ (figures.mean[self._columns] - self._bias)[..., None]
        off = np.abs(np.linalg.norm(seen[..., 0], axis=-1) - 1.0)
        off = np.where(figures.enough[self._columns].all(axis=1), off, 0.0)
        over = off > SUSPECT_LENGTH
        names = tuple(self._names[k] for k in np.flatnonzero(over))
        return _Finding(too_many(over), names, float(off.max()), 0.0)


def too_many(over: BoolArray) -> bool:
    """Whether sensors (n,), in their order along the ribbon, are more than odd ones out.

    One alone, or a tenth of them, may be at odds with all others; two beside
    each other are what a hand or a magnet does.
    """
    odd = max(1, int(ODD_SHARE * len(over))) if len(over) >= LEAST_FOR_ODD else 0
    return bool(over.sum() > odd or (over[1:] & over[:-1]).any())


def listed(names: Sequence[str]) -> str:
    """Some names in a row, and how many more there are."""
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def _moving(moved: _Finding) -> Stillness:
    if moved.spread > MOST_SPREAD:
        words = f"the ribbon moves: {listed(moved.names)} by {moved.spread:.0f} times the noise"
    else:
        words = f"the ribbon drifts: {listed(moved.names)} by {1e3 * moved.drift:.1f} mg"
    return Stillness("moving", 0.0, words, moved.spread, 1e3 * moved.drift, moved.names)


def _stirring(moved: _Finding) -> Stillness:
    words = "the ribbon moves: accelerometers and magnetometers together"
    return Stillness("moving", 0.0, words, moved.spread, 1e3 * moved.drift)


def _silent() -> Stillness:
    return Stillness("moving", 0.0, "no accelerometer says anything of use", 0.0, 0.0)


def _passing(passed: _Finding, moved: _Finding) -> Stillness:
    words = (
        f"the field changes at {listed(passed.names)} while the ribbon lies still: take magnets, "
        "tools and telephones away"
    )
    return Stillness("disturbed", 0.0, words, moved.spread, 1e3 * moved.drift, passed.names)


def _resting(seconds: float, moved: _Finding, passed: _Finding, weak: _Finding | None) -> Stillness:
    """Still, unless the field is not as strong as it was; odd sensors are named."""
    spread, drift = moved.spread, 1e3 * moved.drift
    if weak is not None and weak.restless:
        grade = "bad" if weak.spread > BAD_LENGTH else "suspect"
        words = (
            f"the field at {listed(weak.names)} is off by {100 * weak.spread:.0f} % ({grade}): "
            "look for a magnet or iron nearby"
        )
        return Stillness("disturbed", seconds, words, spread, drift, weak.names)
    names = (*moved.names, *passed.names, *(weak.names if weak is not None else ()))
    odd = tuple(dict.fromkeys(names))
    words = f"still for {seconds:.1f} s"
    if odd:
        words += f"; {listed(odd)} alone {'does' if len(odd) == 1 else 'do'} not agree"
    return Stillness("still", seconds, words, spread, drift, odd)


def _scales(ribbon: Ribbon, calibration: Calibration | None) -> FloatArray:
    """(c,) counts a unit of every column: the calibration's, else the nominal."""
    scales = []
    for i, sensor in enumerate(ribbon.sensors):
        scale = 0.0
        if calibration is not None:
            scale = float(np.sqrt(np.sum(calibration.sensors[i].gain ** 2) / sensor.axes))
        scales += [scale if scale > 0.0 else sensor.counts_per_unit] * sensor.axes
    return np.array(scales)


def _by_kind(ribbon: Ribbon, values: dict[SensorKind, float]) -> FloatArray:
    """(c,) each column's value by its sensor's kind."""
    return np.array([values[sensor.kind] for sensor in ribbon.sensors for _ in range(sensor.axes)])
