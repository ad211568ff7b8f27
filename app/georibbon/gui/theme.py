"""The window's colours: a light and a dark palette of our own, on Qt's Fusion style.

Words stand out from their ground by 4.5 to 1 at least, and frames, signs and curves
by 3 to 1 (the levels of the Web Content Accessibility Guidelines 2.2).
"""

from dataclasses import dataclass
from typing import Literal

from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

Theme = Literal["light", "dark"]
THEMES: tuple[Theme, ...] = ("light", "dark")
_Group, _Role = QPalette.ColorGroup, QPalette.ColorRole


@dataclass(frozen=True)
class Colours:
    """One theme's colours, as "#rrggbb".

    window, base, other: the grounds of windows, of lists and fields, and of every
    second row.  words, dim: text, and text of what is not to be had now.  frame:
    lines around things.  chosen, on_chosen: what is selected and its words.
    link: links.  good, fair, poor: words and signs of a verdict.  curves: lines
    of a plot, told apart also by people who confuse red and green.
    """

    window: str
    base: str
    other: str
    button: str
    words: str
    dim: str
    frame: str
    chosen: str
    on_chosen: str
    link: str
    good: str
    fair: str
    poor: str
    curves: tuple[str, ...]


COLOURS: dict[Theme, Colours] = {
    "light": Colours(
        window="#f1f3f5",
        base="#ffffff",
        other="#f5f7f9",
        button="#e6e9ed",
        words="#1b1f24",
        dim="#687079",
        frame="#787f88",
        chosen="#1f63b5",
        on_chosen="#ffffff",
        link="#1a5fb4",
        good="#1a6e37",
        fair="#8a5a00",
        poor="#b3261e",
        curves=(
            "#1f63b5",
            "#c2500a",
            "#1a7a4a",
            "#a3347f",
            "#6b6f00",
            "#5b4bb7",
            "#00757f",
            "#84513a",
        ),
    ),
    "dark": Colours(
        window="#2c3137",
        base="#17191d",
        other="#1e2126",
        button="#3c424a",
        words="#e6e9ec",
        dim="#a6aeb7",
        frame="#8b939c",
        chosen="#2f6fc4",
        on_chosen="#ffffff",
        link="#7db4f5",
        good="#6fcf8e",
        fair="#e3b34a",
        poor="#ff9187",
        curves=(
            "#6fb1ff",
            "#ff9f5c",
            "#5fd39a",
            "#f08fd0",
            "#d0d05a",
            "#b3a4ff",
            "#4fd0dc",
            "#d9a58c",
        ),
    ),
}


def apply_theme(app: QApplication, theme: Theme) -> None:
    """Give all windows, present and to come, a theme's colours."""
    if theme not in THEMES:
        raise ValueError(f"there is no theme {theme}")
    from georibbon.gui.style import FramedStyle

    if not isinstance(app.style(), FramedStyle):
        app.setStyle(FramedStyle())
    app.setPalette(palette(theme))


def theme_of(colours: QPalette) -> Theme:
    """Which theme a palette belongs to, by how light its ground is."""
    return "dark" if colours.color(_Role.Base).lightnessF() < 0.5 else "light"


def colours_of(colours: QPalette) -> Colours:
    """The colours of the theme that a palette belongs to."""
    return COLOURS[theme_of(colours)]


def palette(theme: Theme) -> QPalette:
    """A theme as Qt's palette."""
    of = COLOURS[theme]
    made = QPalette(QColor(of.button), QColor(of.window))
    for roles, colour in (
        ((_Role.Window,), of.window),
        ((_Role.Base, _Role.ToolTipBase), of.base),
        ((_Role.AlternateBase,), of.other),
        ((_Role.Button,), of.button),
        ((_Role.WindowText, _Role.Text, _Role.ButtonText, _Role.ToolTipText), of.words),
        ((_Role.BrightText,), of.poor),
        ((_Role.PlaceholderText,), of.dim),
        ((_Role.Highlight, _Role.Accent), of.chosen),
        ((_Role.HighlightedText,), of.on_chosen),
        ((_Role.Link, _Role.LinkVisited), of.link),
    ):
        for role in roles:
            made.setColor(role, QColor(colour))
    for role in (_Role.WindowText, _Role.Text, _Role.ButtonText):
        made.setColor(_Group.Disabled, role, QColor(of.dim))
    made.setColor(_Group.Disabled, _Role.Highlight, QColor(of.frame))
    return made


def contrast(one: str, other: str) -> float:
    """The contrast of two colours "#rrggbb", from 1 to 21.

    (L1 + 0.05) / (L2 + 0.05) of the relative luminances L, the lighter one first.
    """
    darker, lighter = sorted((_luminance(one), _luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    """0.2126 R + 0.7152 G + 0.0722 B of the linear parts of an sRGB colour."""
    parts = [channel / 255.0 for channel in bytes.fromhex(colour.removeprefix("#"))]
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
