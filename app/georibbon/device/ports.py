"""Serial ports and sockets, opened by name, and found again after a cable was pulled.

A port here does four things; none of them waits longer than a tenth of a second
unless a driver hangs.  Whatever a driver raises comes out as a DeviceError with
one sentence.
"""

import errno
import os
import socket
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

import serial
from serial.tools import list_ports as _listing

from georibbon.errors import DeviceError
from georibbon.session.words import nearest, told

BAUDRATE = 921_600
READ_WAIT = 0.05  # s that a read waits for a first byte; a stop is heeded that often
WRITE_WAIT = 0.1
CONNECT_WAIT = 3.0
MOST_READ = 65_536
MOST_DROPS = 64  # reads that drop what a socket holds; a flood is not waited for
MOST_TOLD = 10  # ports in one message
_SOCKET = "socket"
# A connection whose other end is silently gone is given up after about ten seconds.
_KEEPALIVE = (("TCP_KEEPIDLE", 4), ("TCP_KEEPINTVL", 2), ("TCP_KEEPCNT", 3))
_USER_TIMEOUT = 10_000  # ms


class Port(Protocol):
    """What the link needs of a port; used by one thread."""

    def read(self) -> bytes:
        """What has come; nothing after `READ_WAIT` without a byte.  DeviceError: it is gone."""

    def write(self, data: bytes) -> bool:
        """Write all; False where the port did not take it in time.  DeviceError: it is gone."""

    def drop(self) -> None:
        """Forget what was received and not read."""

    def close(self) -> None:
        """Give the port back; never raises."""


@dataclass(frozen=True)
class PortInfo:
    """A serial port of this computer; the USB serial number where it has one."""

    device: str
    description: str
    serial_number: str | None
    vid: int | None = None
    pid: int | None = None


OpenPort = Callable[[str, int], Port]
ListPorts = Callable[[], Sequence[PortInfo]]


def list_ports() -> tuple[PortInfo, ...]:
    """The serial ports of this computer, by name."""
    found = [
        PortInfo(p.device, _described(p.description), p.serial_number, p.vid, p.pid)
        for p in _listing.comports()
    ]
    return tuple(sorted(found, key=lambda port: port.device))


def _described(description: str | None) -> str:
    return description if description and description != "n/a" else "no description"


def check_url(url: str) -> None:
    """DeviceError unless the url is a serial port's name or socket://host:port."""
    expected = "a port such as /dev/ttyACM0, COM3 or socket://192.168.1.20:4000 is expected"
    if not url.strip() or not url.isprintable():
        raise DeviceError(f"the port {told(url)} is no name; {expected}")
    if "://" in url:
        _address(url, expected)


def _address(url: str, expected: str) -> tuple[str, int]:
    """Host and port number of a socket's url."""
    try:
        parts = urlsplit(url)
        host, number = parts.hostname, parts.port
    except ValueError:
        raise DeviceError(f"the port {told(url)} cannot be read; {expected}") from None
    rest = parts.path.strip("/") + parts.query + parts.fragment
    if parts.scheme != _SOCKET or not host or not number or rest:
        raise DeviceError(f"the port {told(url)} is of no kind known here; {expected}")
    return host, number


def open_port(url: str, baudrate: int) -> Port:
    """Open a serial port by name, or socket://host:port.

    Raises DeviceError with the reason: there is no such port, no right to open
    it, it is in use, nobody listens there, or it is no serial port at all.
    """
    if "://" in url:
        return SocketPort(url)
    # Exclusive, so that no second program takes half of the bytes.
    line = serial.Serial(
        baudrate=baudrate, timeout=READ_WAIT, write_timeout=WRITE_WAIT, exclusive=True
    )
    line.port = url
    try:
        line.open()
    except _FAULTS as error:
        raise DeviceError(_refusal(url, error)) from None
    return SerialPort(line)


def _terminal_errors() -> tuple[type[Exception], ...]:
    """What the terminal's own module raises, and pyserial lets through; it is no OSError."""
    if sys.platform == "win32":
        return ()
    import termios

    return (termios.error,)


_TERMINAL = _terminal_errors()
# TypeError: pyserial passes None to the system where a port was closed during a call.
_FAULTS: tuple[type[Exception], ...] = (OSError, TypeError, ValueError, *_TERMINAL)


@contextmanager
def _gone() -> Iterator[None]:
    """Whatever a port raises in use means one thing: it is gone."""
    try:
        yield
    except _FAULTS as error:
        raise DeviceError(f"the port vanished: was the cable pulled? ({_plain(error)})") from error


class SerialPort:
    """A serial port, opened by pyserial or by what behaves like it."""

    def __init__(self, line: serial.Serial) -> None:
        self._line = line

    def read(self) -> bytes:
        """What has come; nothing after `READ_WAIT` without a byte."""
        with _gone():
            waiting = min(self._line.in_waiting, MOST_READ)
            data = bytes(self._line.read(max(waiting, 1)))
            # Where nothing was waiting, the first byte that came has others behind it.
            more = min(self._line.in_waiting, MOST_READ) if data and not waiting else 0
            return data + bytes(self._line.read(more)) if more else data

    def write(self, data: bytes) -> bool:
        """Write all; False where the port did not take it in time."""
        with _gone():
            try:
                self._line.write(data)
            except serial.SerialTimeoutException:
                return False
            return True

    def drop(self) -> None:
        """Forget what was received and not read."""
        with _gone():
            self._line.reset_input_buffer()

    def close(self) -> None:
        """Give the port back."""
        with suppress(*_FAULTS):
            self._line.close()


class SocketPort:
    """A TCP connection to a ribbon, or to a converter that it hangs on.

    pyserial opens the same urls, but waits 0.3 s in every close, and leaves a
    connection open that the other end has reset; so the socket is used itself.
    """

    def __init__(self, url: str) -> None:
        host, number = _address(url, "socket://host:port is expected")
        try:
            self._socket = socket.create_connection((host, number), CONNECT_WAIT)
        except (OSError, UnicodeError) as error:
            raise DeviceError(_no_connection(url, error)) from None
        try:
            _keep_alive(self._socket)
        except OSError as error:
            self._socket.close()
            raise DeviceError(_no_connection(url, error)) from None

    def read(self) -> bytes:
        """What has come; nothing after `READ_WAIT` without a byte."""
        with _gone():
            try:
                data = self._socket.recv(MOST_READ)
            except TimeoutError as error:
                _raise_if_dead(error)
                return b""
        if not data:
            raise DeviceError("the port vanished: the other end closed the connection")
        return data

    def write(self, data: bytes) -> bool:
        """Write all; False where the port did not take it in time."""
        with _gone():
            try:
                self._socket.sendall(data)
            except TimeoutError as error:
                _raise_if_dead(error)
                return False
            return True

    def drop(self) -> None:
        """Forget what was received and not read."""
        with _gone():
            self._socket.setblocking(False)
            with suppress(BlockingIOError):
                for _ in range(MOST_DROPS):
                    self._socket.recv(MOST_READ)
            self._socket.settimeout(READ_WAIT)

    def close(self) -> None:
        """Give the connection back."""
        with suppress(OSError):
            self._socket.close()


def _raise_if_dead(error: TimeoutError) -> None:
    """A wait of ours that ran out has no number; one of the system's means a dead connection."""
    if error.errno is not None:
        raise error


def _keep_alive(connection: socket.socket) -> None:
    """Short waits, no delay, and word from the system when the other end is silently gone."""
    connection.settimeout(READ_WAIT)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in (*_KEEPALIVE, ("TCP_USER_TIMEOUT", _USER_TIMEOUT)):
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


class Finder:
    """Finds a device again whose name may have changed: by USB serial number, then by name."""

    def __init__(self, url: str, listing: ListPorts) -> None:
        self._url = url
        self._listing = listing
        self._known: PortInfo | None = None
        self._silent = 0

    def names(self) -> tuple[str, ...]:
        """What to open, the most likely first."""
        known = self._known
        if known is None:
            return (self._url,)
        same = [port.device for port in self._listed() if _same_device(port, known)]
        # The url itself names it still where it is the same device, or a link to it.
        if not same or any(_same_place(self._url, device) for device in same):
            return (self._url,)
        # A device may have several ports: another one is tried where one said nothing.
        first = self._silent % len(same)
        return (*same[first:], *same[:first], self._url)

    def silent(self) -> None:
        """Nothing answered under the first of the names."""
        self._silent += 1

    def opened(self, name: str) -> None:
        """Remember the device that answered under a name."""
        self._silent = 0
        if "://" in name:
            return
        found = [port for port in self._listed() if _same_place(name, port.device)]
        if found and found[0].serial_number:
            self._known = found[0]

    def _listed(self) -> Sequence[PortInfo]:
        try:
            return self._listing()
        except _FAULTS:  # a device that goes while it is asked for its names
            return ()


def _same_device(one: PortInfo, other: PortInfo) -> bool:
    numbers = (one.serial_number, one.vid, one.pid)
    return numbers == (other.serial_number, other.vid, other.pid)


def _same_place(name: str, device: str) -> bool:
    return name == device or os.path.realpath(name) == os.path.realpath(device)


def _refusal(url: str, error: Exception) -> str:
    """Why a serial port cannot be opened, and what to do."""
    number = getattr(error, "errno", None)
    text = str(error)
    if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO) or "FileNotFoundError" in text:
        return f"there is no port {told(url)}{_present(url)}"
    if number in (errno.EAGAIN, errno.EBUSY) or "PermissionError" in text:
        return f"the port {told(url)} is in use; close the other program that reads it"
    if number in (errno.EACCES, errno.EPERM):
        group = _group(url)
        return (
            f"no right to open the port {told(url)}; add yourself to the group {group} "
            f"(sudo usermod -aG {group} $USER) and log in again"
        )
    return f"the port {told(url)} cannot be opened ({_plain(error)}); is it a serial port?"


def _present(url: str) -> str:
    """Which ports there are, the near one first told."""
    try:
        ports = list_ports()
    except _FAULTS:
        ports = ()
    if not ports:
        return ", nor any other serial port; is the ribbon plugged in?"
    names = [port.device for port in ports]
    shown = ", ".join(f"{port.device} ({port.description})" for port in ports[:MOST_TOLD])
    return f"{nearest(url, names)}; the ports here are {shown}"


def _group(url: str) -> str:
    """The group that may open a port; dialout where that cannot be told."""
    try:
        return Path(url).group()
    except (OSError, KeyError, NotImplementedError):
        return "dialout"


def _no_connection(url: str, error: Exception) -> str:
    if isinstance(error, ConnectionRefusedError):
        return f"nobody listens at {told(url)}; is the ribbon switched on, the number right?"
    return f"no connection to {told(url)} ({_plain(error)}); are the address and the network right?"


def _plain(error: Exception) -> str:
    """The system's own words for an error."""
    number = getattr(error, "errno", None)
    if isinstance(number, int) and not isinstance(error, socket.gaierror):
        return os.strerror(number)
    # pyserial puts guesses in brackets behind what it found.
    return str(error).partition(" (")[0].rstrip(".")[:200] or type(error).__name__
