"""The mean of a window in which the ribbon lay still, and how well it is known.

A sensor's noise is not white: its mean over a second is worse known than the
spread of its frames divided by the root of their number.  So the mean's
standard deviation is taken from the means of blocks (batch means; Flegal and
Jones 2010, "Batch means and spectral variance estimators in Markov chain Monte
Carlo"): the spread of the block means over the root of the number of blocks.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from georibbon.arrays import BoolArray, FloatArray
from georibbon.ribbon import Readings

# Few blocks make the estimate noisy, many make them shorter than the noise
# remembers: ten is the usual compromise for windows of one to a few seconds.
BLOCKS = 10
FULL_SCALE = 32767
MOST_RAILED = 0.1  # share of an axis's values at the end of its range; beyond it, it is saturated
# The standard deviation of a value that was rounded to a whole count: the least
# that a single frame can be known to, when all frames are equal.
ROUNDING = 1.0 / np.sqrt(12.0)


@dataclass(frozen=True, eq=False)
class StillMeans:
    """Every axis' mean over a still window.

    mean: (c,) float64, counts, NaN for a column without any value.  sigma: (c,)
    float64, counts, the mean's standard deviation, NaN likewise.  frames: (c,)
    int64, how many values each mean is taken over.
    """

    mean: FloatArray
    sigma: FloatArray
    frames: NDArray[np.int64]


def without_railed(readings: Readings) -> tuple[Readings, BoolArray]:
    """The readings without the values at the end of the range, and which these are (m, c).

    Counts are signed 16-bit numbers on the wire: a value of 32767 or beyond is
    a sensor at its end, or an error of the bus, and no measurement.
    """
    with np.errstate(invalid="ignore"):
        railed = np.abs(readings.counts) >= FULL_SCALE
    return Readings(readings.t, np.where(railed, np.nan, readings.counts)), railed


def still_means(readings: Readings) -> StillMeans:
    """The means of a still window, with their standard deviations from blocks.

    Lost values (NaN) are left out; a column with none left has mean and sigma
    NaN.  With m blocks of means b_k over a column, sigma^2 = sum n_k (b_k -
    mean)^2 / ((m - 1) n), n_k values in a block, n in all, and never less than
    rounding to whole counts leaves, 1 / sqrt(12 n).
    """
    counts = readings.counts
    present = np.isfinite(counts)
    # From near the mean the squares lose no digits.
    centre = np.where(
        present.any(axis=0), np.where(present, counts, np.inf).min(axis=0, initial=np.inf), 0.0
    )
    values = np.where(present, counts - centre, 0.0)
    if len(counts) == 0:
        return means_of_blocks(values, present.astype(np.float64))
    starts = np.unique(np.linspace(0, len(counts), BLOCKS, endpoint=False).astype(int))
    sums = np.add.reduceat(values, starts, axis=0)
    sizes = np.add.reduceat(present.astype(np.float64), starts, axis=0)
    found = means_of_blocks(sums, sizes)
    return StillMeans(found.mean + centre, found.sigma, found.frames)


def means_of_blocks(sums: FloatArray, sizes: FloatArray) -> StillMeans:
    """The means over successive blocks of a still window, of which only the sums are known.

    sums: (m, c) of each block's values.  sizes: (m, c) how many values each is
    over; blocks may differ in length.  See `still_means`.
    """
    frames, filled = sizes.sum(axis=0), (sizes > 0).sum(axis=0)
    some = np.maximum(frames, 1.0)
    mean = np.where(frames > 0, sums.sum(axis=0) / some, np.nan)
    residuals = sums - sizes * np.where(frames > 0, mean, 0.0)
    spread = (residuals**2 / np.maximum(sizes, 1.0)).sum(axis=0)
    variance = spread / np.maximum(filled - 1, 1) / some
    sigma = np.sqrt(np.maximum(variance, ROUNDING**2 / some))
    return StillMeans(mean, np.where(frames > 0, sigma, np.nan), frames.astype(np.int64))
