"""Whether Coons patches where ties close cells are nearer to the truth than strips alone.

Five passes and two or three ties on many surfaces, at the usual spacing and at
twice that: once through the true curves and once through the whole chain from the
sensors (starts and ends marked).  rms (by area) and greatest distance of the
mesh from the true surface, and the rms angle of its normals.

    .venv/bin/python benchmarks/cells.py [--seeds N] [--surfaces A B] [--each]
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from support.captures import SURFACES, marked, ribbon
from support.parallel import in_parallel
from support.tables import publish, table

from georibbon.errors import GeoribbonError
from georibbon.geometry.closest import closest_point
from georibbon.geometry.frames import arc_angles
from georibbon.geometry.mesh import Mesh, facets
from georibbon.geometry.reference import ReferenceSurface
from georibbon.geometry.surface import Surface, SurfaceSettings, build_surface
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.simulation import SimulationSettings, simulate

WAYS = {"strips": SurfaceSettings(), "cells": SurfaceSettings(cells=True)}
FIGURES = ("rms, mm", "max, mm", "normals, °")
WIDE = 0.16  # m
Case = tuple[SimulationSettings, bool]


@dataclass(frozen=True)
class Result:
    """figures: (ways, 3); cells: how many were closed, of four for two ties, eight for three."""

    figures: np.ndarray
    cells: int
    note: str = ""


def captures(
    surfaces: Sequence[str], seeds: int, ties: int, wide: bool
) -> list[SimulationSettings]:
    """The captures of one row of the table."""
    found = []
    for k, surface in enumerate(surfaces):
        for seed in range(1, seeds + 1):
            one = marked(surface, seed, ribbon(k + seed))
            spacing = WIDE if wide else one.layout.spacing
            found.append(replace(one, layout=replace(one.layout, ties=ties, spacing=spacing)))
    return found


def measure(case: Case) -> Result:
    """One capture, strips alone and with cells."""
    settings, exact = case
    try:
        simulation = simulate(settings)
        truth = simulation.truth
        if exact:
            built = [through(truth.strips, chosen) for chosen in WAYS.values()]
        else:
            built = [
                reconstruct(simulation.recording, ReconstructionSettings(surface=chosen)).surface
                for chosen in WAYS.values()
            ]
    except GeoribbonError as error:
        return Result(np.full((len(WAYS), len(FIGURES)), np.nan), 0, str(error))
    figures = np.array([errors(one.mesh, truth.shape) for one in built])
    found = [check for check in built[1].checks if check.code == "cells"]
    note = "; ".join(check.message for check in found if check.verdict != "pass")
    return Result(figures, int(sum(check.value for check in found)), note)


def through(strips: dict, chosen: SurfaceSettings) -> Surface:
    """The surface through the true curves."""
    passes = [name for name in strips if name.startswith("P")]
    ties = [(name, strip) for name, strip in strips.items() if name.startswith("T")]
    return build_surface([strips[name] for name in passes], passes, chosen, ties=ties)


def errors(mesh: Mesh, shape: ReferenceSurface) -> tuple[float, float, float]:
    """rms by area and greatest distance, mm, and rms of the normals' angles, degrees."""
    near = closest_point(shape, mesh.vertices)
    area = np.linalg.norm(facets(mesh), axis=1)
    weight = np.bincount(mesh.triangles.ravel(), np.repeat(area, 3), minlength=len(mesh.vertices))
    angles = np.degrees(arc_angles(shape.normals(near.uv), mesh.normals))
    angles = np.minimum(angles, 180.0 - angles)
    rms, turned = (np.sqrt(np.average(of**2, weights=weight)) for of in (near.distance, angles))
    return 1e3 * float(rms), 1e3 * float(np.abs(near.distance).max()), float(turned)


def rows_of(name: str, results: Sequence[Result]) -> list[list[str]]:
    """One kind's rows: the mean of each figure both ways, the ratio, where cells are better."""
    figures = np.stack([one.figures for one in results])
    figures = figures[np.isfinite(figures).all(axis=(1, 2))]
    rows = []
    for k, figure in enumerate(FIGURES):
        strips, cells = figures[:, 0, k], figures[:, 1, k]
        ratio = np.exp(np.mean(np.log((cells + 1e-4) / (strips + 1e-4))))
        better = f"{np.count_nonzero(cells < strips - 1e-4)} / {len(cells)}"
        worse = f"{np.count_nonzero(cells > strips + 1e-4)} / {len(cells)}"
        both = f"{strips.mean():.4f}", f"{cells.mean():.4f}"
        rows.append([name, figure, *both, f"{ratio:.2f}", better, worse])
    return rows


def options() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=int, default=2, help="seeds for each surface")
    parser.add_argument("--surfaces", nargs="+", default=list(SURFACES))
    parser.add_argument("--each", action="store_true", help="a row for every capture too")
    return parser.parse_args()


def main() -> None:
    """Measure, and print the table."""
    asked = options()
    rows, single = [], []
    for exact in (True, False):
        for ties in (2, 3):
            for wide in (False, True):
                chosen = captures(asked.surfaces, 1 if exact else asked.seeds, ties, wide)
                results = in_parallel(measure, [(one, exact) for one in chosen])
                what = "true curves" if exact else "from sensors"
                name = f"{what}, {ties} ties, {'wide' if wide else 'usual'} spacing"
                rows += rows_of(name, results)
                single += [
                    [name, f"{one.surface}, seed {one.seed}", str(result.cells)]
                    + [f"{value:.4f}" for value in result.figures.T.ravel()]
                    + [result.note]
                    for one, result in zip(chosen, results, strict=True)
                ]
    header = ("curves", "figure", "strips", "cells", "ratio", "better", "worse")
    parts = [
        f"Coons patches where ties close cells, on {len(asked.surfaces)} surfaces; means over "
        "captures, ratio: geometric mean of cells over strips (each plus 0.1 µm or 0.0001°), "
        "better and worse: captures that change by more than that.",
        table(header, rows),
    ]
    if asked.each:
        names = [f"{figure} {way}" for figure in FIGURES for way in WAYS]
        parts.append(table(("curves", "capture", "cells", *names, "notes"), single))
    publish("cells", parts)


if __name__ == "__main__":
    main()
