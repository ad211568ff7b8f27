"""A pass's smoothing: the slider, the number and the way back to automatic."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication

from georibbon import reconstruction
from georibbon.gui import smoothing
from georibbon.gui.smoothing import STEPS, SmoothingControl, to_metres, to_step
from georibbon.gui.units import Units


@pytest.fixture
def control(qtbot):
    made = SmoothingControl(Units(), "pass P1", "automatic")
    qtbot.addWidget(made)
    made.show_value(0.062, False, "automatic")
    made.seen = []
    made.previewed.connect(lambda metres: made.seen.append(("previewed", metres)))
    made.chosen.connect(lambda metres: made.seen.append(("chosen", metres)))
    made.reset.connect(lambda: made.seen.append(("reset", None)))
    return made


def test_the_limits_are_those_of_the_fit():
    assert smoothing.SHORTEST_SMOOTHING == reconstruction.SHORTEST_SMOOTHING
    assert smoothing.LONGEST_SMOOTHING == reconstruction.LONGEST_SMOOTHING


@given(st.integers(0, STEPS))
def test_a_step_is_a_length_and_back(step):
    assert to_step(to_metres(step)) == step


def test_the_slider_goes_from_5_to_1000_mm_in_equal_ratios():
    assert to_metres(0) == pytest.approx(0.005)
    assert to_metres(STEPS) == pytest.approx(1.0)
    assert to_metres(STEPS // 2) == pytest.approx((0.005 * 1.0) ** 0.5)
    assert to_step(0.0001) == 0
    assert to_step(50.0) == STEPS


def test_what_is_shown_is_not_asked_for(control):
    assert control.number.value() == 62
    assert to_metres(control.slider.value()) == pytest.approx(0.062, rel=0.02)
    assert control.back.isChecked()
    assert control.seen == []


def test_a_drag_is_seen_on_the_way_and_chosen_once(control):
    control.slider.setSliderDown(True)
    for step in (100, 110, 120):
        control.slider.setSliderPosition(step)
    assert [kind for kind, _ in control.seen] == ["previewed"] * 3
    control.show_value(0.5, True, "automatic")  # a result of an earlier place
    assert control.slider.value() == 120
    control.slider.setSliderDown(False)
    assert control.seen[-1] == ("chosen", pytest.approx(to_metres(120)))
    assert len(control.seen) == 4


def test_keys_choose_when_they_rest(control, qtbot):
    control.show()
    control.slider.setFocus()
    with qtbot.waitSignal(control.chosen):
        qtbot.keyClick(control.slider, Qt.Key.Key_Right)
        qtbot.keyClick(control.slider, Qt.Key.Key_Right)
        assert control.held
    assert [kind for kind, _ in control.seen] == ["previewed", "previewed", "chosen"]


def test_a_typed_number_is_chosen_as_it_is(control, qtbot):
    control.number.selectAll()
    qtbot.keyClicks(control.number, "85")
    assert control.seen == []
    qtbot.keyClick(control.number, Qt.Key.Key_Return)
    assert control.seen == [("chosen", pytest.approx(0.085))]


def test_back_to_automatic(control):
    control.show_value(0.1, True, "as all")
    assert control.back.text() == "as all"
    assert not control.back.isChecked()
    control.back.click()
    assert control.seen == [("reset", None)]
    control.back.click()  # it stays automatic
    assert control.back.isChecked()


def test_a_wheel_over_it_scrolls_the_table(control):
    control.show()
    for part in (control.slider, control.number):
        part.clearFocus()
        before = part.value()
        where = QPointF(part.rect().center())
        wheel = QWheelEvent(
            where, where, QPoint(0, 0), QPoint(0, 120), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(part, wheel)
        assert part.value() == before
    assert control.seen == []


def test_the_length_is_in_the_unit_in_use(control, qtbot):
    control._units.use("in")
    assert control.number.text() == "2.441 in"
    assert "0.197 in to 39.370 in" in control.slider.accessibleName()
    control.number.selectAll()
    qtbot.keyClicks(control.number, "4")
    qtbot.keyClick(control.number, Qt.Key.Key_Return)
    assert control.seen == [("chosen", pytest.approx(0.1016))]


def test_its_way_back_tells_what_it_is(control):
    control.show_value(0.1, True, "as all")
    assert control.back.toolTip() == "Back to as all"
    control.show_value(0.1, False, "automatic")
    assert control.back.toolTip() == "It is automatic"
    assert control.back.accessibleName() == "Smoothing of pass P1: automatic"
