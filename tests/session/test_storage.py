"""When the place fails: told in one sentence, held in memory, and written when it can be."""

import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from made import RIBBON, readings, same
from test_stream import frames

from georibbon.errors import SessionError, StorageError
from georibbon.ribbon import Readings
from georibbon.session import database, journal, store
from georibbon.session.events import Event
from georibbon.session.file import read_session
from georibbon.session.lock import lock_file
from georibbon.session.moving import without
from georibbon.session.session import Session
from georibbon.session.telling import tell
from waiting import wait_until


@pytest.fixture
def session(tmp_path, monkeypatch):
    """A session with a pass and 3000 frames of a stream; it is not tried again by itself."""
    monkeypatch.setattr(journal, "RETRY", 3600.0)
    made = Session.create(tmp_path / "s.georibbon", RIBBON)
    made.add_pass("P1", "pass", readings(3000, seed=1))
    stream = made.stream(100.0)
    stream.append(frames(0, 3000))
    assert stream.flush()
    yield made
    made.close(discard=True)


def stream_of(session):
    return session._streams[0]


def names(folder):
    return sorted(file.name for file in folder.iterdir())


def on_writer(session, statement):
    """Run a statement on the writer's connection."""
    session._writer.call(lambda: session._journal._store._database.execute(statement))


def fill_disk(session):
    """Let the database grow no more: SQLite then says that the disk is full."""
    on_writer(session, "PRAGMA max_page_count = 1")


def make_room(session):
    on_writer(session, "PRAGMA max_page_count = 1000000")


def remove(session):
    session.path.unlink()


def rename(session):
    session.path.rename(session.path.with_name("elsewhere"))


def replace(session):
    session.path.unlink()
    session.path.write_text("another one")


def remove_log(session):
    Path(f"{session.path}-wal").unlink()


def remove_folder(session):
    shutil.rmtree(session.path.parent)
    session.path.parent.mkdir()


LONG = 2000 * "held "  # more than what is left of a page
FAILURES = [fill_disk, remove, rename, replace, remove_log, remove_folder]


def refused(session, verb):
    """The sentence of a verb that holds what it was given."""
    with pytest.raises(StorageError) as caught:
        verb()
    told = str(caught.value)
    assert "\n" not in told
    assert told.startswith(session.path.name)
    assert session.held
    assert session.storage_error == told
    return told


@pytest.mark.parametrize("fail", FAILURES)
def test_nothing_accepted_is_lost_when_another_place_is_chosen(session, tmp_path, fail):
    told = []
    session.on_storage(told.append)
    fail(session)
    stream = stream_of(session)
    sentence = refused(session, lambda: session.add_pass("P2", "pass", readings(5000, seed=2)))
    refused(session, lambda: session.do("note", text="held"))
    stream.append(frames(3000, 9000))
    assert not stream.flush()
    assert (stream.frames, stream.durable) == (9000, 3000)
    assert told == [sentence]
    assert [run.name for run in session.state.passes] == ["P1", "P2"]
    assert same(session.readings(3), readings(5000, seed=2))
    other = tmp_path / "other.georibbon"
    session.move_to(other)
    assert told == [sentence, None]
    assert not session.held
    assert session.path == other
    assert stream.durable == 9000
    assert stream.part == 2
    assert same(session.readings(2), frames(0, 9000))
    assert not [warning for warning in session.warnings if "could not be read" in warning]
    stream.append(frames(9000, 9100))
    session.do("note", text="after")
    before = len(session.state.history)
    session.close()
    with Session.open(other) as again:
        assert len(again.state.history) == before + 1
        assert [note.text for note in again.state.notes] == ["held", "after"]
        assert same(again.readings(1), readings(3000, seed=1))
        assert same(again.readings(2), frames(0, 9100))
        assert same(again.readings(3), readings(5000, seed=2))
        assert again.recovery is None
    assert "other.georibbon" in names(tmp_path)
    assert not [name for name in names(tmp_path) if name.endswith((".lock", "-wal", "-shm"))]


def test_where_room_was_made_it_is_written_in_its_order(session, tmp_path):
    fill_disk(session)
    refused(session, lambda: session.add_pass("P2", "pass", readings(5000, seed=2)))
    refused(session, lambda: session.do("title", title="held"))
    refused(session, session.undo)
    stream_of(session).append(frames(3000, 9000))
    refused(session, session.retry)
    assert session.state.title is None
    make_room(session)
    session.retry()
    assert not session.held
    wait_until(lambda: stream_of(session).durable == 9000)
    session.retry()
    session.close()
    assert names(tmp_path) == ["s.georibbon"]
    with Session.open(tmp_path / "s.georibbon") as again:
        assert again.state.redoable == "the title"
        assert same(again.readings(3), readings(5000, seed=2))
        assert same(again.readings(2), frames(0, 9000))


def test_it_is_tried_again_by_itself(tmp_path, monkeypatch):
    monkeypatch.setattr(journal, "RETRY", 0.05)
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        told = []
        session.on_storage(told.append)
        fill_disk(session)
        stream = session.stream(100.0)
        stream.append(frames(0, 3000))
        wait_until(lambda: session.held)
        make_room(session)
        wait_until(lambda: stream.durable == 3000)
        assert not session.held
        assert told[-1] is None
    with Session.open(tmp_path / "s.georibbon", read_only=True) as session:
        assert same(session.readings(1), frames(0, 3000))


def test_a_file_that_comes_back_is_written_to_again(session, tmp_path):
    rename(session)
    refused(session, lambda: session.do("note", text="held"))
    refused(session, session.retry)
    (tmp_path / "elsewhere").rename(session.path)
    session.retry()
    session.close()
    assert names(tmp_path) == ["s.georibbon"]
    with Session.open(tmp_path / "s.georibbon") as again:
        assert [note.text for note in again.state.notes] == ["held"]


def test_what_was_written_to_a_file_just_removed_counts_as_held(session, tmp_path, monkeypatch):
    """The commit succeeds, as the kernel keeps the file; its name is gone."""
    real, path = store.insert, session.path

    def insert(*arguments):
        real(*arguments)
        path.unlink(missing_ok=True)

    monkeypatch.setattr(store, "insert", insert)
    assert "removed or replaced" in refused(session, lambda: session.do("note", text="late"))
    session.move_to(tmp_path / "other.georibbon")
    session.close()
    assert [note["text"] for note in tell(tmp_path / "other.georibbon")["notes"]] == ["late"]


def test_it_may_come_to_the_name_that_it_was_removed_from(session, tmp_path):
    remove_folder(session)
    refused(session, lambda: session.do("note", text="held"))
    session.move_to(session.path)
    assert lock_file(session.path).exists()
    session.close()
    assert names(tmp_path) == ["s.georibbon"]
    assert [note["text"] for note in tell(tmp_path / "s.georibbon")["notes"]] == ["held"]


def test_a_new_place_that_fails_too_changes_nothing(session, tmp_path, monkeypatch):
    fill_disk(session)
    refused(session, lambda: session.do("note", text=LONG))
    (tmp_path / "taken.georibbon").write_text("mine")
    with pytest.raises(SessionError, match="such a file already"):
        session.move_to(tmp_path / "taken.georibbon")
    with pytest.raises(SessionError, match="cannot be written"):
        session.move_to(tmp_path / "none" / "s.georibbon")
    with monkeypatch.context() as patch:
        patch.setattr(database, "PAGE_SIZE", "1; NONSENSE")
        with pytest.raises(StorageError, match="cannot be written"):
            session.move_to(tmp_path / "other.georibbon")
    with monkeypatch.context() as patch:
        patch.setattr(journal, "Store", _no_store)
        with pytest.raises(StorageError, match="no store"):
            session.move_to(tmp_path / "other.georibbon")
    assert session.held
    assert session.path == tmp_path / "s.georibbon"
    assert names(tmp_path) == [
        "s.georibbon", "s.georibbon-shm", "s.georibbon-wal", "s.georibbon.lock",
        "taken.georibbon",
    ]  # fmt: skip
    make_room(session)
    session.retry()
    assert [note["text"] for note in tell(session.path)["notes"]] == [LONG]


def _no_store(_):
    raise StorageError("no store")


def test_a_session_in_order_moves_and_leaves_a_whole_one(session, tmp_path):
    session.do("note", text="before")
    session.move_to(tmp_path / "other.georibbon")
    session.do("note", text="after")
    old = tell(tmp_path / "s.georibbon")
    assert old["recovery"] is None
    assert old["frames"] == 6000
    session.close()
    assert names(tmp_path) == ["other.georibbon", "s.georibbon"]
    assert [note["text"] for note in tell(session.path)["notes"]] == ["before", "after"]


def test_closing_what_is_held_is_refused_until_it_is_meant(session, tmp_path):
    fill_disk(session)
    refused(session, lambda: session.do("note", text=LONG))
    refused(session, session.close)
    session.close(discard=True)
    assert names(tmp_path) == ["s.georibbon"]
    with Session.open(tmp_path / "s.georibbon") as again:
        assert again.state.notes == ()
        assert again.recovery.frames == 6000


def test_leaving_a_block_says_what_could_not_be_written(tmp_path):
    def capture():
        with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
            session.do("note", text="written")
            fill_disk(session)
            stream = session.stream(100.0)
            stream.append(frames(0, 3000))

    with pytest.raises(StorageError, match="the disk is full"):
        capture()
    assert names(tmp_path) == ["s.georibbon"]
    assert [note["text"] for note in tell(tmp_path / "s.georibbon")["notes"]] == ["written"]


def damage(session, part, place):
    """Damage a chunk that is in the file."""
    query = f"UPDATE chunk SET t = zeroblob(length(t)) WHERE part = {part} AND place = {place}"  # noqa: S608 (numbers)
    on_writer(session, query)


def test_what_cannot_be_read_any_more_is_left_out_and_told(tmp_path, monkeypatch):
    monkeypatch.setattr(journal, "MOST_KEPT", 0)
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        for name in ("P1", "P2", "P3"):
            session.add_pass(name, "pass", readings(3000))
        session.do("order", passes=["P3", "P2", "P1"])
        session.do("remove", **{"pass": "P2"})
        session.undo()
        stream = session.stream(100.0)
        stream.append(frames(0, 10_000))
        assert stream.flush()
        damage(session, 2, 1)
        damage(session, 4, 1)
        session.move_to(tmp_path / "other.georibbon")
        told = " ".join(session.warnings)
        assert "the frames of pass P2 could not be read" in told
        assert "1 piece of the frames in stream 4 could not be read" in told
        stream.append(frames(10_000, 10_500))
    with Session.open(tmp_path / "other.georibbon") as again:
        assert [run.name for run in again.state.passes] == ["P3", "P1"]
        left = again.readings(4)
        whole = frames(0, 10_500)
        kept = [i for i in range(10_500) if not 2048 <= i < 4096]
        assert same(left, Readings(whole.t[kept], whole.counts[kept]))


def test_frames_that_were_damaged_are_told_when_they_are_read(session):
    damage(session, 2, 0)
    with pytest.raises(SessionError, match="is damaged"):
        session.readings(2)
    on_writer(session, "DROP TABLE chunk")
    for verb in (session.readings, session.frames_in):
        with pytest.raises(SessionError, match="no such table"):
            verb(2)


def test_what_is_in_memory_needs_no_old_file(session, tmp_path):
    damage(session, 1, 0)
    damage(session, 2, 0)
    session.move_to(tmp_path / "other.georibbon")
    assert [warning for warning in session.warnings if "pass" in warning] == []
    session.close()
    with Session.open(tmp_path / "other.georibbon") as again:
        assert same(again.readings(1), readings(3000, seed=1))
        assert again.readings(2).t.tolist() == frames(2048, 3000).t.tolist()


def test_an_old_file_that_cannot_be_read_at_all(session, tmp_path):
    """Its table is gone: what is in memory is saved, the rest is told."""
    on_writer(session, "DROP TABLE chunk")
    refused(session, lambda: session.add_pass("P2", "pass", readings(50, seed=2)))
    session.move_to(tmp_path / "other.georibbon")
    assert "stream 2" in " ".join(session.warnings)
    session.close()
    with Session.open(tmp_path / "other.georibbon") as again:
        assert [run.name for run in again.state.passes] == ["P1", "P2"]
        assert again.readings(2).t.tolist() == frames(2048, 3000).t.tolist()


def test_a_journal_without_some_parts_still_makes_sense():
    time = "2026-01-02T03:04:05+00:00"
    ribbon = {"id": "R", "length": 1.0, "rate": 9.0, "sensor": [
        {"name": "A", "kind": "accelerometer", "axes": 3, "position": 0, "counts_per_unit": 1},
        {"name": "M", "kind": "magnetometer", "axes": 3, "position": 0, "counts_per_unit": 1},
    ]}  # fmt: skip
    run = {"kind": "pass", "frames": 1}
    actions = [
        ("created", {}), ("ribbon", ribbon),
        ("pass", run | {"name": "P1", "part": 1}), ("undo", {"of": 3}), ("redo", {"of": 3}),
        ("pass", run | {"name": "P2", "part": 2}), ("order", {"passes": ["P2", "P1"]}),
        ("remove", {"pass": "P1"}), ("note", {"text": "x"}), ("undo", {"of": 9}),
    ]  # fmt: skip
    events = [Event(i, time, *one) for i, one in enumerate(actions, start=1)]
    left, state = without(events, frozenset({1}))
    assert [(event.id, event.action) for event in left] == [
        (1, "created"), (2, "ribbon"), (3, "pass"), (4, "order"), (5, "note"), (6, "undo"),
    ]  # fmt: skip
    assert left[-1].detail == {"of": 5}
    assert [one.name for one in state.passes] == ["P2"]


ERRORS = {
    "SQLITE_FULL": "the disk is full",
    "SQLITE_READONLY_DBMOVED": "may not be written",
    "SQLITE_CANTOPEN": "may not be written",
    "SQLITE_BUSY": "another program has locked it",
    "SQLITE_CORRUPT": "damaged",
    "SQLITE_IOERR_WRITE": "cannot be written (disk",
    None: "cannot be written (disk",
}


@pytest.mark.parametrize("name", ERRORS)
def test_every_failure_has_its_sentence_and_its_remedy(name):
    error = sqlite3.OperationalError("disk\nsomething")
    if name:
        error.sqlite_errorname = name
    told = str(database.storage_error(Path("x/s.georibbon"), error))
    assert told.startswith("s.georibbon: ")
    assert ERRORS[name] in told
    assert "\n" not in told
    assert "kept in memory" in told


def test_a_second_writer_that_needs_no_lock_of_ours_is_told(session):
    with closing(sqlite3.connect(session.path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        on_writer(session, "PRAGMA busy_timeout = 10")
        assert "another program has locked it" in refused(
            session, lambda: session.do("note", text="held")
        )
    session.retry()


QUOTA = """
import json, resource, signal, sys
from pathlib import Path
sys.path[:0] = json.loads(sys.argv[1])
from made import RIBBON, readings
from test_stream import frames
from georibbon.errors import StorageError
from georibbon.session.session import Session

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
folder, told = Path(sys.argv[2]), []
session = Session.create(folder / "s.georibbon", RIBBON)
session.on_storage(told.append)
stream = session.stream(100.0)
hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, hard))
for k in range(30):
    stream.append(frames(1000 * k, 1000 * k + 1000))
    stream.flush()
try:
    session.add_pass("P1", "pass", readings(9, seed=1))
except StorageError as error:
    told.append(str(error))
partly = stream.durable
try:
    session.move_to(folder / "small.georibbon")
except StorageError as error:
    told.append(str(error))
if sys.argv[3] == "move":
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    session.move_to(folder / "other.georibbon")
else:
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    session.retry()
session.close()
print(json.dumps([told, partly, stream.durable]))
"""


@pytest.mark.parametrize("way", ["move", "retry"])
def test_a_disk_that_is_really_full(tmp_path, way):
    """A quota on the size of every file of the process, which the kernel enforces."""
    folders = [*Path(__file__).parents[:2], Path(store.__file__).parents[2]]
    paths = json.dumps([str(folder) for folder in folders])
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", QUOTA, paths, str(tmp_path), way],
        capture_output=True, text=True, check=True, timeout=100,
    )  # fmt: skip
    told, partly, durable = json.loads(run.stdout)
    assert run.stderr == ""
    assert 0 < partly < 30_000
    assert durable == 30_000
    assert told[-1] is None
    assert all("cannot be written" in sentence for sentence in told[:-1])
    assert len(told) >= 4
    name = "other.georibbon" if way == "move" else "s.georibbon"
    with Session.open(tmp_path / name) as session:
        assert same(session.readings(1), frames(0, 30_000))
        assert same(session.readings(2), readings(9, seed=1))
        assert session.recovery is None
    assert "small.georibbon" not in names(tmp_path)


@contextlib.contextmanager
def nobody():
    """As a person without rights, also where the tests are run by root."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(user)


@pytest.fixture
def locked():
    """A folder with a session, in which nobody may write."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        Session.create(folder / "s.georibbon", RIBBON).close()
        folder.chmod(0o555)
        yield folder
        folder.chmod(0o755)


def test_a_folder_that_may_not_be_written(locked):
    with nobody():
        with pytest.raises(SessionError, match="cannot be written"):
            Session.create(locked / "t.georibbon", RIBBON)
        with Session.open(locked / "s.georibbon") as session:
            assert session.read_only
            assert "may not be written" in session.warnings[0]
    assert names(locked) == ["s.georibbon"]


def test_a_folder_whose_rights_are_taken_away_meanwhile(locked):
    """What is open stays so: the log and the database are written to as before."""
    locked.chmod(0o755)
    with Session.open(locked / "s.georibbon") as session:
        session.do("note", text="before")
        locked.chmod(0o555)
        with nobody():
            session.do("note", text="after")
        locked.chmod(0o755)
    assert [note["text"] for note in tell(locked / "s.georibbon")["notes"]] == ["before", "after"]


def test_the_complete_recording_comes_through_a_move(session, tmp_path):
    session.add_pass("P2", "pass", readings(seed=4))
    remove(session)
    session.move_to(tmp_path / "other.georibbon")
    expected = session.recording()
    session.close()
    assert same(read_session(tmp_path / "other.georibbon"), expected)
