"""The words of a capture: each line reaches the engine as the verb that it means."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.cli.verbs import obey
from georibbon.errors import SettingsError


class Engine:
    """Writes down what it is asked to do."""

    def __init__(self):
        self.did = []
        self.auto = True

    @property
    def survey(self):
        return Desk(self.did)

    def __getattr__(self, verb):
        return lambda *words, **named: self.did.append((verb, *words, *named.items()))


class Desk:
    """Writes down what the survey is asked."""

    def __init__(self, did):
        self.did = did

    def add(self, table, entry):
        self.did.append(("survey", table, entry))

    def remove(self, table, number):
        self.did.append(("forget", table, number))


def done(line):
    engine = Engine()
    obey(engine, line)
    return engine.did


@pytest.mark.parametrize(
    ("line", "did"),
    [
        ("", ("take",)),
        ("  ", ("take",)),
        ("take", ("take",)),
        ("force", ("take", ("force", True))),
        ("skip", ("skip",)),
        ("undo", ("undo",)),
        ("redo", ("redo",)),
        ("redo P3", ("choose", "P3")),
        ("P3", ("choose", "P3")),
        ("left side", ("choose", "left side")),
        (" pose-07 ", ("choose", "pose-07")),
        ("add P6", ("add", "P6", "pass")),
        ("add T3 tie", ("add", "T3", "tie")),
        ("add 'left side'", ("add", "left side", "pass")),
        ("remove P2", ("remove", "P2")),
        ("calibrate", ("calibrate",)),
        ('note it\'s "all" fine', ("note", 'it\'s "all" fine')),
        ("save", ("save_again",)),
        ("save some/a b.georibbon", ("save_to", Path("some/a b.georibbon"))),
        ("forget mark 2", ("forget", "mark", 2)),
    ],
)
def test_a_line_is_a_verb(line, did):
    assert done(line) == [did]


@pytest.mark.parametrize(("word", "auto"), [("on", True), ("off", False)])
def test_taking_by_stillness_can_be_switched(word, auto):
    engine = Engine()
    obey(engine, f"auto {word}")
    assert engine.auto is auto


@pytest.mark.parametrize(("words", "sigma"), [("", 0.0005), (" 0.002", 0.002)])
def test_a_mark_has_a_place_and_a_sigma(words, sigma):
    entry = {"pass": "P1", "at": 0.1, "position": [0.02, -0.2, 0.013], "sigma": sigma}
    assert done(f"mark P1 0.1 0.02 -0.2 0.013{words}") == [("survey", "mark", entry)]


@pytest.mark.parametrize(("words", "sigma"), [("", 0.0005), (" 0.002", 0.002)])
def test_a_distance_is_between_two_points(words, sigma):
    entry = {"passes": ["P1", "P2"], "at": [0.0, 0.1], "distance": 0.12, "sigma": sigma}
    assert done(f"distance P1 0 P2 0.1 0.12{words}") == [("survey", "distance", entry)]


@pytest.mark.parametrize(("words", "sigma"), [("", 0.001), (" 0.002", 0.002)])
def test_a_crossing_has_two_places(words, sigma):
    entry = {"passes": ["P1", "T1"], "at": [0.3, 0.1], "sigma": sigma}
    assert done(f"crossing P1 0.3 T1 0.1{words}") == [("survey", "crossing", entry)]


@pytest.mark.parametrize(
    "line",
    [
        "add", "add a b c", "add P6 surface", "remove", "remove a b", "mark",
        "mark P1 0 0 0", "mark P1 x 0 0 0", "distance P1 0 P2 0", "crossing P1 0 T1",
        "crossing P1 0 T1 y", "forget", "forget mark two", "forget note 1", "auto", "auto maybe",
        "note", "skip now", "undo 3", "add 'open", "add skip", "add quit", "save x.csv",
        "save ~nobody-of-this-name/x.georibbon", "save a\0b.georibbon",
    ],
)  # fmt: skip
def test_what_means_nothing_is_refused(line):
    with pytest.raises(SettingsError):
        done(line)


@given(st.text(max_size=60))
def test_any_text_is_a_verb_or_refused(line):
    engine = Engine()
    try:
        obey(engine, line)
    except SettingsError:
        assert engine.did == []
