"""The source paper's figures done again: their laws, their pictures, and the manual's page."""

import re
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from georibbon.export.paper.pictures import SHORT, picture_of, told_number
from georibbon.geometry.frenet import continued
from georibbon.geometry.settings import SurfaceSettings
from georibbon.paper_figures import NAMES, NUMBERS, Figure, figure
from georibbon.paper_figures.building import (
    crossings_of,
    laid_by,
    laid_plainly,
    shape_numbers,
    tear_ratio,
    verdict_of,
)
from georibbon.paper_figures.curves import (
    binormals,
    flat_arc,
    half_ellipse,
    screw,
    strip_along,
    towards,
    twisted_arc,
    waved,
)
from georibbon.paper_figures.known_surfaces import cone_rows, from_sensors
from georibbon.paper_figures.measured_curves import s_curve_tear
from georibbon.paper_figures.tangents import expected_end_error, helix

ROOT = Path(__file__).resolve().parents[1]
HELP = ROOT / "resources" / "help"
EXACT = (2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 15, 16)  # those that no fit stands behind
TOLERANCE = 0.02  # of a number in the page: computers round differently

sys.path.insert(0, str(ROOT / "packaging" / "paper"))
from paper_page import LANGUAGES, page, picture_name, section  # noqa: E402 - beside the package
from paper_words import FIGURES_FR, PHRASES_FR, SHORT_FR  # noqa: E402 - as above


@cache
def known(number: int) -> Figure:
    """A figure, computed once."""
    return figure(number)


def numbers(number: int, name: str) -> list[float]:
    """One of the numbers of all choices of a figure."""
    return [choice.numbers[name] for choice in known(number).choices]


@pytest.mark.parametrize("number", NUMBERS)
def test_a_figure_tells_numbers_that_are_explained(number):
    found = known(number)
    assert found.number == number
    assert {"paper", "georibbon"} <= {choice.whose for choice in found.choices}
    assert found.of("georibbon").name.startswith(("Georibbon", "A = 1 / tan a"))
    for choice in found.choices:
        assert set(found.main) <= choice.numbers.keys() <= NAMES.keys()
        assert np.isfinite(list(choice.numbers.values())).all()
        assert choice.verdict
    assert set(found.main) <= SHORT.keys() == SHORT_FR.keys() <= NAMES.keys()


def test_the_figures_are_those_of_the_paper():
    assert (*range(2, 14), 15, 16, 17) == NUMBERS


@pytest.mark.parametrize("number", [n for n in NUMBERS if n not in (6, 8, 15)])
def test_the_default_is_whole_everywhere_but_where_nothing_is(number):
    assert known(number).of("georibbon").verdict == "whole"


def test_the_lines_leave_and_arrive_as_fast_as_their_tangents_are_long():
    for choice, (first, last) in zip(
        known(2).choices, [(1, 1), (3, 1), (1, 3), (0.3, 0.3)], strict=False
    ):
        assert choice.numbers["start_speed"] == pytest.approx(first)
        assert choice.numbers["end_speed"] == pytest.approx(last)
    lengths = numbers(2, "line_length")
    assert lengths[3] < lengths[0] < min(lengths[1:3])


def test_two_twisted_arcs_are_joined_squarely_along_their_binormals():
    assert numbers(3, "angle_greatest_deg")[:2] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert min(numbers(3, "sine_least")) > 0.8


def test_binormals_tear_at_an_inflection_and_the_default_does_not():
    paper, default = numbers(4, "tear_ratio")
    assert paper > 15.0
    assert default < 2.0
    assert numbers(4, "normal_jump_deg")[0] == pytest.approx(180.0, abs=2.0)
    assert max(numbers(5, "tear_ratio")) < 2.0
    assert max(numbers(5, "normal_jump_deg")) < 2.0


def test_no_choice_is_whole_where_the_binormal_turns_round():
    facing, kept, chord, safe, default = known(6).choices
    assert facing.numbers["tear_ratio"] > 15.0
    assert chord.numbers["tear_ratio"] > 15.0
    for one in (kept, safe, default):
        assert one.numbers["tear_ratio"] < 3.0
        assert one.numbers["self_crossing_pairs"] > 0.0
    assert all(choice.verdict != "whole" for choice in known(6).choices)


def test_the_cones_formula_holds_with_the_reciprocal_alone():
    *wrong, right = numbers(8, "geodesic_curvature_max_per_m")
    assert wrong == pytest.approx([2.5, 2.3], abs=0.05)
    assert right < 1e-6


def test_shifted_curves_are_no_matter_to_the_default():
    _, chord, default = numbers(9, "rms_mm")
    assert chord < 1e-6
    assert default < 0.005
    binormal, chord, default = numbers(10, "rms_mm")
    assert binormal > 50.0 * chord > 50.0 * default
    binormal, chord, default = numbers(11, "rms_mm")
    assert binormal > 10.0 * chord
    assert default < 1e-4


def test_curves_from_tangents_drift_as_expected():
    assert max(numbers(15, "curve_error_max_mm")) < 0.02
    expected = 1e3 * expected_end_error()
    assert numbers(15, "end_error_mm") == pytest.approx([expected] * 3, rel=0.15)


def test_the_third_criterion_runs_to_its_bounds_and_errs_most():
    *criteria, default = known(7).choices
    errors = [one.numbers["rms_mm"] for one in criteria]
    assert errors[2] > 10.0 * max(errors[0], errors[1], errors[3])
    assert criteria[2].verdict.endswith("at its bounds")
    assert default.numbers["rms_mm"] < 1.5 * min(errors)


def test_measured_binormals_spoil_a_surface_and_the_default_does_not():
    raw, kept, default = known(12).choices
    for one in (raw, kept):
        assert one.verdict.startswith("torn")
        assert one.numbers["normal_rms_deg"] > 8.0 * default.numbers["normal_rms_deg"]
        assert one.numbers["rms_mm"] > 8.0 * default.numbers["rms_mm"]
    assert default.numbers["normal_rms_deg"] < 0.6
    assert default.numbers["rms_mm"] < 0.08
    smoothed, doubled, default = known(13).choices
    assert smoothed.verdict == "torn at inflections"
    assert smoothed.numbers["s_curve_tear_ratio"] > 8.0
    for one in (doubled, default):
        assert one.numbers["s_curve_tear_ratio"] < 1.3
        assert one.numbers["rms_mm"] < 0.3 * smoothed.numbers["rms_mm"]


def test_sensors_limit_a_surface_and_not_the_patches():
    paper, default, sensed = numbers(16, "rms_mm")
    assert default <= paper < 0.05
    assert sensed == pytest.approx(0.32, rel=0.3)


def test_a_fit_to_all_readings_is_nearer_to_the_bonnet():
    for name in ("curves_rms_mm", "normal_rms_deg", "rms_mm", "max_mm"):
        paper, default = numbers(17, name)
        assert default < 0.6 * paper


JETS = (
    half_ellipse(0.1, 0.2, 0.1),
    twisted_arc(0.1, 0.3, 0.02),
    waved(0.0, 0.05, 0.3),
    screw(0.03, 0.6, 1.0),
    flat_arc(0.2, 0.6, 0.6),
)


@pytest.mark.parametrize("jet", JETS)
def test_the_derivatives_of_a_curve_are_those_of_its_points(jet):
    for values, slopes in ((jet.points, jet.first), (jet.first, jet.second)):
        found = np.gradient(values, jet.t, axis=0, edge_order=2)[2:-2]
        assert found == pytest.approx(slopes[2:-2], abs=2e-3 * np.abs(slopes).max())


@pytest.mark.parametrize("jet", JETS)
def test_a_curve_with_its_binormals_is_a_strip(jet):
    strip = strip_along(jet, continued(binormals(jet)))
    steps = np.linalg.norm(np.diff(strip.points, axis=0), axis=1)
    assert np.diff(strip.s) == pytest.approx(steps, rel=1e-3)
    product = np.swapaxes(strip.frames, 1, 2) @ strip.frames
    assert product == pytest.approx(np.broadcast_to(np.eye(3), product.shape), abs=1e-12)
    assert np.linalg.det(strip.frames) == pytest.approx(1.0)
    assert np.abs(np.sum(jet.second * strip.conormals, axis=1)).max() < 1e-9


def test_vectors_are_turned_round_to_agree():
    vectors = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.1], [0.0, 1.0, 0.2], [0.0, 1.0, 0.3]])
    back = np.array([0.0, -1.0, 0.0])
    assert (towards(vectors, np.broadcast_to(back, vectors.shape)) @ back > 0.0).all()


def grid(heights):
    """A grid of points over the unit square, with these heights (k, m), and normals upwards."""
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    return np.stack([x, y, heights], axis=-1), np.broadcast_to([0.0, 0.0, 1.0], (rows, columns, 3))


def test_a_flat_grid_is_whole_and_a_step_in_it_a_tear():
    flat, _ = grid(np.zeros((11, 5)))
    assert tear_ratio(flat[None]) == pytest.approx(1.0)
    heights = np.zeros((11, 5))
    heights[6:] = 1.0
    assert tear_ratio(grid(heights)[0][None]) == pytest.approx(np.hypot(0.1, 1.0) / 0.1)


def test_a_grid_that_goes_through_itself_is_found():
    flat, normals = grid(np.zeros((5, 5)))
    assert crossings_of(flat, normals) == 0.0
    folded = flat.copy()
    folded[:, :, 0] = [[0.0], [0.5], [1.0], [0.55], [0.1]]
    folded[:, :, 2] = [[0.0], [0.0], [0.1], [0.05], [-0.1]]
    assert crossings_of(folded, normals) > 0.0


def test_what_is_wrong_is_said():
    fine = {"tear_ratio": 1.0, "fold_least": 0.9, "self_crossing_pairs": 0.0}
    assert verdict_of(fine) == "whole"
    assert verdict_of(fine | {"tear_ratio": 4.0}) == "torn"
    both = fine | {"fold_least": -0.1, "self_crossing_pairs": 2.0}
    assert verdict_of(both) == "folded, runs through itself"


def test_plain_patches_are_those_of_the_settings():
    _, strips = cone_rows(0.1)
    for direction in ("conormal", "chord"):
        wanted = SurfaceSettings(direction=direction, lengths="unit", correspondence="fraction")
        made, plain = laid_by(strips, wanted), laid_plainly(strips, direction, (1.0, 1.0))
        assert made.points[:, 0] == pytest.approx(plain.points[:, 0], abs=1e-9)
        assert shape_numbers(made)["fold_least"] == pytest.approx(
            shape_numbers(plain)["fold_least"], abs=2e-2
        )


def test_a_strip_turned_over_as_a_whole_lays_the_same_patch():
    _, strips = cone_rows(0.0)
    over = [type(one)(one.s, one.points, one.frames * [1.0, -1.0, -1.0]) for one in strips]
    first, second = (laid_plainly(each, "conormal", (1.0, 1.0)) for each in (strips, over))
    assert first.points == pytest.approx(second.points, abs=1e-12)


def test_exact_sensors_give_the_strip_back():
    _, (strip, _) = cone_rows(0.0)
    found = from_sensors(strip, 0, 0.0)
    inside = slice(10, -10)
    assert found.points[inside] == pytest.approx(strip.points[inside], abs=2e-4)
    worse = from_sensors(strip, 0)
    assert np.abs(worse.points - strip.points).max() > np.abs(found.points - strip.points).max()


def test_the_screw_line_has_unit_speed():
    s = np.linspace(0.0, 0.45, 901)
    points, tangents = helix(s)
    assert points[0].tolist() == [0.0, 0.0, 0.0]
    found = np.gradient(points, s, axis=0)[1:-1]
    assert found == pytest.approx(tangents[1:-1], abs=1e-5)


def test_the_doubled_angle_does_not_turn_over_on_noisy_curves():
    from georibbon.geometry.framing import FramingSettings

    assert s_curve_tear(FramingSettings("raw"), draws=1) > 5.0
    assert s_curve_tear(FramingSettings(), draws=1) < 1.5


@pytest.mark.parametrize(
    ("value", "told"),
    [(0.0, "0"), (1e-9, "< 0.00001"), (0.01234, "0.0123"), (1.0, "1"), (179.96, "180")],
)
def test_numbers_are_told_shortly(value, told):
    assert told_number(value) == told


@pytest.mark.parametrize("number", [9, 15])
def test_a_picture_shows_every_choice(number, tmp_path):
    target = tmp_path / "figure.png"
    target.write_bytes(picture_of(known(number), 600))
    pixels = imread(target)[..., :3]
    assert pixels.shape[1] == 600
    for part in np.array_split(pixels, len(known(number).choices), axis=1):
        assert np.mean(part.min(axis=2) < 0.9) > 0.02


def blocks(text: str) -> dict[int, str]:
    """The sections of the manual's page by their figures' numbers."""
    parts = re.split(r"^## Figure (\d+)\. ", text, flags=re.MULTILINE)
    return {int(number): body for number, body in zip(parts[1::2], parts[2::2], strict=True)}


def split(text: str) -> tuple[str, list[float]]:
    """A text without its numbers, and these; of crossings only whether there are any."""
    text = re.sub(r"(crossings|traversées) 0(?!\d)", r"\1 none", text)
    text = re.sub(r"(crossings|traversées) \d+", r"\1 some", text)
    found = re.findall(r"-?\d+(?:[.,]\d+)?", text)
    return re.sub(r"-?\d+(?:[.,]\d+)?", "#", text), [float(one.replace(",", ".")) for one in found]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_manuals_page_tells_what_is_computed(language):
    text = (HELP / language / "paper.md").read_text(encoding="utf-8")
    told = blocks(text)
    assert tuple(told) == NUMBERS
    for number in EXACT:
        words, values = split(told[number])
        (made,) = blocks(section(known(number), language) + "\n\n").values()
        expected, computed = split(made)
        assert words.strip() == expected.strip()
        assert values == pytest.approx(computed, rel=TOLERANCE, abs=1e-4)
    assert text.startswith(page([], language).rstrip())


def test_the_page_has_its_pictures_and_its_french():
    for number in NUMBERS:
        picture = HELP / "pictures" / f"{picture_name(number)}.png"
        assert 5_000 < picture.stat().st_size < 150_000
    assert tuple(FIGURES_FR) == NUMBERS
    french = (HELP / "fr" / "paper.md").read_text(encoding="utf-8")
    for number in NUMBERS:
        for choice in known(number).choices:
            assert choice.name in PHRASES_FR or re.match(r"A = |λ0 = ", choice.name)
            assert set(choice.verdict.split(", ")) <= PHRASES_FR.keys()
    assert "whole" not in french
    assert "default" not in french
