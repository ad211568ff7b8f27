"""The joint adjustment followed while a smoothing moves.

At the minimum for one smoothing the normal matrix H and the gradient g are
known.  Another smoothing of some passes adds to both: with P the roughness of
a strip and r its rates, dw P and dw P r.  One step -(H + dw P)^-1 (g + dw P r)
then leads to the new minimum as nearly as the readings, linear in a strip that
moves by little, allow.  A step that turns a strip by much is taken, and the
equations are made anew where it leads to.
"""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.blocks import BlockMatrix, factorise
from georibbon.fitting.joint import JointProblem, State, equations, moved
from georibbon.fitting.strip import prior

FAR = float(np.radians(1.0))  # a turn beyond which the equations are made anew


@dataclass(frozen=True, eq=False)
class Foothold:
    """The equations of a joint problem at a state near its minimum."""

    problem: JointProblem
    state: State
    matrix: BlockMatrix
    gradient: list[FloatArray]


def stand(problem: JointProblem, state: State) -> Foothold:
    """The foothold at a state."""
    matrix, gradient = equations(problem, state)
    return Foothold(problem, state, matrix, gradient)


def follow(foothold: Foothold, smoothing: FloatArray) -> tuple[State, Foothold]:
    """The state for another smoothing (p,), and the foothold to go on from."""
    state, turn = _step(foothold, smoothing)
    if turn > FAR:
        foothold = stand(replace(foothold.problem, smoothing=smoothing), state)
        state, _ = _step(foothold, smoothing)
    return state, foothold


def _step(foothold: Foothold, smoothing: FloatArray) -> tuple[State, float]:
    """The state after one step, and by how much at most, radians, it turns a strip about."""
    problem = foothold.problem
    grid, p = problem.grid, len(smoothing)
    more = prior(grid, problem.times * (smoothing - problem.smoothing))
    m = more.shape[1]
    rates = foothold.state.shape.rates.reshape(p, -1)
    matrix, gradient = BlockMatrix(foothold.matrix.sizes), list(foothold.gradient)
    matrix.blocks = dict(foothold.matrix.blocks)
    for k in (int(k) for k in np.flatnonzero(smoothing != problem.smoothing)):
        matrix.blocks[k, k] = matrix.blocks[k, k].copy()
        matrix.blocks[k, k][:m, :m] += more[k]
        gradient[k] = gradient[k].copy()
        gradient[k][3:m] += more[k, 3:, 3:] @ rates[k]
    step = factorise(matrix).solve([-part for part in gradient])
    return moved(problem, foothold.state, step), _turn(problem, step)


def _turn(problem: JointProblem, step: list[FloatArray]) -> float:
    """Radians: the greatest turn of any node that a step makes, along the ribbon's own axes."""
    passes = np.array(step[:-1])
    k = problem.grid.coefficients
    rates = passes[:, 3 : 3 + 2 * k].reshape(len(passes), 2, k)
    along = np.cumsum((rates @ problem.grid.mean.T) * problem.grid.steps, axis=2)
    start = np.abs(passes[:, :3]).max(axis=1)
    return float((start + np.abs(along).max(axis=(1, 2))).max())
