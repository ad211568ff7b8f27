"""Each pass by itself: every distinct shape that its readings allow, best first."""

from collections.abc import Sequence

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Shape, integrate_frames
from georibbon.fitting.smoothing import best_lengths, information_density, weight_of_length
from georibbon.fitting.start import find_starts
from georibbon.fitting.strip import StripProblem, Strips, fit_strips

# A minimum whose cost is this much above the best is no candidate: not even a magnet near half of
# the magnetometers, or what all passes share, would favour it by more.
KEEP_WITHIN = 150.0
SAME_SHAPE = 0.05  # two minima whose frames differ nowhere by more (about 3 degrees) are one
# A pass is at odds with its sensors where this many are this many standard deviations off.
ODD_RESIDUAL = 5.0
ODD_SENSORS = 2
MOST_LENDERS = 3
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


def refitted(
    problem: StripProblem, candidates: Sequence[Strips], lengths: FloatArray
) -> list[Strips]:
    """The candidates fitted again from where they are, the problem's noise having changed."""
    counts = [len(part.cost) for part in candidates]
    owner = np.repeat(np.arange(len(counts)), counts)
    many, strips = problem.take(owner), stack(candidates)
    asked = lengths[owner]
    chosen = np.where(np.isnan(asked), best_lengths(many, strips), asked)
    weights = weight_of_length(chosen, information_density(problem))
    strips = fit_strips(many, strips.shape, weights)
    frames = integrate_frames(problem.grid, strips.shape)
    return [
        strips.take(_distinct(np.flatnonzero(owner == p), strips.cost, frames))
        for p in range(len(counts))
    ]


def with_borrowed(problem: StripProblem, candidates: Sequence[Strips]) -> list[Strips]:
    """The candidates, and for a pass at odds with its sensors those that other passes lead to.

    Where a magnet hides half of a pass's magnetometers its own readings lead
    astray; near-parallel passes have nearly its shape.
    """
    odd = [int(np.sum(part.squares[0] > ODD_RESIDUAL**2)) for part in candidates]
    lenders = [p for p in np.argsort(odd, kind="stable") if odd[p] < ODD_SENSORS][:MOST_LENDERS]
    out = list(candidates)
    for p, count in enumerate(odd):
        if count >= ODD_SENSORS and lenders:
            starts = stack([candidates[k].take([0]) for k in lenders]).shape
            smoothing = np.repeat(candidates[p].smoothing[:1], len(lenders))
            lent = fit_strips(problem.take([p] * len(lenders)), starts, smoothing)
            both = stack([candidates[p], lent])
            frames = integrate_frames(problem.grid, both.shape)
            out[p] = both.take(_distinct(np.arange(len(both.cost)), both.cost, frames))
    return out


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
