"""How values, names and numbers of things are told to a person."""

import difflib
import unicodedata
from collections.abc import Iterable, Mapping

_LONGEST_WORD = 200  # beyond it no near word is looked for: that takes time with the square


def shown(text: str) -> str:
    """A text as a terminal may show it: its lines, with "?" for what would steer the terminal.

    That is every control and format character but line feed and tab.  The bytes of
    a file name that are no text stay, as Python stands for them.
    """
    if text.isascii() and text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join("?" if hidden(character) else character for character in text)


def hidden(character: str) -> bool:
    """Whether a character is one that steers a terminal or hides in a text."""
    return character not in "\n\t" and unicodedata.category(character) in ("Cc", "Cf", "Zl", "Zp")


def told(value: object) -> str:
    """A value as a person wrote it, short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a table"
    try:
        text = f'"{value}"' if isinstance(value, str) else str(value)
    except ValueError:  # Python writes out no integer of more than 4300 digits
        return "a number of thousands of digits"
    text = "".join(c if c.isprintable() else "?" for c in text[:80])
    return text if len(text) < 60 else text[:57] + "..."


def nearest(word: str, known: Iterable[str]) -> str:
    """', did you mean "…"?' where a known word is near, else nothing."""
    close = difflib.get_close_matches(word[:_LONGEST_WORD], list(known), n=1, cutoff=0.6)
    return f'; did you mean "{close[0]}"?' if close else ""


def counted(count: int, one: str, many: str | None = None) -> str:
    """Such as "1 pose" or "16 poses"."""
    return f"{count} {one if count == 1 else many or one + 's'}"
