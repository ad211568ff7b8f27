"""What is read from two metres away: what to lay, how it lies, how the last one went."""

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout

from georibbon.gui.capturing.model import Quality
from georibbon.gui.capturing.words import VERDICT
from georibbon.gui.language import sentence as spoken
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of

FLASH = 450  # ms
_TEXT = QPalette.ColorRole.WindowText
TINT = {"good": "good", "acceptable": "fair", "redo": "poor"}


class Words(QLabel):
    """Words in so many times the usual size, in a colour of the theme, wrapped."""

    def __init__(self, size: float = 1.0, bold: bool = False) -> None:
        super().__init__()
        self._tint = "words"
        self.setWordWrap(True)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        font = QFont(self.font())
        font.setPointSizeF(size * font.pointSizeF())
        font.setBold(bold)
        self.setFont(font)

    def say(self, text: str, tint: str = "words") -> None:
        """Show a text in one of the theme's colours: words, good, fair, poor."""
        self.setText(text)
        self._tint = tint
        self._paint()

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_tint"):
            self._paint()

    def _paint(self) -> None:
        """A palette and no style sheet: a widget with one does not follow the theme."""
        mine = QPalette()
        if self._tint != "words":
            mine.setColor(_TEXT, QColor(getattr(colours_of(self.palette()), self._tint)))
        if self.palette().color(_TEXT) != mine.color(_TEXT):
            self.setPalette(mine)


class Board(QFrame):
    """A framed panel that can light up for a moment."""

    def __init__(self, name: str, parent=None) -> None:
        super().__init__(parent)
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAccessibleName(name)
        self.light: str | None = None
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(FLASH)
        self._timer.timeout.connect(self._go_out)

    def flash(self, good: bool) -> None:
        """Light up in the colour of what went well, or did not."""
        self.light = "good" if good else "poor"
        self._timer.start()
        self.update()

    def _go_out(self) -> None:
        self.light = None
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The frame, and the light along it."""
        super().paintEvent(event)
        if self.light is not None:
            _outline(self, getattr(colours_of(self.palette()), self.light), 8)


def _outline(widget: QFrame, colour: str, width: int) -> None:
    with QPainter(widget) as painter:
        painter.setPen(QPen(QColor(colour), width, j=Qt.PenJoinStyle.MiterJoin))
        half = width // 2
        painter.drawRect(widget.rect().adjusted(half, half, -half, -half))


class VerdictBoard(Board):
    """How the last pass went: a word as large as can be, and why."""

    def __init__(self, parent=None) -> None:
        super().__init__(tr("Quality of the last pass"), parent)
        self.what = Words(1.1)
        self.word = Words(2.6, bold=True)
        self.why = Words()
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
            self.word.say("")
            self.why.setText("")
            return
        if quality is None:
            self.what.setText(tr("{name} is taken", name=name))
            self.word.say("…")
            self.why.setText(tr("its quality is being computed"))
            return
        by = tr("{name}, with the others", name=name)
        self.what.setText(by if quality.final else tr("{name}, by itself", name=name))
        self.word.say(tr(VERDICT[quality.verdict]), TINT[quality.verdict])
        self.why.setText(spoken(quality.reason))


class Banner(QFrame):
    """A trouble across the page, with what can be done about it."""

    def __init__(self, parent=None) -> None:
        super().__init__(parent)
        self.words = Words(1.15, bold=True)
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
        self.words.say(spoken(sentence), "poor")
        self.setAccessibleName(spoken(sentence))
        self.setVisible(bool(sentence))

    def paintEvent(self, event: QPaintEvent) -> None:
        """A line around the trouble."""
        super().paintEvent(event)
        _outline(self, colours_of(self.palette()).poor, 2)
