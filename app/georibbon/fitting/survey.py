"""The survey as equations: what marks, distances, crossings and assumptions say of the curves.

Every observation is a residual, already divided by its standard deviation, with
its derivatives by the unknowns of the one or two passes it touches.  A pass's
unknowns are those of its strip (m of them) and its start point (3).
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Grid
from georibbon.geometry.frames import frames_from, unit
from georibbon.rotations import skew

# Where two passes cross, both lie on one surface: there the curves meet to what contact leaves
# and the normals agree.
CROSSING_NORMAL_SIGMA = np.radians(0.3)


@dataclass(frozen=True, eq=False)
class Placed:
    """All p passes as placed curves with derivatives, at the nodes of their grid.

    points: (p, n + 1, 3).  frames: (p, n + 1, 3, 3).  moves: (p, n + 1, 3, m)
    derivatives of the points by the strips' unknowns.  turns: (p, n + 1, 3, m).
    """

    grid: Grid
    points: FloatArray
    frames: FloatArray
    moves: FloatArray
    turns: FloatArray


@dataclass(frozen=True, eq=False)
class Samples:
    """k points on passes: where they are and how the unknowns move them.

    points: (k, 3).  frames: (k, 3, 3).  moves, turns: (k, 3, m + 3).
    """

    points: FloatArray
    frames: FloatArray
    moves: FloatArray
    turns: FloatArray


def sample(placed: Placed, which: IntArray, at: FloatArray) -> Samples:
    """The passes `which` (k,) at the arc lengths `at` (k,), by cubic Hermite interpolation."""
    nodes = placed.grid.nodes
    j = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    h = placed.grid.steps[j]
    u = np.clip((at - nodes[j]) / h, 0.0, 1.0)
    left, right = (which, j), (which, j + 1)
    end, start = u * u * (3 - 2 * u), 1 - u * u * (3 - 2 * u)
    rise, fall = h * u * (1 - u) ** 2, -h * u * u * (1 - u)
    tau0, tau1 = placed.frames[left][:, :, 0], placed.frames[right][:, :, 0]
    points = _blend(start, placed.points[left], end, placed.points[right])
    points += _blend(rise, tau0, fall, tau1)
    turns = _blend(1 - u, placed.turns[left], u, placed.turns[right])
    moves = _blend(start, placed.moves[left], end, placed.moves[right])
    moves -= _blend(rise, skew(tau0) @ placed.turns[left], fall, skew(tau1) @ placed.turns[right])
    k = len(at)
    whole = np.concatenate([moves, np.broadcast_to(np.eye(3), (k, 3, 3))], axis=2)
    turned = np.concatenate([turns, np.zeros((k, 3, 3))], axis=2)
    return Samples(points, _frames_between(placed, left, right, u), whole, turned)


def _blend(a: FloatArray, x: FloatArray, b: FloatArray, y: FloatArray) -> FloatArray:
    shape = (-1,) + (1,) * (x.ndim - 1)
    return np.asarray(a.reshape(shape) * x + b.reshape(shape) * y)


def _frames_between(
    placed: Placed, left: tuple[IntArray, IntArray], right: tuple[IntArray, IntArray], u: FloatArray
) -> FloatArray:
    """Frames between nodes: the tangent and normal blended, made orthonormal again."""
    blended = _blend(1 - u, placed.frames[left], u, placed.frames[right])
    return frames_from(unit(blended[:, :, 0]), blended[:, :, 2])


@dataclass(frozen=True, eq=False)
class Rows:
    """k observations of d residuals each, normalised.

    residuals: (k, d).  first, second: (k, d, m + 3) derivatives by the unknowns
    of the pass `i` (k,) and of the pass `j` (k,).  Where only one pass is
    touched, j is i and `second` zero.
    """

    i: IntArray
    j: IntArray
    residuals: FloatArray
    first: FloatArray
    second: FloatArray

    @property
    def squares(self) -> FloatArray:
        """(k,) squared normalised residuals."""
        return np.asarray(np.sum(self.residuals**2, axis=1))


@dataclass(frozen=True, eq=False)
class MarkSet:
    """k marks: pass (k,), at (k,), position (k, 3) in the workpiece frame, sigma (k,)."""

    i: IntArray
    at: FloatArray
    position: FloatArray
    sigma: FloatArray

    def rows(self, placed: Placed) -> Rows:
        """(X(s) - m) / sigma."""
        here = sample(placed, self.i, self.at)
        scale = 1 / self.sigma
        residuals = (here.points - self.position) * scale[:, None]
        first = here.moves * scale[:, None, None]
        return Rows(self.i, self.i, residuals, first, np.zeros_like(first))


@dataclass(frozen=True, eq=False)
class DistanceSet:
    """k distances: passes i, j (k,), at (k, 2), distance (k,), sigma (k,)."""

    i: IntArray
    j: IntArray
    at: FloatArray
    distance: FloatArray
    sigma: FloatArray

    def rows(self, placed: Placed) -> Rows:
        """(|X_i(s) - X_j(t)| - d) / sigma."""
        one, other = sample(placed, self.i, self.at[:, 0]), sample(placed, self.j, self.at[:, 1])
        chord = one.points - other.points
        length = np.maximum(np.linalg.norm(chord, axis=1), 1e-9)
        along = (chord / length[:, None])[:, None, :] / self.sigma[:, None, None]
        residuals = ((length - self.distance) / self.sigma)[:, None]
        return Rows(self.i, self.j, residuals, along @ one.moves, -along @ other.moves)


@dataclass(frozen=True, eq=False)
class CrossingSet:
    """k crossings: passes i, j (k,), at (k, 2), sigma (k,)."""

    i: IntArray
    j: IntArray
    at: FloatArray
    sigma: FloatArray

    def rows(self, placed: Placed) -> Rows:
        """Five residuals: X_i(s) - X_j(t) over sigma; N_j along tau_i and V_i over 0.3 degrees."""
        one, other = sample(placed, self.i, self.at[:, 0]), sample(placed, self.j, self.at[:, 1])
        scale = (1 / self.sigma)[:, None]
        apart = (one.points - other.points) * scale
        normal = other.frames[:, :, 2]
        across = np.swapaxes(one.frames[:, :, :2], 1, 2)
        tilt = (across @ normal[..., None])[..., 0] / CROSSING_NORMAL_SIGMA
        # d(a . n) = a . (turn_j x n) + (turn_i x a) . n = (n x a) . (turn_j - turn_i)
        lever = np.cross(normal[:, None, :], across) / -CROSSING_NORMAL_SIGMA
        first = np.concatenate([one.moves * scale[..., None], lever @ one.turns], axis=1)
        second = np.concatenate([-other.moves * scale[..., None], -lever @ other.turns], axis=1)
        residuals = np.concatenate([apart, tilt], axis=1)
        return Rows(self.i, self.j, residuals, first, second)


@dataclass(frozen=True, eq=False)
class AcrossSet:
    """k assumptions that points lie across from each other: passes i, j, at (k, 2), sigma (k,)."""

    i: IntArray
    j: IntArray
    at: FloatArray
    sigma: FloatArray

    def rows(self, placed: Placed) -> Rows:
        """The chord along the mean tangent, (X_j(t) - X_i(s)) . (tau_i + tau_j)/|…| / sigma.

        tau_j is taken backwards where the second pass runs against the first.
        """
        one, other = sample(placed, self.i, self.at[:, 0]), sample(placed, self.j, self.at[:, 1])
        ahead_one, ahead_other = one.frames[:, :, 0], other.frames[:, :, 0]
        against = np.sum(ahead_one * ahead_other, axis=1, keepdims=True) < 0
        ahead_other = np.where(against, -ahead_other, ahead_other)
        both = ahead_one + ahead_other
        length = np.linalg.norm(both, axis=1, keepdims=True)
        mean = both / length
        chord = other.points - one.points
        along = np.sum(chord * mean, axis=1, keepdims=True)
        # The mean tangent turns with the passes: c . (turn x tau) = (tau x c) . turn
        rest = (chord - along * mean) / length
        lean_one = np.cross(ahead_one, rest)[:, None, :]
        lean_other = np.cross(ahead_other, rest)[:, None, :]
        ahead, scale = mean[:, None, :], (1 / self.sigma)[:, None, None]
        first = (lean_one @ one.turns - ahead @ one.moves) * scale
        second = (lean_other @ other.turns + ahead @ other.moves) * scale
        return Rows(self.i, self.j, along * scale[..., 0], first, second)


@dataclass(frozen=True, eq=False)
class ChordSet:
    """k relations between neighbours: passes i, j, at (k, 2), offset (k,) metres, sigma (k,).

    The chord c between matched points of neighbouring passes is square to the
    mean of the normals there where the section between them is a circular arc;
    `offset` is what c . (N_i + N_j)/2 is expected to be otherwise.
    """

    i: IntArray
    j: IntArray
    at: FloatArray
    offset: FloatArray
    sigma: FloatArray

    def rows(self, placed: Placed) -> Rows:
        """(c . (N_i + N_j)/2 - offset) / sigma."""
        one, other = sample(placed, self.i, self.at[:, 0]), sample(placed, self.j, self.at[:, 1])
        chord = other.points - one.points
        scale = (1 / self.sigma)[:, None, None]
        mean = 0.5 * (one.frames[:, :, 2] + other.frames[:, :, 2])[:, None, :]
        residuals = ((mean @ chord[..., None])[..., 0] - self.offset[:, None]) * scale[..., 0]
        # c . (turn x N) = (N x c) . turn
        lean_one = 0.5 * np.cross(one.frames[:, :, 2], chord)[:, None, :]
        lean_other = 0.5 * np.cross(other.frames[:, :, 2], chord)[:, None, :]
        first = (lean_one @ one.turns - mean @ one.moves) * scale
        second = (lean_other @ other.turns + mean @ other.moves) * scale
        return Rows(self.i, self.j, residuals, first, second)


Measurement = MarkSet | DistanceSet | CrossingSet
Assumption = AcrossSet | ChordSet
Observation = Measurement | Assumption
