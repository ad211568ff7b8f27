"""Where the passes that are taken lie, as far as it is known, and where the next one begins.

A ribbon measures no place.  Until the survey holds the passes, each is laid at
the planned spacing to the left of the one before; what a reconstruction has
placed lies there, and all else beside it.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration
from georibbon.capture.live import LiveCurve, LiveFit
from georibbon.capture.plan import tie_places
from georibbon.errors import FitError
from georibbon.geometry.frames import Strip, frames_from, interpolated, unit
from georibbon.recording import PassKind
from georibbon.ribbon import Readings, Ribbon
from georibbon.rotations import about_z
from georibbon.stillness import still_means, without_railed

TIE_AHEAD = 0.5  # share of a tie's length that lies before the middle pass


@dataclass(frozen=True, eq=False)
class Lone:
    """A pass by itself: its curve in magnetic axes, from anywhere."""

    name: str
    kind: PassKind
    strip: Strip


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of places: by a reconstruction, or nothing.

    strips: by the pass's name, in the workpiece frame.  heading: radians, of
    the workpiece against magnetic axes.  starts: (3,) by the pass's name, in
    the workpiece frame, where its start was marked.
    """

    strips: Mapping[str, Strip] = field(default_factory=dict)
    heading: float = 0.0
    starts: Mapping[str, FloatArray] = field(default_factory=dict)


def lone_curve(ribbon: Ribbon, calibration: Calibration, readings: Readings) -> LiveCurve | None:
    """The curve of a pass that was taken, by itself; None where its readings say too little."""
    means = still_means(without_railed(readings)[0])
    with suppress(FitError):
        return LiveFit(ribbon, calibration).update(means.mean, means.sigma)
    return None


def object_axes(strips: Iterable[Strip]) -> FloatArray:
    """(3, 3) columns: along the first pass, to its left, out of the surface; unit, square.

    World axes where there is no strip.
    """
    first = next(iter(strips), None)
    if first is None:
        return np.eye(3)
    chord = first.points[-1] - first.points[0]
    return frames_from(unit(chord), first.normals.mean(axis=0))


def neighbour_of(name: str, order: Sequence[str], there: Mapping[str, object]) -> str | None:
    """The pass that another is laid beside: the nearest before it that is there, or after it."""
    if name not in order:
        return next((one for one in reversed(order) if one in there), None)
    k = list(order).index(name)
    for one in (*reversed(order[:k]), *order[k + 1 :]):
        if one in there:
            return one
    return None


def place_all(
    taken: Sequence[Lone], order: Sequence[str], spacing: float, known: Known
) -> dict[str, Strip]:
    """All passes that are taken, then the ties, each where it lies or is meant to lie.

    order: the names of all passes, taken or not, without the ties.  spacing: metres.
    """
    placed: dict[str, Strip] = {}
    by_name = {one.name: one for one in taken}
    for name in order:
        if name in by_name:
            placed[name] = _place(by_name[name], order, placed, spacing, known)
    ties = [one for one in taken if one.kind == "tie"]
    for k, one in enumerate(ties):
        fraction = tie_places(len(ties))[k]
        placed[one.name] = place_tie(one, fraction, order, placed, known)
    return placed


def place_live(
    live: Lone, order: Sequence[str], placed: Mapping[str, Strip], spacing: float, known: Known
) -> Strip:
    """Where a pass that is being laid lies, its start beside its neighbour's.

    A pass that is repeated begins where it began.
    """
    before = placed.get(live.name)
    strip = _turned(live.strip, known)
    if live.name in known.strips and before is not None:
        return _moved(strip, before.points[0] - strip.points[0])
    others = {name: one for name, one in placed.items() if name != live.name}
    return _beside(live.name, strip, order, others, spacing, known)


def place_tie(
    tie: Lone,
    fraction: float,
    order: Sequence[str],
    placed: Mapping[str, Strip],
    known: Known,
) -> Strip:
    """A tie, its middle on the middle pass at a fraction of it, where it is not known better."""
    if tie.name in known.strips:
        return known.strips[tie.name]
    strip = _turned(tie.strip, known)
    passes = [name for name in order if name in placed]
    if not passes:
        return strip
    middle = placed[passes[(len(passes) - 1) // 2]]
    target = _point(middle, fraction)
    return _moved(strip, target - _point(strip, TIE_AHEAD))


def _place(
    one: Lone, order: Sequence[str], placed: Mapping[str, Strip], spacing: float, known: Known
) -> Strip:
    if one.name in known.strips:
        return known.strips[one.name]
    there = {**{name: known.strips[name] for name in known.strips if name in order}, **placed}
    return _beside(one.name, _turned(one.strip, known), order, there, spacing, known)


def _beside(
    name: str,
    strip: Strip,
    order: Sequence[str],
    there: Mapping[str, Strip],
    spacing: float,
    known: Known,
) -> Strip:
    """A strip with its start at its mark, or at the planned spacing from its neighbour's."""
    if name in known.starts:
        return _moved(strip, known.starts[name] - strip.points[0])
    beside = neighbour_of(name, order, there)
    if beside is None:
        return _moved(strip, -strip.points[0])
    other = there[beside]
    if float(np.sum(strip.tangents.mean(axis=0) * other.tangents.mean(axis=0))) < 0.0:
        # It runs the other way: its end lies beside the neighbour's start.
        own, steps = strip.points[-1], _steps(name, beside, order)
    else:
        own, steps = strip.points[0], _steps(name, beside, order)
    return _moved(strip, other.points[0] + steps * spacing * other.conormals[0] - own)


def _steps(name: str, beside: str, order: Sequence[str]) -> int:
    """How many spacings to the left of its neighbour a pass lies."""
    if name not in order:
        return 1
    places = list(order)
    return places.index(name) - places.index(beside)


def _turned(strip: Strip, known: Known) -> Strip:
    """From magnetic axes to the workpiece's."""
    turn = about_z(-known.heading)
    return Strip(strip.s, strip.points @ turn.T, turn @ strip.frames)


def _moved(strip: Strip, by: FloatArray) -> Strip:
    return Strip(strip.s, strip.points + by, strip.frames)


def _point(strip: Strip, fraction: float) -> FloatArray:
    at = strip.s[0] + fraction * (strip.s[-1] - strip.s[0])
    return np.asarray(interpolated(np.array([at]), strip.s, strip.points)[0])
