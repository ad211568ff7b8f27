"""The two themes: what is read can be read."""

from itertools import combinations

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QCheckBox,
    QComboBox,
    QDockWidget,
    QDoubleSpinBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QMainWindow,
    QPlainTextEdit,
    QPushButton,
    QRadioButton,
    QSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.review.told import ToldLine
from georibbon.gui.style import FramedStyle
from georibbon.gui.theme import COLOURS, THEMES, apply_theme, contrast, palette, theme_of
from georibbon.scene.colours import DARK, WHITE

WORDS, SIGNS = 4.5, 3.0
ROLES = QPalette.ColorRole


def hexadecimal(colour):
    return QColor.fromRgbF(*colour).name()


@pytest.fixture
def app(qapp):
    """The application, with the colours it had given back."""
    before = qapp.palette()
    yield qapp
    qapp.setStyle("Fusion")
    qapp.setPalette(before)
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def test_the_measure_of_contrast():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)
    assert contrast("#123456", "#123456") == 1


@pytest.mark.parametrize("theme", THEMES)
def test_words_stand_out_from_every_ground(theme):
    of = COLOURS[theme]
    for ground in (of.window, of.base, of.other, of.button):
        assert contrast(of.words, ground) >= 7
        for words in (of.link, of.good, of.fair, of.poor):
            assert contrast(words, ground) >= WORDS, (words, ground)
    for ground in (of.window, of.base, of.other):
        assert contrast(of.dim, ground) >= WORDS, ground
    assert contrast(of.dim, of.button) >= SIGNS  # of what is not to be had now alone
    assert contrast(of.on_chosen, of.chosen) >= WORDS


@pytest.mark.parametrize("theme", THEMES)
def test_signs_stand_out(theme):
    of = COLOURS[theme]
    for ground in (of.window, of.base):
        for sign in (of.frame, of.link, *of.curves):
            assert contrast(sign, ground) >= SIGNS, (sign, ground)
    assert contrast(of.link, of.button) >= SIGNS  # the frame of a button where the keys are
    assert contrast(of.chosen, of.base) >= SIGNS


@pytest.mark.parametrize(("theme", "paper"), [("light", WHITE), ("dark", DARK)])
def test_the_3d_view_is_as_readable_on_its_themes_ground(theme, paper):
    ground = hexadecimal(paper.background)
    assert ground == COLOURS[theme].base
    for words in (paper.ink, paper.grid_words):
        assert contrast(hexadecimal(words), ground) >= WORDS
    for sign in (paper.run, paper.tie, paper.mark, *paper.axes):
        assert contrast(hexadecimal(sign), ground) >= SIGNS


@pytest.mark.parametrize("theme", THEMES)
def test_no_two_curves_are_alike(theme):
    for one, other in combinations([QColor(c) for c in COLOURS[theme].curves], 2):
        away = sum((a - b) ** 2 for a, b in zip(one.getRgb(), other.getRgb(), strict=True))
        assert away**0.5 > 50, (one.name(), other.name())


@pytest.mark.parametrize("theme", THEMES)
def test_the_palette_is_complete_in_every_group(theme):
    made = palette(theme)
    for group in (QPalette.ColorGroup.Active, QPalette.ColorGroup.Inactive):
        for words, ground in (
            (ROLES.WindowText, ROLES.Window), (ROLES.Text, ROLES.Base),
            (ROLES.Text, ROLES.AlternateBase), (ROLES.ButtonText, ROLES.Button),
            (ROLES.ToolTipText, ROLES.ToolTipBase), (ROLES.HighlightedText, ROLES.Highlight),
            (ROLES.PlaceholderText, ROLES.Base), (ROLES.Link, ROLES.Base),
        ):  # fmt: skip
            pair = made.color(group, words).name(), made.color(group, ground).name()
            assert contrast(*pair) >= WORDS, (words, ground)
    assert theme_of(made) == theme


@pytest.mark.parametrize("theme", THEMES)
def test_applied_it_reaches_windows_that_are_there(app, qtbot, theme):
    label = QLabel("words")
    button = QPushButton("button")
    for widget in (label, button):
        qtbot.addWidget(widget)
        with qtbot.waitExposed(widget):
            widget.show()
    apply_theme(app, theme)
    assert isinstance(app.style(), FramedStyle)
    words = COLOURS[theme].words
    qtbot.waitUntil(lambda: label.palette().color(ROLES.WindowText).name() == words)
    assert button.palette().color(ROLES.Button).name() == COLOURS[theme].button
    image = label.grab().toImage()
    corner = image.pixelColor(image.width() - 1, image.height() - 1)
    assert corner.name() == COLOURS[theme].window


FRAMED = {
    "box": lambda: QCheckBox(""),
    "ticked box": lambda: _checked(QCheckBox("")),
    "round box": lambda: QRadioButton(""),
    "choice": QComboBox,
    "number": QDoubleSpinBox,
    "line": QLineEdit,
    "text": QPlainTextEdit,
    "list": QListWidget,
    "button": lambda: QPushButton("Do"),
    "slider": lambda: QSlider(Qt.Orientation.Horizontal),
}


def _checked(box):
    box.setChecked(True)
    return box


def strongest(widget, ground):
    """By how much the sign that stands out most from a ground does so."""
    image = widget.grab().toImage()
    seen = {
        image.pixelColor(x, y).name() for x in range(image.width()) for y in range(image.height())
    }
    return max(contrast(colour, ground) for colour in seen)


def frame_of(widget):
    """The colours along the widget's edge, in its middle row from the left, within 12 px."""
    image = widget.grab().toImage()
    row = image.height() // 2
    return [image.pixelColor(x, row).name() for x in range(min(12, image.width()))]


@pytest.fixture
def beside(qtbot):
    """Puts widgets into a window that has the keys."""
    windows = []

    def put(*widgets):
        window = QWidget()
        windows.append(window)
        qtbot.addWidget(window)
        layout = QVBoxLayout(window)
        for widget in widgets:
            layout.addWidget(widget)
        with qtbot.waitActive(window):
            window.show()
            window.activateWindow()
        return widgets

    return put


@pytest.mark.parametrize("theme", THEMES)
def test_frames_stand_out_from_the_window(app, beside, theme):
    apply_theme(app, theme)
    made = {name: make() for name, make in FRAMED.items()}
    *_, other = beside(*made.values(), QPushButton("Other"))
    other.setFocus()
    of = COLOURS[theme]
    assert strongest(made.pop("slider"), of.window) >= SIGNS  # its handle is somewhere in it
    for name, widget in made.items():
        edge = frame_of(widget)
        assert max(contrast(colour, of.window) for colour in edge[:6]) >= SIGNS, (name, edge)
        if name not in ("choice", "button", "ticked box"):  # told apart from what is in it too
            assert of.base in edge, name
            assert max(contrast(colour, of.base) for colour in edge) >= SIGNS, (name, edge)


@pytest.mark.parametrize("theme", THEMES)
def test_where_the_keys_are_is_seen(app, beside, qtbot, theme):
    apply_theme(app, theme)
    made = {name: make() for name, make in FRAMED.items()}
    *_, other = beside(*made.values(), QPushButton("Other"))
    link = COLOURS[theme].link
    for name, widget in made.items():
        other.setFocus()
        before = widget.grab().toImage()
        widget.setFocus(Qt.FocusReason.TabFocusReason)
        qtbot.waitUntil(widget.hasFocus)
        after = widget.grab().toImage()
        seen = {
            after.pixelColor(x, y).name()
            for x in range(after.width()) for y in range(after.height())
            if after.pixel(x, y) != before.pixel(x, y)
        }  # fmt: skip
        assert link in seen, name


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("kind", [QPushButton, QToolButton])
def test_a_button_that_is_held_down_is_seen_and_read(app, beside, theme, kind):
    apply_theme(app, theme)
    up, down, _ = beside(kind(), kind(), QPushButton("Other"))
    for button in (up, down):
        button.setFixedSize(60, 40)
        button.setCheckable(True)
    down.setChecked(True)
    of = COLOURS[theme]
    grounds = [one.grab().toImage().pixelColor(12, 20) for one in (up, down)]
    assert sum(abs(a - b) for a, b in zip(*(one.getRgb() for one in grounds), strict=True)) > 60
    assert contrast(of.words, grounds[1].name()) >= WORDS
    assert contrast(frame_of(down)[0], of.window) >= SIGNS


@pytest.mark.parametrize("theme", THEMES)
def test_the_signs_of_docks_and_toolbars_stand_out(app, qtbot, theme):
    apply_theme(app, theme)
    window = QMainWindow()
    qtbot.addWidget(window)
    dock = QDockWidget("Dock")
    window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
    bar = window.addToolBar("Bar")
    for number in range(20):
        bar.addAction(f"Action {number}")
    window.resize(300, 200)
    with qtbot.waitExposed(window):
        window.show()
    names = ("qt_dockwidget_closebutton", "qt_dockwidget_floatbutton", "qt_toolbar_ext_button")
    for name in names:
        (button,) = [
            one for one in window.findChildren(QAbstractButton) if one.objectName() == name
        ]
        assert button.isVisible()
        assert strongest(button, COLOURS[theme].window) >= SIGNS, name


def test_there_and_back(app):
    apply_theme(app, "dark")
    style = app.style()
    apply_theme(app, "light")
    assert app.style() is style
    assert theme_of(QApplication.palette()) == "light"


def test_another_theme_is_refused(app):
    with pytest.raises(ValueError, match="no theme pink"):
        apply_theme(app, "pink")


@pytest.mark.parametrize("kind", ["plain", "good", "poor"])
def test_what_is_told_stays_readable_when_the_theme_changes(qtbot, app, kind):
    window = QWidget()
    qtbot.addWidget(window)
    line = ToldLine(window)
    window.show()
    for name in ("light", "dark", "light"):
        apply_theme(app, name)
        QApplication.processEvents()
        if not line.text():
            line.tell("It is so.", kind)
        words = line.palette().color(ROLES.WindowText).name()
        assert contrast(words, COLOURS[name].window) >= WORDS
