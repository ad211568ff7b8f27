"""A capture by the page over the virtual ribbon itself: real port, real threads, a pulled cable."""

import pytest
from capturing_bench import SIMULATION, SPACING, true_calibration
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget
from quick_ribbon import quicken

from georibbon.gui.capture_desk import CaptureDesk
from georibbon.gui.capturing.capture_page import CapturePage
from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.parts import Parts
from georibbon.gui.settings import Settings
from georibbon.gui.station.station import Station
from georibbon.gui.units import Units
from georibbon.session.session import Session
from georibbon.virtual import VirtualSettings

FASTER = 4.0  # the virtual ribbon's seconds in one of ours
LONG = 30_000  # ms


class FakeScene(QWidget):
    def show_capture(self, drawing):
        self.drawing = drawing

    def set_units(self, symbol, metres):
        self.unit = (symbol, metres)


@pytest.fixture
def parts(qapp, tmp_path, monkeypatch):
    assert qapp
    quicken(monkeypatch, FASTER)
    settings = Settings(tmp_path / "settings.ini")
    settings.sound = False
    settings.folder = tmp_path
    document, station = Document(), Station()
    made = Parts(settings, Notifier(), document, Units(), station, CaptureDesk(station, document))
    made.capture.changed.connect(document.captured)
    yield made
    made.capture.end()
    station.end()
    document.end()


def test_three_passes_and_a_tie_from_the_plan_to_the_residuals(qtbot, parts, monkeypatch, tmp_path):
    monkeypatch.setattr(CapturePage, "make_scene", lambda _: FakeScene())
    page = CapturePage(parts, folder=tmp_path / "kept")
    qtbot.addWidget(page)
    page.show()
    station, capture, view = parts.station, parts.capture, page.view

    def state(key):
        return {one.key: one.status for one in capture.items}.get(key)

    def lay(name):
        station.virtual.do("lift")
        qtbot.waitUntil(
            lambda: view.ring.stillness is not None and view.ring.stillness.state == "moving",
            timeout=LONG,
        )
        station.virtual.do(f"lay {name}")

    with qtbot.waitSignal(station.identified, timeout=LONG):
        station.connect_virtual(VirtualSettings(SIMULATION, pace=0.0))
    page.use_calibration(true_calibration(), "mine")
    page.plan.title.setText("dome")
    page.plan.passes.setValue(3)
    page.plan.ties.setValue(1)
    page.plan.marks.setCurrentIndex(0)
    page.plan.spacing.set_metres(SPACING)
    path = page.plan.path
    with qtbot.waitSignal(capture.began, timeout=LONG):
        qtbot.mouseClick(page.plan.start, Qt.MouseButton.LeftButton)
    lay("P1")
    qtbot.waitUntil(lambda: state("P1") == "taken", timeout=LONG)
    qtbot.mouseClick(view.auto, Qt.MouseButton.LeftButton)
    station.virtual.do("unplug 1")
    qtbot.waitUntil(lambda: not view.link_banner.isHidden(), timeout=LONG)
    qtbot.waitUntil(view.link_banner.isHidden, timeout=LONG)
    lay("P2")
    qtbot.waitUntil(
        lambda: view.ring.stillness is not None and view.ring.stillness.seconds > 1.2, timeout=LONG
    )
    qtbot.waitUntil(lambda: "P1" in view.angle.text(), timeout=LONG)
    view.setFocus()
    qtbot.keyClick(view, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: state("P2") == "taken", timeout=LONG)
    qtbot.mouseClick(view.auto, Qt.MouseButton.LeftButton)
    for name in ("P3", "T1"):
        lay(name)
        qtbot.waitUntil(lambda name=name: state(name) == "taken", timeout=LONG)
    view.survey.fill_in()
    table = view.survey.table
    qtbot.waitUntil(lambda: table.rowCount() == 3 and table.item(0, 10).text() != "—", timeout=LONG)
    assert parts.document.reconstruction.surface is not None
    with qtbot.waitSignal(page.finished, timeout=LONG):
        qtbot.mouseClick(view.finish_button, Qt.MouseButton.LeftButton)
    page.end()
    parts.document.end()
    with Session.open(path) as kept:
        assert [one.name for one in kept.state.passes] == ["P1", "P2", "P3", "T1"]
        assert len(kept.state.crossings) == 3
