"""The CSV file that grows: what is durable is in it, whatever happens to the disk."""

import errno
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.capture.csv_log import CsvLog, check_csv_place
from georibbon.capture.durable_file import DurableFile
from georibbon.device.frames import LOST, Frame, readings_of
from georibbon.errors import ExportError, StorageError
from georibbon.session.counts import parse_csv

COLUMNS = ("A1x", "A1y", "A1z")


def frames(count, start=0):
    """Frames of counts that tell their number, a lost value among them."""
    return [
        Frame(7.25 + i / 100, np.array([i, -i, LOST], dtype=np.int16), 0.0)
        for i in range(start, start + count)
    ]


def parsed(path):
    return parse_csv(path.read_bytes(), COLUMNS, path.name)


def numbers(path):
    """The numbers of the frames in a file."""
    return parsed(path).counts[:, 0].astype(int).tolist()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.csv"


@pytest.fixture
def log(path):
    made = CsvLog(path, COLUMNS)
    yield made
    made.close()


@pytest.fixture
def disk(monkeypatch):
    """A disk that can be made to fail: on flushing, or after some bytes of a write."""

    class Disk:
        fault: int | None = None

    def flush(descriptor, before=os.fsync):
        if Disk.fault is not None:
            raise OSError(Disk.fault, os.strerror(Disk.fault))
        before(descriptor)

    monkeypatch.setattr("os.fsync", flush)
    return Disk


COUNTS = st.integers(-32768, 32767)
STEPS = st.one_of(st.just(0.0), st.floats(1e-9, 1e-5), st.floats(1e-5, 1e4))
ROWS = st.lists(st.tuples(STEPS, COUNTS, COUNTS, COUNTS), min_size=1, max_size=12)


@given(ROWS, st.floats(0.0, 1e5), st.integers(1, 5))
def test_what_is_read_is_what_was_taken(tmp_path_factory, rows, start, at_once):
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    t = start + np.cumsum([row[0] for row in rows])
    taken = [
        Frame(float(t[i]), np.array(row[1:], dtype=np.int16), 0.0) for i, row in enumerate(rows)
    ]
    log = CsvLog(path, COLUMNS)
    for i in range(0, len(taken), at_once):
        log.append(taken[i : i + at_once])
        log.sync()
        assert log.durable == log.frames == parsed(path).t.size
    log.close()
    back, meant = parsed(path), readings_of(taken)
    assert np.array_equal(back.counts, meant.counts, equal_nan=True)
    # To the microsecond; frames closer than that are moved apart by one each.
    assert np.all(np.abs(back.t - meant.t) < 1.1e-6 * len(rows))
    assert back.t[0] == 0.0


def test_times_are_the_ribbons_microseconds(log, path):
    log.append(
        [Frame(t, np.zeros(3, np.int16), 0.0) for t in (0.1 + 0.2, 0.310001, 4000.3, 123456.789012)]
    )
    log.sync()
    times = [line.split(",")[0] for line in path.read_text().splitlines()[1:]]
    assert times == ["0.000000", "0.010001", "4000.000000", "123456.489012"]


def test_nothing_is_made_before_there_is_a_frame(log, path):
    log.sync()
    assert not path.exists()
    log.append([])
    log.sync()
    assert not path.exists()
    log.append(frames(1))
    assert not path.exists()
    log.sync()
    assert numbers(path) == [0]


def test_the_file_is_readable_after_each_flush_and_durable_counts_it(log, path):
    for i in range(5):
        log.append(frames(3, 3 * i))
        assert (log.frames, log.durable) == (3 * i + 3, 3 * i)
        log.sync()
        assert log.durable == log.frames
        assert numbers(path) == list(range(3 * i + 3))


def test_more_than_a_block_at_once(path):
    log = CsvLog(path, COLUMNS)
    for start in range(0, 30000, 1000):
        log.append([Frame(f.t, f.counts, 0.0) for f in frames(1000, start)] * 3)
    log.close()
    assert log.durable == 90000 == parsed(path).t.size
    assert path.stat().st_size > 1 << 20


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS])
def test_a_disk_that_fails_and_comes_back(log, path, disk, fault):
    log.append(frames(4))
    log.sync()
    disk.fault = fault
    for start in (4, 6):
        log.append(frames(2, start))
        with pytest.raises(StorageError, match=os.strerror(fault)) as caught:
            log.sync()
        assert str(path) in str(caught.value)
        assert (log.frames, log.durable) == (start + 2, 4)
        assert numbers(path) == [0, 1, 2, 3]
    disk.fault = None
    log.sync()
    assert log.durable == 8
    assert numbers(path) == list(range(8))


def test_a_disk_that_fails_from_the_first_frame_on(log, path, disk):
    disk.fault = errno.ENOSPC
    log.append(frames(4))
    with pytest.raises(StorageError):
        log.sync()
    assert log.durable == 0
    disk.fault = None
    log.sync()
    assert numbers(path) == [0, 1, 2, 3]


def test_a_write_that_takes_a_part_leaves_no_part_of_a_line(log, path):
    """A disk that is nearly full takes some bytes, and then none."""
    log.append(frames(1))
    log.sync()
    file = log._file._file
    room = [10]

    class Full:
        def __getattr__(self, name):
            return getattr(file, name)

        def write(self, data):
            if not room[0]:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            taken = file.write(data[: room[0]])
            room[0] -= taken
            return taken

    log._file._file = Full()
    log.append(frames(3, 1))
    with pytest.raises(StorageError):
        log.sync()
    assert numbers(path) == [0]
    room[0] = 1000
    log.sync()
    assert numbers(path) == [0, 1, 2, 3]


@pytest.mark.parametrize("away", ["removed", "moved", "replaced"])
def test_a_file_that_is_taken_away_is_written_anew(log, path, tmp_path, away):
    log.append(frames(5))
    log.sync()
    if away == "removed":
        path.unlink()
    else:
        path.rename(tmp_path / "elsewhere.csv")
    if away == "replaced":
        path.write_text("years of work")
    log.append(frames(2, 5))
    with pytest.raises(StorageError, match="removed or replaced"):
        log.sync()
    assert (log.frames, log.durable) == (7, 0)
    if away == "replaced":
        with pytest.raises(StorageError, match="File exists"):
            log.sync()
        assert path.read_text() == "years of work"
        assert log.durable == 0
        path.unlink()
    log.sync()
    assert log.durable == 7
    assert numbers(path) == list(range(7))
    log.append(frames(1, 7))
    log.sync()
    assert numbers(path) == list(range(8))


CUT = [0, 1, 20, -1]
"""Where another program cuts the file off: bytes from its beginning, or from its end."""


@pytest.mark.parametrize("at", CUT)
def test_a_file_that_is_cut_is_left_alone_and_what_comes_goes_to_a_new_one(log, path, at):
    log.append(frames(50))
    log.sync()
    left = path.read_bytes()[:at]
    os.truncate(path, len(left))
    log.append(frames(2, 50))
    with pytest.raises(StorageError, match="50 frames may be lost"):
        log.sync()
    assert (log.frames, log.durable) == (52, 0)
    with pytest.raises(StorageError, match="File exists"):
        log.sync()
    assert path.read_bytes() == left
    path.unlink()
    log.append(frames(3, 52))
    log.sync()
    assert (log.frames, log.durable, log.gone) == (55, 5, 50)
    assert numbers(path) == list(range(50, 55))
    assert parsed(path).t[0] == 0.5


@pytest.mark.parametrize("at", CUT)
def test_what_comes_after_a_cut_can_go_to_another_place(log, path, tmp_path, at):
    other = tmp_path / "other.csv"
    log.append(frames(4))
    log.sync()
    left = path.read_bytes()[:at]
    os.truncate(path, len(left))
    path.unlink()  # and the bytes cannot be had from the file that is open, either
    log.append(frames(2, 4))
    log.move_to(other)
    assert (log.frames, log.durable, log.gone) == (6, 2, 4)
    assert numbers(other) == [4, 5]


def test_a_copy_of_what_is_cut_meanwhile_is_refused(path, tmp_path):
    file, other = DurableFile(path), tmp_path / "other.csv"
    file.extend(b"0123456789")
    assert file.whole()
    os.truncate(path, 4)
    assert not file.whole()
    with pytest.raises(OSError, match="cut shorter") as caught:
        file.copied_to(other)
    assert caught.value.errno == errno.EIO
    assert not other.exists()
    file.close()


def test_a_folder_that_is_taken_away(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    log = CsvLog(folder / "run.csv", COLUMNS)
    log.append(frames(3))
    log.sync()
    folder.rename(tmp_path / "elsewhere")
    for _ in range(2):
        with pytest.raises(StorageError):
            log.sync()
    assert log.durable == 0
    folder.mkdir()
    log.close()
    assert numbers(folder / "run.csv") == [0, 1, 2]
    assert log.durable == 3


def test_another_place_gets_everything(log, path, tmp_path, disk):
    other = tmp_path / "other.csv"
    log.append(frames(3))
    log.sync()
    disk.fault = errno.ENOSPC
    log.append(frames(2, 3))
    with pytest.raises(StorageError):
        log.sync()
    with pytest.raises(StorageError, match=r"other\.csv"):
        log.move_to(other)
    assert not other.exists()
    assert numbers(path) == [0, 1, 2]
    assert log.durable == 3
    disk.fault = None
    log.move_to(other)
    log.append(frames(1, 5))
    log.sync()
    assert log.path == other
    assert log.durable == 6
    assert numbers(other) == list(range(6))
    assert numbers(path) == [0, 1, 2]


def test_another_place_before_anything_was_written(log, path, tmp_path):
    log.append(frames(2))
    log.move_to(tmp_path / "other.csv")
    assert numbers(tmp_path / "other.csv") == [0, 1]
    assert not path.exists()


def test_no_other_place_is_overwritten(log, tmp_path):
    other = tmp_path / "other.csv"
    other.write_text("years of work\n")
    with pytest.raises(ExportError, match="never overwritten"):
        log.move_to(other)
    assert other.read_text() == "years of work\n"


def test_a_file_that_is_there_is_refused_and_left_alone(path):
    path.write_text("t,A1x\n0,1\n")
    with pytest.raises(ExportError, match="never overwritten") as caught:
        CsvLog(path, COLUMNS)
    assert "cut off" not in str(caught.value)
    assert path.read_text() == "t,A1x\n0,1\n"


def test_a_file_that_appears_meanwhile_is_left_alone(log, path):
    log.append(frames(1))
    path.write_text("years of work")
    with pytest.raises(StorageError, match="File exists"):
        log.sync()
    assert path.read_text() == "years of work"
    path.unlink()
    log.sync()
    assert numbers(path) == [0]


def test_a_line_that_a_crash_cut_off_is_told(path):
    path.write_text("t,A1x\n0,1\n0.01,12")
    with pytest.raises(ExportError, match="its last line was cut off"):
        check_csv_place(path)


def test_places_where_nothing_can_be_written(tmp_path, monkeypatch):
    with pytest.raises(ExportError, match="there is no folder"):
        check_csv_place(tmp_path / "missing" / "run.csv")
    with pytest.raises(ExportError, match="is there already"):
        check_csv_place(tmp_path)
    (tmp_path / "link.csv").symlink_to(tmp_path / "nowhere")
    with pytest.raises(ExportError, match="is there already"):
        check_csv_place(tmp_path / "link.csv")
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(ExportError, match="cannot be written to"):
        check_csv_place(tmp_path / "run.csv")


def test_a_name_that_no_file_can_have_is_refused(tmp_path):
    with pytest.raises(ExportError, match="no file can have this name"):
        check_csv_place(tmp_path / ("x" * 300 + ".csv"))
