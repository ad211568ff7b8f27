"""The place of a session fails while it captures: what is told, and whether a frame is lost.

The full disk is a small file system in memory where this may be mounted (by
root), else a quota on the size of the file; either is the kernel's own refusal.
"""

import argparse
import os
import resource
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from support.kills import RIBBON, frames
from support.tables import met, publish, table

from georibbon.errors import StorageError
from georibbon.session.session import Session

BLOCKS, BLOCK = 200, 100
SMALL = 2 * 2**20  # bytes of the disk or the quota; more than 3 MB are captured


@dataclass(frozen=True)
class Outcome:
    """What was told, how many frames were accepted and how many are in the new file."""

    told: str
    accepted: int
    kept: int


def main() -> None:
    """Let every place fail, and print the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    rows = []
    for name, (place, fail) in failures().items():
        with tempfile.TemporaryDirectory() as folder, place(Path(folder)) as where:
            found = capture(where, Path(folder), fail)
        fine = found.kept == found.accepted and found.told.count("\n") == 0 and bool(found.told)
        rows.append((name, found.told, f"{found.kept} of {found.accepted}", met(fine)))
    head = ("failure", "told", "frames in the new place", "verdict")
    publish("storage", [table(head, rows)])


def failures() -> dict[str, tuple]:
    """By its name: a place, and what is done to it after half of the capture."""
    disk = ("disk full (tmpfs)", small_disk) if may_mount() else ("disk full (quota)", quota)
    return {
        disk[0]: (disk[1], lambda _: None),
        "file removed": (ordinary, Path.unlink),
        "file replaced": (ordinary, replaced),
        "folder removed": (ordinary, folder_removed),
    }


def capture(where: Path, folder: Path, fail: Callable[[Path], object]) -> Outcome:
    """Capture a stream and passes, let the place fail, choose another one."""
    told, accepted = [], 0
    path, other = where / "s.georibbon", folder / "other.georibbon"
    with Session.create(path, RIBBON) as session:
        session.on_storage(lambda sentence: told.append(sentence or ""))
        stream = session.stream(RIBBON.rate)
        for block in range(BLOCKS):
            if block == BLOCKS // 2:
                fail(path)
            stream.append(frames(stream.part, block * BLOCK, BLOCK))
            stream.flush()
            if block % 20 == 0:
                with suppress(StorageError):
                    session.add_pass(f"P{block}", "pass", frames(block, 0, BLOCK))
                accepted += BLOCK
        accepted += stream.frames
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, HARD))
        session.move_to(other)
    return Outcome(told[0] if told else "", accepted, kept(other))


def kept(path: Path) -> int:
    """How many frames are in a file as they were captured."""
    count = 0
    with Session.open(path) as session:
        for part, kind in (
            (1, 1),
            *((run.part, int(run.name[1:])) for run in session.state.passes),
        ):
            found = session.readings(part)
            made = frames(kind, 0, found.t.size)
            same = np.array_equal(found.counts, made.counts, equal_nan=True)
            count += found.t.size if same and np.array_equal(found.t, made.t) else 0
    return count


HARD = resource.getrlimit(resource.RLIMIT_FSIZE)[1]


@contextmanager
def ordinary(folder: Path) -> Iterator[Path]:
    """A folder of its own."""
    place = folder / "place"
    place.mkdir()
    yield place


@contextmanager
def quota(folder: Path) -> Iterator[Path]:
    """A folder where no file may grow beyond a size."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, HARD))
    yield folder


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A file system in memory."""
    place = folder / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(place)]
    subprocess.run(mount, check=True, capture_output=True)
    with ExitStack() as stack:
        stack.callback(subprocess.run, ["umount", "-l", str(place)], check=False)
        yield place


def may_mount() -> bool:
    """Whether a file system may be mounted here."""
    if os.geteuid() != 0:
        return False
    with tempfile.TemporaryDirectory() as folder:
        try:
            with small_disk(Path(folder)):
                return True
        except (subprocess.CalledProcessError, FileNotFoundError):
            return False


def replaced(path: Path) -> None:
    """Another program puts its file there."""
    path.unlink()
    path.write_text("another one", encoding="utf-8")


def folder_removed(path: Path) -> None:
    """The whole folder goes."""
    for file in path.parent.iterdir():
        file.unlink()
    path.parent.rmdir()


if __name__ == "__main__":
    main()
