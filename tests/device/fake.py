"""A ribbon of a few lines: enough of the protocol to be at the other end of a link."""

import contextlib
import os
import socket
import threading
import time
import tty
from collections import deque
from pathlib import Path

import numpy as np

from georibbon.device.frames import pack_frame
from georibbon.device.identity import Identity, write_identity
from georibbon.device.packets import DONE, FRAME, IDENTITY, MESSAGE, Packet, encode
from georibbon.errors import DeviceError
from georibbon.ribbon import Ribbon, Sensor

RIBBON = Ribbon(
    "GR-0007",
    0.5,
    200.0,
    (
        Sensor("A01", "accelerometer", 3, 0.1, 16384.0),
        Sensor("M01", "magnetometer", 2, 0.2, 2000.0),
        Sensor("M02", "magnetometer", 3, 0.4, 2000.0),
    ),
)


def settled(threads, descriptors):
    """Whether there are no more threads and open files than before."""
    return threading.active_count() <= threads and len(open_files()) <= descriptors


def open_files():
    """This process's open files."""
    return list(Path("/proc/self/fd").iterdir())


class FakeRibbon:
    """Answers commands, and sends a frame whenever it is due; `serve` ends a connection's turn.

    `sent` counts the packets it has numbered, `frames` those of them that are
    frames.  With a `battery` it goes on while nobody listens; without one it
    begins anew with every connection.
    """

    def __init__(self, ribbon=RIBBON, battery=True, answers=True):
        self.ribbon, self.battery, self.answers = ribbon, battery, answers
        self.sequence, self.frames, self.sent = 0, 0, 0
        self.clocks = []  # of the frames, in microseconds
        self.mute = threading.Event()
        self.damage = set()  # sequence numbers whose packets are sent damaged
        self.drop = set()  # and those that are not sent at all
        self.says = deque()  # (type, payload) of packets to be sent besides
        self.commands = []
        self._born = time.monotonic()
        self._streaming = False
        self._next = self._born
        self._rest = b""
        self._ends = threading.Event()
        self._thread = None

    def packet(self, kind, payload):
        number = self.sequence
        self.sequence = (number + 1) % 65536
        self.sent += 1
        data = bytearray(encode(Packet(kind, number, payload)))
        if number in self.damage:
            data[len(data) // 2] ^= 0x01 if data[len(data) // 2] != 1 else 0x02
        return b"" if number in self.drop else bytes(data)

    def frame(self):
        self.frames += 1
        counts = np.full(len(self.ribbon.columns), self.frames % 30000, dtype=np.int16)
        self.clocks.append(round((self._next - self._born) * 1e6))
        return self.packet(FRAME, pack_frame(self.clocks[-1], counts))

    def take(self, data):
        """What the ribbon says to these bytes from the host."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        return b"".join(self._answer(line.decode("ascii")) for line in lines)

    def _answer(self, line):
        self.commands.append(line)
        if not self.answers:
            return b""
        word, _, value = line.partition(" ")
        if word == "identify":
            return self.packet(IDENTITY, write_identity(Identity(self.ribbon, "1.4.0")))
        if word in ("start", "stop"):
            self._streaming, self._next = word == "start", time.monotonic()
        elif word == "rate":
            rate = min((50.0, 100.0, 200.0), key=lambda r: abs(r - float(value)))
            self.ribbon = Ribbon(self.ribbon.id, self.ribbon.length, rate, self.ribbon.sensors)
        else:
            return self.packet(MESSAGE, f"unknown command {line}".encode())
        return self.packet(DONE, line.encode())

    def due(self):
        """What is due by now."""
        out = []
        while self.says:
            out.append(self.packet(*self.says.popleft()))
        return b"".join(out) + self._frames()

    def _frames(self):
        out = []
        while self._streaming and time.monotonic() >= self._next:
            if not self.mute.is_set():
                out.append(self.frame())
            self._next += 1.0 / self.ribbon.rate
        return b"".join(out)

    def _serve(self, read, write):
        with contextlib.suppress(OSError):
            while not self._ends.is_set():
                write(self.take(read(0.001)) + self.due())

    def begin(self):
        """A connection is there: what was due before went nowhere."""
        self._rest = b""
        if self.battery:
            self._frames()
        else:
            self._streaming, self.sequence, self._born = False, 0, time.monotonic()

    def connect(self, read, write):
        """Serve one connection in a thread; read(seconds) and write(bytes) are its line."""
        self.begin()
        self._ends.clear()
        self._thread = threading.Thread(target=self._serve, args=(read, write), daemon=True)
        self._thread.start()

    def disconnect(self):
        self._ends.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None


class DirectPort:
    """A port with a ribbon in it: no cable, no thread."""

    def __init__(self, ribbon):
        self._ribbon, self._answers = ribbon, b""
        self.gone, self.closed = threading.Event(), threading.Event()
        ribbon.begin()

    def read(self):
        time.sleep(0.001)
        if self.gone.is_set():
            raise DeviceError("the port vanished")
        data, self._answers = self._answers, b""
        return data + self._ribbon.due()

    def write(self, data):
        self._answers += self._ribbon.take(data)
        return True

    def drop(self):
        self._answers = b""

    def close(self):
        self.closed.set()


class PtyCable:
    """A pseudo-terminal between a ribbon and a name that stays."""

    def __init__(self, ribbon, name):
        self.ribbon, self.url = ribbon, str(name)
        self._master = None

    def plug(self):
        self._master, end = os.openpty()
        tty.setraw(end)
        os.set_blocking(self._master, False)
        Path(self.url).symlink_to(os.ttyname(end))
        os.close(end)
        self.ribbon.connect(self._read, self._write)

    def _read(self, seconds):
        time.sleep(seconds)
        try:
            return os.read(self._master, 4096)
        except OSError:  # nobody holds the other end, or nothing is there
            return b""

    def _write(self, data):
        while data:
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:
                return  # nobody reads: the rest is lost

    def pull(self):
        self.ribbon.disconnect()
        Path(self.url).unlink()
        os.close(self._master)


class TcpCable:
    """A socket on loopback with a ribbon behind it, for one connection at a time."""

    def __init__(self, ribbon):
        self.ribbon = ribbon
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        self._connection = None
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                self.pull()
                connection.settimeout(0.001)
                self._connection = connection
                self.ribbon.connect(self._read, connection.sendall)

    def _read(self, _seconds):
        try:
            data = self._connection.recv(4096)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionResetError
        return data

    def pull(self):
        self.ribbon.disconnect()
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def close(self):
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join()
        self.pull()
