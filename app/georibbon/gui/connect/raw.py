"""What a ribbon's sensors say, as the raw view shows it: kept for some seconds, and judged.

Raw means without any calibration: counts by the sensors' nominal scale.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.device.frames import LOST, Frame
from georibbon.ribbon import Ribbon, SensorKind
from georibbon.stillness import FULL_SCALE

KEPT = 10.0  # s
WINDOW = 0.5  # s over which noise is taken
RECENT = 0.12  # s of which a tap is a part
MOST_ROWS = 100  # of the window that are looked at; more are thinned out
LEAST_ROWS = 6
FLASH = 0.8  # s that a sensor flashes after a tap
# What a tap does at least: g, and of the field for what a magnet does to a magnetometer.
TAP: dict[SensorKind, float] = {"accelerometer": 0.05, "magnetometer": 0.1}
TAP_NOISES = 8.0  # times the sensor's own noise before
TAP_AMONG = 3.0  # times the lower half of the sensors of its kind: else the whole ribbon moves


@dataclass(frozen=True, eq=False)
class RawState:
    """The newest state of all axes (c,) and sensors (n,).

    values: (c,) g or times the nominal field, NaN where the last frame has
    none.  norm: (n,) length over the axes of a sensor; noise: (n,) root mean
    square over its axes of what they spread by.  words: (n,) "", "lost",
    "saturated" or "stuck" (it says the same again and again).  flashing: (n,)
    tapped a moment ago.
    """

    values: FloatArray
    norm: FloatArray
    noise: FloatArray
    words: tuple[str, ...]
    flashing: BoolArray


class History:
    """The frames of the last seconds, as arrays in their order."""

    def __init__(self, ribbon: Ribbon, seconds: float = KEPT) -> None:
        self._most = max(LEAST_ROWS, round(seconds * ribbon.rate))
        # Twice the room: what is kept moves to the front only once in a while.
        self._t = np.empty(2 * self._most)
        self._counts = np.empty((2 * self._most, len(ribbon.columns)), dtype=np.int16)
        self._end = 0

    def append(self, frames: Sequence[Frame]) -> None:
        """Take further frames."""
        frames = frames[-self._most :]
        if not frames:
            return
        if self._end + len(frames) > len(self._t):
            kept = self._most - len(frames)
            begin = max(self._end - kept, 0)
            count = self._end - begin
            self._t[:count] = self._t[begin : self._end]
            self._counts[:count] = self._counts[begin : self._end]
            self._end = count
        rows = slice(self._end, self._end + len(frames))
        self._t[rows] = [frame.t for frame in frames]
        self._counts[rows] = [frame.counts for frame in frames]
        self._end = rows.stop

    def last(self, seconds: float) -> tuple[FloatArray, np.ndarray]:
        """(m,) seconds and (m, c) counts of the last so many seconds."""
        begin = max(self._end - self._most, 0)
        t = self._t[begin : self._end]
        if t.size:
            begin += int(np.searchsorted(t, t[-1] - seconds))
        return self._t[begin : self._end], self._counts[begin : self._end]

    @property
    def empty(self) -> bool:
        """Whether no frame has come."""
        return self._end == 0


class RawReadings:
    """A ribbon's frames, judged anew whenever they are asked for."""

    def __init__(self, ribbon: Ribbon) -> None:
        self.ribbon = ribbon
        self.history = History(ribbon)
        sensors = ribbon.sensors
        self._starts = np.array([one.start for one in ribbon.slices])
        self._axes = np.array([sensor.axes for sensor in sensors])
        self._scale = np.repeat([sensor.counts_per_unit for sensor in sensors], self._axes)
        self._kinds = [np.array(ribbon.indices(kind), dtype=int) for kind in TAP]
        self._tap = np.array([TAP[sensor.kind] for sensor in sensors])
        self._tapped = np.full(len(sensors), -np.inf)

    def feed(self, frames: Sequence[Frame]) -> RawState | None:
        """Take what came since the last call; the newest state, None before the first frame."""
        self.history.append(frames)
        if self.history.empty:
            return None
        t, counts = self.history.last(WINDOW)
        step = max(1, len(t) // MOST_ROWS)
        t, counts = t[::-step][::-1], counts[::-step][::-1]  # the newest is always among them
        lost = counts == LOST
        railed = (np.abs(counts.astype(np.int32)) >= FULL_SCALE) & ~lost
        units = np.where(lost, np.nan, counts / self._scale)
        noise = self._root_mean_square(_spread(units))
        if frames:
            self._look_for_taps(t, units)
        return RawState(
            values=units[-1],
            norm=np.sqrt(np.add.reduceat(units[-1] ** 2, self._starts)),
            noise=noise,
            words=self._words(counts, lost, railed),
            flashing=t[-1] - self._tapped < FLASH,
        )

    def values(self, sensor: int, seconds: float = KEPT) -> tuple[FloatArray, FloatArray]:
        """(m,) seconds before now, (m, axes) values of one sensor, NaN where lost."""
        t, counts = self.history.last(seconds)
        own = counts[:, self.ribbon.slices[sensor]]
        scale = self.ribbon.sensors[sensor].counts_per_unit
        return t - t[-1] if t.size else t, np.where(own == LOST, np.nan, own / scale)

    def _root_mean_square(self, spread: FloatArray) -> FloatArray:
        """(n,) of a figure (c,) of the axes."""
        return np.sqrt(np.add.reduceat(spread**2, self._starts) / self._axes)

    def _words(self, counts: np.ndarray, lost: BoolArray, railed: BoolArray) -> tuple[str, ...]:
        some_lost = np.logical_or.reduceat(lost.any(axis=0), self._starts)
        some_railed = np.logical_or.reduceat(railed.any(axis=0), self._starts)
        same = (counts == counts[-1]).all(axis=0) & (len(counts) >= LEAST_ROWS)
        stuck = np.logical_and.reduceat(same, self._starts)
        words = np.select([some_lost, some_railed, stuck], ["lost", "saturated", "stuck"], "")
        return tuple(str(word) for word in words)

    def _look_for_taps(self, t: FloatArray, units: FloatArray) -> None:
        """Sensors that jump, alone among their kind, were tapped."""
        recent = t > t[-1] - RECENT
        before = units[~recent]
        if len(before) < LEAST_ROWS or not recent.any():
            return
        off = np.abs(np.nan_to_num(units[recent] - _mean(before))).max(axis=0)
        jump = np.sqrt(np.add.reduceat(off**2, self._starts))
        least = np.maximum(self._tap, TAP_NOISES * self._root_mean_square(_spread(before)))
        for kind in self._kinds:
            if kind.size > 1:
                common = np.sort(jump[kind])[(kind.size - 1) // 2]
                least[kind] = np.maximum(least[kind], TAP_AMONG * common)
        self._tapped[jump > least] = t[-1]


def _mean(values: FloatArray) -> FloatArray:
    """(c,) means of (m, c) without what is lost; 0 where all is."""
    there = np.isfinite(values)
    return np.asarray(np.where(there, values, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1))


def _spread(values: FloatArray) -> FloatArray:
    """(c,) standard deviations of (m, c) without what is lost; 0 where too little is there."""
    there = np.isfinite(values)
    off = np.where(there, values - _mean(values), 0.0)
    return np.asarray(np.sqrt((off**2).sum(axis=0) / np.maximum(there.sum(axis=0) - 1, 1)))
