"""How the time grows with the number of passes, stage by stage.

Captures of 5 to 200 marked passes on a long cylinder (and a plane), 32 sensors
each, reconstructed with calibration and surface.  The slope is that of log time
against log passes over the last doublings: 1 is linear growth, 2 quadratic.
Times are of the processor (one thread), so that a busy machine matters less.

    .venv/bin/python benchmarks/scaling.py [--passes 5 10 …] [--surface S] [--profile]
"""

import argparse
import cProfile
import io
import os
import pstats
import resource
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from support.tables import met, publish, table

if TYPE_CHECKING:  # nothing that loads numpy before the number of threads is set
    from georibbon.recording import Recording

T = TypeVar("T")

PASSES = (5, 10, 20, 50, 100, 200)
STAGES = ("calibration", "screened", "capture", "alone", "ribbon", "surface", "other", "whole")
NAMES = {"screened": "means", "capture": "readings", "ribbon": "together"}
STEEPEST = 1.5  # of the whole from 20 passes on: clearly not quadratic


def stage_times(passes: int, surface: str) -> tuple[dict[str, float], "Recording"]:
    """Processor seconds of each stage of one reconstruction, and its recording."""
    from support.captures import many

    from georibbon.reconstruction import Stages, reconstruct
    from georibbon.simulation import simulate

    class TimedStages(Stages):
        """Stages that notice how long each takes."""

        def __init__(self) -> None:
            super().__init__()
            self.seconds = dict.fromkeys(STAGES, 0.0)
            self._asked = 0.0

        def get(self, stage: object, of: tuple[object, ...], make: Callable[[], T]) -> T:
            """The stage's result; its time is added up."""
            begin = time.process_time()
            result = super().get(stage, of, make)
            self.seconds[_name(stage)] += time.process_time() - begin
            return result

        def has(self, stage: object, of: tuple[object, ...]) -> bool:
            """Whether the result is held; all that are missing are made in one go after it."""
            self._asked = time.process_time()
            return super().has(stage, of)

        def put(self, stage: object, of: tuple[object, ...], value: object) -> None:
            """Holds a result; that of passes alone was made since it was asked for."""
            if isinstance(stage, tuple):
                self.seconds[_name(stage)] += time.process_time() - self._asked
                self._asked = time.process_time()
            super().put(stage, of, value)

    recording = simulate(many(surface, passes)).recording
    stages = TimedStages()
    begin = time.process_time()
    reconstruct(recording, stages=stages)
    stages.seconds["whole"] = time.process_time() - begin
    known = sum(stages.seconds[name] for name in STAGES[:-2])
    stages.seconds["other"] = stages.seconds["whole"] - known
    return stages.seconds, recording


def _name(stage: object) -> str:
    return stage[0] if isinstance(stage, tuple) else str(stage)


def slopes(passes: list[int], found: list[dict[str, float]]) -> dict[str, float]:
    """Of log seconds against log passes, from 20 passes on (or all, where there are fewer)."""
    import numpy as np

    late = [k for k, count in enumerate(passes) if count >= 20]
    chosen = late if len(late) > 1 else list(range(len(passes)))
    x = np.log([passes[k] for k in chosen])
    return {
        name: float(np.polyfit(x, np.log([max(found[k][name], 1e-4) for k in chosen]), 1)[0])
        for name in STAGES
    }


def profile(recording: "Recording") -> str:
    """The functions that take longest."""
    from georibbon.reconstruction import reconstruct

    watch = cProfile.Profile()
    watch.runcall(reconstruct, recording)
    text = io.StringIO()
    pstats.Stats(watch, stream=text).sort_stats("tottime").print_stats(25)
    return "```\n" + text.getvalue().strip() + "\n```"


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--passes", type=int, nargs="+", default=list(PASSES))
    parser.add_argument("--surface", choices=("cylinder", "plane"), default="cylinder")
    parser.add_argument("--profile", action="store_true", help="what takes longest at the most")
    asked = parser.parse_args()
    # Before numpy is loaded: one thread, whose processor time is the work done.
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    stage_times(3, asked.surface)  # loads and warms everything
    found, rows = [], []
    for count in asked.passes:
        seconds, recording = stage_times(count, asked.surface)
        found.append(seconds)
        cells = [str(count), *(f"{seconds[name]:.2f}" for name in STAGES)]
        rows.append([*cells, f"{1e3 * seconds['whole'] / count:.0f}"])
    grown = slopes(asked.passes, found)
    rows.append(["slope", *(f"{grown[name]:.2f}" for name in STAGES), ""])
    header = ("passes", *(NAMES.get(name, name) for name in STAGES), "ms a pass")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    parts = [
        f"Processor seconds on a {asked.surface} of as many passes, 32 sensors each; the slope of "
        f"the whole from 20 passes on is {grown['whole']:.2f}, asked at most {STEEPEST:g}: "
        f"{met(grown['whole'] <= STEEPEST)}. Most memory: {peak:.0f} MB.",
        table(header, rows),
    ]
    if asked.profile:
        parts.append(profile(recording))
    publish("scaling", parts)


if __name__ == "__main__":
    main()
