"""The whole job as a person does it: from the start page to the surface on the disk."""

import numpy as np
import pytest
import trimesh
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QStyle, QStyleOptionSlider
from quick_ribbon import LONG, Person, quicken

from georibbon.geometry.closest import closest_point
from georibbon.simulation.scoring import score

FASTER = 5.0
PASSES, TIES = 5, 2
EXPECTED_MM = 1.0  # what the readme's example gives is 0.65


@pytest.fixture
def person(qtbot, tmp_path, monkeypatch):
    """A person at a window with a hurried virtual ribbon inside."""
    quicken(monkeypatch, FASTER)
    return Person(qtbot, tmp_path, monkeypatch)


def calibrate(person):
    """All poses by the virtual hands, and the calibration kept by a name."""
    window = person.window
    person.click(window.start_page.buttons["connect-virtual"])
    person.wait(lambda: window.station.identity is not None)
    person.click(window.navigation.widgetForAction(window.actions_by_id["page-calibrate"]))
    page = window.pages.page("calibrate")
    person.tick(window.hands.follow)
    window.hands.pause.setValue(0.0)
    person.click(page.start.begin_button)
    person.wait(lambda: window.capture.active)
    person.wait(lambda: page.stack.currentWidget() is page.done)
    person.type(page.done.name, "of today")
    kept, spoilt = page.shelf.look()
    assert ([one.name for one in kept], spoilt) == (["of today"], ())
    person.click(page.done.use_button)
    assert window.pages.current == "capture"


def capture(person):
    """Five passes and two ties with the survey, in a new session."""
    window = person.window
    plan = window.pages.page("capture").plan
    person.type(plan.title, "bonnet")
    plan.passes.setValue(PASSES)
    plan.ties.setValue(TIES)
    person.click(plan.start)
    person.wait(lambda: window.capture.active)
    person.wait(lambda: len(window.capture.items) == PASSES + TIES)
    person.wait(lambda: window.capture.current is None)
    person.click(window.hands.survey)
    person.wait(lambda: window.document.reconstruction is not None)
    person.press(Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    person.wait(lambda: window.pages.current == "review")
    assert not window.capture.active
    person.wait(lambda: not window.document.is_busy)


def drag(person, slider, share):
    """Drag a slider's handle by a share of its length."""
    option = QStyleOptionSlider()
    slider.initStyleOption(option)
    handle = slider.style().subControlRect(
        QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, slider
    )
    start, step = handle.center(), handle.center()
    person.qtbot.mousePress(slider, Qt.MouseButton.LeftButton, pos=start)
    for part in np.linspace(0.0, share, 5)[1:]:
        step.setX(start.x() + round(part * slider.width()))
        person.qtbot.mouseMove(slider, pos=step)
        person.qtbot.wait(1)
    person.qtbot.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=step)


def test_from_the_start_page_to_the_surface_on_the_disk(person, tmp_path):
    window = person.window
    calibrate(person)
    capture(person)
    truth = window.station.virtual.truth
    result = window.document.reconstruction
    assert [one.name for one in result.passes] == ["P1", "P2", "P3", "P4", "P5", "T1", "T2"]
    assert score(result, truth).curves.all.rms < EXPECTED_MM

    previewed = []
    window.document.previewed.connect(previewed.append)
    before = result.passes[1].smoothing
    with person.qtbot.waitSignal(window.document.reconstructed, timeout=LONG):
        drag(person, window.passes_panel.control("P2").slider, 0.3)
    assert previewed
    person.wait(lambda: window.document.reconstruction.passes[1].smoothing > 1.2 * before)
    assert window.actions_by_id["undo"].text() == "&Undo the smoothing of pass P2"
    with person.qtbot.waitSignal(window.document.reconstructed, timeout=LONG):
        person.press(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert window.document.reconstruction.passes[1].smoothing == pytest.approx(before)

    target = export(person, tmp_path / "bonnet.stl")
    mesh = trimesh.load(target)
    away = closest_point(truth.shape, np.asarray(mesh.vertices) / 1e3).distance
    assert np.sqrt(np.mean(away**2)) < 1e-3 * EXPECTED_MM
    window.close()


def export(person, target):
    """The surface as STL, by the dialog."""
    from georibbon.gui.review.export_dialog import ExportDialog

    person.press(Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    dialog = person.window.findChild(ExportDialog)
    person.wait(dialog.write.isEnabled)
    person.type(dialog.place, str(target))
    person.wait(target.exists)
    return target
