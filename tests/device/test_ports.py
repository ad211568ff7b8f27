"""Ports: what cannot be opened is told in one sentence, what is found again is the same device."""

import errno
import os
import socket
import termios
from types import SimpleNamespace

import pytest
import serial

from georibbon.device import ports
from georibbon.device.ports import (
    BAUDRATE,
    Finder,
    PortInfo,
    SerialPort,
    check_url,
    list_ports,
    open_port,
)
from georibbon.errors import DeviceError
from waiting import wait_until


@pytest.fixture
def pty():
    master, end = os.openpty()
    yield master, os.ttyname(end)
    os.close(end)
    os.close(master)


@pytest.fixture
def listener():
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


def read_on(port):
    for _ in range(100):
        port.read()


def write_on(port):
    for _ in range(100):
        port.write(b"x")


def url_of(server):
    return f"socket://127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize(
    "url",
    [
        *("", " ", "a\nb", "socket://", "socket://host", "socket://host:0", "socket://host:99999"),
        *("socket://host:x", "socket://host:1/path", "socket://host:1?logging=debug"),
        *("http://host:1", "spy://x?file=y", "rfc2217://host:1", "socket://[::1:5", "loop://"),
    ],
)
def test_a_url_of_no_kind_known(url):
    with pytest.raises(DeviceError, match=r"socket://.* is expected"):
        check_url(url)


@pytest.mark.parametrize(
    "url", ["/dev/ttyACM0", "COM3", "socket://localhost:1", "socket://[::1]:5"]
)
def test_a_url_of_a_known_kind(url):
    check_url(url)


def test_a_serial_port(pty):
    master, name = pty
    port = open_port(name, BAUDRATE)
    try:
        assert port.read() == b""
        assert port.write(b"stop\n")
        assert os.read(master, 100) == b"stop\n"
        os.write(master, bytes(range(256)))
        got = b""
        while len(got) < 256:
            got += port.read()
        assert got == bytes(range(256))
        os.write(master, b"old")
        port.drop()
        assert port.read() == b""
    finally:
        port.close()
    port.close()
    with pytest.raises(DeviceError, match="the port vanished"):
        port.read()


def test_a_serial_port_takes_no_more():
    """The other end reads nothing: the wait ends."""
    line = SimpleNamespace(write=raising(serial.SerialTimeoutException("Write timeout")))
    assert SerialPort(line).write(b"x") is False


def test_a_port_is_opened_once(pty):
    port = open_port(pty[1], BAUDRATE)
    try:
        with pytest.raises(DeviceError, match="in use; close the other program"):
            open_port(pty[1], BAUDRATE)
    finally:
        port.close()


def test_the_other_end_goes():
    master, end = os.openpty()
    port = open_port(os.ttyname(end), BAUDRATE)
    os.close(end)
    os.close(master)
    with pytest.raises(DeviceError, match="the port vanished: was the cable pulled"):
        read_on(port)
    port.close()


def raising(error):
    def call(*_):
        raise error

    return call


class Broken:
    """A line that raises whatever drivers raise."""

    def __init__(self, error):
        self.read = self.write = self.reset_input_buffer = self.close = raising(error)
        self._error = error

    @property
    def in_waiting(self):
        raise self._error


@pytest.mark.parametrize(
    "error",
    [
        OSError(errno.EIO, "Input/output error"),
        serial.SerialException("read failed: device reports readiness (device disconnected?)"),
        TypeError("'NoneType' object cannot be interpreted as an integer"),
        ValueError("file descriptor cannot be a negative integer (-1)"),
        termios.error(5, "Input/output error"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_whatever_a_driver_raises_means_that_the_port_is_gone(error):
    port = SerialPort(Broken(error))
    for call in (port.read, lambda: port.write(b"x"), port.drop):
        with pytest.raises(DeviceError, match="the port vanished"):
            call()
    port.close()


def test_no_such_port(monkeypatch):
    here = (PortInfo("/dev/ttyACM0", "Ribbon", None),)
    monkeypatch.setattr(ports, "list_ports", lambda: here)
    with pytest.raises(DeviceError) as caught:
        open_port("/dev/ttyACM1", BAUDRATE)
    assert str(caught.value) == (
        'there is no port "/dev/ttyACM1"; did you mean "/dev/ttyACM0"?; the ports here are '
        "/dev/ttyACM0 (Ribbon)"
    )
    monkeypatch.setattr(ports, "list_ports", tuple)
    with pytest.raises(DeviceError, match="nor any other serial port; is the ribbon plugged in"):
        open_port("/dev/ttyACM1", BAUDRATE)
    monkeypatch.setattr(ports, "list_ports", raising(OSError(errno.ENODEV, "gone")))
    with pytest.raises(DeviceError, match="nor any other serial port"):
        open_port("/dev/ttyACM1", BAUDRATE)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (serial.SerialException(errno.EACCES, "x"), r"no right .* group (\w+) \(sudo usermod -aG"),
        (serial.SerialException(errno.EBUSY, "x"), "is in use"),
        (serial.SerialException("could not open port 'COM3': PermissionError(13,"), "is in use"),
        (serial.SerialException("could not open port: FileNotFoundError(2,"), "there is no port"),
        (termios.error(5, "Input/output error"), "cannot be opened .*; is it a serial port"),
        (ValueError("Invalid baud rate: 3"), "cannot be opened .Invalid baud rate: 3."),
    ],
)
def test_why_a_port_cannot_be_opened(monkeypatch, error, words):
    monkeypatch.setattr(serial.Serial, "open", raising(error))
    with pytest.raises(DeviceError, match=words):
        open_port("/dev/ttyUSB0", BAUDRATE)


def test_the_group_told_is_the_devices_own(monkeypatch, tmp_path):
    device = tmp_path / "tty"
    device.touch()
    refused = serial.SerialException(errno.EACCES, "x")
    monkeypatch.setattr(serial.Serial, "open", raising(refused))
    with pytest.raises(DeviceError, match=f"add yourself to the group {device.group()} "):
        open_port(str(device), BAUDRATE)
    with pytest.raises(DeviceError, match="add yourself to the group dialout "):
        open_port(str(tmp_path / "none"), BAUDRATE)


def test_a_file_is_no_port(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("hello")
    with pytest.raises(DeviceError, match="is it a serial port"):
        open_port(str(file), BAUDRATE)
    assert file.read_text() == "hello"


def test_a_socket(listener):
    port = open_port(url_of(listener), BAUDRATE)
    far, _ = listener.accept()
    with far:
        assert port.read() == b""
        assert port.write(b"start\n")
        assert far.recv(100) == b"start\n"
        far.sendall(b"old")
        port.drop()
        far.sendall(b"new")
        got = b""
        while not got.endswith(b"new"):
            got += port.read()
    with pytest.raises(DeviceError, match="the other end closed the connection"):
        read_on(port)
    port.drop()
    port.close()
    port.close()


def test_a_socket_that_takes_no_more_and_one_that_was_reset(listener):
    port = open_port(url_of(listener), BAUDRATE)
    far, _ = listener.accept()
    wait_until(lambda: not port.write(b"x" * 65536))
    # Closed with bytes unread, the connection is reset.
    far.close()
    with pytest.raises(DeviceError, match="the port vanished"):
        write_on(port)
    port.close()


def test_nobody_listens(listener):
    url = url_of(listener)
    listener.close()
    with pytest.raises(DeviceError, match=r"nobody listens at .* is the ribbon switched on"):
        open_port(url, BAUDRATE)


@pytest.mark.parametrize(
    "error",
    [socket.gaierror(-2, "Name or service not known"), TimeoutError("timed out"), UnicodeError()],
)
def test_no_connection(monkeypatch, error):
    monkeypatch.setattr(socket, "create_connection", raising(error))
    with pytest.raises(DeviceError, match=r"no connection to .* are the address and the network"):
        open_port("socket://ribbon.example:4000", BAUDRATE)


def test_a_connection_that_goes_while_it_is_set_up(monkeypatch, listener):
    monkeypatch.setattr(ports, "_keep_alive", raising(OSError(errno.EINVAL, "x")))
    with pytest.raises(DeviceError, match="no connection"):
        open_port(url_of(listener), BAUDRATE)


def test_a_dead_connection_is_no_pause():
    """The system's own time-out, told by a number, is not the short wait of a read."""
    dead = TimeoutError(errno.ETIMEDOUT, "Connection timed out")
    with pytest.raises(TimeoutError):
        ports._raise_if_dead(dead)
    ports._raise_if_dead(TimeoutError("timed out"))


def test_ports_are_listed_by_name(monkeypatch):
    found = [
        SimpleNamespace(device="/dev/b", description="n/a", serial_number=None, vid=None, pid=None),
        SimpleNamespace(device="/dev/a", description="Ribbon", serial_number="7", vid=1, pid=2),
    ]
    monkeypatch.setattr(ports._listing, "comports", lambda: found)
    assert list_ports() == (
        PortInfo("/dev/a", "Ribbon", "7", 1, 2),
        PortInfo("/dev/b", "no description", None),
    )


class Listing:
    """The ports that are there now."""

    def __init__(self, *present):
        self.present = present

    def __call__(self):
        return [PortInfo(device, "Ribbon", number, 1, 2) for device, number in self.present]


def test_a_device_is_found_under_its_new_name():
    listing = Listing(("/dev/ttyACM0", "7"), ("/dev/ttyACM1", "8"))
    finder = Finder("/dev/ttyACM0", listing)
    assert finder.names() == ("/dev/ttyACM0",)
    finder.opened("/dev/ttyACM0")
    listing.present = (("/dev/ttyACM0", "8"), ("/dev/ttyACM1", "7"))
    assert finder.names() == ("/dev/ttyACM1", "/dev/ttyACM0")
    listing.present = (("/dev/ttyACM0", "7"),)
    assert finder.names() == ("/dev/ttyACM0",)
    listing.present = ()
    assert finder.names() == ("/dev/ttyACM0",)


def test_a_device_of_two_ports_is_tried_at_both():
    listing = Listing(("/dev/ttyACM0", "7"), ("/dev/ttyACM1", "7"))
    finder = Finder("/dev/ttyACM1", listing)
    finder.opened("/dev/ttyACM1")
    listing.present = (("/dev/ttyACM2", "7"), ("/dev/ttyACM3", "7"))
    assert finder.names()[0] == "/dev/ttyACM2"
    finder.silent()
    assert finder.names()[0] == "/dev/ttyACM3"
    finder.opened("/dev/ttyACM3")
    assert finder.names() == ("/dev/ttyACM2", "/dev/ttyACM3", "/dev/ttyACM1")


def test_without_a_serial_number_the_name_is_all_there_is():
    listing = Listing(("/dev/ttyS0", None), ("/dev/ttyS1", None))
    finder = Finder("/dev/ttyS0", listing)
    finder.opened("/dev/ttyS0")
    listing.present = (("/dev/ttyS1", None),)
    assert finder.names() == ("/dev/ttyS0",)


def test_a_link_to_a_device_is_that_device(tmp_path):
    device, link = tmp_path / "ttyACM0", tmp_path / "by-id"
    device.touch()
    link.symlink_to(device)
    listing = Listing((str(device), "7"))
    finder = Finder(str(link), listing)
    finder.opened(str(link))
    assert finder.names() == (str(link),)
    listing.present = (("/dev/ttyACM5", "7"),)
    assert finder.names() == ("/dev/ttyACM5", str(link))


def test_a_socket_has_one_name_and_a_listing_may_fail():
    finder = Finder("socket://localhost:1", raising(AssertionError("nothing to list")))
    finder.opened("socket://localhost:1")
    assert finder.names() == ("socket://localhost:1",)
    failing = Finder("/dev/ttyACM0", raising(OSError(errno.ENODEV, "gone")))
    failing.opened("/dev/ttyACM0")
    assert failing.names() == ("/dev/ttyACM0",)
