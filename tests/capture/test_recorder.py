"""The recorder: every frame of the link gets to the sink, in order, and is counted."""

import threading
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
import pytest

from georibbon.capture import recorder as module
from georibbon.capture.recorder import Progress, Recorder
from georibbon.device.frames import Frame
from georibbon.errors import StorageError


def frames(count, start=0, rate=100.0):
    return [
        Frame(3.0 + i / rate, np.array([i], dtype=np.int16), time.monotonic())
        for i in range(start, start + count)
    ]


@dataclass(frozen=True)
class FakeHealth:
    state: str = "streaming"
    reason: str = "as it should"
    lost: int = 0
    damaged: int = 0


@dataclass(frozen=True)
class FakeChange:
    state: str
    reason: str


class FakeLink:
    """A link whose frames and changes the test makes up."""

    def __init__(self):
        self.queue = deque()
        self.now = FakeHealth()
        self.tell = None

    def recorder(self):
        return self

    def take(self):
        return [self.queue.popleft() for _ in range(len(self.queue))]

    def on_change(self, callback):
        self.tell = callback

    def health(self):
        return self.now


class FakeSink:
    """Keeps what it gets in a list; `fault` makes it fail."""

    def __init__(self):
        self.frames, self.events, self.threads = [], [], set()
        self.durable = 0
        self.fault = None

    def append(self, taken):
        self.frames += taken
        self.threads.add(threading.current_thread().name)

    def note(self, event):
        self.events.append(event)

    def sync(self):
        if self.fault is not None:
            raise self.fault
        self.durable = len(self.frames)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    for name in ("PERIOD", "RETRY", "LOSSES"):
        monkeypatch.setattr(module, name, 0.01)


@pytest.fixture
def link():
    return FakeLink()


@pytest.fixture
def sink():
    return FakeSink()


def wait_until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.002)


def wait_for(recorder, frames, durable):
    wait_until(lambda: recorder.progress.frames == frames and recorder.progress.durable == durable)


def numbers(taken):
    return [int(frame.counts[0]) for frame in taken]


def test_every_frame_gets_to_the_sink_in_order(link, sink):
    recorder = Recorder(link)
    link.queue.extend(frames(7))  # before it is known where they go
    assert recorder.progress == Progress(0, 0, None)
    recorder.start(sink)
    sent = 7
    for count in (7, 0, 1, 30, 400):
        link.queue.extend(frames(count, sent))
        sent += count
        wait_for(recorder, sent, sent)
    link.queue.extend(frames(5, sent))
    recorder.stop()
    assert numbers(sink.frames) == list(range(sent + 5))
    assert recorder.progress == Progress(sent + 5, sent + 5, None)
    assert not recorder.finished
    assert sink.threads == {"georibbon-recorder"}
    assert "georibbon-recorder" not in {thread.name for thread in threading.enumerate()}


def test_what_comes_with_the_end_is_taken(link):
    """Whatever the link delivered before `stop` is in the sink after it."""
    for _ in range(20):
        recorder, there = Recorder(link), FakeSink()
        recorder.start(there)
        link.queue.extend(frames(3))
        recorder.stop()
        assert numbers(there.frames) == [0, 1, 2]
        assert there.durable == 3


def test_stopped_before_it_was_started(link):
    recorder = Recorder(link)
    recorder.stop()
    assert recorder.progress == Progress(0, 0, None)


def test_durable_is_never_ahead(link, sink):
    recorder = Recorder(link)
    recorder.start(sink)
    for start in range(0, 3000, 10):
        link.queue.extend(frames(10, start))
        progress = recorder.progress
        assert progress.durable <= progress.frames
    recorder.stop()
    assert recorder.progress == Progress(3000, 3000, None)


@pytest.mark.parametrize(("seconds", "kept"), [(0.5, 50), (0.501, 51), (0.01, 1), (30.0, 3000)])
def test_so_many_seconds_by_the_ribbons_clock(link, sink, seconds, kept):
    recorder = Recorder(link, seconds=seconds)
    recorder.start(sink)
    for start in range(0, kept + 40, 8):
        link.queue.extend(frames(8, start))
    wait_until(lambda: recorder.finished)
    link.queue.extend(frames(8, 9000))
    recorder.stop()
    assert numbers(sink.frames) == list(range(kept))
    assert recorder.progress == Progress(kept, kept, None)


def test_the_seconds_end_where_the_frames_cease(link, sink, monkeypatch):
    monkeypatch.setattr(module, "_LATE", 0.01)
    recorder = Recorder(link, seconds=0.05)
    recorder.start(sink)
    link.queue.extend(frames(2))
    wait_until(lambda: recorder.finished)
    recorder.stop()
    assert numbers(sink.frames) == [0, 1]


def test_the_seconds_do_not_run_before_the_first_frame(link, sink, monkeypatch):
    monkeypatch.setattr(module, "_LATE", 0.0)
    recorder = Recorder(link, seconds=0.02)
    recorder.start(sink)
    waited = time.monotonic() + 0.1
    wait_until(lambda: time.monotonic() > waited)
    assert not recorder.finished
    link.queue.extend(frames(1))
    wait_until(lambda: recorder.finished)
    recorder.stop()
    assert len(sink.frames) == 1


def test_a_full_disk_is_told_once_and_costs_no_frame(link, sink):
    told = []
    recorder = Recorder(link, on_storage=told.append)
    recorder.start(sink)
    link.queue.extend(frames(10))
    wait_until(lambda: recorder.progress.durable == 10)
    sink.fault = StorageError("the disk is full")
    for start in range(10, 60, 10):
        link.queue.extend(frames(10, start))
        wait_for(recorder, start + 10, 10)
    assert recorder.progress == Progress(60, 10, "the disk is full")
    sink.fault = StorageError("the disk is gone")
    wait_until(lambda: len(told) == 2)
    sink.fault = None
    wait_until(lambda: recorder.progress == Progress(60, 60, None))
    recorder.stop()
    assert told == ["the disk is full", "the disk is gone", None]
    assert numbers(sink.frames) == list(range(60))


def test_the_end_tries_once_more_whatever_the_pause(link, sink, monkeypatch):
    monkeypatch.setattr(module, "RETRY", 1e6)
    recorder = Recorder(link)
    recorder.start(sink)
    sink.fault = StorageError("the disk is full")
    link.queue.extend(frames(3))
    wait_until(lambda: recorder.progress.storage)
    sink.fault = None
    recorder.stop()
    assert recorder.progress == Progress(3, 3, None)


def test_an_end_that_cannot_be_written_is_seen_in_the_counts(link, sink):
    recorder = Recorder(link)
    recorder.start(sink)
    sink.fault = StorageError("the disk is full")
    link.queue.extend(frames(3))
    recorder.stop()
    assert recorder.progress == Progress(3, 0, "the disk is full")


def test_a_fault_of_the_program_is_not_swallowed(link, sink):
    recorder = Recorder(link)
    sink.fault = ZeroDivisionError("a fault")
    recorder.start(sink)
    wait_until(lambda: recorder.finished)
    with pytest.raises(ZeroDivisionError, match="a fault"):
        recorder.stop()


def test_changes_of_the_link_are_noted_with_its_health(link, sink):
    recorder = Recorder(link)
    link.tell(FakeChange("opening", "to see what is there"))  # before there is a sink
    recorder.start(sink)
    wait_until(lambda: len(sink.events) == 1)
    link.now = FakeHealth("disconnected", "unplugged", lost=0)
    link.tell(FakeChange("disconnected", "unplugged"))
    wait_until(lambda: len(sink.events) == 2)
    recorder.stop()
    assert [(event["state"], event["reason"]) for event in sink.events] == [
        ("opening", "to see what is there"),
        ("disconnected", "unplugged"),
    ]
    assert sink.events[1]["damaged"] == 0


def test_losses_are_noted_once(link, sink):
    recorder = Recorder(link)
    recorder.start(sink)
    link.now = FakeHealth(lost=3, damaged=1)
    wait_until(lambda: len(sink.events) == 1)
    link.now = FakeHealth(lost=4, damaged=1)
    wait_until(lambda: len(sink.events) == 2)
    recorder.stop()
    assert [event["reason"] for event in sink.events] == [
        "3 packets lost and 1 damaged",
        "1 packet lost and 0 damaged",
    ]
    assert [event["lost"] for event in sink.events] == [3, 4]


def test_the_last_losses_are_noted_at_the_end(link, sink, monkeypatch):
    monkeypatch.setattr(module, "LOSSES", 1e6)
    recorder = Recorder(link)
    recorder.start(sink)
    link.now = FakeHealth(lost=1)
    wait_until(lambda: sink.events)
    link.now = FakeHealth(lost=9)
    recorder.stop()
    assert [event["lost"] for event in sink.events] == [1, 9]
