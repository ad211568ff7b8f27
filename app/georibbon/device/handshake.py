"""The start of a conversation with a ribbon: who are you, and the answer waited for."""

import threading
import time
from dataclasses import dataclass

from georibbon.device.health import Counts
from georibbon.device.identity import Identity, read_identity
from georibbon.device.packets import IDENTITY, MOST_DECODED, Packet, PacketReader
from georibbon.device.ports import Port
from georibbon.errors import DeviceError
from georibbon.session.words import counted

MOST_HELD = 5_000  # packets kept while the identity is awaited; more are lost, and counted so


@dataclass(frozen=True)
class LinkTiming:
    """How long the link waits for what, in seconds.

    answer, tries: for an identity, and how often it is asked for.  stall:
    without a frame while frames are due.  retry_first, retry_last: between tries
    to open the port, from the first to the last.  stop: until a thread that hangs
    in a port is left to end by itself.
    """

    answer: float = 2.0
    tries: int = 3
    stall: float = 1.0
    retry_first: float = 0.1
    retry_last: float = 1.0
    stop: float = 0.12


@dataclass(frozen=True, slots=True)
class Arrival:
    """A packet, and when its last byte was read (seconds of the monotonic clock)."""

    packet: Packet
    arrived: float


class Wire:
    """An open port as packets in and commands out; used by the link's thread alone.

    trusted: whether the ribbon has said who it is; what is damaged before, such
    as a packet that was cut off when the port was opened, is not counted.
    """

    def __init__(self, port: Port, counts: Counts) -> None:
        self.bytes = 0
        self.trusted = False
        self._port = port
        self._counts = counts
        self._reader = PacketReader()
        self._damaged = 0

    @property
    def too_long(self) -> int:
        """How many packets were longer than a packet may be."""
        return self._reader.too_long

    def drop(self) -> None:
        """Forget what the line held before it was opened."""
        self._port.drop()
        self._reader.drop()

    def read(self) -> list[Arrival]:
        """The packets that have come; none after a short wait.  DeviceError: the port is gone."""
        data = self._port.read()
        arrived = time.monotonic()
        packets = self._reader.feed(data)
        damaged, self._damaged = self._reader.damaged - self._damaged, self._reader.damaged
        self.bytes += len(data)
        with self._counts.lock:
            self._counts.bytes += len(data)
            self._counts.damaged += damaged if self.trusted else 0
        return [Arrival(packet, arrived) for packet in packets]

    def send(self, *commands: str) -> None:
        """Commands, each a line.  What a port does not take in time is asked again later."""
        self._port.write("".join(f"{command}\n" for command in commands).encode("ascii"))


class Handshake:
    """Asks a ribbon who it is; what else comes meanwhile is kept in `held`."""

    def __init__(self, wire: Wire, timing: LinkTiming, stopping: threading.Event) -> None:
        self.held: list[Arrival] = []
        self._wire = wire
        self._timing = timing
        self._stopping = stopping
        self._packets = 0

    def identify(self, *before: str) -> Identity | None:
        """The ribbon's identity, asked for after other commands; None where told to stop.

        Raises DeviceError where none comes, with what came instead, and for one
        that cannot be read.
        """
        for _ in range(self._timing.tries):
            self._wire.send(*before, "identify")
            until = time.monotonic() + self._timing.answer
            while time.monotonic() < until:
                if self._stopping.is_set():
                    return None
                answer = self._answer()
                if answer is not None:
                    return read_identity(answer.payload)
        raise DeviceError(self._silence())

    def _answer(self) -> Packet | None:
        """The last identity among the packets that have come."""
        arrivals = self._wire.read()
        self._packets += len(arrivals)
        self.held += arrivals[: MOST_HELD - len(self.held)]
        found = [a.packet for a in arrivals if a.packet.type == IDENTITY]
        return found[-1] if found else None

    def _silence(self) -> str:
        seconds = self._timing.answer * self._timing.tries
        if self._wire.too_long:
            return (
                f"{counted(self._wire.too_long, 'packet')} of more than {MOST_DECODED} bytes came "
                f"and no identity within {seconds:g} s; has the ribbon too many sensors for one?"
            )
        if self._packets:
            return (
                f"{counted(self._packets, 'packet')} came, but no identity within {seconds:g} s; "
                "is this a ribbon, and its firmware up to date?"
            )
        if self._wire.bytes:
            return (
                f"{counted(self._wire.bytes, 'byte')} came that are no packets; the baud rate is "
                "wrong, or this is no ribbon"
            )
        return f"nothing answers within {seconds:g} s; is this the ribbon's port, and is it on?"
