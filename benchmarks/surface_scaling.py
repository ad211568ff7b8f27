"""How the time and the memory of a surface grow with its curves and with their points.

From 5 to 500 curves of 100 points, and five curves of 100 to 10,000 points each,
on a barrel whose passes are shifted against each other; the whole surface as
`build_surface` makes it, with its checks, in stages.  Each slope is that of log
time against log number over the last two steps: 1 is linear growth, 2 quadratic.
Times are of the processor (one thread); memory is what arrays took at most beside
what was there, told by tracemalloc in a run of its own.

    .venv/bin/python benchmarks/surface_scaling.py [--curves 5 20 …] [--points 100 300 …]
"""

import argparse
import os
import time
import tracemalloc
from collections.abc import Sequence

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from support.tables import met, publish, table

from georibbon.geometry.checks import all_checks
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import Strip, frames_from
from georibbon.geometry.mesh import area
from georibbon.geometry.patch import lines_at, natural_parameters, patches_at, patches_between
from georibbon.geometry.surface import (
    SurfaceSettings,
    build_surface,
    grid_of,
    subdivided,
    triangulated,
)

CURVES = (5, 20, 50, 100, 200, 500)
POINTS = (100, 300, 1000, 3000, 10_000)
FEW_CURVES, FEW_POINTS = 5, 100
STEEPEST = 1.25
GAP, LENGTH = 0.08, 0.8  # m
STAGES = ("order", "match", "patches", "cuts", "mesh", "checks", "whole")


def barrel(curves: int, points: int) -> list[Strip]:
    """Meridian sections of a cylinder about the y axis, 0.5 m in radius, side by side."""
    strips = []
    for k in range(curves):
        s = np.linspace(0.0, LENGTH, points)
        angle = (s - 0.5 * LENGTH + 0.02 * np.sin(1.7 * k)) / 0.5
        zero = np.zeros_like(s)
        normals = np.stack([np.sin(angle), zero, np.cos(angle)], axis=1)
        tangents = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
        places = 0.5 * normals + np.array([0.0, GAP * k, 0.0])
        strips.append(Strip(s, places, frames_from(tangents, normals)))
    return strips


def stage_times(curves: int, points: int) -> dict[str, float]:
    """Processor seconds of the stages of one surface, and of the whole."""
    strips, settings = barrel(curves, points), SurfaceSettings()
    names = [f"P{k + 1}" for k in range(curves)]
    marks = [time.process_time()]

    def mark() -> None:
        marks.append(time.process_time())

    arrangement = arrange(strips)
    mark()
    model = patches_between(arrangement, settings)
    mark()
    u = natural_parameters(model)
    sample = patches_at(model, u)
    grid = grid_of(sample)
    mark()
    nodes, counts = subdivided(sample, grid, u, settings.tolerance)
    mark()
    area(triangulated(lines_at(model, nodes), counts, None, True))
    mark()
    all_checks(model, names, sample, grid, None)
    mark()
    build_surface(strips, names, settings)
    mark()
    return dict(zip(STAGES, np.diff(marks).tolist(), strict=True))


def most_memory(curves: int, points: int) -> float:
    """MB that arrays take at most while a surface is built."""
    strips, names = barrel(curves, points), [f"P{k + 1}" for k in range(curves)]
    tracemalloc.start()
    build_surface(strips, names, SurfaceSettings())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return float(peak) / 2**20


def slope(numbers: Sequence[int], values: Sequence[float]) -> float:
    """Of log values against log numbers, over the last three."""
    x, y = np.log(numbers[-3:]), np.log(np.maximum(values[-3:], 1e-4))
    return float(np.polyfit(x, y, 1)[0])


def growth(what: str, numbers: Sequence[int], sizes: Sequence[tuple[int, int]]) -> str:
    """The table of one growth."""
    found = [stage_times(*size) for size in sizes]
    memory = [most_memory(*size) for size in sizes]
    rows = [
        [str(number), *(f"{1e3 * one[stage]:.0f}" for stage in STAGES), f"{used:.0f}"]
        for number, one, used in zip(numbers, found, memory, strict=True)
    ]
    slopes = [slope(numbers, [one[stage] for one in found]) for stage in STAGES]
    slopes.append(slope(numbers, memory))
    rows.append(["slope", *(f"{value:.2f}" for value in slopes)])
    whole, used = slopes[-2], slopes[-1]
    verdict = (
        f"Asked: the whole and the memory grow at most with the power {STEEPEST:g}: "
        f"{met(max(whole, used) <= STEEPEST)}."
    )
    return f"{table([what, *STAGES, 'MB'], rows)}\n\n{verdict}"


def main() -> None:
    """Measure, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--curves", type=int, nargs="+", default=list(CURVES))
    parser.add_argument("--points", type=int, nargs="+", default=list(POINTS))
    asked = parser.parse_args()
    stage_times(FEW_CURVES, FEW_POINTS)  # loads and warms everything
    publish(
        "surface_scaling",
        [
            f"Milliseconds of the processor; {FEW_POINTS} points a curve.",
            growth("curves", asked.curves, [(one, FEW_POINTS) for one in asked.curves]),
            f"Milliseconds of the processor; {FEW_CURVES} curves.",
            growth("points a curve", asked.points, [(FEW_CURVES, one) for one in asked.points]),
        ],
    )


if __name__ == "__main__":
    main()
