"""Qt's Fusion style with frames that can be seen.

Fusion draws the frames of boxes, fields and buttons a shade darker than the window,
which on a dark ground nobody sees; here they are drawn over it in the theme's frame
colour, 3 to 1 at least, and where the keys are they are thick and in the link's.
"""

from collections.abc import Callable

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette, QPen
from PySide6.QtWidgets import QProxyStyle, QStyle, QStyleOption, QToolBar, QWidget

from georibbon.gui.icons import icon
from georibbon.gui.theme import Theme, colours_of, theme_of

_Primitive, _Control, _Complex = (
    QStyle.PrimitiveElement,
    QStyle.ControlElement,
    QStyle.ComplexControl,
)
_State, _Sub, _Pixmap = QStyle.StateFlag, QStyle.SubControl, QStyle.StandardPixmap

# What is framed over Fusion's drawing, with its corners' radius in px.
_FRAMED = {
    _Primitive.PE_IndicatorCheckBox: 1.0,
    _Primitive.PE_IndicatorItemViewItemCheck: 1.0,
    _Primitive.PE_FrameLineEdit: 2.0,
    _Primitive.PE_PanelButtonCommand: 2.0,
    _Primitive.PE_FrameGroupBox: 2.0,
    _Primitive.PE_Frame: 0.0,
}
# What shows where the keys are by itself.
_FOCUSED = frozenset((
    _Primitive.PE_IndicatorCheckBox, _Primitive.PE_FrameLineEdit, _Primitive.PE_PanelButtonCommand,
    _Primitive.PE_Frame,
))  # fmt: skip


_BUTTONS = (_Primitive.PE_PanelButtonCommand, _Primitive.PE_PanelButtonTool)
_TINT: dict[Theme, float] = {"light": 0.3, "dark": 0.45}  # on a button that is held down


# Signs that Fusion draws in black, or hardly lighter than the window; ours are of a grey that
# stands out from both themes' windows, since they are not asked for again when the theme changes.
_SIGNS = {
    _Pixmap.SP_DockWidgetCloseButton: "dock-close",
    _Pixmap.SP_TitleBarCloseButton: "dock-close",
    _Pixmap.SP_TitleBarNormalButton: "dock-float",
    _Pixmap.SP_ToolBarHorizontalExtensionButton: "more",
    _Pixmap.SP_ToolBarVerticalExtensionButton: "more-below",
}


class FramedStyle(QProxyStyle):
    """Fusion, with its frames in the theme's colours."""

    def __init__(self) -> None:
        super().__init__("Fusion")

    def drawPrimitive(self, element, option, painter, widget=None) -> None:
        """As Fusion draws it, and its frame over it."""
        if element == _Primitive.PE_FrameFocusRect:
            _stroke(painter, option, option.rect, 2.0, focused=True)
            return
        super().drawPrimitive(element, option, painter, widget)
        if element in _BUTTONS and option.state & _State.State_On:
            _tint(painter, option)
        if element == _Primitive.PE_IndicatorRadioButton:
            _draw_round(painter, option)
        elif element in _FRAMED and not _is_flat(element, option):
            focused = element in _FOCUSED and bool(option.state & _State.State_HasFocus)
            _stroke(painter, option, option.rect, _FRAMED[element], focused)

    def standardIcon(self, sign, option=None, widget=None) -> QIcon:
        """Our own where there is one."""
        if sign in _SIGNS:
            return icon(_SIGNS[sign], "light")
        return super().standardIcon(sign, option, widget)

    def styleHint(self, hint, option=None, widget=None, data=None) -> int:
        """As Fusion's, but that the buttons of dialogs have words alone, as all others."""
        if hint == QStyle.StyleHint.SH_DialogButtonBox_ButtonsHaveIcons:
            return 0
        return super().styleHint(hint, option, widget, data)

    def drawControl(self, element, option, painter, widget=None) -> None:
        """As Fusion draws it; bars flat, titles of columns with a selection not bold, so cut."""
        if element == _Control.CE_ToolBar:
            _draw_bar(painter, option, widget)
            return
        if element == _Control.CE_HeaderLabel:
            option.state &= ~_State.State_On
        super().drawControl(element, option, painter, widget)

    def drawComplexControl(self, control, option, painter, widget=None) -> None:
        """As Fusion draws it, and its frame over it."""
        super().drawComplexControl(control, option, painter, widget)
        focused = bool(option.state & _State.State_HasFocus)
        if control in (_Complex.CC_ComboBox, _Complex.CC_SpinBox):
            _stroke(painter, option, option.rect, 2.0, focused)
        elif control == _Complex.CC_Slider:
            handle = self.subControlRect(control, option, _Sub.SC_SliderHandle, widget)
            _stroke(painter, option, handle.adjusted(1, 1, -1, -1), 2.0, focused)


def _draw_bar(painter: QPainter, option: QStyleOption, bar: QWidget | None) -> None:
    """A bar's flat ground, and a line on the side of what it belongs to."""
    of, rect = colours_of(option.palette), option.rect
    painter.save()
    painter.fillRect(rect, QColor(of.window))
    line = QColor(of.frame)
    line.setAlphaF(0.5)
    painter.setPen(QPen(line, 1.0))
    if isinstance(bar, QToolBar) and bar.orientation() == Qt.Orientation.Vertical:
        painter.drawLine(rect.topRight(), rect.bottomRight())
    else:
        painter.drawLine(rect.bottomLeft(), rect.bottomRight())
    painter.restore()


def _is_flat(element: QStyle.PrimitiveElement, option: QStyleOption) -> bool:
    """Whether it is a button that stands on its ground without a frame."""
    raised = _State.State_Raised | _State.State_Sunken | _State.State_On
    return element == _Primitive.PE_PanelButtonCommand and not option.state & raised


def _stroke(
    painter: QPainter, option: QStyleOption, rect: QRect, radius: float, focused: bool
) -> None:
    """A rounded frame just inside a rectangle."""
    _paint(
        painter, option, rect, focused, lambda inner: painter.drawRoundedRect(inner, radius, radius)
    )


def _tint(painter: QPainter, option: QStyleOption) -> None:
    """Show that a button is held down: in the colour of what is chosen."""
    of = colours_of(option.palette)
    ground = QColor(of.chosen)
    tint = _TINT[theme_of(option.palette)]  # its words are read on it
    ground.setAlphaF(tint if option.state & _State.State_Enabled else tint / 2)
    frame = QColor(of.link)
    if not option.state & _State.State_Enabled:
        frame.setAlphaF(0.5)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(frame, 1.0))
    painter.setBrush(ground)
    painter.drawRoundedRect(QRectF(option.rect).adjusted(0.5, 0.5, -0.5, -0.5), 2.0, 2.0)
    painter.restore()


def _draw_round(painter: QPainter, option: QStyleOption) -> None:
    """A round frame just inside."""
    focused = bool(option.state & _State.State_HasFocus)
    _paint(painter, option, option.rect, focused, painter.drawEllipse)


def _paint(
    painter: QPainter,
    option: QStyleOption,
    rect: QRect,
    focused: bool,
    draw: Callable[[QRectF], None],
) -> None:
    width = 2.0 if focused else 1.0
    half = width / 2
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(_colour(option, focused), width))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    draw(QRectF(rect).adjusted(half, half, -half, -half))
    painter.restore()


def _colour(option: QStyleOption, focused: bool) -> QColor:
    of = colours_of(option.palette)
    if focused:
        chosen = option.state & _State.State_Item and option.state & _State.State_Selected
        return QColor(of.on_chosen if chosen else of.link)
    colour = QColor(of.frame)
    if not option.state & _State.State_Enabled or (
        option.palette.currentColorGroup() == QPalette.ColorGroup.Disabled
    ):
        colour.setAlphaF(0.5)  # what is not to be had now need not stand out
    return colour
