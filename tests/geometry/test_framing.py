"""Strips from curves as they come: exact ones stay, noisy ones are smoothed, bad ones refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.errors import SettingsError, SurfaceError
from georibbon.geometry.correspondence import aligned
from georibbon.geometry.frames import Strip, arc_angles, dot
from georibbon.geometry.framing import (
    FramingSettings,
    arc_length,
    faced,
    faced_as,
    frame_curve,
    framed,
    noise_of,
    position_cut,
)
from georibbon.geometry.geodesics import directions_at, geodesics
from georibbon.geometry.penalised import penalised_spline
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.settings import NORMAL_RULES
from georibbon.rotations import exp

S = np.linspace(0.0, 0.8, 161)


def paths(s=S):
    """Three geodesics of a bonnet side by side."""
    starts = np.array([[0.1, -0.1], [0.1, 0.0], [0.1, 0.1]])
    ahead = directions_at(Bonnet(), starts, np.full(3, 0.1))
    return geodesics(Bonnet(), starts, ahead, s - s[0] - 0.4)


PATH = paths()[1]


def noisy(values, noise, seed=0):
    return values + noise * np.random.default_rng(seed).normal(size=values.shape)


def degrees(a, b):
    """The greatest angle between vectors."""
    return np.degrees(arc_angles(a, b).max())


def test_an_exact_strip_comes_back():
    found = frame_curve(PATH.points, PATH.s + 3.0, PATH.normals)
    assert (found.position_cut, found.normal_cut, found.measured) == (0.0, 0.0, True)
    assert found.noise < 1e-12
    np.testing.assert_allclose(found.strip.s, PATH.s, atol=1e-12)
    np.testing.assert_array_equal(found.strip.points, PATH.points)
    np.testing.assert_allclose(found.strip.frames, PATH.frames, atol=1e-6)


def test_without_arc_length_and_normals_it_is_nearly_as_good():
    strip = framed(PATH.points)
    np.testing.assert_allclose(strip.s, PATH.s, atol=1e-9)
    side = np.sign(dot(strip.normals, PATH.normals)[0])
    assert degrees(side * strip.normals, PATH.normals) < 0.01


def test_the_arc_lengths_error_falls_with_a_high_power_of_the_spacing():
    errors = []
    for count in (11, 21, 41):
        s = np.linspace(0.0, 0.8, count)
        errors.append(np.abs(arc_length(paths(s)[1].points) - s).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert errors[-1] < 1e-7
    assert (orders > 3.5).all()


@pytest.mark.parametrize("noise", [1e-6, 1e-4, 2e-3])
def test_the_noise_is_told_whatever_the_sampling(noise):
    uneven = np.sort(np.random.default_rng(3).uniform(0.0, 0.8, 200))
    for s in (S, uneven[np.concatenate([[True], np.diff(uneven) > 1e-3])]):
        points = paths(s)[1].points
        found = [noise_of(s, noisy(points, noise, seed)) for seed in range(8)]
        assert np.mean(found) == pytest.approx(noise, rel=0.15)


def test_the_noise_is_told_where_the_arc_length_is_the_points_own():
    found = [frame_curve(noisy(PATH.points, 1e-4, seed)).noise for seed in range(8)]
    assert np.mean(found) == pytest.approx(1e-4, rel=0.15)


def test_exact_curves_have_no_noise_even_where_points_are_few():
    for count, most in ((161, 1e-12), (41, 2e-8), (20, 1e-5)):
        s = np.linspace(0.0, 0.8, count)
        assert noise_of(s, paths(s)[1].points) < most
    assert noise_of(S[:12], noisy(PATH.points[:12], 1e-3)) == 0.0


@pytest.mark.parametrize("noise", [1e-5, 1e-4])
def test_noise_is_smoothed_by_itself_and_the_strip_is_nearer_to_the_truth(noise):
    rough = noisy(PATH.points, noise)
    found = frame_curve(rough, PATH.s)
    assert 0.02 < found.position_cut < found.normal_cut < 0.4
    error = np.linalg.norm(found.strip.points - PATH.points, axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.6 * np.sqrt(3.0) * noise
    side = np.sign(dot(found.strip.normals, PATH.normals)[80])
    raw = framed(rough, PATH.s, settings=FramingSettings("raw", 0.0, 0.0))
    angles = np.degrees(arc_angles(side * found.strip.normals, PATH.normals))
    assert np.sqrt(np.mean(angles**2)) < 2.0
    assert degrees(raw.normals, PATH.normals) > 45.0


@pytest.mark.parametrize("noise", [1e-5, 1e-4])
def test_the_smoothing_of_points_leaves_so_much_curvature_of_their_noise(noise):
    s, left = np.linspace(0.0, 4.0, 801), []
    cut = position_cut(s, noise)
    inside = (s > cut) & (s < 4.0 - cut)
    for seed in range(20):
        smooth = penalised_spline(s, noisy(np.zeros((len(s), 3)), noise, seed), cut, order=3)
        left.append(smooth(s[inside], nu=2))
    assert np.sqrt(np.mean(np.square(left))) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("size", [1.0, 0.1, 0.01])
def test_normals_of_exact_curves_are_as_good_on_small_objects(size):
    found = framed(size * PATH.points)
    side = np.sign(dot(found.normals, PATH.normals)[0])
    assert degrees(side * found.normals, PATH.normals) < 0.02


def test_normals_of_noisy_curves_follow_small_objects_too():
    wrong = []
    for seed in range(4):
        found = framed(noisy(0.1 * PATH.points, 1e-6, seed))
        side = np.sign(dot(found.normals, PATH.normals)[80])
        wrong.append(np.degrees(arc_angles(side * found.normals, PATH.normals)))
    assert np.sqrt(np.mean(np.square(wrong))) < 0.45


def test_noise_does_not_lengthen_a_smoothed_curve():
    rough = noisy(PATH.points, 5e-4)
    assert arc_length(rough)[-1] > 1.01 * PATH.s[-1]
    assert framed(rough).s[-1] == pytest.approx(PATH.s[-1], rel=4e-3)


def test_no_smoothing_is_done_where_none_is_wanted():
    rough = noisy(PATH.points, 1e-4)
    found = frame_curve(
        rough, PATH.s, PATH.normals, FramingSettings(normal_cut=0.0, position_cut=0.0)
    )
    np.testing.assert_array_equal(found.strip.points, rough)
    assert (found.position_cut, found.normal_cut) == (0.0, 0.0)
    assert found.noise == pytest.approx(1e-4, rel=0.2)


def rolled(strip, angle):
    """The strip's normals turned about its tangents."""
    turn = exp(angle[:, None] * strip.tangents)
    return np.einsum("nij,nj->ni", turn, strip.normals)


def test_a_wave_of_roll_as_long_as_the_cut_is_halved():
    wave = 0.05 * np.sin(2 * np.pi * PATH.s / 0.1)
    settings = FramingSettings(normal_cut=0.1)
    found = framed(PATH.points, PATH.s, rolled(PATH, wave), settings)
    inside = slice(40, -40)
    left = np.arcsin(dot(found.normals, PATH.conormals))[inside]
    wave = np.arcsin(dot(rolled(PATH, wave), PATH.conormals))[inside]
    assert left @ wave / (wave @ wave) == pytest.approx(0.5, abs=0.02)


def test_noisy_normals_are_smoothed_by_themselves():
    rough = rolled(PATH, noisy(np.zeros(len(S)), np.radians(0.5)))
    found = frame_curve(PATH.points, PATH.s, rough)
    assert 0.02 < found.normal_cut < 0.8
    before, after = (np.degrees(arc_angles(n, PATH.normals)) for n in (rough, found.strip.normals))
    assert np.sqrt(np.mean(after**2)) < 0.4 * np.sqrt(np.mean(before**2))


def test_normals_of_any_length_are_made_square():
    tilted = 7.0 * PATH.normals + 3.0 * PATH.tangents
    found = framed(PATH.points, PATH.s, tilted)
    np.testing.assert_allclose(found.frames, PATH.frames, atol=1e-6)


@pytest.mark.parametrize("measured", [True, False])
def test_a_rigid_motion_moves_the_strip_along(measured):
    turn, shift = exp(np.array([0.5, -0.3, 1.2])), np.array([2.0, -1.0, 0.5])
    rough = noisy(PATH.points, 1e-5)
    normals = PATH.normals if measured else None
    still = framed(rough, None, normals)
    moved = framed(rough @ turn.T + shift, None, normals if normals is None else normals @ turn.T)
    np.testing.assert_allclose(moved.points, still.points @ turn.T + shift, atol=1e-9)
    side = np.sign(dot(moved.normals, still.normals @ turn.T)[0])
    np.testing.assert_allclose(moved.normals, side * still.normals @ turn.T, atol=1e-4)


@pytest.mark.parametrize("measured", [True, False])
def test_backwards_it_is_the_strip_reversed(measured):
    rough = noisy(PATH.points, 1e-5)
    normals = PATH.normals if measured else None
    ahead = framed(rough, None, normals).reversed()
    back = framed(rough[::-1], None, None if normals is None else normals[::-1])
    side = np.sign(dot(back.normals, ahead.normals)[0])
    np.testing.assert_allclose(back.s, ahead.s, atol=1e-9)
    np.testing.assert_allclose(back.points, ahead.points, atol=1e-9)
    np.testing.assert_allclose(side * back.normals, ahead.normals, atol=1e-4)


def flipped(strip):
    return aligned(strip, False, True)


def test_found_normals_take_the_side_of_measured_ones():
    one, two, three = paths()
    given = [flipped(one), flipped(two), three.reversed()]
    mended = faced(given, [True, False, True])
    assert mended[1] is given[1]
    for strip in mended:
        assert (strip.normals[:, 2] < 0).all()
    np.testing.assert_allclose(mended[2].points, given[2].points)


def test_where_nothing_is_measured_they_face_up():
    one, two, three = paths()
    for mixed in ([one, flipped(two), three], [flipped(one), flipped(two), flipped(three)]):
        for strip in faced(mixed, [True] * 3):
            assert (strip.normals[:, 2] > 0).all()
    low = [flipped(one), flipped(two), three]
    kept = faced(low, [False] * 3)
    assert all(a is b for a, b in zip(kept, low, strict=True))


def test_a_tie_takes_the_side_of_what_it_crosses():
    strips = paths()
    tie = geodesics(Bonnet(), np.array([[0.1, 0.0]]), np.array([[0.0, 1.0, 0.0]]), S - 0.4)[0]
    for one in (tie, flipped(tie)):
        assert (faced_as(one, strips).normals[:, 2] > 0).all()


def test_straight_stretches_of_found_normals_are_told():
    x = np.linspace(0.0, 1.0, 101)
    bent = np.stack([x, 0 * x, 0.3 * np.maximum(x - 0.5, 0.0) ** 3], axis=1)
    found = frame_curve(bent)
    ((start, end),) = found.straight
    assert start == 0.0
    assert 0.4 < end < 0.6
    upright = np.tile([0.0, 0.0, 1.0], (101, 1))
    assert frame_curve(bent, None, upright).straight == ()


@pytest.mark.parametrize("noise", [1e-5, 1e-4, 1e-3])
def test_a_line_with_noise_is_told_as_straight_however_much_it_is_smoothed(noise):
    line = np.linspace(0.0, 1.0, 101)[:, None] * [1.0, 0.0, 0.0]
    ((start, end),) = frame_curve(noisy(line, noise)).straight
    assert end - start > 0.9


LINE = np.stack([S, 0 * S, 0.1 * S**2], axis=1)
UP = np.tile([0.0, 0.0, 1.0], (len(S), 1))


def changed(values, row, value):
    values = values.copy()
    values[row] = value
    return values


@pytest.mark.parametrize(
    ("points", "s", "normals", "told"),
    [
        (LINE[:3], None, None, "it has 3 points, at least 4"),
        (LINE[:, :2], None, None, "it has 161 points"),
        (changed(LINE, 7, LINE[6]), None, None, "points 7 and 8 are the same"),
        (changed(LINE, 7, np.nan), None, None, "coordinates are finite"),
        (LINE, changed(S, 5, S[4]), None, "does not ascend from point 5 to 6"),
        (LINE, S[::-1], None, "does not ascend"),
        (LINE, changed(S, 5, np.inf), None, "arc lengths are finite"),
        (LINE, S[:-1], None, "161 points and 160 arc lengths"),
        (LINE, 1e3 * S, None, "same unit"),
        (LINE, 1.1 * S, None, "arc length runs over"),
        (LINE, None, UP[:-1], "161 points and 160 normals"),
        (LINE, None, changed(UP, 3, np.nan), "normals are finite"),
        (LINE, None, changed(UP, 3, 0.0), "normal at point 4 is zero"),
        (LINE, None, UP[:, [2, 0, 1]], "normal at point 1 is zero or lies along"),
        (S[:, None] * [1.0, 0.0, 0.0], None, None, "straight from end to end"),
    ],
)
def test_what_is_no_curve_is_refused(points, s, normals, told):
    with pytest.raises(SurfaceError, match=told):
        framed(points, s, normals)


@pytest.mark.parametrize(
    "wrong",
    [{"normals": "nice"}, {"normal_cut": -0.1}, {"position_cut": np.nan}, {"normal_cut": 11.0}],
)
def test_settings_that_mean_nothing_are_refused(wrong):
    with pytest.raises(SettingsError):
        replace(FramingSettings(), **wrong)


def test_few_points_are_enough():
    for count in (4, 5, 6, 7):
        s = np.linspace(0.0, 0.3, count)
        arc = np.stack([np.sin(s), 0 * s, np.cos(s)], axis=1)
        strip = framed(arc)
        assert isinstance(strip, Strip)
        assert abs(strip.s[-1] - 0.3) < 1e-4
        assert degrees(strip.normals * np.sign(strip.normals[0, 2]), arc) < 1.0


SHAPES = st.sampled_from(["any", "grid", "walk", "steps", "back", "corner"])


@given(
    SHAPES,
    st.integers(4, 30),
    st.integers(0, 10_000),
    st.booleans(),
    st.sampled_from(NORMAL_RULES),
    st.sampled_from([None, 0.0, 1e-9, 0.01, 10.0]),
    st.sampled_from([None, 0.0, 1e-9, 0.01, 10.0]),
)
def test_any_points_give_frames_or_a_refusal(shape, count, seed, measured, rule, normal, position):
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, count)
    points = {
        "any": rng.normal(size=(count, 3)),
        "grid": rng.integers(-2, 3, size=(count, 3)).astype(float),
        "walk": np.cumsum(rng.normal(size=(count, 3)), axis=0),
        "steps": np.cumsum(10.0 ** rng.uniform(-9, 0, size=count))[:, None] ** [1.0, 2.0, 0.5],
        "back": np.stack([np.abs(t - 0.5), 0 * t, 1e-9 * rng.normal(size=count)], axis=1),
        "corner": np.stack([t, np.where(t < 0.5, 0.0, 1.0), 0 * t], axis=1),
    }[shape]
    normals = rng.normal(size=(count, 3)) if measured else None
    try:
        strip = framed(points, None, normals, FramingSettings(rule, normal, position))
    except SurfaceError:
        return
    assert np.isfinite(strip.points).all()
    np.testing.assert_allclose(np.linalg.det(strip.frames), 1.0, atol=1e-6)
    assert (np.diff(strip.s) > 0.0).all()
