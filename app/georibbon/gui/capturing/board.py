"""What is read from two metres away: what to lay, how it lies, how the last one went."""

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout

from georibbon.gui.capturing.model import Quality
from georibbon.gui.capturing.words import VERDICT
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of

FLASH = 450  # ms


def label(size: float = 1.0, bold: bool = False) -> QLabel:
    """Words in so many times the usual size, wrapped, read aloud as they are."""
    made = QLabel()
    made.setWordWrap(True)
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
    font = QFont(made.font())
    font.setPointSizeF(size * font.pointSizeF())
    font.setBold(bold)
    made.setFont(font)
    return made


class Board(QFrame):
    """A framed panel that can flash; its words by their names."""

    def __init__(self, name: str, parent=None) -> None:
        super().__init__(parent)
        self.setObjectName("board")
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAccessibleName(name)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(FLASH)
        self._timer.timeout.connect(lambda: self.setStyleSheet(""))

    def flash(self, good: bool) -> None:
        """Light up for a moment."""
        of = colours_of(self.palette())
        colour = of.good if good else of.poor
        self.setStyleSheet(f"QFrame#board {{ border: 6px solid {colour}; }}")
        self._timer.start()


class VerdictBoard(Board):
    """How the last pass went: a word as large as can be, and why."""

    def __init__(self, parent=None) -> None:
        super().__init__(tr("Quality of the last pass"), parent)
        self.what = label(1.1)
        self.word = label(2.6, bold=True)
        self.why = label()
        self.name: str | None = None
        layout = QVBoxLayout(self)
        layout.setSpacing(2)
        layout.addWidget(self.what)
        layout.addWidget(self.word)
        layout.addWidget(self.why)
        layout.addStretch(1)
        self.show_quality(None, None)

    def show_quality(self, name: str | None, quality: Quality | None) -> None:
        """Show a pass's quality; None: it is not known yet."""
        self.name = name
        if name is None:
            self.what.setText(tr("no pass is taken yet"))
            self.word.setText("")
            self.why.setText("")
            return
        if quality is None:
            self.what.setText(tr("{name} is taken", name=name))
            self.word.setText("…")
            self.why.setText(tr("its quality is being computed"))
            return
        by = tr("{name}, with the others", name=name)
        self.what.setText(by if quality.final else tr("{name}, by itself", name=name))
        self.word.setText(tr(VERDICT[quality.verdict]))
        self.why.setText(quality.reason)
        of = colours_of(self.palette())
        colour = {"good": of.good, "acceptable": of.fair, "redo": of.poor}[quality.verdict]
        self.word.setStyleSheet(f"color: {colour}")


class Banner(QFrame):
    """A trouble across the page, with what can be done about it."""

    def __init__(self, parent=None) -> None:
        super().__init__(parent)
        self.setObjectName("banner")
        self.words = label(1.15, bold=True)
        self.buttons: list[QPushButton] = []
        self._layout = QHBoxLayout(self)
        self._layout.addWidget(self.words, 1)
        self.hide()

    def add_button(self, text: str) -> QPushButton:
        """A button for a remedy."""
        button = QPushButton(text)
        self._layout.addWidget(button)
        self.buttons.append(button)
        return button

    def tell(self, sentence: str) -> None:
        """Show a sentence; nothing at all for an empty one."""
        self.words.setText(sentence)
        self.setAccessibleName(sentence)
        of = colours_of(self.palette())
        self.setStyleSheet(
            f"QFrame#banner {{ border: 2px solid {of.poor}; border-radius: 4px; }}"
            f"QFrame#banner QLabel {{ color: {of.poor}; }}"
        )
        self.setVisible(bool(sentence))
