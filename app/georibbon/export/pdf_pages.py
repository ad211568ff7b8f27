"""Pages of a PDF in the house's style: headings, tables, badges, pictures, page numbers."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal
from xml.sax.saxutils import escape

import matplotlib as mpl
from reportlab.lib import colors
from reportlab.lib.enums import TA_RIGHT
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import (
    Flowable,
    Image,
    KeepTogether,
    Paragraph,
    SimpleDocTemplate,
    Spacer,
    Table,
    TableStyle,
)

from georibbon.export.words import SIGNS

Side = Literal["left", "right"]

_MARGIN, _FOOT = 14 * mm, 18 * mm
_PADDING = 6.0  # of the library's frames on each side, points
WIDTH = A4[0] - 2 * _MARGIN
_INK, _DIM, _LINE, _STRONG_LINE = (
    colors.HexColor(one) for one in ("#20252b", "#57606a", "#e6e9ed", "#cfd5dc")
)
# A verdict's words, ground and frame.
_VERDICTS = {
    **dict.fromkeys(("good", "pass"), ("#14632b", "#f1faf3", "#1a7f37")),
    **dict.fromkeys(("acceptable", "warn"), ("#7a5200", "#fdf8ea", "#9a6700")),
    **dict.fromkeys(("redo", "fail"), ("#9c1c12", "#fdf2f1", "#b42318")),
}
_FONT, _BOLD = "DejaVuSans", "DejaVuSans-Bold"
_UNKNOWN = "□"


def use_fonts() -> None:
    """Make the fonts known, those of the drawings: they are in the file, whoever reads it."""
    if _FONT not in pdfmetrics.getRegisteredFontNames():
        folder = Path(mpl.get_data_path(), "fonts", "ttf")
        for name in (_FONT, _BOLD):
            pdfmetrics.registerFont(TTFont(name, str(folder / f"{name}.ttf")))
        pdfmetrics.registerFontFamily(_FONT, normal=_FONT, bold=_BOLD, italic=_FONT)


def _style(name: str, **settings: Any) -> ParagraphStyle:
    defaults: dict[str, Any] = {
        "fontName": _FONT,
        "fontSize": 8.5,
        "leading": 12,
        "textColor": _INK,
    }
    return ParagraphStyle(name, **{**defaults, **settings})


_STYLES = {
    "kicker": _style("kicker", fontSize=7.5, textColor=_DIM),
    "title": _style("title", fontName=_BOLD, fontSize=18, leading=23, spaceAfter=4 * mm),
    "heading": _style(
        "heading", fontName=_BOLD, fontSize=12, leading=15, spaceBefore=6 * mm, keepWithNext=1,
        spaceAfter=2 * mm,
    ),
    "heading 2": _style(
        "heading 2", fontName=_BOLD, fontSize=9.5, spaceBefore=3 * mm, spaceAfter=1 * mm,
        keepWithNext=1,
    ),
    "text": _style("text"),
    "bold": _style("bold", fontName=_BOLD),
    "note": _style("note", fontSize=7.5, leading=10, textColor=_DIM, spaceBefore=1 * mm),
    "cell": _style("cell", fontSize=7.2, leading=9.4),
    "cell bold": _style("cell bold", fontName=_BOLD, fontSize=7.2, leading=9.4),
    "number": _style("number", fontSize=7.2, leading=9.4, alignment=TA_RIGHT),
    "head": _style("head", fontName=_BOLD, fontSize=7.2, leading=9.4, textColor=_DIM),
    "head number": _style(
        "head number", fontName=_BOLD, fontSize=7.2, leading=9.4, textColor=_DIM,
        alignment=TA_RIGHT,
    ),
}  # fmt: skip


def plain(text: str) -> str:
    """A text that can be drawn: signs that the font lacks as a box, those of control too."""
    known: dict[int, int] = getattr(pdfmetrics.getFont(_FONT), "face").charToGlyph  # noqa: B009
    return "".join(c if ord(c) in known and c.isprintable() else _UNKNOWN for c in text)


def text(words: str, style: str = "text") -> Paragraph:
    """A paragraph of a text in which nothing is markup."""
    return Paragraph(escape(plain(words)), _STYLES[style])


def badge(verdict: str, style: str = "cell") -> Paragraph:
    """A verdict: its sign, its word, its colour."""
    ink = _VERDICTS[verdict][0]
    return Paragraph(
        f'<font name="{_BOLD}" color="{ink}">{SIGNS[verdict]} {verdict}</font>', _STYLES[style]
    )


def facts(pairs: Sequence[tuple[str, str]], columns: int = 2) -> Table:
    """Names with what there is to say, side by side."""
    rows = [list(pairs[k : k + columns]) for k in range(0, len(pairs), columns)]
    rows[-1] += [("", "")] * (columns - len(rows[-1]))
    cells = [
        [part for name, value in row for part in (text(name, "head"), text(value, "cell"))]
        for row in rows
    ]
    width = WIDTH / columns
    style = [("VALIGN", (0, 0), (-1, -1), "TOP"), ("TOPPADDING", (0, 0), (-1, -1), 1)]
    style.append(("LEFTPADDING", (0, 0), (-1, -1), 0))
    return Table(
        cells, [0.17 * width, 0.83 * width] * columns,
        style=TableStyle([*style, ("BOTTOMPADDING", (0, 0), (-1, -1), 1)]), splitInRow=1,
    )  # fmt: skip


def table(
    heads: Sequence[tuple[str, Side]],
    rows: Sequence[Sequence[str | Flowable]],
    widths: Sequence[float],
) -> Table:
    """A table whose head is on every page it goes over; the first column's words are bold.

    heads: each column's name, and the side on which it is aligned.  widths: the
    columns', as parts of their sum.
    """
    sides = [side for _, side in heads]
    cells: list[list[Flowable]] = []
    if any(name for name, _ in heads):
        head = {"left": "head", "right": "head number"}
        cells.append([text(name, head[side]) for name, side in heads])
    first = len(cells)
    cells += [
        [
            _cell(value, "cell bold" if k == 0 else "cell" if side == "left" else "number")
            for k, (value, side) in enumerate(zip(row, sides, strict=True))
        ]
        for row in rows
    ]
    style: list[Any] = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LINEBELOW", (0, 0), (-1, -1), 0.5, _LINE),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 6),
        ("TOPPADDING", (0, 0), (-1, -1), 2.5),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2.5),
    ]
    if first:
        style.append(("LINEBELOW", (0, 0), (-1, 0), 1, _STRONG_LINE))
    share = WIDTH / sum(widths)
    return Table(
        cells, [share * one for one in widths], repeatRows=first, style=TableStyle(style),
        splitInRow=1,
    )  # fmt: skip


def _cell(value: str | Flowable, style: str) -> Flowable:
    return text(value, style) if isinstance(value, str) else value


def box(verdict: str, content: Sequence[Flowable]) -> Table:
    """Paragraphs in the frame of a verdict's colour."""
    _, ground, frame = _VERDICTS[verdict]
    style: list[Any] = [
        ("BACKGROUND", (0, 0), (-1, -1), colors.HexColor(ground)),
        ("BOX", (0, 0), (-1, -1), 0.7, colors.HexColor(frame)),
        ("LINEBEFORE", (0, 0), (0, -1), 4, colors.HexColor(frame)),
        ("LEFTPADDING", (0, 0), (-1, -1), 10),
        ("TOPPADDING", (0, 0), (-1, 0), 6),
        ("BOTTOMPADDING", (0, -1), (-1, -1), 6),
    ]
    return Table([[one] for one in content], [WIDTH], style=TableStyle(style), splitInRow=1)


def picture(data: bytes, caption: str = "", heading: str = "") -> KeepTogether:
    """A PNG picture across the page, with its heading above and what it shows below."""
    image = Image(io.BytesIO(data))
    height = WIDTH * image.imageHeight / image.imageWidth
    most = A4[1] - _MARGIN - _FOOT - 30 * mm  # room for a heading and the caption
    scale = min(1.0, most / height)
    image.drawWidth, image.drawHeight = WIDTH * scale, height * scale
    above = [text(heading, "heading")] if heading else []
    below = [text(caption, "note")] if caption else []
    return KeepTogether([*above, Spacer(0, 2 * mm), image, *below, Spacer(0, 2 * mm)])


def pages(story: Sequence[Flowable], title: str, foot: str) -> bytes:
    """The PDF of what follows one another, with page numbers, the same for the same story."""
    target = io.BytesIO()
    document = SimpleDocTemplate(
        target, pagesize=A4, leftMargin=_MARGIN - _PADDING, rightMargin=_MARGIN - _PADDING,
        topMargin=_MARGIN, bottomMargin=_FOOT, title=plain(title), author="",
        creator="Georibbon", invariant=1, lang="en",
    )  # fmt: skip
    words = plain(foot)

    class Numbered(Canvas):
        """Pages that are finished when it is known how many there are."""

        def __init__(self, *arguments: Any, **settings: Any) -> None:
            super().__init__(*arguments, **settings)
            self._held: list[dict[str, Any]] = []

        def showPage(self) -> None:  # noqa: N802 - the canvas's own name for it
            """Keep the page."""
            self._held.append(dict(self.__dict__))
            self._startPage()  # type: ignore[attr-defined]  # how a page is kept for later

        def save(self) -> None:
            """Write all pages, each with its number."""
            for number, page in enumerate(self._held, start=1):
                self.__dict__.update(page)
                self.setFont(_FONT, 7)
                self.setFillColor(_DIM)
                self.drawString(_MARGIN, 9 * mm, words)
                self.drawRightString(A4[0] - _MARGIN, 9 * mm, f"{number} / {len(self._held)}")
                super().showPage()
            super().save()

    document.build(list(story), canvasmaker=Numbered)
    return target.getvalue()
