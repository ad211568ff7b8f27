"""What was acknowledged is not lost, and what is another's is not touched: odd files, odd disks."""

import os
import shutil
import sqlite3
import stat
import threading
from contextlib import closing
from pathlib import Path

import journals
import numpy as np
import pytest
from made import RIBBON, readings, recording, same
from old import VERSION_1
from test_stream import frames

from georibbon.errors import SessionError, StorageError
from georibbon.session import database as database_module
from georibbon.session import journal, lock, store
from georibbon.session.chunks import Chunk
from georibbon.session.events import Event
from georibbon.session.file import create_session, read_session
from georibbon.session.lock import Lock, holder, lock_file
from georibbon.session.salvage import check_session, salvage
from georibbon.session.session import Session
from georibbon.session.telling import tell

WAYS = {
    "write": Session.open,
    "read": lambda path: Session.open(path, read_only=True),
    "tell": tell,
    "check": lambda path: _sound(check_session(path)),
}


def _sound(found):
    if not found.ok:
        raise SessionError(found.message)
    return found


@pytest.fixture
def path(tmp_path):
    """Where a session is to be."""
    return tmp_path / "s.georibbon"


def files(folder, but=()):
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.suffix not in but}


def names(folder):
    return sorted(file.name for file in folder.iterdir())


def notes(path):
    return [note["text"] for note in tell(path)["notes"]]


def crashed(path, index=True):
    """Six passes and notes as a killed program leaves them, all in the log; returns where."""
    left = path.parent / "left" / path.name
    left.parent.mkdir()
    with Session.create(path, RIBBON) as session:
        for i in range(6):
            session.add_pass(f"P{i}", "pass", readings(100, seed=i))
            session.do("note", text=f"n{i}")
        for end in ("", "-wal", "-shm") if index else ("", "-wal"):
            shutil.copyfile(f"{path}{end}", f"{left}{end}")
    return left


def flip(file, where):
    """One bit of a file; where: 0 is its first byte, 1 its end."""
    data = bytearray(file.read_bytes())
    data[int(where * len(data))] ^= 1
    file.write_bytes(data)


@pytest.mark.parametrize("index", [True, False])
@pytest.mark.parametrize("where", [0.0, 0.004, 0.2, 0.5, 0.8])
def test_a_log_with_a_fault_is_not_given_up(path, where, index):
    """SQLite reads a log up to its first fault, and removes it: so nobody opens it before."""
    left = crashed(path, index)
    flip(Path(f"{left}-wal"), where)
    before = files(left.parent, but=[".georibbon-shm"])
    for way in WAYS.values():
        with pytest.raises(SessionError, match="is damaged"):
            way(left)
        assert files(left.parent, but=[".georibbon-shm"]) == before
    saved = path.with_name("saved.georibbon")
    salvage(left, saved)
    assert len(tell(saved)["passes"]) >= 5


def test_frames_alone_behind_a_fault_are_not_given_up_either(path):
    left = path.with_name("left.georibbon")
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        empty = "PRAGMA wal_checkpoint(TRUNCATE)"
        session._writer.call(lambda: session._journal._store._database.execute(empty))
        for i in range(6):
            stream.append(frames(100 * i, 100 * i + 100))
            assert stream.flush()
        for end in ("", "-wal"):
            shutil.copyfile(f"{path}{end}", f"{left}{end}")
    flip(Path(f"{left}-wal"), 0.4)
    for way in WAYS.values():
        with pytest.raises(SessionError, match=r"lose 0 events and [1-6] pieces? of frames"):
            way(left)


@pytest.mark.parametrize("index", [True, False])
def test_a_transaction_that_was_not_promised_is_no_fault_of_the_log(path, index):
    """A frame without the end of its transaction, and half a frame, as a kill leaves them."""
    left = crashed(path, index)
    log = Path(f"{left}-wal")
    data = log.read_bytes()
    last = bytearray(data[-4120:])
    last[4:8] = bytes(4)  # it ends no transaction
    log.write_bytes(data + last + last[:2000])
    assert "sound" in tell(left)["recovery"]
    with Session.open(left) as session:
        assert "sound" in session.recovery.message
        assert len(session.state.passes) == 6


def test_a_log_of_another_session_is_not_taken_for_ones_own(path):
    other = crashed(path)
    with Session.create(path.with_name("t.georibbon"), RIBBON) as session:
        for i in range(8):
            session.add_pass(f"Q{i}", "pass", readings(100, seed=i))
    shutil.copyfile(f"{other}-wal", path.with_name("t.georibbon-wal"))
    for way in WAYS.values():
        with pytest.raises(SessionError, match="is damaged"):
            way(path.with_name("t.georibbon"))


@pytest.mark.parametrize("t", [[0.0, np.nan], [-np.inf, np.inf], [1e300, -1e300], [1.0, 1.0]])
def test_times_that_make_no_sense_are_told_alike_by_all(path, t):
    """With the right digest, and not closed: as anybody may have made it."""
    counts = np.zeros((2, len(RIBBON.columns)), "<i2").tobytes()
    made = journals.Capture()
    made.do("created", georibbon="2.0")
    made.do("ribbon", **journals.RIBBON_TABLE)
    made.do("stream", part=1, rate=100.0)
    chunk = Chunk(1, 0, 2, 2, np.array(t, "<f8").tobytes(), counts)
    journals.write(path, made.events, [chunk])
    for way in WAYS.values():
        with pytest.raises(SessionError, match="do not grow"):
            way(path)


def test_a_log_that_is_not_there_is_told(path):
    left = crashed(path)
    for end in ("-wal", "-shm"):
        Path(f"{left}{end}").unlink()
    told = "s.georibbon-wal is not beside it"
    assert told in check_session(left).message
    assert told in tell(left)["recovery"]
    for read_only in (True, False):
        with Session.open(left, read_only=read_only) as session:
            assert told in " ".join(session.warnings)
    create_session(path.with_name("t.georibbon"), recording())
    assert tell(path.with_name("t.georibbon"))["recovery"] is None
    assert check_session(path.with_name("t.georibbon")).message.endswith("in order")


def test_a_file_that_is_left_is_closed_as_it_is(path):
    """What waits when the session moves is in the new file alone; the old one is sound."""
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 500))
        assert stream.flush()
        stream._poke = lambda *_: None  # from here on nothing but the move writes
        stream.append(frames(500, 600))
        session.move_to(path.with_name("t.georibbon"))
        assert "closed" not in [event.action for event in session.state.history]
        stream._poke = session._writer.poke
        stream.append(frames(600, 700))
    assert check_session(path).verdict == "fine"
    assert check_session(path).frames == 500
    assert check_session(path.with_name("t.georibbon")).frames == 700


@pytest.mark.parametrize("name", ["none/t.georibbon", f"{'x' * 240}.georibbon"])
def test_a_move_that_fails_leaves_no_trace(path, name):
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 50))
        assert stream.flush()
        with pytest.raises(SessionError):
            session.move_to(path.parent / name)
        stream.append(frames(50, 100))
        assert stream.flush()
        assert tell(path)["events"][-1]["action"] == "stream"


def test_a_stream_at_a_full_chunk_goes_on_in_the_new_file(path, monkeypatch):
    monkeypatch.setattr(journal, "MOST_KEPT", 0)
    new = path.with_name("t.georibbon")
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 4096))
        assert stream.flush()
        spoil = "UPDATE chunk SET t = zeroblob(length(t)) WHERE place = 0"
        session._writer.call(lambda: session._journal._store._database.execute(spoil))
        session.move_to(new)
        stream.append(frames(4096, 4196))
    assert check_session(new).verdict == "fine"
    with Session.open(new, read_only=True) as session:
        assert same(session.readings(1), frames(2048, 4196))


def test_the_chunks_of_an_earlier_stream_are_moved_as_far_as_they_go(path):
    """It does not grow any more; a part of it cannot be read."""
    new = path.with_name("t.georibbon")
    with Session.create(path, RIBBON) as session:
        session.stream(100.0).append(frames(0, 5000))
    with Session.open(path) as session:
        session.do("note", text="x")
        spoil = "UPDATE chunk SET t = zeroblob(length(t)) WHERE place = 1"
        session._writer.call(lambda: session._journal._store._database.execute(spoil))
        session.move_to(new)
        assert "1 piece of the frames in stream 1" in " ".join(session.warnings)
        assert session.frames_in(1) == 5000 - 2048
    assert check_session(new).verdict == "fine"


def test_what_a_link_named_as_the_lock_leads_to_stays(path):
    create_session(path, recording())
    thesis = path.with_name("thesis")
    thesis.write_text("mine")
    lock_file(path).symlink_to(thesis)
    with Session.open(path) as session:
        assert session.read_only
        assert "s.georibbon.lock beside it cannot be used" in session.warnings[0]
        assert "remove it if no program" in session.warnings[0]
    assert thesis.read_text() == "mine"
    assert holder(path) is None
    path.unlink()
    with pytest.raises(SessionError, match=r"s\.georibbon\.lock beside it cannot be used"):
        Session.create(path, RIBBON)
    assert names(path.parent) == ["s.georibbon.lock", "thesis"]


def _linked(file):
    file.write_text("")
    file.with_name("other").hardlink_to(file)


NO_LOCKS = {
    "a text": lambda file: file.write_text("my notes"),
    "a long text": lambda file: file.write_text('{"process"' + 2000 * "x"),
    "a folder": Path.mkdir,
    "a pipe": os.mkfifo,
    "a second name": _linked,
}


@pytest.mark.parametrize("kind", NO_LOCKS)
def test_what_is_no_lock_file_is_left_alone_and_named(path, kind):
    create_session(path, recording())
    NO_LOCKS[kind](lock_file(path))
    text = lock_file(path).read_bytes() if kind.endswith("text") else None
    with Session.open(path) as session:
        assert session.read_only
        assert "s.georibbon.lock beside it" in session.warnings[0]
    assert lock_file(path).exists()
    assert text is None or lock_file(path).read_bytes() == text


@pytest.mark.parametrize("text", [b"", bytes(60), b'{"process": 1, "since": "2020-01-01"}'])
def test_the_lock_file_of_a_crash_is_taken_over(path, text):
    lock_file(path).write_bytes(text)
    taken = Lock(path)
    assert str(os.getpid()) in holder(path)
    assert lock_file(path).read_bytes().startswith(b'{"process"')
    taken.release()
    assert names(path.parent) == []


def test_a_lock_of_another_user_is_seen(path, monkeypatch):
    """It may be read and not be written: so it is looked at for reading."""
    real, asked = os.open, []

    def open_for_reading_alone(file, flags, *arguments, **named):
        if str(file).endswith(".lock") and flags & os.O_RDWR:
            asked.append(file)
            raise PermissionError(13, "Permission denied")
        return real(file, flags, *arguments, **named)

    held = Lock(path)
    with monkeypatch.context() as patch:
        patch.setattr(lock.os, "open", open_for_reading_alone)
        assert str(os.getpid()) in holder(path)
        create_session(path, recording())
        with Session.open(path) as session:  # it must not be told to remove that lock
            assert f"process {os.getpid()}" in session.warnings[0]
            assert "remove" not in session.warnings[0]
    held.release()
    lock_file(path).write_text("")
    with monkeypatch.context() as patch:
        patch.setattr(lock.os, "open", open_for_reading_alone)
        assert holder(path) is None
    assert asked

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(lock.os, "open", refuse)
    assert "s.georibbon.lock" in holder(path)


def test_a_file_with_two_names_has_no_writer(path):
    """Each name has a lock of its own, and the log of one is not that of the other."""
    create_session(path, recording())
    other = path.with_name("t.georibbon")
    other.hardlink_to(path)
    for name in (path, other):
        with Session.open(name) as session:
            assert session.read_only
            assert "a second name" in session.warnings[0]
            assert same(session.recording(), recording())
    other.unlink()
    with Session.open(path) as session:
        assert not session.read_only


def test_an_old_session_with_two_names_becomes_a_file_of_its_own(path):
    shutil.copyfile(VERSION_1, path)
    other = path.with_name("t.georibbon")
    other.hardlink_to(path)
    with Session.open(path) as session:
        assert not session.read_only
    assert other.read_bytes() == VERSION_1.read_bytes()


def test_an_event_is_never_replaced(path):
    with Session.create(path, RIBBON) as session:
        session.do("note", text="first")
        number = len(session.state.history) + 1
        foreign = Event(number, journals.TIME, "note", {"text": "foreign"})
        with closing(sqlite3.connect(path)) as database, database:
            database.execute("INSERT INTO event VALUES (?, ?, ?, ?, ?)", foreign.row)
        with pytest.raises(StorageError, match="another program has written"):
            session.do("note", text="second")
        assert notes(path) == ["first", "foreign"]
        session.move_to(path.with_name("t.georibbon"))
    assert notes(path) == ["first", "foreign"]
    assert notes(path.with_name("t.georibbon")) == ["first", "second"]


def test_the_same_event_twice_is_there_once(path):
    create_session(path, recording())
    with closing(sqlite3.connect(path)) as database, database:
        before = database.execute("SELECT * FROM event").fetchall()
        event = Event(len(before) + 1, journals.TIME, "note", {"text": "x"})
        database_module.insert(database, [event, event], ())
        database_module.insert(database, [event], ())
        assert database.execute("SELECT * FROM event").fetchall() == [*before, event.row]


def test_a_migrated_session_keeps_its_rights(path):
    shutil.copyfile(VERSION_1, path)
    path.chmod(0o600)
    with Session.open(path) as session:
        assert not session.read_only
    assert {stat.S_IMODE(file.stat().st_mode) for file in path.parent.iterdir()} == {0o600}
    assert len(names(path.parent)) == 2


def test_a_copy_of_an_old_session_keeps_its_rights_too(path, monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    shutil.copyfile(VERSION_1, path)
    path.chmod(0o600)
    monkeypatch.setattr(Path, "hardlink_to", refuse)
    monkeypatch.setattr(os, "chown", refuse)
    with Session.open(path) as session:
        assert not session.read_only
    assert {stat.S_IMODE(file.stat().st_mode) for file in path.parent.iterdir()} == {0o600}


def test_a_session_renamed_while_it_is_open_gets_what_is_in_its_log(path):
    new = path.with_name("r.georibbon")
    session = Session.create(path, RIBBON)
    session.add_pass("P1", "pass", readings(9))
    path.rename(new)
    with pytest.raises(StorageError):
        session.close()
    session.close(discard=True)
    assert names(path.parent) == ["r.georibbon"]
    assert "removed or replaced" in " ".join(session.warnings)
    with Session.open(new) as again:
        assert same(again.readings(1), readings(9))


class Full(sqlite3.OperationalError):
    """What SQLite says where there is no room for the index of a log."""

    sqlite_errorname = "SQLITE_IOERR_SHMSIZE"


def test_a_full_disk_is_told_as_one_wherever_it_is_met(path, monkeypatch):
    def fail(*_):
        raise Full("disk I/O error")

    usage = shutil._ntuple_diskusage(2**20, 2**20, 4096)
    monkeypatch.setattr(database_module.shutil, "disk_usage", lambda _: usage)
    with monkeypatch.context() as patch:
        patch.setattr(store, "pragma", fail)
        with pytest.raises(StorageError, match="the disk is full") as caught:
            Session.create(path, RIBBON)
        assert "in memory" not in str(caught.value)  # it was not opened
    assert names(path.parent) == []
    before = threading.enumerate()
    with pytest.raises(StorageError, match="the disk is full"), Session.create(path, RIBBON):
        monkeypatch.setattr(store, "read_sizes", fail)
    assert threading.enumerate() == before
    assert names(path.parent) == ["s.georibbon"]


def test_why_a_session_is_no_plain_file_is_told(path, monkeypatch):
    def fail(*_):
        raise Full("disk I/O error")

    def unknown(_):
        raise FileNotFoundError(2, "No such file or directory")

    monkeypatch.setattr(store, "WAIT", 0.0)
    monkeypatch.setattr(database_module.shutil, "disk_usage", unknown)
    session = Session.create(path, RIBBON)
    monkeypatch.setattr(store, "pragma", fail)
    session.close()
    assert "cannot be written (disk I/O error)" in session.warnings[-1]
    assert "another program" not in session.warnings[-1]


def test_a_closed_session_is_told_as_closed(path):
    session = Session.create(path, RIBBON)
    session.add_pass("P1", "pass", readings(9))
    journal_left = session._journal
    session.close()
    for ask in (lambda: session.frames_in(1), lambda: session.readings(2), session.retry):
        with pytest.raises(SessionError, match="is closed"):
            ask()
    with pytest.raises(SessionError, match="closed meanwhile"):  # between its last two steps
        journal_left.sizes()


def test_who_is_told_of_the_disk_and_fails_stops_nothing(path, monkeypatch):
    told = []
    monkeypatch.setattr(threading, "excepthook", told.append)
    session = Session.create(path, RIBBON)
    session.on_storage(lambda _: 1 / 0)
    path.unlink()
    with pytest.raises(StorageError, match="removed or replaced"):
        session.do("note", text="x")
    assert session.held
    assert told[0].exc_type is ZeroDivisionError
    session.move_to(path.with_name("t.georibbon"))
    session.close()
    assert notes(path.with_name("t.georibbon")) == ["x"]


def test_a_move_to_the_same_name_keeps_its_lock_where_that_fails(path):
    folder = path.parent / "f"
    folder.mkdir()
    path = folder / "s.georibbon"
    session = Session.create(path, RIBBON)
    shutil.rmtree(folder)
    with pytest.raises(SessionError):
        session.move_to(path)
    folder.mkdir()
    other = Session.create(path, RIBBON)
    with pytest.raises(SessionError):
        session.move_to(path)
    assert str(os.getpid()) in holder(path)
    other.close()
    session.move_to(folder / "t.georibbon")
    assert holder(folder / "t.georibbon")
    session.close()
    assert names(folder) == ["s.georibbon", "t.georibbon"]


def test_a_session_that_moves_to_its_own_name_never_lets_it_go(path):
    session = Session.create(path, RIBBON)
    session.do("note", text="x")
    for end in ("", "-wal", "-shm"):
        Path(f"{path}{end}").unlink()
    mine = session._journal.lock
    session.move_to(path)
    assert session._journal.lock is mine
    session.close()
    assert names(path.parent) == ["s.georibbon"]
    assert same(read_session(path, complete=False), session.recording(complete=False))
