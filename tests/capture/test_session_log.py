"""Plain logging into a session: frames and link events, whatever happens to the disk."""

import numpy as np
import pytest

from georibbon.capture.session_log import SessionLog
from georibbon.device.frames import LOST, Frame
from georibbon.device.identity import Identity
from georibbon.errors import SessionError, StorageError
from georibbon.ribbon import Ribbon, Sensor
from georibbon.session.session import Session
from georibbon.session.store import Store

IDENTITY = Identity(
    Ribbon(
        "GR-0001", 0.5, 100.0,
        (
            Sensor("A01", "accelerometer", 3, 0.1, 16384.0),
            Sensor("M01", "magnetometer", 2, 0.2, 2000.0),
        ),
    ),
    "1.2.3",
)  # fmt: skip


def frames(count, start=0):
    return [
        Frame(7.25 + i / 100, np.array([i, -i, LOST, 1, 2], dtype=np.int16), 0.0)
        for i in range(start, start + count)
    ]


class Diary:
    """A link diary whose entries the test makes up."""

    def __init__(self):
        self.entries, self.final = [], False

    def take(self, *, last=False):
        self.final = self.final or last
        taken, self.entries = self.entries, []
        return taken


@pytest.fixture
def diary():
    return Diary()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.georibbon"


@pytest.fixture
def log(path, diary):
    made = SessionLog(path, IDENTITY, diary)
    yield made
    made.close()


@pytest.fixture
def disk(monkeypatch):
    """A disk that can be made to fail."""

    class Disk:
        fault = None

    def write(store, *arguments, before=Store.write):
        if Disk.fault is not None:
            raise StorageError(Disk.fault)
        before(store, *arguments)

    monkeypatch.setattr(Store, "write", write)
    return Disk


def held_by(path):
    """The numbers of the frames in a session, and the reasons of its link events."""
    with Session.open(path, read_only=True) as session:
        (stream,) = session.state.streams
        numbers = session.readings(stream.part).counts[:, 0].astype(int).tolist()
        events = [event for event in session.state.history if event.action == "link"]
        return numbers, [event.detail["reason"] for event in events]


def entry(reason):
    return {"state": "streaming", "reason": reason, "frames": 3}


def test_the_session_tells_whose_frames_they_are(log, path):
    log.append(frames(3))
    log.sync()
    with Session.open(path, read_only=True) as session:
        assert session.state.ribbon == IDENTITY.ribbon
        assert session.state.firmware == "1.2.3"
        assert session.state.streams[0].rate == 100.0


def test_after_each_sync_the_frames_and_the_diary_are_in_the_file(log, path, diary):
    for i in range(4):
        log.append(frames(5, 5 * i))
        diary.entries.append(entry(f"news {i}"))
        log.sync()
        assert log.durable == 5 * i + 5
        assert held_by(path) == (list(range(5 * i + 5)), [f"news {j}" for j in range(i + 1)])


def test_the_end_leaves_one_file_with_the_last_news(path, diary, tmp_path):
    log = SessionLog(path, IDENTITY, diary)
    log.append(frames(2))
    diary.entries.append(entry("the end"))
    log.close()
    assert diary.final
    assert held_by(path) == ([0, 1], ["the end"])
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_fails_and_comes_back(log, path, diary, disk):
    log.append(frames(4))
    log.sync()
    disk.fault = "the disk is full"
    for start in (4, 6):
        log.append(frames(2, start))
        diary.entries += [entry(f"one {start}"), entry(f"two {start}")]
        with pytest.raises(StorageError, match="the disk is full"):
            log.sync()
        assert log.durable == 4
    disk.fault = None
    log.sync()
    assert log.durable == 8
    assert held_by(path) == (list(range(8)), ["one 4", "two 4", "one 6", "two 6"])


def test_another_place_gets_everything(log, tmp_path, disk):
    other = tmp_path / "other.georibbon"
    log.append(frames(3))
    log.sync()
    disk.fault = "the disk is full"
    log.append(frames(2, 3))
    with pytest.raises(StorageError):
        log.sync()
    disk.fault = None
    log.move_to(other)
    log.append(frames(1, 5))
    log.sync()
    assert (log.path, log.durable) == (other, 6)
    assert held_by(other)[0] == list(range(6))


@pytest.mark.parametrize("more", [0, 2])
@pytest.mark.parametrize("away", ["removed", "moved", "replaced"])
def test_a_file_that_is_taken_away_is_written_anew(path, diary, tmp_path, away, more):
    log = SessionLog(path, IDENTITY, diary)
    log.append(frames(5))
    log.sync()
    if away == "removed":
        path.unlink()
    else:
        path.rename(tmp_path / "elsewhere")
    if away == "replaced":
        path.write_text("years of work")
        (tmp_path / "run-2.georibbon").write_text("more of it")
    log.append(frames(more, 5))
    with pytest.raises(StorageError, match="removed or replaced"):
        log.sync()
    assert log.durable == 0
    log.sync()
    assert log.durable == 5 + more
    log.append(frames(1, 5 + more))
    log.close()
    assert held_by(log.path)[0] == list(range(6 + more))
    if away == "replaced":
        assert path.read_text() == "years of work"
        assert (tmp_path / "run-2.georibbon").read_text() == "more of it"
        assert log.path.name == "run-3.georibbon"


def test_a_folder_that_is_taken_away(tmp_path, diary):
    folder = tmp_path / "folder"
    folder.mkdir()
    log = SessionLog(folder / "run.georibbon", IDENTITY, diary)
    log.append(frames(5))
    log.sync()
    folder.rename(tmp_path / "elsewhere")
    for _ in range(2):
        with pytest.raises(StorageError):
            log.sync()
        assert log.durable == 0
    folder.mkdir()
    log.sync()
    assert log.durable == 5
    log.close()
    assert held_by(log.path)[0] == list(range(5))


def test_what_cannot_be_written_in_the_end_is_told(path, diary, disk, tmp_path):
    log = SessionLog(path, IDENTITY, diary)
    log.append(frames(3))
    log.sync()
    disk.fault = "the disk is full"
    log.append(frames(3, 3))
    diary.entries.append(entry("the end"))
    with pytest.raises(StorageError, match="the disk is full"):
        log.close()
    disk.fault = None
    with Session.open(path) as session:  # nobody holds it any more
        assert not session.read_only
    assert held_by(path) == ([0, 1, 2], [])
    assert list(tmp_path.iterdir()) == [path]


def test_a_session_that_cannot_begin_leaves_no_lock(path, diary, disk, tmp_path):
    disk.fault = "the disk is full"
    with pytest.raises(StorageError, match="the disk is full"):
        SessionLog(path, IDENTITY, diary)
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_there_is_refused_and_left_alone(path, diary):
    path.write_text("years of work")
    with pytest.raises(SessionError):
        SessionLog(path, IDENTITY, diary)
    assert path.read_text() == "years of work"


def test_warnings_of_the_place_are_told(path, diary, monkeypatch):
    words = ("this folder is on a network",)
    monkeypatch.setattr("georibbon.session.session.place_warnings", lambda _: words)
    log = SessionLog(path, IDENTITY, diary)
    assert log.warnings == words
    log.close()
