"""A line that tells how it went, close to its cause: in words, with a sign and a colour."""

from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget

from georibbon.gui.language import sentence as spoken
from georibbon.gui.theme import colours_of, theme_of

Kind = Literal["plain", "good", "poor"]
_SIGNS = {"plain": "", "good": "✔ ", "poor": "✖ "}


class ToldLine(QLabel):
    """A sentence that can be selected and wraps; a name without end does not widen the window."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWordWrap(True)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._kind: Kind = "plain"
        self._theme = theme_of(self.palette())  # that it is coloured for

    def tell(self, sentence: str, kind: Kind = "plain") -> None:
        """Show a sentence; none where it is empty."""
        self._kind = kind
        self.setText(f"{_SIGNS[kind]}{spoken(sentence)}" if sentence else "")
        self.setToolTip(self.text())
        self._colour()

    def changeEvent(self, event) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == event.Type.PaletteChange and theme_of(self.palette()) != self._theme:
            self._colour()

    def _colour(self) -> None:
        self._theme = theme_of(self.palette())
        colours = colours_of(self.palette())
        words = {"plain": colours.words, "good": colours.good, "poor": colours.poor}[self._kind]
        palette = QPalette()
        palette.setColor(QPalette.ColorRole.WindowText, QColor(words))
        self.setPalette(palette)
