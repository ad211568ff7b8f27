"""How far curves, normals and surfaces are from the truth, calibration included.

Virtual captures on many surfaces, with ribbons of 16 to 64 sensors, 2- and
3-axis magnetometers, and headings as the seeds draw them.  Curves of captures
without marks are first moved rigidly onto the truth.  Worst and mean are over
captures, of each capture's root mean square.

    .venv/bin/python benchmarks/accuracy.py [--seeds N] [--surfaces A B] [--each]
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from support.captures import (
    SURFACES,
    dead,
    fanned,
    magnetised,
    marked,
    ribbon,
    spaced,
    tied,
)
from support.parallel import in_parallel
from support.tables import met, publish, table

from georibbon.errors import GeoribbonError
from georibbon.notices import Notice
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.simulation import SimulationSettings, score, simulate

WAYS = {
    "default": ReconstructionSettings(),
    "alone": ReconstructionSettings(neighbours=False),
    "paper": ReconstructionSettings(method="paper"),
}
HEADER = ("survey", "figure", "asked", "worst", "mean", "without neighbours", "paper's way", "")


@dataclass(frozen=True)
class Kind:
    """A kind of capture, and what is asked of it.

    asked: the figure's name, the limit of the worst capture, that of the mean.
    """

    name: str
    change: Callable[[SimulationSettings], SimulationSettings]
    asked: tuple[tuple[str, float, float], ...]


NONE = np.inf
MARKED = (("curves, mm", 1.0, NONE), ("normals, °", 0.45, NONE), ("surface, mm", 0.6, 0.42))
KINDS = (
    Kind("starts and ends marked", lambda capture: capture, MARKED),
    Kind("the same, passes 3° off parallel", fanned, MARKED),
    Kind("3 tie passes, no marks", tied, (("curves, mm", 1.6, NONE),)),
    Kind("distances only", spaced, (("curves, mm", 2.4, NONE),)),
    Kind("marked, two dead sensors", dead, (("curves, mm", 1.5, NONE),)),
    Kind("marked, a magnet", magnetised, (("curves, mm", 1.5, NONE),)),
)
FIGURES = ("curves, mm", "normals, °", "surface, mm")


@dataclass(frozen=True)
class Result:
    """figures: (ways, figures), NaN where a way failed.  named: all that was wrong was named."""

    figures: np.ndarray
    named: bool
    note: str


def measure(case: tuple[int, SimulationSettings]) -> Result:
    """One capture, every way."""
    kind, settings = case
    simulation = simulate(KINDS[kind].change(settings))
    figures = np.full((len(WAYS), len(FIGURES)), np.nan)
    note, named = "", True
    for row, (way, chosen) in zip(figures, WAYS.items(), strict=True):
        try:
            found = reconstruct(simulation.recording, chosen)
        except GeoribbonError as error:
            note += f" {way}: {error}"
            continue
        scored = score(found, simulation.truth)
        row[:] = scored.curves.all.rms, scored.curves.all.normal_rms, scored.surface_rms or np.nan
        if way == "default":
            note += " ".join(sorted({notice.code for notice in found.notices}))
            named = all_named(KINDS[kind].change(settings), found.notices)
    return Result(figures, named, note)


def all_named(settings: SimulationSettings, notices: Sequence[Notice]) -> bool:
    """Whether the notices name every dead sensor, and a magnetometer of the magnet's pass."""
    faults = settings.faults
    if faults.magnet > 0 and not any(
        notice.code == "field-disturbed" and notice.pass_name == faults.magnet_on
        for notice in notices
    ):
        return False
    return set(faults.dead) <= {notice.sensor for notice in notices}


def rows_of(kind: Kind, results: Sequence[Result]) -> list[list[str]]:
    """The kind's rows of the table."""
    figures = np.array([result.figures for result in results])
    rows = []
    for name, worst, mean in kind.asked:
        part = figures[:, :, FIGURES.index(name)]
        fine = bool(part[:, 0].max() <= worst and part[:, 0].mean() <= mean)
        asked = f"{worst:g}" + ("" if mean == NONE else f", mean {mean:g}")
        cells = [kind.name, name, asked, f"{part[:, 0].max():.2f}", f"{part[:, 0].mean():.2f}"]
        rows.append([*cells, *(f"{np.mean(part[:, k]):.2f}" for k in (1, 2)), met(fine)])
    if results and kind.change in (dead, magnetised):
        share = sum(result.named for result in results)
        cells = [kind.name, "named in the notices", "all", f"{share} of {len(results)}"]
        rows.append([*cells, "", "", "", met(share == len(results))])
    return rows


def by_sensors(captures: Sequence[SimulationSettings], results: Sequence[Result]) -> str:
    """The worst surface of the marked captures by the ribbon's number of sensors."""
    worst: dict[int, float] = {}
    for capture, result in zip(captures, results, strict=False):
        sensors = capture.ribbon.sensors
        worst[sensors] = max(worst.get(sensors, 0.0), float(result.figures[0, 2]))
    told = ", ".join(f"{n} sensors {worst[n]:.2f} mm" for n in sorted(worst))
    return f"Worst surface, starts and ends marked, by ribbon: {told}."


def each_row(kind: Kind, settings: SimulationSettings, result: Result) -> list[str]:
    """One capture's row."""
    made = settings.ribbon
    what = f"{settings.surface}, seed {settings.seed}, {made.sensors} × {made.magnetometer_axes}"
    figures = [f"{value:.2f}" for value in result.figures[:2].ravel()]
    return [kind.name, what, *figures, result.note + ("" if result.named else " NOT NAMED")]


def options() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=int, default=5, help="seeds for each surface")
    parser.add_argument("--first", type=int, default=1, help="the first seed")
    parser.add_argument("--surfaces", nargs="+", default=list(SURFACES))
    parser.add_argument("--each", action="store_true", help="a row for every capture too")
    return parser.parse_args()


def main() -> None:
    """Measure, and print the table."""
    asked = options()
    captures = [
        marked(surface, seed, ribbon(k + seed))
        for k, surface in enumerate(asked.surfaces)
        for seed in range(asked.first, asked.first + asked.seeds)
    ]
    cases = [(kind, capture) for kind in range(len(KINDS)) for capture in captures]
    results = in_parallel(measure, cases)
    rows, single = [], []
    for k, kind in enumerate(KINDS):
        part = results[k * len(captures) : (k + 1) * len(captures)]
        rows += rows_of(kind, part)
        single += [each_row(kind, *pair) for pair in zip(captures, part, strict=True)]
    parts = [
        f"Accuracy on {len(captures)} captures of each kind ({len(asked.surfaces)} surfaces, "
        f"{asked.seeds} seeds each, 16 to 64 sensors on 0.96 m, 2- and 3-axis magnetometers, "
        "calibration included); rms of each capture, the last two columns are means.",
        table(HEADER, rows),
        by_sensors(captures, results),
    ]
    if asked.each:
        names = ("curves", "normals", "surface")
        header = ("survey", "capture", *names, *(f"{name} alone" for name in names), "notes")
        parts.append(table(header, single))
    publish("accuracy", parts)


if __name__ == "__main__":
    main()
