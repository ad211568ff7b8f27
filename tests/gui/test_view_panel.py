"""The 3D view's panel, worked by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QWidget

import synthetic
from georibbon.gui.notifier import Notifier
from georibbon.gui.scene_view import PARTS, ImageView
from georibbon.gui.theme import palette
from georibbon.gui.units import Units
from georibbon.gui.view_panel import ViewPanel

RESULT = synthetic.reconstruction()
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def both(qtbot):
    """A view with a result, from above, and its panel beside it."""
    place = QWidget()
    row = QHBoxLayout(place)
    units = Units()
    view = ImageView()
    notifier = Notifier()
    panel = ViewPanel(SimpleNamespace(units=units, notifier=notifier), view)
    panel.units, panel.notifier = units, notifier
    row.addWidget(view, 1)
    row.addWidget(panel)
    panel.setFixedWidth(330)
    place.resize(860, 700)
    qtbot.addWidget(place)
    with qtbot.waitExposed(place):
        place.show()
    view.show_scene(RESULT)
    view.standard_view("top")
    view.place_held = place
    return view, panel


def choose(panel, mode, qtbot):
    combo = panel.colouring
    combo.setFocus()
    while combo.currentData() != mode:
        before = combo.currentIndex()
        qtbot.keyClick(combo, Qt.Key.Key_Down)
        assert combo.currentIndex() != before


def touch(view, qtbot, *shares):
    for x, y in shares:
        at = QPoint(round(x * view.width()), round(y * view.height()))
        qtbot.mouseClick(view, LEFT, pos=at)


def test_colours_are_chosen_and_say_what_they_mean(both, qtbot):
    view, panel = both
    choose(panel, "mean", qtbot)
    assert view.colouring == "mean"
    assert "bends" in panel.meaning.text()
    assert panel.low.suffix() == " 1/m"
    assert panel.low.value() == pytest.approx(-panel.high.value())
    view.set_colouring("zebra")
    assert panel.colouring.currentData() == "zebra"
    assert not panel.fixed.isVisibleTo(panel)


def test_a_range_is_fixed_typed_and_let_go(both, qtbot):
    view, panel = both
    assert not panel.low.isEnabled()
    automatic = view.range()
    qtbot.mouseClick(panel.fixed, LEFT, pos=QPoint(8, panel.fixed.height() // 2))
    assert view.fixed_range == pytest.approx(automatic)
    panel.high.setFocus()
    panel.high.lineEdit().selectAll()
    qtbot.keyClicks(panel.high, "2.5")
    qtbot.keyClick(panel.high, Qt.Key.Key_Return)
    assert view.range()[1] == pytest.approx(0.0025)
    panel.low.setFocus()
    panel.low.lineEdit().selectAll()
    qtbot.keyClicks(panel.low, "9")
    qtbot.keyClick(panel.low, Qt.Key.Key_Return)
    assert "below" in panel.meaning.text()
    assert view.range()[1] == pytest.approx(0.0025)
    qtbot.mouseClick(panel.fixed, LEFT, pos=QPoint(8, panel.fixed.height() // 2))
    assert view.fixed_range is None
    assert "below" not in panel.meaning.text()


def test_units_are_followed(both, qtbot):
    view, panel = both
    view.set_range((0.0, 0.00254))
    view.set_tool("point")
    touch(view, qtbot, (0.4, 0.5))
    assert " mm" in panel.results.text()
    panel.units.use("in")
    assert panel.high.value() == pytest.approx(0.1)
    assert panel.high.suffix() == " in"
    assert view.range() == pytest.approx((0.0, 0.00254))
    assert " in" in panel.results.text()
    assert " mm" not in panel.results.text()


def test_every_part_is_switched(both, qtbot):
    view, panel = both
    assert set(panel.shown) == set(PARTS)
    for part, check in panel.shown.items():
        before = view.is_shown(part)
        check.setFocus()
        qtbot.keyClick(check, Qt.Key.Key_Space)
        assert view.is_shown(part) is not before
        assert check.isChecked() is not before
    view.set_shown("floor", True)
    assert panel.shown["floor"].isChecked()


def test_tools_are_taken_up_and_put_down(both, qtbot):
    view, panel = both
    qtbot.mouseClick(panel.tools["distance"], LEFT)
    assert view.tool == "distance"
    assert panel.hint.text() == "Click the first place."
    qtbot.mouseClick(panel.tools["point"], LEFT)
    assert view.tool == "point"
    assert not panel.tools["distance"].isChecked()
    qtbot.mouseClick(panel.tools["point"], LEFT)
    assert view.tool == "none"
    view.set_tool("section")
    view.setFocus()
    qtbot.keyClick(view, Qt.Key.Key_Escape)
    assert not any(button.isChecked() for button in panel.tools.values())


def test_what_is_found_is_listed_copied_and_cleared(both, qtbot):
    view, panel = both
    assert not panel.copy_button.isEnabled()
    view.set_tool("point")
    touch(view, qtbot, (0.4, 0.5), (0.45, 0.5))
    view.set_tool("distance")
    with qtbot.waitSignal(view.measured):
        touch(view, qtbot, (0.35, 0.5), (0.5, 0.5))
    assert panel.results.count() == 3
    qtbot.mouseClick(panel.copy_button, LEFT)
    words = QGuiApplication.clipboard().text()
    for part in ("Point 1", "Point 2", "Distance 1", "along the surface", "nearest pass", "1σ"):
        assert part in words
    panel.results.setFocus()
    panel.results.setCurrentRow(1)
    qtbot.keyClick(panel.results, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert QGuiApplication.clipboard().text().startswith("Point 2\n")
    assert "Distance" not in QGuiApplication.clipboard().text()
    qtbot.mouseClick(panel.clear_button, LEFT)
    assert panel.results.count() == 0
    assert not panel.clear_button.isEnabled()


def test_a_section_has_a_profile_and_can_be_had_as_a_file(both, qtbot):
    view, panel = both
    assert not panel.export_button.isEnabled()
    view.set_tool("section")
    with qtbot.waitSignal(view.sectioned) as told:
        touch(view, qtbot, (0.35, 0.5), (0.5, 0.45))
    section = told.args[0]
    drawn = panel.profile._line.getData()
    assert np.allclose(drawn[0], 1e3 * section.across)
    assert panel.profile.isVisibleTo(panel)
    with qtbot.waitSignal(panel.section_export) as asked:
        qtbot.mouseClick(panel.export_button, LEFT)
    assert asked.args[0] is section
    panel.units.use("cm")
    assert np.allclose(panel.profile._line.getData()[1], 1e2 * section.height)
    panel.profile.setPalette(palette("dark"))
    qtbot.mouseClick(panel.clear_button, LEFT)
    assert not panel.profile.isVisibleTo(panel)


def test_what_to_compare_with_is_asked_for(both, qtbot):
    view, panel = both
    view.set_colouring("deviation")
    assert "Choose below" in panel.meaning.text()
    view.set_deviation(np.zeros(len(RESULT.surface.mesh.vertices)), "from A")
    assert "compared" in panel.meaning.text()
    assert "Choose" not in panel.meaning.text()
    for button, signal in (
        (panel.from_session, panel.deviation_from_session),
        (panel.from_mesh, panel.deviation_from_mesh),
    ):
        with qtbot.waitSignal(signal):
            qtbot.mouseClick(button, LEFT)


def test_everything_can_be_reached_by_tab_and_has_a_name(both, qtbot):
    _, panel = both
    panel.colouring.setFocus()
    reached = set()
    for _ in range(40):
        focused = panel.focusWidget()
        reached.add(focused)
        qtbot.keyClick(focused, Qt.Key.Key_Tab)
    expected = {panel.colouring, panel.fixed, panel.from_session, panel.from_mesh, panel.upright,
                panel.results, *panel.shown.values(), *panel.tools.values()}  # fmt: skip
    assert expected <= reached
    for unnamed in (panel.low, panel.high, panel.results):
        assert unnamed.accessibleName()


def test_a_fault_in_a_tool_is_told(both):
    view, panel = both
    view.tools.fault.emit(RuntimeError("it broke"))
    assert "it broke" in panel.notifier.entries[-1].detail
