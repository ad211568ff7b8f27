"""The session file of version 1: read as it was published, made into the present version."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import old
import pytest
from made import same

from georibbon.errors import SessionError
from georibbon.session import migration, version1
from georibbon.session.chunks import DamagedError
from georibbon.session.file import read_session
from georibbon.session.session import Session
from georibbon.session.telling import tell
from georibbon.session.version1 import TABLES


@pytest.fixture
def session(tmp_path):
    """A copy of the published file."""
    return Path(shutil.copy(old.VERSION_1, tmp_path / "old.georibbon"))


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def refused(path):
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
            row = (version1.digest(version1.select(database, name)), name)
            database.execute("UPDATE seal SET digest = ? WHERE name = ?", row)


def test_the_published_file_gives_what_was_put_into_it(session):
    before = session.read_bytes()
    assert same(read_session(session), old.recording())
    with Session.open(session, read_only=True) as opened:
        assert same(opened.recording(), old.recording())
        assert opened.recovery is None
    assert tell(session)["version"] == 1
    assert names(session.parent) == ["old.georibbon"]
    assert session.read_bytes() == before


def test_opened_for_writing_it_is_brought_to_the_present_and_the_old_one_kept(session):
    before = session.read_bytes()
    with Session.open(session) as opened:
        assert any("old.version-1.georibbon" in warning for warning in opened.warnings)
        assert opened.recovery is None
        assert same(opened.recording(), old.recording())
        opened.do("note", text="after")
    assert names(session.parent) == ["old.georibbon", "old.version-1.georibbon"]
    assert (session.parent / "old.version-1.georibbon").read_bytes() == before
    assert session.read_bytes()[60:64] == b"\0\0\0\2"
    assert same(read_session(session), old.recording())
    assert [note["text"] for note in tell(session)["notes"]] == ["after"]


@pytest.mark.parametrize("links", [True, False])
def test_a_copy_that_is_there_is_never_overwritten(session, monkeypatch, links):
    if not links:
        monkeypatch.setattr(Path, "hardlink_to", _no_links)
    kept = session.parent / "old.version-1.georibbon"
    kept.write_text("mine")
    before = session.read_bytes()
    Session.open(session).close()
    assert kept.read_text() == "mine"
    assert (session.parent / "old.version-1-2.georibbon").read_bytes() == before
    assert len(names(session.parent)) == 3


def _no_links(*_):
    raise PermissionError(1, "Operation not permitted")


def test_where_it_cannot_be_migrated_it_stays_as_it_was(session, monkeypatch):
    def fail(*_, **__):
        raise SessionError("no room")

    before = session.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(migration, "create", fail)
        with pytest.raises(SessionError, match="no room"):
            Session.open(session)
    assert names(session.parent) == ["old.georibbon"]
    assert session.read_bytes() == before
    monkeypatch.setattr(migration, "MOST_COPIES", 1)
    with pytest.raises(SessionError, match="remove some"):
        Session.open(session)


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
    "a view": (["DROP TABLE note", "CREATE VIEW note AS SELECT 1"], "not those of version 1"),
    "no table": (["DROP TABLE chunk"], "not those of version 1"),
    "no ribbon": (["DELETE FROM ribbon"], "no ribbon is known"),
    "one pass": (
        ["DELETE FROM pass WHERE place = 1", "DELETE FROM chunk WHERE part = 4",
         "DELETE FROM part WHERE id = 4"],
        "1 pass of kind",
    ),
    "sigma": (["UPDATE mark SET sigma = -1"], "sigma is -1.0"),
    "infinity": (["UPDATE mark SET x = 9e999"], "damaged|no number|cannot keep"),
    "a tilted workpiece": (["UPDATE workpiece SET level = 0"], "level is false"),
    "a table of 2": (["UPDATE pose SET on_table = 2"], "table is 2"),
    "a part twice": (["UPDATE pass SET part = 1"], "used twice"),
    "no such part": (["UPDATE pass SET part = 77 WHERE place = 0"], "frames"),
    "another length": (["UPDATE part SET frames = 5"], "frames"),
    "no date": (["UPDATE meta SET value = 'now' WHERE key = 'created'"], "no time but"),
    "a setting that is none": (
        ["INSERT INTO setting VALUES (1, 'P1', 'smoothing', '}')"], "no JSON",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FORGED)
def test_what_is_sealed_and_cannot_be_meant_is_refused(session, name):
    statements, words = FORGED[name]
    change(session, *statements, seal=name not in ("a view", "no table"))
    told = refused(session)
    assert any(word in told for word in words.split("|"))


def test_blobs_where_text_belongs_are_refused(session):
    change(
        session,
        "PRAGMA writable_schema = ON",
        "UPDATE sqlite_schema SET sql = replace(sql, ' STRICT', '')",
        seal=False,
    )
    change(session, "UPDATE mark SET pass = x'00'", seal=False)
    assert "damaged" in refused(session)
    with pytest.raises(DamagedError, match="bytes where none belong"):
        version1.digest([(1, b"x")])


def test_bounds_hold(session, monkeypatch):
    monkeypatch.setattr(version1, "MAX_ROWS", 2)
    assert "more than 2 rows" in refused(session)


def test_what_the_tables_could_hold_beside_is_taken_over(session):
    change(
        session,
        "INSERT INTO setting VALUES (1, 'P1', 'smoothing', '0.06')",
        "INSERT INTO note VALUES (1, '2025-01-02T03:04:05+00:00', 'cold')",
        "INSERT INTO calibration VALUES (1, '2025-01-02T03:04:05+00:00', 'null')",
    )
    with Session.open(session) as opened:
        assert opened.state.settings == {("P1", "smoothing"): 0.06}
        assert [(note.time, note.text) for note in opened.state.notes] == [
            ("2025-01-02T03:04:05+00:00", "cold")
        ]
