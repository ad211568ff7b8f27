"""The cards of the poses: each a picture of the bar, its words, and how it stands."""

from collections.abc import Sequence

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QGridLayout, QSizePolicy, QWidget

from georibbon.calibration.directions import attitude
from georibbon.gui.calibrating.bar_view import LOOKS, paint_bar
from georibbon.gui.calibrating.signs import colour_of, paint_sign
from georibbon.gui.calibrating.state import Card
from georibbon.gui.calibrating.words import STATES, card_told, card_words
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of, theme_of

KEYS = (
    Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_Home,
    Qt.Key.Key_End,
)  # fmt: skip
SMALLEST = 0.72  # of the usual size: the words of a card that has little room
BESIDE = 20  # px beside a card's words
SLACK = 4  # px that a smaller font's words may be wider than their share
SPACING = 4  # px between cards
FEW, NARROW, WIDE = 16, 4, 5  # up to so many poses so many cards side by side; more where there are


class PoseCard(QAbstractButton):
    """One pose.  clicked: ask for it; moved(key): an arrow, Home or End was pressed on it."""

    moved = Signal(object)

    def __init__(self, card: Card, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.card = card
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        lines = card_words(card.pose).split("\n")
        self._widest = max(self.fontMetrics().horizontalAdvance(line) for line in lines)
        least = round(SMALLEST * self._widest)
        self.setMinimumSize(least + BESIDE, 5 * self.fontMetrics().height())
        self.show_card(card)

    @property
    def comfortable(self) -> int:
        """px: as wide as its words are in full size."""
        return self._widest + BESIDE

    def sizeHint(self) -> QSize:
        """Wider than high."""
        return QSize(130, 108)

    def show_card(self, card: Card) -> None:
        """Show how it stands."""
        self.card = card
        self.setText(tr("{number}", number=card.number))
        self.setAccessibleName(card_told(card))
        self.setToolTip(card_told(card))
        self.update()

    def keyPressEvent(self, event) -> None:
        """Arrows go to the other cards, Return asks for this one; Space takes, on the page."""
        if event.key() in KEYS:
            self.moved.emit(Qt.Key(event.key()))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.click()
        else:
            event.ignore()

    def paintEvent(self, _event) -> None:
        """The picture, the number and words, the sign and the state."""
        colours = colours_of(self.palette())
        line = self.fontMetrics().height()
        area = QRectF(self.rect()).adjusted(2, 2, -2, -2)
        with QPainter(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            self._paint_frame(painter, area, colours)
            inner = area.adjusted(6, 4, -6, -4)
            font = self.font()
            font.setBold(True)
            painter.setFont(font)
            painter.setPen(QColor(colours.words))
            painter.drawText(
                inner, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop, self.text()
            )
            painter.setFont(self.font())
            self._paint_state(painter, inner, line, colours)
            words = inner.adjusted(0, inner.height() - 2 * line, 0, 0)
            painter.setPen(QColor(colours.words))
            font = self.font()
            share = min(1.0, (inner.width() - SLACK) / max(self._widest, 1))
            font.setPointSizeF(share * font.pointSizeF())
            painter.setFont(font)
            painter.drawText(words, Qt.AlignmentFlag.AlignHCenter, card_words(self.card.pose))
            picture = inner.adjusted(0, line, 0, -2 * line)
            turned = attitude(_asked(self.card))
            look = LOOKS[theme_of(self.palette())]
            paint_bar(
                painter, picture, turned, not self.card.pose.table, colours, look, labels=False
            )

    def _paint_frame(self, painter, area, colours) -> None:
        asked = self.card.state in ("asked", "refused")
        painter.setPen(QPen(QColor(colour_of(self.card.state, colours)), 3.0 if asked else 1.2))
        painter.setBrush(QColor(colours.base if not self.isDown() else colours.other))
        painter.drawRoundedRect(area, 6, 6)
        if self.hasFocus():
            pen = QPen(QColor(colours.words), 1.0, Qt.PenStyle.DotLine)
            painter.setPen(pen)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(area.adjusted(3, 3, -3, -3), 4, 4)

    def _paint_state(self, painter, inner, line, colours) -> None:
        state = self.card.state
        size = line - 2.0
        sign = QRectF(inner.right() - size, inner.top() + 1.0, size, size)
        paint_sign(painter, sign, state, colours)
        colour = colours.dim if state in ("open", "skipped") else colour_of(state, colours)
        painter.setPen(QColor(colour))
        painter.drawText(
            inner.adjusted(0, 0, -size - 4.0, 0),
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop,
            tr(STATES[state]),
        )


def _asked(card: Card) -> tuple[float, float, float, bool]:
    pose = card.pose
    return pose.roll, pose.heading, pose.pitch, pose.table


def columns_for(number: int, room: int, width: int) -> int:
    """How many cards of a width stand side by side in so much room."""
    if number <= FEW:
        return min(max(number, 1), NARROW)
    return WIDE if room >= WIDE * width + (WIDE - 1) * SPACING else NARROW


class PoseGrid(QWidget):
    """The cards of all poses.  asked(key): a person wants this one."""

    asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("Poses"))
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(SPACING)
        self.buttons: list[PoseCard] = []
        self._columns = 1

    def show_cards(self, cards: Sequence[Card]) -> None:
        """Show how all stand; the same cards stay where they are."""
        if [card.key for card in cards] != [one.card.key for one in self.buttons]:
            self._fill(cards)
        for button, card in zip(self.buttons, cards, strict=True):
            if button.card != card:
                button.show_card(card)

    def minimumSizeHint(self) -> QSize:
        """As narrow as it can be: with fewer cards side by side, and smaller words."""
        sizes = [one.minimumSize() for one in self.buttons]
        if not sizes:
            return QSize(0, 0)
        columns = min(len(sizes), NARROW)
        rows = -(-len(sizes) // columns)
        wide, high = max(s.width() for s in sizes), max(s.height() for s in sizes)
        return QSize(columns * (wide + SPACING) - SPACING, rows * (high + SPACING) - SPACING)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """As many cards side by side as there is room for."""
        super().resizeEvent(event)
        self._arrange()

    def card(self, key: str) -> PoseCard:
        """The card of a pose."""
        return next(one for one in self.buttons if one.card.key == key)

    def _fill(self, cards: Sequence[Card]) -> None:
        for button in self.buttons:
            self._grid.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = []
        for place, card in enumerate(cards):
            button = PoseCard(card)
            button.clicked.connect(lambda _=False, key=card.key: self.asked.emit(key))
            button.moved.connect(lambda key, at=place: self._go(at, key))
            self.buttons.append(button)
        self._columns = 0
        self._arrange()
        self.updateGeometry()

    def _arrange(self) -> None:
        widest = max((one.comfortable for one in self.buttons), default=0)
        columns = columns_for(len(self.buttons), self.width(), widest)
        if columns == self._columns:
            return
        self._columns = columns
        for button in self.buttons:
            self._grid.removeWidget(button)
        for place, button in enumerate(self.buttons):
            self._grid.addWidget(button, place // columns, place % columns)

    def _go(self, place: int, key: Qt.Key) -> None:
        """Give the keys to the card that an arrow leads to, where there is one."""
        last = len(self.buttons) - 1
        place = {
            Qt.Key.Key_Left: place - 1,
            Qt.Key.Key_Right: place + 1,
            Qt.Key.Key_Up: place - self._columns,
            Qt.Key.Key_Down: place + self._columns,
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: last,
        }[key]
        if 0 <= place <= last:
            self.buttons[place].setFocus(Qt.FocusReason.OtherFocusReason)
