"""Lines from standard input: through a pipe as they are, on a terminal key by key."""

import itertools
import os
import pty
import termios
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.cli.keyboard import MOST_READ, Words, key_by_key, keys_of


def piped(*blocks):
    words = Words()
    for block in blocks:
        words.feed(block)
    return words.take()


def typed(*blocks):
    """What a terminal's keys come to: the lines, and what is still being typed."""
    words = Words()
    words.on_keys = True
    for block in blocks:
        words.feed(block)
    return words.take(), words.typed


@given(st.lists(st.binary(max_size=8), max_size=8))
def test_how_the_bytes_are_cut_matters_nothing(blocks):
    assert piped(*blocks) == piped(b"".join(blocks))


def test_a_pipe_gives_lines_as_they_are():
    assert piped(b"undo\n\nno", b"te  a \x7f b\nrest") == ["undo", "", "note  a \x7f b"]


@pytest.mark.parametrize(
    ("keys", "lines", "rest"),
    [
        (b"undo\n", ["undo"], ""),
        (b"undo\r", ["undo"], ""),
        (b" ", [""], ""),
        (b"\x1b[6~", [""], ""),
        (b"note a b\n", ["note a b"], ""),
        (b"note\x1b[A\x1b[6~\x1bOPx", [], "notex"),
        (b"\x1bundo\n", ["undo"], ""),
        (b"remove P1\x04", [], "remove P1"),
        (b"\x04", ["quit"], ""),
        (b"sat\x7f\x7ftatus\n", ["status"], ""),
        ("nö\x7fote\n".encode(), ["note"], ""),
        (b"rubbish\x15P1", [], "P1"),
        (b"\x7f\x7fP1\n", ["P1"], ""),
    ],
)
def test_keys_make_and_mend_a_line(keys, lines, rest):
    assert typed(keys) == (lines, rest)


KEYS = st.sampled_from([b"a", b" ", b"\n", b"\x7f", b"\x15", b"\x1b[6~", b"\x1bOP", b"\x1b[1;5A"])


@given(st.lists(KEYS, max_size=8), st.lists(st.integers(0, 40), max_size=4))
def test_how_keys_are_cut_matters_nothing(keys, cuts):
    data = b"".join(keys)
    ends = sorted({min(cut, len(data)) for cut in cuts} | {0, len(data)})
    blocks = [data[a:b] for a, b in itertools.pairwise(ends)]
    assert typed(*blocks) == typed(data)


@given(st.binary(max_size=80))
def test_keys_are_all_the_bytes(data):
    keys, rest = keys_of(data)
    assert b"".join(keys) + rest == data
    assert len(rest) <= 32


def test_a_line_without_end_is_bounded():
    words = Words()
    words.feed(b"x" * 200_000)
    words.feed(b"\n")
    assert len(words.take()[0]) <= MOST_READ


@given(st.binary(max_size=40))
def test_any_keys_are_taken(data):
    lines, rest = typed(data)
    assert all("\n" not in line for line in [*lines, rest])


def test_a_terminal_is_given_back_as_it_was():
    here, there = pty.openpty()
    try:
        before = termios.tcgetattr(there)
        restore = key_by_key(termios, there)
        assert not termios.tcgetattr(there)[3] & (termios.ICANON | termios.ECHO)
        restore()
        assert termios.tcgetattr(there) == before
    finally:
        os.close(here)
        os.close(there)


def test_lines_come_from_the_descriptor(monkeypatch):
    reading, writing = os.pipe()
    with os.fdopen(reading) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        words = Words()
        words.start()
        os.write(writing, b"status\nlast")
        os.close(writing)
        deadline = threading.Event()
        for _ in range(1000):
            if words.ended:
                break
            deadline.wait(0.01)
        assert words.take() == ["status", "last"]
        words.stop()


def test_without_standard_input_there_are_no_words(monkeypatch):
    monkeypatch.setattr("sys.stdin", None)
    words = Words()
    words.start()
    assert words.ended
