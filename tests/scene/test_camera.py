"""Where the camera stands: laws of the framing, with the projection written out again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.scene.camera import Region, fit_view, view_direction
from georibbon.scene.colours import quantity_table, round_range, round_step


def project(view, points, aspect):
    """(n, 2) places in the picture, from -1 to 1, and (n,) depths."""
    forward = view.focus - view.position
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, view.up)
    relative = points - view.position
    depth = relative @ forward
    half = np.tan(view.angle / 2)
    x = relative @ right / (depth * half * aspect)
    return np.column_stack((x, relative @ view.up / (depth * half))), depth


@given(
    seed=st.integers(0, 10_000),
    aspect=st.floats(0.4, 3.0),
    right=st.floats(0.3, 1.0),
    squeeze=st.floats(0.01, 10.0),
)
def test_everything_is_inside_the_region_and_touches_two_opposite_edges(
    seed, aspect, right, squeeze
):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * np.array([1.0, squeeze, 0.3]) + rng.normal(size=3) * 5
    region = Region(left=0.9, right=right, bottom=0.8, top=0.95)
    direction = view_direction(rng.normal(size=(4, 3)))
    at, depth = project(fit_view(points, direction, aspect, region), points, aspect)
    low, high = at.min(axis=0), at.max(axis=0)
    assert depth.min() > 0
    slack_low = low + np.array([region.left, region.bottom])
    slack_high = np.array([region.right, region.top]) - high
    assert min(slack_low.min(), slack_high.min()) > -1e-9
    assert min(slack_low[0] + slack_high[0], slack_low[1] + slack_high[1]) < 1e-9


@given(
    seed=st.integers(0, 10_000),
    aspect=st.floats(0.4, 3.0),
    vertical=st.sampled_from([None, 1.0, -1.0]),
)
def test_in_parallel_everything_is_inside_in_front_and_touches_two_opposite_edges(
    seed, aspect, vertical
):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * np.array([1.0, 0.5, 2.0])
    direction = view_direction(rng.normal(size=(4, 3)))
    if vertical is not None:
        direction = np.array([0.0, 0.0, vertical])
    region = Region(left=0.9, right=0.6, bottom=0.8, top=0.95)
    view = fit_view(points, direction, aspect, region, parallel=True)
    relative = points - view.focus
    x = relative @ np.cross(view.up, direction) / (aspect * view.half_height)
    y = relative @ view.up / view.half_height
    slack = np.array([region.left + x, region.right - x, region.bottom + y, region.top - y])
    left, right, bottom, top = slack.min(axis=1)
    assert min(left, right, bottom, top) > -1e-9
    assert min(left + right, bottom + top) < 1e-9
    assert np.min((view.position - points) @ direction) > 0


@pytest.mark.parametrize("height", [1.0, -1.0])
def test_looking_along_z_north_is_up(height):
    points = np.random.default_rng(0).normal(size=(9, 3))
    view = fit_view(points, np.array([0.0, 0.0, height]), 1.5, Region())
    assert view.up == pytest.approx([0, 1, 0])


@pytest.mark.parametrize("towards", [1, -1])
def test_the_camera_stands_on_the_side_the_normals_point_to(towards):
    direction = view_direction(np.tile([0.0, 0.0, float(towards)], (5, 1)))
    assert direction[2] * towards > 0
    assert np.linalg.norm(direction) == pytest.approx(1)


def test_a_closed_object_is_seen_from_above():
    sphere = np.random.default_rng(1).normal(size=(1000, 3))
    sphere = np.concatenate((sphere, -sphere))
    assert view_direction(sphere)[2] > 0


@given(low=st.floats(0, 100), width=st.floats(1e-6, 1e4))
def test_a_round_range_holds_the_range_in_few_round_steps(low, width):
    start, end, step = round_range(low, low + width)
    assert start <= low * (1 + 1e-6) + 1e-6 * step
    assert end >= (low + width) * (1 - 1e-6) - 1e-6 * step
    assert step > 0
    assert 1 <= round((end - start) / step) <= 8
    mantissa = step / 10 ** np.floor(np.log10(step * (1 + 1e-9)))
    assert min(abs(mantissa - m) for m in (1, 2, 5)) < 1e-6


def test_a_range_without_width_still_has_a_scale():
    assert round_range(0.5, 0.5)[0] == 0
    assert round_range(0.0, 0.0) == pytest.approx((0.0, 1.0, 0.2))


def test_steps_are_the_coarsest_needed():
    assert round_step(1.0, 12) == pytest.approx(0.1)
    assert round_step(0.95, 12) == pytest.approx(0.1)
    assert round_step(1.3, 12) == pytest.approx(0.2)


def test_the_colours_get_lighter_from_end_to_end_and_are_viridis():
    import matplotlib as mpl

    table = quantity_table()
    lightness = table @ np.array([0.2126, 0.7152, 0.0722])
    assert np.all(np.diff(lightness) > -0.5)
    reference = mpl.colormaps["viridis"](np.arange(256))[:, :3] * 255
    assert np.max(np.abs(table - reference)) <= 3.0
