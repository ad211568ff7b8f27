"""Patches, normals and mesh of five passes, as a ratio to the one product that evaluates them.

The product is np.matmul of the Hermite functions (33, 4) with the control of four
patches (4, 200, 4, 3): the points alone, 4 x 33 x 200 of them.  Both are timed in
turns in one run, so that a busy machine slows both; the least of many is compared,
for it is what the work takes when nothing else is in the way, and the medians stand
beside it.

Given are the passes at common parameters with their derivatives along them.  From
there all is made that a surface's mesh needs: chords, directions across, tangent
lengths, control, and these differentiated; points, both partial derivatives and
unit normals; vertices in a row, and two triangles for every cell, cut along its
shorter diagonal.  A surface that its checks have found far from folding is not
searched for folds again.  The passes themselves, from their splines and what was
matched, are timed beside it.

    .venv/bin/python benchmarks/evaluation.py [--repeats N]
"""

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from support.tables import met, publish, table

from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import Strip
from georibbon.geometry.geodesics import directions_at, geodesics
from georibbon.geometry.mesh import Mesh, area, grid_mesh
from georibbon.geometry.patch import (
    Lines,
    PatchSet,
    basis,
    lines_at,
    patch_grid,
    patches_at,
    patches_between,
)
from georibbon.geometry.rails import sampled_moving
from georibbon.geometry.reference import Torus
from georibbon.geometry.slopes import control_with_slope
from georibbon.geometry.vertices import vertices_of

ROWS, COLUMNS, PASSES = 200, 33, 5
MOST_RATIO = 10.0
GREATEST_ARRAY = 24 << 20  # bytes; memory of arrays up to the greatest let go of is kept at hand

Step = Callable[[], object]


def passes() -> list[Strip]:
    """Five geodesics on a torus, 33 to 89 mm apart, 0.9 m long."""
    torus = Torus(0.5, 0.2, True)
    places = 0.448 * (np.arange(PASSES) - 2.0)
    uv = np.stack([np.zeros(PASSES), places], axis=1)
    s = np.linspace(-0.45, 0.45, 121)
    found = geodesics(torus, uv, directions_at(torus, uv, np.zeros(PASSES)), s)
    return [Strip(one.s - one.s[0], one.points, one.frames) for one in found]


def timed_in_turns(steps: dict[str, Step], repeats: int) -> dict[str, np.ndarray]:
    """Microseconds of every run (repeats,) of each step, one after the other in turns."""
    times: dict[str, list[float]] = {name: [] for name in steps}
    for _ in range(repeats):
        for name, step in steps.items():
            begin = time.perf_counter()
            step()
            times[name].append(1e6 * (time.perf_counter() - begin))
    return {name: np.array(values) for name, values in times.items()}


def steps_of(model: PatchSet) -> dict[str, Step]:
    """What is timed; the product first, then the whole, then its parts and what is not in it."""
    first, last = model.match.ends[model.match.middle]
    u, counts = np.linspace(first, last, ROWS), np.full(PASSES - 1, COLUMNS - 1)
    v = np.linspace(0.0, 1.0, COLUMNS)
    rails, rates = sampled_moving(model.splines, *model.match.with_rates(u))
    lines = lines_at(model, u)
    functions, control = basis(v), np.ascontiguousarray(lines.control)
    normals = rails.frames[..., 2]
    points, facing = vertices_of(lines, counts, True)

    def whole() -> Mesh:
        made = control_with_slope(rails, rates, model.scheme, u)
        return grid_mesh(*vertices_of(Lines(rails, *made), counts, True))

    def named() -> np.ndarray:
        made = patch_grid(control, lines.slope, (normals[:-1], normals[1:]), v)
        return made.normals

    mesh = whole()
    return {
        "the product": lambda: np.matmul(functions, control),
        "patches, normals and mesh": whole,
        "of it: control and its derivative": lambda: control_with_slope(
            rails, rates, model.scheme, u
        ),
        "of it: points, derivatives, normals": lambda: vertices_of(lines, counts, True),
        "of it: mesh": lambda: grid_mesh(points, facing),
        "beside it: passes from splines": lambda: sampled_moving(
            model.splines, *model.match.with_rates(u)
        ),
        "beside it: with a search for folds": lambda: vertices_of(lines, counts),
        "beside it: grid for checks": named,
        "beside it: second derivatives too": lambda: patches_at(model, u),
        "beside it: area": lambda: area(mesh),
    }


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--repeats", type=int, default=600, help="runs of every step")
    asked = parser.parse_args()
    # Memory let go of is kept for the next array from here on, as in a program that has run a while
    np.ones(GREATEST_ARRAY // 8)
    steps = steps_of(patches_between(arrange(passes())))
    timed_in_turns(steps, 3)
    pair = dict(list(steps.items())[:2])
    rest = dict(list(steps.items())[2:])
    times = timed_in_turns(pair, asked.repeats)
    for name, step in rest.items():
        times |= timed_in_turns({name: step}, asked.repeats // 4)
    least = times["the product"].min()
    middle = np.median(times["the product"])
    rows = []
    for name, values in times.items():
        ratio = values.min() / least
        judged = name == "patches, normals and mesh"
        rows.append(
            [
                name,
                f"{values.min():.0f}",
                f"{np.median(values):.0f}",
                f"{ratio:.1f}",
                f"{np.median(values) / middle:.1f}",
                f"< {MOST_RATIO:.0f}" if judged else "",
                met(ratio < MOST_RATIO) if judged else "",
            ]
        )
    header = (
        f"{PASSES - 1} x {COLUMNS} x {ROWS} points",
        "least, us",
        "median, us",
        "ratio of the least",
        "ratio of the medians",
        "asked",
        "verdict",
    )
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    publish("evaluation", [table(header, rows), f"One thread, {os.cpu_count()} cores{load}."])


if __name__ == "__main__":
    main()
