"""The joint adjustment followed while a smoothing moves.

At the minimum for one smoothing the normal matrix H and the gradient g are
known.  Another smoothing of some passes adds to both: with P the roughness of
a strip and r its rates, D = dw P and D r.  One step -(H + D)^-1 (g + D r) then
leads to the new minimum as nearly as the readings, linear in a strip that moves
by little, allow.  A step that turns a strip by much is taken, and the equations
are made anew where it leads to.

For few passes the columns Z of the inverse of H that are theirs are held, and
(Woodbury's identity)

    (H + D)^-1 x = y - Z (I + D Z_kk)^-1 D y_k,     y = H^-1 x

with k the rows of these passes; for many H + D is factorised.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from georibbon.arrays import FloatArray
from georibbon.fitting.blocks import BlockFactor, BlockMatrix, factorise
from georibbon.fitting.joint import JointProblem, State, equations, moved
from georibbon.fitting.strip import prior

FAR = float(np.radians(1.0))  # a turn beyond which the equations are made anew
LOST = 1.0  # radians: what still turns by so much with fresh equations is nowhere near
DAMPING = 1e-9  # of the diagonal: a roughness beyond all readings leaves it no digits to spare
FEW = 3  # passes of which columns are held: beyond, the factor is sooner made anew


@dataclass(frozen=True, eq=False)
class Foothold:
    """The equations of a joint problem at a state near its minimum.

    held: columns of the inverse, block by block, by the pass that they are of,
    added to as they are asked for.
    """

    problem: JointProblem
    state: State
    matrix: BlockMatrix
    gradient: list[FloatArray]
    held: dict[int, list[FloatArray]] = field(default_factory=dict)

    @cached_property
    def factor(self) -> BlockFactor:
        """The factor of the normal matrix."""
        return factorise(self.matrix.damped(DAMPING))

    @cached_property
    def step(self) -> list[FloatArray]:
        """The step that is left with the smoothing as it is."""
        return self.factor.solve([-part for part in self.gradient])

    def columns(self, k: int) -> list[FloatArray]:
        """The columns of the inverse of the normal matrix that are pass k's."""
        if k not in self.held:
            size = self.matrix.sizes[k]
            right = [np.zeros((rows, size)) for rows in self.matrix.sizes]
            right[k] = np.eye(size)
            self.held[k] = self.factor.solve(right)
        return self.held[k]


def stand(problem: JointProblem, state: State) -> Foothold:
    """The foothold at a state."""
    matrix, gradient = equations(problem, state)
    return Foothold(problem, state, matrix, gradient)


def follow(foothold: Foothold, smoothing: FloatArray) -> tuple[State, Foothold]:
    """The state for another smoothing (p,), and the foothold to go on from.

    Raises `numpy.linalg.LinAlgError` where the way is too far for that.
    """
    state, turn = _step(foothold, smoothing)
    if turn > FAR:
        foothold = stand(replace(foothold.problem, smoothing=smoothing), state)
        state, turn = _step(foothold, smoothing)
    if not turn < LOST:  # NaN is lost too
        raise np.linalg.LinAlgError(f"a step turns a strip about by {turn:.1f} radians")
    return state, foothold


def _step(foothold: Foothold, smoothing: FloatArray) -> tuple[State, float]:
    """The state after one step, and by how much at most, radians, it turns a strip about.

    A start point that moves by the ribbon's length counts as a radian.
    """
    problem = foothold.problem
    changed = [int(k) for k in np.flatnonzero(smoothing != problem.smoothing)]
    more = prior(problem.grid, problem.times * (smoothing - problem.smoothing))
    added = {k: np.pad(more[k], (0, 3)) for k in changed}  # start points have no roughness
    pulled = {k: added[k] @ _unknowns(foothold, k) for k in changed}
    way = _by_columns if len(changed) <= FEW else _by_factor
    step = way(foothold, added, pulled)
    return moved(problem, foothold.state, step), _turn(problem, step)


def _unknowns(foothold: Foothold, k: int) -> FloatArray:
    """A pass's unknowns as the roughness sees them: its rates, and nothing else."""
    out = np.zeros(foothold.matrix.sizes[k])
    out[3:-3] = foothold.state.shape.rates[k].ravel()
    return out


def _by_columns(
    foothold: Foothold, added: dict[int, FloatArray], pulled: dict[int, FloatArray]
) -> list[FloatArray]:
    """The step, by the columns of the inverse that are held."""
    if not added:
        return foothold.step
    held = [foothold.columns(k) for k in added]
    columns = [np.concatenate(parts, axis=1) for parts in zip(*held, strict=True)]
    pull = np.concatenate(list(pulled.values()))
    step = [one - part @ pull for one, part in zip(foothold.step, columns, strict=True)]
    among = np.concatenate([columns[k] for k in added])
    weight = block_diag(*added.values())
    own = np.concatenate([step[k] for k in added])
    back = np.linalg.solve(np.eye(len(own)) + weight @ among, weight @ own)
    return [one - part @ back for one, part in zip(step, columns, strict=True)]


def _by_factor(
    foothold: Foothold, added: dict[int, FloatArray], pulled: dict[int, FloatArray]
) -> list[FloatArray]:
    """The step, by factorising the matrix with what is added."""
    matrix = BlockMatrix(foothold.matrix.sizes)
    matrix.blocks = dict(foothold.matrix.blocks)
    right = [-part for part in foothold.gradient]
    for k, block in added.items():
        matrix.blocks[k, k] = matrix.blocks[k, k] + block
        right[k] = right[k] - pulled[k]
    return factorise(matrix.damped(DAMPING)).solve(right)


def _turn(problem: JointProblem, step: list[FloatArray]) -> float:
    """Radians: the greatest turn of any node that a step makes, along the ribbon's own axes."""
    passes = np.array(step[:-1])
    k = problem.grid.coefficients
    rates = passes[:, 3 : 3 + 2 * k].reshape(len(passes), 2, k)
    along = np.cumsum((rates @ problem.grid.mean.T) * problem.grid.steps, axis=2)
    start = np.abs(passes[:, :3]).max(axis=1)
    shift = np.abs(passes[:, -3:]).max(axis=1) / problem.grid.nodes[-1]
    return float((start + shift + np.abs(along).max(axis=(1, 2))).max())
