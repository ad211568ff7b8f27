"""Rotations: exp and log are inverse, Jacobians are derivatives, up is up."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from georibbon.rotations import about_z, exp, exp_and_jacobian, log, skew, to_up

UP = np.array([0.0, 0.0, 1.0])
components = st.floats(-1.0, 1.0, allow_subnormal=False)
vectors = st.tuples(components, components, components).map(np.array)
directions = vectors.filter(lambda v: np.linalg.norm(v) > 1e-3).map(lambda v: v / np.linalg.norm(v))
ANGLES = [
    *(0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.0199, 0.02, 0.0201, 0.5, np.pi / 2, 3.0, 3.0001),
    *(np.pi - 1e-3, np.pi - 1e-6, np.pi - 1e-9),
]


def left_jacobian(phi):
    """J = integral of exp(t [phi]x) over t from 0 to 1, by quadrature."""
    t, weight = np.polynomial.legendre.leggauss(24)
    turns = Rotation.from_rotvec(0.5 * (t[:, None] + 1) * phi).as_matrix()
    return np.einsum("k,kij->ij", 0.5 * weight, turns)


@given(vectors, vectors)
def test_skew_is_the_cross_product(v, w):
    np.testing.assert_allclose(skew(v) @ w, np.cross(v, w), atol=1e-15)


@given(directions, st.sampled_from([*ANGLES, np.pi]) | st.floats(0.0, np.pi))
def test_exp_is_the_rotation_about_the_vector_by_its_length(axis, angle):
    found = exp(angle * axis)
    np.testing.assert_allclose(found, Rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(found) == pytest.approx(1.0, abs=1e-14)


@given(directions, st.sampled_from(ANGLES) | st.floats(0.0, np.pi - 1e-9))
def test_log_undoes_exp_up_to_half_a_turn(axis, angle):
    np.testing.assert_allclose(log(exp(angle * axis)), angle * axis, atol=2e-14, rtol=1e-12)


@given(directions)
def test_log_of_half_a_turn_is_one_of_its_two_vectors(axis):
    found = log(exp(np.pi * axis))
    assert np.linalg.norm(found) == pytest.approx(np.pi, abs=1e-14)
    np.testing.assert_allclose(exp(found), exp(np.pi * axis), atol=1e-14)


@given(directions, st.floats(np.pi + 1e-6, 2 * np.pi))
def test_log_takes_the_shorter_way(axis, angle):
    np.testing.assert_allclose(log(exp(angle * axis)), (angle - 2 * np.pi) * axis, atol=1e-13)


def test_log_of_a_small_rotation_keeps_all_its_digits():
    """An arccos would lose half of them."""
    phi = np.array([1e-9, -2e-9, 3e-9])
    np.testing.assert_allclose(log(exp(phi)), phi, rtol=1e-14)


@given(directions, st.sampled_from(ANGLES) | st.floats(0.0, 6.0))
def test_the_jacobian_is_the_mean_rotation_along_the_way(axis, angle):
    rotation, jacobian = exp_and_jacobian(angle * axis)
    np.testing.assert_allclose(rotation, exp(angle * axis), atol=0)
    np.testing.assert_allclose(jacobian, left_jacobian(angle * axis), atol=1e-12)


@given(directions, st.floats(0.0, 3.0), vectors)
def test_the_jacobian_is_the_derivative_from_the_left(axis, angle, d):
    phi, step = angle * axis, 1e-6
    _, jacobian = exp_and_jacobian(phi)
    ahead, behind = exp(phi + step * d), exp(phi - step * d)
    slope = log(ahead @ behind.T) / (2 * step)
    np.testing.assert_allclose(slope, jacobian @ d, atol=1e-8)


@given(directions, st.floats(1e-3, 1e3))
def test_to_up_brings_gravity_up_by_the_smallest_rotation(g, length):
    found = to_up(length * g)
    np.testing.assert_allclose(found @ g, UP, atol=1e-12)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    angle = np.arctan2(np.hypot(g[0], g[1]), g[2])
    assert np.linalg.norm(log(found)) == pytest.approx(angle, abs=1e-9)
    assert log(found)[2] == pytest.approx(0.0, abs=1e-9)


def test_to_up_from_straight_down_is_half_a_turn_about_x():
    np.testing.assert_allclose(to_up(-UP), np.diag([1.0, -1.0, -1.0]), atol=1e-15)
    np.testing.assert_allclose(to_up(UP), np.eye(3), atol=1e-15)


@given(st.floats(-10.0, 10.0))
def test_about_z_turns_east_to_north(angle):
    np.testing.assert_allclose(about_z(angle), exp(angle * UP), atol=1e-14)
    assert (about_z(np.pi / 2) @ np.array([1.0, 0.0, 0.0]))[1] == pytest.approx(1.0)


def test_all_take_stacks_of_any_shape():
    rng = np.random.default_rng(1)
    phi = rng.normal(size=(4, 2, 3))
    every, jacobians = exp_and_jacobian(phi)
    vectors_back, ups, turns = log(every), to_up(phi), about_z(phi[..., 0])
    for place in np.ndindex(4, 2):
        one, jacobian = exp_and_jacobian(phi[place])
        np.testing.assert_allclose(every[place], one, atol=1e-15)
        np.testing.assert_allclose(jacobians[place], jacobian, atol=1e-15)
        np.testing.assert_allclose(vectors_back[place], log(one), atol=1e-14)
        np.testing.assert_allclose(ups[place], to_up(phi[place]), atol=1e-15)
        np.testing.assert_allclose(turns[place], about_z(phi[place][0]), atol=1e-15)
