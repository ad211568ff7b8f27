"""The virtual ribbon served: over a real pseudo-terminal and over TCP, in real time."""

import os
import socket
import stat
import threading
from importlib import import_module
from pathlib import Path

import pytest
import serial
from worlds import SMALL

from georibbon.device.packets import DONE, FRAME, IDENTITY, MESSAGE, Packet, PacketReader
from georibbon.errors import SettingsError
from georibbon.virtual import VirtualRibbon, VirtualSettings, serve_pty, serve_tcp
from waiting import wait_until

# A terminal that vanishes while it is opened: what pyserial lets through there.
VANISHING = (import_module("termios").error,) if os.name == "posix" else ()
SERVE = {"pty": serve_pty, "tcp": serve_tcp}


class Host:
    """A host as simple as can be, on any URL."""

    def __init__(self, url: str) -> None:
        self.port = serial.serial_for_url(url, timeout=0.02)
        self.reader = PacketReader()
        self.packets: list[Packet] = []

    def __enter__(self) -> "Host":
        return self

    def __exit__(self, *_: object) -> None:
        close(self.port)

    def says(self, words: bytes) -> None:
        self.port.write(words)

    def listens(self) -> list[Packet]:
        self.packets += self.reader.feed(self.port.read(65536))
        return self.packets

    def hears(self, kind: int, count: int = 1) -> list[Packet]:
        """Wait for so many packets of a kind; all of that kind until then."""
        wait_until(lambda: sum(p.type == kind for p in self.listens()) >= count)
        return [packet for packet in self.packets if packet.type == kind]


def close(port: serial.SerialBase) -> None:
    """Close a port; pyserial leaves a socket open whose other end was quicker to close."""
    line = getattr(port, "_socket", None)
    port.close()
    if line is not None:
        line.close()


@pytest.fixture
def world():
    return VirtualRibbon(VirtualSettings(SMALL, pace=0.0))


@pytest.fixture(autouse=True)
def nothing_left():
    """No thread and no descriptor more than before."""
    threads, descriptors = threading.enumerate(), open_descriptors()
    yield
    assert threading.enumerate() == threads
    assert open_descriptors() == descriptors


def open_descriptors():
    """Those of this process, where the system tells."""
    place = Path("/proc/self/fd")
    return sorted(place.iterdir()) if place.is_dir() else []


@pytest.mark.parametrize("kind", SERVE)
def test_a_conversation(world, kind):
    with SERVE[kind](world) as port, Host(port.url) as host:
        host.says(b"stop\nident")
        host.says(b"ify\r\nnonsense\nstart\n")
        host.hears(FRAME, 30)
        host.says(b"stop\n")
        host.hears(DONE, 3)
        assert [p.type for p in host.packets[:4]] == [DONE, IDENTITY, MESSAGE, DONE]
        assert host.packets[-1].payload == b"stop"
        assert host.reader.damaged == 0
        assert [p.sequence for p in host.packets] == list(range(len(host.packets)))
        assert world.sent.whole == world.sent.packets == len(host.packets)


@pytest.mark.parametrize("kind", SERVE)
def test_words_are_carried_out_while_it_is_served(world, kind):
    with SERVE[kind](world) as port, Host(port.url) as host:
        host.says(b"start\n")
        host.hears(FRAME, 3)
        world.do("message hello")
        (message,) = host.hears(MESSAGE)
        assert message.payload == b"hello"
        assert world.do("lay P2") == "P2, still"
        assert "100 frames a second" in world.do("status")


@pytest.mark.parametrize("kind", SERVE)
def test_a_host_that_leaves_ends_the_frames_and_may_come_again(world, kind):
    with SERVE[kind](world) as port:
        with Host(port.url) as host:
            host.says(b"start\n")
            host.hears(FRAME, 3)
        wait_until(lambda: "silent" in world.do("status"))
        before = world.sent.packets
        with Host(port.url) as host:
            host.says(b"\nstop\nidentify\n")
            (identity,) = host.hears(IDENTITY)
            assert identity.sequence == before + 1


@pytest.mark.parametrize("kind", SERVE)
def test_a_host_that_does_not_read_is_never_waited_for(world, kind):
    with SERVE[kind](world) as port, Host(port.url) as host:
        host.says(b"rate 400\nstart\n")
        wait_until(lambda: world.sent.frames > 10)
        for _ in range(50):  # minutes of frames in no time
            world.advance(0.5)
            world.catch_up()
        wait_until(lambda: world.sent.overrun > 1000)
        made = world.sent.packets
        wait_until(lambda: world.sent.packets > made + 20)  # its clock goes on
        host.says(b"stop\n")
        host.hears(DONE, 3)
        numbers = [packet.sequence for packet in host.packets]
        assert numbers[0] == 0
        sent = world.sent
        lost = (numbers[-1] - len(numbers) + 1) % 65536
        assert lost == sent.overrun % 65536
        assert len(numbers) == sent.whole
        assert host.reader.damaged == 0


@pytest.mark.parametrize("kind", SERVE)
def test_pulled_out_the_port_vanishes_and_put_back_it_has_its_old_name(world, kind):
    with SERVE[kind](world) as port:
        url = port.url
        for _ in range(3):
            with Host(url) as host:
                host.says(b"start\n")
                host.hears(FRAME, 2)
                world.do("unplug")
                wait_until(lambda: not can_be_opened(url))
                assert port.url == url
            world.do("replug")
            wait_until(lambda: can_be_opened(url))
        with Host(url) as host:
            host.says(b"\nidentify\n")
            (identity,) = host.hears(IDENTITY)
            assert identity.sequence == world.sent.packets - 1


def can_be_opened(url):
    try:
        close(serial.serial_for_url(url))
    except (serial.SerialException, OSError, *VANISHING):
        return False
    return True


def test_a_host_sees_the_terminal_vanish(world):
    with serve_pty(world) as port, Host(port.url) as host:
        host.says(b"start\n")
        host.hears(FRAME, 2)
        world.do("unplug")
        with pytest.raises((serial.SerialException, OSError)):
            wait_until(lambda: host.port.in_waiting < 0)


def test_the_link_is_in_a_private_folder_and_gone_at_the_end(world):
    with serve_pty(world) as port:
        link = Path(port.url)
        assert link.is_symlink()
        assert stat.S_IMODE(link.parent.stat().st_mode) == 0o700
    assert not link.parent.exists()


def test_the_link_may_be_given_and_replaces_nothing(world, tmp_path):
    link = tmp_path / "ribbon"
    with serve_pty(world, link) as port:
        assert port.url == str(link)
        assert link.is_symlink()
        with pytest.raises(SettingsError, match="something is there already"):
            serve_pty(VirtualRibbon(VirtualSettings(SMALL)), link)
    assert not link.is_symlink()
    for make in (lambda: link.write_text("mine"), lambda: link.symlink_to(tmp_path / "nothing")):
        make()
        with pytest.raises(SettingsError, match="something is there already"):
            serve_pty(world, link)
        link.unlink()
    with pytest.raises(SettingsError, match="no link can be made there"):
        serve_pty(world, tmp_path / "nowhere" / "ribbon")


def test_a_link_left_by_one_that_was_killed_is_taken_over(world, tmp_path):
    link = tmp_path / "ribbon"
    link.symlink_to("/dev/pts/999999")
    with serve_pty(world, link) as port, Host(port.url) as host:
        host.says(b"identify\n")
        host.hears(IDENTITY)


def test_what_has_taken_the_links_place_meanwhile_stays(world, tmp_path):
    link = tmp_path / "ribbon"
    with serve_pty(world, link):
        link.unlink()
        link.write_text("mine")
    assert link.read_text() == "mine"


def test_replugged_it_waits_for_its_name_to_be_free(world, tmp_path):
    link = tmp_path / "ribbon"
    with serve_pty(world, link):
        world.do("unplug")
        wait_until(lambda: not link.is_symlink())
        link.write_text("mine")
        world.do("replug")
        assert link.read_text() == "mine"
        link.unlink()
        wait_until(link.is_symlink)


def test_the_terminal_does_not_echo(world):
    """What the ribbon says before a host has set the terminal up must not come back to it."""
    with serve_pty(world) as port:
        host = os.open(port.url, os.O_RDWR | os.O_NOCTTY)
        try:
            wait_until(lambda: world.sent.packets == 0)
            world.do("message hello\x20there")
            wait_until(lambda: world.sent.packets == 1)
            os.write(host, b"identify\n")
            wait_until(lambda: world.sent.packets == 2)
            data = b""
            while data.count(b"\0") < 2:
                data += os.read(host, 4096)
        finally:
            os.close(host)
    assert [p.type for p in PacketReader().feed(data)] == [MESSAGE, IDENTITY]


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.7", "::", "example.org", ""])  # noqa: S104 (refused)
def test_only_this_machine_may_listen(world, host):
    with pytest.raises(SettingsError, match="this machine only"):
        serve_tcp(world, host, 0)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.5", "localhost", "::1", "[::1]"])
def test_every_name_of_this_machine_does(world, host):
    if ":" in host and not socket.has_ipv6:
        host = "127.0.0.1"
    with serve_tcp(world, host) as port, Host(port.url) as client:
        assert port.url.startswith("socket://")
        client.says(b"identify\n")
        client.hears(IDENTITY)


def test_a_second_host_is_told_and_sent_away(world):
    with serve_tcp(world) as port, Host(port.url) as host:
        host.says(b"identify\n")
        host.hears(IDENTITY)
        number = int(port.url.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", number), timeout=20) as second:
            data = b"".join(iter(lambda: second.recv(4096), b""))
        (busy,) = PacketReader().feed(data)
        assert busy.type == MESSAGE
        assert b"busy" in busy.payload
        host.says(b"stop\n")
        host.hears(DONE)


def test_a_host_that_comes_back_at_once_is_let_in(world):
    with serve_tcp(world) as port:
        number = int(port.url.rpartition(":")[2])
        for _ in range(50):
            with socket.create_connection(("127.0.0.1", number), timeout=20) as host:
                host.sendall(b"identify\n")
                reader, packets = PacketReader(), []
                while not packets:
                    packets = reader.feed(host.recv(65536))
                assert packets[0].type == IDENTITY


def test_it_is_served_on_one_port_at_a_time(world):
    with serve_pty(world), pytest.raises(SettingsError, match="served already"):
        serve_tcp(world)
    with serve_tcp(world) as port, Host(port.url) as host:
        host.says(b"identify\n")
        host.hears(IDENTITY)


def test_a_port_that_is_taken_is_refused(world):
    with serve_tcp(world) as port:
        number = int(port.url.rpartition(":")[2])
        with pytest.raises(SettingsError, match=f"port {number}"):
            serve_tcp(VirtualRibbon(VirtualSettings(SMALL)), "127.0.0.1", number)


def test_a_host_that_talks_without_end_does_not_keep_the_frames(world):
    with serve_tcp(world) as port, Host(port.url) as host:
        host.says(b"start\n")
        done = threading.Event()

        def talk() -> None:
            while not done.is_set():
                host.port.write(b"\n" * 20000)

        talker = threading.Thread(target=talk)
        talker.start()
        try:
            host.hears(FRAME, 20)
        finally:
            done.set()
            talker.join()


@pytest.mark.parametrize("kind", SERVE)
def test_a_fault_of_the_program_ends_the_service_and_is_told(world, kind, monkeypatch):
    port = SERVE[kind](world)
    assert port.serves
    monkeypatch.setattr(world, "catch_up", lambda: 1 / 0)
    world.do("status")  # which wakes it
    wait_until(lambda: not port.serves)
    assert not can_be_opened(port.url)
    with pytest.raises(ZeroDivisionError):
        port.close()
    port.close()
    monkeypatch.undo()
    with SERVE[kind](world) as port, Host(port.url) as host:
        host.says(b"identify\n")
        host.hears(IDENTITY)
