"""Consistent overhead byte stuffing: any bytes as bytes without a zero.

Cheshire and Baker, "Consistent overhead byte stuffing", IEEE/ACM Transactions
on Networking 7 (1999).  Every run of bytes up to the next zero is preceded by
its length plus one; a run of 254 bytes that no zero ends has the length byte 255.
Where the bytes end with such a run, some write an empty run after it and some
do not; both are read.
"""

LONGEST_RUN = 254


class StuffingError(ValueError):
    """The bytes are not what stuffing gives."""


def stuff(data: bytes) -> bytes:
    """The bytes without a zero among them; `unstuff` gives them back."""
    out = bytearray()
    for run in data.split(b"\0"):
        while len(run) >= LONGEST_RUN:
            out.append(LONGEST_RUN + 1)
            out += run[:LONGEST_RUN]
            run = run[LONGEST_RUN:]  # noqa: PLW2901 (what is left of the run)
        out.append(len(run) + 1)
        out += run
    return bytes(out)


def unstuff(data: bytes) -> bytes:
    """The bytes that were stuffed.

    Raises StuffingError for a zero, for a run that is cut off, and for nothing
    at all.
    """
    if not data or 0 in data:
        raise StuffingError("stuffed bytes are not empty and hold no zero")
    out = bytearray()
    at, size = 0, len(data)
    while at < size:
        code = data[at]
        after = at + code
        if after > size:
            raise StuffingError("a run is cut off")
        out += data[at + 1 : after]
        if code <= LONGEST_RUN and after < size:
            out.append(0)
        at = after
    return bytes(out)
