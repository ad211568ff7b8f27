"""The station: connected through real ports, told on the main thread, with nothing left behind."""

import os
import threading
from functools import partial
from pathlib import Path

import pytest
import serial
from PySide6.QtCore import QThread

from georibbon.device.link import Link, LinkState, LinkTiming
from georibbon.errors import DeviceError
from georibbon.gui.station import connection
from georibbon.gui.station.station import Station
from georibbon.simulation import LayoutSettings, RibbonSettings, SimulationSettings
from georibbon.virtual import MeshSettings, VirtualRibbon, VirtualSettings, serve_pty, serve_tcp
from waiting import wait_until

SMALL = VirtualSettings(
    SimulationSettings(
        "dome",
        ribbon=RibbonSettings(sensors=8, length=0.24),
        layout=LayoutSettings(passes=2, ties=1),
        seed=5,
    ),
    pace=0.0,
)
WAIT = 20_000  # ms
QUICK = LinkTiming(answer=0.2, tries=1, stall=0.2, retry_first=0.05, retry_last=0.1)


@pytest.fixture
def station():
    one = Station()
    yield one
    one.end()


@pytest.fixture
def quick(monkeypatch):
    """Links that lose patience soon."""
    monkeypatch.setattr(connection, "Link", partial(Link, timing=QUICK))


@pytest.fixture
def served():
    """A virtual ribbon of somebody else's at a pseudo-terminal."""
    world = VirtualRibbon(SMALL)
    with serve_pty(world) as port:
        yield world, port.url


def threads():
    """Who lives besides the main thread, among those that a station makes."""
    names = ("link", "virtual ribbon")
    return [one.name for one in threading.enumerate() if one.name.startswith(names)]


def open_files():
    return len(list(Path("/proc/self/fd").iterdir()))


def streaming(qtbot, station):
    qtbot.waitUntil(lambda: station.state is LinkState.STREAMING, timeout=WAIT)


@pytest.mark.parametrize("way", ["pty", "tcp"])
def test_the_virtual_ribbon_is_reached_through_a_real_port(qtbot, station, way):
    with qtbot.waitSignal(station.identified, timeout=WAIT) as told:
        station.connect_virtual(SMALL, way)
        assert station.state is LinkState.OPENING  # at once: nothing is waited for here
    assert told.args[0] == station.identity
    assert station.identity.ribbon.id == station.virtual.ribbon.id
    assert len(station.identity.ribbon.sensors) == 8
    assert station.url.startswith("socket://") == (way == "tcp")
    streaming(qtbot, station)
    with qtbot.waitSignal(station.health_changed, timeout=WAIT) as health:
        pass
    assert health.args[0].frames > 0


def test_what_is_laid_is_what_comes_over_the_wire(qtbot, station):
    station.connect_virtual(SMALL)
    streaming(qtbot, station)
    tap = station.recorder()
    assert station.virtual.do("lay P1").startswith("P1")
    qtbot.waitUntil(lambda: len(tap.take()) > 0, timeout=WAIT)
    assert [entry["state"] for entry in station.diary.take()][-1] == "streaming"


def test_a_ribbon_at_a_port_is_reached_by_its_name(qtbot, station, served):
    world, url = served
    station.connect_to(url, ribbon=world.ribbon)
    streaming(qtbot, station)
    assert station.virtual is None
    assert station.url == url
    assert station.health().frames_per_second >= 0


def test_everything_is_told_on_the_main_thread(qtbot, station, served, qapp):
    world, url = served
    told = []
    for signal in (station.identified, station.changed, station.happened, station.health_changed):
        signal.connect(lambda *_: told.append(QThread.currentThread()))
    station.connect_to(url)
    streaming(qtbot, station)
    with qtbot.waitSignal(station.happened, timeout=WAIT) as event:
        world.do("message the battery is low")
    assert "the battery is low" in event.args[0].message
    assert set(told) == {qapp.thread()}


def test_a_pulled_cable_is_told_and_survived(qtbot, station):
    station.connect_virtual(SMALL)
    streaming(qtbot, station)
    failures, identities = [], []
    station.failed.connect(failures.append)
    station.identified.connect(identities.append)
    station.virtual.do("unplug")
    qtbot.waitUntil(lambda: station.state is LinkState.DISCONNECTED, timeout=WAIT)
    assert station.active
    assert station.link is not None
    assert station.reason
    station.virtual.do("replug")
    streaming(qtbot, station)
    assert station.health().reconnects == 1
    assert not failures
    assert not identities


def test_another_ribbon_is_refused_with_both_told(qtbot, station, served):
    world, url = served
    with qtbot.waitSignal(station.failed, timeout=WAIT) as told:
        station.connect_to(url, ribbon_id="GR-9999")
    assert "GR-9999" in told.args[0]
    assert world.ribbon.id in told.args[0]
    assert not station.active
    assert station.link is None
    assert station.identity is None


def test_a_port_in_use_is_told_in_one_sentence(qtbot, station, served):
    _, url = served
    with (
        serial.Serial(url, exclusive=True),
        qtbot.waitSignals([station.failed, station.disconnected], timeout=WAIT),
    ):
        station.connect_to(url)
    assert "in use" in station.reason
    assert url in station.reason
    qtbot.waitUntil(lambda: not threads() or threads() == ["virtual ribbon"], timeout=WAIT)


@pytest.mark.usefixtures("quick")
def test_a_port_where_nothing_answers_is_told(qtbot, station):
    master, slave = os.openpty()
    try:
        with qtbot.waitSignal(station.failed, timeout=WAIT) as told:
            station.connect_to(os.ttyname(slave))
        assert os.ttyname(slave) in told.args[0]
        assert station.state is LinkState.DISCONNECTED
        station.end()
        wait_until(lambda: not threads())
    finally:
        os.close(master)
        os.close(slave)


def test_what_is_no_port_is_told(qtbot, station):
    for url in ("", "http://127.0.0.1:1", "/dev/none-such"):
        with qtbot.waitSignal(station.failed, timeout=WAIT) as told:
            station.connect_to(url)
        assert "port" in told.args[0]
        assert not station.active


def test_a_virtual_ribbon_that_cannot_be_is_told(qtbot, station, tmp_path):
    none = VirtualSettings(SMALL.simulation, mesh=MeshSettings(tmp_path / "none.stl"))
    with qtbot.waitSignal(station.failed, timeout=WAIT) as told:
        station.connect_virtual(none)
    assert "none.stl" in told.args[0]


def test_a_fault_of_the_program_is_no_failure_of_the_persons(qtbot, station, monkeypatch):
    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr(connection, "to_virtual", broken)
    failures = []
    station.failed.connect(failures.append)
    with qtbot.waitSignal(station.fault, timeout=WAIT) as told:
        station.connect_virtual(SMALL)
    assert isinstance(told.args[0], RuntimeError)
    assert not failures


def test_without_pseudo_terminals_a_socket_is_taken(qtbot, station, monkeypatch):
    def none():
        raise OSError("none here")

    monkeypatch.setattr("pty.openpty", none)
    station.connect_virtual(SMALL, "pty")
    streaming(qtbot, station)
    assert station.url.startswith("socket://127.0.0.1:")


@pytest.mark.usefixtures("quick")
def test_disconnecting_while_connecting_connects_to_nothing(qtbot, station):
    master, slave = os.openpty()
    try:
        failures = []
        station.failed.connect(failures.append)
        station.connect_to(os.ttyname(slave))
        qtbot.waitUntil(lambda: station.link is not None, timeout=WAIT)
        with qtbot.waitSignal(station.disconnected, timeout=WAIT):
            station.disconnect()
        assert station.state is LinkState.DISCONNECTED
        assert not failures
        station.end()
        wait_until(lambda: not threads())
    finally:
        os.close(master)
        os.close(slave)


def test_disconnecting_while_the_virtual_ribbon_is_made_leaves_none(station):
    station.connect_virtual(SMALL)
    station.disconnect()
    station.connect_virtual(SMALL)
    station.disconnect()
    station.end()
    assert station.link is None
    wait_until(lambda: not threads())


def test_another_connection_takes_the_place_of_the_first(qtbot, station):
    world = VirtualRibbon(
        VirtualSettings(
            SimulationSettings("dome", ribbon=RibbonSettings(id="GR-0002", sensors=8, length=0.24))
        )
    )
    with serve_tcp(world) as port:
        station.connect_virtual(SMALL)
        streaming(qtbot, station)
        with qtbot.waitSignals([station.disconnected, station.identified], timeout=WAIT):
            station.connect_to(port.url)
        assert station.identity.ribbon.id == "GR-0002"
        assert station.virtual is None
        station.end()


def test_without_a_ribbon_there_is_nothing_to_record(station):
    with pytest.raises(DeviceError, match="connect one first"):
        station.recorder()
    assert station.health() is None
    assert station.diary is None


def test_twenty_connections_leave_nothing(qtbot):
    descriptors = None
    for turn in range(20):
        station = Station()
        station.connect_virtual(SMALL, "pty" if turn % 2 else "tcp")
        qtbot.waitUntil(lambda: station.identity is not None, timeout=WAIT)  # noqa: B023 - called in this turn
        station.end()
        if descriptors is None:
            descriptors = open_files()
    wait_until(lambda: not threads())
    assert open_files() <= descriptors


def test_after_the_end_nothing_begins(station):
    station.end()
    station.connect_virtual(SMALL)
    assert not station.active
    assert not threads()
