"""A capture through a real port, its engine in a thread, its news on the main thread."""

import threading

import pytest
from quick_ribbon import quicken

from georibbon.capture.plan import CapturePlan
from georibbon.gui.capture_desk import CaptureDesk
from georibbon.gui.document import Document
from georibbon.gui.station.station import Station
from georibbon.session.session import Session
from georibbon.simulation.settings import (
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
)
from georibbon.virtual import VirtualSettings

FASTER = 4.0  # the virtual ribbon's seconds in one of ours
LONG = 30_000  # ms


class Desk:
    """A desk with a virtual ribbon on it, and what it told."""

    def __init__(self, qtbot, monkeypatch):
        quicken(monkeypatch, FASTER)
        self.qtbot = qtbot
        self.document, self.station = Document(), Station()
        self.capture = CaptureDesk(self.station, self.document)
        self.told, self.refused = [], []
        self.capture.happened.connect(self.told.append)
        self.capture.refused.connect(self.refused.append)
        self.capture.changed.connect(self.document.captured)

    def connect(self):
        simulation = SimulationSettings(
            ribbon=RibbonSettings(sensors=12),
            layout=LayoutSettings(passes=3),
            poses=PoseSettings(plan=12),
        )
        settings = VirtualSettings(simulation, pace=0.0)
        with self.qtbot.waitSignal(self.station.identified, timeout=LONG):
            self.station.connect_virtual(settings)

    def begin(self, path, **how):
        with self.qtbot.waitSignal(self.capture.began, timeout=LONG):
            self.capture.begin(path, **how)

    def wait_for(self, kind, subject=None):
        def there():
            return any(one.kind == kind and subject in (None, one.subject) for one in self.told)

        self.qtbot.waitUntil(there, timeout=LONG)

    def lay(self, name):
        self.station.virtual.do("lift")
        self.qtbot.waitUntil(
            lambda: self.stillness() is not None and self.stillness().state == "moving",
            timeout=LONG,
        )
        self.station.virtual.do(f"lay {name}")

    def stillness(self):
        with self.qtbot.waitSignal(self.capture.refreshed, timeout=LONG) as seen:
            pass
        return seen.args[0].live.stillness

    def end(self):
        self.capture.end()
        self.station.end()
        self.document.end()


@pytest.fixture
def desk(qtbot, monkeypatch):
    """A desk, cleared in the end."""
    made = Desk(qtbot, monkeypatch)
    yield made
    made.end()


PLAN = CapturePlan(poses=0, passes=2)


def test_passes_are_taken_by_stillness_and_stand_in_the_document(desk, tmp_path):
    desk.connect()
    desk.begin(tmp_path / "s.georibbon", plan=PLAN)
    assert desk.capture.current.key == "P1"
    for name in ("P1", "P2"):
        desk.lay(name)
        desk.wait_for("taken", name)
    desk.wait_for("complete")
    assert [one.name for one in desk.document.passes] == ["P1", "P2"]
    assert desk.capture.session is desk.document.session
    desk.capture.end()
    assert not desk.capture.active
    desk.document.end()
    with Session.open(tmp_path / "s.georibbon") as kept:
        assert [one.name for one in kept.state.passes] == ["P1", "P2"]
        assert any(one.action == "link" for one in kept.state.history)


def test_what_is_taken_back_is_gone_from_the_document_and_asked_for_again(desk, tmp_path):
    desk.connect()
    desk.begin(tmp_path / "s.georibbon", plan=PLAN)
    desk.lay("P1")
    desk.wait_for("taken", "P1")
    desk.capture.undo()
    desk.wait_for("undone")
    assert desk.document.passes == ()
    desk.qtbot.waitUntil(lambda: desk.capture.current.key == "P1")
    desk.capture.redo()
    desk.wait_for("redone")
    assert [one.name for one in desk.document.passes] == ["P1"]


def test_it_goes_on_with_the_session_that_is_open(desk, tmp_path):
    path = tmp_path / "s.georibbon"
    desk.connect()
    desk.begin(path, plan=PLAN)
    desk.lay("P1")
    desk.wait_for("taken", "P1")
    session = desk.document.session
    desk.capture.end()
    desk.begin(path)
    assert desk.capture.session is session
    assert [one.status for one in desk.capture.items] == ["taken", "open"]
    desk.capture.set_plan(CapturePlan(poses=0, passes=3))
    desk.qtbot.waitUntil(lambda: len(desk.capture.items) == 3)
    desk.capture.undo()
    desk.qtbot.waitUntil(lambda: len(desk.capture.items) == 2)
    assert desk.capture.plan.passes == 2


def test_verbs_that_cannot_be_done_are_refused_with_the_reason(desk, tmp_path):
    desk.capture.take()
    assert desk.refused == ["No capture is going on; begin one first."]
    with desk.qtbot.waitSignal(desk.capture.failed) as failed:
        desk.capture.begin(tmp_path / "s.georibbon")
    assert failed.args == ["No ribbon is connected; connect one first."]
    desk.connect()
    with desk.qtbot.waitSignal(desk.capture.failed, timeout=LONG) as failed:
        desk.capture.begin(tmp_path / "nowhere" / "s.georibbon", plan=PLAN)
    assert "nowhere" in failed.args[0]
    assert not desk.capture.active
    desk.begin(tmp_path / "s.georibbon", plan=PLAN)
    desk.capture.choose("P9")
    desk.capture.reorder(["P1"])
    desk.qtbot.waitUntil(lambda: len(desk.refused) == 3)
    assert "there is no pose or pass" in desk.refused[1]
    assert "the order names P1" in desk.refused[2]


def test_another_connection_goes_on_with_the_same_capture(desk, tmp_path):
    desk.connect()
    desk.begin(tmp_path / "s.georibbon", plan=PLAN)
    desk.lay("P1")
    desk.wait_for("taken", "P1")
    with desk.qtbot.waitSignal(desk.station.disconnected, timeout=LONG):
        desk.station.disconnect()
    desk.connect()
    desk.lay("P2")
    desk.wait_for("taken", "P2")


def test_a_capture_that_is_ended_while_it_begins_leaves_nothing(desk, tmp_path):
    desk.connect()
    desk.capture.begin(tmp_path / "s.georibbon", plan=PLAN)
    desk.capture.end()
    assert not desk.capture.active
    assert not [one for one in threading.enumerate() if one.name == "capture"]
    with Session.open(tmp_path / "s.georibbon") as kept:
        assert kept.state.passes == ()


def test_a_capture_that_could_not_begin_takes_no_frames(desk, tmp_path):
    desk.connect()
    taps = []
    recorder = desk.station.recorder
    desk.station.recorder = lambda: taps.append(recorder()) or taps[-1]
    for name in ("one", "two"):
        with desk.qtbot.waitSignal(desk.capture.failed, timeout=LONG):
            desk.capture.begin(tmp_path / "nowhere" / name, plan=PLAN)
    assert len(taps) == 2
    desk.qtbot.waitUntil(lambda: all(tap.closed for tap in taps), timeout=LONG)
