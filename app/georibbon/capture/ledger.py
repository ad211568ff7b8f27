"""The session as a capture writes it: what was kept is told, and what could not be kept."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar

from georibbon.errors import StorageError
from georibbon.session.session import Session

T = TypeVar("T")
Kind = Literal[
    "chosen", "taken", "refused", "skipped", "removed", "undone", "redone", "noted", "survey",
    "ordered", "planned", "quality", "calibrated", "held", "saved", "link", "complete",
]  # fmt: skip

NOT_YET = "not calibrated yet"  # how a "quality" begins where the poses give no calibration
CHANGES = (
    "skipped",
    "removed",
    "undone",
    "redone",
    "noted",
    "survey",
    "ordered",
    "planned",
    "calibrated",
)


@dataclass(frozen=True)
class Happening:
    """Something that an observer is told: its kind, what it is about, the sentence for a person."""

    kind: Kind
    subject: str | None
    message: str


class Ledger:
    """Writes into a session and tells observers; all on the owner's thread.

    What cannot be written is held in memory by the session; that is told once
    for each reason, and again when everything is on the disk after all.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._observers: list[Callable[[Happening], None]] = []
        self._reason: str | None = None

    def observe(self, callback: Callable[[Happening], None]) -> None:
        """Have every happening told to a callback."""
        self._observers.append(callback)

    def tell(self, kind: Kind, subject: str | None, message: str) -> None:
        """Tell all observers; of a change that is held, that it is."""
        if kind in CHANGES and self._reason is not None:
            message = f"{message} (in memory only, not on disk yet)"
        for callback in tuple(self._observers):
            callback(Happening(kind, subject, message))

    def write(self, change: Callable[[], T]) -> T | None:
        """Make a change of the session; None where it is held."""
        try:
            found = change()
        except StorageError as error:
            if str(error) != self._reason:
                self._reason = str(error)
                self.tell("held", None, self._reason)
            return None
        self.look()
        return found

    def look(self) -> None:
        """See whether what was held has got to the disk meanwhile, and tell it."""
        if self._reason is not None and not self.session.held:
            self._reason = None
            self.tell("saved", None, f"everything is safe in {self.session.path}")
