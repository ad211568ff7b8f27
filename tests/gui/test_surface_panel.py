"""The surface's settings in the window."""

from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from georibbon.export.surfaces import surface_with
from georibbon.geometry import settings as geometry
from georibbon.gui import surface_panel
from georibbon.gui.document import Document
from georibbon.gui.surface_panel import OWN, SurfacePanel
from georibbon.gui.units import Units
from georibbon.reconstruction import METHODS
from georibbon.session.file import create_session
from georibbon.session.source import load
from georibbon.simulation import LayoutSettings, RibbonSettings, SimulationSettings, simulate


def wait_for_result(panel, qtbot, act):
    with qtbot.waitSignal(panel._document.reconstructed, timeout=20000) as waited:
        act()
    return waited.args[0]


@pytest.fixture
def panel(qapp, qtbot, session):
    """The panel of an open session."""
    document, units = Document(qapp), Units(parent=qapp)
    made = SurfacePanel(SimpleNamespace(document=document, units=units))
    qtbot.addWidget(made)
    made.resize(380, 600)
    made.show()
    assert not made.isEnabled()
    wait_for_result(made, qtbot, lambda: document.open(session))
    yield made
    document.end()
    document.deleteLater()
    units.deleteLater()


@pytest.fixture
def tied(tmp_path):
    """A session file of a small capture with ties: 3 passes, 2 ties."""
    settings = SimulationSettings(
        surface="dome",
        seed=3,
        ribbon=RibbonSettings(sensors=16, length=0.6),
        frames=40,
        layout=LayoutSettings(passes=3, ties=2),
    )
    path = tmp_path / "tied.georibbon"
    create_session(path, simulate(settings).recording)
    return path


def choose(box, qtbot, word):
    """Go to a word of a list with the keys, and take it."""
    box.setFocus()
    key = Qt.Key.Key_Down if box.findData(word) > box.currentIndex() else Qt.Key.Key_Up
    for _ in range(abs(box.findData(word) - box.currentIndex())):
        qtbot.keyClick(box, key)


def test_every_word_of_the_settings_can_be_chosen():
    for choices, words in (
        (surface_panel.DIRECTIONS, geometry.DIRECTIONS),
        (surface_panel.LENGTHS, (*geometry.LENGTHS, OWN)),
        (surface_panel.CORRESPONDENCES, geometry.CORRESPONDENCES),
        (surface_panel.INTERIORS, geometry.INTERIORS),
        (surface_panel.METHODS, METHODS),
        (surface_panel.TANGENTS, geometry.TANGENTS),
    ):
        assert [word for word, _, _ in choices] == list(words)
        assert len({name for _, name, _ in choices}) == len(choices)


@pytest.mark.parametrize(
    ("name", "key", "word"),
    [
        ("direction", "surface.direction", "chord"),
        ("lengths", "surface.lengths", "unit"),
        ("correspondence", "surface.correspondence", "foot-trim"),
        ("interior", "surface.interior", "c1-lines"),
        ("method", "method", "paper"),
    ],
)
def test_a_word_is_chosen_by_the_keyboard_kept_and_undone(panel, qtbot, session, name, key, word):
    box = getattr(panel, name)
    usual = box.currentData()
    wait_for_result(panel, qtbot, lambda: choose(box, qtbot, word))
    assert load(session).values == {("*", key): word}
    assert box.currentData() == word
    assert box.toolTip()
    wait_for_result(panel, qtbot, panel._document.undo)
    assert box.currentData() == usual
    wait_for_result(panel, qtbot, panel._document.redo)
    wait_for_result(panel, qtbot, lambda: choose(box, qtbot, usual))
    assert panel._document.values == {}  # what is usual is no choice


def test_a_tolerance_is_typed_in_the_unit_in_use(panel, qtbot, session):
    before = panel._document.reconstruction.surface.mesh
    panel.tolerance.selectAll()
    qtbot.keyClicks(panel.tolerance, "0.5")
    result = wait_for_result(
        panel, qtbot, lambda: qtbot.keyClick(panel.tolerance, Qt.Key.Key_Return)
    )
    assert len(result.surface.mesh.triangles) <= len(before.triangles)
    assert load(session).settings.surface.tolerance == pytest.approx(0.0005)
    panel._units.use("cm")
    assert panel.tolerance.text() == "0.050 cm"


def test_a_solid_has_a_thickness(panel, qtbot):
    assert panel._document.reconstruction.surface.solid is None
    result = wait_for_result(panel, qtbot, panel.solid.click)
    assert result.surface.solid is not None
    assert panel._document.settings.surface.thickness == pytest.approx(0.002)
    panel.thickness.setFocus()
    wait_for_result(panel, qtbot, lambda: qtbot.keyClick(panel.thickness, Qt.Key.Key_Up))
    assert panel._document.settings.surface.thickness == pytest.approx(0.0025)
    result = wait_for_result(panel, qtbot, panel.solid.click)
    assert result.surface.solid is None
    assert panel._document.values == {}


def test_why_there_is_no_surface_is_told_where_it_was_asked_for(panel, qtbot):
    document = panel._document
    with qtbot.waitSignal(document.failed, timeout=20000):
        document.set_setting("P1", "trim", [1.0, 1.0])
    assert panel.failure.text() == ""  # nothing was asked for here
    with qtbot.waitSignal(document.failed, timeout=20000) as waited:
        choose(panel.interior, qtbot, "g2")
    assert panel.failure.text() == waited.args[0]
    wait_for_result(panel, qtbot, lambda: document.set_setting("P1", "trim", None))
    assert panel.failure.text() == ""


def test_own_angles_and_factors_are_there_where_they_count(panel, qtbot):
    assert not panel.angles[0].isVisible()
    assert not panel.factors[0].isVisible()
    wait_for_result(panel, qtbot, lambda: choose(panel.direction, qtbot, "angles"))
    assert panel.angles[0].isVisible()
    box = panel.angles[1]
    box.selectAll()
    qtbot.keyClicks(box, "12.5")
    wait_for_result(panel, qtbot, lambda: qtbot.keyClick(box, Qt.Key.Key_Return))
    assert panel._document.settings.surface.angles == (0.0, 12.5, 0.0, 0.0)
    wait_for_result(panel, qtbot, lambda: panel._chosen("surface.lengths", OWN))
    assert panel.factors[1].isVisible()
    panel.factors[1].setFocus()
    wait_for_result(panel, qtbot, lambda: qtbot.keyClick(panel.factors[1], Qt.Key.Key_Up))
    lengths = panel._document.settings.surface.lengths
    assert lengths[1] - lengths[0] == pytest.approx(0.05)
    assert panel.lengths.currentData() == OWN


def test_what_another_choice_takes_the_place_of_cannot_be_chosen(panel, qtbot):
    wait_for_result(panel, qtbot, lambda: choose(panel.interior, qtbot, "g2"))
    assert not panel.direction.isEnabled()
    assert not panel.lengths.isEnabled()
    assert "another setting" in panel.direction.toolTip()
    wait_for_result(panel, qtbot, lambda: choose(panel.method, qtbot, "paper"))
    assert not panel.neighbours.isEnabled()


def test_tangents_are_asked_for_where_passes_come_of_them(panel, qtbot, session):
    assert not panel.tangents.isVisible()
    wait_for_result(panel, qtbot, lambda: choose(panel.method, qtbot, "paper"))
    assert panel.tangents.isVisible()
    result = wait_for_result(panel, qtbot, lambda: choose(panel.tangents, qtbot, "averages"))
    assert result.tangents == "averages"
    assert load(session).values[("*", "tangents")] == "averages"
    wait_for_result(panel, qtbot, panel._document.undo)
    assert panel.tangents.currentData() == "unrolled"


def test_neighbours_are_asked_or_not(panel, qtbot, session):
    wait_for_result(panel, qtbot, panel.neighbours.click)
    assert load(session).values == {("*", "neighbours"): False}
    wait_for_result(panel, qtbot, panel.neighbours.click)
    assert load(session).values == {}


def test_cells_need_ties(panel):
    assert not panel.cells.isEnabled()
    assert "ties" in panel.cells.toolTip()


def test_cells_are_asked_for_kept_and_undone_where_there_are_ties(panel, qtbot, tied):
    wait_for_result(panel, qtbot, lambda: panel._document.open(tied))
    assert panel.cells.isEnabled()
    result = wait_for_result(panel, qtbot, panel.cells.click)
    found = [one for one in result.surface.checks if one.code == "cells"]
    assert [one.value for one in found] == [1.0, 1.0]
    assert load(tied).values == {("*", "surface.cells"): True}
    again = surface_with(result, panel._document.settings.surface)  # as the export makes it
    assert [one.message for one in again.checks] == [one.message for one in result.surface.checks]
    assert panel._document.undoable == "the surface's cells between passes and ties"
    wait_for_result(panel, qtbot, lambda: choose(panel.interior, qtbot, "c1-lines"))
    assert panel.cells.isEnabled()  # to be taken back
    assert "G1" in panel.cells.toolTip()
    wait_for_result(panel, qtbot, panel._document.undo)
    result = wait_for_result(panel, qtbot, panel._document.undo)
    assert not panel.cells.isChecked()
    assert not [one for one in result.surface.checks if one.code == "cells"]


def test_the_surface_is_reset_and_nothing_else(panel, qtbot):
    document = panel._document
    assert not panel.reset.isEnabled()
    wait_for_result(
        panel,
        qtbot,
        lambda: document.set_settings(
            {
                ("*", "surface.direction"): "chord",
                ("*", "surface.tolerance"): 1e-4,
                ("P1", "weight"): 2.0,
            }
        ),
    )
    wait_for_result(panel, qtbot, panel.reset.click)
    assert document.values == {("P1", "weight"): 2.0}
    assert document.undoable == "the settings of the surface"
    assert not panel.reset.isEnabled()


def test_every_choice_has_a_name_and_a_tip(panel):
    labelled = {one.buddy() for one in panel.findChildren(QLabel)}
    for box in (panel.direction, panel.lengths, panel.correspondence, panel.interior, panel.method):
        assert box in labelled
        assert box.toolTip()
    assert panel.tolerance in labelled
    for box in (*panel.angles, *panel.factors, panel.thickness):
        assert box.accessibleName()
    for button in (panel.solid, panel.neighbours, panel.cells, panel.reset):
        assert "&" in button.text()
    for box in (panel.tolerance, panel.thickness, panel.solid, panel.neighbours, panel.reset):
        assert box.toolTip()
    assert panel.cells.toolTip()


def test_where_lines_may_fold_the_way_out_is_told(panel, qtbot):
    assert panel.advice.isHidden()
    for box, word, told in (
        (panel.direction, "conormal", True),
        (panel.correspondence, "foot-trim", False),
        (panel.correspondence, "foot-cover", True),
        (panel.direction, "chord", False),
        (panel.interior, "c1-lines", True),
    ):
        wait_for_result(panel, qtbot, lambda box=box, word=word: choose(box, qtbot, word))
        assert panel.advice.isVisible() == told, word


@pytest.mark.parametrize("symbol", ["mm", "cm", "in"])
def test_the_least_that_can_be_typed_is_allowed(panel, qtbot, symbol):
    panel._units.use(symbol)
    for box in (panel.tolerance, panel.thickness):
        assert box.minimum() > 0.0
    refused = []
    panel._document.failed.connect(refused.append)
    wait_for_result(panel, qtbot, lambda: panel.tolerance.setValue(0.0))
    assert refused == []
