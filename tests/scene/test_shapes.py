"""The shapes of the scene: closed, turned outward, in the same triangles when they move."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.geometry.mesh import Mesh, is_watertight, volume
from georibbon.scene.shapes import around, ball, die, stamped, tubes


def merged(solid):
    """A solid as a mesh whose corners that lie on one another are one."""
    points, which = np.unique(np.round(solid.points, 9), axis=0, return_inverse=True)
    return Mesh(points, which.reshape(-1)[solid.triangles], np.zeros_like(points))


def curve(seed, count):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(count, 3)) * 0.02 + [0.1, 0.0, 0.0], axis=0)


@given(seed=st.integers(0, 999), counts=st.lists(st.integers(2, 9), min_size=1, max_size=4))
def test_tubes_are_closed_and_as_thick_as_asked(seed, counts):
    curves = [curve(seed + k, count) for k, count in enumerate(counts)]
    solid = tubes(curves, 0.01, 6)
    assert is_watertight(merged(solid))
    assert volume(Mesh(solid.points, solid.triangles, solid.normals)) > 0
    start = 0
    for points in curves:
        rings = solid.points[start : start + 6 * len(points)].reshape(len(points), 6, 3)
        assert np.linalg.norm(rings - points[:, None], axis=2) == pytest.approx(0.01)
        start += 6 * len(points) + 2


def test_values_follow_the_points_of_their_tubes():
    curves = [curve(1, 4), curve(2, 4), curve(3, 3)]
    values = [10.0 * k + np.arange(len(one)) for k, one in enumerate(curves)]
    solid, spread = tubes(curves, 0.01, 5), around(values, 5)
    nearest = np.concatenate(curves)
    owner = np.linalg.norm(solid.points[:, None] - nearest, axis=2).argmin(axis=1)
    assert spread == pytest.approx(np.concatenate(values)[owner])


def test_what_moves_keeps_its_triangles():
    before, after = (tubes([curve(seed, 7)], 0.01, 6) for seed in (1, 2))
    assert np.array_equal(before.triangles, after.triangles)
    assert not np.array_equal(before.points, after.points)


@pytest.mark.parametrize(("solid", "expected"), [(ball(), 4 / 3 * np.pi), (die(), 8.0)])
def test_small_solids_are_closed_and_turned_outward(solid, expected):
    assert is_watertight(merged(solid))
    found = volume(Mesh(solid.points, solid.triangles, solid.normals))
    assert 0.9 * expected < found <= expected * (1 + 1e-9)
    corners = solid.points[solid.triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.sum(facing * solid.normals[solid.triangles].mean(axis=1), axis=1) > 0)


def test_stamps_stand_at_their_places_in_their_sizes():
    places, sizes = np.array([[0.0, 0, 0], [1.0, 2, 3]]), np.array([0.1, 0.2])
    solid = stamped(die(), places, sizes)
    halves = solid.points.reshape(2, -1, 3)
    assert halves.mean(axis=1) == pytest.approx(places)
    assert np.ptp(halves, axis=1) == pytest.approx(np.repeat(2 * sizes[:, None], 3, axis=1))
    assert solid.triangles.max() == len(solid.points) - 1
