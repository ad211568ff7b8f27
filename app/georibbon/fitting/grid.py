"""The ribbon as a discrete curve: steps along it, splines for its rates, frames and positions.

A ribbon cannot bend in its own plane, so its frame R = [tau, V, N] obeys
R' = R [w]x with w = (twist rate, bending rate, 0) (Sprynski et al. 2008,
propositions 1 to 3).  The two rates are cubic B-splines of the arc length;
frames are products of exponentials over short steps, each of the rate's mean
over the step, and positions follow by Simpson's rule on the tangents.

Everything is done for a stack of b passes of one ribbon at once.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from georibbon.arrays import FloatArray, IntArray
from georibbon.ribbon import Ribbon
from georibbon.rotations import exp, exp_and_jacobian, skew

LONGEST_STEP = 0.015  # m; the frames' discretisation error is then below 0.01 degrees
SENSORS_PER_KNOT = 2  # a spline interval for every two sensors: what they can resolve


@dataclass(frozen=True, eq=False)
class Grid:
    """The discretisation that all passes of one ribbon share.

    nodes: (n + 1,) metres, from 0 to the ribbon's length, every sensor's place
    among them.  steps: (n,) metres.  mean, half: (n, k) the k basis functions'
    means over each step and over each step's first half.  at_nodes: (n + 1, k)
    their values.  roughness: (k, k), c^T roughness c = integral of g''².
    sensor_nodes: (sensors,) the node of each sensor.
    """

    nodes: FloatArray
    steps: FloatArray
    mean: FloatArray
    half: FloatArray
    at_nodes: FloatArray
    roughness: FloatArray
    sensor_nodes: IntArray

    @property
    def coefficients(self) -> int:
        """The number of coefficients of each of the two rates."""
        return int(self.mean.shape[1])

    @property
    def unknowns(self) -> int:
        """The number of a strip's unknowns: three of R(0) and the coefficients."""
        return 3 + 2 * self.coefficients


def make_grid(ribbon: Ribbon) -> Grid:
    """The grid for a ribbon: steps of at most 15 mm, knots every two sensors."""
    positions = np.array([sensor.position for sensor in ribbon.sensors])
    nodes = _nodes(positions, ribbon.length)
    basis = _basis(len(np.unique(positions)), ribbon.length)
    left, right = nodes[:-1], nodes[1:]
    middle = 0.5 * (left + right)
    # Simpson's rule is exact for cubics: a mean misses only where a knot falls inside a step.
    quarter = basis(0.5 * (left + middle))
    return Grid(
        nodes=nodes,
        steps=right - left,
        mean=(basis(left) + 4 * basis(middle) + basis(right)) / 6,
        half=(basis(left) + 4 * quarter + basis(middle)) / 6,
        at_nodes=basis(nodes),
        roughness=_roughness(basis),
        sensor_nodes=np.searchsorted(nodes, positions - 1e-9).astype(np.int64),
    )


def _nodes(positions: FloatArray, length: float) -> FloatArray:
    """The sensors' places and both ends, with long gaps divided evenly."""
    fixed = np.unique(np.concatenate([[0.0, length], positions]))
    fixed = fixed[np.concatenate([[True], np.diff(fixed) > 1e-9])]
    fixed[-1] = length
    counts = np.maximum(1, np.ceil(np.diff(fixed) / LONGEST_STEP - 1e-9).astype(int))
    parts = [
        np.linspace(a, b, count, endpoint=False)
        for a, b, count in zip(fixed[:-1], fixed[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, [length]])


def _basis(places: int, length: float) -> BSpline[np.float64]:
    """The cubic B-spline basis with uniform knots, as one spline with k values."""
    intervals = max(3, round(places / SENSORS_PER_KNOT))
    knots = np.concatenate([[0.0] * 3, np.linspace(0, length, intervals + 1), [length] * 3])
    return BSpline(knots, np.eye(intervals + 3), 3)


def _roughness(basis: BSpline[np.float64]) -> FloatArray:
    """The integrals of products of second derivatives, exact by two Gauss points an interval."""
    knots = np.unique(basis.t)
    middle, reach = 0.5 * (knots[1:] + knots[:-1]), 0.5 * np.diff(knots) / np.sqrt(3.0)
    points = np.concatenate([middle - reach, middle + reach])
    weights = np.tile(0.5 * np.diff(knots), 2)
    second = basis.derivative(2)(points)
    return np.asarray(second.T @ (weights[:, None] * second))


@dataclass(frozen=True, eq=False)
class Shape:
    """The unknowns of b strips: start (b, 3, 3) frames at s = 0; rates (b, 2, k) coefficients."""

    start: FloatArray
    rates: FloatArray

    def moved(self, step: FloatArray) -> "Shape":
        """After a step (b, 3 + 2k): R(0) turned by exp([step]x) from the left, rates added to."""
        rates = self.rates + step[:, 3:].reshape(self.rates.shape)
        return Shape(exp(step[:, :3]) @ self.start, rates)

    def take(self, index: IntArray | list[int]) -> "Shape":
        """The strips of the given places in the stack."""
        return Shape(self.start[index], self.rates[index])


def integrate_frames(grid: Grid, shape: Shape) -> FloatArray:
    """Frames at the nodes, (b, n + 1, 3, 3)."""
    return _chain(shape.start, exp(_step_rotations(grid.mean, grid.steps, shape.rates)))


def _step_rotations(basis: FloatArray, lengths: FloatArray, rates: FloatArray) -> FloatArray:
    """(b, n, 3) rotation vectors of the steps in the ribbon's frame; the third is zero."""
    phi = np.zeros((rates.shape[0], basis.shape[0], 3))
    phi[..., :2] = lengths[:, None] * (basis @ np.swapaxes(rates, 1, 2))
    return phi


def _chain(start: FloatArray, steps: FloatArray) -> FloatArray:
    """start, start E0, start E0 E1, …: a prefix product in log2(n) vectorised rounds."""
    product = np.concatenate([start[:, None], steps], axis=1)
    reach = 1
    while reach < product.shape[1]:
        joined = product[:, :-reach] @ product[:, reach:]
        product[:, reach:] = joined
        reach *= 2
    return product


@dataclass(frozen=True, eq=False)
class Turns:
    """Frames at the nodes and how each unknown turns them.

    frames: (b, n + 1, 3, 3).  delta: (b, n + 1, 3, m): for a change x of the
    unknowns the frame turns by exp([delta x]x) from the left, in the world.
    """

    frames: FloatArray
    delta: FloatArray


def differentiate_frames(grid: Grid, shape: Shape) -> Turns:
    """Frames with their exact first derivatives."""
    phi = _step_rotations(grid.mean, grid.steps, shape.rates)
    rotation, jacobian = exp_and_jacobian(phi)
    frames = _chain(shape.start, rotation)
    turned = frames[:, :-1] @ jacobian[..., :2]
    increments = _spread(turned, grid.mean * grid.steps[:, None])
    b, n, _, columns = increments.shape
    delta = np.zeros((b, n + 1, 3, 3 + columns))
    delta[:, :, :, :3] = np.eye(3)
    np.cumsum(increments, axis=1, out=delta[:, 1:, :, 3:])
    return Turns(frames, delta)


def _spread(turned: FloatArray, basis: FloatArray) -> FloatArray:
    """(b, n, 3, 2) by (n, k) to (b, n, 3, 2k)."""
    b, n = turned.shape[:2]
    return (turned[..., None] * basis[:, None, None, :]).reshape(b, n, 3, -1)


def integrate_positions(grid: Grid, shape: Shape, frames: FloatArray) -> FloatArray:
    """Points at the nodes, (b, n + 1, 3) metres, from the origin."""
    middle = frames[:, :-1] @ exp(_step_rotations(grid.half, 0.5 * grid.steps, shape.rates))
    weight = (grid.steps / 6)[:, None]
    step = weight * (frames[:, :-1, :, 0] + 4 * middle[..., 0] + frames[:, 1:, :, 0])
    points = np.zeros((frames.shape[0], frames.shape[1], 3))
    np.cumsum(step, axis=1, out=points[:, 1:])
    return points


def differentiate_positions(
    grid: Grid, shape: Shape, turns: Turns
) -> tuple[FloatArray, FloatArray]:
    """Points (b, n + 1, 3) and their derivatives (b, n + 1, 3, m), from a fixed start."""
    frames, delta = turns.frames, turns.delta
    phi = _step_rotations(grid.half, 0.5 * grid.steps, shape.rates)
    rotation, jacobian = exp_and_jacobian(phi)
    middle = (frames[:, :-1] @ rotation)[..., 0]
    turned = frames[:, :-1] @ jacobian[..., :2]
    at_middle = delta[:, :-1].copy()
    at_middle[..., 3:] += _spread(turned, grid.half * (0.5 * grid.steps)[:, None])
    weight = (grid.steps / 6)[:, None]
    moves = -skew(weight * frames[:, :-1, :, 0]) @ delta[:, :-1]
    moves -= skew(4 * weight * middle) @ at_middle
    moves -= skew(weight * frames[:, 1:, :, 0]) @ delta[:, 1:]
    points = np.zeros((frames.shape[0], frames.shape[1], 3))
    step = weight * (frames[:, :-1, :, 0] + 4 * middle + frames[:, 1:, :, 0])
    np.cumsum(step, axis=1, out=points[:, 1:])
    derivative = np.zeros_like(delta)
    np.cumsum(moves, axis=1, out=derivative[:, 1:])
    return points, derivative
