"""Sentences of the core are recognised by their patterns, and texts by themselves."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as some

from georibbon.gui import language
from georibbon.gui.patterns import LONGEST, Recogniser, pattern

SPOKEN = Recogniser(
    {
        "{0} is not taken: {1}": "{0} n'est pas pris : {1}",
        "{0} is not taken: still for {1} s": "{0} n'est pas pris : immobile {1} s",
        "hold the ribbon still": "tenez le ruban immobile",
        "{0} of {1}": "de {1}, {0}",
        "{0}; {1}": "{0} ; {1}",
        "there is no pass {0}{1}": "il n'y a pas de passe {0}{1}",
        '; did you mean "{0}"?': " ; vouliez-vous dire « {0} » ?",
        "; the passes are ": " ; les passes sont ",
        "{0} and {1}": "{0} et {1}",
        "{0} frames": "{0} trames",
        "[[{0}]] is missing": "[[{0}]] manque",
        "mark": "repère",
        "{0} lie at {1}": "{1} : {0} y sont",
    }
)


@pytest.fixture
def french():
    """The language of the catalogues, and English again afterwards."""
    language.use("fr")
    yield
    language.use("en")


@pytest.mark.parametrize(
    ("english", "french"),
    [
        ("P1 is not taken: hold the ribbon still", "P1 n'est pas pris : tenez le ruban immobile"),
        ("P1 is not taken: still for 0.4 s", "P1 n'est pas pris : immobile 0.4 s"),
        ("P1 is not taken: other", "P1 n'est pas pris : other"),
        ("3 of 5", "de 5, 3"),
        ("something else", "something else"),
        ("", ""),
        ("hold the ribbon still; 3 of 5", "tenez le ruban immobile ; de 5, 3"),
        ("there is no pass P9", "il n'y a pas de passe P9"),
        ('there is no pass P9; did you mean "P2"?',
         "il n'y a pas de passe P9 ; vouliez-vous dire « P2 » ?"),
        ("there is no pass P9; the passes are P1 and P2",
         "il n'y a pas de passe P9 ; les passes sont P1 et P2"),
        ("12 frames", "12 trames"),
        ("many other frames", "many other frames"),
        ("something entirely different of 5", "something entirely different of 5"),
        ("[[mark]] is missing", "[[mark]] manque"),
        ("mark is not taken: 3 frames", "repère n'est pas pris : 3 trames"),
    ],
)  # fmt: skip
def test_a_sentence_is_recognised_with_what_is_in_it(english, french):
    assert SPOKEN.translated(english) == french


@given(some.text(max_size=60), some.text(max_size=60))
def test_what_fills_a_sentence_comes_through_as_it_is(one, other):
    found = pattern("<{0}|{1}>", "{1}{0}").fillings(f"<{one}|{other}>")
    assert found is not None
    assert "|".join(found) == f"{one}|{other}"
    assert "|" not in found[0]


@given(some.text(alphabet="ab |:;", max_size=200))
def test_a_reading_ends_and_loses_nothing_of_what_it_does_not_know(text):
    assert Recogniser({}).translated(text) == text
    assert Recogniser({"{0}: {1}": "{0} : {1}", "a {0}": "b {0}"}).translated(text) is not None


@pytest.mark.parametrize("piece", ["a: b; ", " and ", "x of y; ", "is not taken: ", "(", "of "])
def test_long_texts_are_left_and_others_end(piece):
    hostile = piece * (LONGEST // len(piece))
    assert isinstance(SPOKEN.translated(hostile), str)
    assert SPOKEN.translated(hostile + "." * LONGEST) == hostile + "." * LONGEST


@pytest.mark.usefixtures("french")
@pytest.mark.parametrize(
    ("english", "said"),
    [
        ("P1 is not taken: the ribbon moves: A01 and A02 by 12 times the noise; hold the ribbon "
         "still",
         "P1 n'est pas prise : le ruban bouge : A01 et A02 de 12 fois le bruit ; tenez le ruban "
         "immobile"),
        ("the sensors miss the curve by 3.1 of their standard deviations; press the ribbon down "
         "along its whole length",
         "les capteurs manquent la courbe de 3.1 de leurs écarts types ; appuyez le ruban sur "
         "toute sa longueur"),
        ("M03 is off by 12 % in strength and 3° in direction from what its neighbours tell: look "
         "for a magnet or iron there",
         "M03 est faux de 12 % en intensité et 3° en direction par rapport à ce que disent ses "
         "voisins : cherchez là un aimant ou du fer"),
        ("the field is 4.8 % weaker and 1.7° flatter than when the ribbon was calibrated (2% and "
         "3° are allowed): the place is disturbed or the ribbon has changed; check in the place "
         "where it was calibrated, away from steel and currents, or calibrate here",
         "le champ est 4.8 % plus faible et 1.7° moins incliné qu'à l'étalonnage du ruban (2% et "
         "3° sont admis) : le lieu est perturbé ou le ruban a changé ; contrôlez au lieu de "
         "l'étalonnage, loin de l'acier et des courants, ou étalonnez ici"),
        ("s.georibbon: the session cannot be written (No space left on device)",
         "s.georibbon : la session ne peut pas être écrite (Plus de place sur le disque)"),
        ("the removal of pass P3", "suppression (passe P3)"),
        ("the smoothing of pass P2", "lissage (passe P2)"),
    ],
)  # fmt: skip
def test_sentences_of_the_core_come_through_whole(english, said):
    assert language.sentence(english).replace("\N{NO-BREAK SPACE}", " ") == said


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
