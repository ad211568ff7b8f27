"""Sentences of the core are recognised by their patterns, and texts by themselves."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as some

from georibbon.gui import language


@pytest.fixture
def spoken(monkeypatch):
    """A language of two sentences."""
    translations = {
        "{0} is not taken: {1}": "{0} n'est pas pris : {1}",
        "{0} is not taken: still for {1} s": "{0} n'est pas pris : immobile {1} s",
        "hold the ribbon still": "tenez le ruban immobile",
        "{0} of {1}": "de {1}, {0}",
    }
    monkeypatch.setattr(language, "_patterns", language.patterns(translations))
    language._translated.cache_clear()
    yield
    language._translated.cache_clear()


@pytest.mark.usefixtures("spoken")
@pytest.mark.parametrize(
    ("english", "french"),
    [
        ("P1 is not taken: hold the ribbon still", "P1 n'est pas pris : tenez le ruban immobile"),
        ("P1 is not taken: still for 0.4 s", "P1 n'est pas pris : immobile 0.4 s"),
        ("P1 is not taken: other", "P1 n'est pas pris : other"),
        ("3 of 5", "de 5, 3"),
        ("something else", "something else"),
        ("", ""),
    ],
)
def test_a_sentence_is_recognised_with_what_is_in_it(english, french):
    assert language.sentence(english) == french


@given(some.text(max_size=60), some.text(max_size=60))
def test_what_fills_a_sentence_comes_through_as_it_is(one, other):
    ((recogniser, _),) = language.patterns({"<{0}|{1}>": "{1}{0}"})
    found = recogniser.fullmatch(f"<{one}|{other}>")
    if one and other:
        assert f"{found['slot0']}|{found['slot1']}" == f"{one}|{other}"


def test_in_english_nothing_is_changed():
    language.use("en")
    assert language.sentence("hold the ribbon still") == "hold the ribbon still"


def test_french_is_taken_up_and_left_again():
    language.use("fr")
    french = language.tr("&Quit")
    language.use("en")
    assert language.tr("&Quit") == "&Quit"
    assert french  # whatever it is, it is not nothing
    kept = language.resource("translations") / "fr" / "sentences.json"
    assert isinstance(json.loads(kept.read_text(encoding="utf-8")), dict)
