"""Where a host finds the virtual ribbon: a pseudo-terminal behind a stable name, or TCP.

Both are served by one thread, which sleeps until something is due or something
comes, and never waits for a slow host.
"""

import ipaddress
import os
import selectors
import shutil
import socket
import tempfile
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from math import inf
from pathlib import Path
from types import TracebackType
from typing import Self

from georibbon.device.packets import MESSAGE, Packet, encode
from georibbon.errors import SettingsError
from georibbon.virtual.ribbon import VirtualRibbon

READ, READS = 4096, 16
"""Bytes taken at a time, and how often before the frames have their turn."""
KNOCKING = 0.02
"""Seconds between looks whether a host has opened the pseudo-terminal."""
SENDING = 32768
"""Bytes that the system keeps for a slow TCP client: as little as a device would."""
USE_TCP = "use --tcp 127.0.0.1:0 instead of --pty"
NO_TERMINALS = f"this system has no pseudo-terminals; {USE_TCP}"


class GoneError(Exception):
    """The host has closed its end, or has not opened it."""


class Line(ABC):
    """The ribbon's end of a cable.  url: where a host finds it."""

    url: str

    @abstractmethod
    def open(self) -> None:
        """Put the cable in; SettingsError where that cannot be."""

    @abstractmethod
    def close(self) -> None:
        """Pull it; nothing is left open."""

    @abstractmethod
    def remove(self) -> None:
        """Take away what was made for it; it is not opened again."""

    @abstractmethod
    def sources(self) -> list[int]:
        """The descriptors on which a host may come or say something, at this moment."""

    @abstractmethod
    def connected(self) -> bool:
        """Whether a host is there; lets one in that waits."""

    @abstractmethod
    def read(self) -> bytes:
        """What the host has sent, b"" for nothing yet; raises GoneError."""

    @abstractmethod
    def write(self, data: bytes) -> int:
        """Send as much as goes without waiting; how much; raises GoneError."""


class Port:
    """A virtual ribbon that is served; a context manager that leaves nothing behind.

    url: where a host finds it.  A fault of the program ends the service (`serves`
    tells), and `close` raises it.
    """

    def __init__(self, world: VirtualRibbon, line: Line) -> None:
        """Opens the line and serves on it until closed."""
        self._world, self._line = world, line
        self._open, self._present = True, False
        self._rest = b""
        self._closing = threading.Event()
        self._failure: Exception | None = None
        self._awake, self._alarm = socket.socketpair()
        try:
            self._awake.setblocking(False)
            self._alarm.setblocking(False)
            world.attach(self._ring)
            try:
                line.open()
            except BaseException:
                world.detach()
                raise
        except BaseException:
            self._tidy()
            raise
        self._thread = threading.Thread(target=self._serve, name="virtual ribbon", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Where a host finds the ribbon: a path, or socket://HOST:PORT."""
        return self._line.url

    @property
    def serves(self) -> bool:
        """Whether a host is served still."""
        return self._thread.is_alive()

    def __enter__(self) -> Self:
        """The port itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        self.close()

    def close(self) -> None:
        """End the service: the host sees the ribbon vanish.  Raises what ended it before."""
        if self._closing.is_set():
            return
        self._closing.set()
        self._ring()
        self._thread.join()
        self._world.detach()
        self._tidy()
        if self._failure is not None:
            raise self._failure

    def _tidy(self) -> None:
        self._line.remove()
        self._awake.close()
        self._alarm.close()

    def _ring(self) -> None:
        try:
            self._alarm.send(b"\0")
        except OSError:  # full: it is ringing already; closed: nobody is there to wake
            return

    def _serve(self) -> None:
        try:
            while not self._closing.is_set():
                self._plug()
                self._look()
                self._serve_host(self._receive)
                due = self._world.catch_up()
                self._serve_host(self._send)
                self._sleep(due)
        except Exception as failure:  # raised again by `close`: nobody else would hear of it
            self._failure = failure
        finally:
            self._line.close()

    def _plug(self) -> None:
        """Put the cable in or pull it, as the world says."""
        if self._open and not self._world.plugged:
            self._line.close()
            self._open = False
            self._leave()
        elif self._world.plugged and not self._open:
            try:
                self._line.open()
            except SettingsError:
                return  # its name is taken for now; tried again soon
            self._open = True

    def _serve_host(self, part: Callable[[], None]) -> None:
        """Listen or talk to the host, where there is one."""
        try:
            if self._present:
                part()
        except GoneError:
            self._leave()

    def _look(self) -> None:
        """Whether a host has come or gone."""
        present = self._open and self._line.connected()
        if self._present and not present:
            self._leave()
        self._present = present

    def _receive(self) -> None:
        # A host that talks without end must not keep the frames from going out.
        for _ in range(READS):
            if not (data := self._line.read()):
                return
            self._world.receive(data)

    def _send(self) -> None:
        while True:
            if not self._rest:
                self._rest = self._world.take()
            if not self._rest:
                return
            sent = self._line.write(self._rest)
            self._rest = self._rest[sent:]
            if self._rest:
                return

    def _leave(self) -> None:
        """The host is gone."""
        if self._rest:
            self._world.cut()
        self._rest, self._present = b"", False
        self._world.hang_up()

    def _sleep(self, due: float) -> None:
        """Until something is due, comes, or can be sent."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._awake, selectors.EVENT_READ)
            watched = self._line.sources() if self._open else []
            for source in watched:
                wanted = selectors.EVENT_WRITE if self._rest else 0
                selector.register(source, selectors.EVENT_READ | wanted)
            idle = bool(watched) or not self._world.plugged
            wait = due if idle else min(due, KNOCKING)
            selector.select(None if wait == inf else wait)
        try:
            while self._awake.recv(READ):
                pass
        except BlockingIOError:
            return


class Terminal(Line):
    """A pseudo-terminal behind a symbolic link, which keeps its name over a replug."""

    def __init__(self, link: Path | None) -> None:
        """link: where; None: in a private folder of its own."""
        self._folder = None if link else Path(tempfile.mkdtemp(prefix="georibbon-virtual-"))
        self._link = link or Path(str(self._folder)) / "ribbon"
        self._target: str | None = None
        self._master = -1
        self._got = b""
        self._present = False
        self.url = str(self._link)

    def open(self) -> None:
        """A new pseudo-terminal behind the same name."""
        try:
            import pty
            import tty
        except ImportError:
            raise SettingsError(NO_TERMINALS) from None
        try:
            master, slave = pty.openpty()
        except OSError as error:
            raise SettingsError(f"no pseudo-terminal is to be had ({error}); {USE_TCP}") from error
        try:
            # Raw from the start: no echo of frames as commands before the host has set it up.
            tty.setraw(slave)
            os.set_blocking(master, False)
            self._name(os.ttyname(slave))
        except BaseException:
            os.close(master)
            raise
        finally:
            os.close(slave)
        self._master = master

    def close(self) -> None:
        """The terminal vanishes, and its name."""
        if self._master >= 0:
            os.close(self._master)
        if self._target is not None and _target(self._link) == self._target:
            self._link.unlink()
        self._master, self._target, self._got, self._present = -1, None, b"", False

    def remove(self) -> None:
        """Leave no folder behind."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def sources(self) -> list[int]:
        """The terminal, while a host has it open: without one it would never let us sleep."""
        return [self._master] if self._present else []

    def connected(self) -> bool:
        """Whether a host has it open."""
        try:
            self._got = self._got or self._take()
            self._present = True
        except GoneError:
            self._present = False
        return self._present

    def read(self) -> bytes:
        """What the host has sent."""
        got, self._got = self._got, b""
        return got or self._take()

    def write(self, data: bytes) -> int:
        """Send as much as the terminal takes."""
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise GoneError from error

    def _take(self) -> bytes:
        try:
            got = os.read(self._master, READ)
        except BlockingIOError:
            return b""
        except OSError as error:  # EIO: no host has it open
            raise GoneError from error
        if not got:  # how other systems say so
            raise GoneError
        return got

    def _name(self, target: str) -> None:
        """Put the link there; SettingsError where something else has its place."""
        if os.path.lexists(self._link):
            old = _target(self._link)
            if old is None or not old.startswith("/dev/") or self._link.exists():
                raise SettingsError(
                    f"{self._link}: something is there already; give another path, or remove it"
                )
            self._link.unlink()  # left by a virtual ribbon that could not tidy up
        try:
            self._link.symlink_to(target)
        except OSError as error:
            raise SettingsError(
                f"{self._link}: no link can be made there ({error.strerror}); give another path"
            ) from error
        self._target = target


def _target(link: Path) -> str | None:
    """Where a symbolic link leads; None for what is none."""
    try:
        return str(link.readlink())
    except OSError:
        return None


class Listener(Line):
    """A TCP port on this machine alone, for one host at a time."""

    def __init__(self, host: str, port: int) -> None:
        """port: 0 for any.  SettingsError for an address that others could reach."""
        self._host, self._port = _loopback(host), port
        self._server: socket.socket | None = None
        self._client: socket.socket | None = None
        self.url = ""

    def open(self) -> None:
        """Listen; at the same port as before."""
        family = socket.AF_INET6 if ":" in self._host else socket.AF_INET
        server = socket.socket(family, socket.SOCK_STREAM)
        try:
            if os.name == "posix":  # elsewhere it would let another program take the port over
                server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            server.bind((self._host, self._port))
            server.listen(2)
            server.setblocking(False)
        except OSError as error:
            server.close()
            raise SettingsError(
                f"port {self._port} of {self._host} cannot be listened on ({error.strerror}); "
                "choose another, or 0 for any that is free"
            ) from error
        self._server, self._port = server, server.getsockname()[1]
        host = f"[{self._host}]" if ":" in self._host else self._host
        self.url = f"socket://{host}:{self._port}"

    def close(self) -> None:
        """The host is cut off, and the port closed."""
        for one in (self._client, self._server):
            if one is not None:
                one.close()
        self._client = self._server = None

    def remove(self) -> None:
        """Nothing was made."""

    def sources(self) -> list[int]:
        """The port and the host."""
        return [one.fileno() for one in (self._server, self._client) if one is not None]

    def connected(self) -> bool:
        """Lets a host in; a second one is told and sent away."""
        if self._client is not None and _has_left(self._client):
            # Seen before the next is let in: it may be the same host, back at once.
            self._drop()
            return False
        while self._server is not None:
            try:
                client, _ = self._server.accept()
            except OSError:  # nobody waits, or who waited has left
                break
            client.setblocking(False)
            if self._client is not None:
                _send_away(client)
                continue
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SENDING)
            self._client = client
        return self._client is not None

    def read(self) -> bytes:
        """What the host has sent."""
        if self._client is None:
            return b""
        try:
            got = self._client.recv(READ)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._drop()
            raise GoneError from error
        if not got:
            self._drop()
            raise GoneError
        return got

    def write(self, data: bytes) -> int:
        """Send as much as the system takes."""
        if self._client is None:
            return 0
        try:
            return self._client.send(data)
        except BlockingIOError:
            return 0
        except OSError as error:
            self._drop()
            raise GoneError from error

    def _drop(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None


def _has_left(client: socket.socket) -> bool:
    """Whether a host has closed its end and said nothing more before."""
    try:
        return client.recv(1, socket.MSG_PEEK) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def _send_away(client: socket.socket) -> None:
    """Tell a second host that there is a first."""
    busy = encode(Packet(MESSAGE, 0, b"busy: another host is connected; close it first"))
    try:
        client.send(busy)
    except OSError:  # it has left already
        pass
    finally:
        client.close()


def _loopback(host: str) -> str:
    """The address of a host that is this machine; SettingsError for any other."""
    name = "127.0.0.1" if host == "localhost" else host.strip("[]")
    try:
        local = ipaddress.ip_address(name).is_loopback
    except ValueError:
        local = False
    if not local:
        raise SettingsError(
            f"{host}: the virtual ribbon answers on this machine only, where no stranger reaches "
            "it; give 127.0.0.1, ::1 or localhost"
        )
    return name


def serve_pty(world: VirtualRibbon, link: Path | None = None) -> Port:
    """Serve on a pseudo-terminal; use as a context manager, with `url` the path of its link.

    link: where the link shall be; None: in a private temporary folder.  Raises
    SettingsError where there are no pseudo-terminals or the place is taken.
    """
    return Port(world, Terminal(link))


def serve_tcp(world: VirtualRibbon, host: str = "127.0.0.1", port: int = 0) -> Port:
    """Serve on TCP, this machine only; use as a context manager, with `url` socket://HOST:PORT.

    Raises SettingsError for another machine's address or a port that is taken.
    """
    return Port(world, Listener(host, port))
