"""Whether the predicted standard deviations are those that are found.

Over many seeds, the rms of (error / predicted sigma) of the curves' points,
each component in the workpiece frame; 1 is honest, less is too careful, more
too sure.  Starts and ends are marked, the calibration is included.

    .venv/bin/python benchmarks/honesty.py [--seeds N] [--surfaces A B] [--sensors N] [--alone]
"""

import argparse

import numpy as np
from support.captures import marked
from support.parallel import in_parallel
from support.tables import met, publish, table

from georibbon.reconstruction import FittedPass, ReconstructionSettings, reconstruct
from georibbon.simulation import RibbonSettings, SimulationSettings, Truth, simulate

SURFACES = ("bonnet", "sphere", "saddle", "hull", "elbow")
LEAST, MOST = 0.8, 1.25
HEADER = ("surface", "axes", "neighbours", "x", "y", "z", "whole", "normals", "rms error, mm", "")


def ratios(one: FittedPass, truth: Truth) -> np.ndarray:
    """(n, 6): error / sigma of x, y, z, of the whole, of the normal; the error in mm."""
    true = truth.strips[one.name]
    s = one.strip.s
    points, frames = true.points, true.frames
    variances = np.diagonal(one.covariance, axis1=1, axis2=2)
    sigma = np.sqrt([np.interp(true.s, s, column) for column in variances.T]).T
    error = np.stack([np.interp(true.s, s, column) for column in one.strip.points.T], 1) - points
    normals = np.stack([np.interp(true.s, s, column) for column in one.strip.normals.T], 1)
    # The normal's error has two components, each of which normal_sigma is of.
    tilt = np.linalg.norm(np.cross(normals, frames[:, :, 2]), axis=1) / np.sqrt(2)
    length = np.linalg.norm(error, axis=1)
    whole = length / np.linalg.norm(sigma, axis=1)
    turned = tilt / np.interp(true.s, s, one.normal_sigma)
    return np.column_stack([error / sigma, whole, turned, 1e3 * length])


def measure(case: tuple[SimulationSettings, bool]) -> np.ndarray:
    """(6,) mean squares of one capture's ratios."""
    settings, neighbours = case
    simulation = simulate(settings)
    chosen = ReconstructionSettings(neighbours=neighbours, surface=None)
    found = reconstruct(simulation.recording, chosen)
    every = [ratios(one, simulation.truth) for one in found.passes]
    return np.asarray(np.mean(np.concatenate(every) ** 2, axis=0))


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=int, default=50, help="seeds for each row")
    parser.add_argument("--surfaces", nargs="+", default=list(SURFACES))
    parser.add_argument("--sensors", type=int, default=32)
    parser.add_argument("--alone", action="store_true", help="without neighbours as well")
    asked = parser.parse_args()
    kinds = [
        (surface, axes, neighbours)
        for surface in asked.surfaces
        for axes in (2, 3)
        for neighbours in ((True, False) if asked.alone else (True,))
    ]
    cases = [
        (
            marked(
                surface, 1000 + seed, RibbonSettings(sensors=asked.sensors, magnetometer_axes=axes)
            ),
            neighbours,
        )
        for surface, axes, neighbours in kinds
        for seed in range(asked.seeds)
    ]
    squares = np.array(in_parallel(measure, cases)).reshape(len(kinds), asked.seeds, 6)
    rows = []
    for (surface, axes, neighbours), part in zip(kinds, squares, strict=True):
        figures = np.sqrt(part.mean(axis=0))
        fine = bool((figures[:3] >= LEAST).all() and (figures[:3] <= MOST).all())
        cells = [surface, str(axes), "yes" if neighbours else "no"]
        rows.append([*cells, *(f"{value:.2f}" for value in figures), met(fine)])
    head = (
        f"Rms of (error / predicted sigma) over {asked.seeds} seeds, {asked.sensors} sensors; "
        f"asked of x, y and z: {LEAST:g} to {MOST:g}"
    )
    publish("honesty", [head, table(HEADER, rows)])


if __name__ == "__main__":
    main()
