"""A capture that is killed at a random moment, and what must then be in its file."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from georibbon.ribbon import Readings, Ribbon, Sensor
from georibbon.session.session import Session

RIBBON = Ribbon(
    "GR-0009",
    1.0,
    100.0,
    tuple(Sensor(f"A{i:02}", "accelerometer", 3, i / 16, 16384.0) for i in range(16))
    + tuple(Sensor(f"M{i:02}", "magnetometer", 2, i / 16, 2000.0) for i in range(16)),
)
BLOCK = 20  # frames appended at a time
PASS = 60  # frames of a pass
PAUSE = 0.002  # seconds between blocks: a hundred times faster than a ribbon
ROUND = 120  # blocks from opening to closing
Acknowledged = dict[tuple[str, int], int]


def frames(kind: int, start: int, count: int) -> Readings:
    """The frames from one on of a stream or a pass, by arithmetic from its number alone."""
    places = np.arange(start, start + count)
    columns = np.arange(len(RIBBON.columns))
    counts = (places[:, None] * 7919 + columns * 104729 + kind * 15485863) % 40009 - 20004.0
    counts[(places[:, None] + columns) % 997 == 3] = np.nan
    return Readings(places / RIBBON.rate, counts)


def capture(path: Path) -> None:
    """Capture for ever, opening and closing the session now and then; tell what is durable."""
    _say("ready", 0, 0)
    Session.create(path, RIBBON, title="to be killed").close()
    _say("created", 0, 0)
    taken = 0
    for number in range(1_000):
        with Session.open(path) as session:
            stream = session.stream(RIBBON.rate)
            for block in range(ROUND):
                stream.append(frames(stream.part, block * BLOCK, BLOCK))
                _say("stream", stream.part, stream.durable)
                if block % 12 == 5:
                    taken += 1
                    kind = 1_000_000 + taken
                    session.add_pass(f"P{taken}", "pass", frames(kind, 0, PASS))
                    _say("pass", taken, PASS)
                time.sleep(PAUSE)
        _say("closed", number, 0)


def _say(word: str, number: int, count: int) -> None:
    os.write(1, f"{word} {number} {count}\n".encode())


@dataclass(frozen=True)
class Outcome:
    """What one kill left.

    acknowledged: frames; faults: what is not as it must be; recovered: whether
    the session had to be recovered.
    """

    acknowledged: int
    faults: tuple[str, ...]
    recovered: bool


def killed(folder: Path, seed: int, longest: float) -> Outcome:
    """Start a capture, kill it after at most so many seconds, and look at what is left."""
    place = folder / str(seed)
    place.mkdir()
    path = place / "victim.georibbon"
    said = _run(path, random.Random(seed).uniform(0.0, longest))  # noqa: S311 (no secret)
    known: Acknowledged = {}
    for line in said.split("\n")[:-1]:
        word, number, count = line.split(" ")
        known[word, int(number)] = int(count)
    try:
        return _outcome(path, known)
    finally:
        shutil.rmtree(place)


def _run(path: Path, seconds: float) -> str:
    """What a capture said until it was killed, so many seconds after it was ready."""
    program = [sys.executable, str(Path(__file__)), str(path)]
    with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as child:
        first = child.stdout.readline() if child.stdout else ""
        time.sleep(seconds)
        child.send_signal(signal.SIGKILL)
        return first + (child.stdout.read() if child.stdout else "")


def _outcome(path: Path, known: Acknowledged) -> Outcome:
    if not path.exists():
        faults = ("the file is missing",) if ("created", 0) in known else ()
        return Outcome(0, faults, False)
    with Session.open(path) as session:
        faults = ["the lock was not taken over"] if session.read_only else []
        faults += _missing(session, known)
        recovered = session.recovery is not None
    if [file.name for file in path.parent.iterdir()] != [path.name]:
        faults.append("closing left more than one file")
    promised = sum(count for (word, _), count in known.items() if word in ("stream", "pass"))
    return Outcome(promised, tuple(faults), recovered)


def _missing(session: Session, known: Acknowledged) -> list[str]:
    """What was acknowledged and is not there, or is there and is not what was captured."""
    faults = []
    passes = {one.name: one.part for one in session.state.passes}
    faults += [
        f"pass {number} is missing"
        for word, number in known
        if word == "pass" and f"P{number}" not in passes
    ]
    for name, part in passes.items():
        if not _same(session.readings(part), frames(1_000_000 + int(name[1:]), 0, PASS)):
            faults.append(f"pass {name} is not what was captured")
    for entry in session.state.streams:
        promised = known.get(("stream", entry.part), 0)
        faults += _missing_of_stream(session, entry.part, promised)
    return faults


def _missing_of_stream(session: Session, part: int, promised: int) -> list[str]:
    if not session.frames_in(part):
        return [f"stream {part} is empty"] if promised else []
    readings = session.readings(part)
    if readings.t.size < promised:
        return [f"stream {part} has {readings.t.size} of {promised} frames"]
    if not _same(readings, frames(part, 0, readings.t.size)):
        return [f"stream {part} is not what was captured"]
    return []


def _same(one: Readings, other: Readings) -> bool:
    return np.array_equal(one.t, other.t) and np.array_equal(
        one.counts, other.counts, equal_nan=True
    )


if __name__ == "__main__":
    capture(Path(sys.argv[1]))
