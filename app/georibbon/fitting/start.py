"""Where to start a strip: headings by dynamic programming, so that no false minimum is taken.

At every magnetometer gravity, interpolated between the accelerometers, fixes
the frame up to its heading.  The misfit of the magnetometer's reading on a ring
of headings, and what a ribbon would have to do between neighbouring sensors
(bend in its own plane: hardly; out of it: mildly), make a chain that is
minimised exactly by dynamic programming over all headings.  Every chain that
is a local minimum at some sensor and not much worse than the best is a start.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Grid, Shape, integrate_frames
from georibbon.fitting.strip import StripProblem
from georibbon.rotations import about_z, log, to_up

HEADINGS = 72
# A reading against its frame: the ring's own coarseness (half a step is 2.5 degrees) and the
# interpolation of gravity; in g and local field.
_READING_SIGMA = 0.06
_READING_CAP = 12.0
# What a ribbon does over 6 cm: in its plane nothing but the ring's coarseness and the sensors'
# noise; out of it some bending and twisting.
_IN_PLANE = np.radians(4.0)
_OUT_OF_PLANE = np.radians(15.0)
_TRANSITION_CAP = 60.0
_REFERENCE_GAP = 0.06
_KEEP_WITHIN = 60.0
_MOST_STARTS = 6
_SAME_CHAIN = np.radians(20.0)


@dataclass(frozen=True, eq=False)
class Starts:
    """Starting shapes of a stack of passes, several for each.

    shape: (k) starts in all.  owner: (k,) the pass each belongs to, ascending;
    a pass's own come best first.
    """

    shape: Shape
    owner: IntArray


def find_starts(problem: StripProblem) -> Starts:
    """All promising starts of every pass, at least one each."""
    chains = _chains(problem)
    owners, starts, rates = [], [], []
    for p in range(len(problem.observations.values)):
        for headings in _distinct_paths(chains, p):
            frames = about_z(headings) @ chains.level[p]
            shape = _shape_through(problem.grid, chains.nodes, frames)
            owners.append(p)
            starts.append(shape.start[0])
            rates.append(shape.rates[0])
    return Starts(Shape(np.array(starts), np.array(rates)), np.array(owners, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class _Chains:
    """The dynamic programme of b passes over k sensor places and h headings.

    nodes: (k,) grid nodes.  level: (b, k, 3, 3) frames at heading zero.
    through: (b, k, h) the cost of the best chain through each heading.
    before, after: (b, k, h) the best predecessor and successor of each.
    """

    nodes: IntArray
    level: FloatArray
    through: FloatArray
    before: IntArray
    after: IntArray


def _chains(problem: StripProblem) -> _Chains:
    array, grid = problem.array, problem.grid
    # One magnetometer a place: of two at one place (left and right edge) one is enough to start.
    magnetometers = np.flatnonzero(array.field & array.used)
    nodes, first = np.unique(grid.sensor_nodes[magnetometers], return_index=True)
    magnetometers = magnetometers[first]
    level = to_up(gravity_at(problem, grid.nodes[nodes]))
    misfit = _misfits(problem, magnetometers, level)
    transition = _transitions(level, np.diff(grid.nodes[nodes]))
    forward, before = _sweep(misfit, transition)
    # Backwards the step from heading b to heading a turns the other way round.
    turned = np.roll(transition[:, ::-1, ::-1], 1, axis=-1)
    backward, after = _sweep(misfit[:, ::-1], turned)
    through = forward + backward[:, ::-1] - misfit
    return _Chains(nodes, level, through, before, after[:, ::-1])


def gravity_at(problem: StripProblem, places: FloatArray) -> FloatArray:
    """(b, k, 3) the up direction in the ribbon's frame, interpolated between accelerometers."""
    array, observations = problem.array, problem.observations
    indices = np.flatnonzero(~array.field)
    indices = indices[np.argsort(problem.grid.sensor_nodes[indices], kind="stable")]
    where = problem.grid.nodes[problem.grid.sensor_nodes[indices]]
    up = (array.inverse[indices] @ observations.values[:, indices, :, None])[..., 0]
    out = np.zeros((len(up), len(places), 3))
    for p in range(len(up)):
        there = observations.present[p, indices]
        for axis in range(3):
            out[p, :, axis] = np.interp(places, where[there], up[p, there, axis])
    return out


def _misfits(
    problem: StripProblem,
    magnetometers: IntArray,
    level: FloatArray,
) -> FloatArray:
    """(b, k, h) the cost of each heading at each magnetometer, none where it is absent."""
    headings = 2 * np.pi * np.arange(HEADINGS) / HEADINGS
    turned = problem.vectors[magnetometers[0]] @ about_z(headings)
    seen = turned @ level
    predicted = seen @ np.swapaxes(problem.array.gain[magnetometers], 1, 2)
    values = problem.observations.values[:, magnetometers, None, :]
    squares = np.sum((predicted - values) ** 2, axis=-1) / _READING_SIGMA**2
    present = problem.observations.present[:, magnetometers, None]
    return np.asarray(np.where(present, np.minimum(squares, _READING_CAP), 0.0))


def _transitions(level: FloatArray, gaps: FloatArray) -> FloatArray:
    """(b, k - 1, h) the cost of a change of heading by each angle of the ring."""
    changes = about_z(2 * np.pi * np.arange(HEADINGS) / HEADINGS)
    relative = np.swapaxes(level[:, :-1, None], -1, -2) @ changes @ level[:, 1:, None]
    phi = log(relative)
    share = np.maximum(gaps, 1e-3) / _REFERENCE_GAP
    spread = np.array([_OUT_OF_PLANE, _OUT_OF_PLANE, _IN_PLANE])
    # In its plane the noise does not shrink with the gap; out of it the bending does.
    scale = spread * np.stack([share, share, np.sqrt(share)], axis=-1).clip(min=0.3)[:, None, :]
    cost: FloatArray = np.sum((phi / scale) ** 2, axis=-1)
    return np.minimum(cost, _TRANSITION_CAP)


def _sweep(misfit: FloatArray, transition: FloatArray) -> tuple[FloatArray, IntArray]:
    """Best chain cost up to each heading at each place, and the heading it came from."""
    _b, k, h = misfit.shape
    ring = (np.arange(h)[:, None] - np.arange(h)[None, :]) % h  # [to, from]
    cost, origin = np.empty_like(misfit), np.zeros(misfit.shape, dtype=np.int64)
    cost[:, 0] = misfit[:, 0]
    for j in range(1, k):
        total = cost[:, j - 1, None, :] + transition[:, j - 1][:, ring]
        origin[:, j] = np.argmin(total, axis=-1)
        best = np.take_along_axis(total, origin[:, j][..., None], axis=-1)[..., 0]
        cost[:, j] = best + misfit[:, j]
    return cost, origin


def _distinct_paths(chains: _Chains, p: int) -> list[FloatArray]:
    """The headings (k,), radians, of the distinct good chains of one pass, best first."""
    through = chains.through[p]
    local = (through <= np.roll(through, 1, axis=1)) & (through < np.roll(through, -1, axis=1))
    local &= through <= through.min() + _KEEP_WITHIN
    if not local.any():  # every heading is as good: readings far off, or an upright field
        local.flat[np.argmin(through)] = True
    places, headings = np.nonzero(local)
    order = np.argsort(through[places, headings], kind="stable")
    kept: list[FloatArray] = []
    for place, heading in zip(places[order], headings[order], strict=True):
        path = _trace(chains, p, int(place), int(heading))
        if all(_apart(path, other) for other in kept):
            kept.append(path)
        if len(kept) == _MOST_STARTS:
            break
    return kept


def _apart(one: FloatArray, other: FloatArray) -> bool:
    """Whether two chains differ somewhere by more than the same-chain angle."""
    difference = np.abs((one - other + np.pi) % (2 * np.pi) - np.pi)
    return bool(difference.max() > _SAME_CHAIN)


def _trace(chains: _Chains, p: int, place: int, heading: int) -> FloatArray:
    """The headings of the best chain through one heading at one place."""
    k = chains.through.shape[1]
    path = np.empty(k, dtype=np.int64)
    path[place] = heading
    for j in range(place, 0, -1):
        path[j - 1] = chains.before[p, j, path[j]]
    for j in range(place, k - 1):
        path[j + 1] = chains.after[p, j, path[j]]
    return 2 * np.pi * path / HEADINGS


def _shape_through(grid: Grid, nodes: IntArray, frames: FloatArray) -> Shape:
    """The strip whose rates fit the turns between the frames (k, 3, 3) at some nodes."""
    gaps = np.diff(grid.nodes[nodes])
    rates = log(np.swapaxes(frames[:-1], 1, 2) @ frames[1:])[:, :2] / gaps[:, None]
    basis = np.array(
        [
            grid.steps[a:b] @ grid.mean[a:b] / (grid.nodes[b] - grid.nodes[a])
            for a, b in itertools.pairwise(nodes)
        ]
    )
    # Enough smoothing to settle what the gaps leave open, as a share of the equations' own size.
    ridge = 1e-3 * np.trace(basis.T @ basis) / np.trace(grid.roughness) * grid.roughness
    ridge = ridge + 1e-9 * np.eye(grid.coefficients)
    coefficients = np.linalg.solve(basis.T @ basis + ridge, basis.T @ rates).T
    free = Shape(np.eye(3)[None], coefficients[None])
    middle = len(nodes) // 2
    reached = integrate_frames(grid, free)[0, nodes[middle]]
    return Shape((frames[middle] @ reached.T)[None], coefficients[None])
