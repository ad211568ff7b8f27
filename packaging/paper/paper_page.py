"""The manual's page about the source paper's figures, in each language, from computed figures."""

import re
from collections.abc import Mapping, Sequence

from paper_words import FIGURES_FR, FRAMES, LEGEND, PHRASES_FR, SHORT_FR, WHOSE, Words

from georibbon.export.paper.pictures import SHORT, told_number
from georibbon.paper_figures import Choice, Figure

LANGUAGES = tuple(FRAMES)
_POINT = re.compile(r"(?<=\d)\.(?=\d)")


def page(figures: Sequence[Figure], language: str) -> str:
    """The page's Markdown."""
    frame = FRAMES[language]
    parts = [f"# {frame.title}", frame.beginning, LEGEND[language]]
    return "\n\n".join([*parts, *(section(figure, language) for figure in figures)]) + "\n"


def section(figure: Figure, language: str) -> str:
    """One figure's Markdown."""
    frame, words = FRAMES[language], _words(figure, language)
    rows = [_row(choice, figure.main, language) for choice in figure.choices]
    return "\n\n".join(
        [
            f"## {frame.figure.format(figure.number, words.title)}",
            frame.given.format(words.situation),
            frame.shows.format(words.shows),
            f"![{words.title}](pictures/{picture_name(figure.number)}.png)",
            "\n".join([frame.head, "|---|---|---|---|", *rows]),
            frame.found.format(words.found),
        ]
    )


def picture_name(number: int) -> str:
    """The name of a figure's picture in the manual."""
    return f"paper-{number:02d}"


def _words(figure: Figure, language: str) -> Words:
    if language == "fr":
        return FIGURES_FR[figure.number]
    return Words(figure.title, figure.situation, figure.shows, figure.found)


def _row(choice: Choice, main: Sequence[str], language: str) -> str:
    short: Mapping[str, str] = SHORT_FR if language == "fr" else SHORT
    numbers = ", ".join(short[key].format(told_number(choice.numbers[key])) for key in main)
    if language == "fr":
        numbers = numbers.replace(", ", " ; ")
    verdict = ", ".join(_said(word, language) for word in choice.verdict.split(", "))
    cells = [WHOSE[language][choice.whose], _said(choice.name, language), verdict, numbers]
    row = f"| {' | '.join(cells)} |"
    return _POINT.sub(",", row) if language == "fr" else row


def _said(phrase: str, language: str) -> str:
    """A name or a verdict; formulas are the same in every language."""
    return PHRASES_FR.get(phrase, phrase) if language == "fr" else phrase
