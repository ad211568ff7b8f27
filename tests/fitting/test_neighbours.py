"""Neighbours know each other: exact on circular sections, to the next order on others."""

import numpy as np
import pytest
from laid import placed, plane, ribbon, sphere

from georibbon.fitting.grid import Shape, make_grid
from georibbon.fitting.neighbours import DOUBT, LEAST_SIGMA, REACH, SPACING, relate
from georibbon.fitting.survey import Placed, sample
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.rotations import exp
from georibbon.simulation import (
    LayoutSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
    simulate,
)

GRID = make_grid(ribbon(12))
LENGTH = float(GRID.nodes[-1])
OFFSETS = (-0.2, -0.1, 0.0, 0.1, 0.2)


def misses(here, relation):
    """(k,) metres: what c . (N_i + N_j)/2 is beyond the offset."""
    rows = relation.rows(here)
    return rows.residuals[:, 0] * relation.sigma


def on_sphere(offsets=OFFSETS, radius=0.5):
    shape, origin = sphere(GRID, radius, offsets)
    return placed(GRID, shape, origin)


def over(height, slope, places):
    """Straight passes along x over the section z = height(y)."""
    turns = [exp(np.array([np.arctan(slope(y)), 0.0, 0.0])) for y in places]
    straight = np.zeros((len(places), 2, GRID.coefficients))
    origin = np.array([[0.0, y, height(y)] for y in places])
    return placed(GRID, Shape(np.array(turns), straight), origin)


def backwards(here, which):
    """The same curves, some of them read from the other end."""
    points, frames = here.points.copy(), here.frames.copy()
    about = np.array([-1.0, -1.0, 1.0])
    points[which], frames[which] = points[which, ::-1], frames[which, ::-1] * about
    return Placed(GRID, points, frames, here.moves, here.turns)


def face_down(here, which):
    """The same curves, with the ribbon turned over."""
    frames = here.frames.copy()
    frames[which] *= np.array([1.0, -1.0, -1.0])
    return Placed(GRID, here.points, frames, here.moves, here.turns)


# --- where it is exact ---


@pytest.mark.parametrize("radius", [0.4, 0.7, 3.0])
def test_on_a_sphere_it_is_exact(radius):
    here = on_sphere(radius=radius)
    relation = relate(here, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(misses(here, relation), 0.0, atol=3e-6)
    np.testing.assert_allclose(relation.offset, 0.0, atol=3e-6)
    np.testing.assert_allclose(relation.sigma, least_sigma(chords(here, relation)), rtol=1e-3)


@pytest.mark.parametrize("radius", [0.3, -0.3, 2.0])
def test_along_a_cylinder_it_is_exact(radius):
    angles = np.array([-0.3, -0.1, 0.15, 0.3])  # unevenly spaced, too
    turns = np.array([exp(np.array([angle, 0.0, 0.0])) for angle in angles])
    straight = np.zeros((4, 2, GRID.coefficients))
    here = placed(GRID, Shape(turns, straight), radius * turns[:, :, 2])
    relation = relate(here, [0, 1, 2, 3])
    np.testing.assert_allclose(misses(here, relation), 0.0, atol=1e-12)
    np.testing.assert_allclose(relation.offset, 0.0, atol=1e-10)


def test_on_a_plane_it_is_exact():
    shape, origin = plane(GRID, OFFSETS)
    here = placed(GRID, shape, origin)
    relation = relate(here, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(misses(here, relation), 0.0, atol=1e-13)


# --- elsewhere ---


def inner_miss(height, slope, spacing):
    """(with the offset, without it): metres at the middle one of seven gaps."""
    places = 0.05 + spacing * (np.arange(8) - 3.5)
    here = over(height, slope, places)
    relation = relate(here, list(range(8)))
    middle = (relation.i == 3) | (relation.j == 3)
    middle &= (relation.i == 4) | (relation.j == 4)
    rest = misses(here, relation)[middle]
    return np.abs(rest).max(), np.abs(rest + relation.offset[middle]).max()


def gentle(y):
    """A section whose curvature changes evenly."""
    return 0.4 * y**3 + 0.1 * y**2


def gentle_slope(y):
    return 1.2 * y**2 + 0.2 * y


def test_the_offset_takes_the_third_order_away():
    with_offset, without = np.array(
        [inner_miss(gentle, gentle_slope, spacing) for spacing in (0.1, 0.05)]
    ).T
    assert np.log2(without[0] / without[1]) == pytest.approx(3.0, abs=0.2)
    assert np.log2(with_offset[0] / with_offset[1]) > 4.0
    assert (with_offset < 0.1 * without).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_offset_has_the_sign_of_the_change_of_curvature(sign):
    """-d²/12 (k_b - k_a), k = h'' = 6 a y: -a d³/2."""
    here = over(lambda y: sign * 0.3 * y**3, lambda y: sign * 0.9 * y**2, 0.1 * np.arange(-3, 3))
    relation = relate(here, list(range(6)))
    expected = -sign * 0.3 * 0.1**3 / 2
    inner = (np.minimum(relation.i, relation.j) >= 1) & (np.maximum(relation.i, relation.j) <= 4)
    np.testing.assert_allclose(relation.offset[inner], expected, rtol=0.1)
    # At the rims the curvature is taken to change as it does further in.
    np.testing.assert_allclose(relation.offset[~inner], expected, rtol=0.35)
    least = least_sigma(chords(here, relation))
    np.testing.assert_allclose(relation.sigma, np.hypot(least, DOUBT * relation.offset), rtol=1e-9)


def chords(here, relation):
    """Metres between the related points."""
    one = sample(here, relation.i, relation.at[:, 0]).points
    return np.linalg.norm(sample(here, relation.j, relation.at[:, 1]).points - one, axis=1)


def least_sigma(chord):
    """Contact, and a next order that grows with the cube of the chord."""
    return LEAST_SIGMA * np.hypot(1.0, (chord / REACH) ** 3)


def test_far_passes_hardly_know_each_other():
    near, far = (
        relate(over(lambda y: 0.0 * y, lambda y: 0.0 * y, gap * np.arange(3)), [0, 1, 2])
        for gap in (0.1, 0.6)
    )
    assert near.sigma.max() < 1.1 * LEAST_SIGMA
    assert far.sigma.min() > 50 * LEAST_SIGMA


def test_uneven_gaps_are_counted_as_they_are():
    places = np.array([-0.22, -0.15, -0.05, 0.02, 0.12, 0.2])
    here = over(lambda y: 0.3 * y**3, lambda y: 0.9 * y**2, places)
    relation = relate(here, list(range(6)))
    inner = (np.minimum(relation.i, relation.j) >= 1) & (np.maximum(relation.i, relation.j) <= 4)
    gap = np.diff(places)[np.minimum(relation.i, relation.j)]
    np.testing.assert_allclose(relation.offset[inner], (-0.15 * gap**3)[inner], rtol=0.15)


def test_between_two_passes_alone_nothing_is_known_of_the_change():
    here = over(gentle, gentle_slope, np.array([0.0, 0.1]))
    relation = relate(here, [0, 1])
    np.testing.assert_array_equal(relation.offset, 0.0)


# --- which points ---


def test_points_are_matched_about_every_six_centimetres_across_from_each_other():
    here = on_sphere()
    relation = relate(here, [0, 1, 2, 3, 4])
    count = int(LENGTH / SPACING)
    assert len(relation.i) <= 4 * count
    assert len(relation.i) >= 4 * (count - 1)
    assert {tuple(sorted(pair)) for pair in zip(relation.i, relation.j, strict=True)} == {
        (0, 1), (1, 2), (2, 3), (3, 4),
    }  # fmt: skip
    np.testing.assert_allclose(relation.at[:, 0], relation.at[:, 1], atol=1e-6)
    steps = np.diff(np.sort(relation.at[np.minimum(relation.i, relation.j) == 1, 0]))
    np.testing.assert_allclose(steps, LENGTH / count, atol=1e-9)


def test_only_the_passes_asked_for_are_related():
    relation = relate(on_sphere(), [0, 2, 3])
    assert {tuple(sorted(pair)) for pair in zip(relation.i, relation.j, strict=True)} == {
        (0, 2), (2, 3),
    }  # fmt: skip


def test_the_order_in_which_passes_were_laid_does_not_matter():
    shuffled = on_sphere(offsets=(0.1, -0.2, 0.2, 0.0, -0.1))
    relation = relate(shuffled, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(misses(shuffled, relation), 0.0, atol=3e-6)
    assert {tuple(sorted(pair)) for pair in zip(relation.i, relation.j, strict=True)} == {
        (1, 4), (3, 4), (0, 3), (0, 2),
    }  # fmt: skip


@pytest.mark.parametrize("which", [[1], [0], [0, 3], [4]])
def test_a_pass_laid_backwards_is_related_all_the_same(which):
    forth = over(gentle, gentle_slope, 0.1 * np.arange(-2, 3))
    back = backwards(forth, which)
    one, other = relate(forth, [0, 1, 2, 3, 4]), relate(back, [0, 1, 2, 3, 4])
    assert np.abs(misses(back, other)).max() < 1.5 * np.abs(misses(forth, one)).max()
    forwards = other.at.copy()
    for side, number in enumerate((other.i, other.j)):
        turned = np.isin(number, which)
        forwards[turned, side] = LENGTH - forwards[turned, side]
    np.testing.assert_allclose(forwards[:, 0], forwards[:, 1], atol=1e-6)


@pytest.mark.parametrize("which", [[2], [0, 1]])
def test_a_pass_laid_face_down_is_not_bent_by_its_neighbours(which):
    here = face_down(on_sphere(), which)
    relation = relate(here, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(misses(here, relation), 0.0, atol=3e-6)


def test_a_surface_read_from_inside_is_the_same():
    here = face_down(over(gentle, gentle_slope, 0.1 * np.arange(-2, 3)), [0, 1, 2, 3, 4])
    outside = over(gentle, gentle_slope, 0.1 * np.arange(-2, 3))
    inner, outer = (relate(one, [0, 1, 2, 3, 4]) for one in (here, outside))
    np.testing.assert_allclose(
        np.abs(misses(here, inner)).max(), np.abs(misses(outside, outer)).max(), rtol=1e-6
    )


def test_where_nothing_can_be_matched_there_is_no_relation():
    here = on_sphere()
    assert relate(here, []) is None
    assert relate(here, [2]) is None
    shape, origin = plane(GRID, (0.0, 0.1))
    apart = placed(GRID, shape, origin + np.array([[0.0, 0, 0], [3.0, 0, 0]]))
    assert relate(apart, [0, 1]) is None


def test_half_overlapping_passes_are_related_where_they_overlap():
    shape, origin = plane(GRID, (0.0, 0.1, 0.2))
    here = placed(GRID, shape, origin + np.array([[0.0, 0, 0], [0.5 * LENGTH, 0, 0], [0, 0, 0]]))
    relation = relate(here, [0, 1, 2])
    places = here.points[relation.i, 0, 0] + relation.at[:, 0]
    np.testing.assert_allclose(here.points[relation.j, 0, 0] + relation.at[:, 1], places, atol=1e-6)
    assert 0 < len(relation.i) < 2 * int(LENGTH / SPACING)


# --- what it is worth ---


def normal_error(surface, seed, neighbours):
    """Metres rms along the true normals: the surface's own error."""
    settings = SimulationSettings(
        surface=surface,
        seed=seed,
        ribbon=RibbonSettings(sensors=16, length=0.48),
        layout=LayoutSettings(passes=4),
        survey=SurveySettings(kinds=("starts",)),
        tell_heading=True,
        frames=20,
    )
    made = simulate(settings)
    result = reconstruct(
        made.recording,
        ReconstructionSettings(neighbours=neighbours, surface=None),
        made.truth.calibration,
    )
    out = []
    for one in result.passes:
        true = made.truth.strips[one.name]
        found = np.stack([np.interp(true.s, one.strip.s, x) for x in one.strip.points.T], axis=1)
        out.append(np.sum((found - true.points) * true.normals, axis=1))
    return np.mean(np.square(out))


def test_neighbours_make_surfaces_better_on_average():
    cases = [(surface, seed) for surface in ("dome", "saddle") for seed in (1, 2, 3)]
    alone, together = (
        np.sqrt(np.mean([normal_error(*case, neighbours) for case in cases]))
        for neighbours in (False, True)
    )
    assert together < 0.85 * alone
