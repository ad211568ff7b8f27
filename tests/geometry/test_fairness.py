"""Laws of the tangent length criteria: exact derivatives, true minima, symmetry, invariance."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from georibbon.geometry.fairness import (
    BOX,
    CRITERIA,
    CURVATURE_FLOOR,
    TORSION_FLOOR,
    Lines,
    Quadrature,
    anchored,
    fairest_lengths,
    lines_between,
)
from georibbon.geometry.frames import unit

NAMES = sorted(CRITERIA)
ROUGH = ("criterion2", "criterion3")  # with several minima
PLACES, WEIGHTS = np.polynomial.legendre.leggauss(16)
V, WEIGHTS = 0.5 * (PLACES + 1.0), 0.5 * WEIGHTS


def random_ends(count: int, spread: float = 0.3, seed: int = 1) -> tuple[np.ndarray, ...]:
    """Unit chords and directions (n, 3) that lean from them by about `spread`."""
    random = np.random.default_rng(seed)
    chords = unit(random.normal(size=(count, 3)))
    leaning = (unit(chords + spread * random.normal(size=(count, 3))) for _ in range(2))
    return (chords, *leaning)


def arcs_of(lines: Lines) -> np.ndarray:
    return 2.0 / (1.0 + lines.grams[:, 1:3])


def derivatives(v: np.ndarray, ends: tuple[np.ndarray, ...], lengths: np.ndarray) -> list:
    """F', F'', F''' (m, 3) of the Hermite cubic, written out by itself."""
    c, t0, t1 = ends[0], lengths[0] * ends[1], lengths[1] * ends[2]
    cube, square = t0 + t1 - 2.0 * c, 3.0 * c - 2.0 * t0 - t1
    v = v[:, None]
    return [t0 + 2 * v * square + 3 * v**2 * cube, 2 * square + 6 * v * cube, 6 * cube + 0 * v]


def speed(v: np.ndarray, ends: tuple, lengths: np.ndarray) -> np.ndarray:
    return np.linalg.norm(derivatives(v, ends, lengths)[0], axis=1)


def bend(v: np.ndarray, ends: tuple, lengths: np.ndarray) -> np.ndarray:
    """The curvature vector (m, 3)."""
    first, second, _ = derivatives(v, ends, lengths)
    along = np.sum(first * second, axis=1) / np.sum(first**2, axis=1)
    return (second - along[:, None] * first) / np.sum(first**2, axis=1)[:, None]


def rate(of: Callable[..., np.ndarray], *more: object) -> np.ndarray:
    return (of(V + 1e-5, *more) - of(V - 1e-5, *more)) / 2e-5


def written_out(name: str, ends: tuple, lengths: np.ndarray) -> float:
    """A criterion from its definition, derivatives by v as differences."""
    length = WEIGHTS @ speed(V, ends, lengths)
    if name == "criterion1":
        return float(WEIGHTS @ rate(speed, ends, lengths) ** 2)
    if name == "criterion2":
        return float(
            WEIGHTS @ rate(lambda *a: np.linalg.norm(bend(*a), axis=1), ends, lengths) ** 2
        )
    if name == "criterion3":
        first, second, third = derivatives(V, ends, lengths)
        cross = np.cross(first, second)
        floor = np.sum(cross**2, axis=1) + TORSION_FLOOR
        return float(WEIGHTS @ (np.sum(cross * third, axis=1) / floor) ** 2)
    if name == "bending":
        bent = np.sum(bend(V, ends, lengths) ** 2, axis=1)
        return float(length * (WEIGHTS @ (bent * speed(V, ends, lengths))))
    change, ahead = rate(bend, ends, lengths), unit(derivatives(V, ends, lengths)[0])
    squared = np.sum(np.cross(change, ahead) ** 2, axis=1)
    if name == "curvature-variation":
        return float(length**3 * (WEIGHTS @ (squared / speed(V, ends, lengths))))
    return float(WEIGHTS @ squared)


@pytest.mark.parametrize("name", NAMES)
def test_criteria_are_what_they_are_called(name: str) -> None:
    """The literal curvature has a corner where it vanishes; its floor shows there."""
    ends = random_ends(40)
    x = np.random.default_rng(2).normal(0.0, 0.3, (40, 2))
    found = Quadrature(CRITERIA[name], 16)(lines_between(*ends), x)[0]
    expected = [
        written_out(name, tuple(one[k] for one in ends), np.exp(x[k])) for k in range(len(x))
    ]
    close = np.isclose(found, expected, rtol=1e-4)
    assert close.all() if name != "criterion2" else np.mean(close) > 0.7
    assert CURVATURE_FLOOR < 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_gradients_and_hessians_are_those_of_the_criterion(name: str) -> None:
    lines = lines_between(*random_ends(60))
    anchors = np.log(arcs_of(lines))
    rule, x, h = Quadrature(CRITERIA[name], 8), anchors + 0.2, 1e-5
    jet = anchored(rule, lines, x, anchors)
    for k in range(2):
        step = h * np.eye(2)[k]
        change = anchored(rule, lines, x + step, anchors) - anchored(rule, lines, x - step, anchors)
        for exact, part in ((jet[1 + k], 0), (jet[3 + k], 1), (jet[4 + k], 2)):
            scale = np.abs(exact).max()
            assert np.abs(change[part] / (2.0 * h) - exact).max() < 1e-6 * scale


@pytest.mark.parametrize("name", [name for name in NAMES if name not in ROUGH])
def test_minima_are_those_that_a_general_method_finds_line_by_line(name: str) -> None:
    lines = lines_between(*random_ends(12, 0.2, seed=5))
    arcs = arcs_of(lines)
    found = fairest_lengths(name, lines, arcs)
    assert found.settled.all()
    assert not found.bounded.any()
    for k in range(len(arcs)):
        one, anchor = lines[k : k + 1], np.log(arcs[k : k + 1])
        rule = Quadrature(CRITERIA[name], 8)
        best = minimize(
            lambda x, rule=rule, one=one, anchor=anchor: anchored(rule, one, x[None], anchor)[0, 0],
            anchor[0],
            method="Nelder-Mead",
            options={"xatol": 1e-8, "fatol": 1e-14},
        )
        assert np.abs(np.exp(best.x) - found.factors[k]).max() < 1e-5


@pytest.mark.parametrize("name", NAMES)
def test_what_settled_lies_where_no_step_leads_down(name: str) -> None:
    """At a bound, or where the gradient vanishes; and never higher than the arc."""
    lines = lines_between(*random_ends(200, 0.2))
    arcs = arcs_of(lines)
    found = fairest_lengths(name, lines, arcs)
    assert np.mean(found.settled) > (0.9 if name == "criterion3" else 0.99)
    rule = Quadrature(CRITERIA[name], 16 if lines.grams[:, 1:3].min() < 0.7 else 8)
    x = np.log(found.factors)
    jet = anchored(rule, lines, x, np.log(arcs))
    down = np.where(jet[1:3].T > 0.0, x > -BOX + 1e-9, x < BOX - 1e-9) * jet[1:3].T
    scale = 1.0 + np.abs(jet[[3, 5]].T)
    assert np.abs(down / scale)[found.settled].max() < 1e-6
    start = anchored(rule, lines, np.log(arcs), np.log(arcs))
    assert (jet[0] <= start[0] * (1.0 + 1e-9) + 1e-12).all()


@pytest.mark.parametrize("name", NAMES)
def test_lines_run_backwards_have_the_same_lengths_swapped(name: str) -> None:
    chords, start, end = random_ends(100, 0.25)
    lines, back = lines_between(chords, start, end), lines_between(-chords, -end, -start)
    plain = fairest_lengths(name, lines, arcs_of(lines))
    other = fairest_lengths(name, back, arcs_of(back))
    both = plain.settled & other.settled
    assert np.mean(both) > 0.8
    away = np.abs(plain.factors[both] - other.factors[both][:, ::-1])
    assert np.mean(away < 1e-5) > 0.98


@pytest.mark.parametrize("name", NAMES)
def test_a_straight_line_keeps_the_length_of_its_chord(name: str) -> None:
    chords = random_ends(1)[0]
    lines = lines_between(chords, chords, chords)
    found = fairest_lengths(name, lines, np.ones((1, 2)))
    assert found.settled.all()
    assert np.allclose(found.factors, 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "k", "rel"),
    [
        ("criterion1", 1 / 6, 0.02),
        ("criterion2-vector", 1 / 4, 0.05),
        ("bending", 1 / 4, 0.05),
        ("curvature-variation", 1 / 4, 0.05),
    ],
)
def test_on_flat_arcs_the_lengths_grow_with_the_square_of_the_half_turn(
    name: str, k: float, rel: float
) -> None:
    b = 0.2
    chord = np.array([[1.0, 0.0, 0.0]])
    start, end = (np.array([[np.cos(b), side * np.sin(b), 0.0]]) for side in (1.0, -1.0))
    lines = lines_between(chord, start, end)
    found = fairest_lengths(name, lines, arcs_of(lines))
    assert np.allclose((found.factors - 1.0) / b**2, k, rtol=rel)


def test_many_lines_are_done_as_few() -> None:
    lines = lines_between(*random_ends(1500, 0.15))
    whole = fairest_lengths("bending", lines, arcs_of(lines)).factors
    part = slice(1200, 1220)
    assert np.allclose(
        fairest_lengths("bending", lines[part], arcs_of(lines)[part]).factors,
        whole[part],
        atol=1e-7,
    )


def test_no_lines_have_no_lengths() -> None:
    nothing = np.zeros((0, 3))
    found = fairest_lengths("criterion1", lines_between(nothing, nothing, nothing), np.ones((0, 2)))
    assert found.factors.shape == (0, 2)
