"""The frames of a part put together from the pieces of it that were found."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.ribbon import Readings
from georibbon.session.carving import Carving, Piece
from georibbon.session.chunks import FRAMES, Chunk, DamagedError, joined, pack
from georibbon.session.fields import MAX_NUMBER
from georibbon.session.words import counted


def whole_part(
    carving: Carving, pieces: Sequence[Piece], frames: int, columns: int
) -> tuple[Chunk, ...]:
    """The chunks of a pose or a pass, all of them.

    pieces: those of its part; frames: how many it has.  Raises DamagedError,
    with how much is damaged, where some are not there or fit in two ways.
    """
    places = {piece.place: piece for piece in pieces}
    expected = -(-frames // FRAMES)
    missing = expected - sum(place < expected for place in places)
    if missing:
        verb = "is" if missing == 1 else "are"
        number = f"{missing} of {counted(expected, 'piece')} of its frames"
        raise DamagedError(f"{number} {verb} damaged")
    if len(places) < len(pieces) or sum(piece.frames for piece in pieces) != frames:
        raise DamagedError("its frames are there more than once and differ")
    chunks = tuple(carving.chunk(places[place]) for place in range(expected))
    if not grows(joined(chunks, columns).t):
        raise DamagedError("the times of its frames do not grow")
    return chunks


def grows(t: FloatArray) -> bool:
    """Whether times, in seconds, are such as frames have."""
    return bool(np.all(np.abs(t) <= MAX_NUMBER) and np.all(np.diff(t) > 0.0))


def stretch(carving: Carving, pieces: Sequence[Piece], columns: int) -> Iterator[Readings]:
    """The frames of a stream as far as they can be read, in the order of their times.

    pieces: those of its part, in any order.  Small chunks that were taken
    together to large ones are found beside them: a frame is told from another
    by its time, and given once.
    """
    fitting = [piece for piece in pieces if piece.columns == columns]
    times = {piece: _times(carving.chunk(piece)) for piece in fitting}
    end = -np.inf
    for piece in sorted(fitting, key=times.__getitem__):
        last = times[piece][-1]
        if last > end:
            readings = joined([replace(carving.chunk(piece), place=0)], columns)
            fresh = readings.t > end
            if grows(readings.t):
                yield Readings(readings.t[fresh], readings.counts[fresh])
                end = last


def repacked(blocks: Iterator[Readings], part: int) -> Iterator[Chunk]:
    """The same frames as chunks of a part, as large as they are made."""
    held: list[Readings] = []
    place = 0
    for block in blocks:
        held.append(block)
        if sum(one.t.size for one in held) >= FRAMES:
            full = _together(held)
            yield from pack(Readings(full.t[:FRAMES], full.counts[:FRAMES]), part, place)
            held = [Readings(full.t[FRAMES:], full.counts[FRAMES:])]
            place += 1
    if held and any(one.t.size for one in held):
        yield from pack(_together(held), part, place)


def _together(blocks: Sequence[Readings]) -> Readings:
    return Readings(
        np.concatenate([block.t for block in blocks]),
        np.concatenate([block.counts for block in blocks]),
    )


def _times(chunk: Chunk) -> tuple[float, int, float]:
    """For the order: when a chunk begins, the larger the sooner, and when it ends."""
    t = np.frombuffer(chunk.t, "<f8")
    return float(t[0]), -chunk.frames, float(t[-1])
