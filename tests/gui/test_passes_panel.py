"""The choices of a pass below the table: weight, cut ends, sensors."""

from itertools import pairwise
from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt

from georibbon.fitting import assessment
from georibbon.fitting import settings as limits
from georibbon.gui import pass_details, sensor_list
from georibbon.gui.document import Document
from georibbon.gui.passes_panel import SIGMA, PassesPanel
from georibbon.gui.sensor_list import MEANING, OFF_BY, SENSOR
from georibbon.gui.units import Units
from georibbon.ribbon import Readings
from georibbon.session.settings import BY_PASS
from georibbon.session.source import load


def wait_for_result(panel, qtbot, act):
    with qtbot.waitSignal(panel._document.reconstructed, timeout=20000) as waited:
        act()
    return waited.args[0]


@pytest.fixture
def panel(qapp, qtbot, session):
    """The panel of an open session of three passes."""
    document, units = Document(qapp), Units(parent=qapp)
    made = PassesPanel(SimpleNamespace(document=document, units=units))
    qtbot.addWidget(made)
    made.resize(560, 700)
    made.show()
    wait_for_result(made, qtbot, lambda: document.open(session))
    yield made
    document.end()
    document.deleteLater()
    units.deleteLater()


def line(panel, name):
    """The line of a sensor."""
    (item,) = panel.details.sensors.findItems(name, Qt.MatchFlag.MatchExactly, SENSOR)
    return item


def switch(panel, qtbot, name):
    """Stand on a sensor and press the space bar."""
    sensors = panel.details.sensors
    sensors.setFocus()
    sensors.setCurrentItem(line(panel, name))
    qtbot.keyClick(sensors, Qt.Key.Key_Space)


def test_the_limits_are_those_of_the_core():
    assert pass_details.OF_PASS == BY_PASS
    assert (pass_details.LEAST_WEIGHT, pass_details.MOST_WEIGHT) == (
        limits.LEAST_WEIGHT,
        limits.MOST_WEIGHT,
    )
    assert sensor_list.NAMED == assessment.NAMED
    assert pytest.approx(assessment.IGNORED) == sensor_list.IGNORED


def test_without_anything_open_there_is_nothing_to_choose(qapp, qtbot):
    document, units = Document(qapp), Units(parent=qapp)
    made = PassesPanel(SimpleNamespace(document=document, units=units))
    qtbot.addWidget(made)
    assert not made.details.isEnabled()
    assert made.details.sensors.topLevelItemCount() == 0
    document.end()
    document.deleteLater()
    units.deleteLater()


def test_the_details_are_of_the_chosen_pass(panel):
    assert panel.details.title.text() == "All passes without their own"
    panel.table.selectRow(2)
    assert panel.details.title.text() == "Pass P2"
    panel.table.selectRow(0)
    assert panel.details.title.text() == "All passes without their own"


def test_a_sensor_is_switched_off_by_the_keyboard_and_on_again_by_undo(panel, qtbot, session):
    panel.table.selectRow(2)
    assert line(panel, "A03").text(MEANING) == "agrees"
    result = wait_for_result(panel, qtbot, lambda: switch(panel, qtbot, "A03"))
    assert result.passes[1].sensors_off == ("A03",)
    assert result.passes[0].sensors_off == ()
    assert line(panel, "A03").text(MEANING) == "switched off"
    assert line(panel, "A03").text(OFF_BY) == "–"
    assert panel.details.sensors.currentItem().text(SENSOR) == "A03"
    assert panel.details.switched_off.text() == "Sensors: 1 switched off, 0 disagree"
    assert load(session).settings.sensors_off == {"P2": ("A03",)}
    wait_for_result(panel, qtbot, lambda: switch(panel, qtbot, "M02"))
    assert panel._document.settings.sensors_off == {"P2": ("M02", "A03")}
    assert panel._document.undoable == "the switched-off sensors of pass P2"
    wait_for_result(panel, qtbot, panel._document.undo)
    assert line(panel, "M02").checkState(SENSOR) == Qt.CheckState.Checked
    wait_for_result(panel, qtbot, lambda: switch(panel, qtbot, "A03"))
    assert panel._document.values == {}


def test_one_that_is_off_in_all_passes_is_told_and_left_alone_in_each(panel, qtbot):
    wait_for_result(panel, qtbot, lambda: switch(panel, qtbot, "A03"))
    panel.table.selectRow(1)
    assert line(panel, "A03").text(MEANING) == "switched off in all passes"
    assert not line(panel, "A03").flags() & Qt.ItemFlag.ItemIsEnabled
    wait_for_result(panel, qtbot, lambda: switch(panel, qtbot, "M02"))
    assert panel._document.settings.sensors_off == {"*": ("A03",), "P1": ("M02",)}


def test_the_bad_sensor_is_seen(panel, qtbot):
    document = panel._document
    recording = document._source.recording()
    readings = recording.passes[0].readings
    i = [one.name for one in recording.ribbon.sensors].index("A03")
    counts = readings.counts.copy()
    counts[:, recording.ribbon.slices[i]] += 0.25 * recording.ribbon.sensors[i].counts_per_unit
    document.session.do("remove", **{"pass": "P1"})
    document.session.add_pass("P1", "pass", Readings(readings.t, counts))
    wait_for_result(panel, qtbot, document.captured)
    assert line(panel, "A03").text(MEANING).startswith("▲ disagrees")
    assert line(panel, "A03").text(OFF_BY).endswith("(P1)")
    assert line(panel, "A03").font(MEANING).bold()
    assert panel.details.switched_off.text() == "Sensors: 0 switched off, 1 disagrees"
    panel.details.sensors.sortByColumn(OFF_BY, Qt.SortOrder.DescendingOrder)
    assert panel.details.sensors.topLevelItem(0).text(SENSOR) == "A03"


def test_ends_are_cut_in_the_unit_in_use(panel, qtbot, session):
    panel._units.use("cm")
    panel.table.selectRow(1)
    box = panel.details.start
    box.selectAll()
    qtbot.keyClicks(box, "5")
    result = wait_for_result(panel, qtbot, lambda: qtbot.keyClick(box, Qt.Key.Key_Return))
    assert result.passes[0].strip.s[0] == pytest.approx(0.05)
    panel.details.end.setFocus()
    box = panel.details.end
    result = wait_for_result(panel, qtbot, lambda: qtbot.keyClick(box, Qt.Key.Key_Up))
    assert load(session).settings.trim == {"P1": (pytest.approx(0.05), pytest.approx(0.005))}
    panel.table.selectRow(2)
    assert panel.details.start.metres == 0.0


def test_a_weight_is_typed_and_the_pass_reset(panel, qtbot, session):
    panel.table.selectRow(3)
    details = panel.details
    assert not details.reset.isEnabled()
    details.weight.selectAll()
    qtbot.keyClicks(details.weight, "0.5")
    wait_for_result(panel, qtbot, lambda: qtbot.keyClick(details.weight, Qt.Key.Key_Return))
    assert load(session).settings.weight == {"P3": 0.5}
    wait_for_result(panel, qtbot, lambda: panel._document.set_smoothing("P3", 0.2))
    assert details.reset.isEnabled()
    wait_for_result(
        panel, qtbot, lambda: qtbot.mouseClick(details.reset, Qt.MouseButton.LeftButton)
    )
    assert panel._document.values == {}
    assert panel._document.undoable == "the settings of pass P3"
    assert details.weight.value() == 1.0


def test_lengths_follow_the_unit(panel):
    assert panel.table.horizontalHeaderItem(SIGMA).text() == "σ (mm)"
    before = float(panel.text("P1", SIGMA))
    panel._units.use("in")
    assert panel.table.horizontalHeaderItem(SIGMA).text() == "σ (in)"
    assert float(panel.text("P1", SIGMA)) == pytest.approx(before / 25.4, rel=0.01)
    assert line(panel, "A01").text(sensor_list.AT).endswith(" in")
    assert panel.details.start.suffix() == " in"


def test_everything_has_a_name_and_a_key(panel):
    details = panel.details
    for label, box in (
        (details.weight_label, details.weight),
        (details.start_label, details.start),
        (details.end_label, details.end),
    ):
        assert label.buddy() is box
        assert "&" in label.text()
        assert box.toolTip()
    assert details.sensors.accessibleName()
    assert details.sensors.focusPolicy() & Qt.FocusPolicy.TabFocus


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_no_part_of_a_line_lies_over_another(panel, qtbot, unit):
    panel._units.use(unit)
    panel.resize(panel.minimumSizeHint())
    control = panel.control("P1")
    qtbot.waitUntil(lambda: control.slider.width() >= control.slider.minimumWidth())
    parts = (control.slider, control.number, control.back)
    for one, following in pairwise(parts):
        assert one.geometry().right() < following.geometry().left()
    assert control.geometry().contains(control.back.geometry().translated(control.pos()))


def test_where_passes_are_fitted_from_tangents_nothing_is_smoothed(panel, qtbot):
    document = panel._document
    wait_for_result(panel, qtbot, lambda: document.set_setting("*", "method", "paper"))
    for name in ("*", "P1", "P2", "P3"):
        assert not panel.control(name).isEnabled()
        assert panel.control(name).toolTip()
    wait_for_result(panel, qtbot, document.undo)
    for name in ("*", "P1", "P2", "P3"):
        assert panel.control(name).isEnabled()
        assert panel.control(name).number.metres > 0.0
