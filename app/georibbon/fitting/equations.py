"""From a recording's survey to equations: what holds the passes, and what must be assumed.

A ribbon measures no position.  Marks hold a pass in the workpiece; crossings
hold passes to each other; distances hold them loosely, so that a weak
assumption settles what they leave open.  A pass that nothing holds is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import FitError
from georibbon.fitting.placing import Link
from georibbon.fitting.survey import (
    AcrossSet,
    ChordSet,
    CrossingSet,
    DistanceSet,
    MarkSet,
    Observation,
)
from georibbon.notices import Notice
from georibbon.recording import Crossing, Distance, Recording

# Points between which a distance was measured lie across from each other, to this along the
# passes, and to this square to the surface.  Neighbours tell a slide of a pass along itself to a
# few mm only; a technician who measures between starts has them in line better than that.
ACROSS_SIGMA = 0.003
LEVEL_SIGMA = 0.003
ALIKE_PLACES = 0.05  # m
SLACK = 0.02  # m, what a slip of the tape may be; the fit names it
SPREAD = 10.0  # ribbon lengths: no neighbour lies farther away
_ROUGHLY = 0.02  # how near a neighbour lies to its distance along the conormal, at first


@dataclass(frozen=True)
class Pair:
    """Points of two passes, by number and metres along either, and how far they are apart."""

    i: int
    j: int
    at: tuple[float, float]
    distance: float


@dataclass(frozen=True)
class Survey:
    """A recording's survey, its passes by number.

    marked: whether any mark ties the passes to the workpiece.  loose: the
    distances that alone hold their passes to each other.
    """

    recording: Recording
    number: dict[str, int]
    marked: bool
    loose: tuple[Pair, ...]


def read_survey(recording: Recording) -> Survey:
    """The survey, checked: every pass must be held.

    Raises `FitError` naming the passes that nothing holds.
    """
    number = {one.name: k for k, one in enumerate(recording.passes)}
    _require_possible(recording)
    held = _Groups(len(number) + 1)
    workpiece = len(number)
    for mark in recording.marks:
        held.join(workpiece, number[mark.pass_name])
    for crossing in recording.crossings:
        held.join(number[crossing.passes[0]], number[crossing.passes[1]])
    loose = []
    for one in recording.distances:
        i, j = number[one.passes[0]], number[one.passes[1]]
        if held.find(i) != held.find(j):
            loose.append(Pair(i, j, one.at, one.distance))
    for pair in loose:
        held.join(pair.i, pair.j)
    survey = Survey(recording, number, bool(recording.marks), tuple(loose))
    _require_held(survey, held, workpiece if survey.marked else None)
    return survey


def holds_itself(survey: Survey) -> bool:
    """Whether crossings and distances alone hold all passes to each other, without the marks."""
    held = _Groups(len(survey.number))
    pairs = [one.passes for one in survey.recording.crossings]
    pairs += [one.passes for one in survey.recording.distances]
    for one, other in pairs:
        held.join(survey.number[one], survey.number[other])
    return len({held.find(k) for k in range(len(survey.number))}) == 1


def _require_possible(recording: Recording) -> None:
    """No two points of a ribbon are farther apart than it is long between them."""
    length = recording.ribbon.length
    for one in recording.distances:
        most = SPREAD * length if one.passes[0] != one.passes[1] else abs(one.at[1] - one.at[0])
        if one.distance > most + 5 * one.sigma + SLACK:
            raise FitError(
                f"the distance between {one.passes[0]} and {one.passes[1]} is {one.distance:g} m, "
                f"but the ribbon is {length:g} m long: give distances in metres"
            )
    for a, b in pairwise(sorted(recording.marks, key=lambda mark: (mark.pass_name, mark.at))):
        apart = float(np.linalg.norm(np.subtract(a.position, b.position)))
        same = a.pass_name == b.pass_name
        most = abs(a.at - b.at) if same else SPREAD * length * len(recording.passes)
        if apart > most + 5 * float(np.hypot(a.sigma, b.sigma)) + SLACK:
            between = f"only {most:g} m of ribbon lie between them" if same else "that is too far"
            raise FitError(
                f"the marks of {a.pass_name} at {a.at:g} m and of {b.pass_name} at {b.at:g} m are "
                f"{apart:g} m apart, but {between}: give positions in metres, and look at both"
            )


def without_loose_ties(recording: Recording) -> tuple[Recording, tuple[Notice, ...]]:
    """The recording without tie passes that the survey nowhere names, and a notice for each."""
    named = {mark.pass_name for mark in recording.marks}
    named.update(name for one in recording.distances for name in one.passes)
    named.update(name for one in recording.crossings for name in one.passes)
    loose = [one for one in recording.passes if one.kind == "tie" and one.name not in named]
    notices = [
        Notice(
            "tie-left-out",
            f"tie {one.name} has no crossing with any pass and is left out; note where it crosses "
            "([[crossing]])",
            one.name,
        )
        for one in loose
    ]
    kept = tuple(one for one in recording.passes if one not in loose)
    return (replace(recording, passes=kept) if loose else recording), tuple(notices)


class _Groups:
    """Things joined into groups (union and find)."""

    def __init__(self, size: int) -> None:
        self.parent = list(range(size))

    def find(self, k: int) -> int:
        """The group that k belongs to."""
        while self.parent[k] != k:
            self.parent[k] = self.parent[self.parent[k]]
            k = self.parent[k]
        return k

    def join(self, a: int, b: int) -> None:
        """Puts the groups of a and b together."""
        self.parent[self.find(a)] = self.find(b)


def _require_held(survey: Survey, held: _Groups, anchor: int | None) -> None:
    """Every pass must be in the workpiece's group, or without marks in the largest."""
    names = list(survey.number)
    groups = [held.find(k) for k in range(len(names))]
    if anchor is None and len(set(groups)) == len(names) > 1:
        raise FitError(
            "the survey holds no pass to another, so nothing says where they lie: add marks "
            "([[mark]]), distances between neighbours ([[distance]]) or tie passes with their "
            "crossings ([[crossing]])"
        )
    main = held.find(anchor) if anchor is not None else max(groups, key=groups.count)
    lost = [name for name, group in zip(names, groups, strict=True) if group != main]
    if lost:
        to = "the marked passes" if anchor is not None else f"pass {names[groups.index(main)]}"
        raise FitError(
            f"nothing in the survey holds {'pass' if len(lost) == 1 else 'passes'} "
            f"{', '.join(lost)} to {to}: add a mark, a distance or a crossing for each"
        )


def observations(survey: Survey) -> list[Observation]:
    """What was measured, as equations: marks, distances, crossings, in this order."""
    recording, number = survey.recording, survey.number
    out: list[Observation] = []
    if recording.marks:
        out.append(
            MarkSet(
                np.array([number[mark.pass_name] for mark in recording.marks]),
                np.array([mark.at for mark in recording.marks]),
                np.array([mark.position for mark in recording.marks]),
                np.array([mark.sigma for mark in recording.marks]),
            )
        )
    if recording.distances:
        i, j, at, sigma = _places(number, recording.distances)
        measured = np.array([one.distance for one in recording.distances])
        out.append(DistanceSet(i, j, at, measured, sigma))
    if recording.crossings:
        out.append(CrossingSet(*_places(number, recording.crossings)))
    return out


def _places(
    number: dict[str, int], observed: Sequence[Distance | Crossing]
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """The passes i and j (k,), the places along either (k, 2) and the sigmas (k,)."""
    passes = np.array([[number[name] for name in one.passes] for one in observed])
    at = np.array([one.at for one in observed])
    return passes[:, 0], passes[:, 1], at, np.array([one.sigma for one in observed])


def loose_assumptions(pairs: tuple[Pair, ...]) -> list[Observation]:
    """That the points of loose pairs lie across from each other, and level with the surface."""
    if not pairs:
        return []
    i, j = np.array([pair.i for pair in pairs]), np.array([pair.j for pair in pairs])
    at = np.array([pair.at for pair in pairs])
    zero = np.zeros(len(pairs))
    return [
        AcrossSet(i, j, at, zero + ACROSS_SIGMA),
        ChordSet(i, j, at, zero, zero + LEVEL_SIGMA),
    ]


def square_pairs(survey: Survey) -> tuple[Pair, ...]:
    """The marks of consecutive marked passes nearest to each other along the ribbon.

    The lines between them are taken as square to the passes; marks at places
    more than 5 cm different are not.
    """
    marks: dict[int, list[tuple[float, tuple[float, float, float]]]] = {}
    for mark in survey.recording.marks:
        marks.setdefault(survey.number[mark.pass_name], []).append((mark.at, mark.position))
    marked = [k for k in sorted(marks) if survey.recording.passes[k].kind == "pass"]
    out = []
    for i, j in pairwise(marked):
        (s, x), (t, y) = min(
            ((a, b) for a in marks[i] for b in marks[j]), key=lambda ab: abs(ab[0][0] - ab[1][0])
        )
        if abs(s - t) <= ALIKE_PLACES:
            out.append(Pair(i, j, (s, t), float(np.linalg.norm(np.subtract(y, x)))))
    return tuple(out)


def links(survey: Survey, assumed: tuple[Pair, ...], side: float) -> list[Link]:
    """The survey for the first, rigid placing; loose and assumed pairs lie on the given side."""
    recording, number = survey.recording, survey.number
    out = [
        Link(number[mark.pass_name], mark.at, mark.sigma, target=mark.position)
        for mark in recording.marks
    ]
    out += [
        Link(number[c.passes[0]], c.at[0], c.sigma, number[c.passes[1]], c.at[1])
        for c in recording.crossings
    ]
    out += [
        Link(pair.i, pair.at[0], _ROUGHLY, pair.j, pair.at[1], side=side * pair.distance)
        for pair in (*survey.loose, *assumed)
    ]
    if not survey.marked:
        out.append(Link(0, 0.0, 1e-3))
    return out
