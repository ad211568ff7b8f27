"""What the colours stand for: values, ranges, titles, and changing them in place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import synthetic
from georibbon.scene.colouring import (
    MODES,
    PARTS,
    SHOWN_FIRST,
    SIGNED,
    Look,
    range_of,
    scene_values,
)
from georibbon.scene.colours import DARK, WHITE, signed_table, zebra_table
from georibbon.scene.offscreen import drawn
from georibbon.scene.places import sensor_places
from georibbon.scene.scene import Scene
from georibbon.scene.shapes import ball, die
from georibbon.scene.zebra import mirrored_height

SIZE = (480, 300)
RESULT = synthetic.reconstruction()
GRID = replace(RESULT, surface=replace(RESULT.surface, shape=(61, 97)))
COUNT = len(RESULT.surface.mesh.vertices)


def moved(result, by):
    """The result shifted, with as many points and triangles."""
    passes = tuple(
        replace(one, strip=replace(one.strip, points=one.strip.points + by))
        for one in result.passes
    )
    mesh = replace(result.surface.mesh, vertices=result.surface.mesh.vertices + by)
    return replace(result, passes=passes, surface=replace(result.surface, mesh=mesh))


def picture(scene):
    scene.frame(SIZE[0] / SIZE[1])
    return drawn(scene, SIZE).astype(int)


@pytest.mark.parametrize("mode", MODES)
def test_every_mode_is_drawn_and_a_switch_in_place_draws_the_same(mode):
    deviation = 1e-3 * RESULT.surface.mesh.vertices[:, 1]
    look = Look(mode, deviation=deviation, deviation_words="from A")
    switched = Scene(GRID)
    switched.apply(look)
    assert np.abs(picture(switched) - picture(Scene(GRID, look=look))).max() == 0
    differ = np.abs(picture(switched) - picture(Scene(GRID, look=Look("plain")))).max(axis=-1) > 40
    assert differ.mean() > 0.05 if mode != "plain" else not differ.any()


def test_an_update_writes_into_the_arrays_that_are_there_and_draws_the_same():
    scene = Scene(GRID)
    held = [scene._surface.points, scene._runs["passes"].body.points]
    other = moved(GRID, [0.004, 0.0, 0.002])
    assert not scene.update(other)
    assert held[0] is scene._surface.points
    assert held[1] is scene._runs["passes"].body.points
    assert held[0] == pytest.approx(other.surface.mesh.vertices, abs=1e-6)
    anew = Scene(other)
    for one in (scene, anew):
        one.apply(Look(shown=SHOWN_FIRST - {"floor"}))
        one.frame(1.6)
    camera = anew.renderer.GetActiveCamera()
    scene.renderer.GetActiveCamera().DeepCopy(camera)
    differ = np.abs(drawn(scene, SIZE).astype(int) - drawn(anew, SIZE)).max(axis=-1) > 40
    assert differ.mean() < 0.002


def test_another_result_may_have_another_size_or_no_surface():
    scene = Scene(GRID)
    assert scene.update(moved(GRID, [3.0, 0.0, 0.0]))
    bare = replace(GRID, surface=None, passes=GRID.passes[:2])
    scene.update(bare)
    assert not scene._surface.actor.GetVisibility()
    assert (np.abs(picture(scene) - picture(Scene(bare))).max(axis=-1) > 40).mean() < 0.002
    scene.update(None)
    assert not scene._runs["passes"].body.actor.GetVisibility()
    scene.update(GRID)
    assert scene._surface.actor.GetVisibility()


def test_the_made_up_bonnet_is_domed_along_as_its_formula_says():
    """z = 0.1 - 0.22 (x - 0.35)²: k = z'' / (1 + z'²)^(3/2) along the middle pass."""
    values = scene_values(GRID, Look("normal")).reshape(61, 97)
    # The grid's rows run across here: the passes' direction is the second index.
    bend = scene_values(replace(GRID, surface=replace(GRID.surface, shape=(61, 97))), Look("mean"))
    assert np.isfinite(values).all()
    x = np.linspace(0, 1, 97) * synthetic.LENGTH * 0.97
    expected = -0.44 / (1 + (0.44 * (x - 0.35)) ** 2) ** 1.5
    across = 2 * bend.reshape(61, 97)[30] - expected
    assert np.ptp(across) < 0.05  # what is left bends across, alike everywhere


@given(
    values=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30),
    mode=st.sampled_from(SIGNED),
    metres=st.sampled_from([1e-3, 0.0254]),
)
def test_signed_ranges_lie_even_about_zero_and_hold_most_values(values, mode, metres):
    look = Look(mode, metres=metres)
    low, high, step = range_of(np.array([*values, np.nan]), look)
    assert low == -high
    assert high > 0
    held = np.abs(np.array(values)) / look.unit <= high * (1 + 1e-9)
    assert held.mean() >= 0.9 or len(values) < 10
    assert round((high - low) / step) <= 16


def test_a_fixed_range_is_kept_in_every_unit():
    for symbol, metres in (("mm", 1e-3), ("in", 0.0254)):
        look = Look("uncertainty", {"uncertainty": (0.0, 0.002)}, symbol=symbol, metres=metres)
        scene = Scene(RESULT, look=look)
        assert scene.range == pytest.approx((0.0, 0.002))
        assert scene._bar.actor.GetLookupTable().GetRange() == pytest.approx((0, 0.002 / metres))
        assert f"1σ, {symbol}" in scene._bar.actor.GetTitle()


def test_what_is_not_known_has_no_scale_and_a_deviation_of_another_mesh_is_not_shown():
    for look in (Look("deviation"), Look("deviation", deviation=np.zeros(COUNT + 1))):
        assert scene_values(RESULT, look) is None
        assert not Scene(RESULT, look=look)._bar.actor.GetVisibility()
    empty = Look("deviation", deviation=np.full(COUNT, np.nan))
    assert range_of(scene_values(RESULT, empty), empty) == (0.0, 1.0, 0.2)
    Scene(RESULT, look=empty)


@pytest.mark.parametrize("part", PARTS)
def test_every_part_can_be_hidden(part):
    paper = DARK if part in PARTS[::2] else WHITE
    everything = Scene(RESULT, look=Look(shown=frozenset(PARTS)), paper=paper)
    without = Scene(RESULT, look=Look(shown=frozenset(PARTS) - {part}), paper=paper)
    assert np.abs(picture(everything) - picture(without)).max() > 40


def test_sensors_that_are_left_out_have_another_shape_and_colour():
    scene = Scene(RESULT, look=Look(shown=frozenset(PARTS)))
    found = sensor_places(RESULT)
    assert len(scene._sensors.points) == found.used.sum() * len(ball(cuts=1).points)
    assert len(scene._unused.points) == len(RESULT.passes) * len(die().points)  # M04 on each
    strip, place = RESULT.passes[0].strip, RESULT.ribbon.sensors[7].position
    middle = scene._unused.points[: len(die().points)].mean(axis=0)
    expected = [np.interp(place, strip.s, strip.points[:, k]) for k in range(3)]
    assert middle == pytest.approx(expected, abs=1e-6)
    assert np.all((found.frames.swapaxes(1, 2) @ found.frames).round(6) == np.eye(3))


def test_the_signed_map_is_darkest_at_both_ends_and_as_dark():
    lightness = signed_table() @ np.array([0.2126, 0.7152, 0.0722])
    assert np.all(np.diff(lightness[:128]) > -0.5)
    assert np.all(np.diff(lightness[128:]) < 0.5)
    assert lightness[0] == pytest.approx(lightness[-1], abs=25)
    assert signed_table()[0][2] > 100 > signed_table()[0][0]  # blue below
    assert signed_table()[-1][0] > 100 > signed_table()[-1][2]  # red above


def test_stripes_are_dark_and_light_by_turns():
    grey = zebra_table(stripes=8, size=800)[:, 0].astype(float)
    assert grey.min() < 60
    assert grey.max() > 200
    assert np.sum(np.diff(np.sign(grey - 135.0)) != 0) == pytest.approx(8, abs=1)


def test_a_mirror_sends_the_sight_back_as_steep_as_it_came():
    up = np.array([0.0, 0.0, 1.0])
    sight = np.array([[np.sin(0.3), 0.0, np.cos(0.3)]])
    assert mirrored_height(up[None], sight, up) == pytest.approx(np.cos(0.3))
    tilted = np.array([[np.sin(0.3), 0.0, np.cos(0.3)]])
    assert mirrored_height(tilted, sight, up) == pytest.approx(np.cos(0.3))
    assert mirrored_height(tilted, up[None], up) == pytest.approx(np.cos(0.6))
