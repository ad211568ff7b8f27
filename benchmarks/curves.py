"""How long the panel of the curves takes to follow a slider: 5 passes of 32 sensors.

New values into the lines that are there, and painted, on Qt's platform without a
display, 900 x 300 pixels.  Wall clock and the processor's time, medians of many; on a
machine that does something else as well the latter tells more.

    .venv/bin/python benchmarks/curves.py [--rounds N]
"""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

from support.tables import met, publish, table

from georibbon.reconstruction import Reconstruction, ReconstructionSettings, Stages, reconstruct
from georibbon.recording import Recording
from georibbon.simulation import SimulationSettings, simulate

ASKED = 8.0  # ms
SHOWN = {
    "curvature and uncertainty, as at first": ("curvature", "sigma"),
    "the same, with residuals and torsion": ("curvature", "torsion", "sigma", "residuals"),
    "the same, with a raw reading": (
        "curvature",
        "torsion",
        "sigma",
        "residuals",
        "magnetometer-x",
    ),
}


def results(recording: Recording) -> list[Reconstruction]:
    """What a slider would show, one after the other."""
    stages = Stages()
    lengths = (0.08, 0.1, 0.13, 0.1)
    settings = [ReconstructionSettings(smoothing={"*": one}, surface=None) for one in lengths]
    return [reconstruct(recording, one, stages=stages) for one in settings]


def measure(rounds: int) -> list[tuple[str, float, float]]:
    """Of every choice of quantities the milliseconds of an update, and of the processor."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    from PySide6.QtWidgets import QApplication

    from georibbon.gui.curve_panel import CurvePanel
    from georibbon.gui.settings import Settings
    from georibbon.gui.theme import apply_theme
    from georibbon.gui.units import Units

    application = QApplication(["curves"])
    apply_theme(application, "light")
    recording = simulate(SimulationSettings()).recording
    moved = results(recording)
    names = [one.name for one in moved[0].passes]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        parts = SimpleNamespace(units=Units(), settings=Settings(Path(folder) / "settings.ini"))
        panel = CurvePanel(parts)
        panel.resize(900, 300)
        panel.show()
        for words, quantities in SHOWN.items():
            panel.show_quantities(quantities)
            walls, busy = [], []
            for k in range(rounds):
                wall, processor = time.perf_counter(), time.process_time()
                panel.show_passes(moved[k % len(moved)], names, recording)
                application.processEvents()
                walls.append(time.perf_counter() - wall)
                busy.append(time.process_time() - processor)
            found.append((words, 1e3 * statistics.median(walls), 1e3 * statistics.median(busy)))
        panel.close()
    return found


def report(found: Sequence[tuple[str, float, float]]) -> list[str]:
    """The table; the first line is what is asked for."""
    rows = [
        [
            words,
            f"≤ {ASKED:.0f} ms" if not k else "",
            f"{wall:.1f} ms",
            f"{processor:.1f} ms",
            met(processor <= ASKED) if not k else "",
        ]
        for k, (words, wall, processor) in enumerate(found)
    ]
    header = ["shown of 5 passes", "asked", "wall clock", "processor", "verdict"]
    return ["# Curves that follow a slider", table(header, rows)]


def main() -> None:
    """Measure, print, keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=100)
    publish("curves", report(measure(parser.parse_args().rounds)))


if __name__ == "__main__":
    main()
