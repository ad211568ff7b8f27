"""Neighbouring passes know each other: the chord between them is square to their mean normal.

On a smooth surface the chord c between matched points of neighbouring passes obeys

    c . (N_a + N_b) / 2 = -d²/12 (k_b - k_a) + higher orders,        d = |c|

with k the normal curvature of the section between them at either pass (the
Euler-Maclaurin formula for the section's height by its slopes).  The right
side vanishes on circular sections; elsewhere k is known from how the normals
turn from pass to pass, and the relation holds to the next order as well.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.survey import ChordSet, Placed
from georibbon.geometry.correspondence import arrange, feet
from georibbon.geometry.frames import Strip, interpolated

SPACING = 0.06  # m between the matched points: the passes' own errors hardly change over less
LEAST_SIGMA = 0.3e-3  # m: contact, and what the next order leaves on gentle surfaces
DOUBT = 0.5  # the share of the correction that may be wrong
# m: the chord at which the next order is as doubtful as contact; it grows with the chord's cube.
REACH = 0.15


@dataclass(frozen=True, eq=False)
class _Gap:
    """Matched points between neighbours a and b in their common direction.

    s, t: (k,) metres along either.  chord: (k,) metres.  bend: (k,) the mean
    normal curvature of the section between them, 1/m.
    """

    s: FloatArray
    t: FloatArray
    chord: FloatArray
    bend: FloatArray


def relate(placed: Placed, passes: list[int]) -> ChordSet | None:
    """The relation at matched points of neighbours among the given passes; None if none match."""
    nodes = placed.grid.nodes
    strips = [Strip(nodes, placed.points[p], placed.frames[p]) for p in passes]
    if len(strips) < 2:
        return None
    arrangement = arrange(strips)
    ordered = arrangement.strips
    gaps = [_match(a, b) for a, b in itertools.pairwise(ordered)]
    i, j, at, offset, chords = [], [], [], [], []
    for g, gap in enumerate(gaps):
        one, other = arrangement.order[g], arrangement.order[g + 1]
        if arrangement.flipped[g] != arrangement.flipped[g + 1]:
            continue  # one of the two was laid face down, and its normals are not the surface's
        facing = -1.0 if arrangement.flipped[g] else 1.0
        i.append(np.full(len(gap.s), passes[one]))
        j.append(np.full(len(gap.s), passes[other]))
        s = nodes[-1] - gap.s if arrangement.turned[g] else gap.s
        t = nodes[-1] - gap.t if arrangement.turned[g + 1] else gap.t
        at.append(np.stack([s, t], axis=1))
        offset.append(facing * _offset(gaps, g))
        chords.append(gap.chord)
    if sum(len(part) for part in offset) == 0:
        return None
    expected = np.concatenate(offset)
    chord = np.concatenate(chords)
    sigma = np.hypot(LEAST_SIGMA * np.hypot(1.0, (chord / REACH) ** 3), DOUBT * expected)
    return ChordSet(np.concatenate(i), np.concatenate(j), np.concatenate(at), expected, sigma)


def _match(a: Strip, b: Strip) -> _Gap:
    """Points across from each other every 6 cm, half a spacing from the ends on."""
    count = max(int(a.s[-1] / SPACING), 1)
    at = (np.arange(count) + 0.5) * a.s[-1] / count
    t, valid = feet(a, b, at)
    s, t = at[valid], t[valid]
    chord = interpolated(t, b.s, b.points) - interpolated(s, a.s, a.points)
    square = np.maximum(np.sum(chord**2, axis=1), 1e-12)
    turn = interpolated(t, b.s, b.normals) - interpolated(s, a.s, a.normals)
    bend = -np.sum(turn * chord, axis=1) / square
    return _Gap(s, t, np.sqrt(square), bend)


def _offset(gaps: list[_Gap], g: int) -> FloatArray:
    """-d²/12 (k_b - k_a), with the curvature at either pass from the gaps on its two sides."""
    gap = gaps[g]
    rises = []
    if g > 0 and len(gaps[g - 1].t):
        rises.append(-_rise(gap.bend, gap.chord, gaps[g - 1], gap.s, gaps[g - 1].t))
    if g + 1 < len(gaps) and len(gaps[g + 1].s):
        rises.append(_rise(gap.bend, gap.chord, gaps[g + 1], gap.t, gaps[g + 1].s))
    if not rises or not len(gap.s):
        return np.zeros(len(gap.s))
    # With a neighbour on one side only the curvature is taken to change alike on the other.
    change = rises[0] + rises[1] if len(rises) == 2 else 2 * rises[0]
    return np.asarray(-(gap.chord**2) / 12 * change)


def _rise(
    bend: FloatArray, chord: FloatArray, beside: _Gap, here: FloatArray, places: FloatArray
) -> FloatArray:
    """The curvature at the pass shared with the gap beside, less this gap's own mean curvature."""
    order = np.argsort(places)
    other = np.interp(here, places[order], beside.bend[order])
    width = np.interp(here, places[order], beside.chord[order])
    return (other - bend) * chord / (chord + width)
