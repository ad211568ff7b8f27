"""What a capture shows of itself while it goes on: with a result and before there is one."""

from dataclasses import replace

import numpy as np
import pytest

import synthetic
from georibbon.scene.colours import WHITE
from georibbon.scene.drawing import CaptureDrawing
from georibbon.scene.offscreen import drawn, offscreen_window, pixels
from georibbon.scene.scene import Scene

SIZE = (480, 300)
RESULT = synthetic.reconstruction()
TAKEN = tuple((one.name, one.kind, one.strip.points) for one in RESULT.passes)
LIVE = ("P9", TAKEN[0][2] + [0.0, -0.15, 0.02])


def picture(result, drawing):
    scene = Scene(result)
    scene.show_capture(drawing)
    scene.frame(SIZE[0] / SIZE[1])
    return drawn(scene, SIZE)


def count(pixels, colour):
    """How many pixels have about a colour (0 to 1 each)."""
    away = np.abs(pixels.astype(float) - 255 * np.array(colour)).max(axis=-1)
    return int((away < 50).sum())


@pytest.mark.parametrize("result", [None, RESULT])
def test_the_live_curve_and_its_neighbour_stand_out(result):
    bare = picture(result, CaptureDrawing(TAKEN[:2]))
    full = picture(result, CaptureDrawing(TAKEN[:2], LIVE, "P1"))
    for colour in (WHITE.live, WHITE.neighbour):
        assert count(full, colour) > count(bare, colour) + 100


@pytest.mark.parametrize(
    "drawing",
    [
        CaptureDrawing(),
        CaptureDrawing((), LIVE),
        CaptureDrawing(TAKEN[:1]),
        CaptureDrawing((("P1", "pass", np.full((5, 3), np.nan)),), ("P2", np.zeros((0, 3)))),
        CaptureDrawing((), ("P2", np.zeros((4, 3)))),
    ],
)
def test_little_or_nothing_is_drawn_without_complaint(drawing):
    assert np.ptp(picture(None, drawing)) > 0


def test_what_the_result_holds_is_not_drawn_twice():
    scene = Scene(RESULT)
    scene.show_capture(CaptureDrawing(TAKEN))
    again = Scene(RESULT)
    for one in (scene, again):
        one.frame(1.6)
    assert np.array_equal(drawn(scene, SIZE), drawn(again, SIZE))


def test_a_live_curve_is_written_into_the_arrays_that_are_there():
    scene = Scene(None)
    scene.show_capture(CaptureDrawing(TAKEN, LIVE))
    held = scene._runs["live"].body.points
    moved = ("P9", LIVE[1] + [0.01, 0.0, 0.0])
    floor_changed = scene.show_capture(CaptureDrawing(TAKEN, moved))
    assert scene._runs["live"].body.points is held
    assert not floor_changed
    assert held[0, 0] == pytest.approx(held[:, 0].min(), abs=0.02)
    scene.show_capture(None)
    assert not scene._runs["live"].body.actor.GetVisibility()


def test_a_curve_far_away_gets_a_floor_of_its_own():
    scene = Scene(None)
    assert scene.show_capture(CaptureDrawing(TAKEN[:1]))
    assert scene.show_capture(CaptureDrawing(TAKEN[:1], ("P2", LIVE[1] + [0.0, 2.0, 0.0])))


def test_a_ribbon_in_the_hand_does_not_make_the_floor_jump():
    scene = Scene(None)
    scene.show_capture(CaptureDrawing(TAKEN, LIVE, "P1"))
    lifted = ("P9", LIVE[1] + [0.0, -0.05, 0.15])
    assert not scene.show_capture(CaptureDrawing(TAKEN, lifted, "P1"))
    assert not scene.show_capture(CaptureDrawing(TAKEN, None, "P1"))
    assert scene.show_capture(CaptureDrawing(TAKEN, ("P9", LIVE[1] + [0.0, -1.0, 0.0])))


def test_a_much_smaller_object_gets_a_smaller_floor():
    scene = Scene(None)
    scene.show_capture(CaptureDrawing(TAKEN))
    assert scene.show_capture(CaptureDrawing((("P1", "pass", TAKEN[0][2][:20]),)))


@pytest.mark.parametrize("number", [5, 20, 60])
def test_however_many_curves_there_are_none_has_gaps(number):
    s = np.linspace(0.0, 1.0, 60)
    begins = np.linspace(0.0, 1.2, number)
    flat = [np.stack((s, y + 0.2 * s, 0.0 * s), axis=1) for y in begins]
    scene = Scene(None)
    scene.show_capture(CaptureDrawing(tuple((f"P{k}", "pass", at) for k, at in enumerate(flat))))
    scene.apply(replace(scene.look, shown=frozenset({"passes"})))
    scene.frame(1.0, np.array([0.0, 0.0, 1.0]))
    window = offscreen_window((400, 400))
    window.SetMultiSamples(0)  # as the live view is drawn
    scene.attach(window)
    window.Render()
    dark = pixels(window).astype(int).sum(axis=-1) < 600
    window.Finalize()
    columns = np.nonzero(dark[:, :230].sum(axis=0) >= number)[0]
    middle = dark[:, columns.min() + 5 : columns.max() - 5]
    found = np.count_nonzero(middle[1:] & ~middle[:-1], axis=0)
    assert middle.shape[1] > 100
    assert np.all(found == number)
