"""The bar on its table, drawn from its attitude."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QSizePolicy, QWidget

from georibbon.gui.calibrating.bar_geometry import BarPicture, Face, bar_picture
from georibbon.gui.language import N_, tr
from georibbon.gui.theme import Colours, colours_of, theme_of

# What a picture needs in the geometry's units: its width, and how far down and up it reaches, the
# second where the bar lies flat and where one end is lifted.
WIDTH, BELOW, ABOVE, ABOVE_LIFTED = 3.3, 0.82, 0.85, 1.85
SENSORS = 7
SEEN = 0.01  # radians by which a bar must turn to be seen to
# Wood, the ribbon, and what tells the bar's ends apart, by theme: drawn things, not words.
LOOKS = {
    "light": {"bar": "#c9a36a", "ribbon": "#1f63b5", "end": "#c2500a", "block": "#9aa3ad"},
    "dark": {"bar": "#b8915a", "ribbon": "#3d84d6", "end": "#e07a33", "block": "#747d87"},
}
LETTERS = {
    "under": N_("below"), "left": N_("left"), "right": N_("right"), "end": N_("E"),
    "start": N_("S"),
}  # fmt: skip
TEXT_ON = "#16181c"  # on wood, in both themes


def paint_bar(
    painter: QPainter, area: QRectF, attitude, block: bool, colours: Colours, look, labels=True
) -> None:
    """Paint a bar of an attitude (3, 3) into an area; labels: the compass' figures too."""
    picture = bar_picture(attitude, block)
    above = ABOVE_LIFTED if block else ABOVE
    scale = min(area.width() / WIDTH, area.height() / (above + BELOW))
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(area.center())
    painter.scale(scale, scale)
    painter.translate(0.0, 0.5 * (above - BELOW))
    _paint_table(painter, picture, colours, scale, labels)
    for face in picture.block:
        _paint_face(painter, face, look["block"], colours, scale)
    for face in picture.bar:
        colour = look["end"] if face.name == "end" else look["bar"]
        _paint_face(painter, face, colour, colours, scale)
        _paint_on(painter, face, look)
    painter.restore()


def _paint_table(painter, picture: BarPicture, colours: Colours, scale: float, labels) -> None:
    line = QColor(colours.frame)
    painter.setPen(QPen(line, 1.2 / scale))
    painter.setBrush(QColor(colours.base))
    painter.drawPolygon(_polygon(picture.table))
    for tick in picture.ticks:
        painter.drawLine(QPointF(*tick[0]), QPointF(*tick[1]))
    shade = QColor(colours.words)
    shade.setAlpha(45)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(shade)
    painter.drawPolygon(_polygon(picture.shadow))
    _paint_arrow(painter, picture, QColor(colours.link), scale)
    if labels:
        for degrees, place in zip((0, 90, 180, 270), picture.labels, strict=True):
            _paint_text(painter, tr("{degrees}°", degrees=degrees), place, 0.15, colours.dim)


def _paint_arrow(painter, picture: BarPicture, colour: QColor, scale: float) -> None:
    """Where the end points, on the compass' rim."""
    middle, tip = (QPointF(*point) for point in picture.heading)
    along = tip - middle
    length = (along.x() ** 2 + along.y() ** 2) ** 0.5
    if length < 1e-6:
        return
    along /= length
    across = QPointF(-along.y(), along.x())
    painter.setPen(QPen(colour, 2.0 / scale))
    painter.drawLine(middle, tip)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    back = tip - 0.16 * along
    painter.drawPolygon(QPolygonF([tip + 0.06 * along, back + 0.09 * across, back - 0.09 * across]))


def _paint_face(painter, face: Face, colour: str, colours: Colours, scale: float) -> None:
    painter.setPen(QPen(QColor(colours.words), 1.0 / scale))
    painter.setBrush(QColor(colour).darker(round(100 + 55 * (1.0 - face.shade))))
    painter.drawPolygon(_polygon(face.corners))


def _paint_on(painter, face: Face, look) -> None:
    """What a face shows: the ribbon with its sensors on the upper one, a word on the others."""
    long = face.name not in ("end", "start")
    width, height = (200.0, 40.0) if long else (40.0, 28.0)
    sheet = QPolygonF(
        [QPointF(0, 0), QPointF(width, 0), QPointF(width, height), QPointF(0, height)]
    )
    turned = QTransform.quadToQuad(sheet, _polygon(face.corners))
    if turned is None:
        return
    painter.save()
    painter.setTransform(turned, combine=True)
    painter.setPen(Qt.PenStyle.NoPen)
    if face.name == "top":
        painter.setBrush(QColor(look["ribbon"]))
        painter.drawRect(QRectF(0, 0.2 * height, width, 0.6 * height))
        painter.setBrush(QColor("#ffffff"))
        for place in range(SENSORS):
            x = (place + 0.5) / SENSORS * width
            painter.drawRect(QRectF(x - 4.0, 0.36 * height, 8.0, 0.28 * height))
    else:
        painter.setPen(QColor(TEXT_ON))
        font = painter.font()
        font.setPixelSize(24 if long else 22)
        font.setBold(True)
        painter.setFont(font)
        painter.drawText(sheet.boundingRect(), Qt.AlignmentFlag.AlignCenter, tr(LETTERS[face.name]))
    painter.restore()


def _paint_text(painter, text: str, place, size: float, colour: str) -> None:
    """A text of a height in the picture's units, around a place."""
    painter.save()
    font = painter.font()
    font.setPixelSize(20)
    painter.setFont(font)
    painter.setPen(QColor(colour))
    painter.translate(*place)
    painter.scale(size / 20.0, size / 20.0)
    painter.drawText(QRectF(-60, -20, 120, 40), Qt.AlignmentFlag.AlignCenter, text)
    painter.restore()


def _polygon(points) -> QPolygonF:
    return QPolygonF([QPointF(*point) for point in points])


class BarView(QWidget):
    """One bar in an attitude, or nothing; caption: what it shows, in words."""

    def __init__(self, caption: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.caption = caption
        self.words = ""
        self.attitude = None
        self._block = False
        self.setAccessibleName(caption)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(110, 84)

    def sizeHint(self) -> QSize:
        """Wider than high."""
        return QSize(300, 220)

    def show_attitude(self, attitude, block: bool, words: str = "") -> None:
        """Show an attitude (3, 3); None: nothing to show, and the words say why."""
        if self._shows(attitude, block, words):
            return
        self.attitude, self._block, self.words = attitude, block, words
        self.setAccessibleDescription(words)
        self.update()

    def _shows(self, attitude, block: bool, words: str) -> bool:
        """Whether nobody would see a difference: at rest nothing is painted anew."""
        if (block, words) != (self._block, self.words):
            return False
        if attitude is None or self.attitude is None:
            return attitude is self.attitude
        return bool(abs(attitude - self.attitude).max() < SEEN)

    def paintEvent(self, _event) -> None:
        """The caption above, the bar, the words below."""
        colours = colours_of(self.palette())
        line = self.fontMetrics().height() + 4
        area = QRectF(self.rect()).adjusted(4, line, -4, -line)
        with QPainter(self) as painter:
            painter.setPen(QColor(colours.dim))
            top = QRectF(0, 0, self.width(), line)
            painter.drawText(top, Qt.AlignmentFlag.AlignCenter, self.caption)
            if self.attitude is not None:
                look = LOOKS[theme_of(self.palette())]
                paint_bar(painter, area, self.attitude, self._block, colours, look)
            painter.setPen(QColor(colours.words))
            below = QRectF(0, self.height() - line, self.width(), line)
            painter.drawText(below, Qt.AlignmentFlag.AlignCenter, self.words)
