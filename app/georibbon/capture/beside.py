"""How a ribbon lies beside its neighbour: how parallel, how far, and what to do about it.

Points are matched where they lie across from each other.  The angle between two
passes is taken in the surface: the neighbour's tangent is first carried over by
the smallest rotation of its normal into the other's, so that what both have
from the surface's own bend counts for nothing.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.correspondence import match_feet
from georibbon.geometry.frames import Strip, interpolated, rotations_between, unit

Kind = Literal["crosses", "turn-left", "turn-right", "near", "far"]
Where = Literal["start", "middle", "end", "all"]

STEP = 0.02  # m between matched points
LEAST_MATCHED = 3
MOST_TURN = np.radians(2.0)  # beyond it a person is told to turn the ribbon
NEAR, FAR = 0.7, 1.4  # of the planned spacing
END = 0.25  # share of the matched stretch that counts as its start or its end


@dataclass(frozen=True)
class Beside:
    """How a pass lies beside its neighbour; angles in radians, lengths in metres.

    turn: mean angle, counter-clockwise (to the left) seen against the normal.
    angle_rms, angle_worst: of the angle along the pass, the worst with its
    sign, at angle_at along the pass.  least, mean, most: the distance across;
    least_at, most_at along the pass.  start, end: the distance there.  side: +1
    where it lies to the left of the neighbour, seen along it; -1 to its right.
    crossing: where it crosses the neighbour, None where it does not.
    """

    neighbour: str
    turn: float
    angle_rms: float
    angle_worst: float
    angle_at: float
    least: float
    least_at: float
    mean: float
    most: float
    most_at: float
    start: float
    end: float
    stretch: tuple[float, float]
    side: float
    crossing: float | None


@dataclass(frozen=True)
class Hint:
    """What to do: turn by `amount` radians, or move by `amount` metres, and where.

    "crosses": at `amount` metres along the pass.
    """

    kind: Kind
    amount: float
    where: Where


def compare(live: Strip, other: Strip, name: str) -> Beside | None:
    """How one strip lies beside another, in one frame; None where they hardly lie side by side.

    Either may run against the other.
    """
    if float(np.sum(live.tangents.mean(axis=0) * other.tangents.mean(axis=0))) < 0.0:
        other = other.reversed()
    count = max(LEAST_MATCHED, round(float(live.s[-1] - live.s[0]) / STEP) + 1)
    at = np.linspace(live.s[0], live.s[-1], count)
    t, valid = match_feet(
        live.points, live.tangents, live.s, other.points, other.tangents, other.s, at
    )
    if np.count_nonzero(valid) < LEAST_MATCHED:
        return None
    return _told(live, other, name, at[valid], t[valid])


def _told(live: Strip, other: Strip, name: str, at: FloatArray, t: FloatArray) -> Beside:
    chord = interpolated(at, live.s, live.points) - interpolated(t, other.s, other.points)
    far = np.linalg.norm(chord, axis=1)
    angle = _angles(live, other, at, t)
    across = np.sum(chord * interpolated(t, other.s, other.conormals), axis=1)
    worst, least, most = np.argmax(np.abs(angle)), np.argmin(far), np.argmax(far)
    crossing = _crossing(at, across)
    if crossing is not None:
        least_distance, least_at = 0.0, crossing
    else:
        least_distance, least_at = float(far[least]), float(at[least])
    return Beside(
        neighbour=name,
        turn=float(angle.mean()),
        angle_rms=float(np.sqrt(np.mean(angle**2))),
        angle_worst=float(angle[worst]),
        angle_at=float(at[worst]),
        least=least_distance,
        least_at=least_at,
        mean=float(far.mean()),
        most=float(far[most]),
        most_at=float(at[most]),
        start=float(far[0]),
        end=float(far[-1]),
        stretch=(float(at[0]), float(at[-1])),
        side=float(np.copysign(1.0, np.median(across))),
        crossing=crossing,
    )


def _angles(live: Strip, other: Strip, at: FloatArray, t: FloatArray) -> FloatArray:
    """(k,) from the neighbour's tangent, carried over, to the live one, about the live normal."""
    normal = unit(interpolated(at, live.s, live.normals))
    ahead = unit(interpolated(at, live.s, live.tangents))
    theirs = unit(interpolated(t, other.s, other.normals))
    beside = unit(interpolated(t, other.s, other.tangents))
    carried = (rotations_between(theirs, normal) @ beside[..., None])[..., 0]
    sine = np.sum(normal * np.cross(carried, ahead), axis=1)
    return np.asarray(np.arctan2(sine, np.sum(carried * ahead, axis=1)))


def _crossing(at: FloatArray, across: FloatArray) -> float | None:
    """Where the side changes, metres along the pass."""
    changes = np.flatnonzero(across[:-1] * across[1:] <= 0.0)
    if len(changes) == 0:
        return None
    k = int(changes[0])
    span = abs(across[k]) + abs(across[k + 1])
    share = 0.5 if span == 0.0 else abs(across[k]) / span
    return float(at[k] + share * (at[k + 1] - at[k]))


def advise(beside: Beside, spacing: float) -> tuple[Hint, ...]:
    """What to do, the gravest first; nothing where it lies well.  spacing: metres, as planned."""
    if beside.crossing is not None:
        return (Hint("crosses", beside.crossing, "all"),)
    hints = []
    if abs(beside.turn) > MOST_TURN:
        kind: Kind = "turn-right" if beside.turn > 0.0 else "turn-left"
        hints.append(Hint(kind, abs(beside.turn), "end"))
    if beside.least < NEAR * spacing:
        where = _where(beside, beside.least_at, beside.most < NEAR * spacing)
        hints.append(Hint("near", spacing - beside.least, where))
    if beside.most > FAR * spacing:
        where = _where(beside, beside.most_at, beside.least > FAR * spacing)
        hints.append(Hint("far", beside.most - spacing, where))
    return tuple(hints)


def _where(beside: Beside, at: float, everywhere: bool) -> Where:
    """At the start, in the middle, at the end; all along where it is so everywhere."""
    if everywhere:
        return "all"
    low, high = beside.stretch
    share = (at - low) / (high - low)
    return "start" if share < END else "end" if share > 1.0 - END else "middle"
