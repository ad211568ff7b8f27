"""Directions, tangent lengths, correspondences and interiors against the truth, and their time.

Exact passes on known surfaces; the rms distance of the built surface to the
true one over all parameters.  The time of the tangent length criteria is
compared with a general minimisation called line by line.

    .venv/bin/python benchmarks/criteria.py [--lines N] [--compared N]
"""

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize
from support.tables import met, publish, table

from georibbon.arrays import FloatArray
from georibbon.geometry.closest import closest_point
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.fairness import fairest_lengths, lines_between
from georibbon.geometry.frames import Strip, unit
from georibbon.geometry.geodesics import directions_at, geodesic
from georibbon.geometry.patch import (
    Patches,
    basis,
    natural_parameters,
    patch_grid,
    patches_at,
    patches_between,
)
from georibbon.geometry.reference import (
    Bonnet,
    BSplineSurface,
    Cone,
    Ellipsoid,
    ReferenceSurface,
    Saddle,
    Torus,
)
from georibbon.geometry.settings import CORRESPONDENCES, LENGTHS, SurfaceSettings

ROWS, COLUMNS = 200, 33
TOLERANCE, ROUNDING = 1.05, 5e-5  # of the figures asked for, which have four decimals, mm
LEAST_RATIO = 200.0
SCORED = ("unit", "arc", "criterion1", "criterion2-vector")

Case = tuple[str, ReferenceSurface, list[Strip]]
Choice = dict[str, object]


def rows(
    surface: ReferenceSurface,
    places: Sequence[float],
    lengths: Sequence[float],
    shifts: Sequence[float] | None = None,
    angles: Sequence[float] | None = None,
) -> list[Strip]:
    """Geodesics through places v at u = 0, their middles `shifts` metres beyond, 121 points."""
    count = len(places)
    uv = np.stack([np.zeros(count), places], axis=1)
    turned = directions_at(surface, uv, np.array(angles or [0.0] * count))
    strips = []
    for at, ahead, length, shift in zip(uv, turned, lengths, shifts or [0.0] * count, strict=True):
        s = shift + np.linspace(-0.5 * length, 0.5 * length, 121)
        found = geodesic(surface, at, ahead, np.union1d(s, [0.0]))
        kept = np.isin(np.union1d(s, [0.0]), s)
        strips.append(Strip(s - s[0], found.points[kept], found.frames[kept]))
    return strips


def across(count: int, gap: float) -> list[float]:
    """Places a gap apart, about 0."""
    return [gap * (k - 0.5 * (count - 1)) for k in range(count)]


def cone_rows(span: float, shift: float) -> tuple[Cone, list[Strip]]:
    """Two geodesics of a cone of 30 degrees, 0.30 and 0.39 m from its axis where they are nearest.

    Each spans an angle about the axis; they are shifted about it against each other.
    """
    lengths, shifts = [], []
    for distance, side in ((0.6, -0.5), (0.78, 0.5)):
        ends = np.array([-0.5, 0.5]) * span + side * shift
        first, last = distance * np.tan(0.5 * ends)
        lengths.append(last - first)
        shifts.append(0.5 * (first + last))
    cone = Cone(30.0)
    return cone, rows(cone, [0.6, 0.78], lengths, shifts)


def panel() -> BSplineSurface:
    """An uneven arch of two radians: a net of 8 by 7 points."""
    random = np.random.default_rng(12)
    angles, y = np.linspace(-1.4, 1.4, 8), np.linspace(-0.6, 0.6, 7)
    radius = 0.55 + 0.05 * random.normal(size=(8, 7))
    x, z = radius * np.sin(angles)[:, None], radius * np.cos(angles)[:, None]
    return BSplineSurface(np.stack([x, np.broadcast_to(y, (8, 7)), z], axis=2))


def panel_rows() -> tuple[BSplineSurface, list[Strip]]:
    """Five passes over the arch, 90 mm apart in its middle."""
    surface = panel()
    uv = np.stack([np.full(5, 2.5), 2.0 + 0.45 * np.arange(-2, 3)], axis=1)
    ahead = directions_at(surface, uv, np.zeros(5))
    s = np.linspace(-0.36, 0.36, 121)
    strips = [geodesic(surface, at, to, s) for at, to in zip(uv, ahead, strict=True)]
    return surface, [Strip(one.s - one.s[0], one.points, one.frames) for one in strips]


def lengths_cases() -> list[tuple[Case, dict[str, float]]]:
    """Surfaces with passes, and the figures asked for, mm, where the situation is determined."""
    sphere, torus, ring = Ellipsoid(), Torus(0.5, 0.2, True), 0.448
    fan = [0.0, 0.03, -0.03, 0.0, 0.03]
    aligned, shifted = cone_rows(2.0, 0.0), cone_rows(2.0, 0.2)
    return [
        (
            ("sphere", sphere, rows(sphere, across(5, 0.1 / 0.6), [0.72] * 5)),
            {"unit": 0.0018, "arc": 0.0, "criterion1": 0.0006, "criterion2-vector": 0.0},
        ),
        (
            ("torus", torus, rows(torus, across(5, ring), [0.9] * 5)),
            {"unit": 0.024, "arc": 0.0007, "criterion1": 0.0083, "criterion2-vector": 0.0004},
        ),
        (
            ("torus, 3 passes", torus, rows(torus, across(3, 2 * ring), [0.9] * 3)),
            {"unit": 0.370, "arc": 0.0073, "criterion1": 0.134, "criterion2-vector": 0.0071},
        ),
        (
            ("torus, 2 passes", torus, rows(torus, across(2, 4 * ring), [0.9] * 2)),
            {"unit": 5.27, "arc": 0.041, "criterion1": 2.13, "criterion2-vector": 0.18},
        ),
        (
            ("cone, level", *aligned),
            dict.fromkeys(SCORED, 0.0),
        ),
        (
            (
                "sphere, shifted",
                sphere,
                rows(sphere, across(2, 0.155 / 0.6), [0.72] * 2, [-0.044, 0.044]),
            ),
            {"unit": 0.0195, "arc": 0.0, "criterion1": 0.0066, "criterion2-vector": 0.0},
        ),
        (("cone, shifted", *shifted), {}),
        (("saddle", Saddle(), rows(Saddle(), across(5, 0.1), [0.9] * 5, None, fan)), {}),
        (("bonnet", Bonnet(), rows(Bonnet(), across(5, 0.1), [0.9] * 5, None, fan)), {}),
        (
            (
                "ellipsoid",
                Ellipsoid(0.7, 0.6, 0.5),
                rows(Ellipsoid(0.7, 0.6, 0.5), across(5, 0.16), [0.8] * 5),
            ),
            {},
        ),
        (("uneven arch", *panel_rows()), {}),
    ]


def correspondence_cases() -> list[Case]:
    """Pairs of passes shifted or of unequal lengths."""
    sphere, torus, bonnet = Ellipsoid(), Torus(0.5, 0.2, True), Bonnet()
    pair = across(2, 0.1)
    return [
        ("cone, shifted", *cone_rows(2.0, 0.2)),
        (
            "sphere, shifted",
            sphere,
            rows(sphere, across(2, 0.155 / 0.6), [0.72] * 2, [-0.044, 0.044]),
        ),
        ("bonnet, shifted 100 mm", bonnet, rows(bonnet, pair, [0.8] * 2, [-0.05, 0.05])),
        ("bonnet, 0.72/0.50, starts level", bonnet, rows(bonnet, pair, [0.72, 0.5], [0.0, -0.11])),
        ("torus, 0.90/0.70", torus, rows(torus, [0.45, 1.0], [0.9, 0.7])),
        (
            "sphere, 0.70/0.45, starts level",
            sphere,
            rows(sphere, across(2, 0.1 / 0.6), [0.7, 0.45], [0.0, -0.125]),
        ),
    ]


def patches_of(strips: Sequence[Strip], choice: Choice, count: int = ROWS) -> Patches:
    """The patches between passes, at so many parameters."""
    model = patches_between(arrange(strips), SurfaceSettings(**choice))
    u = natural_parameters(model)
    return patches_at(model, np.linspace(u[0], u[-1], count))


def points_of(patches: Patches) -> FloatArray:
    """(p-1, k, m, 3) points of all patches."""
    return basis(np.linspace(0.0, 1.0, COLUMNS), 0, patches.control.shape[-2]) @ patches.control


def error(surface: ReferenceSurface, strips: Sequence[Strip], choice: Choice) -> float:
    """rms distance of the built surface to the true one, mm."""
    away = closest_point(surface, points_of(patches_of(strips, choice)).reshape(-1, 3)).distance
    return 1e3 * float(np.sqrt(np.mean(away**2)))


def lengths_table() -> str:
    """Errors by tangent length criterion."""
    lines = []
    for (name, surface, strips), asked in lengths_cases():
        found = {
            word: error(surface, strips, {"lengths": word, "correspondence": "fraction"})
            for word in LENGTHS
        }
        cells = [
            f"{value:.4f}" + (f" ({asked[word]:g})" if word in asked else "")
            for word, value in found.items()
        ]
        fine = all(found[word] <= TOLERANCE * (mm + ROUNDING) for word, mm in asked.items())
        lines.append([name, *cells, met(fine) if asked else "-"])
    text = table(["rms mm (asked, at most 5 % more)", *LENGTHS, "verdict"], lines)
    return "## Tangent lengths\n\nAlong the safe chord, matched by fractions.\n\n" + text


def directions_table() -> str:
    """Errors by direction and interior."""
    choices: list[Choice] = [
        *({"direction": word} for word in ("safe-chord", "chord", "section", "conormal")),
        {"interior": "c1-lines"},
        {"interior": "g2"},
    ]
    matched: Choice = {"correspondence": "fraction"}
    header = ["rms mm", *(" ".join(map(str, choice.values())) for choice in choices)]
    lines = [
        [name, *(f"{error(surface, strips, {**choice, **matched}):.4f}" for choice in choices)]
        for (name, surface, strips), _ in lengths_cases()
    ]
    return "## Directions and interiors\n\nWith arc lengths, matched by fractions.\n\n" + table(
        header, lines
    )


def correspondence_table() -> str:
    """Errors by correspondence; cover and trim shall not be worse than fractions."""
    lines = []
    for name, surface, strips in correspondence_cases():
        cells, found = [], {}
        for rule in CORRESPONDENCES:
            chord, conormal = (
                error(surface, strips, {"correspondence": rule, "direction": word})
                for word in ("safe-chord", "conormal")
            )
            found[rule] = chord
            cells.append(f"{chord:.4f} ({conormal:.4f})")
        limit = TOLERANCE * (found["fraction"] + ROUNDING)
        fine = found["foot-trim"] <= limit and found["foot-cover"] <= limit
        lines.append([name, *cells, met(fine)])
    header = ["rms mm, safe chord (conormal)", *CORRESPONDENCES, "feet no worse than fractions"]
    return "## Correspondence\n\nWith arc lengths.\n\n" + table(header, lines)


def best_time(run: Callable[[], object], repeats: int = 5) -> float:
    """Seconds, the least of several runs."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def random_lines(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit chords and directions leaning from them by some ten degrees."""
    random = np.random.default_rng(3)
    chords = unit(random.normal(size=(count, 3)))
    start, end = (unit(chords + 0.15 * random.normal(size=(count, 3))) for _ in range(2))
    return chords, start, end


def speed_variation(x: FloatArray, control: FloatArray, slopes: FloatArray) -> float:
    """Criterion 1 of one line by the trapezoid rule on 51 places, as one would write it."""
    lengths = np.exp(x)
    scaled = np.stack([control[0], lengths[0] * control[1], lengths[1] * control[2]])
    first, second = slopes @ scaled
    along = np.sum(first * second, axis=1)
    return float(np.trapezoid(along**2 / np.sum(first**2, axis=1), dx=0.02))


def line_by_line(ends: tuple[FloatArray, FloatArray, FloatArray]) -> FloatArray:
    """(n, 2) criterion 1's lengths, each line minimised by itself by scipy's BFGS."""
    v = np.linspace(0.0, 1.0, 51)
    slopes = np.stack([basis(v, order)[:, 1:] for order in (1, 2)])
    # The columns of the basis are those of F_v(0), F_v(1), F(1): put the chord first.
    slopes = slopes[:, :, [2, 0, 1]]
    return np.array(
        [
            np.exp(minimize(speed_variation, np.zeros(2), (np.stack(one), slopes), method="BFGS").x)
            for one in zip(*ends, strict=True)
        ]
    )


def time_table(lines: int, compared: int) -> str:
    """Time of the criteria over many lines, and criterion 1's against line by line."""
    ends = random_lines(lines)
    made = lines_between(*ends)
    arcs = 2.0 / (1.0 + np.clip(made.grams[:, 1:3], 0.0, 1.0))
    some = tuple(one[:compared] for one in ends)
    start = time.perf_counter()
    slow = line_by_line((some[0], some[1], some[2]))
    alone = (time.perf_counter() - start) / compared * lines
    fast = fairest_lengths("criterion1", made, arcs).factors
    away = np.abs(slow - fast[:compared]).max()
    cells = []
    for word in (w for w in LENGTHS if w not in {"arc", "unit", "criterion4"}):
        found = fairest_lengths(word, made, arcs)
        taken = best_time(lambda word=word: fairest_lengths(word, made, arcs))
        ratio = alone / taken
        asked = word == "criterion1"
        cells.append(
            [
                word,
                f"{1e3 * taken:.1f}",
                str(np.count_nonzero(~found.settled)),
                str(np.count_nonzero(found.bounded)),
                f"{ratio:.0f}" if asked else "-",
                f"{LEAST_RATIO:.0f}" if asked else "-",
                met(ratio >= LEAST_RATIO) if asked else "-",
            ]
        )
    header = [f"{lines} lines", "ms", "unsettled", "at bounds", "times faster", "asked", "verdict"]
    return (
        "## Time\n\nCriterion 1 line by line: scipy's BFGS with the trapezoid rule on 51 places, "
        f"{compared} lines timed and scaled, {1e3 * alone:.0f} ms; lengths differ by at most "
        f"{away:.1e}.\n\n" + table(header, cells)
    )


def evaluation_table() -> str:
    """Patches, normals and points of five passes, as a ratio to the one product that F is."""
    (_, _, strips), _ = lengths_cases()[1]
    model = patches_between(arrange(strips), SurfaceSettings())
    ends = natural_parameters(model)
    u, v = np.linspace(ends[0], ends[-1], ROWS), np.linspace(0.0, 1.0, COLUMNS)

    def everything() -> None:
        patches = patches_at(model, u)
        normals = patches.rails.frames[..., 2]
        _ = patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), v).normals

    control, functions = patches_at(model, u).control, basis(v)
    product = best_time(lambda: np.matmul(functions, control), 20)
    whole = best_time(everything, 20)
    cells = [[f"{1e3 * product:.2f}", f"{1e3 * whole:.2f}", f"{whole / product:.1f}"]]
    text = table(["one product, ms", "patches and normals, ms", "ratio"], cells)
    return f"## Evaluation\n\n4 patches of {COLUMNS} by {ROWS} points.\n\n" + text


def main() -> None:
    """Measure and publish."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lines", type=int, default=1000, help="lines of the time's comparison")
    parser.add_argument("--compared", type=int, default=60, help="how many of them one by one")
    arguments = parser.parse_args()
    publish(
        "criteria",
        [
            "# Directions, tangent lengths, correspondence, interiors",
            lengths_table(),
            directions_table(),
            correspondence_table(),
            time_table(arguments.lines, arguments.compared),
            evaluation_table(),
        ],
    )


if __name__ == "__main__":
    main()
