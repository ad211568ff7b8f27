"""The recorder: every frame of the link gets to the sink, in order, and is counted."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from georibbon.capture import recorder as module
from georibbon.capture.recorder import Progress, Recorder
from georibbon.device.frames import Frame
from georibbon.device.ring import Tap
from georibbon.errors import StorageError
from waiting import wait_until


def frames(count, start=0, rate=100.0):
    return [
        Frame(3.0 + i / rate, np.array([i], dtype=np.int16), time.monotonic())
        for i in range(start, start + count)
    ]


class FakeSink:
    """Keeps what it gets in a list; `fault` makes it fail."""

    def __init__(self):
        self.frames, self.threads, self.turns = [], set(), 0
        self.durable = 0
        self.fault = None

    def append(self, taken):
        self.turns += 1
        self.frames += taken
        self.threads.add(threading.current_thread().name)

    def sync(self):
        if self.fault is not None:
            raise self.fault
        self.durable = len(self.frames)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    for name in ("PERIOD", "RETRY"):
        monkeypatch.setattr(module, name, 0.01)


@pytest.fixture
def tap():
    return Tap()


@pytest.fixture
def sink():
    return FakeSink()


def wait_for(recorder, frames, durable):
    wait_until(lambda: recorder.progress.frames == frames and recorder.progress.durable == durable)


def numbers(taken):
    return [int(frame.counts[0]) for frame in taken]


def test_every_frame_gets_to_the_sink_in_order(tap, sink):
    recorder = Recorder(tap, sink)
    tap.append(frames(7))  # before it is started
    assert recorder.progress == Progress(0, 0, None)
    recorder.start()
    sent = 7
    for count in (7, 0, 1, 30, 400):
        tap.append(frames(count, sent))
        sent += count
        wait_for(recorder, sent, sent)
    tap.append(frames(5, sent))
    recorder.stop()
    assert numbers(sink.frames) == list(range(sent + 5))
    assert recorder.progress == Progress(sent + 5, sent + 5, None)
    assert not recorder.finished
    assert sink.threads == {"recorder"}
    assert "recorder" not in {thread.name for thread in threading.enumerate()}


def test_what_comes_with_the_end_is_taken():
    """Whatever the link delivered before `stop` is in the sink after it, and nothing else."""
    for _ in range(20):
        tap, sink = Tap(), FakeSink()
        recorder = Recorder(tap, sink)
        recorder.start()
        tap.append(frames(3))
        recorder.stop()
        tap.append(frames(3))
        assert numbers(sink.frames) == [0, 1, 2]
        assert sink.durable == 3
        assert tap.take() == []


class BusySink(FakeSink):
    """While it is asked what is durable, ten more frames come and become durable."""

    def __init__(self, tap):
        self._tap, self._durable = tap, 0
        super().__init__()

    @property
    def durable(self):
        if threading.current_thread().name != "recorder":
            meant = self._durable + 10
            self._tap.append(frames(10, self._durable))
            wait_until(lambda: self._durable == meant)
        return self._durable

    @durable.setter
    def durable(self, count):
        self._durable = count


def test_durable_is_never_ahead(tap):
    recorder = Recorder(tap, BusySink(tap))
    recorder.start()
    for count in range(10, 60, 10):
        assert recorder.progress == Progress(count, count, None)
    recorder.stop()


@pytest.mark.parametrize(("seconds", "kept"), [(0.5, 50), (0.501, 51), (0.01, 1), (30.0, 3000)])
def test_so_many_seconds_by_the_ribbons_clock(tap, sink, seconds, kept):
    recorder = Recorder(tap, sink, seconds=seconds)
    recorder.start()
    for start in range(0, kept + 40, 8):
        tap.append(frames(8, start))
    wait_until(lambda: recorder.finished)
    tap.append(frames(8, 9000))
    recorder.stop()
    assert numbers(sink.frames) == list(range(kept))
    assert recorder.progress == Progress(kept, kept, None)


def test_the_seconds_end_where_the_frames_cease(tap, sink, monkeypatch):
    monkeypatch.setattr(module, "_LATE", 0.01)
    recorder = Recorder(tap, sink, seconds=0.05)
    recorder.start()
    tap.append(frames(2))
    wait_until(lambda: recorder.finished)
    recorder.stop()
    assert numbers(sink.frames) == [0, 1]


class Clock:
    """The host's clock, which stands still unless told."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(module, "time", made)
    return made


def turns(sink, count=3):
    """Let the recorder go round."""
    begun = sink.turns
    wait_until(lambda: sink.turns >= begun + count)


def test_the_seconds_do_not_run_before_the_first_frame(tap, sink, clock):
    recorder = Recorder(tap, sink, seconds=3.0)
    recorder.start()
    clock.now += 3.0 + module.FIRST
    turns(sink)
    assert not recorder.finished
    tap.append([replace(frames(1)[0], arrived=clock.now)])
    clock.now += 3.0
    turns(sink)
    assert not recorder.finished
    clock.now += 1.0
    wait_until(lambda: recorder.finished)
    recorder.stop()
    assert len(sink.frames) == 1


def test_a_ribbon_that_never_sends_a_frame_is_not_waited_for_without_end(tap, sink, clock):
    recorder = Recorder(tap, sink, seconds=3.0)
    recorder.start()
    clock.now += 3.0 + module.FIRST
    turns(sink)
    assert not recorder.finished
    clock.now += 0.1
    wait_until(lambda: recorder.finished)
    recorder.stop()
    assert recorder.progress == Progress(0, 0, None)


def test_without_seconds_the_first_frame_is_waited_for_without_end(tap, sink, clock):
    recorder = Recorder(tap, sink)
    recorder.start()
    clock.now += 1e9
    turns(sink)
    assert not recorder.finished
    recorder.stop()


def test_a_full_disk_is_told_once_and_costs_no_frame(tap, sink):
    told = []
    recorder = Recorder(tap, sink, on_storage=told.append)
    recorder.start()
    tap.append(frames(10))
    wait_until(lambda: recorder.progress.durable == 10)
    sink.fault = StorageError("the disk is full")
    for start in range(10, 60, 10):
        tap.append(frames(10, start))
        wait_for(recorder, start + 10, 10)
    assert recorder.progress == Progress(60, 10, "the disk is full")
    sink.fault = StorageError("the disk is gone")
    wait_until(lambda: len(told) == 2)
    sink.fault = None
    wait_until(lambda: recorder.progress == Progress(60, 60, None))
    recorder.stop()
    assert told == ["the disk is full", "the disk is gone", None]
    assert numbers(sink.frames) == list(range(60))


def test_the_end_tries_once_more_whatever_the_pause(tap, sink, monkeypatch):
    monkeypatch.setattr(module, "RETRY", 1e6)
    recorder = Recorder(tap, sink)
    recorder.start()
    sink.fault = StorageError("the disk is full")
    tap.append(frames(3))
    wait_until(lambda: recorder.progress.storage)
    sink.fault = None
    recorder.stop()
    assert recorder.progress == Progress(3, 3, None)


def test_an_end_that_cannot_be_written_is_seen_in_the_counts(tap, sink):
    recorder = Recorder(tap, sink)
    recorder.start()
    sink.fault = StorageError("the disk is full")
    tap.append(frames(3))
    recorder.stop()
    assert recorder.progress == Progress(3, 0, "the disk is full")


def test_a_fault_of_the_program_is_not_swallowed(tap, sink):
    recorder = Recorder(tap, sink)
    sink.fault = ZeroDivisionError("a fault")
    recorder.start()
    wait_until(lambda: recorder.finished)
    with pytest.raises(ZeroDivisionError, match="a fault"):
        recorder.stop()
