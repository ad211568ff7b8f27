"""Each pass by itself: every distinct shape that its readings allow, best first."""

from collections.abc import Sequence

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Shape, integrate_frames
from georibbon.fitting.smoothing import best_lengths, information_density, weight_of_length
from georibbon.fitting.start import find_starts
from georibbon.fitting.strip import StripProblem, Strips, fit_strips

# A minimum whose cost is this much above the best is no candidate: the readings exclude it, even
# where the sensors' common errors, which are not in a single pass's cost, favour it.
KEEP_WITHIN = 40.0
SAME_SHAPE = 0.05  # two minima whose frames differ nowhere by more (about 3 degrees) are one
FIRST_LENGTH = 0.12  # m, the smoothing before the evidence has spoken


def find_candidates(problem: StripProblem, lengths: FloatArray) -> list[Strips]:
    """For each of b passes its distinct minima, best first, in magnetic axes.

    lengths: (b,) smoothing lengths, metres; NaN for one chosen by the evidence.
    """
    density = information_density(problem)
    starts = find_starts(problem)
    many = problem.take(starts.owner)
    asked = lengths[starts.owner]
    first = np.where(np.isnan(asked), FIRST_LENGTH, asked)
    strips = fit_strips(many, starts.shape, weight_of_length(first, density))
    if np.isnan(asked).any():
        chosen = np.where(np.isnan(asked), best_lengths(many, strips), asked)
        strips = fit_strips(many, strips.shape, weight_of_length(chosen, density))
    frames = integrate_frames(problem.grid, strips.shape)
    return [
        strips.take(_distinct(np.flatnonzero(starts.owner == p), strips.cost, frames))
        for p in range(len(lengths))
    ]


def _distinct(places: IntArray, cost: FloatArray, frames: FloatArray) -> list[int]:
    """The places of the distinct minima near the best, best first."""
    kept: list[int] = []
    ordered = places[np.argsort(cost[places], kind="stable")]
    for k in ordered:
        if cost[k] > cost[ordered[0]] + KEEP_WITHIN:
            break
        if all(np.abs(frames[k] - frames[other]).max() > SAME_SHAPE for other in kept):
            kept.append(int(k))
    return kept


def stack(strips: Sequence[Strips]) -> Strips:
    """Several stacks as one."""
    return Strips(
        Shape(
            np.concatenate([part.shape.start for part in strips]),
            np.concatenate([part.shape.rates for part in strips]),
        ),
        np.concatenate([part.cost for part in strips]),
        np.concatenate([part.normal for part in strips]),
        np.concatenate([part.squares for part in strips]),
        np.concatenate([part.smoothing for part in strips]),
    )
