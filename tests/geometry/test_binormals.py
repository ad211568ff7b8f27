"""Normals from how a curve bends: exact, noisy, through inflections, along straights."""

from itertools import pairwise

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.binormals import (
    bend_of,
    doubled_angle,
    least_squares,
    normals_from_bend,
    runs,
    straight_stretches,
)
from georibbon.geometry.frames import dot
from georibbon.geometry.frenet import continuity, curvature_vectors, curve_through
from georibbon.geometry.geodesics import directions_at, geodesic
from georibbon.geometry.reference import Bonnet, Cylinder
from georibbon.geometry.settings import NORMAL_RULES
from georibbon.rotations import exp

S = np.linspace(0.0, 0.8, 201)
every_rule = pytest.mark.parametrize("rule", NORMAL_RULES)


def path(angle=0.4):
    """A geodesic of a bonnet with inflections, 4 mm from point to point."""
    surface, start = Bonnet(), np.array([[0.1, 0.2]])
    direction = directions_at(surface, start, np.array([angle]))[0]
    found = geodesic(surface, start[0], direction, S - 0.4)
    return found


def bend(points, s=S, cut=0.0):
    curve = curve_through(s, points, cut)
    return bend_of(s, curve(s), *curvature_vectors(curve, s))


def wrong(normals, truth):
    """Degrees between normals whatever their signs."""
    return np.degrees(np.arccos(np.clip(np.abs(dot(normals, truth)), 0.0, 1.0)))


def wave(s=S):
    """A plane curve that bends to both sides, at points by its own length, nearly."""
    return np.stack([s, 0.02 * np.cos(2 * np.pi * s / 0.4), 0 * s], axis=1)


def noisy(points, noise, seed=0):
    return points + noise * np.random.default_rng(seed).normal(size=points.shape)


def test_the_frame_does_not_turn_and_holds_the_whole_bend():
    found = bend(path().points)
    curve = curve_through(S, path().points)
    _, bent = curvature_vectors(curve, S)
    held = found.along[:, None] * found.first + found.across[:, None] * found.second
    np.testing.assert_allclose(held, bent, atol=1e-9)
    np.testing.assert_allclose(found.curvature, np.linalg.norm(bent, axis=1), atol=1e-9)
    np.testing.assert_allclose(np.cross(found.tangents, found.first), found.second, atol=1e-12)


def test_rolls_and_normals_are_each_others_inverse():
    found = bend(path().points)
    roll = 0.3 + 9.0 * S
    np.testing.assert_allclose(found.roll(found.normals(roll)), roll, atol=1e-12)


@every_rule
def test_exact_curves_of_a_surface_give_its_normals(rule):
    truth = path()
    found = normals_from_bend(bend(truth.points), rule, 0.04)
    assert wrong(found, truth.normals)[3:-3].max() < (0.2 if rule == "spline" else 0.05)


@every_rule
def test_they_are_unit_and_square_to_the_curve(rule):
    found = bend(noisy(path().points, 1e-5), cut=0.03)
    normals = normals_from_bend(found, rule, 0.1)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    np.testing.assert_allclose(dot(normals, found.tangents), 0.0, atol=1e-12)


@every_rule
def test_they_turn_with_the_curve_and_do_not_depend_on_its_place(rule):
    points = noisy(path().points, 1e-6)
    turn = exp(np.array([0.2, 1.4, -0.5]))
    still = normals_from_bend(bend(points, cut=0.02), rule, 0.1)
    moved = normals_from_bend(bend(points @ turn.T + [3.0, -1.0, 2.0], cut=0.02), rule, 0.1)
    sign = np.sign(dot(moved, still @ turn.T)[0])
    np.testing.assert_allclose(moved, sign * still @ turn.T, atol=1e-5)


@every_rule
def test_backwards_they_are_the_same_up_to_one_sign(rule):
    points = noisy(path().points, 1e-6)
    ahead = normals_from_bend(bend(points, cut=0.02), rule, 0.1)
    back = normals_from_bend(bend(points[::-1], cut=0.02), rule, 0.1)[::-1]
    sign = np.sign(dot(back, ahead)[0])
    np.testing.assert_allclose(back, sign * ahead, atol=1e-5)


def test_without_noise_only_the_raw_ones_turn_over_at_an_inflection():
    found = bend(wave())
    turned = continuity(normals_from_bend(found, "raw", 0.1)).flips
    np.testing.assert_allclose(S[turned], [0.1, 0.3, 0.5, 0.7], atol=0.0041)
    for rule in ("doubled-angle", "spline", "continuous"):
        assert continuity(normals_from_bend(found, rule, 0.1)).greatest_turn < 0.021


@pytest.mark.parametrize("noise", [1e-6, 1e-5])
def test_in_noise_the_doubled_angle_does_not_tear_where_the_plain_rule_does(noise):
    """The normals of a plane curve all lie in its plane: a turn away from it is a tear."""
    turns = {"doubled-angle": [], "continuous": []}
    for seed in range(5):
        found = bend(noisy(wave(), noise, seed), cut=0.02 if noise < 5e-6 else 0.04)
        for rule, seen in turns.items():
            seen.append(continuity(normals_from_bend(found, rule, 0.1)).greatest_turn)
    assert max(turns["doubled-angle"]) < np.radians(2.0)
    assert max(turns["continuous"]) > np.radians(20.0)


def test_in_noise_the_doubled_angle_is_nearest_to_the_truth():
    truth = path()
    errors = {rule: [] for rule in NORMAL_RULES}
    for seed in range(4):
        found = bend(noisy(truth.points, 1e-5, seed), cut=0.07)
        for rule, seen in errors.items():
            seen.append(wrong(normals_from_bend(found, rule, 0.15), truth.normals))
    rms = {rule: np.sqrt(np.mean(np.square(seen))) for rule, seen in errors.items()}
    assert rms["doubled-angle"] < 1.0
    assert rms["doubled-angle"] < 0.3 * min(rms["spline"], rms["raw"], rms["continuous"])


def test_the_steps_towards_no_geodesic_curvature_come_to_rest(monkeypatch):
    found = bend(noisy(path().points, 1e-5), cut=0.04)
    rolls = []
    for steps in (0, 2, 3, 4):
        monkeypatch.setattr("georibbon.geometry.binormals.STEPS", steps)
        rolls.append(doubled_angle(found, 0.1))
    moved = [np.abs(b - a).max() for a, b in pairwise(rolls)]
    assert moved[0] > 1e-3
    assert moved[2] < 1e-5 < moved[0]


def bent_straight_bent():
    """An arc, a straight of 0.4 m and an arc in the plane at 70 degrees about it."""
    s = np.linspace(0.0, 1.0, 251)
    radius, turn = 0.3, np.radians(70.0)
    before, after = np.minimum(s - 0.3, 0.0), np.maximum(s - 0.7, 0.0)
    x = np.clip(s, 0.3, 0.7) + radius * (np.sin(before / radius) + np.sin(after / radius))
    up = radius * (1 - np.cos(before / radius))
    aside = radius * (1 - np.cos(after / radius))
    points = np.stack([x, aside * np.sin(turn), up + aside * np.cos(turn)], axis=1)
    return s, points, turn


def test_over_a_straight_stretch_they_turn_smoothly_and_it_is_told():
    s, points, turn = bent_straight_bent()
    found = bend(points, s)
    roll = doubled_angle(found, 0.05)
    assert abs(roll[-1] - roll[0]) == pytest.approx(turn, abs=0.02)
    rate = np.gradient(roll, s)
    middle = (s > 0.36) & (s < 0.64)
    assert (np.sign(rate[middle]) == np.sign(rate[middle][0])).all()
    assert np.abs(rate).max() < 1.6 * turn / 0.4
    ((start, end),) = straight_stretches(found, 0.05)
    assert (start, end) == (pytest.approx(0.3, abs=0.05), pytest.approx(0.7, abs=0.05))
    assert straight_stretches(found, 0.25) == ()
    assert len(straight_stretches(found, 0.0)) == 1


def test_beyond_the_last_bend_they_go_on_turning_as_they_did():
    """A screw that runs out straight: its normal turns about it by its torsion."""
    radius, pitch = 0.2, 0.1
    speed = np.hypot(radius, pitch)
    s = np.linspace(0.0, 1.0, 401)
    t = np.minimum(s, 0.6) / speed
    ahead = np.maximum(s - 0.6, 0.0)[:, None] / speed
    slope = np.stack([-radius * np.sin(t), radius * np.cos(t), pitch + 0 * t], axis=1)
    points = np.stack([radius * np.cos(t), radius * np.sin(t), pitch * t], axis=1) + ahead * slope
    roll = doubled_angle(bend(points, s), 0.1)
    rate = np.gradient(roll, s)
    np.testing.assert_allclose(np.abs(rate[20:200]), pitch / speed**2, rtol=1e-3)
    np.testing.assert_allclose(np.abs(rate[280:]), pitch / speed**2, rtol=0.15)
    np.testing.assert_allclose(rate[300:], rate[-1], rtol=1e-3)


def test_a_passing_inflection_is_no_straight_stretch():
    assert straight_stretches(bend(wave()), 0.02) == ()


@every_rule
def test_where_a_curve_is_exactly_straight_the_nearest_bend_counts(rule):
    angle = np.maximum(S - 0.4, 0.0) / 0.3
    found = bend(np.stack([S, 0 * S, 0 * S], axis=1))
    found = type(found)(S, found.tangents, found.first, found.second, angle, angle)
    normals = normals_from_bend(found, rule, 0.1)
    expected = found.normals(np.full(len(S), np.pi / 4))
    np.testing.assert_allclose(np.abs(dot(normals, expected)), 1.0, atol=1e-6)


@every_rule
def test_a_line_is_refused(rule):
    with pytest.raises(SurfaceError, match="straight from end to end"):
        normals_from_bend(bend(S[:, None] * [0.6, 0.0, 0.8]), rule, 0.1)


def test_a_cut_of_nothing_smooths_nothing():
    found = bend(noisy(path().points, 1e-5), cut=0.04)
    plain = normals_from_bend(found, "continuous", 0.0)
    for rule in ("doubled-angle", "spline"):
        np.testing.assert_array_equal(normals_from_bend(found, rule, 0.0), plain)


def test_a_full_circle_about_a_cylinder_keeps_its_side():
    ring = geodesic(Cylinder(0.1), (0.0, 0.0), (1.0, 0.0, 0.0), np.linspace(0, 0.6, 151))
    normals = normals_from_bend(bend(ring.points, ring.s), "doubled-angle", 0.05)
    np.testing.assert_allclose(np.abs(dot(normals, ring.normals)), 1.0, atol=1e-7)
    assert len(continuity(normals).flips) == 0


def test_least_squares_keep_cubics_and_have_few_coefficients():
    s = np.linspace(0.0, 1.0, 40)
    cubic = np.stack([s**3 - s, 2 * s**2], axis=1)
    for spacing in (0.01, 0.1, 5.0):
        np.testing.assert_allclose(least_squares(s, cubic, spacing), cubic, atol=1e-9)
    rough = np.random.default_rng(0).normal(size=(40, 2))
    np.testing.assert_allclose(
        least_squares(s, rough, 2.0),
        np.stack([np.polyval(np.polyfit(s, c, 3), s) for c in rough.T], 1),
    )
    np.testing.assert_allclose(least_squares(s[:4], rough[:4], 0.1), rough[:4], atol=1e-9)
    uneven = np.concatenate([s[:20], 5.0 + s[20:]])
    assert np.abs(least_squares(uneven, rough, 0.05)).max() < 2.0 * np.abs(rough).max()


def test_runs_of_flags():
    assert runs(np.array([True, False, True, True, False, True])) == [(0, 0), (2, 3), (5, 5)]
    assert runs(np.zeros(3, dtype=bool)) == []
