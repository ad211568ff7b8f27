"""Georibbon and other programs on the same curves: how near the truth, and how fast.

Exact passes on known surfaces, and the same as sensors with errors would tell
them.  Each program lays its surface through them; points of that surface, as
far as the passes enclose the true one, are measured against the true surface.
The peers have an environment of their own, which `make peers` prepares.

    make peers [ARGS="--seeds N --only WORD …"]
"""

import argparse
import importlib.util
import platform
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from criteria import lengths_cases, rows
from support.produced import Away, Covered, compared, covered_by, pooled
from support.programs import PROGRAMS, Program
from support.tables import publish, table
from threadpoolctl import threadpool_limits

import georibbon
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import Cone, ReferenceSurface
from georibbon.geometry.spherical import interpolate_frames
from georibbon.rotations import exp

NEEDED = ("OCP", "geomdl", "open3d")
LEFT_OUT = ("torus, 2 passes",)
MISTAKES = (AttributeError, ImportError, NameError, TypeError)  # ours, not the program's failure
PITCH = 0.03  # m between sensors
NOISE = 0.25  # degrees, standard deviation about each axis
REPEATS, LONG = 4, 0.2  # of what is timed; two where it takes longer than so many seconds

NOTES = f"""Each pass is a curve of 121 points with its normals, on a surface that is known. The \
distance is that of points of the produced surface (100 along the passes by 24 between neighbours; \
of triangles the middles) from the closest true point, the points weighted by their area; only \
those count whose closest true point lies between the passes. Normals are compared with the \
truth's there. With noise, each sensor's frame (one in about {1e3 * PITCH:.0f} mm) is turned by \
{NOISE}° (standard deviation about each axis), the curve is integrated from them and put so that \
its middle is right: the error is then mostly that of the curves, the same for all. The curves are \
taken as they are: that Georibbon smooths the twist of a ribbon before is no part of this. Times \
are the processor's, the least of {REPEATS} runs on one thread: to lay the surface, and to \
evaluate those points with their normals, each by its own evaluation (called point by point from \
Python for OpenCASCADE and geomdl, vectorised for the others; Open3D's mesh needs none).

Georibbon is told the points and normals, as are OpenCASCADE's plate with tangent planes and \
Open3D; the others know no way to use normals and are told the points. Settings of the peers, each \
time those of the named that are nearest to the truth: OpenCASCADE's loft cubic or of degree up to \
8 across, to 1e-6 m, without its smoothing (which took from 1 s to 50 s); its plate of order 2 or \
3, with 40 places a curve; geomdl and SciPy's grid spline cubic both ways (across the passes of \
the degree that their number allows), equal fractions of the passes across from each other; thin \
plates through all points; Open3D's octree of depth 5 to 9, only the side that faces as the truth \
does."""

Case = tuple[str, ReferenceSurface, list[Strip]]


@dataclass(frozen=True)
class Score:
    """How a program did in a situation: exact, with noise, and seconds; or why it failed."""

    away: Away | None = None
    noisy: Away | None = None
    laid: float = 0.0
    sampled: float = 0.0
    failure: str = ""


def cases(words: Sequence[str]) -> list[Case]:
    """The situations, or those that have one of the words in their names."""
    cone = Cone(30.0)
    more: Case = ("steep cone", cone, rows(cone, [0.6, 0.7, 0.8, 0.9, 1.0], [0.8] * 5))
    known = [case for case, _ in lengths_cases() if case[0] not in LEFT_OUT]
    found = [known[0], more, *known[1:]]
    return [one for one in found if not words or any(word in one[0] for word in words)]


def as_measured(strip: Strip, random: np.random.Generator) -> Strip:
    """A pass integrated from sensors' frames that are wrong by the noise, its middle right."""
    last = len(strip.s) - 1
    wanted = strip.s[-1] / PITCH
    steps = [step for step in range(1, last + 1) if last % step == 0]
    sites = np.arange(0, last + 1, min(steps, key=lambda step: abs(last / step - wanted)))
    turns = exp(np.radians(NOISE) * random.normal(size=(len(sites), 3)))
    found = interpolate_frames(strip.s[sites], strip.frames[sites] @ turns, strip.s)
    middle = last // 2
    moved = found.points + (strip.points[middle] - found.points[middle])
    return Strip(found.s, moved, found.frames)


def timed(run: Callable[[], Any]) -> tuple[Any, float]:
    """What it returns, and the least seconds of the processor that it took."""
    times: list[float] = []
    # The first run may load what the program consists of: it never stands alone.
    while len(times) < 2 or (len(times) < REPEATS and times[-1] < LONG):
        start = time.process_time()
        result = run()
        times.append(time.process_time() - start)
    return result, min(times)


def laid_once(program: Program, variant: dict[str, Any], covered: Covered, strips: Any) -> Score:
    """One variant of a program through exact curves."""
    laid, building = timed(lambda: program.lay(strips, **variant))
    points, sampling = timed(lambda: program.sample(laid))
    return Score(compared(covered, points, program.closed), None, building, sampling)


def scored(program: Program, covered: Covered, strips: Any, measured: Iterable[Any]) -> Score:
    """The variant of a program nearest to the truth, on exact curves and on measured ones."""
    found, failures = [], []
    for variant in program.variants:
        try:
            found.append((laid_once(program, variant, covered, strips), variant))
        except MISTAKES:
            raise
        except Exception as problem:
            failures.append(str(problem).partition("\n")[0] or type(problem).__name__)
    if not found:
        return Score(failure=failures[0])
    best, variant = min(found, key=lambda one: one[0].away.cells[0])
    noisy = []
    for again in measured:
        sampled = program.sample(program.lay(again, **variant))
        noisy.append(compared(covered, sampled, program.closed))
    return Score(best.away, pooled(noisy), best.laid, best.sampled)


def scores(found: Sequence[Case], seeds: int) -> list[list[Score]]:
    """For each situation the scores of all programs."""
    all_scores = []
    for name, truth, strips in found:
        print(f"… {name}", flush=True)
        covered = covered_by(truth, strips)
        drawn = [np.random.default_rng(seed) for seed in range(seeds)]
        measured = [[as_measured(strip, random) for strip in strips] for random in drawn]
        all_scores.append([scored(one, covered, strips, measured) for one in PROGRAMS])
    return all_scores


def figures(values: Sequence[float], decimals: int) -> list[str]:
    """Numbers with so many decimals, large ones with fewer."""
    return [f"{value:.{decimals if value < 10.0 else 1}f}" for value in values]


def line(program: Program, name: str, score: Score) -> list[str]:
    """A row of the table."""
    start = [name, program.name, "yes" if program.normals else "no"]
    if score.away is None or score.noisy is None:
        return [*start, f"failed: {score.failure}", *["-"] * 9]
    cells = []
    for away in (score.away, score.noisy):
        rms, most, turn, most_turn = away.cells
        cells += [*figures((rms, most), 4), *figures((turn, most_turn), 3)]
    points = "-" if program.closed else f"{1e3 * score.sampled:.1f}"
    return [*start, *cells, f"{1e3 * score.laid:.1f}", points]


def whole_table(found: Sequence[Case], all_scores: Sequence[Sequence[Score]]) -> str:
    """All figures."""
    header = ["situation", "program", "normals told"]
    for words in ("", f", {NOISE}°"):
        header += [f"rms mm{words}", f"max mm{words}", f"normals rms °{words}"]
        header.append(f"normals max °{words}")
    header += ["laid, ms", "points, ms"]
    lines = [
        line(program, name, score)
        for (name, *_), several in zip(found, all_scores, strict=True)
        for program, score in zip(PROGRAMS, several, strict=True)
    ]
    return table(header, lines)


def glance(found: Sequence[Case], all_scores: Sequence[Sequence[Score]]) -> str:
    """rms distances on exact curves, the least of each situation in bold."""
    columns = []
    for several in all_scores:
        found_rms = [one.away.cells[0] if one.away else np.inf for one in several]
        least = figures([min(found_rms)], 4)[0]
        texts = [figures([rms], 4)[0] if np.isfinite(rms) else "failed" for rms in found_rms]
        columns.append([f"**{text}**" if text == least else text for text in texts])
    lines = [[one.name, *cells] for one, *cells in zip(PROGRAMS, *columns, strict=True)]
    return table(["rms mm, exact curves", *(name for name, *_ in found)], lines)


def beaten(found: Sequence[Case], all_scores: Sequence[Sequence[Score]]) -> str:
    """Where a peer is nearer the truth than Georibbon as it comes, in any of its four figures."""
    words = ("rms distance", "greatest distance", "rms of normals", "greatest angle of normals")
    lines = []
    for (name, *_), (own, *others) in zip(found, all_scores, strict=True):
        for program, score in zip(PROGRAMS[1:], others, strict=True):
            if program.package is None or score.away is None or own.away is None:
                continue
            pairs = ((score.away, own.away, "exact"), (score.noisy, own.noisy, f"{NOISE}°"))
            for theirs, ours, kind in pairs:
                better = [
                    f"{word} {a:.4g} against {b:.4g}"
                    for word, a, b in zip(words, theirs.cells, ours.cells, strict=True)
                    if a < b
                ]
                if better:
                    lines.append(f"- {name}, {kind}: {program.name}: {'; '.join(better)}")
    return "\n".join(lines) or "Nowhere."


def versions() -> str:
    """What was measured, with what."""
    packages = dict.fromkeys(one.package for one in PROGRAMS if one.package)
    told = [f"Georibbon {georibbon.__version__}", f"NumPy {np.__version__}"]
    for name in packages:
        try:
            told.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            told.append(f"{name}-cpu {version(name + '-cpu')}")
    told.append(f"Python {platform.python_version()}, {platform.system()} {platform.machine()}")
    return ", ".join(told) + "."


def missing() -> list[str]:
    """The peers that are not installed here."""
    return [name for name in NEEDED if importlib.util.find_spec(name) is None]


def main() -> None:
    """Measure and publish; without the peers say how to get them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="how many times noise is drawn")
    parser.add_argument("--only", nargs="+", default=[], help="situations with such words")
    arguments = parser.parse_args()
    if missing():
        print(f"Not measured: {', '.join(missing())} missing here; `make peers` installs and runs.")
        return
    with threadpool_limits(1):
        found = cases(arguments.only)
        all_scores = scores(found, arguments.seeds)
    publish(
        "peers",
        [
            "# Georibbon and its peers on the same curves",
            versions(),
            NOTES,
            "## At a glance",
            glance(found, all_scores),
            "## Where a peer is nearer the truth than Georibbon as it comes",
            beaten(found, all_scores),
            "## All figures",
            whole_table(found, all_scores),
        ],
    )


if __name__ == "__main__":
    main()
