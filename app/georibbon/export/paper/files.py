"""The paper's figures as a table for programs and as a page for people."""

import json
from collections.abc import Mapping, Sequence
from html import escape

from georibbon import __version__
from georibbon.export.paper.pictures import numbers_told
from georibbon.paper_figures import NAMES, Choice, Figure

FORMAT, VERSION = "georibbon paper figures", 1
PAPER = (
    "N. Sprynski, N. Szafran, B. Lacolle, L. Biard: Surface reconstruction via geodesic "
    "interpolation. Computer-Aided Design 40 (2008) 480-492"
)
DIGITS = 6
STYLE = """\
body { font-family: sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #22262c }
img { max-width: 100% } table { border-collapse: collapse }
td, th { border-bottom: 1px solid #d5d9de; padding: .25em .7em; text-align: left }
"""


def picture_name(number: int) -> str:
    """The name of a figure's picture."""
    return f"figure-{number:02d}.png"


def figure_data(figure: Figure) -> dict[str, object]:
    """A figure for programs: words and numbers, six digits of each."""
    return {
        "number": figure.number,
        "title": figure.title,
        "situation": figure.situation,
        "paper_shows": figure.shows,
        "found": figure.found,
        "picture": picture_name(figure.number),
        "choices": [_choice_data(choice) for choice in figure.choices],
    }


def _choice_data(choice: Choice) -> dict[str, object]:
    return {
        "name": choice.name,
        "whose": choice.whose,
        "settings": choice.settings,
        "verdict": choice.verdict,
        "numbers": {key: float(f"{value:.{DIGITS}g}") for key, value in choice.numbers.items()},
    }


def figures_json(figures: Sequence[Figure]) -> str:
    """All figures as one JSON text: what the numbers are, then the figures."""
    data: Mapping[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "program": f"georibbon {__version__}",
        "paper": PAPER,
        "numbers": explained(figures),
        "figures": [figure_data(figure) for figure in figures],
    }
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def explained(figures: Sequence[Figure]) -> dict[str, str]:
    """What each number that the figures have is, by its name."""
    used = {key for figure in figures for choice in figure.choices for key in choice.numbers}
    return {key: words for key, words in NAMES.items() if key in used}


def figures_page(figures: Sequence[Figure]) -> str:
    """All figures as one HTML page beside their pictures."""
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8"><title>The figures of the paper</title>',
        f"<style>{STYLE}</style></head><body>",
        f"<h1>The figures of the paper</h1><p>{escape(PAPER)}.</p>",
        "<p>The paper gives no data with its figures: the situations are of the same kind. In the "
        "pictures, red strokes are the conormals, and a surface's other side is brown.</p>",
        *map(_section, figures),
        "<h2>The numbers in figures.json</h2><table>",
        *(
            f"<tr><td>{escape(key)}</td><td>{escape(words)}</td></tr>"
            for key, words in explained(figures).items()
        ),
        "</table></body></html>",
    ]
    return "\n".join(parts) + "\n"


def _section(figure: Figure) -> str:
    rows = [
        f"<tr><td>{escape(choice.name)}</td><td>{escape(choice.settings)}</td>"
        f"<td>{escape(choice.verdict)}</td>"
        f"<td>{escape(', '.join(numbers_told(choice, figure.main)))}</td></tr>"
        for choice in figure.choices
    ]
    return "\n".join(
        [
            f"<h2>Figure {figure.number}. {escape(figure.title)}</h2>",
            f"<p><b>Given:</b> {escape(figure.situation)}</p>",
            f"<p><b>The paper shows:</b> {escape(figure.shows)}</p>",
            f'<p><img src="{picture_name(figure.number)}" alt="{escape(figure.title)}"></p>',
            "<table><tr><th>choice</th><th>settings</th><th>verdict</th><th>numbers</th></tr>",
            *rows,
            "</table>",
            f"<p><b>Found:</b> {escape(figure.found)}</p>",
        ]
    )
