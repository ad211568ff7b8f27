"""Recognises sentences by their patterns and puts them into another language.

A pattern is a sentence with {0}, {1}, ... for what differs.  What stands in a slot may
be a sentence itself, or several that are joined.  Of all readings of a text the one is
taken that leaves the fewest words of it as they are.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

LONGEST = 2000  # characters; a longer text is left as it is
DEEPEST = 6  # sentences within sentences
MOST_READINGS = 60  # texts looked at for one sentence, whatever it is made of
TELLING = 16  # literal letters that tell of which pattern a text is, whatever stands in its slots
BEGINNING = 4  # characters at its beginning that tell it too
JOINT = 10  # letters that a "; " between two sentences weighs
QUOTES = ("[", '"', "'", "`")  # what stands behind one is a name
BEFORE, AFTER = -1, -2  # slots at the open ends of a fragment
_SLOTS = re.compile(r"((?:\{\d+\})+)")
_SLOT = re.compile(r"\{(\d+)\}")
_COUNT = re.compile(r"\{0\} [a-z]+")
_NUMBER = re.compile(r"[-+]?\d[\d.,]*")
_LETTER = re.compile(r"[^\W\d_]")
_WORD = re.compile(r"(?<![\w./\\-])[a-z][a-z']+(?![\w./\\])")


@dataclass(frozen=True)
class Pattern:
    """A sentence's literal texts with a slot between each two, and its translation.

    slots: the numbers in each slot; slots that stand side by side are one.
    weight: the letters of its literal texts.  counts: it is a number with a word, such
    as "{0} frames".
    """

    literals: tuple[str, ...]
    slots: tuple[tuple[int, ...], ...]
    translation: str
    weight: int
    counts: bool

    def fillings(self, text: str) -> tuple[str, ...] | None:
        """What stands in the slots, the earlier ones as short as can be; None: another text."""
        literals = self.literals
        if not text.startswith(literals[0]) or not text.endswith(literals[-1]):
            return None
        at, end = len(literals[0]), len(text) - len(literals[-1])
        found = []
        for literal in literals[1:-1]:
            here = text.find(literal, at, end)
            if here < 0:
                return None
            found.append(text[at:here])
            at = here + len(literal)
        if at > end or (self.counts and not _NUMBER.fullmatch(text[at:end])):
            return None
        return *found, text[at:end]

    def filled(self, fillings: Mapping[int, str]) -> str:
        """The translation with what stands in its slots."""
        inside = _SLOT.sub(lambda slot: fillings.get(int(slot[1]), ""), self.translation)
        return fillings.get(BEFORE, "") + inside + fillings.get(AFTER, "")


class Recogniser:
    """All patterns of a language: whole sentences by themselves, others the most telling first."""

    def __init__(self, translations: Mapping[str, str]) -> None:
        """translations: from English, both with {0}, {1}, ... for what differs."""
        self.whole = {one: other for one, other in translations.items() if not _SLOT.search(one)}
        found = [pattern(one, other) for one, other in translations.items()]
        self.patterns = sorted(
            (one for one in found if one.slots), key=lambda one: -one.weight
        )  # fmt: skip

    def translated(self, text: str) -> str:
        """The text in the other language; as it is where no pattern is its own."""
        if len(text) > LONGEST:
            return text
        return _Reading(self).of(text, 0)[1]


def pattern(english: str, translation: str) -> Pattern:
    """The pattern of a sentence; one that begins or ends as a part of another is open there."""
    parts = _SLOTS.split(english)
    literals = parts[::2]
    slots = [tuple(map(int, _SLOT.findall(part))) for part in parts[1::2]]
    if english[:1] in " ,;:":
        literals, slots = ["", *literals], [(BEFORE,), *slots]
    if english[-1:] == " ":
        literals, slots = [*literals, ""], [*slots, (AFTER,)]
    weight = sum(JOINT if one == "; " else len(_LETTER.findall(one)) for one in literals)
    return Pattern(
        tuple(literals), tuple(slots), translation, weight, bool(_COUNT.fullmatch(english))
    )


def words_in(text: str) -> int:
    """How many letters of a text are in words; a name, a number or a path has none."""
    return sum(map(len, _WORD.findall(text))) if " " in text else 0


class _Reading:
    """The readings of one sentence: every text in it is looked at once."""

    def __init__(self, recogniser: Recogniser) -> None:
        self.of_all = recogniser
        self.known: dict[str, tuple[int, str]] = {}

    def of(self, text: str, depth: int) -> tuple[int, str]:
        """The letters of words that stay as they are, and the text in the other language."""
        whole = self.of_all.whole.get(text)
        if whole is not None:
            return 0, whole
        if text not in self.known:
            left = words_in(text)
            if left == 0 or depth > DEEPEST or len(self.known) >= MOST_READINGS:
                return left, text
            self.known[text] = left, text  # for a text that leads to itself
            self.known[text] = self._best(text, depth)
        return self.known[text]

    def _best(self, text: str, depth: int) -> tuple[int, str]:
        words = words_in(text)
        best = words, text
        for one in self.of_all.patterns:
            fillings = one.fillings(text)
            if fillings is None or text in fillings:
                continue
            left, translated = self._filled(one, fillings, depth)
            own = 2 * left <= words or one.weight >= TELLING or len(one.literals[0]) > BEGINNING
            if left < best[0] and own:
                best = left, translated
            if 4 * best[0] <= words:
                break
        return best

    def _filled(self, one: Pattern, fillings: tuple[str, ...], depth: int) -> tuple[int, str]:
        left, texts = 0, {}
        for before, numbers, filling in zip(one.literals, one.slots, fillings, strict=False):
            if before.endswith(QUOTES):
                texts[numbers[0]] = filling
            else:
                more, texts[numbers[0]] = self.of(filling, depth + 1)
                left += more
        return left, one.filled(texts)
