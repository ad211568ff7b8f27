"""The daily check over a real port: a virtual ribbon, the station, the desk with its thread."""

import time

import pytest
from PySide6.QtCore import Qt

from georibbon import virtual
from georibbon.gui.calibrating.page import CalibrationPage
from georibbon.gui.calibrating.state import CHECK_KEYS
from georibbon.gui.capture_desk import CaptureDesk
from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.parts import Parts
from georibbon.gui.settings import Settings
from georibbon.gui.station.station import Station
from georibbon.gui.units import Units
from georibbon.session.calibration_shelf import Shelf
from georibbon.simulation.settings import (
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
)
from georibbon.virtual import VirtualRibbon, VirtualSettings

FASTER = 3.0  # the virtual ribbon's seconds in one of ours
LONG = 60_000  # ms
WORDS = ("pose 0,0,0,table", "pose 90,90,0,table", "pose 0,90,-40")


@pytest.fixture
def page(qtbot, monkeypatch, tmp_path):
    """The page over a station with a virtual ribbon; a calibration of it is kept."""
    origin = time.monotonic()
    monkeypatch.setattr(
        virtual,
        "VirtualRibbon",
        lambda settings: VirtualRibbon(
            settings, clock=lambda: origin + FASTER * (time.monotonic() - origin)
        ),
    )
    document, station = Document(), Station()
    desk = CaptureDesk(station, document)
    desk.changed.connect(document.captured)
    settings = Settings(tmp_path / "settings.ini")
    settings.sound = False
    parts = Parts(settings, Notifier(), document, Units(), station, desk)
    simulation = SimulationSettings(
        ribbon=RibbonSettings(sensors=12),
        layout=LayoutSettings(passes=2),
        poses=PoseSettings(plan=20, bend=0.02),
    )
    with qtbot.waitSignal(station.identified, timeout=LONG):
        station.connect_virtual(VirtualSettings(simulation, pace=0.0))
    Shelf(tmp_path / "calibrations").keep(station.virtual.truth.calibration, "as it was made")
    made = CalibrationPage(parts, folder=tmp_path / "calibrations")
    qtbot.addWidget(made)
    made.resize(1190, 680)
    made.show()
    qtbot.waitExposed(made)
    made.entered()
    yield made
    desk.end()
    made.end()
    station.end()
    document.end()


def test_the_daily_check_is_done_by_stillness_alone(page, qtbot):
    check = page.start.kept.buttons["check"]
    qtbot.waitUntil(check.isEnabled, timeout=LONG)
    desk, ribbon = page._desk, page._desk.station.virtual
    with qtbot.waitSignal(desk.began, timeout=LONG):
        qtbot.mouseClick(check, Qt.MouseButton.LeftButton)

    def state(key):
        return next(card.state for card in page.posing.cards if card.key == key)

    def moving():
        ring = page.posing.live.ring.stillness
        return ring is not None and ring.state == "moving"

    for key, words in zip(CHECK_KEYS, WORDS, strict=True):
        ribbon.do("lift")
        qtbot.waitUntil(lambda key=key: state(key) == "asked" and moving(), timeout=LONG)
        ribbon.do(words)
        qtbot.waitUntil(lambda key=key: state(key) in ("good", "poor"), timeout=LONG)
    panel = page.posing.check
    qtbot.waitUntil(lambda: panel.verdict.text() == "Good", timeout=LONG)
    history = page.shelf.look()[0][0].checks
    assert [one.verdict for one in history] == ["good"]
    assert len(list((page.shelf.folder / "sessions").glob("check *.georibbon"))) == 1
    qtbot.mouseClick(page.posing.stop_button, Qt.MouseButton.LeftButton)
    assert not desk.active
