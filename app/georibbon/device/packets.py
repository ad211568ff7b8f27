"""Packets of the wire protocol, version 1: bytes to packets and back.

A packet is type (1 byte), sequence number (2 bytes, little-endian), payload and
CRC-16/CCITT-FALSE of all that (2 bytes, little-endian), stuffed by `cobs` and
ended by one zero byte.
"""

import binascii
import struct
from dataclasses import dataclass

from georibbon.device.cobs import StuffingError, stuff, unstuff

IDENTITY, FRAME, MESSAGE, DONE = 0x01, 0x02, 0x03, 0x04
KNOWN = (IDENTITY, FRAME, MESSAGE, DONE)
SEQUENCES = 65536
MOST_DECODED = 4096
# Stuffing adds a byte, and one more for every 254.
MOST_STUFFED = MOST_DECODED + MOST_DECODED // 254 + 1
_HEAD = struct.Struct("<BH")
_TAIL = struct.Struct("<H")
_LEAST = _HEAD.size + _TAIL.size
MOST_PAYLOAD = MOST_DECODED - _LEAST


@dataclass(frozen=True, slots=True)
class Packet:
    """One undamaged packet: its type, its sequence number (0 to 65535), its payload."""

    type: int
    sequence: int
    payload: bytes


def encode(packet: Packet) -> bytes:
    """The bytes on the wire, the ending zero included; ValueError for a packet too long."""
    data = _HEAD.pack(packet.type, packet.sequence) + packet.payload
    if len(data) + _TAIL.size > MOST_DECODED:
        raise ValueError(f"a packet of {len(data) + _TAIL.size} bytes; at most {MOST_DECODED}")
    return stuff(data + _TAIL.pack(checksum(data))) + b"\0"


def checksum(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, nothing reflected."""
    return binascii.crc_hqx(data, 0xFFFF)


class PacketReader:
    """Cuts a stream of bytes into packets.

    What does not decode, has a wrong checksum or is too long is dropped and
    counted in `damaged`, and the next zero byte starts afresh; too_long: those of
    them that were too long.  Zero bytes that follow each other are no packet
    and no damage.
    """

    def __init__(self) -> None:
        self.damaged = self.too_long = 0
        self._rest = b""
        self._skipping = False

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that these bytes complete, in their order."""
        *ended, rest = (self._rest + data).split(b"\0")
        packets = []
        for stuffed in ended:
            if self._skipping:
                self._skipping = False
            elif stuffed:
                packet = self._packet(stuffed)
                if packet is not None:
                    packets.append(packet)
        if self._skipping or len(rest) > MOST_STUFFED:
            # Counted once, at its first byte too many; the rest of it is not kept.
            self.damaged += not self._skipping
            self.too_long += not self._skipping
            self._skipping, rest = True, b""
        self._rest = rest
        return packets

    def drop(self) -> None:
        """Forget what the line held: the start of a packet whose end will not come."""
        self._rest, self._skipping = b"", False

    def _packet(self, stuffed: bytes) -> Packet | None:
        if len(stuffed) > MOST_STUFFED:
            self.damaged += 1
            self.too_long += 1
            return None
        try:
            data = unstuff(stuffed)
        except StuffingError:
            data = b""
        if not _LEAST <= len(data) <= MOST_DECODED:
            self.damaged += 1
            return None
        body = data[: -_TAIL.size]
        if checksum(body) != _TAIL.unpack(data[-_TAIL.size :])[0]:
            self.damaged += 1
            return None
        kind, sequence = _HEAD.unpack_from(body)
        return Packet(kind, sequence, body[_HEAD.size :])
