"""Finds words that a widget has no room for, as far as that can be told without eyes."""

from collections.abc import Iterator

from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QTextDocument
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractScrollArea,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QGroupBox,
    QHeaderView,
    QLabel,
    QRadioButton,
    QSizePolicy,
    QSpinBox,
    QStyle,
    QStyleOptionComboBox,
    QStyleOptionSpinBox,
    QTabBar,
    QToolButton,
    QWidget,
)

SLACK = 1  # px


def clipped(window: QWidget) -> list[str]:
    """What of a window and all that is in it lacks room, a line each."""
    found = []
    for widget in (window, *window.findChildren(QWidget)):
        if (
            widget.isVisible()
            and widget.window() is window
            and not widget.visibleRegion().isEmpty()
        ):
            found += [f"{_told(widget)}: {what}" for what in _of(widget) if not _gives_way(widget)]
    return found


def _told(widget: QWidget) -> str:
    kind = type(widget)
    while not kind.__module__.startswith("PySide6"):
        kind = kind.__base__
    own = type(widget).__name__
    return kind.__name__ if own == kind.__name__ else f"{own} ({kind.__name__})"


def _gives_way(widget: QWidget) -> bool:
    """Whether it is meant to be cut: a remark of any width, whole in its tool tip."""
    gives = widget.sizePolicy().horizontalPolicy() == QSizePolicy.Policy.Ignored
    return gives and set(_words(widget).split()) <= set(widget.toolTip().split())


def _words(widget: QWidget) -> str:
    text = getattr(widget, "text", None)
    return text() if callable(text) else ""


def _of(widget: QWidget) -> Iterator[str]:
    """What a single widget lacks."""
    yield from _outside(widget)
    if isinstance(widget, QLabel):
        yield from _label(widget)
    elif isinstance(widget, QAbstractButton):
        yield from _wide(widget.text(), _button_width(widget), widget.width())
    elif isinstance(widget, QComboBox):
        option = QStyleOptionComboBox()
        widget.initStyleOption(option)
        yield from _field(widget, widget.currentText(), option, QStyle.ComplexControl.CC_ComboBox,
                          QStyle.SubControl.SC_ComboBoxEditField)  # fmt: skip
    elif isinstance(widget, (QSpinBox, QDoubleSpinBox)):
        option = QStyleOptionSpinBox()
        widget.initStyleOption(option)
        yield from _field(widget, widget.text(), option, QStyle.ComplexControl.CC_SpinBox,
                          QStyle.SubControl.SC_SpinBoxEditField)  # fmt: skip
    elif isinstance(widget, QGroupBox):
        needed = widget.fontMetrics().horizontalAdvance(widget.title())
        yield from _wide(widget.title(), needed, widget.width())
    elif isinstance(widget, QHeaderView):
        yield from _header(widget)
    elif isinstance(widget, QTabBar):
        yield from _tabs(widget)


def _wide(text: str, needed: int, there: int) -> Iterator[str]:
    if text and needed > there + SLACK:
        yield f"{text!r} needs {needed} px and has {there}"


def _button_width(button: QAbstractButton) -> int:
    """What its words and its icon need at least, without the air around them."""
    plain = button.text().replace("&&", "\0").replace("&", "").replace("\0", "&")
    words = max(button.fontMetrics().horizontalAdvance(line) for line in plain.split("\n"))
    if isinstance(button, (QCheckBox, QRadioButton)):
        return button.sizeHint().width()
    beside = not isinstance(button, QToolButton) or (
        button.toolButtonStyle() == Qt.ToolButtonStyle.ToolButtonTextBesideIcon
    )
    return words + (0 if button.icon().isNull() or not beside else button.iconSize().width() + 4)


def _label(label: QLabel) -> Iterator[str]:
    text, room = label.text(), label.contentsRect()
    if not text:
        return
    if label.wordWrap():
        needed = label.heightForWidth(label.width())
        if needed > label.height() + SLACK:
            yield f"{text!r} needs {needed} px of height and has {label.height()}"
        return
    if label.textFormat() != Qt.TextFormat.PlainText and "</" in text:
        document = QTextDocument()
        document.setDefaultFont(label.font())
        document.setDocumentMargin(0)
        document.setHtml(text)
        needed = round(document.idealWidth())
    else:
        plain = text.replace("&&", "\0").replace("&", "").replace("\0", "&")
        needed = max(label.fontMetrics().horizontalAdvance(line) for line in plain.split("\n"))
    yield from _wide(text, needed, room.width())


def _field(widget, text, option, control, part) -> Iterator[str]:
    """Words in the field of a box."""
    field: QRect = widget.style().subControlRect(control, option, part, widget)
    yield from _wide(text, widget.fontMetrics().horizontalAdvance(text), field.width())


def _header(header: QHeaderView) -> Iterator[str]:
    model = header.model()
    if header.orientation() == Qt.Orientation.Vertical or model is None:
        return
    for section in range(header.count()):
        title = model.headerData(section, Qt.Orientation.Horizontal)
        if title and not header.isSectionHidden(section):
            needed = header.fontMetrics().horizontalAdvance(str(title))
            yield from _wide(str(title), needed, header.sectionSize(section))


def _tabs(bar: QTabBar) -> Iterator[str]:
    for k in range(bar.count()):
        if bar.isTabVisible(k) and not bar.usesScrollButtons():
            needed = bar.fontMetrics().horizontalAdvance(bar.tabText(k).replace("&", ""))
            yield from _wide(bar.tabText(k), needed, bar.tabRect(k).width())
    last = bar.tabRect(bar.count() - 1)
    if bar.count() and last.right() > bar.width() + SLACK:
        yield f"its tabs need {last.right()} px and have {bar.width()}"


def _outside(widget: QWidget) -> Iterator[str]:
    """Whether it stands out of its parent, where that cannot be scrolled."""
    parent = widget.parentWidget()
    if widget.isWindow() or parent is None or not isinstance(widget, (QLabel, QAbstractButton)):
        return
    if isinstance(parent, QAbstractScrollArea) or isinstance(
        parent.parentWidget(), QAbstractScrollArea
    ):
        return
    if not parent.rect().adjusted(-SLACK, -SLACK, SLACK, SLACK).contains(widget.geometry()):
        yield f"{_words(widget)!r} stands out of its parent"
