"""A session: what it accepts is durable, it is opened by one, and closed it is one plain file."""

import os
import shutil
import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from made import RIBBON, readings, recording, same

from georibbon.errors import RecordingError, SessionError, StorageError
from georibbon.ribbon import Readings
from georibbon.session import session as module
from georibbon.session.chunks import Chunk
from georibbon.session.database import insert, pragma
from georibbon.session.events import Event
from georibbon.session.file import create_session, read_session
from georibbon.session.lock import Lock, holder, lock_file
from georibbon.session.session import Session
from georibbon.session.telling import tell

MARK = {"pass": "P1", "at": 0.1, "position": [0.0, 0.0, 1.0], "sigma": 0.001}


@pytest.fixture
def path(tmp_path):
    """Where a session is to be."""
    return tmp_path / "s.georibbon"


def names(path):
    return sorted(file.name for file in path.parent.iterdir())


def left_by_a_crash(path, to):
    """What a killed program leaves of a session that is open now: its files without their lock."""
    for end in ("", "-wal", "-shm"):
        shutil.copyfile(f"{path}{end}", f"{to}{end}")
    return to


def test_a_whole_capture_comes_back(path):
    with Session.create(path, RIBBON, title="by hand") as session:
        for i, pose in enumerate(recording().poses):
            session.add_pose(
                f"pose-{i}", pose.name, pose.roll, pose.heading, pose.pitch, pose.table,
                pose.readings,
            )  # fmt: skip
        for run in recording().passes:
            session.add_pass(run.name, run.kind, run.readings)
        session.do("workpiece", level=True, heading=25)
        position = (0.1, -0.2, 0.3)
        session.do(
            "survey",
            mark=[{"pass": "P1", "at": 0, "position": position, "sigma": 0.0005}],
            distance=[{"passes": ["P1", "P2"], "at": [0, 0.5], "distance": 0.1, "sigma": 0.0005}],
            crossing=[{"passes": ("P2", "T1"), "at": (0.25, 0.05), "sigma": 0.001}],
        )
        assert same(session.recording(), recording())
        assert same(read_session(path), recording())
    assert names(path) == ["s.georibbon"]
    assert same(read_session(path), recording())
    with Session.open(path) as session:
        assert same(session.recording(), recording())
        assert session.recovery is None
        assert not session.read_only


def test_what_is_accepted_is_there_for_others_at_once(path):
    with Session.create(path, RIBBON) as session:
        event = session.do("note", text="here")
        session.add_pass("P1", "pass", readings(3000))
        facts = tell(path)
        assert facts["events"][event.id - 1]["detail"] == {"text": "here"}
        assert [run["frames"] for run in facts["passes"]] == [3000]
        assert str(os.getpid()) in facts["open_in"]


def test_opening_and_closing_alone_changes_nothing(path):
    create_session(path, recording())
    before = tell(path)
    Session.open(path).close()
    assert tell(path) == before


def test_undoing_survives_a_restart(path):
    with Session.create(path, RIBBON) as session:
        session.add_pass("P1", "pass", readings(seed=1))
        session.add_pass("P1", "pass", readings(9, seed=2))
        session.do("title", title="x")
        assert session.undo() == "the title"
    with Session.open(path) as session:
        assert (session.state.undoable, session.state.redoable) == ("pass P1", "the title")
        assert session.undo() == "pass P1"
        (run,) = session.state.passes
        assert same(session.readings(run.part), readings(seed=1))
    with Session.open(path) as session:
        assert session.redo() == "pass P1"
        assert session.redo() == "the title"
        assert session.redo() is None
        assert session.state.title == "x"
        assert [run.frames for run in session.state.passes] == [9]
        assert [session.undo() for _ in range(4)] == ["the title", "pass P1", "pass P1", None]


def test_an_unfinished_session_gives_what_it_has(path):
    with Session.create(path, RIBBON) as session:
        with pytest.raises(SessionError, match="no passes of kind"):
            session.recording()
        session.add_pose("pose-01", "roll 0", 0, 0, 0, True, readings())
        session.do("survey", mark=[MARK, MARK | {"pass": "P9"}], distance=[], crossing=[])
        assert session.pending_survey() == ("P1", "P9")
        found = session.recording(complete=False)
        assert (len(found.poses), found.passes, found.marks) == (1, (), ())
    with pytest.raises(SessionError, match="at least 2 are needed"):
        read_session(path)
    assert same(read_session(path, complete=False), found)


def test_without_a_ribbon(path):
    with Session.create(path) as session:
        for verb in (
            lambda: session.stream(100.0),
            lambda: session.add_pass("P1", "pass", readings()),
            lambda: session.recording(complete=False),
        ):
            with pytest.raises(SessionError, match="ribbon"):
                verb()


BAD = {
    "columns": (Readings(np.zeros(1), np.zeros((1, 7))), "shapes"),
    "no frame": (Readings(np.empty(0), np.empty((0, 8))), "no frame"),
    "times": (Readings(np.zeros(2), np.zeros((2, 8))), "that grow"),
    "counts": (Readings(np.zeros(1), np.full((1, 8), 0.5)), "no whole number"),
}


@pytest.mark.parametrize("name", BAD)
def test_readings_that_are_none_are_refused_and_nothing_is_written(path, name):
    bad, words = BAD[name]
    with Session.create(path, RIBBON) as session:
        with pytest.raises(RecordingError, match=words):
            session.add_pass("P1", "pass", bad)
        with pytest.raises(SessionError, match="kind is"):
            session.add_pass("P1", "jump", readings())
        with pytest.raises(SessionError, match="there is no pass"):
            session.do("remove", **{"pass": "P1"})
        with pytest.raises(SessionError, match="plain numbers and texts"):
            session.do("setting", **{"pass": "*", "key": "x", "value": float("nan")})
        with pytest.raises(ValueError, match="not done by this verb"):
            session.do("pass", name="P1")
        assert session.state.passes == ()
        session.add_pass("P1", "pass", readings())
    assert [event["action"] for event in tell(path)["events"]] == [
        "created", "ribbon", "pass", "closed",
    ]  # fmt: skip


def test_a_closed_session_takes_nothing(path):
    session = Session.create(path, RIBBON)
    stream = session.stream(100.0)
    session.close()
    session.close()
    with pytest.raises(SessionError, match="closed"):
        session.do("note", text="x")
    with pytest.raises(SessionError, match="ended"):
        stream.append(readings())


def test_a_second_one_opens_it_read_only_and_says_who_has_it(path):
    with Session.create(path, RIBBON) as first:
        first.add_pass("P1", "pass", readings())
        with Session.open(path) as second:
            assert second.read_only
            assert f"process {os.getpid()}, since 20" in second.warnings[0]
            assert second.recovery is None
            assert same(second.readings(1), readings())
            assert second.frames_in(1) == 4
            with pytest.raises(SessionError, match=f"process {os.getpid()}"):
                second.do("note", text="x")
        first.do("note", text="still mine")
    with Session.open(path) as third:
        assert not third.read_only
        assert len(third.state.notes) == 1


def test_asked_for_reading_nothing_changes(path):
    create_session(path, recording())
    before = path.read_bytes()
    with Session.open(path, read_only=True) as session:
        assert session.read_only
        assert same(session.recording(), recording())
        assert not session.held
        with pytest.raises(SessionError, match="opened read only"):
            session.undo()
    assert path.read_bytes() == before
    assert names(path) == ["s.georibbon"]


@pytest.mark.parametrize("end", ["", "-shm"])
def test_after_a_crash_it_is_said_what_is_there_and_up_to_when(path, tmp_path, end):
    other = tmp_path / "copy" / "s.georibbon"
    other.parent.mkdir()
    with Session.create(path, RIBBON) as session:
        session.add_pass("P1", "pass", readings())
        stream = session.stream(100.0)
        stream.append(Readings(np.arange(6000) * 3600.0, np.zeros((6000, 8))))
        assert stream.flush()
        session.do("note", text="last")
        left_by_a_crash(path, other)
        last = session.state.history[-1].time
    if end:
        (tmp_path / "copy" / f"s.georibbon{end}").unlink()
    files = {file.name: file.read_bytes() for file in other.parent.iterdir()}
    with Session.open(other, read_only=True) as session:
        told = session.recovery
    assert told.frames == 6004
    assert told.time > last  # the stream's frames go on for long
    assert "6004 frames, 0 poses, 1 pass or tie" in told.message
    assert 'the note "last"' in told.message
    assert tell(other)["recovery"] == told.message
    assert {file.name: file.read_bytes() for file in other.parent.iterdir()} == files
    with Session.open(other) as session:
        assert session.recovery == told
        assert session.state.history[-1].detail == {"to": told.time, "frames": 6004}
    assert names(other) == ["s.georibbon"]
    with Session.open(other) as session:
        assert session.recovery is None


def test_frames_damaged_by_a_crash_are_found_on_opening(path, tmp_path):
    other = tmp_path / "other.georibbon"
    with Session.create(path, RIBBON) as session:
        session.add_pass("P1", "pass", readings(3000))
        left_by_a_crash(path, other)
    with closing(sqlite3.connect(other)) as database, database:
        database.execute("UPDATE chunk SET counts = zeroblob(length(counts)) WHERE place = 1")
    for read_only in (True, False):
        with pytest.raises(SessionError, match=r"damaged.*georibbon check"):
            Session.open(other, read_only=read_only)
    assert holder(other) is None


def test_a_journal_that_was_broken_off_is_finished_in_a_copy(path):
    create_session(path, recording())
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("PRAGMA cache_spill = 1")
        database.execute("PRAGMA cache_size = 1")
        database.execute("BEGIN")
        database.execute("DELETE FROM chunk")
        database.execute("INSERT INTO event VALUES (99, '', '', hex(zeroblob(99999)), x'')")
        files = {file.name: file.read_bytes() for file in path.parent.iterdir()}
    assert "s.georibbon-journal" in files
    for name, body in files.items():
        (path.parent / name).write_bytes(body)
    assert same(read_session(path), recording())
    assert {file.name: file.read_bytes() for file in path.parent.iterdir()} == files
    with Session.open(path) as session:
        assert same(session.recording(), recording())
    assert names(path) == ["s.georibbon"]


@pytest.mark.parametrize("name", ["", "-wal", "-journal"])
def test_nothing_that_is_there_is_overwritten(path, name):
    (path.parent / f"s.georibbon{name}").write_text("mine")
    with pytest.raises(SessionError, match=r"such a file already|was not closed"):
        Session.create(path, RIBBON)
    assert names(path) == [f"s.georibbon{name}"]


def test_a_place_that_is_taken_in_the_last_moment_is_not_overwritten(path, monkeypatch):
    def late(place):
        create_session(place, recording())
        return Lock(place)

    monkeypatch.setattr(module, "Lock", late)
    with pytest.raises(SessionError, match="such a file already"):
        Session.create(path, RIBBON)
    assert names(path) == ["s.georibbon"]
    assert same(read_session(path), recording())


def test_where_nothing_can_be_made(path, tmp_path):
    with pytest.raises(SessionError, match="cannot be written"):
        Session.create(tmp_path / "none" / "s.georibbon")
    with pytest.raises(SessionError, match="20000 characters"):
        Session.create(path, title="x" * 20_000)
    with pytest.raises(SessionError, match="no such file"):
        Session.open(path)
    path.write_text("a text")
    with pytest.raises(SessionError, match="no Georibbon session"):
        Session.open(path)
    assert names(path) == ["s.georibbon"]


def test_a_file_or_folder_that_may_not_be_written_is_opened_read_only(path, monkeypatch):
    create_session(path, recording())
    with monkeypatch.context() as patch:
        patch.setattr(os, "access", lambda *_: False)
        with Session.open(path) as session:
            assert session.read_only
            assert "may not be written" in session.warnings[0]

    def refuse(_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(module, "Lock", refuse)
    with Session.open(path) as session:
        assert session.read_only
        assert "may not be written" in session.warnings[0]
    assert names(path) == ["s.georibbon"]


def test_a_file_that_cannot_be_read_is_told(path, monkeypatch):
    create_session(path, recording())

    def fail(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("georibbon.session.reading.connect", fail)
    with pytest.raises(SessionError, match="Input/output error"):
        Session.open(path)


def test_a_newer_version_is_refused(path):
    create_session(path, recording())
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA user_version = 3")
    with pytest.raises(SessionError, match="newer than 2"):
        Session.open(path)
    assert names(path) == ["s.georibbon"]


def test_a_transaction_waits_for_the_disk(path):
    """Durable when acknowledged: a log that is synced at every commit."""
    with Session.create(path, RIBBON) as session:
        for name, value in (("journal_mode", "wal"), ("synchronous", 2), ("page_size", 4096)):
            assert session._writer.call(
                lambda name=name: pragma(session._journal._store._database, name)
            ) == value  # fmt: skip


def test_callbacks_may_look_at_the_session(path):
    seen = []
    with Session.create(path, RIBBON) as session:
        session.add_pass("P1", "pass", readings())
        session.on_storage(lambda _: seen.append(session.readings(1).t.size))
        path.rename(path.with_name("away"))
        with pytest.raises(StorageError):
            session.do("note", text="held")
        path.with_name("away").rename(path)
        session.retry()
    assert seen == [4, 4]


def test_a_clock_that_makes_no_sense_is_no_fault_after_a_crash(path, tmp_path):
    other = tmp_path / "other.georibbon"
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(Readings(np.array([-1e9, 1e9]), np.zeros((2, 8))))
        session.stream(100.0)
        forged = Event(5, "9999-12-31T00:00:00+00:00", "stream", {"part": 3, "rate": 1.0})
        last = Chunk(3, 0, 2, 2, np.array([-1e9, 1e9]).tobytes(), bytes(32))
        assert stream.flush()
        left_by_a_crash(path, other)
    with closing(sqlite3.connect(other, isolation_level=None)) as database:
        insert(database, [forged], [last])
    with Session.open(other) as session:
        assert session.recovery.frames == 4
        assert session.recovery.time == forged.time


def test_many_threads_may_do_things_at_once(path):
    with Session.create(path, RIBBON) as session:
        threads = [
            threading.Thread(target=lambda k=k: [session.do("note", text=f"{k}") for _ in range(5)])
            for k in range(4)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(session.state.notes) == 20
    with Session.open(path) as session:
        assert len(session.state.notes) == 20
    assert not [thread for thread in threading.enumerate() if thread.name == "session-writer"]


def test_an_error_inside_closes_it_all_the_same(path):
    def fail():
        with Session.create(path, RIBBON) as session:
            session.do("note", text="x")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert names(path) == ["s.georibbon"]
    assert tell(path)["recovery"] is None


def test_a_reader_that_stays_keeps_the_log_and_it_is_said(path, monkeypatch):
    monkeypatch.setattr("georibbon.session.store.WAIT", 0.05)
    session = Session.create(path, RIBBON)
    session.do("note", text="x")
    with closing(sqlite3.connect(path, isolation_level=None)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM event").fetchone()
        session.close()
        assert "another program is reading" in session.warnings[-1]
        assert not lock_file(path).exists()
    with Session.open(path) as session:
        assert session.recovery is None
        assert [note.text for note in session.state.notes] == ["x"]
    assert names(path) == ["s.georibbon"]


def test_a_log_does_not_grow_for_ever_beside_a_long_reader(path, monkeypatch):
    monkeypatch.setattr("georibbon.session.store.LARGEST_LOG", 200_000)
    monkeypatch.setattr("georibbon.session.store.TRY_LOG", 0.0)
    log = path.with_name("s.georibbon-wal")
    with Session.create(path, RIBBON) as session:
        with closing(sqlite3.connect(path, isolation_level=None)) as reader:
            reader.execute("BEGIN")
            reader.execute("SELECT count(*) FROM event").fetchone()
            for i in range(4):
                session.add_pass(f"P{i}", "pass", readings(5000))
            assert log.stat().st_size > 400_000
        session.add_pass("P9", "pass", readings(5000))
        assert log.stat().st_size < 200_000


def test_the_lock_of_a_killed_program_is_taken_over(path):
    create_session(path, recording())
    lock_file(path).write_text('{"process": 1, "since": "2020-01-01"}')
    assert holder(path) is None
    with Session.open(path) as session:
        assert not session.read_only
        assert str(os.getpid()) in holder(path)
    assert names(path) == ["s.georibbon"]


def test_the_name_of_a_lock_that_was_removed_is_not_taken_for_the_lock(path, monkeypatch):
    first = Lock(path)
    real, opened = os.open, []

    def open_late(file, *arguments):
        descriptor = real(file, *arguments)
        if not opened:  # between opening and locking, the first owner gives the lock back
            opened.append(descriptor)
            first.release()
        return descriptor

    monkeypatch.setattr(os, "open", open_late)
    second = Lock(path)
    assert os.path.samestat(lock_file(path).stat(), os.fstat(second._descriptor))
    second.release()
    second.release()
    assert names(path) == []


def test_where_nothing_can_be_locked(path, monkeypatch):
    create_session(path, recording())

    def refuse(_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("georibbon.session.lock._take", refuse)
    with Session.open(path) as session:
        assert session.read_only
        assert "opened read only" in session.warnings[0]
    with pytest.raises(SessionError, match="No locks available"):
        Session.create(path.with_name("t.georibbon"))


def test_a_lock_that_cannot_be_removed_locks_nobody_out(path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", refuse)
        Session.create(path, RIBBON).close()
    assert lock_file(path).exists()
    with Session.open(path) as session:
        assert not session.read_only


def test_a_file_system_without_shared_memory_is_told(path, monkeypatch):
    monkeypatch.setattr("georibbon.session.store.pragma", lambda *_: "delete")
    with pytest.raises(StorageError, match="no shared memory"):
        Session.create(path, RIBBON)
    assert not lock_file(path).exists()


def test_a_database_that_cannot_be_begun_with_is_told(path, monkeypatch):
    def fail(*_):
        raise sqlite3.OperationalError("disk I/O error")

    monkeypatch.setattr("georibbon.session.store.pragma", fail)
    with pytest.raises(StorageError, match="disk I/O error"):
        Session.create(path, RIBBON)
    assert holder(path) is None


@pytest.mark.parametrize("text", ["", "{", "[]", '{"process": "x"}', '{"process": 1}', "9" * 2000])
def test_an_owner_that_is_not_named_is_another_program(path, text):
    lock = Lock(path)
    lock_file(path).write_text(text)
    assert holder(path) == "another program"
    lock.release()
