"""Laws of curves from tangents: unit speed, order, rotation, exactness on great circles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.errors import FitError
from georibbon.geometry.frames import arc_angles, frames_from
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.spherical import (
    SphericalSpline,
    curve_from_tangents,
    interpolate_frames,
)
from known_curves import helix, some_directions


def test_directions_are_unit_and_pass_through_the_samples() -> None:
    s = np.sort(np.random.default_rng(2).uniform(size=12))
    tangents = some_directions(12)
    spline = SphericalSpline(s, tangents)
    assert np.allclose(spline(s), tangents, atol=1e-14)
    between = spline(np.linspace(s[0], s[-1], 300))
    assert np.allclose(np.linalg.norm(between, axis=1), 1.0, atol=1e-14)


def test_a_rotation_of_the_samples_rotates_the_curve() -> None:
    s, out = np.linspace(0.0, 0.5, 10), np.linspace(-0.02, 0.52, 60)
    tangents = some_directions(10)
    turn = Rotation.from_rotvec([0.3, -1.2, 0.7])
    rotated = curve_from_tangents(s, turn.apply(tangents), out)
    assert np.allclose(rotated, turn.apply(curve_from_tangents(s, tangents, out)), atol=1e-13)


def test_the_curve_backwards_is_the_same_curve() -> None:
    s, out = np.linspace(0.0, 0.5, 10), np.linspace(0.0, 0.5, 60)
    tangents = some_directions(10)
    forward = curve_from_tangents(s, tangents, out)
    backward = curve_from_tangents(s, -tangents[::-1], out)
    assert np.allclose(backward[::-1] - backward[-1], forward, atol=1e-13)


def test_great_circles_at_constant_speed_are_exact() -> None:
    s = np.array([0.0, 0.1, 0.25, 0.3, 0.5])
    spline = SphericalSpline(s, np.stack([np.cos(s), np.sin(s), 0.0 * s], axis=1))
    at = np.linspace(-0.05, 0.6, 40)
    exact = np.stack([np.cos(at), np.sin(at), 0.0 * at], axis=1)
    assert np.allclose(spline(at), exact, atol=1e-14)


def test_a_straight_ribbon_is_a_straight_line() -> None:
    points = curve_from_tangents(
        np.linspace(0.0, 1.0, 5), np.tile([0.0, 0.6, 0.8], (5, 1)), np.linspace(0.0, 1.0, 11)
    )
    assert np.allclose(points, np.linspace(0.0, 1.0, 11)[:, None] * [0.0, 0.6, 0.8], atol=1e-15)


def test_two_directions_are_enough() -> None:
    spline = SphericalSpline(np.array([0.0, 1.0]), np.eye(3)[:2])
    assert np.allclose(spline(np.array([0.5])), np.sqrt(0.5) * np.array([[1.0, 1.0, 0.0]]))


def test_beyond_half_a_pitch_the_direction_stays() -> None:
    s = np.linspace(0.0, 0.9, 10)
    spline = SphericalSpline(s, some_directions(10))
    assert np.allclose(spline(np.array([-0.05, 0.95])), spline(np.array([-3.0, 7.0])))
    assert not np.allclose(spline(np.array([0.0])), spline(np.array([-0.05])))


def test_positions_are_of_fourth_order() -> None:
    out = np.linspace(0.0, 0.45, 91)
    exact = helix(out)[0]
    errors = []
    for count in (10, 19, 37):
        s = np.linspace(0.0, 0.45, count)
        curve = curve_from_tangents(s, helix(s)[1], out)
        errors.append(np.linalg.norm(curve - exact, axis=1).max())
    assert errors[0] / errors[1] > 12.0
    assert errors[1] / errors[2] > 12.0
    assert errors[2] < 1e-7


def test_sixteen_sensors_follow_a_helix_within_a_micrometre() -> None:
    s, out = np.linspace(0.0, 0.45, 16), np.linspace(0.0, 0.45, 91)
    error = curve_from_tangents(s, helix(s)[1], out) - helix(out)[0]
    assert np.linalg.norm(error, axis=1).max() < 1.1e-6


def test_the_curve_does_not_depend_on_where_it_is_asked_for() -> None:
    s = np.linspace(0.0, 0.5, 10)
    tangents = some_directions(10)
    coarse, fine = np.linspace(0.0, 0.5, 11), np.linspace(0.0, 0.5, 101)
    assert np.allclose(
        curve_from_tangents(s, tangents, coarse),
        curve_from_tangents(s, tangents, fine)[::10],
        atol=2e-6,
    )


def test_frames_along_a_helix() -> None:
    s, out = np.linspace(0.0, 0.45, 16), np.linspace(0.0, 0.45, 91)
    _, tangents, normals = helix(s)
    strip = interpolate_frames(s, frames_from(tangents, normals), out)
    points, tangents, normals = helix(out)
    assert np.linalg.norm(strip.points - points, axis=1).max() < 1.1e-6
    assert np.degrees(arc_angles(strip.tangents, tangents)).max() < 1e-2
    assert np.degrees(arc_angles(strip.normals, normals)).max() < 1e-2
    assert np.array_equal(strip.s, out)


def test_frames_along_a_geodesic_of_a_car_bonnet() -> None:
    fine = np.linspace(-0.45, 0.45, 181)
    exact = geodesic(Bonnet(), (0.0, 0.3), (1.0, 0.4, 0.0), fine)
    some = slice(None, None, 6)
    strip = interpolate_frames(exact.s[some], exact.frames[some], exact.s)
    assert np.linalg.norm(strip.points - (exact.points - exact.points[0]), axis=1).max() < 1e-5
    assert np.degrees(arc_angles(strip.normals, exact.normals)).max() < 0.01
    assert np.allclose(np.swapaxes(strip.frames, 1, 2) @ strip.frames, np.eye(3), atol=1e-12)


def test_beyond_half_a_pitch_the_frames_stay() -> None:
    s, out = np.linspace(0.0, 0.45, 16), np.array([-0.2, -0.015, 0.2, 0.465, 0.6])
    _, tangents, normals = helix(s)
    strip = interpolate_frames(s, frames_from(tangents, normals), out)
    assert np.allclose(strip.frames[0], strip.frames[1], atol=1e-9)
    assert np.allclose(strip.frames[3], strip.frames[4], atol=1e-9)
    assert np.allclose(strip.points[4] - strip.points[3], 0.135 * strip.tangents[3], atol=1e-9)


def test_frames_rotate_with_their_samples() -> None:
    s, out = np.linspace(0.0, 0.45, 16), np.linspace(0.0, 0.45, 50)
    _, tangents, normals = helix(s)
    frames = frames_from(tangents, normals)
    turn = Rotation.from_rotvec([0.3, -1.2, 0.7])
    plain = interpolate_frames(s, frames, out)
    turned = interpolate_frames(s, turn.as_matrix() @ frames, out)
    assert np.allclose(turned.frames, turn.as_matrix() @ plain.frames, atol=1e-12)


@pytest.mark.parametrize(
    ("s", "tangents", "words"),
    [
        ([0.0], [[1.0, 0.0, 0.0]], "at least 2"),
        ([0.0, 1.0, 2.0], [[1.0, 0.0, 0.0]] * 2, "as many of one as of the other"),
        ([0.0, 0.0], [[1.0, 0.0, 0.0]] * 2, "do not ascend"),
        ([0.0, np.nan], [[1.0, 0.0, 0.0]] * 2, "not a number"),
        ([0.0, 1.0], [[1.0, 0.0, 0.0], [np.inf, 0.0, 0.0]], "not a number"),
        ([0.0, 0.1], [[1.0, 0.0, 0.0], [-0.8, 0.6, 0.0]], "143° apart"),
    ],
)
def test_what_gives_no_curve_is_refused(
    s: list[float], tangents: list[list[float]], words: str
) -> None:
    with pytest.raises(FitError, match=words):
        SphericalSpline(np.array(s), np.array(tangents))
