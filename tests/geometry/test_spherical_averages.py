"""Laws of weighted averages on the sphere, and of all splines of tangents alike."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from georibbon.errors import FitError
from georibbon.geometry.frames import arc_angles, frames_from, unit
from georibbon.geometry.settings import TANGENTS
from georibbon.geometry.spherical import curve_from_tangents, interpolate_frames
from georibbon.geometry.spherical_averages import AverageSpline, weighted_average
from georibbon.geometry.tangent_splines import SPLINES
from known_curves import helix, some_directions

every_spline = pytest.mark.parametrize("kind", TANGENTS)


def clusters(count: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Some directions about a random one each, with positive weights."""
    random = np.random.default_rng(8)
    middle = random.normal(size=(count, 1, 3))
    directions = unit(unit(middle) + 0.5 * random.normal(size=(count, 4, 3)))
    return directions, random.dirichlet(np.ones(4), count)


def spread_about(q: np.ndarray, directions: np.ndarray, weights: np.ndarray) -> float:
    """The sum of squared angles that an average makes least."""
    return float(weights @ arc_angles(np.broadcast_to(q, directions.shape), directions) ** 2)


def test_an_average_is_where_the_squared_angles_are_least() -> None:
    directions, weights = clusters()
    for q, some, share in zip(
        weighted_average(directions, weights), directions, weights, strict=True
    ):
        least = minimize(
            lambda x, some=some, share=share: spread_about(unit(x), some, share),
            share @ some,
            method="BFGS",
        )
        assert spread_about(q, some, share) <= least.fun + 1e-14
        assert arc_angles(q, unit(least.x)) < 1e-5


def test_an_average_of_two_divides_the_arc_between_them() -> None:
    share = np.linspace(0.0, 1.0, 7)
    directions = np.broadcast_to(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), (7, 2, 3))
    found = weighted_average(directions, np.stack([1.0 - share, share], axis=1))
    angle = share * np.pi / 2
    expected = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_an_average_turns_with_its_directions_and_knows_no_order() -> None:
    directions, weights = clusters()
    found = weighted_average(directions, weights)
    turn = Rotation.from_rotvec([0.3, -1.2, 0.7])
    turned = turn.apply(directions.reshape(-1, 3)).reshape(directions.shape)
    np.testing.assert_allclose(weighted_average(turned, weights), turn.apply(found), atol=1e-13)
    mixed = weighted_average(directions[:, [2, 0, 3, 1]], weights[:, [2, 0, 3, 1]])
    np.testing.assert_allclose(mixed, found, atol=1e-13)


def test_equal_directions_are_their_own_average() -> None:
    directions = np.broadcast_to(np.array([0.6, 0.0, 0.8]), (3, 4, 3))
    found = weighted_average(directions, np.full((3, 4), 0.25))
    np.testing.assert_allclose(found, directions[:, 0], atol=1e-15)


def test_directions_all_around_have_no_average() -> None:
    around = np.array([[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])
    with pytest.raises(FitError, match="take unrolled tangents"):
        weighted_average(around, np.array([[0.5, 0.5]]))


def test_it_is_the_average_of_control_directions_with_b_splines_as_weights() -> None:
    """Within a small part of the sphere it is the plane's not-a-knot cubic spline."""
    s, at = np.linspace(0.0, 0.5, 9), np.linspace(-0.02, 0.52, 60)
    small = 1e-4
    flat = np.random.default_rng(1).normal(size=(9, 2))
    tangents = unit(np.concatenate([np.ones((9, 1)), small * flat], axis=1))
    knots = np.r_[[s[0]] * 4, s[2:-2], [s[-1]] * 4]
    controls = np.linalg.solve(BSpline(knots, np.eye(9), 3)(s), flat)
    expected = BSpline(knots, controls, 3)(at)
    found = AverageSpline(s, tangents)(at)
    np.testing.assert_allclose(found[:, 1:] / found[:, :1] / small, expected, atol=1e-6)


@every_spline
@pytest.mark.parametrize("count", [2, 3, 4, 5, 12])
def test_directions_are_unit_and_pass_through_the_samples(kind: str, count: int) -> None:
    s = 0.1 * (np.arange(count) + 0.5 * np.random.default_rng(2).uniform(size=count))
    tangents = some_directions(count)
    spline = SPLINES[kind](s, tangents)
    np.testing.assert_allclose(spline(s), tangents, atol=1e-12)
    between = spline(np.linspace(s[0], s[-1], 300))
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), 1.0, atol=1e-14)


@every_spline
def test_a_rotation_of_the_samples_rotates_the_curve(kind: str) -> None:
    s, out = np.linspace(0.0, 0.5, 10), np.linspace(-0.02, 0.52, 60)
    tangents, made = some_directions(10), SPLINES[kind]
    turn = Rotation.from_rotvec([0.3, -1.2, 0.7])
    rotated = curve_from_tangents(s, turn.apply(tangents), out, made)
    straight = curve_from_tangents(s, tangents, out, made)
    np.testing.assert_allclose(rotated, turn.apply(straight), atol=1e-12)


@every_spline
def test_the_curve_backwards_is_the_same_curve(kind: str) -> None:
    s, out = np.linspace(0.0, 0.5, 10), np.linspace(0.0, 0.5, 60)
    tangents, made = some_directions(10), SPLINES[kind]
    forward = curve_from_tangents(s, tangents, out, made)
    backward = curve_from_tangents(s, -tangents[::-1], out, made)
    np.testing.assert_allclose(backward[::-1] - backward[-1], forward, atol=1e-12)


@pytest.mark.parametrize("kind", ["unrolled", "averages"])
def test_great_circles_at_constant_speed_are_exact(kind: str) -> None:
    s = np.array([0.0, 0.1, 0.25, 0.3, 0.5, 0.6])
    at = np.linspace(-0.05, 0.65, 40)

    def circle(angle: np.ndarray) -> np.ndarray:
        return np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)

    np.testing.assert_allclose(SPLINES[kind](s, circle(s))(at), circle(at), atol=1e-12)


@every_spline
def test_directions_are_twice_differentiable(kind: str) -> None:
    s = np.linspace(0.0, 0.9, 10)
    spline, h = SPLINES[kind](s, some_directions(10)), 1e-5
    inner = s[1:-1]
    ahead, behind = (
        (spline(inner + sign * h) - 2 * spline(inner + 2 * sign * h) + spline(inner + 3 * sign * h))
        / h**2
        for sign in (1, -1)
    )
    np.testing.assert_allclose(ahead, behind, atol=5e-3 * np.abs(ahead).max())


@every_spline
def test_beyond_half_a_pitch_the_direction_stays(kind: str) -> None:
    s = np.linspace(0.0, 0.9, 10)
    spline = SPLINES[kind](s, some_directions(10))
    np.testing.assert_allclose(spline(np.array([-0.05, 0.95])), spline(np.array([-3.0, 7.0])))
    assert not np.allclose(spline(np.array([0.0])), spline(np.array([-0.05])))


@every_spline
def test_positions_are_of_fourth_order(kind: str) -> None:
    out = np.linspace(0.0, 0.45, 91)
    exact = helix(out)[0]
    errors = []
    for count in (10, 19, 37):
        s = np.linspace(0.0, 0.45, count)
        curve = curve_from_tangents(s, helix(s)[1], out, SPLINES[kind])
        errors.append(np.linalg.norm(curve - exact, axis=1).max())
    assert errors[0] / errors[1] > 12.0
    assert errors[1] / errors[2] > 12.0
    assert errors[2] < 1e-7


@every_spline
def test_frames_along_a_helix(kind: str) -> None:
    s, out = np.linspace(0.0, 0.45, 16), np.linspace(0.0, 0.45, 91)
    _, tangents, normals = helix(s)
    strip = interpolate_frames(s, frames_from(tangents, normals), out, SPLINES[kind])
    points, tangents, normals = helix(out)
    assert np.linalg.norm(strip.points - points, axis=1).max() < 1.5e-6
    assert np.degrees(arc_angles(strip.tangents, tangents)).max() < 1e-2
    assert np.degrees(arc_angles(strip.normals, normals)).max() < 1e-2


@every_spline
@pytest.mark.parametrize(
    ("s", "tangents", "said"),
    [
        ([0.0, 0.1, 0.1], np.eye(3), "do not ascend"),
        ([0.0], np.eye(3)[:1], "at least 2"),
        ([0.0, 0.1], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], "180° apart"),
        ([0.0, 0.1], [[1.0, 0.0, 0.0], [np.nan, 0.0, 0.0]], "not a number"),
    ],
)
def test_what_cannot_be_interpolated_is_refused(
    kind: str, s: list[float], tangents: np.ndarray, said: str
) -> None:
    with pytest.raises(FitError, match=said):
        SPLINES[kind](np.array(s), np.array(tangents))


def test_samples_that_averages_follow_by_turning_far_aside_are_followed() -> None:
    """Their control directions lie up to 155 degrees apart, and whole rounds lead nowhere."""
    s = np.array([0.013, 0.115, 0.241, 0.305, 0.43])
    tangents = some_directions(5)
    np.testing.assert_allclose(AverageSpline(s, tangents)(s), tangents, atol=1e-12)


def test_samples_so_uneven_that_averages_overshoot_are_refused_in_words() -> None:
    """Two close by and one far off: the B-spline's middle direction would be half around."""
    s, tangents = np.array([0.0, 0.03, 0.55]), some_directions(3)
    with pytest.raises(FitError, match="take unrolled tangents"):
        AverageSpline(s, tangents)(s)
