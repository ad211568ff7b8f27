"""Whether a session file is in order; if not, what can be saved of it into a new one."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from georibbon.errors import SessionError
from georibbon.session.carving import carved
from georibbon.session.chunks import DamagedError
from georibbon.session.lock import holder
from georibbon.session.reading import Contents, check_file, contents, reading
from georibbon.session.restoration import Restoration, restore
from georibbon.session.schema import APPLICATION_ID, VERSION
from georibbon.session.soundness import check_wholly, left_log
from georibbon.session.state import SessionState
from georibbon.session.store import check_place, create
from georibbon.session.words import told

Verdict = Literal["fine", "not closed", "damaged", "salvaged"]
_FAR_VERSION = 100  # no version so far ahead is to be expected: the header is damaged


@dataclass(frozen=True)
class Checkup:
    """What was found of a session file.

    path: the file that the numbers are of; message: a sentence for the person;
    frames: of poses, passes and streams; lost: what cannot be read, or could
    not be saved, a sentence each.
    """

    path: Path
    verdict: Verdict
    message: str
    frames: int
    poses: int
    passes: int
    notes: int
    events: int
    lost: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is lost."""
        return self.verdict in ("fine", "not closed")


def check_session(path: Path) -> Checkup:
    """Read all of a session file, and change nothing.

    The checkup of a damaged file counts what can be saved.  Raises SessionError
    for what is no session, of a newer version or open in another program, and
    where nothing can be saved.
    """
    _refuse_open(path)
    try:
        found = _read_wholly(path)
    except SessionError as error:
        _refuse_what_is_not_damaged(path, error)
        with _restored(path, error if error.__cause__ is None else None) as made:
            frames = sum(chunk.frames for chunk in made.chunks())
            message = f"{path.name}: the session file is damaged ({_reason(path, error)})"
            return _checkup(path, "damaged", message, frames, made.state, made.lost)
    frames, left = sum(found.sizes.values()), left_log(path)
    if not found.closed:
        message = (
            f"{path.name}: the session was not closed, as after a crash; it is in order, and "
            "opening it puts it right"
        )
        return _checkup(path, "not closed", _with(message, left), frames, found.state)
    message = _with(f"{path.name}: the session is in order", left)
    return _checkup(path, "fine", message, frames, found.state)


def salvage(path: Path, target: Path) -> Checkup:
    """Save what can be read of a session file into a new one; the old one stays as it is.

    Raises SessionError where the target is there already or cannot be written,
    where the session is open in another program, and where nothing can be saved.
    """
    _refuse_open(path)
    check_place(target)
    try:
        check_file(path)
        foreign = None
    except SessionError as error:
        foreign = error
    with _restored(path, foreign) as made:
        create(target, made.events, made.chunks())
    found = _read_wholly(target)
    message = f"{target.name}: all that can be read of {path.name}"
    frames = sum(found.sizes.values())
    return _checkup(target, "salvaged", message, frames, found.state, made.lost)


def _with(message: str, left: str | None) -> str:
    return message if left is None else f"{message}; but {left}"


def _checkup(
    path: Path,
    verdict: Verdict,
    message: str,
    frames: int,
    state: SessionState,
    lost: list[str] | None = None,
) -> Checkup:
    numbers = (len(state.poses), len(state.passes), len(state.notes), len(state.history))
    return Checkup(path, verdict, message, frames, *numbers, tuple(lost or ()))


def _refuse_open(path: Path) -> None:
    """SessionError where a program is writing to the session: it is not what it will be."""
    owner = holder(path)
    if owner is not None:
        raise SessionError(
            f"{path.name}: {owner} has the session open; close it there, then check it"
        )


def _refuse_what_is_not_damaged(path: Path, error: SessionError) -> None:
    """Raise the error again where another remedy than saving is asked for."""
    if "locked" in str(error.__cause__) or "busy" in str(error.__cause__):
        raise error
    head = _head(path)
    if not head or (_is_ours(head) and VERSION < int.from_bytes(head[60:64]) < _FAR_VERSION):
        raise error


def _reason(path: Path, error: SessionError) -> str:
    """What is damaged, short."""
    if error.__cause__ is not None:
        return told(str(error.__cause__)).strip('"')
    if not _is_ours(_head(path)):
        return "its header is destroyed"
    return told(str(error).partition(": ")[2]).strip('"')


def _head(path: Path) -> bytes:
    """The header of a file; nothing where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(100)
    except (OSError, ValueError):
        return b""


def _is_ours(head: bytes) -> bool:
    return head[:16] == b"SQLite format 3\0" and head[68:72] == APPLICATION_ID.to_bytes(4)


@contextmanager
def _restored(path: Path, foreign: SessionError | None) -> Iterator[Restoration]:
    """What can be saved of a session.

    foreign: what to raise where nothing of one is found, if it may never have been one.
    """
    with carved(path) as carving:
        if foreign is not None and not carving.events and not carving.pieces:
            raise foreign
        try:
            yield restore(carving, path.name, _last_event(path))
        except DamagedError as error:
            message = f"{path.name}: {error}; see that no program writes to it, and try again"
            raise SessionError(message) from error


def _last_event(path: Path) -> int | None:
    """The id of the last event as SQLite finds it; None where it cannot."""
    try:
        with reading(path) as database:
            last = database.execute("SELECT max(id) FROM event").fetchone()[0]
    except SessionError:
        return None
    return last if isinstance(last, int) else None


def _read_wholly(path: Path) -> Contents:
    """The contents of a session, every frame and the log read; SessionError where damaged."""
    with reading(path) as database:
        found = contents(database, path)
        check_wholly(database, found, path)
    return found
