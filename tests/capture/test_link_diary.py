"""What a session keeps of the link: every change, every word, every loss."""

from dataclasses import replace

import pytest

from georibbon.capture import link_diary
from georibbon.capture.link_diary import LinkDiary
from georibbon.device.health import Counts
from georibbon.device.telling import Change, Event, LinkState

TIME = "2024-05-01T12:00:00.000+00:00"
STREAMING = Counts().health(LinkState.STREAMING, "frames come")


class FakeLink:
    """A link whose news the test makes up."""

    def __init__(self):
        self.now = STREAMING
        self.tell = {}

    def on_change(self, callback):
        self.tell["change"] = callback

    def on_event(self, callback):
        self.tell["event"] = callback

    def health(self):
        return self.now


@pytest.fixture
def link():
    return FakeLink()


def test_changes_and_events_come_in_order_with_the_figures(link):
    diary = LinkDiary(link)
    link.tell["change"](Change(LinkState.OPENING, "to see who is there", TIME))
    link.tell["event"](Event("message", "battery low", TIME))
    link.tell["change"](Change(LinkState.DISCONNECTED, "the port vanished", TIME))
    link.now = replace(STREAMING, frames=12, stalls=2)
    entries = diary.take()
    told = [(entry["state"], entry["reason"]) for entry in entries]
    assert told == [
        ("opening", "to see who is there"),
        ("streaming", "battery low"),
        ("disconnected", "the port vanished"),
    ]
    assert all((entry["frames"], entry["stalls"]) == (12, 2) for entry in entries)
    assert all(type(entry["state"]) is str for entry in entries)
    assert diary.take() == []


def test_losses_are_told_once(link, monkeypatch):
    monkeypatch.setattr(link_diary, "LOSSES", 0.0)
    diary = LinkDiary(link)
    assert diary.take() == []
    for lost, damaged, words in ((3, 1, "3 packets lost, 1 damaged"), (4, 1, "1 packet lost, 0")):
        link.now = replace(STREAMING, lost=lost, damaged=damaged)
        (entry,) = diary.take()
        assert entry["reason"].startswith(words)
        assert (entry["lost"], entry["damaged"]) == (lost, damaged)
        assert diary.take() == []


def test_losses_are_gathered_and_the_last_ones_not_forgotten(link, monkeypatch):
    monkeypatch.setattr(link_diary, "LOSSES", 1e6)
    diary = LinkDiary(link)
    link.now = replace(STREAMING, lost=1)
    assert len(diary.take()) == 1
    link.now = replace(STREAMING, lost=9)
    assert diary.take() == []
    (entry,) = diary.take(last=True)
    assert entry["reason"] == "8 packets lost, 0 damaged"
    assert diary.take(last=True) == []


def test_what_nobody_takes_is_bounded_and_the_newest_is_kept(link):
    diary = LinkDiary(link)
    for number in range(3 * link_diary.MOST_WAITING):
        link.tell["event"](Event("message", f"word {number}", TIME))
    entries = diary.take()
    assert len(entries) == link_diary.MOST_WAITING
    assert entries[-1]["reason"] == f"word {3 * link_diary.MOST_WAITING - 1}"
    assert diary.take() == []
