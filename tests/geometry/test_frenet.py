"""Frenet's frames, Darboux's rates, inflections and the run of directions keep their laws."""

import numpy as np
import pytest

from georibbon.geometry.frames import Strip, frames_from
from georibbon.geometry.frenet import (
    continued,
    continuity,
    curvature_vectors,
    curve_through,
    darboux_rates,
    frenet,
    inflections,
)
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.reference import Cylinder, Torus
from georibbon.rotations import exp

RADIUS, PITCH = 0.4, 0.15
SPEED = np.hypot(RADIUS, PITCH)


def helix(s):
    """A right-handed screw by its arc length."""
    t = s / SPEED
    return np.stack([RADIUS * np.cos(t), RADIUS * np.sin(t), PITCH * t], axis=1)


S = np.linspace(0.0, 1.2, 121)
CURVE = curve_through(S, helix(S))


def test_a_screws_curvature_and_torsion_are_the_same_everywhere():
    found = frenet(CURVE, S)
    np.testing.assert_allclose(found.curvature, RADIUS / SPEED**2, rtol=1e-6)
    np.testing.assert_allclose(found.torsion, PITCH / SPEED**2, rtol=1e-3)


def test_the_frame_is_a_right_handed_frame_that_turns_by_frenets_law():
    found = frenet(CURVE, S)
    frames = np.stack([found.tangents, found.normals, found.binormals], axis=2)
    np.testing.assert_allclose(
        np.swapaxes(frames, 1, 2) @ frames, np.eye(3)[None] + 0 * frames, atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    rates = np.gradient(found.binormals, S, axis=0)[5:-5]
    expected = -found.torsion[:, None] * found.normals
    np.testing.assert_allclose(rates, expected[5:-5], atol=1e-4)


def test_it_does_not_depend_on_the_parameter():
    t = np.linspace(0.0, 1.0, 161)
    place = 0.6 * t + 0.6 * t**2
    found = frenet(curve_through(t, helix(place)), t)
    np.testing.assert_allclose(found.curvature, RADIUS / SPEED**2, rtol=1e-6)
    np.testing.assert_allclose(found.torsion, PITCH / SPEED**2, rtol=1e-3)


def test_a_rigid_motion_moves_it_along():
    turn = exp(np.array([0.3, -1.1, 0.7]))
    moved = frenet(curve_through(S, helix(S) @ turn.T + [1.0, 2.0, 3.0]), S)
    still = frenet(CURVE, S)
    for name in ("tangents", "normals", "binormals"):
        np.testing.assert_allclose(getattr(moved, name), getattr(still, name) @ turn.T, atol=1e-9)
    np.testing.assert_allclose(moved.curvature, still.curvature, atol=1e-9)
    np.testing.assert_allclose(moved.torsion, still.torsion, atol=1e-6)


def test_backwards_tangent_and_binormal_turn_round_and_all_else_stays():
    back = frenet(curve_through(S, helix(S)[::-1]), S)
    found = frenet(CURVE, S)
    np.testing.assert_allclose(back.tangents[::-1], -found.tangents, atol=1e-9)
    np.testing.assert_allclose(back.binormals[::-1], -found.binormals, atol=1e-9)
    np.testing.assert_allclose(back.normals[::-1], found.normals, atol=1e-9)
    np.testing.assert_allclose(back.curvature[::-1], found.curvature, atol=1e-9)
    np.testing.assert_allclose(back.torsion[::-1], found.torsion, atol=1e-6)


def test_the_curvatures_error_falls_with_the_fourth_power_of_the_spacing():
    errors = []
    for count in (21, 41, 81):
        s = np.linspace(0.0, 1.2, count)
        curvature = frenet(curve_through(s, helix(s)), np.linspace(0.3, 0.9, 301)).curvature
        errors.append(np.abs(curvature - RADIUS / SPEED**2).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 3.5).all()


def test_a_straight_curve_has_no_side():
    line = curve_through(S, S[:, None] * [0.0, 0.6, 0.8])
    found = frenet(line, S)
    np.testing.assert_allclose(found.tangents, [[0.0, 0.6, 0.8]] * len(S), atol=1e-12)
    np.testing.assert_allclose(found.curvature, 0.0, atol=1e-8)
    flat = frenet(curve_through(S[:5], np.zeros((5, 3)) + S[:5, None] * [1.0, 0.0, 0.0]), S[:5])
    assert np.isfinite(flat.torsion).all()


def test_a_smoothed_curve_loses_the_wave_of_its_cut_by_half():
    s = np.linspace(0.0, 1.0, 401)
    wave = np.stack([s, 1e-3 * np.sin(2 * np.pi * s / 0.05), 0 * s], axis=1)
    inside = slice(100, 300)
    left = curve_through(s, wave, 0.05)(s)[inside, 1]
    assert np.abs(left).max() == pytest.approx(0.5e-3, rel=0.04)


def test_darbouxs_rates_of_a_screw_on_a_cylinder():
    angle, radius = 0.5, 0.4
    around = geodesic(Cylinder(radius), (0.1, 0.0), (np.cos(angle), np.sin(angle), 0.0), S)
    tangent = around.tangents[0]
    turned = np.hypot(tangent[0], tangent[2])
    rates = darboux_rates(around)
    np.testing.assert_allclose(rates.geodesic, 0.0, atol=1e-8)
    np.testing.assert_allclose(rates.normal, -(turned**2) / radius, rtol=1e-6)
    np.testing.assert_allclose(
        np.abs(rates.torsion), turned * np.abs(tangent[1]) / radius, rtol=1e-6
    )
    slope = np.gradient(around.normals, around.s, axis=0)
    against = np.sum(slope * around.conormals, axis=1)
    np.testing.assert_allclose(rates.torsion[2:-2], against[2:-2], rtol=1e-3)


def latitude(count):
    """A parallel of a ball of radius 1 at 45 degrees, which is no geodesic."""
    s = np.linspace(0.0, 1.0, count)
    t = s / np.sqrt(0.5)
    points = np.sqrt(0.5) * np.stack([np.cos(t), np.sin(t), np.ones_like(t)], axis=1)
    tangents = np.stack([-np.sin(t), np.cos(t), 0 * t], axis=1)
    return Strip(s, points, frames_from(tangents, points))


def test_a_parallel_turns_within_its_ball():
    rates = darboux_rates(latitude(201))
    np.testing.assert_allclose(np.abs(rates.geodesic), 1.0, rtol=1e-4)
    np.testing.assert_allclose(rates.normal, -1.0, rtol=1e-4)
    np.testing.assert_allclose(rates.torsion, 0.0, atol=1e-9)


def test_the_rates_error_falls_with_the_square_of_the_spacing():
    errors = []
    for count in (41, 81, 161):
        s = np.linspace(-0.4, 0.4, count)
        path = geodesic(Torus(0.6, 0.25), (0.3, 0.4), (0.4, 0.9, 0.3), s)
        exact = geodesic(
            Torus(0.6, 0.25), (0.3, 0.4), (0.4, 0.9, 0.3), np.linspace(-0.4, 0.4, 2561)
        )
        fine = darboux_rates(exact).torsion[:: 2560 // (count - 1)]
        errors.append(np.abs(darboux_rates(path).torsion - fine)[2:-2].max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 1.8).all()


def test_the_inflections_of_a_wave_are_where_it_crosses_its_middle():
    x = np.linspace(0.13, 1.4, 160)
    wave = np.stack([x, 0.05 * np.sin(2 * np.pi * x / 0.5), 0 * x], axis=1)
    _, bent = curvature_vectors(curve_through(x, wave), x)
    np.testing.assert_allclose(inflections(x, bent), [0.25, 0.5, 0.75, 1.0, 1.25], atol=1e-5)


def test_an_inflection_may_be_at_a_point_or_a_straight_stretch():
    s = np.linspace(0.0, 1.0, 11)
    bent = np.zeros((11, 3))
    bent[:, 1] = s - 0.5
    np.testing.assert_allclose(inflections(s, bent), [0.5], atol=1e-12)
    bent[:, 1] = np.where(s < 0.35, 1.0, np.where(s > 0.65, -1.0, 0.0))
    np.testing.assert_allclose(inflections(s, bent), [0.5], atol=1e-12)


def test_a_screw_and_a_line_have_no_inflection():
    assert len(inflections(S, curvature_vectors(CURVE, S)[1])) == 0
    assert len(inflections(S, np.zeros((len(S), 3)))) == 0


def test_directions_that_turn_back_are_found_and_continued():
    angle = np.linspace(0.0, 2.0, 21)
    smooth = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    signs = np.where((np.arange(21) >= 7) & (np.arange(21) < 12), -1.0, 1.0)
    found = continuity(signs[:, None] * smooth)
    assert found.flips.tolist() == [6, 11]
    assert found.greatest_turn == pytest.approx(np.pi - 0.1)
    mended = continued(signs[:, None] * smooth)
    np.testing.assert_allclose(mended, smooth)
    assert len(continuity(mended).flips) == 0
    assert continuity(mended).greatest_turn == pytest.approx(0.1)


def test_what_has_no_direction_is_passed_over():
    directions = np.array([[1.0, 0, 0], [0, 0, 0], [-1.0, 0.1, 0], [0, 0, 0], [1.0, 0, 0]])
    np.testing.assert_allclose(continued(directions)[:, 0], [1.0, 0.0, 1.0, 0.0, 1.0])
    np.testing.assert_allclose(continued(np.zeros((3, 3))), 0.0)
