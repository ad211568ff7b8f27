"""A ribbon that lies as a curve of known rates, and what it says there at any moment."""

from dataclasses import dataclass

import numpy as np

from georibbon.calibration.model import Calibration, SensorModel
from georibbon.fitting.grid import Grid, Shape, integrate_frames, integrate_positions, make_grid
from georibbon.fitting.sensing import Noise
from georibbon.ribbon import Ribbon
from georibbon.rotations import exp
from georibbon.simulation.forward import expected_counts
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import noise_counts, true_models, virtual_ribbon
from georibbon.world import field_direction

DIP = np.radians(62.0)


@dataclass(frozen=True, eq=False, repr=False)
class Lying:
    """A calibrated ribbon. sigma: (c,) counts, of a sample."""

    ribbon: Ribbon
    calibration: Calibration
    grid: Grid
    sigma: np.ndarray

    def counts(self, shape: Shape, seed: int | None = None, magnet=None) -> np.ndarray:
        """(c,) what it says lying as a shape: with the contact's noise and an average's, or none.

        magnet: (n, 3) what it adds to the field at each sensor, in the world.
        """
        frames = integrate_frames(self.grid, shape)[0, self.grid.sensor_nodes]
        if seed is not None:
            rng = np.random.default_rng(seed)
            frames = frames @ exp(Noise().contact * rng.standard_normal((len(frames), 3)))
        models = self.calibration.sensors
        said = expected_counts(self.ribbon, models, frames, field_direction(DIP), magnet)
        if seed is not None:
            said = said + self.sigma * rng.standard_normal(len(said))
        return said

    def points(self, shape: Shape) -> np.ndarray:
        """(nodes, 3) of the curve, from its start."""
        return integrate_positions(self.grid, shape, integrate_frames(self.grid, shape))[0]

    def sensors(self, kind: str) -> list[str]:
        """The names of one kind, along the ribbon."""
        return [self.ribbon.sensors[i].name for i in self.ribbon.indices(kind)]


def lying(
    sensors: int = 24, axes: int = 2, seed: int = 4, average: int = 25, **faults: float
) -> Lying:
    """A ribbon with sensors mounted askew, all known to its calibration; readings are averages."""
    settings = RibbonSettings(
        sensors=sensors, length=0.03 * sensors, magnetometer_axes=axes, **faults
    )
    ribbon = virtual_ribbon(settings)
    models: tuple[SensorModel, ...] = true_models(ribbon, settings, np.random.default_rng(seed))
    calibration = Calibration(ribbon.id, DIP, models, mounting_sigma=0.0)
    sigma = noise_counts(ribbon, settings) / np.sqrt(average)
    return Lying(ribbon, calibration, make_grid(ribbon), sigma)


def curve(grid: Grid, start=None, twist: float = 0.4, bend: float = 1.2) -> Shape:
    """A strip that twists and bends gently, from an attitude (3,) given as a rotation vector."""
    s = grid.nodes / grid.nodes[-1]
    values = np.stack([twist * np.sin(5.0 * s - 0.5), bend * (0.7 + 0.5 * np.cos(4.0 * s))])
    rates = np.linalg.lstsq(grid.at_nodes, values.T, rcond=None)[0].T
    attitude = exp(np.zeros(3) if start is None else np.asarray(start, dtype=float))
    return Shape(attitude[None], rates[None])
