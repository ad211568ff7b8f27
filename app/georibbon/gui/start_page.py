"""The start page: what a person can begin with."""

import datetime
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QEvent, QItemSelectionModel, QLocale, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QColor, QPainter, QPen
from PySide6.QtWidgets import (
    QAbstractButton,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.actions import plain
from georibbon.gui.icons import icon
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of, theme_of

# The actions to begin with, where the window has them, with their icons.
CARDS = {
    "new-capture": "capture",
    "open": "open",
    "calibrate": "calibrate",
    "connect-virtual": "virtual",
    "demonstration": "surface",
}
SMALLER = {"open-folder": "folder", "import": "import"}
_ICON = 32  # px


class Card(QAbstractButton):
    """A way to begin: its sign, its words, what it does, and its keys."""

    def __init__(self, action: QAction, sign: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._action, self._sign = action, sign
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)
        self._picture, self._title, self._tip, self._keys = (QLabel() for _ in range(4))
        for label in (self._picture, self._title, self._tip, self._keys):
            label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            label.setTextFormat(Qt.TextFormat.PlainText)
        font = self._title.font()
        font.setPointSizeF(1.15 * font.pointSizeF())
        font.setBold(True)
        self._title.setFont(font)
        self._tip.setWordWrap(True)
        self._lay_out()
        self.clicked.connect(action.trigger)
        action.changed.connect(self._follow)
        self._follow()

    def sizeHint(self) -> QSize:
        """As its words need it."""
        return self.layout().sizeHint()

    def keyPressEvent(self, event) -> None:
        """Return presses it too."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.click()
        else:
            super().keyPressEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._show_sign()

    def paintEvent(self, event) -> None:
        """A ground with a frame; a thick one where the keys or the pointer are."""
        of = colours_of(self.palette())
        wanted = self.isEnabled() and (self.hasFocus() or self.underMouse())
        width = 2.0 if wanted else 1.0
        pen = QPen(QColor(of.link if wanted else of.frame), width)
        if not self.isEnabled():
            pen.setStyle(Qt.PenStyle.DashLine)
        with QPainter(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(pen)
            painter.setBrush(QColor(of.button if self.isDown() else of.base))
            half = width / 2
            painter.drawRoundedRect(
                QRectF(self.rect()).adjusted(half, half, -half, -half), 6.0, 6.0
            )

    def _lay_out(self) -> None:
        words = QVBoxLayout()
        words.setSpacing(2)
        head = QHBoxLayout()
        head.setSpacing(12)
        head.addWidget(self._title, 1)
        head.addWidget(self._keys)
        words.addLayout(head)
        words.addWidget(self._tip, 1, Qt.AlignmentFlag.AlignTop)
        whole = QHBoxLayout(self)
        whole.setContentsMargins(14, 12, 14, 12)
        whole.setSpacing(14)
        whole.addWidget(self._picture, 0, Qt.AlignmentFlag.AlignTop)
        whole.addLayout(words, 1)
        self.setMinimumWidth(330)
        self.setMinimumHeight(64)

    def _follow(self) -> None:
        """The action's words, and whether it can be done now."""
        action = self._action
        text = plain(action.text())
        self._title.setText(text)
        self._tip.setText(action.statusTip())
        keys = action.shortcut().toString(action.shortcut().SequenceFormat.NativeText)
        self._keys.setText(keys)
        self.setEnabled(action.isEnabled())
        self.setAccessibleName(text)
        self.setAccessibleDescription(action.statusTip())
        self.setStatusTip(action.statusTip())
        self._show_sign()

    def _show_sign(self) -> None:
        of = colours_of(self.palette())
        shade = self._keys.palette()
        shade.setColor(self._keys.foregroundRole(), QColor(of.dim))
        self._keys.setPalette(shade)
        drawn = icon(self._sign, theme_of(self.palette()))
        self._picture.setPixmap(drawn.pixmap(QSize(_ICON, _ICON), self.devicePixelRatioF()))


class StartPage(QWidget):
    """New capture, calibrate, the virtual ribbon, open, the demonstration, and what was last.

    actions: the window's; of those to begin with, what it lacks is not offered.
    asked(path): one of the recent ones, or what was dropped here.
    """

    asked = Signal(Path)

    def __init__(self, actions: Mapping[str, QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("Start"))
        self.setAcceptDrops(True)
        self._dropping = False
        self.buttons: dict[str, QAbstractButton] = {}
        left = QVBoxLayout()
        left.setSpacing(10)
        for name, sign in CARDS.items():
            if name in actions:
                self.buttons[name] = Card(actions[name], sign)
                left.addWidget(self.buttons[name])
        smaller = QHBoxLayout()
        for name, sign in SMALLER.items():
            if name in actions:
                self.buttons[name] = _small(actions[name], sign)
                smaller.addWidget(self.buttons[name])
        left.addLayout(smaller)
        left.addStretch()
        self._fill(left, self._make_recent())

    def entered(self) -> None:
        """The page is shown: the keys go on where they were, or begin at the first way to begin."""
        to = self.focusWidget() or next(iter(self.buttons.values()), None)
        if to is not None:
            to.setFocus(Qt.FocusReason.OtherFocusReason)

    def show_recent(self, paths: Sequence[Path]) -> None:
        """List what was opened last, with its place and when it was written last."""
        self.recent.clear()
        for path in paths:
            left = tr("It was not closed; what was captured is in it.") if _left(path) else ""
            more = f"\n▲ {left}" if left else ""
            item = QListWidgetItem(f"{path.name}\n{_when(path)}{_place(path.parent)}{more}")
            item.setData(Qt.ItemDataRole.UserRole, path)
            item.setToolTip(str(path))
            self.recent.addItem(item)
        if paths:
            self.recent.setCurrentRow(0, QItemSelectionModel.SelectionFlag.NoUpdate)
        else:
            item = QListWidgetItem(tr("Nothing yet: the demonstration is a good beginning."))
            item.setFlags(Qt.ItemFlag.NoItemFlags)
            self.recent.addItem(item)

    def dragEnterEvent(self, event) -> None:
        """One file or folder of this machine may be dropped."""
        if dropped(event) is not None:
            event.acceptProposedAction()
            self._light(True)

    def dragLeaveEvent(self, event) -> None:
        """It was taken elsewhere."""
        self._light(False)

    def dropEvent(self, event) -> None:
        """Open what is dropped."""
        self._light(False)
        path = dropped(event)
        if path is not None:
            event.acceptProposedAction()
            self.asked.emit(path)

    def paintEvent(self, event) -> None:
        """A frame around all while something hangs over it."""
        super().paintEvent(event)
        if self._dropping:
            with QPainter(self) as painter:
                painter.setPen(QPen(QColor(colours_of(self.palette()).link), 4))
                painter.drawRect(self.rect().adjusted(2, 2, -2, -2))

    def _light(self, on: bool) -> None:
        self._dropping = on
        self.update()

    def _make_recent(self) -> QVBoxLayout:
        self.recent = QListWidget()
        self.recent.setAccessibleName(tr("Opened last"))
        self.recent.setStatusTip(tr("Press Return or click to open it again"))
        self.recent.setSpacing(3)
        self.recent.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.recent.itemActivated.connect(self._ask)
        self.recent.itemClicked.connect(self._ask)
        label = QLabel(tr("Opened &last"))
        label.setBuddy(self.recent)
        drop = QLabel(tr("Or drop a session or a recording folder anywhere on this window."))
        drop.setWordWrap(True)
        right = QVBoxLayout()
        right.addWidget(label)
        right.addWidget(self.recent, 1)
        right.addWidget(drop)
        return right

    def _fill(self, left: QVBoxLayout, right: QVBoxLayout) -> None:
        """Title above, the ways to begin to the left, what was last to the right."""
        title = QLabel("Georibbon")
        font = title.font()
        font.setPointSizeF(2.2 * font.pointSizeF())
        title.setFont(font)
        words = QLabel(tr("From what a ribbon of sensors measures to the surface it was laid on."))
        words.setWordWrap(True)
        inside = QWidget()
        grid = QGridLayout(inside)
        grid.setContentsMargins(40, 28, 40, 28)
        grid.setHorizontalSpacing(32)
        grid.setVerticalSpacing(8)
        grid.addWidget(title, 0, 0, 1, 2)
        grid.addWidget(words, 1, 0, 1, 2)
        grid.setRowMinimumHeight(2, 8)
        grid.addLayout(left, 3, 0)
        grid.addLayout(right, 3, 1)
        grid.setRowStretch(3, 1)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(1, 1)
        scroll = QScrollArea()
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        scroll.setWidgetResizable(True)
        scroll.setWidget(inside)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(4, 4, 4, 4)  # the room of the frame while something hangs over it
        whole.addWidget(scroll)

    def _ask(self, item: QListWidgetItem) -> None:
        path = item.data(Qt.ItemDataRole.UserRole)
        if path is not None:
            self.asked.emit(Path(path))


def dropped(event) -> Path | None:
    """What hangs over a window or is dropped on it: one file or folder of this machine, or None."""
    urls = event.mimeData().urls()
    if len(urls) != 1 or not urls[0].isLocalFile():
        return None
    return Path(urls[0].toLocalFile())


def _small(action: QAction, sign: str) -> QPushButton:
    """A plain button of an action."""
    button = _SmallButton(sign)

    def follow() -> None:
        button.setText(plain(action.text()).replace("&", "&&"))
        button.setAccessibleName(plain(action.text()))
        button.setToolTip(action.toolTip())
        button.setStatusTip(action.statusTip())
        button.setEnabled(action.isEnabled())

    follow()
    action.changed.connect(follow)
    button.clicked.connect(action.trigger)
    return button


class _SmallButton(QPushButton):
    """A button whose sign follows the theme."""

    def __init__(self, sign: str) -> None:
        super().__init__()
        self._sign = sign
        self._show_sign()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._show_sign()

    def _show_sign(self) -> None:
        self.setIcon(icon(self._sign, theme_of(self.palette())))


def _left(path: Path) -> bool:
    """Whether a crash left a session open: its log lies beside it, and nobody writes to it."""
    try:
        if not Path(f"{path.resolve()}-wal").exists():
            return False
        from georibbon.session.lock import holder

        return holder(path) is None
    except OSError:
        return False


def _place(folder: Path) -> str:
    """A folder as people read it: one's own by its short name."""
    with suppress(RuntimeError, ValueError):  # nobody's home, or elsewhere
        return str("~" / folder.relative_to(Path.home()))
    return str(folder)


def _when(path: Path) -> str:
    """When it was written last, with what parts it from its place; nothing where that is hidden."""
    try:
        at = datetime.datetime.fromtimestamp(path.stat().st_mtime)
    except (OSError, ValueError, OverflowError):
        return ""
    locale = QLocale()
    time = locale.toString(at.time().replace(microsecond=0), QLocale.FormatType.ShortFormat)
    days = (datetime.date.today() - at.date()).days
    if days == 0:
        when = tr("today, {time}", time=time)
    elif days == 1:
        when = tr("yesterday, {time}", time=time)
    else:
        when = locale.toString(at.date(), QLocale.FormatType.ShortFormat)
    return f"{when}  ·  "
