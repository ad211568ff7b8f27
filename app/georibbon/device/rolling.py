"""Sums over the frames of late, kept up to date frame by frame.

Counts are whole numbers of 16 bits, and so are their sums and squares: nothing
is rounded, however long it goes on.
"""

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.ribbon import Readings
from georibbon.stillness import BLOCKS, ROUNDING, StillMeans, means_of_blocks

MOST_SQUARE = 9.0  # of one column's shift, among those of all


def spread_of(sums: IntArray, squares: IntArray, sizes: IntArray) -> FloatArray:
    """(c,) standard deviations from sums of values and of their squares; 0 below two values."""
    variance = (sizes * squares - sums**2) / np.maximum(sizes * (sizes - 1), 1)
    return np.asarray(np.sqrt(variance))


class Rolling:
    """The last `kept` frames of c columns, and the sums over the last `size` of them."""

    def __init__(self, size: int, kept: int, columns: int) -> None:
        self.size = size
        self._t = np.zeros(kept)
        self._counts = np.zeros((kept, columns), dtype=np.int64)
        self._present = np.zeros((kept, columns), dtype=bool)
        self.clear()

    def clear(self) -> None:
        """Forget all frames."""
        columns = self._counts.shape[1]
        self.frames = 0
        self._sums = np.zeros(columns, dtype=np.int64)
        self._squares = np.zeros(columns, dtype=np.int64)
        self._sizes = np.zeros(columns, dtype=np.int64)

    @property
    def full(self) -> bool:
        """Whether there are enough frames for the sums."""
        return self.frames >= self.size

    @property
    def last_time(self) -> float:
        """Seconds of the last frame."""
        return float(self._t[(self.frames - 1) % len(self._t)])

    def append(self, t: float, counts: IntArray, present: BoolArray) -> None:
        """One more frame; counts are 0 where not present."""
        if self.full:
            out = (self.frames - self.size) % len(self._t)
            self._add(self._counts[out], self._present[out], -1)
        place = self.frames % len(self._t)
        self._t[place], self._counts[place], self._present[place] = t, counts, present
        self._add(counts, present, 1)
        self.frames += 1

    def _add(self, counts: IntArray, present: BoolArray, sign: int) -> None:
        self._sums += sign * counts
        self._squares += sign * counts * counts
        self._sizes += sign * present

    def statistics(self) -> tuple[FloatArray, FloatArray, BoolArray]:
        """(c,) means and standard deviations over `size` frames, and whether half of them spoke."""
        enough = self._sizes >= max(2, self.size // 2)
        mean = self._sums / np.maximum(self._sizes, 1)
        return mean, spread_of(self._sums, self._squares, self._sizes), enough

    def halves(self) -> FloatArray:
        """(c,) the mean of the later half of `size` frames less that of the earlier."""
        counts, present = self.last(self.size)
        middle = self.size // 2
        earlier, later = (
            counts[part].sum(axis=0) / np.maximum(present[part].sum(axis=0), 1)
            for part in (slice(middle), slice(middle, None))
        )
        both = present[:middle].any(axis=0) & present[middle:].any(axis=0)
        return np.where(both, later - earlier, 0.0)

    def sway(self, columns: IntArray) -> float:
        """By how much the halves of `size` frames differ; 1 at rest.

        The mean over some columns of their shift's square, in units of what the
        noise does to it: its variance 4 s² / size times (2 - q) / q for noise that
        remembers, with s the spread in the later half, q the squares' ratio of
        differences and spread there (their median).  A sway that ends is in the
        earlier half, and hides in no figure of the later.  One column counts for
        at most `MOST_SQUARE`: a single odd sensor is no motion.
        """
        counts, present = (part[:, columns] for part in self.last(self.size - self.size // 2))
        sums, squares = counts.sum(axis=0), (counts**2).sum(axis=0)
        variance = np.maximum(spread_of(sums, squares, present.sum(axis=0)), ROUNDING) ** 2
        both = present[1:] & present[:-1]
        steps = np.where(both, np.diff(counts, axis=0), 0)
        halved = (steps**2).sum(axis=0) / np.maximum(2 * both.sum(axis=0), 1)
        share = min(float(np.median(halved / variance)), 1.0)
        shift = self.halves()[columns] ** 2 / variance * (self.size / 4.0)
        return float(np.minimum(shift * share / (2.0 - share), MOST_SQUARE).mean())

    def last(self, frames: int) -> tuple[IntArray, BoolArray]:
        """Counts and presence of the last frames, (m, c) each."""
        places = self._places(frames)
        return self._counts[places], self._present[places]

    def times(self, frames: int) -> FloatArray:
        """(m,) seconds of the last frames."""
        return self._t[self._places(frames)]

    def readings(self, frames: int) -> Readings:
        """The last frames, as many as are kept: t from the first on, NaN for what was lost."""
        counts, present = self.last(frames)
        t = self.times(frames)
        return Readings(t - t[:1], np.where(present, counts, np.nan))

    def _places(self, frames: int) -> IntArray:
        count = min(frames, self.frames, len(self._t))
        return np.arange(self.frames - count, self.frames) % len(self._t)


class StillRun:
    """The frames since the ribbon came to rest: their sums, in blocks.

    There are from 10 to 20 blocks and one that is not complete: whenever there
    are 20, pairs are made one (dynamic batch means; Yeh and Schmeiser 2000), so
    that the blocks grow with the run and its memory does not.
    """

    def __init__(self, block: int, rolling: Rolling) -> None:
        counts, present = rolling.last(rolling.size)
        self.anchor = rolling.statistics()[0]
        self.frames = 0
        self._first = self._last = 0.0
        self._length, self._filled, self._place = block, 0, 0
        self._sums = np.zeros((2 * BLOCKS + 1, counts.shape[1]), dtype=np.int64)
        self._sizes = np.zeros_like(self._sums)
        for t, one, there in zip(rolling.times(rolling.size), counts, present, strict=True):
            self.append(float(t), one, there)

    @property
    def seconds(self) -> float:
        """From its first frame to its last."""
        return self._last - self._first

    def append(self, t: float, counts: IntArray, present: BoolArray) -> None:
        """One more frame; counts are 0 where not present."""
        if self.frames == 0:
            self._first = t
        self._last = t
        self.frames += 1
        self._sums[self._place] += counts
        self._sizes[self._place] += present
        self._filled += 1
        if self._filled == self._length:
            self._place, self._filled = self._place + 1, 0
            if self._place == 2 * BLOCKS:
                self._join()

    def _join(self) -> None:
        for blocks in (self._sums, self._sizes):
            blocks[:BLOCKS] = blocks[0 : 2 * BLOCKS : 2] + blocks[1 : 2 * BLOCKS : 2]
            blocks[BLOCKS:] = 0
        self._place, self._length = BLOCKS, 2 * self._length

    def means(self) -> StillMeans:
        """Mean, standard deviation and number of frames of every column, in counts."""
        # From near the mean the squares lose no digits.
        sizes = self._sizes.astype(np.float64)
        centre = np.rint(self.anchor)
        found = means_of_blocks(self._sums - sizes * centre, sizes)
        return StillMeans(found.mean + centre, found.sigma, found.frames)


class LearnedNoise:
    """Every column's own noise, learned while the ribbon lies still.

    At first from the differences of successive frames (the root of half their
    mean square, von Neumann's estimate), the least of all blocks of frames: a
    motion adds to it, but little where it is slow.  Then from the spread of
    blocks in which the ribbon lay still, at most twice what differences tell:
    their median, and once there are eight the least median of eight in
    succession, so that it grows by no motion that is taken for rest.  A
    thousandth a block is all that is forgotten, for sensors whose noise does
    grow.  A block of equal counts tells nothing.

    sigma: (c,) of one value.  slow: (c,) that of white noise whose means were as
    uncertain: sigma sqrt((2 - q) / q) with q the squares' ratio of differences
    and spread, which is right where each value remembers the one before (an
    autoregression of the first order, 1 - q its memory).
    """

    REMEMBERED = 8
    MOST_RATIO = 2.0
    LEAST_BIAS = 1.2  # the least of some differences is a little small
    FORGETTING = 1.001
    # At first: the bias, and that noise often remembers.
    FIRST_RATIO, FIRST_SLOW = 1.3, 1.5

    def __init__(self, size: int, least: FloatArray, most: FloatArray) -> None:
        self._size = size
        self._least, self._most = np.maximum(least, ROUNDING), np.maximum(most, ROUNDING)
        self._steps = np.full(len(least), np.inf)
        self._blocks = np.full((self.REMEMBERED, 2, len(least)), np.nan)
        self._noise = np.full((2, len(least)), np.inf)
        self.sigma = self.slow = self._most.copy()
        self._begin()

    def interrupt(self) -> None:
        """The frames to come do not follow on those before: the block begun is given up."""
        self._begin()

    def _begin(self) -> None:
        columns = len(self._least)
        self._frames = 0
        self._before: tuple[IntArray, BoolArray] | None = None
        self._sums = np.zeros((2, columns), dtype=np.int64)
        self._squares = np.zeros((2, columns), dtype=np.int64)
        self._sizes = np.zeros((2, columns), dtype=np.int64)

    def append(self, counts: IntArray, present: BoolArray, still: bool) -> None:
        """One more frame; counts are 0 where not present.

        still: whether the ribbon has lain still for as many frames as a block has.
        """
        self._add(0, counts, present)
        if self._before is not None:
            both = present & self._before[1]
            self._add(1, np.where(both, counts - self._before[0], 0), both)
        self._frames += 1
        if self._frames == self._size:
            self._learn(still)
            self._begin()
        self._before = counts, present

    def _add(self, which: int, values: IntArray, present: BoolArray) -> None:
        self._sums[which] += values
        self._squares[which] += values * values
        self._sizes[which] += present

    def _learn(self, still: bool) -> None:
        spread = spread_of(self._sums[0], self._squares[0], self._sizes[0])
        steps = np.sqrt(self._squares[1] / np.maximum(2 * self._sizes[1], 1))
        told = (self._sizes >= self._size // 3).all(axis=0) & (spread > 0.0)
        self._steps = np.fmin(self._steps * self.FORGETTING, np.where(told, steps, np.nan))
        self._noise *= self.FORGETTING
        if still:
            self._rest(np.where(told, spread, np.nan), steps)
        first = self.FIRST_RATIO * self._steps
        median = np.fmin(self._noise, _medians(self._blocks))
        known = np.isfinite(median)
        sigma = np.where(known[0], median[0], first)
        slow = np.where(known[1], median[1], self.FIRST_SLOW * first)
        self.sigma = np.clip(sigma, self._least, self._most)
        self.slow = np.clip(slow, self.sigma, self.MOST_RATIO**2 * self._most)

    def _rest(self, spread: FloatArray, steps: FloatArray) -> None:
        """A block in which the ribbon lay still; spread is NaN where it tells nothing."""
        spread = np.minimum(
            spread, self.MOST_RATIO * np.minimum(steps, self.LEAST_BIAS * self._steps)
        )
        share = np.minimum(steps / spread, 1.0) ** 2
        slow = spread * np.sqrt((2.0 - share) / share)
        self._blocks = np.concatenate([self._blocks[1:], np.stack([spread, slow])[None]])
        # The least of medians over few blocks would be far too small: those are not kept.
        enough = np.isfinite(self._blocks).all(axis=0)
        self._noise = np.where(enough, np.minimum(self._noise, _medians(self._blocks)), self._noise)


def _medians(values: FloatArray) -> FloatArray:
    """The lower medians of (m, ...) over the first axis, NaN left out; NaN for nothing else."""
    ordered = np.sort(values, axis=0)  # NaN last
    middle = np.maximum(np.isfinite(values).sum(axis=0) - 1, 0) // 2
    return np.asarray(np.take_along_axis(ordered, middle[None], axis=0)[0])
