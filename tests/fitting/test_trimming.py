"""What is left of a curve without its ends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.fitting.trimming import Curve, trimmed
from georibbon.geometry.frames import Strip

RADIUS, LENGTH, COUNT = 0.5, 0.6, 41
ENDS = st.floats(0.0, 0.25)


def arc():
    """A circle's arc, known worse towards its end."""
    s = np.linspace(0.0, LENGTH, COUNT)
    points, frames = circle(s)
    covariance = (1e-6 * (1 + s))[:, None, None] * np.eye(3)
    return Curve(Strip(s, points, frames), covariance, 0.01 * (1 + s))


def circle(s):
    angle = s / RADIUS
    zero, one = np.zeros_like(s), np.ones_like(s)
    points = RADIUS * np.stack([np.sin(angle), zero, np.cos(angle)], axis=1)
    tangents = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
    normals = np.stack([np.sin(angle), zero, np.cos(angle)], axis=1)
    across = np.stack([zero, one, zero], axis=1)
    return points, np.stack([tangents, across, normals], axis=2)


def test_nothing_cut_is_the_same_object():
    curve = arc()
    assert trimmed(curve, (0.0, 0.0)) is curve


@given(ENDS, ENDS)
def test_what_is_left_lies_where_it_lay(start, end):
    left = trimmed(arc(), (start, end))
    assert left.strip.s[0] == pytest.approx(start)
    assert left.strip.s[-1] == pytest.approx(LENGTH - end)
    assert (np.diff(left.strip.s) > 0).all()
    points, frames = circle(left.strip.s)
    np.testing.assert_allclose(left.strip.points, points, atol=1e-8)
    np.testing.assert_allclose(left.strip.frames, frames, atol=1e-4)
    np.testing.assert_allclose(left.normal_sigma, 0.01 * (1 + left.strip.s))
    np.testing.assert_allclose(left.covariance[:, 1, 1], 1e-6 * (1 + left.strip.s))


@given(ENDS, ENDS)
def test_the_other_way_round_is_the_same(start, end):
    curve = arc()
    turned = Curve(curve.strip.reversed(), curve.covariance[::-1], curve.normal_sigma[::-1])
    one, other = trimmed(curve, (start, end)), trimmed(turned, (end, start))
    np.testing.assert_allclose(other.strip.points[::-1], one.strip.points, atol=1e-9)
    np.testing.assert_allclose(other.covariance[::-1], one.covariance, atol=1e-15)


def test_an_end_on_a_node_is_that_node():
    curve = arc()
    left = trimmed(curve, (float(curve.strip.s[3]), LENGTH - float(curve.strip.s[-5])))
    np.testing.assert_allclose(left.strip.s, curve.strip.s[3:-4], atol=1e-12)
