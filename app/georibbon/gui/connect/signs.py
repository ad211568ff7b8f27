"""The signs of the link's states: a shape for each, besides its colour and its word."""

from typing import Literal

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPen, QPixmap, QPolygonF

from georibbon.device.telling import LinkState
from georibbon.gui.theme import Colours

Sign = Literal["none", "opening", "streaming", "stalled", "gone"]
SIZE = 16


def sign_of(state: LinkState, known: bool) -> Sign:
    """The sign of a state; known: a ribbon has answered on this connection before."""
    if state is LinkState.DISCONNECTED:
        return "gone" if known else "none"
    signs: dict[LinkState, Sign] = {
        LinkState.OPENING: "opening",
        LinkState.STREAMING: "streaming",
        LinkState.STALLED: "stalled",
    }
    return signs[state]


def sign_icon(sign: Sign, of: Colours, ratio: float = 1.0) -> QIcon:
    """A ring for nothing, dots for a try, a disc for frames, a triangle for a stall, a cross."""
    pixmap = QPixmap(round(SIZE * ratio), round(SIZE * ratio))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    _DRAW[sign](painter, of)
    painter.end()
    return QIcon(pixmap)


def _ring(painter: QPainter, of: Colours) -> None:
    painter.setPen(QPen(QColor(of.dim), 2.0))
    painter.drawEllipse(QRectF(3, 3, 10, 10))


def _dots(painter: QPainter, of: Colours) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(of.fair))
    for x in (3, 8, 13):
        painter.drawEllipse(QPointF(x, 8), 2, 2)


def _disc(painter: QPainter, of: Colours) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(of.good))
    painter.drawEllipse(QRectF(2, 2, 12, 12))


def _triangle(painter: QPainter, of: Colours) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(of.fair))
    painter.drawPolygon(QPolygonF([QPointF(8, 1.5), QPointF(15, 14), QPointF(1, 14)]))


def _cross(painter: QPainter, of: Colours) -> None:
    painter.setPen(QPen(QColor(of.poor), 2.5))
    painter.drawLine(QPointF(3, 3), QPointF(13, 13))
    painter.drawLine(QPointF(13, 3), QPointF(3, 13))


_DRAW = {
    "none": _ring,
    "opening": _dots,
    "streaming": _disc,
    "stalled": _triangle,
    "gone": _cross,
}
