"""Laws of the stages by themselves: derivatives, gauge, mirror, robust weights."""

from dataclasses import replace

import numpy as np
import pytest
from bar import TWENTY, Bar
from scipy.spatial.transform import Rotation

from georibbon.calibration import magnetometers as field
from georibbon.calibration.accelerometers import directions_of, fit_accelerometers, tangents
from georibbon.calibration.gauge import FACE, fit_gauge, settle
from georibbon.calibration.labels import check_headings, describe, roll_pitch
from georibbon.calibration.poses import (
    Attitudes,
    attitudes,
    block,
)
from georibbon.calibration.quality import coverage
from georibbon.calibration.separable import median_of, robust_weights
from georibbon.rotations import about_x, about_y, about_z, exp
from georibbon.stillness import still_means


@pytest.fixture(scope="module")
def bar():
    return Bar(seed=3, noise=0.0, sensors=8, frames=5)


@pytest.fixture(scope="module")
def stages(bar):
    poses = bar.poses(TWENTY)
    asked, means = (
        attitudes(poses, np.ones(20, dtype=bool)),
        [still_means(pose.readings) for pose in poses],
    )
    first = fit_accelerometers(block(bar.ribbon, means, "accelerometer"))
    magnetometers = block(bar.ribbon, means, "magnetometer")
    second = field.fit_magnetometers(magnetometers, asked.level, first.up, asked.heading)
    return asked, first, magnetometers, second


@pytest.mark.parametrize(("turn", "axis"), [(about_x, "x"), (about_y, "y"), (about_z, "z")])
def test_rotations_are_those_of_scipy(turn, axis):
    angles = np.linspace(-3.0, 3.0, 7)
    expected = Rotation.from_euler(axis, angles[:, None]).as_matrix()
    np.testing.assert_allclose(turn(angles), expected, atol=1e-15)


@pytest.mark.parametrize("w", [np.zeros(3), np.array([0.3, -0.2, 1.0]), np.array([1e-14, 0, 0])])
def test_the_exponential_is_that_of_scipy(w):
    np.testing.assert_allclose(exp(w), Rotation.from_rotvec(w).as_matrix(), atol=1e-15)


def test_the_nominal_attitude_is_as_the_format_says():
    """Rz(heading) Ry(-pitch) Rx(roll): roll 90 puts +y up, a pitch > 0 the ribbon's end."""
    asked = Attitudes(
        ("a", "b"),
        np.radians([90.0, 0.0]),
        np.zeros(2),
        np.radians([0.0, 30.0]),
        np.array([True, False]),
        (1, 2),
    )
    np.testing.assert_allclose(asked.up, [[0, 1, 0], [0.5, 0, np.sqrt(0.75)]], atol=1e-15)
    roll, pitch = roll_pitch(asked.up)
    np.testing.assert_allclose(roll, asked.roll, atol=1e-15)
    np.testing.assert_allclose(pitch, asked.pitch, atol=1e-15)


def test_tangents_are_square_to_their_direction():
    up = np.random.default_rng(0).normal(size=(30, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    basis = np.concatenate([up[:, :, None], tangents(up)], axis=2)
    np.testing.assert_allclose(basis.mT @ basis, np.tile(np.eye(3), (30, 1, 1)), atol=1e-14)
    assert directions_of(up).jacobian.shape == (30, 3, 60)


def test_the_fields_derivative_is_its_difference_quotient(stages):
    frames = field.levelled(stages[0].level, stages[1].up)
    q = np.append(np.linspace(0.0, 5.0, len(frames)), 0.7)
    jacobian = field._directions(frames, q).jacobian
    for k in (0, 5, len(q) - 1):
        step = np.zeros_like(q)
        step[k] = 1e-6
        ahead, back = field._directions(frames, q + step).d, field._directions(frames, q - step).d
        np.testing.assert_allclose(jacobian[:, :, k], (ahead - back) / 2e-6, atol=1e-9)


def test_levelled_frames_put_up_upright(stages):
    frames = field.levelled(stages[0].level, stages[1].up)
    np.testing.assert_allclose(
        np.einsum("pij,pj->pi", frames, stages[1].up), np.tile([0, 0, 1.0], (20, 1)), atol=1e-12
    )
    np.testing.assert_allclose(frames @ frames.mT, np.tile(np.eye(3), (20, 1, 1)), atol=1e-12)


def test_the_mirror_solution_is_turned_back(stages):
    """(-dip, heading + 180, -S) predicts the same readings; the axes' sign tells."""
    _, first, magnetometers, second = stages
    problem = field.Problem(
        magnetometers.values,
        magnetometers.valid.astype(float),
        magnetometers.axes.astype(float),
        field.prior_of(magnetometers, 1.0, 1.0, 1.0),
        lambda q: field._directions(field.levelled(stages[0].level, first.up), q),
        field._move,
        1e-3,
    )
    stage = field._Stage(problem, problem.prior, second.frames)
    right = second.adjusted
    q = np.append(right.q[:-1] + np.pi, -right.q[-1])
    b, mirrored = problem.directions(right.q).d, problem.directions(q).d
    np.testing.assert_allclose(b, -mirrored, atol=1e-12)
    wrong = replace(right, q=q, theta=right.theta * [-1, -1, -1, 1])
    back = field._upright(stage, wrong)
    np.testing.assert_allclose(back.theta, right.theta)
    assert back.q[-1] == pytest.approx(right.q[-1])
    assert field._upright(stage, right) is right


def frames_on_table(rotation, tilt, roll, heading):
    table = Rotation.from_rotvec([*tilt, 0.0]).as_matrix()
    return table @ about_z(heading) @ about_x(roll) @ rotation.T


ROLL = np.repeat(np.radians([0.0, 90, 180, 270]), 2)
HEADING = np.tile([0.1, np.pi - 0.2], 4)


@pytest.mark.parametrize("seed", range(5))
def test_the_gauge_finds_rotation_and_tilt(seed):
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_rotvec(0.05 * rng.normal(size=3)).as_matrix()
    tilt = 0.02 * rng.normal(size=2)
    frames = frames_on_table(rotation, tilt, ROLL, HEADING)
    found = fit_gauge(frames, ROLL, np.ones(8, dtype=bool))
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-12)
    assert np.linalg.norm(found.tilt) == pytest.approx(np.sin(np.linalg.norm(tilt)), abs=1e-12)
    assert np.nanmax(found.residuals) < 1e-12
    assert found.found < found.sigma


def test_the_gauge_is_equivariant():
    """A solution in a turned frame has the turned gauge."""
    rng = np.random.default_rng(7)
    rotation = Rotation.from_rotvec(0.05 * rng.normal(size=3)).as_matrix()
    turn = Rotation.from_rotvec(0.1 * rng.normal(size=3)).as_matrix()
    noise = Rotation.from_rotvec(1e-3 * rng.normal(size=(8, 3))).as_matrix()
    frames = frames_on_table(rotation, [0.01, 0.0], ROLL, HEADING) @ noise
    one = fit_gauge(frames, ROLL, np.ones(8, dtype=bool))
    other = fit_gauge(frames @ turn.T, ROLL, np.ones(8, dtype=bool))
    np.testing.assert_allclose(other.rotation, turn @ one.rotation, atol=1e-10)
    np.testing.assert_allclose(other.residuals, one.residuals, atol=1e-10)


def test_the_gauges_sigma_is_honest():
    """Over many bars with faces as rough as FACE says, the worst axis errs as predicted."""
    rng = np.random.default_rng(1)
    errors, predicted = [], 0.0
    for _ in range(200):
        rough = Rotation.from_rotvec(FACE * rng.normal(size=(8, 3))).as_matrix()
        frames = frames_on_table(np.eye(3), [0.01, -0.005], ROLL, HEADING) @ rough
        found = fit_gauge(frames, ROLL, np.ones(8, dtype=bool))
        errors.append(Rotation.from_matrix(found.rotation).as_rotvec())
        predicted = found.sigma
    worst = np.sqrt(np.linalg.eigvalsh(np.cov(np.transpose(errors)))[-1])
    assert worst == pytest.approx(predicted, rel=0.15)


def test_turning_the_bar_end_for_end_is_what_tells_the_tilt():
    turned = fit_gauge(frames_on_table(np.eye(3), [0, 0], ROLL, HEADING), ROLL, np.ones(8, bool))
    same = fit_gauge(frames_on_table(np.eye(3), [0, 0], ROLL, 0 * ROLL), ROLL, np.ones(8, bool))
    assert np.degrees(turned.sigma) < 0.06
    assert np.degrees(same.sigma) > 1.0


def test_a_face_on_a_chip_is_left_out():
    frames = frames_on_table(np.eye(3), [0.01, 0.0], ROLL, HEADING)
    frames[3] = frames[3] @ Rotation.from_euler("x", 3.0, degrees=True).as_matrix()
    gauge, out = settle(frames, ROLL, np.ones(8, dtype=bool))
    assert [place for place, _ in out] == [3]
    np.testing.assert_allclose(gauge.rotation, np.eye(3), atol=1e-10)


def test_square_faces_say_nothing_of_rotation_and_tilt():
    frames = frames_on_table(np.eye(3), [0.0, 0.0], ROLL, HEADING)
    gauge = fit_gauge(frames, ROLL, np.ones(8, dtype=bool))
    np.testing.assert_allclose(gauge.square @ gauge.square, gauge.square, atol=1e-10)
    for w in np.eye(3):
        moved = np.cross(frames[:, 2, :], w).ravel()
        assert moved @ gauge.square @ moved == pytest.approx(0.0, abs=1e-12)


def test_weights_fall_with_the_residual_and_are_zero_where_nothing_was_read():
    cells = np.array([[0.0, 1.0, 2.0, 50.0]])
    valid = np.array([[1.0, 1.0, 0.0, 1.0]])
    weights = robust_weights(cells, valid, 0.5)[0]
    assert weights[0] == 1.0
    assert weights[0] > weights[1] > weights[3]
    assert weights[2] == 0.0
    assert weights[3] < 0.01


def test_the_median_counts_what_was_read_only():
    cells = np.array([[1.0, 2.0, 9.0], [5.0, 6.0, 7.0]])
    valid = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_array_equal(median_of(cells, valid, 1), [1.5, 0.0])


def test_coverage_is_one_for_even_directions_and_none_for_a_plane():
    even = np.concatenate([np.eye(3), -np.eye(3)])
    assert coverage(even) == pytest.approx(1.0)
    assert coverage(even[[0, 1, 3, 4]]) == pytest.approx(0.0)
    assert coverage(even @ Rotation.from_rotvec([1, 2, 3]).as_matrix()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("roll", "pitch", "words"),
    [
        (0, 0, "the upper face up"),
        (91, 3, "the left edge up"),
        (-90, 0, "the right edge up"),
        (180, 40, "the face down and the end 40° up"),
        (270, -38, "the right edge up and the start 38° up"),
    ],
)
def test_poses_in_words(roll, pitch, words):
    assert describe(np.radians(roll), np.radians(pitch)) == words


def test_headings_are_compared_up_to_what_is_common():
    asked = replace(
        Attitudes(tuple("abcdefgh"), *np.zeros((3, 8)), np.ones(8, dtype=bool), tuple(range(1, 9))),
        heading=np.linspace(0.0, 5.0, 8),
    )
    found = asked.heading + 2.5 + np.array([0, 0.1, -0.1, 0, 0, 1.6, 0, 0.05])
    wrong, notices = check_headings(asked, found)
    assert list(np.flatnonzero(wrong)) == [5]
    assert "pose 6" in notices[0].message
