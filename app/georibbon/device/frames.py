"""Frames as the link delivers them: what all axes said at one moment."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from georibbon.ribbon import Readings

LOST = -32768
"""What stands on the wire for a value that was lost."""

CLOCK = 1 << 32
_MICROSECONDS = struct.Struct("<I")
Counts = NDArray[np.int16]


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """One frame.

    t: seconds, from the ribbon's own clock, counted from the link's first frame
    and growing from frame to frame.  counts: (c,) int16, in the order of
    `Ribbon.columns`; `LOST` where a value was lost.  arrived: seconds of the
    host's monotonic clock (`time.monotonic`) when its bytes were read.
    """

    t: float
    counts: Counts
    arrived: float


def pack_frame(microseconds: int, counts: Counts) -> bytes:
    """The payload of a frame packet: the ribbon's clock, and (c,) int16 counts."""
    return _MICROSECONDS.pack(microseconds % CLOCK) + counts.astype("<i2").tobytes()


def frame_bytes(columns: int) -> int:
    """How long the payload of a frame packet is."""
    return _MICROSECONDS.size + 2 * columns


def unpack_frame(payload: bytes, columns: int) -> tuple[int, Counts] | None:
    """Microseconds and counts of a frame packet; None where its length is not the ribbon's."""
    if len(payload) != frame_bytes(columns):
        return None
    counts = np.frombuffer(payload, "<i2", offset=_MICROSECONDS.size).astype(np.int16)
    return _MICROSECONDS.unpack_from(payload)[0], counts


def readings_of(frames: Sequence[Frame]) -> Readings:
    """Frames, at least one, as readings: t from the first frame on, NaN for what was lost."""
    t = np.array([frame.t for frame in frames], dtype=np.float64)
    counts = np.array([frame.counts for frame in frames]).astype(np.float64)
    counts[counts == LOST] = np.nan
    return Readings(t - t[0], counts)
