"""Ribbons laid as curves of known rates, and what their sensors then say."""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.calibration.model import Calibration, SensorModel
from georibbon.fitting.grid import (
    Grid,
    Shape,
    differentiate_frames,
    differentiate_positions,
    integrate_frames,
    integrate_positions,
    make_grid,
)
from georibbon.fitting.sensing import Noise, SensorArray, observe
from georibbon.fitting.strip import StripProblem, sensed_vectors
from georibbon.fitting.survey import Placed
from georibbon.recording import Mark, Pass, Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.rotations import exp
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import true_models, virtual_ribbon
from georibbon.world import field_direction

DIP = np.radians(62.0)
FLAT = np.eye(3)


def ribbon(sensors: int = 16, axes: int = 2, pitch: float = 0.03) -> Ribbon:
    """Accelerometers and magnetometers by turns."""
    length = round(sensors * pitch, 6)
    return virtual_ribbon(RibbonSettings(sensors=sensors, length=length, magnetometer_axes=axes))


def calibration(of: Ribbon, seed: int | None = None, **fields: float) -> Calibration:
    """Exact: plain gains, or, with a seed, those of sensors mounted askew with biases."""
    models = tuple(
        SensorModel(
            sensor.name,
            sensor.counts_per_unit * np.eye(3)[: sensor.axes],
            np.zeros(sensor.axes),
        )
        for sensor in of.sensors
    )
    if seed is not None:
        models = true_models(of, RibbonSettings(), np.random.default_rng(seed))
    return Calibration(of.id, DIP, models, **fields)


def shape_of(grid: Grid, start: np.ndarray, twist, bend) -> Shape:
    """The strip of one pass whose rates come nearest to the functions of s, rad/m."""
    values = np.stack([np.broadcast_to(f(grid.nodes), grid.nodes.shape) for f in (twist, bend)])
    rates = np.linalg.lstsq(grid.at_nodes, values.T, rcond=None)[0].T
    return Shape(np.asarray(start)[None], rates[None])


def constant(value: float):
    """A rate that is the same everywhere."""
    return lambda s: np.full_like(s, value)


def wavy(grid: Grid, start: np.ndarray = FLAT, scale: float = 1.0) -> Shape:
    """A strip that twists and bends gently, both ways."""
    length = grid.nodes[-1]
    return shape_of(
        grid,
        start,
        lambda s: scale * (0.4 * np.sin(5.0 * s / length) - 0.2),
        lambda s: scale * (0.9 + 0.7 * np.cos(4.0 * s / length)),
    )


def random_shape(grid: Grid, rng: np.random.Generator, count: int = 1) -> Shape:
    """Strips with any attitude and lively rates."""
    start = exp(rng.uniform(-1.5, 1.5, (count, 3)))
    return Shape(start, rng.normal(0.0, 1.0, (count, 2, grid.coefficients)))


def both(*shapes: Shape) -> Shape:
    """Several strips as one stack."""
    return Shape(
        np.concatenate([shape.start for shape in shapes]),
        np.concatenate([shape.rates for shape in shapes]),
    )


def frames_at_sensors(grid: Grid, shape: Shape) -> np.ndarray:
    """(b, n, 3, 3)."""
    return integrate_frames(grid, shape)[:, grid.sensor_nodes]


def counts(
    of: Ribbon, models: tuple[SensorModel, ...], frames: np.ndarray, field: np.ndarray
) -> np.ndarray:
    """(b, c) what the sensors would say without any noise; frames (b, n, 3, 3)."""
    parts = []
    for i, (sensor, model) in enumerate(zip(of.sensors, models, strict=True)):
        vector = field if sensor.kind == "magnetometer" else np.array([0.0, 0.0, 1.0])
        parts.append((vector @ frames[:, i]) @ model.gain.T + model.bias)
    return np.concatenate(parts, axis=1)


@dataclass(frozen=True, eq=False)
class Laid:
    """Passes that were laid: their true shape and the problem of finding it again."""

    ribbon: Ribbon
    calibration: Calibration
    grid: Grid
    shape: Shape
    problem: StripProblem


def lay(
    of: Ribbon,
    shape: Shape,
    *,
    seed: int | None = None,
    skew_seed: int | None = None,
    noise: Noise | None = None,
    heading: float = 0.0,
) -> Laid:
    """The passes with noise drawn as `Noise` says, or with none (seed None)."""
    noise = noise or Noise()
    calibrated = calibration(of, skew_seed)
    grid, array = make_grid(of), SensorArray.of(of, calibrated)
    frames = frames_at_sensors(grid, shape)
    rng = np.random.default_rng(seed)
    if seed is not None:
        frames = frames @ exp(noise.contact * rng.standard_normal((*frames.shape[:2], 3)))
    field = field_direction(DIP, heading)
    means = counts(of, calibrated.sensors, frames, field)
    if seed is not None:
        floor = [
            np.full(s.axes, (noise.field if s.kind == "magnetometer" else noise.acceleration))
            for s in of.sensors
        ]
        scale = [np.full(s.axes, array.scale[i]) for i, s in enumerate(of.sensors)]
        means = means + np.concatenate(floor) * np.concatenate(scale) * rng.standard_normal(
            means.shape
        )
    observed = observe(of, array, means, np.zeros_like(means))
    vectors = sensed_vectors(array, field)
    return Laid(of, calibrated, grid, shape, StripProblem(grid, array, observed, vectors, noise))


def without(laid: Laid, *names: str) -> Laid:
    """The same passes with some sensors saying nothing."""
    present = laid.problem.observations.present.copy()
    for i, sensor in enumerate(laid.ribbon.sensors):
        if sensor.name in names:
            present[:, i] = False
    observed = replace(laid.problem.observations, present=present)
    return replace(laid, problem=replace(laid.problem, observations=observed))


def placed(grid: Grid, shape: Shape, origin: np.ndarray) -> Placed:
    """The passes with their start points (b, 3), without derivatives."""
    frames = integrate_frames(grid, shape)
    points = integrate_positions(grid, shape, frames) + origin[:, None]
    empty = np.zeros((*points.shape, 0))
    return Placed(grid, points, frames, empty, empty)


def degrees_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(...) degrees between rotations (..., 3, 3), by the Frobenius norm of their difference."""
    chord = np.sqrt(np.sum((one - other) ** 2, axis=(-2, -1)))
    return np.degrees(2 * np.arcsin(np.clip(chord / np.sqrt(8.0), 0.0, 1.0)))


def with_derivatives(grid: Grid, shape: Shape, origin: np.ndarray) -> Placed:
    """The passes with their start points (b, 3) and all derivatives."""
    turns = differentiate_frames(grid, shape)
    points, moves = differentiate_positions(grid, shape, turns)
    return Placed(grid, points + origin[:, None], turns.frames, moves, turns.delta)


def plane(grid: Grid, offsets: tuple[float, ...]) -> tuple[Shape, np.ndarray]:
    """Straight passes along x on the level plane at these y, and their start points."""
    count = len(offsets)
    shape = Shape(np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 2, grid.coefficients)))
    return shape, np.array([[0.0, y, 0.0] for y in offsets])


def sphere(grid: Grid, radius: float, offsets: tuple[float, ...]) -> tuple[Shape, np.ndarray]:
    """Great circles over the top of a sphere, `offsets` metres apart in their middles."""
    half = 0.5 * grid.nodes[-1] / radius
    back = exp(np.array([0.0, -half, 0.0]))
    tilts = exp(np.array([[-offset / radius, 0.0, 0.0] for offset in offsets]))
    start = tilts @ back
    rates = np.zeros((len(offsets), 2, grid.coefficients))
    rates[:, 1] = 1 / radius
    return Shape(start, rates), radius * start[:, :, 2]


def recording(
    of: Ribbon,
    shape: Shape,
    *,
    names: tuple[str, ...] | None = None,
    seed: int | None = None,
    heading: float = 0.0,
    frames: int = 12,
    models: tuple[SensorModel, ...] | None = None,
    **survey: object,
) -> Recording:
    """Passes (ties where the name begins with T) as they would be recorded, with their survey.

    heading: radians, of the workpiece; the strips are in the workpiece's axes.
    """
    grid = make_grid(of)
    names = names or tuple(f"P{k + 1}" for k in range(len(shape.start)))
    models = models or calibration(of).sensors
    rng = np.random.default_rng(seed)
    there = frames_at_sensors(grid, shape)
    if seed is not None:
        there = there @ exp(Noise().contact * rng.standard_normal((*there.shape[:2], 3)))
    said = counts(of, models, there, field_direction(DIP, heading))
    t = np.arange(frames) / of.rate
    passes = tuple(
        Pass(
            name,
            "tie" if name.startswith("T") else "pass",
            Readings(t, one + 6.0 * rng.standard_normal((frames, len(one)))),
        )
        for name, one in zip(names, said, strict=True)
    )
    return Recording(of, (), passes, **survey)


def points_of(grid: Grid, shape: Shape, origin: np.ndarray) -> np.ndarray:
    """(b, n + 1, 3) the points at the nodes."""
    return placed(grid, shape, origin).points


def marked(
    grid: Grid, points: np.ndarray, ends: tuple[int, ...] = (0, -1), sigma: float = 5e-4
) -> tuple[Mark, ...]:
    """Exact marks of every pass P1, P2, … at some nodes."""
    return tuple(
        Mark(f"P{k + 1}", float(grid.nodes[end]), tuple(float(x) for x in one[end]), sigma)
        for k, one in enumerate(points)
        for end in ends
    )
