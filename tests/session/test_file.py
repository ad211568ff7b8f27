"""The session file: a round trip loses nothing, and damage is never taken for data."""

import functools
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
from georibbon.session import chunks, file
from georibbon.session.file import create_session, read_session
from georibbon.session.folder import read_recording, write_recording
from georibbon.session.version1 import TABLES


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


def change(path, *statements, seal=True):
    """Change a session with SQL, and renew its seals as an able forger would."""
    with closing(sqlite3.connect(path)) as database, database:
        for statement in statements:
            database.execute(statement)
        for name in TABLES if seal else ():
            seals = (file._digest(file._select(database, name)), name)
            database.execute("UPDATE seal SET digest = ? WHERE name = ?", seals)


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
    assert head[60:64] == b"\0\0\0\1"


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


def test_every_value_of_every_row_is_sealed(session):
    with closing(sqlite3.connect(session)) as database:
        filled = [
            (table, column[1], CHANGES[column[2]])
            for table in (*TABLES, "chunk")
            if database.execute(f'SELECT count(*) FROM "{table}"').fetchone()[0]  # noqa: S608
            for column in database.execute(f'PRAGMA table_info("{table}")')
        ]
    body = session.read_bytes()
    assert len(filled) > 50
    for table, column, other in filled:
        session.write_bytes(body)
        values = f'"{column}" = {other.format(column)}'
        change(session, f'UPDATE "{table}" SET {values}', seal=False)  # noqa: S608
        assert "damaged" in refused(session), (table, column)


@pytest.mark.parametrize("table", ["mark", "pose", "chunk", "part", "seal", "sensor"])
def test_a_row_that_is_gone_is_missed(session, table):
    change(session, f'DELETE FROM "{table}" WHERE rowid = 1', seal=False)  # noqa: S608
    change(session, f'DELETE FROM "{table}" WHERE rowid = 0', seal=False)  # noqa: S608
    assert "damaged" in refused(session)


FORGED = {
    "newer": (["PRAGMA user_version = 7"], "version 7, newer than 1"),
    "older": (["PRAGMA user_version = 0"], "its version is 0"),
    "another program's": (["PRAGMA application_id = 1"], "another program's database"),
    "a trigger": (
        ["CREATE TRIGGER x AFTER UPDATE ON mark BEGIN DELETE FROM mark; END"],
        "not those of version 1",
    ),
    "a view": (["DROP TABLE note", "CREATE VIEW note AS SELECT 1"], "not those of version 1"),
    "no table": (["DROP TABLE chunk"], "not those of version 1"),
    "no ribbon": (["DELETE FROM ribbon"], "[ribbon] is missing"),
    "one pass": (["DELETE FROM pass WHERE place = 1"], "1 pass of kind"),
    "a mark nowhere": (["UPDATE mark SET pass = 'P9'"], "[[mark]] number 1"),
    "sigma": (["UPDATE mark SET sigma = -1"], "sigma is -1.0"),
    "infinity": (["UPDATE mark SET x = 9e999"], "position is inf"),
    "a tilted workpiece": (["UPDATE workpiece SET level = 0"], "level is false"),
    "a table of 2": (["UPDATE pose SET on_table = 2"], "table is 2"),
    "an unknown kind": (["UPDATE sensor SET kind = 'x' WHERE place = 0"], 'kind is "x"'),
    "a part twice": (["UPDATE pass SET part = 1"], "named twice"),
    "no such part": (["UPDATE pass SET part = 77 WHERE place = 0"], "has no frames"),
    "another length": (["UPDATE part SET frames = 5"], "frames, not as it should"),
    "a title without end": (
        ["UPDATE meta SET value = hex(zeroblob(20000)) WHERE key = 'title'"], "40000 characters",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FORGED)
def test_what_is_sealed_and_cannot_be_meant_is_refused(session, name):
    statements, words = FORGED[name]
    change(session, *statements, seal=name not in ("a view", "no table"))
    assert words in refused(session)


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
    "no frames": ({"frames": 0, "t": b"", "counts": b""}, "out of order"),
    "many frames": ({"frames": 2**40}, "length"),
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
    with closing(sqlite3.connect(session)) as database, database:
        database.execute("PRAGMA writable_schema = ON")
        database.execute("UPDATE sqlite_schema SET sql = replace(sql, ' STRICT', '')")
    change(session, "UPDATE mark SET pass = x'00'", seal=False)
    assert "damaged" in refused(session)
    with pytest.raises(chunks.DamagedError, match="bytes where none belong"):
        file._digest([(1, b"x")])
    with pytest.raises(chunks.DamagedError, match="wrong type"):
        chunks.unpack([(1, 0, 1, 2, "text", b"", b"")], 2)


def test_bounds_hold(session, monkeypatch):
    for name, value, words in (
        ("MAX_SESSION", 100, "at most 100 are read"),
        ("MAX_FRAMES", 100, "at most 100 are read"),
        ("MAX_ROWS", 2, "more than 2 rows"),
        ("MAX_ROW", 50, "damaged"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(file, name, value)
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
            real = sqlite3.connect
            patch.setattr(sqlite3, "connect", lambda *a, **k: real(*a, timeout=0.0, **k))
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


def test_where_it_cannot_be_written(tmp_path, monkeypatch):
    with pytest.raises(SessionError, match="a folder or a device"):
        create_session(tmp_path, recording())
    with pytest.raises(SessionError, match="cannot be written"):
        create_session(tmp_path / "none" / "s.georibbon", recording())
    monkeypatch.setattr(file, "statements", lambda: {"x": "CREATE NONSENSE"})
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
