"""The table of the surface's checks: all kinds, what is amiss first, its sentence, its passes."""

from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt

from georibbon.geometry.checks import Check
from georibbon.gui.checks_panel import CHECK, FOUND, NAMES, VERDICT, WHERE, ChecksPanel
from georibbon.reconstruction import reconstruct
from georibbon.session.folder import read_recording

DRAWN = Check("tear", "warn", 4.0, "", "P2-P3", "the surface between P2-P3 is drawn out")
LEVEL = [Check("fold", "pass", 0.9, "", f"P{k}-P{k + 1}", f"no fold {k}") for k in (1, 2)]


def result_with(*checks):
    """A result of three passes with a surface that has these checks."""
    passes = [SimpleNamespace(name=name) for name in ("P1", "P2", "P3")]
    return SimpleNamespace(passes=passes, surface=SimpleNamespace(checks=checks))


@pytest.fixture
def panel(qtbot):
    """The panel, shown."""
    made = ChecksPanel()
    qtbot.addWidget(made)
    made.resize(420, 300)
    made.show()
    return made


def lines(panel, column):
    """What stands in a column."""
    found = panel.list
    return [found.topLevelItem(k).text(column) for k in range(found.topLevelItemCount())]


def test_what_is_amiss_stands_first_and_what_passes_once_a_kind(panel):
    panel.show_result(result_with(*LEVEL, DRAWN))
    assert lines(panel, CHECK) == ["Tear", "Fold"]
    assert lines(panel, VERDICT) == ["warning", "passed"]
    assert lines(panel, WHERE) == ["P2-P3", "P1-P2 to P2-P3"]
    assert lines(panel, FOUND) == ["4", "0.9"]
    assert panel.message.toPlainText() == DRAWN.message


def test_a_line_that_is_chosen_names_its_passes(panel, qtbot):
    panel.show_result(result_with(*LEVEL, DRAWN))
    panel.list.setFocus()
    panel.list.setCurrentItem(panel.list.topLevelItem(0))
    with qtbot.waitSignal(panel.chosen) as told:
        qtbot.keyClick(panel.list, Qt.Key.Key_Return)
    assert told.args == [["P2", "P3"]]
    with qtbot.waitSignal(panel.chosen) as told:
        panel.list.itemClicked.emit(panel.list.topLevelItem(1), 0)
    assert told.args == [[]]


def test_the_keys_go_from_sentence_to_sentence(panel, qtbot):
    panel.show_result(result_with(*LEVEL, DRAWN))
    panel.list.setFocus()
    qtbot.keyClick(panel.list, Qt.Key.Key_Down)
    assert panel.message.toPlainText() == "no fold 1\nno fold 2"


def test_without_a_surface_it_says_so(panel):
    panel.show_result(result_with(DRAWN))
    for nothing in (None, SimpleNamespace(passes=[], surface=None)):
        panel.show_result(nothing)
        assert lines(panel, CHECK) == []
        assert panel.message.toPlainText() == "There is no surface to be checked."


def test_a_list_that_stays_keeps_its_line(panel):
    panel.show_result(result_with(*LEVEL, DRAWN))
    panel.list.setCurrentItem(panel.list.topLevelItem(1))
    panel.show_result(result_with(*LEVEL, DRAWN))
    assert panel.list.currentItem() is panel.list.topLevelItem(1)


def test_every_check_of_a_capture_has_a_name(panel, small_capture):
    result = reconstruct(read_recording(small_capture))
    panel.show_result(result)
    codes = {check.code for check in result.surface.checks}
    assert codes <= set(NAMES)
    assert {
        "heading-drift",
        "fold",
        "tear",
        "self-crossing",
        "pinch",
        "skew",
        "normal-turn",
    } <= codes
    assert sorted(lines(panel, CHECK)) == sorted(NAMES[code] for code in codes)
