"""The directions of gravity that poses cover."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.calibration.directions import (
    attitude,
    covered,
    directions_of_field,
    directions_of_gravity,
)
from georibbon.calibration.plans import PLANS

ANGLES = st.floats(-360.0, 360.0)


@given(ANGLES, ANGLES, st.floats(-90.0, 90.0))
def test_an_attitude_is_a_rotation_and_gravity_knows_no_heading(roll, heading, pitch):
    r = attitude((roll, heading, pitch, False))
    np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(r) == pytest.approx(1.0)
    up = directions_of_gravity([(roll, heading, pitch, False), (roll, 0.0, pitch, False)])
    np.testing.assert_allclose(up[0], up[1], atol=1e-12)
    # The end up by `pitch` shows along the ribbon.
    assert up[0][0] == pytest.approx(np.sin(np.radians(pitch)), abs=1e-12)


def test_the_faces_are_where_they_are_called():
    up = directions_of_gravity([(roll, 0.0, 0.0, True) for roll in (0, 90, 180, 270)])
    np.testing.assert_allclose(up, [[0, 0, 1], [0, 1, 0], [0, 0, -1], [0, -1, 0]], atol=1e-12)


def test_the_field_points_north_and_down():
    flat = directions_of_field([(0.0, 0.0, 0.0, True)], np.radians(60.0))[0]
    np.testing.assert_allclose(flat, [0.0, 0.5, -np.sqrt(0.75)], atol=1e-12)
    turned = directions_of_field([(0.0, 90.0, 0.0, True)], np.radians(60.0))[0]
    np.testing.assert_allclose(turned, [0.5, 0.0, -np.sqrt(0.75)], atol=1e-12)


@pytest.mark.parametrize("plan", list(PLANS))
def test_coverage_grows_with_a_plan(plan):
    poses = PLANS[plan]
    none = covered(poses, [False] * plan)
    assert (none.figure, none.grade, none.remedy) == (0.0, "poor", "")
    table = covered(poses, [pose[3] for pose in poses])
    assert table.grade == "poor"
    assert "lift one end" in table.remedy
    whole = covered(poses, [True] * plan)
    assert whole.figure > 0.2
    assert whole.up.shape == (plan, 3)
    assert whole.taken == (True,) * plan


def test_an_even_spread_is_good():
    poses = [(r, 0.0, p, False) for r in (0, 90, 180, 270) for p in (-35.0, 35.0)]
    found = covered(poses, [True] * 8)
    assert found.figure == pytest.approx(3.0 * np.sin(np.radians(35.0)) ** 2)
    assert (found.grade, found.remedy) == ("good", "")
    few = covered([*poses, (0.0, 0.0, 0.0, True)], [True] + [False] * 8)
    assert few.figure == 0.0
