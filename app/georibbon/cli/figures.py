"""``georibbon figures``: the figures of the source paper, done again."""

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser, whole
from georibbon.cli.outputs import Outputs, folder_made, signals_held
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.paper_figures import Figure

DESCRIPTION = """\
Do the figures of the paper again that Georibbon began from: Sprynski, Szafran, Lacolle
and Biard, Surface reconstruction via geodesic interpolation, Computer-Aided Design 40
(2008).  Each figure as a picture and with numbers: the paper's choice and Georibbon's
own default side by side, against the true surface where there is one.  The paper gives
no data with its figures: the situations are of the same kind, with numbers of our own.
The figures are 2 to 13, 15, 16, and 17, whose object is a virtual one here."""

EPILOG = """\
what comes out, in DIR; files of an earlier time are written anew:
  figure-02.png …   a picture of each figure
  figures.json      all the numbers, for programs
  index.html        all of it on one page, for people

figures.json: "numbers" says what each number is; the end of its name is its unit (_mm,
_deg, _percent, _per_m), others have none.  "figures" holds for each figure "number",
"title", "situation", "paper_shows", "found", "picture" and "choices", and for each of
these "name", "whose" (paper, georibbon or other), "settings" (direction, tangent
lengths, correspondence), "verdict" and "numbers".

examples:
  georibbon figures -o paper
  georibbon figures -o paper --only 7,9,10 --width 2400"""

LEAST_WIDTH, MOST_WIDTH = 400, 6000


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, required=True,
        help="the folder to write into, made if need be",
    )  # fmt: skip
    parser.add_argument(
        "--only", metavar="N,N…", type=_numbers, help="these figures alone, by their numbers"
    )
    parser.add_argument(
        "--width", metavar="PIXELS", type=_width, default=1600,
        help="of each picture (default %(default)s)",
    )  # fmt: skip
    parser.set_defaults(run=run)


def _numbers(text: str) -> tuple[int, ...]:
    from georibbon.paper_figures import NUMBERS

    found = {whole(word) for word in text.split(",")}
    unknown = found - set(NUMBERS)
    if unknown:
        known = ", ".join(map(str, NUMBERS))
        raise argparse.ArgumentTypeError(f"there is no figure {min(unknown)}; they are {known}")
    return tuple(sorted(found))


def _width(text: str) -> int:
    value = whole(text)
    if not LEAST_WIDTH <= value <= MOST_WIDTH:
        raise argparse.ArgumentTypeError(
            f"{text} found, {LEAST_WIDTH} to {MOST_WIDTH} pixels expected"
        )
    return value


def run(arguments: argparse.Namespace) -> None:
    """Compute, draw and write the figures one after another, and tell their numbers."""
    from georibbon.export.paper.files import figures_json, figures_page, picture_name
    from georibbon.export.paper.pictures import picture_of
    from georibbon.paper_figures import NUMBERS, figure
    from georibbon.threads import one_thread

    folder: Path = arguments.output
    numbers: Sequence[int] = arguments.only or NUMBERS
    pictures = {number: folder / picture_name(number) for number in numbers}
    table, page = folder / "figures.json", folder / "index.html"
    with ExitStack() as stack:
        stack.enter_context(folder_made(folder))
        outputs = stack.enter_context(Outputs([*pictures.values(), table, page]))
        stack.enter_context(one_thread())
        figures = []
        for number, target in pictures.items():
            found = figure(number)
            _print_figure(found)
            with signals_held():
                picture = picture_of(found, arguments.width)
            outputs.place(target).write_bytes(picture)
            figures.append(found)
        outputs.place(table).write_text(figures_json(figures), encoding="utf-8")
        outputs.place(page).write_text(figures_page(figures), encoding="utf-8")
    print(f"\nwritten: {page}, {table} and {counted(len(pictures), 'picture')}")


def _print_figure(found: "Figure") -> None:
    from georibbon.export.paper.pictures import numbers_told

    print(f"Figure {found.number}. {found.title}")
    wide = max(len(choice.name) for choice in found.choices)
    for choice in found.choices:
        told = ", ".join(numbers_told(choice, found.main))
        print(f"  {choice.whose:9}  {choice.name:{wide}}  {choice.verdict}: {told}", flush=True)
