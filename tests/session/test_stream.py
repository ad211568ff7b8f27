"""Frames without end: as they were, in few chunks, and never waited for."""

import sqlite3
import tempfile
import threading
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made import RIBBON, same

from georibbon.errors import RecordingError, SessionError
from georibbon.ribbon import Readings
from georibbon.session import stream as module
from georibbon.session.chunks import FRAMES
from georibbon.session.session import Session
from georibbon.session.telling import tell
from waiting import wait_until


def frames(start, stop, wide=False):
    """Frames of a long capture, from one to another; some values lost, some wide."""
    places = np.arange(start, stop)
    counts = (places[:, None] * 31 + np.arange(8)) % 40_000 - 20_000.0
    counts[places % 7 == 3, 2] = np.nan
    if wide:
        counts[places % 5000 == 10, 1] = 1e6
    return Readings(places * 0.01, counts)


@dataclass
class Frame:
    """As the link delivers it."""

    t: float
    counts: np.ndarray


def chunks_of(path, part):
    with closing(sqlite3.connect(path)) as database:
        query = "SELECT place, frames FROM chunk WHERE part = ? ORDER BY place"
        return database.execute(query, (part,)).fetchall()


# Blocks to append, and None for a transaction between them.
BLOCKS = st.lists(st.sampled_from([1, 2, 20, 700, 2047, 2048, 2049, 5000, None]), max_size=8)


@given(BLOCKS, st.booleans())
@settings(max_examples=25)
def test_what_is_appended_is_there_in_as_few_chunks_as_can_be(blocks, wide):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "s.georibbon"
        with Session.create(path, RIBBON) as session:
            stream = session.stream(100.0)
            done = 0
            for block in blocks:
                if block is None:
                    assert stream.flush()
                    assert stream.durable == done
                    continue
                stream.append(frames(done, done + block, wide))
                done += block
            assert stream.frames == done
            stream.close()
            assert stream.durable == done
            if done:
                assert same(session.readings(stream.part), frames(0, done, wide))
            assert session.readings(stream.part).counts.shape == (done, 8)
        expected = [FRAMES] * (done // FRAMES) + [done % FRAMES] * (done % FRAMES > 0)
        assert chunks_of(path, stream.part) == list(enumerate(expected))
        assert tell(path)["streams"][0]["frames"] == done


def test_it_is_merged_while_it_grows(tmp_path):
    path = tmp_path / "s.georibbon"
    with Session.create(path, RIBBON) as session:
        stream = session.stream(100.0)
        for k in range(210):
            stream.append(frames(20 * k, 20 * k + 20))
            assert stream.flush()
        # 102 blocks are 2040 frames; the next one makes a chunk, and leaves 12 frames
        expected = [FRAMES, FRAMES, 4, *[20] * 5]
        assert [count for _, count in chunks_of(path, stream.part)] == expected
        assert same(session.readings(stream.part), frames(0, 4200))


def test_it_is_written_soon_without_being_asked(tmp_path):
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 5))
        wait_until(lambda: stream.durable == 5)
        assert [one["frames"] for one in tell(session.path)["streams"]] == [5]
        stream.append(frames(5, 9))
        wait_until(lambda: stream.durable == 9)


def test_the_frames_of_the_link_are_taken(tmp_path):
    counts = np.array([1, -32768, 3, 4, 5, 6, 7, -32767], dtype=np.int16)
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        stream = session.stream(100.0)
        stream.append([Frame(0.5, counts), Frame(0.51, counts)])
        stream.append([])
        assert stream.flush()
        expected = np.array([[1, np.nan, 3, 4, 5, 6, 7, -32767]] * 2)
        assert same(session.readings(stream.part), Readings(np.array([0.5, 0.51]), expected))


def test_much_at_once_is_written_in_bounded_transactions(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MOST_AT_ONCE", 3000)
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 20_000))
        works = []
        real = stream.done
        monkeypatch.setattr(stream, "done", lambda work: (works.append(work.frames), real(work)))
        assert stream.flush()
        assert sum(works) == 20_000
        assert max(works) < 3000 + FRAMES
        assert same(session.readings(stream.part), frames(0, 20_000))


def test_waiting_for_a_slow_disk_ends_in_time(tmp_path):
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        stream = session.stream(100.0)
        entered, going = threading.Event(), threading.Event()

        def block():
            entered.set()
            going.wait(60.0)

        blocked = threading.Thread(target=lambda: session._writer.call(block))
        blocked.start()
        entered.wait(60.0)
        stream.append(frames(0, 9))
        safe = stream.flush(timeout=0.05)
        stream.append(frames(9, 12))
        going.set()
        blocked.join()
        assert not safe
        assert stream.flush()
        assert stream.durable == 12
    assert stream.flush()


def test_what_was_given_up_is_not_waited_for(tmp_path):
    session = Session.create(tmp_path / "s.georibbon", RIBBON)
    stream = session.stream(100.0)
    session.path.unlink()
    stream.append(frames(0, 9))
    assert not stream.flush()
    session.close(discard=True)
    assert not stream.flush(timeout=1e6)


BAD = {
    "columns": (Readings(np.zeros(1), np.zeros((1, 3))), RecordingError, "shapes"),
    "times": (Readings(np.zeros(2), np.zeros((2, 8))), RecordingError, "that grow"),
    "back": (frames(3, 5), SessionError, "times that grow"),
    "infinite": (Readings(np.full(1, np.inf), np.zeros((1, 8))), RecordingError, "seconds"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_frame_is_refused_and_the_others_go_on(tmp_path, name):
    bad, error, words = BAD[name]
    with Session.create(tmp_path / "s.georibbon", RIBBON) as session:
        stream = session.stream(100.0)
        stream.append(frames(0, 5))
        with pytest.raises(error, match=words):
            stream.append(bad)
        stream.append(frames(5, 9))
        assert stream.flush()
        assert same(session.readings(stream.part), frames(0, 9))


def test_several_streams_and_passes_do_not_mix(tmp_path):
    path = tmp_path / "s.georibbon"
    with Session.create(path, RIBBON) as session:
        first, second = session.stream(100.0), session.stream(50.0)
        for k in range(5):
            first.append(frames(1000 * k, 1000 * k + 1000))
            second.append(frames(900 * k, 900 * k + 900))
            session.add_pass(f"P{k}", "pass", frames(k, k + 10))
    with Session.open(path) as session:
        assert same(session.readings(first.part), frames(0, 5000))
        assert same(session.readings(second.part), frames(0, 4500))
        third = session.stream(100.0)
        assert third.part == 8
        for k, run in enumerate(session.state.passes):
            assert same(session.readings(run.part), frames(k, k + 10))
    assert tell(path)["frames"] == 9550
