"""What becomes of a session file whose bytes are damaged: opened, salvaged or refused.

A session of 16 poses, 6 passes (one redone), a survey, notes and a stream of
frames between them, of 32 sensors, is damaged from a seed in many ways; each
time it is checked and, if damaged, salvaged.  Whatever can be opened then is
compared, bit for bit, with what was captured: every pose and pass must be one
that was captured under its name, every event of the journal one that was
written or one that stands in its place and is told.

    .venv/bin/python benchmarks/damage.py [--times N] [--seed N]
"""

import argparse
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from support.tables import met, publish, table

from georibbon.errors import GeoribbonError
from georibbon.ribbon import Readings, Ribbon, Sensor
from georibbon.session.carving import carved
from georibbon.session.salvage import check_session, salvage
from georibbon.session.schema import PAGE_SIZE
from georibbon.session.session import Session

POSES, PASSES = 16, 6
STANDING = ("created", "recovered", "note", "remove", "ribbon")  # in the place of one that is lost
ADDED = ("stream", "note", "closed")  # by salvaging, at the end


def main() -> None:
    """Damage, salvage, compare, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--times", type=int, default=200, help="of each kind of flipped bytes")
    parser.add_argument("--seed", type=int, default=1, help="of the damages")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = capture(Path(folder))
        chance = np.random.default_rng(asked.seed)
        trials = [
            trial(made, kind, bodies) for kind, bodies in damages(made, chance, asked.times).items()
        ]
        speed = carving_speed(made)
    report(made, trials, speed)


@dataclass(frozen=True)
class Made:
    """The session: closed, and as a crash left it; what was captured, and every event."""

    path: Path
    closed: bytes
    crashed: bytes
    log: bytes
    parts: dict[int, Readings]
    titles: set[tuple[str, str, int]]
    events: dict[int, tuple[object, ...]]


@dataclass
class Trial:
    """What became of a kind of damage."""

    kind: str
    ends: Counter[str] = field(default_factory=Counter)
    passes: int = 0
    poses: int = 0
    wrong: int = 0
    faults: int = 0


def ribbon() -> Ribbon:
    """A ribbon of 16 accelerometers and 16 magnetometers."""
    sensors = [
        Sensor(f"{kind[0].upper()}{i:02}", kind, 3, (i + 0.5) / 32, counts)
        for kind, counts in (("accelerometer", 16384.0), ("magnetometer", 2000.0))
        for i in range(16)
    ]
    return Ribbon("GR-0001", 0.5, 100.0, tuple(sensors))


def frames(count: int, start: float, chance: np.random.Generator) -> Readings:
    """Frames of noise."""
    counts = np.rint(chance.normal(0.0, 4000.0, (count, 96))).clip(-32000, 32000)
    return Readings(start + np.arange(count) / 100.0, counts)


def capture(folder: Path) -> Made:
    """Capture the session; a copy is taken just before it is closed."""
    path, chance = folder / "s.georibbon", np.random.default_rng(0)
    with Session.create(path, ribbon(), title="damage") as session:
        stream = session.stream(100.0)
        clock = 0.0
        for i in range(POSES + PASSES + 1):
            for _ in range(10):
                stream.append(frames(10, clock, chance))
                stream.flush()
                clock += 0.1
            if i < POSES:
                roll = 22.5 * i
                readings = frames(50, 0.0, chance)
                session.add_pose(f"pose-{i}", f"roll {roll:g}", roll, 0.0, 0.0, True, readings)
            else:
                name = f"P{(i - POSES) % PASSES + 1}"
                session.add_pass(name, "pass", frames(2100 if name == "P3" else 120, 0.0, chance))
                session.do("note", text=f"{name} lies well")
        mark = {"pass": "P1", "at": 0.1, "position": [0.0, 0.1, 0.2], "sigma": 0.001}
        session.do("survey", mark=[mark], distance=[], crossing=[])
        crashed, log = path.read_bytes(), Path(f"{path}-wal").read_bytes()
    with Session.open(path, read_only=True) as session:
        history = session.state.history
        titles = {
            (e.action, str(e.detail.get("key", e.detail["name"])), int(str(e.detail["part"])))
            for e in history
            if e.action in ("pose", "pass")
        }
        streams = {stream.part for stream in session.state.streams}
        numbers = {part for _, _, part in titles} | streams
        parts = {part: session.readings(part) for part in numbers}
    events = {event.id: event.row for event in history}
    return Made(path, path.read_bytes(), crashed, log, parts, titles, events)


Bodies = Iterator[tuple[bytes, bytes]]


def damages(made: Made, chance: np.random.Generator, times: int) -> dict[str, Bodies]:
    """For each kind of damage the files, with their logs, that it leaves."""
    pages = len(made.closed) // PAGE_SIZE
    some = sorted({*range(12), *map(int, chance.integers(0, pages, times // 2))})
    quarter = max(times // 4, 1)
    return {
        "one byte flipped": ((flipped(made.closed, 1, chance), b"") for _ in range(times)),
        "20 bytes flipped": ((flipped(made.closed, 20, chance), b"") for _ in range(times)),
        "200 bytes flipped": ((flipped(made.closed, 200, chance), b"") for _ in range(quarter)),
        "cut off": ((cut(made.closed, chance), b"") for _ in range(quarter)),
        "a page zeroed": ((zeroed(made.closed, page), b"") for page in some),
        "the header page zeroed": ((zeroed(made.closed, page), b"") for page in (0,)),
        "after a crash, a byte of the log": (
            (made.crashed, flipped(made.log, 1, chance)) for _ in range(quarter)
        ),
        "after a crash, the log cut off": (
            (made.crashed, cut(made.log, chance)) for _ in range(quarter)
        ),
    }


def flipped(body: bytes, count: int, chance: np.random.Generator) -> bytes:
    """Bytes with some of them changed."""
    changed = bytearray(body)
    for place in chance.choice(len(body), count, replace=False):
        changed[place] ^= int(chance.integers(1, 256))
    return bytes(changed)


def cut(body: bytes, chance: np.random.Generator) -> bytes:
    """Bytes cut off somewhere."""
    return body[: int(chance.integers(len(body)))]


def zeroed(body: bytes, page: int) -> bytes:
    """Bytes with a page zeroed."""
    return body[: page * PAGE_SIZE] + bytes(PAGE_SIZE) + body[(page + 1) * PAGE_SIZE :]


def trial(made: Made, kind: str, bodies: Iterable[tuple[bytes, bytes]]) -> Trial:
    """Check and salvage each of the damaged files."""
    result = Trial(kind)
    for body, log in bodies:
        folder = Path(tempfile.mkdtemp(dir=made.path.parent))
        path = folder / "s.georibbon"
        path.write_bytes(body)
        if log:
            Path(f"{path}-wal").write_bytes(log)
        try:
            judge(made, result, path)
        except GeoribbonError:
            result.ends["refused"] += 1
        except Exception as error:
            print(f"{kind}: {error!r}")
            result.faults += 1
        shutil.rmtree(folder)
    return result


def judge(made: Made, result: Trial, path: Path) -> None:
    """What became of one damaged file."""
    found = check_session(path)
    target = path
    if not found.ok:
        target = path.with_name("saved.georibbon")
        salvage(path, target)
    with carved(path) as carving:
        last = max((event.id for event in carving.events), default=0)
    with Session.open(target, read_only=True) as session:
        state = session.state
        held = {("pose", one.key, one.part) for one in state.poses}
        held |= {("pass", one.name, one.part) for one in state.passes}
        right = held <= made.titles
        for _, _, part in held:
            right = right and same(session.readings(part), made.parts[part])
        for event in state.history:
            written = event.row == made.events.get(event.id)
            stands = bool(found.lost) and event.action in STANDING
            added = not found.ok and event.id > last and event.action in ADDED
            right = right and (written or stands or added)
    result.ends["opened" if found.ok else "salvaged"] += 1
    result.passes += len(state.passes)
    result.poses += len(state.poses)
    result.wrong += not right


def same(one: Readings, other: Readings) -> bool:
    """Whether they are the same to the last bit."""
    return np.array_equal(one.t, other.t) and np.array_equal(
        one.counts, other.counts, equal_nan=True
    )


def carving_speed(made: Made) -> float:
    """Megabytes of the undamaged session searched in a second."""
    start = time.perf_counter()
    with carved(made.path) as found:
        if not found.whole:
            raise RuntimeError("the undamaged session was not searched wholly")
    return len(made.closed) / 1e6 / (time.perf_counter() - start)


def report(made: Made, trials: list[Trial], speed: float) -> None:
    """Print the tables."""
    rows = []
    for one in trials:
        count = sum(one.ends.values()) + one.faults
        kept = max(one.ends["opened"] + one.ends["salvaged"], 1)
        rows.append(
            [
                one.kind,
                str(count),
                *(str(one.ends[end]) for end in ("opened", "salvaged", "refused")),
                *(f"{number / kept:.2f}" for number in (one.passes, one.poses)),
                *(str(number) for number in (one.wrong, one.faults)),
                met(one.wrong == one.faults == 0),
            ]
        )
    header = ("damage", "times", "opened", "salvaged", "refused", f"passes of {PASSES}")
    header += (f"poses of {POSES}", "wrong data (asked: 0)", "crashes (asked: 0)", "verdict")
    head = (
        f"A session of {len(made.closed) / 1e6:.1f} MB; the means of passes and poses are over "
        f"the files that were opened or salvaged. Searched at {speed:.0f} MB/s."
    )
    publish("damage", [head, table(header, rows)])


if __name__ == "__main__":
    main()
