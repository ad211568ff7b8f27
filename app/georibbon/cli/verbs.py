"""The words of ``georibbon capture``: a line of text to a verb of the engine."""

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.errors import SettingsError

if TYPE_CHECKING:
    from georibbon.capture.engine import Engine

MARK_SIGMA = DISTANCE_SIGMA = 0.0005
CROSSING_SIGMA = 0.001
TABLES = ("mark", "distance", "crossing")
OWN = ("status", "help", "?", "quit", "exit")  # words that the dialogue answers by itself


def obey(engine: "Engine", line: str) -> None:
    """Do what a line says; raises SettingsError, one sentence, for what it cannot mean."""
    verb, _, rest = line.strip().partition(" ")
    rest = rest.strip()
    if verb in TEXTS:
        TEXTS[verb](engine, rest)
        return
    if verb not in VERBS:
        engine.choose(line.strip())
        return
    try:
        words = shlex.split(rest)
    except ValueError as error:
        raise SettingsError(f"{line.strip()!r} cannot be read: a quotation mark is open") from error
    VERBS[verb](engine, words)


def _none(words: Sequence[str], verb: str) -> None:
    if words:
        raise SettingsError(f"{verb} takes no more words; {' '.join(words)!r} was found")


def _plain(verb: str, act: Callable[["Engine"], object]) -> Callable[["Engine", list[str]], None]:
    """A verb that stands alone."""

    def run(engine: "Engine", words: list[str]) -> None:
        _none(words, verb)
        act(engine)

    return run


def _number(word: str, what: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise SettingsError(f"{what} is {word!r}; a number is expected") from error


def _again(engine: "Engine", words: list[str]) -> None:
    """``redo`` by itself is undo's counterpart, with a name it repeats that pass."""
    if words:
        engine.choose(_one(words, "redo"))
    else:
        engine.redo()


def _one(words: Sequence[str], verb: str) -> str:
    if len(words) != 1:
        raise SettingsError(f"{verb} takes one name; {len(words)} words were found")
    return words[0]


def _add(engine: "Engine", words: list[str]) -> None:
    if len(words) not in (1, 2) or words[1:] not in ([], ["tie"], ["pass"]):
        raise SettingsError("add takes a name, and tie where it is one: add P6, add T3 tie")
    if words[0] in (*VERBS, *TEXTS, *OWN):
        raise SettingsError(f"{words[0]!r} is a word with a meaning of its own; give another name")
    engine.add(words[0], "tie" if words[1:] == ["tie"] else "pass")


def _remove(engine: "Engine", words: list[str]) -> None:
    engine.remove(_one(words, "remove"))


def _mark(engine: "Engine", words: list[str]) -> None:
    if len(words) not in (5, 6):
        raise SettingsError("mark takes PASS AT X Y Z [SIGMA], lengths in metres")
    at, x, y, z, sigma = _numbers([*words[1:], *[str(MARK_SIGMA)][len(words) - 5 :]])
    engine.survey.add("mark", {"pass": words[0], "at": at, "position": [x, y, z], "sigma": sigma})


def _distance(engine: "Engine", words: list[str]) -> None:
    if len(words) not in (5, 6):
        raise SettingsError("distance takes PASS AT PASS AT METRES [SIGMA], lengths in metres")
    given = [words[1], words[3], words[4], *words[5:], *[str(DISTANCE_SIGMA)][len(words) - 5 :]]
    a, b, distance, sigma = _numbers(given)
    passes = [words[0], words[2]]
    entry = {"passes": passes, "at": [a, b], "distance": distance, "sigma": sigma}
    engine.survey.add("distance", entry)


def _crossing(engine: "Engine", words: list[str]) -> None:
    if len(words) not in (4, 5):
        raise SettingsError("crossing takes PASS AT PASS AT [SIGMA], lengths in metres")
    given = [words[1], words[3], *words[4:], *[str(CROSSING_SIGMA)][len(words) - 4 :]]
    a, b, sigma = _numbers(given)
    engine.survey.add("crossing", {"passes": [words[0], words[2]], "at": [a, b], "sigma": sigma})


def _numbers(words: Sequence[str]) -> list[float]:
    return [_number(word, "a length") for word in words]


def _forget(engine: "Engine", words: list[str]) -> None:
    if len(words) != 2 or words[0] not in TABLES or not words[1].isdecimal():
        raise SettingsError(
            "forget takes mark, distance or crossing, and its number: forget mark 2"
        )
    engine.survey.remove(words[0], int(words[1][:9]))


def _auto(engine: "Engine", words: list[str]) -> None:
    if words not in (["on"], ["off"]):
        raise SettingsError("auto takes on or off")
    engine.auto = words == ["on"]


def _note(engine: "Engine", text: str) -> None:
    if not text:
        raise SettingsError("note takes the text of the note")
    engine.note(text)


def _save(engine: "Engine", text: str) -> None:
    if not text:
        engine.save_again()
        return
    try:
        place = Path(text).expanduser()
    except RuntimeError as error:
        raise SettingsError(f"{text!r} begins with a home folder that is not known") from error
    if not text.isprintable() or place.suffix.lower() != ".georibbon":
        raise SettingsError(f"{text!r} is no session's name; give one that ends with .georibbon")
    engine.save_to(place)


VERBS: dict[str, Callable[["Engine", list[str]], None]] = {
    "": _plain("take", lambda engine: engine.take()),
    "take": _plain("take", lambda engine: engine.take()),
    "force": _plain("force", lambda engine: engine.take(force=True)),
    "skip": _plain("skip", lambda engine: engine.skip()),
    "undo": _plain("undo", lambda engine: engine.undo()),
    "redo": _again,
    "calibrate": _plain("calibrate", lambda engine: engine.calibrate()),
    "add": _add,
    "remove": _remove,
    "mark": _mark,
    "distance": _distance,
    "crossing": _crossing,
    "forget": _forget,
    "auto": _auto,
}
# Verbs whose rest is one text as it stands.
TEXTS: dict[str, Callable[["Engine", str], None]] = {"note": _note, "save": _save}
