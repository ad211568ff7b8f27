"""What it brings that neighbouring passes correct each other.

The rms error of surface and curves without and with neighbours, by surface and
spacing; starts and ends marked, calibration included, 32 sensors.

    .venv/bin/python benchmarks/neighbours.py [--seeds N] [--surfaces A B] [--spacings …]
"""

import argparse

import numpy as np
from support.captures import SURFACES, spread
from support.parallel import in_parallel
from support.tables import publish, table

from georibbon.errors import SettingsError
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.simulation import SimulationSettings, score, simulate

SPACINGS = (0.05, 0.1, 0.15)
HEADER = (
    *("surface", "spacing, mm", "surface alone, mm", "with neighbours", "share"),
    *("curves alone, mm", "with neighbours"),
)


def measure(settings: SimulationSettings) -> np.ndarray:
    """(2, 2): surface and curves, mm, without and with; NaN where the passes do not fit."""
    try:
        simulation = simulate(settings)
    except SettingsError:
        return np.full((2, 2), np.nan)
    rows = []
    for neighbours in (False, True):
        found = reconstruct(simulation.recording, ReconstructionSettings(neighbours=neighbours))
        scored = score(found, simulation.truth)
        rows.append([scored.surface_rms, scored.curves.all.rms])
    return np.array(rows)


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=int, default=5, help="seeds for each row")
    parser.add_argument("--surfaces", nargs="+", default=list(SURFACES))
    parser.add_argument("--spacings", nargs="+", type=float, default=list(SPACINGS), help="metres")
    asked = parser.parse_args()
    kinds = [(surface, spacing) for surface in asked.surfaces for spacing in asked.spacings]
    cases = [
        spread(surface, 100 + seed, spacing)
        for surface, spacing in kinds
        for seed in range(asked.seeds)
    ]
    found = np.array(in_parallel(measure, cases)).reshape(len(kinds), asked.seeds, 2, 2)
    rows = []
    for (surface, spacing), each in zip(kinds, found, strict=True):
        if np.isnan(each).any():
            continue
        (surface_alone, alone), (surface_with, together) = np.sqrt(np.mean(each**2, axis=0))
        cells = [surface, f"{1e3 * spacing:g}", f"{surface_alone:.2f}", f"{surface_with:.2f}"]
        rows.append([*cells, f"{surface_with / surface_alone:.2f}"])
        rows[-1] += [f"{alone:.2f}", f"{together:.2f}"]
    head = (
        f"Rms errors over {asked.seeds} seeds without and with neighbours; combinations whose "
        "passes run off the surface are left out."
    )
    publish("neighbours", [head, table(HEADER, rows)])


if __name__ == "__main__":
    main()
