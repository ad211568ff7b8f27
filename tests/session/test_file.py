"""The session file: a round trip loses nothing, and damage is never taken for data."""

import functools
import json
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made import RIBBON, readings, recording, recordings, same

from georibbon.errors import RecordingError, SessionError
from georibbon.recording import Pass, Recording
from georibbon.ribbon import Readings
from georibbon.session import chunks, database, reading, restoring
from georibbon.session.database import connect
from georibbon.session.events import Event
from georibbon.session.file import check_place, create_session, read_session
from georibbon.session.folder import read_recording, write_recording
from georibbon.session.schema import TABLES


@pytest.fixture
def session(tmp_path):
    """A session file of the recording made by hand."""
    create_session(tmp_path / "made.georibbon", recording())
    return tmp_path / "made.georibbon"


@functools.cache
def made_bytes():
    """The bytes of that session."""
    with tempfile.TemporaryDirectory() as name:
        create_session(Path(name) / "s.georibbon", recording())
        return (Path(name) / "s.georibbon").read_bytes()


def refused(path):
    """The sentence with which a session is refused."""
    with pytest.raises(SessionError) as caught:
        read_session(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def change(path, *statements):
    """Change a session with SQL, digests as they are."""
    with closing(sqlite3.connect(path)) as opened, opened:
        for statement in statements:
            opened.execute(statement)


def forge(path, action, **changes):
    """Change the detail of the first event of an action, digest and all, as a forger would."""
    with closing(sqlite3.connect(path)) as opened, opened:
        query = "SELECT * FROM event WHERE action = ? ORDER BY id LIMIT 1"
        number, time, _, detail, _ = opened.execute(query, (action,)).fetchone()
        row = Event(number, time, action, json.loads(detail) | changes).row
        opened.execute("REPLACE INTO event VALUES (?, ?, ?, ?, ?)", row)


@given(recordings())
@settings(max_examples=40)
def test_folder_to_session_to_folder_loses_nothing(made):
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        write_recording(made, place / "one")
        create_session(place / "s.georibbon", read_recording(place / "one"))
        write_recording(read_session(place / "s.georibbon"), place / "two")
        assert same(read_recording(place / "two"), made)
        for path in (place / "one").rglob("*.csv"):
            other = place / "two" / path.relative_to(place / "one")
            assert other.read_bytes() == path.read_bytes()


def test_nothing_but_the_session_is_left_and_reading_changes_nothing(session):
    before = session.read_bytes()
    read_session(session)
    assert [p.name for p in session.parent.iterdir()] == ["made.georibbon"]
    assert session.read_bytes() == before


def test_it_is_a_database_with_the_application_id(session):
    head = session.read_bytes()[:100]
    assert head.startswith(b"SQLite format 3\0")
    assert head[68:72] == b"GeoR"
    assert head[60:64] == b"\0\0\0\2"


def long_recording(frames, scale):
    random = np.random.default_rng(5)
    counts = np.rint(random.normal(0.0, scale, (frames, 8)))
    counts[random.random(counts.shape) < 0.01] = np.nan
    runs = [Readings(np.arange(frames) * 0.01, counts), readings()]
    passes = tuple(Pass(f"P{i}", "pass", run) for i, run in enumerate(runs))
    return Recording(RIBBON, (), passes)


@pytest.mark.parametrize("scale", [5000.0, 1e6])
def test_long_passes_are_kept_in_chunks(tmp_path, scale):
    made = long_recording(5000, scale)
    create_session(tmp_path / "s.georibbon", made)
    assert same(read_session(tmp_path / "s.georibbon"), made)
    with closing(sqlite3.connect(tmp_path / "s.georibbon")) as database:
        rows = database.execute("SELECT frames, width FROM chunk WHERE part = 1").fetchall()
    assert [frames for frames, _ in rows] == [2048, 2048, 904]
    assert {width for _, width in rows} == {2 if scale < 1e4 else 4}


@pytest.mark.parametrize(
    ("value", "width"),
    [(32767, 2), (-32767, 2), (32768, 4), (-32768, 4), (2**31 - 1, 4), (-(2**31) + 1, 4)],
)
def test_no_count_is_taken_for_a_lost_value(value, width):
    counts = np.array([[value, np.nan]], dtype=float)
    (chunk,) = chunks.pack(Readings(np.zeros(1), counts), 1)
    assert chunk.width == width
    assert np.array_equal(chunks.unpack([chunk.row], 2).counts, counts, equal_nan=True)


@given(st.data())
@settings(max_examples=200)
def test_flipped_bytes_never_give_wrong_data(data):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "made.georibbon"
        body = bytearray(made_bytes())
        places = st.integers(0, len(body) - 1) | st.integers(0, 120)
        for place in data.draw(st.lists(places, min_size=1, max_size=8)):
            body[place] ^= data.draw(st.integers(1, 255))
        path.write_bytes(body)
        try:
            found = read_session(path)
        except SessionError as error:
            assert "made.georibbon" in str(error)  # noqa: PT017 (refusing is a good end too)
        else:
            assert same(found, recording())
        assert [p.name for p in Path(name).iterdir()] == ["made.georibbon"]


def test_every_truncation_is_refused(session):
    body = session.read_bytes()
    random = np.random.default_rng(3)
    lengths = [0, 1, 15, 16, 99, 100, len(body) - 1, *random.integers(0, len(body), 40)]
    for length in lengths:
        session.write_bytes(body[: int(length)])
        assert "made.georibbon" in refused(session)


CHANGES = {
    "INTEGER": '"{}" + 1000',
    "REAL": '"{}" + 1e-6',
    "TEXT": "\"{}\" || 'x'",
    "BLOB": "zeroblob(9)",
}


def test_every_value_of_every_row_has_its_digest(session):
    with closing(sqlite3.connect(session)) as opened:
        columns = [
            (table, column[1], CHANGES[column[2]])
            for table in TABLES
            for column in opened.execute(f'PRAGMA table_info("{table}")')
        ]
        rows = opened.execute("SELECT count(*) FROM event").fetchone()[0]
    body = session.read_bytes()
    assert len(columns) == 12
    for table, column, other in columns:
        for row in (1, rows if table == "event" else 5):
            session.write_bytes(body)
            values = f'"{column}" = {other.format(column)}'
            change(session, f'UPDATE "{table}" SET {values} WHERE rowid = {row}')  # noqa: S608
            assert "damaged" in refused(session), (table, column)


@pytest.mark.parametrize("table", ["event", "chunk"])
def test_a_row_that_is_gone_is_missed(session, table):
    body = session.read_bytes()
    with closing(sqlite3.connect(session)) as opened:
        rows = opened.execute(f"SELECT count(*) FROM {table}").fetchone()[0]  # noqa: S608
    for row in range(1, rows + (table == "chunk")):  # without its last event it was left by a crash
        session.write_bytes(body)
        change(session, f"DELETE FROM {table} WHERE rowid = {row}")  # noqa: S608
        assert "damaged" in refused(session), row


FORGED = {
    "newer": ("PRAGMA user_version = 7", "version 7, newer than 2"),
    "older": ("PRAGMA user_version = 0", "its version is 0"),
    "negative": ("PRAGMA user_version = -1", "its version is -1"),
    "another program's": ("PRAGMA application_id = 1", "another program's database"),
    "a trigger": (
        "CREATE TRIGGER x AFTER UPDATE ON event BEGIN DELETE FROM event; END",
        "not those of version 2",
    ),
    "a table more": ("CREATE TABLE more (a)", "not those of version 2"),
    "no table": ("DROP TABLE chunk", "not those of version 2"),
    "no event": ("DELETE FROM event", "first event is missing"),
    "frames of nothing": (
        "INSERT INTO chunk VALUES (99, 0, 1, 2, x'', x'', x'')",
        "no event tells of part 99",
    ),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_database_that_is_no_session_is_refused(session, name):
    statement, words = FORGED[name]
    change(session, statement)
    assert words in refused(session)


MARK = {"pass": "P1", "at": 0.1, "position": [0.0, 0.0, 1.0], "sigma": 0.001}
MEANT = {
    "no ribbon's length": ("ribbon", {"length": -1}, "length is -1"),
    "a kind": ("ribbon", {"sensor": [{"name": "A"}]}, "kind is missing"),
    "a title": ("title", {"title": "x" * 20_000}, "20000 characters"),
    "a tilted workpiece": ("workpiece", {"level": False}, "level is false"),
    "a tilted pose": ("pose", {"pitch": 40.0}, "table is true beside"),
    "a pose's table": ("pose", {"table": 1}, "table is 1"),
    "an unknown field": ("pose", {"colour": "red"}, "not known"),
    "infinity": ("pose", {"roll": 1e300}, "at most 1e+09"),
    "a pass's kind": ("pass", {"kind": "x"}, 'kind is "x"'),
    "a part twice": ("pass", {"part": 1}, "used twice"),
    "no part": ("pass", {"part": 0}, "part is 0"),
    "a true part": ("pass", {"part": True}, "part is true"),
    "no such part": ("pass", {"part": 77}, "part 77 has 0 frames"),
    "another length": ("pass", {"frames": 5}, "has 4 frames, not 5"),
    "half a frame": ("pass", {"frames": 4.0}, "frames is 4.0"),
    "a mark too far": ("survey", {"mark": [MARK | {"at": 9.0}]}, "at is 9.0"),
    "sigma": ("survey", {"mark": [MARK | {"sigma": -1}]}, "sigma is -1"),
    "a nameless pass": ("survey", {"mark": [MARK | {"pass": ""}]}, "the name of a pass"),
    "no survey": ("survey", {"mark": 5}, "tables written"),
    "frames at the end": ("closed", {"frames": 7}, "frames are missing"),
}


@pytest.mark.parametrize("name", MEANT)
def test_what_has_a_digest_and_cannot_be_meant_is_refused(session, name):
    action, changes, words = MEANT[name]
    forge(session, action, **changes)
    assert words in refused(session)


def test_entries_of_the_survey_may_wait_for_their_pass(session):
    forge(session, "survey", mark=[MARK, MARK | {"pass": "P9"}])
    assert [mark.pass_name for mark in read_session(session).marks] == ["P1"]


def forge_chunk(path, **values):
    """Give the first chunk other values and the digest that goes with them."""
    with closing(sqlite3.connect(path)) as database, database:
        row = database.execute("SELECT * FROM chunk WHERE rowid = 1").fetchone()
        names = ("part", "place", "frames", "width", "t", "counts")
        chunk = chunks.Chunk(**(dict(zip(names, row[:6], strict=True)) | values))
        database.execute(
            "UPDATE chunk SET part=?, place=?, frames=?, width=?, t=?, counts=?, digest=? "
            "WHERE rowid = 1",
            chunk.row,
        )


FORGED_CHUNKS = {
    "width": ({"width": 3}, "out of order"),
    "place": ({"place": 1}, "out of order"),
    "no frames": ({"frames": 0, "t": b"", "counts": b""}, "has 0 frames, not 4"),
    "many frames": ({"frames": 2**40}, "not 4"),
    "short times": ({"t": b"\0" * 8}, "length"),
    "short counts": ({"counts": b"\0" * 16}, "length"),
    "torn counts": ({"counts": b"\0" * 63}, "length"),
    "times standing": ({"t": b"\0" * 32}, 'pose "roll 0", frame 2, column t: 0.0'),
    "times not finite": ({"t": np.array([0, 1, np.nan, 3]).tobytes()}, "seconds"),
}


@pytest.mark.parametrize("name", FORGED_CHUNKS)
def test_frames_with_a_digest_and_no_sense_are_refused(session, name):
    values, words = FORGED_CHUNKS[name]
    forge_chunk(session, **values)
    assert words in refused(session)


def test_blobs_where_text_belongs_are_refused(session):
    change(
        session,
        "PRAGMA writable_schema = ON",
        "UPDATE sqlite_schema SET sql = replace(sql, ' STRICT', '')",
    )
    change(session, "UPDATE event SET detail = x'00' WHERE id = 2")
    assert "damaged" in refused(session)
    for row in ([(1, 0, 1, 2, "text", b"", b"")], [(1, 0)]):
        with pytest.raises(chunks.DamagedError, match=r"wrong type|values that it should"):
            chunks.unpack(row, 2)


@pytest.mark.parametrize(
    ("module", "name", "value", "words"),
    [
        (reading, "MAX_SESSION", 100, "at most 100 are read"),
        (restoring, "MAX_FRAMES", 100, "at most 100 are read"),
        (database, "MAX_EVENTS", 2, "more than 2 events"),
        (database, "MAX_ROW", 50, "damaged"),
    ],
)
def test_bounds_hold(session, monkeypatch, module, name, value, words):
    monkeypatch.setattr(module, name, value)
    assert words in refused(session)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nothing.georibbon", "no such file"),
        (".", "this is no file"),
        ("n" * 5000, "no such file"),
        ("text.csv", "no Georibbon session"),
    ],
)
def test_what_is_no_session_is_refused(tmp_path, name, words):
    (tmp_path / "text.csv").write_text("t,A01x\n")
    assert words in refused(tmp_path / name)


def test_a_session_that_may_not_be_read_is_told(session, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", fail)
    assert "it cannot be read (Permission denied)" in refused(session)


def test_a_place_that_is_taken_meanwhile_is_told(tmp_path, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(SessionError, match="cannot be written"):
        create_session(tmp_path / "s.georibbon", recording())
    assert not list(tmp_path.iterdir())


def test_a_name_with_the_signs_of_addresses(tmp_path):
    path = tmp_path / "50% #1?mode=rw.georibbon"
    create_session(path, recording())
    assert same(read_session(path), recording())


def test_a_session_being_written_to_is_told(session):
    with closing(sqlite3.connect(session, isolation_level=None)) as database:
        database.execute("BEGIN EXCLUSIVE")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(reading, "connect", lambda uri: connect(uri, timeout=0.0))
            assert "another program is writing" in refused(session)


def test_a_session_is_never_overwritten(session):
    with pytest.raises(SessionError, match="such a file already"):
        create_session(session, long_recording(3, 100.0))
    assert same(read_session(session), recording())


def test_reading_leaves_nothing_beside_a_session_in_wal_mode(session):
    with closing(sqlite3.connect(session)) as database:
        assert database.execute("PRAGMA journal_mode = WAL").fetchone() == ("wal",)
    assert list(session.parent.iterdir()) == [session]
    assert same(read_session(session), recording())
    assert list(session.parent.iterdir()) == [session]


def test_a_foreign_database_in_wal_mode_is_left_as_it_is(tmp_path):
    path = tmp_path / "other.georibbon"
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("CREATE TABLE t (a)")
    assert "another program's" in refused(path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", ["-wal", "-journal"])
def test_the_journal_of_another_is_not_taken_for_ours(tmp_path, ending):
    (tmp_path / f"s.georibbon{ending}").write_bytes(b"x")
    with pytest.raises(SessionError, match="was not closed"):
        create_session(tmp_path / "s.georibbon", recording())


def test_a_log_without_its_index_is_read_and_left_as_it_is(session):
    with closing(sqlite3.connect(session, isolation_level=None)) as opened:
        opened.execute("PRAGMA journal_mode = WAL")
        opened.execute("DELETE FROM event WHERE action = 'closed'")
        log = Path(f"{session}-wal").read_bytes()
        body = session.read_bytes()
    session.write_bytes(body)
    Path(f"{session}-wal").write_bytes(log)
    assert same(read_session(session), recording())
    files = {path.name: path.read_bytes() for path in session.parent.iterdir()}
    assert files == {session.name: body, f"{session.name}-wal": log}


def test_where_it_cannot_be_written(tmp_path, monkeypatch):
    with pytest.raises(SessionError, match="a folder or a device"):
        create_session(tmp_path, recording())
    with pytest.raises(SessionError, match="cannot be written"):
        create_session(tmp_path / "none" / "s.georibbon", recording())
    monkeypatch.setattr(database, "statements", lambda: {"x": "CREATE NONSENSE"})
    with pytest.raises(SessionError, match="the session cannot be written"):
        create_session(tmp_path / "s.georibbon", recording())
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_read_back_is_not_written(tmp_path):
    passes = recording().passes
    with pytest.raises(RecordingError, match="there is no pass"):
        create_session(
            tmp_path / "s.georibbon",
            Recording(RIBBON, (), passes[:2], crossings=recording().crossings),
        )
    half = Pass("P3", "pass", Readings(np.zeros(1), np.full((1, 8), 0.5)))
    with pytest.raises(RecordingError, match="no whole number"):
        create_session(tmp_path / "s.georibbon", Recording(RIBBON, (), (*passes, half)))
    assert not list(tmp_path.iterdir())


def test_a_link_that_leads_nowhere_is_left_alone(tmp_path):
    link = tmp_path / "link.georibbon"
    link.symlink_to(tmp_path / "nothing.georibbon")
    with pytest.raises(SessionError, match="leads nowhere"):
        check_place(link)
    assert link.is_symlink()
