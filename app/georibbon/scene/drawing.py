"""What a capture that goes on shows of itself, before there is any result and after."""

from dataclasses import dataclass

from georibbon.arrays import FloatArray
from georibbon.recording import PassKind


@dataclass(frozen=True, eq=False)
class CaptureDrawing:
    """The curves of a capture, in the workpiece frame, metres.

    passes: what has been taken, each its name, its kind and its (n, 3) points, n
    at least 2.  live: the name of what is being laid and the (n, 3) points of the
    ribbon as it lies now; None where nothing is seen of it.  neighbour: the name
    of the one of `passes` that the live one is laid beside; it is drawn so that
    it stands out.
    """

    passes: tuple[tuple[str, PassKind, FloatArray], ...] = ()
    live: tuple[str, FloatArray] | None = None
    neighbour: str | None = None
