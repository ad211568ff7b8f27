"""Laws of frames: orthonormality, rotation, transport, the rotation minimising frame."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.geometry.frames import (
    Strip,
    arc_angles,
    curvatures,
    frames_from,
    interpolated,
    minimising_frame,
    rotations_between,
    unit,
)


def helix(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    s = np.linspace(0.0, 1.0, count)
    a, b = 0.1, 0.05
    t = s / np.hypot(a, b)
    points = np.stack([a * np.cos(t), a * np.sin(t), b * t], axis=1)
    tangents = np.stack([-a * np.sin(t), a * np.cos(t), np.full_like(t, b)], axis=1)
    return s, points, tangents / np.hypot(a, b)


def some_frames(count: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    return frames_from(unit(rng.normal(size=(count, 3))), rng.normal(size=(count, 3)))


def test_frames_are_right_handed_and_orthonormal() -> None:
    frames = some_frames(20)
    assert np.allclose(np.swapaxes(frames, 1, 2) @ frames, np.eye(3), atol=1e-14)
    assert np.allclose(np.linalg.det(frames), 1.0)
    tau, conormal, normal = np.moveaxis(frames, 2, 0)
    assert np.allclose(np.cross(normal, tau), conormal)


def test_a_strip_reversed_twice_is_itself_and_once_keeps_its_normals() -> None:
    s, points, _ = helix(20)
    strip = Strip(s, points, some_frames(20))
    back = strip.reversed()
    assert np.array_equal(back.normals, strip.normals[::-1])
    assert np.array_equal(back.tangents, -strip.tangents[::-1])
    assert np.array_equal(back.conormals, -strip.conormals[::-1])
    again = back.reversed()
    assert np.allclose(again.s, strip.s)
    assert np.array_equal(again.points, strip.points)
    assert np.array_equal(again.frames, strip.frames)


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2, 2.5])
def test_on_a_cylinder_the_curvatures_are_eulers(angle: float) -> None:
    """A helix at an angle to the parallels: k = -cos²/r, t = sin cos / r, normal outwards."""
    radius, s = 0.2, np.linspace(0.0, 0.5, 40)
    turn = s * np.cos(angle) / radius
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(s)], axis=1)
    around = np.stack([-np.sin(turn), np.cos(turn), np.zeros_like(s)], axis=1)
    tangents = np.cos(angle) * around + np.sin(angle) * np.array([0.0, 0.0, 1.0])
    points = radius * out + np.outer(s, [0.0, 0.0, np.sin(angle)])
    strip = Strip(s, points, frames_from(tangents, out))
    curvature, torsion = curvatures(strip)
    assert np.allclose(curvature, -(np.cos(angle) ** 2) / radius, atol=1e-9)
    # V' . N from differences, whatever the sign convention says.
    slope = np.gradient(strip.conormals, s, axis=0, edge_order=2)
    assert np.allclose(torsion, np.sum(slope * strip.normals, axis=1), atol=5e-3)
    assert np.allclose(np.abs(torsion), np.abs(np.sin(angle) * np.cos(angle)) / radius, atol=1e-9)
    back = curvatures(strip.reversed())
    assert np.allclose(back, [curvature[::-1], torsion[::-1]], atol=1e-9)


def test_zero_vectors_stay_zero() -> None:
    assert np.array_equal(unit(np.zeros((2, 3))), np.zeros((2, 3)))


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 1.0, 3.0])
def test_angles_are_exact_however_small(angle: float) -> None:
    first = np.array([[1.0, 0.0, 0.0]])
    second = np.array([[np.cos(angle), np.sin(angle), 0.0]])
    assert arc_angles(first, second)[0] == pytest.approx(angle, rel=1e-12)


def test_the_smallest_rotation_takes_one_vector_into_the_other() -> None:
    rng = np.random.default_rng(1)
    first, second = unit(rng.normal(size=(50, 3))), unit(rng.normal(size=(50, 3)))
    rotations = rotations_between(first, second)
    assert np.allclose(np.einsum("kij,kj->ki", rotations, first), second, atol=1e-12)
    assert np.allclose(
        Rotation.from_matrix(rotations).magnitude(), arc_angles(first, second), atol=1e-7
    )


def test_the_minimising_frame_turns_back_by_the_helix_torsion() -> None:
    """On a helix it turns against the principal normal at the rate of the torsion."""
    s, points, tangents = helix(101)
    a, b = 0.1, 0.05
    torsion = b / (a * a + b * b)
    principal = -unit(points * [1.0, 1.0, 0.0])
    binormal = np.cross(tangents, principal)
    frame = minimising_frame(points, tangents, principal[0])
    roll = np.unwrap(
        np.arctan2(np.sum(frame * binormal, axis=1), np.sum(frame * principal, axis=1))
    )
    assert np.allclose(roll, -torsion * s, atol=1e-5)


def test_the_minimising_frame_is_of_fourth_order() -> None:
    a, b = 0.1, 0.05
    errors = []
    for count in (21, 41):
        s, points, tangents = helix(count)
        frame = minimising_frame(points, tangents, -points[0])
        assert np.allclose(np.sum(frame * tangents, axis=1), 0.0, atol=1e-12)
        principal = -unit(points[-1] * [1.0, 1.0, 0.0])
        angle = -b / (a * a + b * b) * s[-1]
        exact = np.cos(angle) * principal + np.sin(angle) * np.cross(tangents[-1], principal)
        errors.append(np.linalg.norm(frame[-1] - exact))
    assert errors[0] / errors[1] > 12.0


def test_between_two_places_the_columns_run_straight() -> None:
    s, values = np.array([0.0, 2.0, 3.0]), np.array([[0.0, 1.0], [4.0, -1.0], [5.0, 5.0]])
    found = interpolated(np.array([-1.0, 0.5, 2.0, 9.0]), s, values)
    assert np.array_equal(found, [[0.0, 1.0], [1.0, 0.5], [4.0, -1.0], [5.0, 5.0]])
