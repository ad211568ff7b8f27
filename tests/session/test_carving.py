"""Rows found without their table: every one that is there, and none that is not."""

import shutil
import tempfile
from contextlib import closing
from pathlib import Path

import journals
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from journals import event
from made import readings

from georibbon.errors import SessionError
from georibbon.ribbon import Readings
from georibbon.session import carving, pages
from georibbon.session.carving import carved
from georibbon.session.chunks import DamagedError, pack
from georibbon.session.pages import SIZES, decode, varint

EVENTS = [
    event(1, "created", georibbon="2.0"),
    event(2, text="short"),
    event(3, text="ä" * 300),
    event(4, text="long " * 5000),
    *(event(i, text=f"note {i}") for i in range(5, 60)),
    event(200, "undo", of=7),
]
CHUNKS = [
    *pack(readings(3000, seed=1), 1),
    *pack(readings(1, seed=2), 2),
    *pack(Readings(np.arange(90) / 7, readings(90, seed=3).counts * 1000), 3),
    *pack(readings(150, seed=4), 300),
]
WRITTEN = ([e.row for e in EVENTS], [c.row for c in CHUNKS])


def found(path):
    """What is found in a file, as rows."""
    with carved(path) as carving:
        assert carving.whole
        assert carving.conflicts == ()
        return journals.rows(carving)


@pytest.fixture
def journal(tmp_path):
    """A closed file with those rows."""
    journals.write(tmp_path / "s.georibbon", EVENTS, CHUNKS)
    return tmp_path / "s.georibbon"


@pytest.mark.parametrize("size", SIZES)
def test_an_undamaged_file_gives_exactly_its_rows(tmp_path, size):
    path = tmp_path / "s.georibbon"
    journals.write(path, EVENTS, CHUNKS, size)
    before = path.read_bytes()
    assert found(path) == WRITTEN
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("header", [b"", b"SQLite format 3\0\x02\0", b"\xff" * 20])
def test_neither_the_header_nor_the_schema_is_needed(tmp_path, size, header):
    path = tmp_path / "s.georibbon"
    journals.write(path, EVENTS, CHUNKS, size)
    body = path.read_bytes()
    path.write_bytes(header.ljust(size, b"\0") + body[size:])
    assert found(path) == WRITTEN


def test_trees_and_page_headers_are_not_needed(journal):
    body = bytearray(journal.read_bytes())
    for page in range(4096, len(body), 4096):
        if body[page] in (2, 5, 10):  # inner pages, and the index
            body[page : page + 4096] = bytes(4096)
        elif body[page] == 13:
            body[page : page + 8] = bytes(8)
    journal.write_bytes(body)
    events, chunks = found(journal)
    assert events == WRITTEN[0]
    assert chunks == WRITTEN[1]


@given(st.data())
@settings(max_examples=40, deadline=None)
def test_one_byte_costs_at_most_one_row(data):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "s.georibbon"
        journals.write(path, EVENTS, CHUNKS)
        body = bytearray(path.read_bytes())
        place = data.draw(st.integers(0, len(body) - 1) | st.integers(0, 100))
        body[place] ^= data.draw(st.integers(1, 255))
        path.write_bytes(body)
        events, chunks = found(path)
        lost = [row for row in WRITTEN[0] if row not in events]
        lost += [row for row in WRITTEN[1] if row not in chunks]
        assert len(lost) <= 1
        assert len(events) + len(chunks) + len(lost) == len(EVENTS) + len(CHUNKS)


@given(st.data())
@settings(max_examples=40, deadline=None)
def test_whatever_is_damaged_only_what_was_written_is_found(data):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "s.georibbon"
        journals.write(path, EVENTS, CHUNKS)
        body = bytearray(path.read_bytes())
        pages = len(body) // 4096
        for page in data.draw(st.lists(st.integers(0, pages - 1), max_size=5)):
            other = data.draw(st.sampled_from([None, *range(pages)]))
            content = bytes(4096) if other is None else body[other * 4096 :][:4096]
            body[page * 4096 : page * 4096 + 4096] = content
        for place in data.draw(st.lists(st.integers(0, len(body) - 1), max_size=20)):
            body[place] ^= data.draw(st.integers(1, 255))
        path.write_bytes(body[: data.draw(st.integers(0, len(body)) | st.just(len(body)))])
        events, chunks = found(path)
        assert all(row in WRITTEN[0] for row in events)
        assert all(row in WRITTEN[1] for row in chunks)
        assert sorted(events) == events


def killed(database, path):
    """The file and its log as a crash would leave them; returns the copy."""
    copy = path.with_name("crashed.georibbon")
    shutil.copy(path, copy)
    shutil.copy(f"{path}-wal", f"{copy}-wal")
    assert database.execute("SELECT 1").fetchone() == (1,)  # still open: nothing was put away
    return copy


@pytest.fixture
def logging(tmp_path):
    """A journal in WAL mode with the first rows in the file and the others in the log."""
    path = tmp_path / "s.georibbon"
    with closing(journals.opened(path)) as database:
        journals.add(database, EVENTS[:30], CHUNKS[:2])
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("PRAGMA wal_autocheckpoint = 0")
        journals.add(database, EVENTS[30:40], CHUNKS[2:3])
        journals.add(database, EVENTS[40:], CHUNKS[3:])
        yield database, path


def test_the_log_is_read_too(logging):
    assert found(killed(*logging)) == WRITTEN


def test_a_damaged_frame_of_the_log_does_not_end_it(logging):
    copy = killed(*logging)
    log = Path(f"{copy}-wal")
    body = bytearray(log.read_bytes())
    body[32 + 24 + 100] ^= 1
    log.write_bytes(body)
    events, _ = found(copy)
    assert events == WRITTEN[0]
    body[:32] = bytes(32)
    log.write_bytes(body)
    assert found(copy)[0] == WRITTEN[0]


def test_what_was_never_committed_is_not_found(logging):
    database, path = logging
    database.execute("PRAGMA cache_size = 1")
    database.execute("BEGIN")
    for number in range(1000, 1400):
        row = event(number, text="never " * 100).row
        database.execute("INSERT INTO event VALUES (?, ?, ?, ?, ?)", row)
    copy = killed(database, path)
    assert b"never never" in Path(f"{copy}-wal").read_bytes()
    assert found(copy) == WRITTEN
    database.execute("ROLLBACK")
    journals.add(database, [event(1000, text="another")])
    events, chunks = found(killed(database, path))
    assert events == [*WRITTEN[0], event(1000, text="another").row]
    assert chunks == WRITTEN[1]


def test_what_the_log_held_before_is_not_found(logging):
    database, path = logging
    database.execute("PRAGMA cache_size = 1")
    database.execute("BEGIN")
    for number in range(1000, 1400):
        row = event(number, text="never " * 100).row
        database.execute("INSERT INTO event VALUES (?, ?, ?, ?, ?)", row)
    database.execute("ROLLBACK")
    database.execute("PRAGMA wal_checkpoint(RESTART)")
    journals.add(database, [event(1000, text="another")])
    copy = killed(database, path)
    assert b"never never" in Path(f"{copy}-wal").read_bytes()
    assert found(copy)[0] == [*WRITTEN[0], event(1000, text="another").row]


def test_the_pages_are_those_that_sqlite_sees(logging):
    """After a checkpoint the log is written anew from its start, over what it held before."""
    database, path = logging
    database.execute("PRAGMA wal_checkpoint(RESTART)")
    journals.add(database, [event(1000, text="x" * 9000)])
    database.execute("DELETE FROM event WHERE id > 990")
    database.execute("PRAGMA wal_checkpoint(RESTART)")
    journals.add(database, [event(1001, text="y" * 5000)])
    copy = killed(database, path)
    with copy.open("rb") as file, Path(f"{copy}-wal").open("rb") as log:
        view = pages.Pages(file, log, 4096)
        seen = [view.page(number) for number in range(1, view.count + 3)]
    with closing(journals.sqlite3.connect(copy)) as other:
        other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    body = copy.read_bytes()
    assert b"".join(seen[1:]) == body[4096:]


def test_a_frame_of_the_log_that_names_another_page_costs_no_row_of_the_file(logging):
    copy = killed(*logging)
    page = copy.read_bytes().index(CHUNKS[0].counts[20_000:20_100]) // 4096 + 1
    log = Path(f"{copy}-wal")
    body = bytearray(log.read_bytes())
    body[32:36] = page.to_bytes(4)
    log.write_bytes(body)
    assert CHUNKS[0].row in found(copy)[1]


def test_of_two_events_of_one_id_the_newer_is_taken_and_it_is_told(logging):
    database, path = logging
    row = (*event(7, text="forged").row, 7)
    query = "UPDATE event SET id=?, time=?, action=?, detail=?, digest=? WHERE id=?"
    database.execute(query, row)
    with carved(killed(database, path)) as carving:
        assert carving.conflicts == (7,)
        (found,) = [e for e in carving.events if e.id == 7]
        assert found.detail == {"text": "forged"}


def test_deleted_rows_are_found_as_long_as_their_bytes_are_there(journal):
    with closing(journals.sqlite3.connect(journal)) as database, database:
        database.execute("PRAGMA secure_delete = OFF")
        database.execute("DELETE FROM chunk WHERE part = 3")
    events, chunks = found(journal)
    assert events == WRITTEN[0]
    assert all(row in WRITTEN[1] for row in chunks)


@given(st.binary(max_size=3000), st.sampled_from([b"", b"SQLite format 3\0\x10\0"]))
@settings(max_examples=100, deadline=None)
def test_any_bytes_are_gone_through(data, head):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "s.georibbon"
        path.write_bytes(head + data)
        Path(f"{path}-wal").write_bytes(data[::-1])
        assert found(path) == ([], [])


def hostile_head(t, counts):
    """The head of a chunk's record with blobs of so many bytes."""
    kinds = b"".join(encoded(12 + 2 * length) for length in (t, counts))
    return bytes([6 + len(kinds)]) + b"\x01\x01\x02\x01" + kinds + b"\x4c"


def encoded(value):
    """A number of up to four times seven bits."""
    digits = [value >> shift & 0x7F for shift in (21, 14, 7, 0) if value >> shift]
    return bytes([digit | 0x80 for digit in digits[:-1]] + digits[-1:])


def test_a_chain_in_a_circle_ends(tmp_path, monkeypatch):
    """Every page is full of heads that ask for megabytes of a chain that leads to itself."""
    monkeypatch.setattr(carving, "_SPARE", 2**22)
    path = tmp_path / "s.georibbon"
    head = hostile_head(8 * 2**16, 2**21)
    page = (head * 500)[:4092]
    path.write_bytes(b"".join((n % 50 + 1).to_bytes(4) + page for n in range(50)))
    with carved(path) as search:
        assert (search.events, search.pieces, search.whole) == ((), (), False)


def test_too_many_rows_are_not_gathered(journal, monkeypatch):
    monkeypatch.setattr(carving, "MAX_ROWS", 20)
    with carved(journal) as search:
        assert not search.whole
        assert len(search.events) + len(search.pieces) == 21


def test_a_place_that_the_disk_cannot_read_costs_what_is_there(journal, monkeypatch):
    """Reading any part of a page of events fails, as it does on a disk with a bad sector."""
    real, start = pages.read_at, journal.read_bytes().index(b"note 30") // 4096 * 4096

    def read_at(file, offset, length):
        bad = offset < start + 4096 and offset + length > start
        return b"" if bad else real(file, offset, length)

    for module in (pages, carving):
        monkeypatch.setattr(module, "read_at", read_at)
    events, chunks = found(journal)
    assert 0 < len(events) < len(EVENTS)
    assert all(row in WRITTEN[0] for row in events)
    assert chunks == WRITTEN[1]


def test_a_log_is_found_beside_what_a_link_leads_to(logging, tmp_path):
    copy = killed(*logging)
    (tmp_path / "elsewhere").mkdir()
    link = tmp_path / "elsewhere" / "link.georibbon"
    link.symlink_to(copy)
    assert found(link) == WRITTEN


def test_a_file_that_changes_meanwhile_is_noticed(journal):
    with carved(journal) as search:
        body = journal.read_bytes()
        journal.write_bytes(bytes(len(body)))
        with pytest.raises(DamagedError, match="changed while"):
            search.chunk(search.pieces[0])


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    for path in (tmp_path / "none", tmp_path, tmp_path / ("n" * 5000), tmp_path / "\0"):
        with pytest.raises(SessionError, match="cannot be read"), carved(path):
            pass


def test_what_a_disk_cannot_read_is_nothing():
    class Broken:
        def seek(self, *_):
            raise OSError(5, "Input/output error")

    assert pages.read_at(Broken(), 0, 10) == b""


@given(st.binary(max_size=40))
def test_any_record_is_decoded_or_none(data):
    values = decode(data)
    assert values is None or isinstance(values, tuple)


@pytest.mark.parametrize(
    ("data", "value"),
    [
        (b"\x00", (0, 1)),
        (b"\x7f\xff", (127, 1)),
        (b"\x81\x00", (128, 2)),
        (b"\xff" * 9, (2**64 - 1, 9)),
        (b"\x80" * 8 + b"\x01", (1, 9)),
        (b"\x81", None),
        (b"", None),
    ],
)
def test_numbers_of_variable_length(data, value):
    assert varint(data, 0) == value
