"""Whether a plan gives what was forecast for it, before any pass was laid.

Virtual captures by each plan, calibration included, against the truth: the rms
over all points of the passes (after the best rigid motion where there are no
marks), and the forecast for the same kind of surface.  The forecast is honest
where the ratio is near 1; it may not promise much more than is found.  Where
distances alone hold the passes, the forecast counts what the assumption that
they were measured straight across may miss; in a virtual capture it is true.

    .venv/bin/python benchmarks/forecast.py [--seeds N]
"""

import argparse
import time

import numpy as np
from support.parallel import in_parallel
from support.tables import met, publish, table

from georibbon.capture.forecast import forecast, usual_calibration
from georibbon.capture.plan import CapturePlan, PlannedLayout
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.simulation import LayoutSettings, SimulationSettings, SurveySettings, simulate
from georibbon.simulation.scoring import score
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import virtual_ribbon

LEAST, MOST = 0.6, 1.5
LEAST_ASSUMED = 0.2
HEADER = ("surface", "plan", "forecast, mm", "found, mm", "found / forecast",
          "normals forecast", "normals found", "took, s", "")  # fmt: skip
SURFACES = {"flat": "plane", "gentle": "bonnet", "bent": "cylinder"}
PLANS = {
    "starts and ends marked": (0, PlannedLayout()),
    "marked, 2 ties": (2, PlannedLayout()),
    "2 ties": (2, PlannedLayout(marks=0)),
    "4 ties": (4, PlannedLayout(marks=0)),
    "distances": (0, PlannedLayout(marks=0, distances=2)),
}


def found(case: tuple[str, str, int]) -> tuple[float, float]:
    """Mean squares of position (mm) and normals (degrees) over the passes of one capture."""
    surface, name, seed = case
    ties, layout = PLANS[name]
    kinds = []
    kinds += ["starts", "ends"] if layout.marks else []
    kinds += ["distances"] if layout.distances else []
    radius = {"radius": 0.96 / 2.1} if surface == "cylinder" else {}
    simulation = simulate(
        SimulationSettings(
            surface=surface,
            parameters=radius,
            seed=seed,
            layout=LayoutSettings(passes=5, ties=ties, spacing=layout.spacing, heading=0.0),
            survey=SurveySettings(kinds=tuple(kinds)),
        )
    )
    result = reconstruct(simulation.recording, ReconstructionSettings(surface=None))
    passes = score(result, simulation.truth).curves.passes
    squares = [(one.rms**2, one.normal_rms**2) for name, one in passes.items() if name[0] == "P"]
    place, normal = np.mean(squares, axis=0)
    return float(place), float(normal)


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=int, default=12, help="captures for each row")
    parser.add_argument("--surfaces", nargs="+", default=list(SURFACES), choices=list(SURFACES))
    asked = parser.parse_args()
    kinds = [(likeness, name) for likeness in asked.surfaces for name in PLANS]
    cases = [
        (SURFACES[likeness], name, 500 + seed)
        for likeness, name in kinds
        for seed in range(asked.seeds)
    ]
    squares = np.array(in_parallel(found, cases)).reshape(len(kinds), asked.seeds, 2)
    ribbon = virtual_ribbon(RibbonSettings())
    rows = []
    for (likeness, name), errors in zip(kinds, squares, strict=True):
        ties, layout = PLANS[name]
        began = time.perf_counter()
        plan = CapturePlan(passes=5, ties=ties, layout=layout)
        told = forecast(ribbon, usual_calibration(ribbon), plan, likeness).figures
        took = time.perf_counter() - began
        place, normal = np.sqrt(errors.mean(axis=0))
        ratio = place / (1e3 * told.rms)
        least = LEAST_ASSUMED if name == "distances" else LEAST
        rows.append(
            (likeness, name, f"{1e3 * told.rms:.2f}", f"{place:.2f}", f"{ratio:.2f}",
             f"{np.degrees(told.normal) * np.sqrt(2):.2f}°", f"{normal:.2f}°", f"{took:.2f}",
             met(least <= ratio <= MOST))
        )  # fmt: skip
    publish("forecast", ["# Forecast and found", table(HEADER, rows)])


if __name__ == "__main__":
    main()
