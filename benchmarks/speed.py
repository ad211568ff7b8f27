"""How long a reconstruction takes, as a ratio to importing NumPy and SciPy in the same run.

Every figure is the median over fresh processes, the first of which is thrown
away (byte code and disk are warm after it).  A process measures, in this order:

- the import of numpy, scipy.optimize, scipy.interpolate and scipy.sparse;
- with all modules imported: reading a recording folder, calibrating from 16
  poses and reconstructing 5 passes of 32 sensors, the surface included, for
  the first time in this process, then for the second;
- one pass refitted from its minimum of a moment before, as a live view does;
- all brought up to date after one pass's smoothing was changed.

    .venv/bin/python benchmarks/speed.py [--repeats N]
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

Seconds = tuple[float, float]

MOST_WHOLE = 3.0
MOST_REFIT = 0.01


def main() -> None:
    """Start the processes, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--repeats", type=int, default=9, help="processes that count")
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure is not None:
        print(json.dumps(measure(asked.measure)))
        return
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "recording"
        record(recording)
        command = [sys.executable, __file__, "--measure", str(recording)]
        runs = [
            json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
            for _ in range(asked.repeats + 1)
        ]
    report(runs[1:])


def record(folder: Path) -> None:
    """A recording of five marked passes of 32 sensors and 16 poses."""
    from georibbon.session.folder import write_recording
    from georibbon.simulation import SimulationSettings, simulate

    write_recording(simulate(SimulationSettings()).recording, folder)


def measure(folder: Path) -> dict[str, Seconds]:
    """Seconds of each thing, in this process."""
    return {"import": imports(), **reconstructions(folder), **refit(folder)}


class Clock:
    """Seconds since it was made: (on the wall, of the processor)."""

    def __init__(self) -> None:
        self.begin = time.perf_counter(), time.process_time()

    def read(self) -> Seconds:
        """The seconds so far."""
        return time.perf_counter() - self.begin[0], time.process_time() - self.begin[1]


def imports() -> Seconds:
    """Seconds that the imports take."""
    clock = Clock()
    import numpy  # noqa: F401  imported to see how long it takes, like the rest here
    import scipy.interpolate
    import scipy.optimize
    import scipy.sparse  # noqa: F401

    return clock.read()


def reconstructions(folder: Path) -> dict[str, Seconds]:
    """Seconds of reading and of reconstructing, at first, again, and brought up to date."""
    import georibbon.geometry.surface  # noqa: F401  everything that is used later
    from georibbon.reconstruction import ReconstructionSettings, Stages, reconstruct
    from georibbon.session.folder import read_recording

    found = {}
    for name in ("first", "second"):
        stages = Stages()
        clock = Clock()
        recording = read_recording(folder)
        found[f"read, {name}"] = clock.read()
        reconstruct(recording, stages=stages)
        found[f"whole, {name}"] = clock.read()
    settings = ReconstructionSettings(smoothing={"P2": 0.2})
    found["update"] = seconds(lambda: reconstruct(recording, settings, stages=stages))
    return found


def refit(folder: Path) -> dict[str, Seconds]:
    """Seconds in which one pass follows its readings, from the minimum of a moment before."""
    from georibbon.calibration import calibrate
    from georibbon.fitting.capture import Capture, prepare
    from georibbon.fitting.fit import FitSettings, fit_alone
    from georibbon.fitting.screening import screen
    from georibbon.fitting.strip import fit_strips
    from georibbon.ribbon import Readings
    from georibbon.session.folder import read_recording

    recording = read_recording(folder)
    calibration = calibrate(recording.ribbon, recording.poses)

    def captured(part: slice) -> Capture:
        passes = tuple(
            replace(one, readings=Readings(one.readings.t[part], one.readings.counts[part]))
            for one in recording.passes
        )
        screened = screen(recording.ribbon, passes, calibration)
        return prepare(replace(recording, passes=passes), calibration, screened)

    before, now = captured(slice(0, 50)), captured(slice(50, 100))
    strip = fit_alone(before, [1], FitSettings())[0].take([0])
    problem = now.problem.take([1])
    times = [seconds(lambda: fit_strips(problem, strip.shape, strip.smoothing)) for _ in range(30)]
    return {"refit": sorted(times)[len(times) // 2]}


def seconds(work: Callable[[], object]) -> Seconds:
    """How long it takes."""
    clock = Clock()
    work()
    return clock.read()


def report(runs: list[dict[str, Seconds]]) -> None:
    """Print the medians and their ratios."""
    from statistics import median

    from support.tables import met, publish, table

    def row(what: str, name: str, limit: float | None) -> list[str]:
        wall = sorted(run[name][0] / run["import"][0] for run in runs)
        busy = median(run[name][1] / run["import"][1] for run in runs)
        asked = "" if limit is None else f"{limit:g}"
        cells = [what, f"{1e3 * median(run[name][0] for run in runs):.1f}"]
        cells += [f"{median(wall):.3g}", f"{wall[0]:.3g} to {wall[-1]:.3g}", f"{busy:.3g}"]
        return [*cells, asked, "" if limit is None else met(median(wall) <= limit)]

    rows = [
        row("importing numpy and three parts of scipy", "import", None),
        row("reading, calibrating and reconstructing, first time", "whole, first", MOST_WHOLE),
        row("the same, second time", "whole, second", None),
        row("of which reading the folder, first time", "read, first", None),
        row("one pass refitted from a warm start", "refit", MOST_REFIT),
        row("all brought up to date after one pass's smoothing", "update", None),
    ]
    header = ("what", "ms", "ratio", "least and greatest", "of processor time", "asked", "")
    head = (
        f"Medians over {len(runs)} fresh processes; ratios are taken within each. (The refit's "
        f"limit is 1/100 of the import; of the whole's limit it would be {MOST_WHOLE / 100:g}.)"
    )
    publish("speed", [head, table(header, rows)])


if __name__ == "__main__":
    main()
