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
    frames = present.sum(axis=0)
    values = np.where(present, counts, 0.0)
    with np.errstate(invalid="ignore"):
        mean = np.where(frames > 0, values.sum(axis=0) / np.maximum(frames, 1), np.nan)
    sigma = _sigma_from_blocks(values - np.where(present, mean, 0.0), present, frames)
    return StillMeans(mean, sigma, frames.astype(np.int64))


def _sigma_from_blocks(
    residuals: FloatArray, present: NDArray[np.bool_], frames: NDArray[np.intp]
) -> FloatArray:
    """The means' (c,) standard deviations from (m, c) residuals, 0 where a value is lost."""
    if residuals.shape[0] == 0:
        return np.full(residuals.shape[1], np.nan)
    starts = np.unique(np.linspace(0, residuals.shape[0], BLOCKS, endpoint=False).astype(int))
    sums = np.add.reduceat(residuals, starts, axis=0)
    sizes = np.add.reduceat(present.astype(np.float64), starts, axis=0)
    filled = (sizes > 0).sum(axis=0)
    spread = (sums**2 / np.maximum(sizes, 1.0)).sum(axis=0)
    variance = spread / np.maximum(filled - 1, 1) / np.maximum(frames, 1)
    least = ROUNDING**2 / np.maximum(frames, 1)
    return np.where(frames > 0, np.sqrt(np.maximum(variance, least)), np.nan)
