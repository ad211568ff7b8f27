"""From a recording's survey to equations: what holds the passes, and what must be assumed.

A ribbon measures no position.  Marks hold a pass in the workpiece; crossings
hold passes to each other; distances hold them loosely, so that a weak
assumption settles what they leave open.  A pass that nothing holds is refused.
"""

import itertools
from dataclasses import dataclass

import numpy as np

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
from georibbon.recording import Recording

# Points between which a distance was measured lie across from each other, to this along the
# passes, and to this square to the surface.
ACROSS_SIGMA = 0.010
LEVEL_SIGMA = 0.003
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
    _require_held(survey, held, workpiece if survey.marked else 0)
    return survey


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


def _require_held(survey: Survey, held: _Groups, anchor: int) -> None:
    names = list(survey.number)
    lost = [name for k, name in enumerate(names) if held.find(k) != held.find(anchor)]
    if not lost:
        return
    if len(lost) == len(names) - 1 and not survey.marked:
        raise FitError(
            "the survey holds no pass to another, so nothing says where they lie: add marks "
            "([[mark]]), distances between neighbours ([[distance]]) or tie passes with their "
            "crossings ([[crossing]])"
        )
    to = "the marked passes" if survey.marked else f"pass {names[0]}"
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
        out.append(
            DistanceSet(
                np.array([number[one.passes[0]] for one in recording.distances]),
                np.array([number[one.passes[1]] for one in recording.distances]),
                np.array([one.at for one in recording.distances]),
                np.array([one.distance for one in recording.distances]),
                np.array([one.sigma for one in recording.distances]),
            )
        )
    if recording.crossings:
        out.append(
            CrossingSet(
                np.array([number[one.passes[0]] for one in recording.crossings]),
                np.array([number[one.passes[1]] for one in recording.crossings]),
                np.array([one.at for one in recording.crossings]),
                np.array([one.sigma for one in recording.crossings]),
            )
        )
    return out


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
    """Marks of consecutive passes at most alike places: the lines taken as square to the passes."""
    first: dict[int, tuple[float, tuple[float, float, float]]] = {}
    for mark in survey.recording.marks:
        first.setdefault(survey.number[mark.pass_name], (mark.at, mark.position))
    marked = [k for k in sorted(first) if survey.recording.passes[k].kind == "pass"]
    out = []
    for i, j in itertools.pairwise(marked):
        apart = np.linalg.norm(np.subtract(first[j][1], first[i][1]))
        out.append(Pair(i, j, (first[i][0], first[j][0]), float(apart)))
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
