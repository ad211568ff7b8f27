"""The one thread that writes: in order, soon, and whatever happens."""

import threading

import pytest

from georibbon.errors import SessionError
from georibbon.session import writer as module
from georibbon.session.writer import Writer
from waiting import wait_until


def test_calls_are_run_in_their_order_on_one_thread():
    writer, seen = Writer(lambda: None), []
    threads = {writer.call(threading.current_thread) for _ in range(3)}
    for k in range(5):
        writer.call(lambda k=k: seen.append(k))
    assert seen == [0, 1, 2, 3, 4]
    assert len(threads) == 1
    assert threading.current_thread() not in threads
    assert writer.call(lambda: writer.call(lambda: 7)) == 7
    writer.stop()
    with pytest.raises(SessionError, match="closed"):
        writer.call(lambda: 7)
    assert not threads.pop().is_alive()


def test_what_a_call_raises_comes_to_who_asked_and_ends_nothing():
    def fail():
        raise ZeroDivisionError

    writer = Writer(lambda: None)
    with pytest.raises(ZeroDivisionError):
        writer.call(fail)
    assert writer.call(lambda: 7) == 7
    writer.stop()


def test_many_pokes_are_one_tick_and_a_poke_during_it_another(monkeypatch):
    monkeypatch.setattr(module, "INTERVAL", 0.05)
    ticks = []

    def tick():
        ticks.append(None)
        if len(ticks) == 1:
            writer.poke()

    writer = Writer(tick)
    for _ in range(100):
        writer.poke()
    wait_until(lambda: len(ticks) == 2)
    writer.stop()
    assert len(ticks) == 2


def test_a_tick_may_ask_for_another():
    again = [0.01, 0.01, None]
    writer = Writer(lambda: again.pop(0))
    writer.poke()
    wait_until(lambda: not again)
    writer.stop()


def test_a_fault_of_the_program_is_shown_and_the_writing_goes_on(monkeypatch):
    monkeypatch.setattr(module, "AFTER_FAULT", 0.01)
    shown, ticks = [], []
    monkeypatch.setattr(threading, "excepthook", lambda found: shown.append(found.exc_type))

    def tick():
        ticks.append(None)
        if len(ticks) == 1:
            raise ZeroDivisionError

    writer = Writer(tick)
    writer.poke()
    wait_until(lambda: len(ticks) == 2)
    assert writer.call(lambda: 7) == 7
    writer.stop()
    assert shown == [ZeroDivisionError]
