"""The two themes: what is read can be read."""

from itertools import combinations

import pytest
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from georibbon.gui.theme import COLOURS, THEMES, apply_theme, contrast, palette, theme_of
from georibbon.scene.colours import DARK, WHITE

WORDS, SIGNS = 4.5, 3.0
ROLES = QPalette.ColorRole


def hexadecimal(colour):
    return QColor.fromRgbF(*colour).name()


@pytest.fixture
def app(qapp):
    """The application, with the colours it had given back."""
    style, before = qapp.style().name(), qapp.palette()
    yield qapp
    qapp.setStyle(style)
    qapp.setPalette(before)


def test_the_measure_of_contrast():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)
    assert contrast("#123456", "#123456") == 1


@pytest.mark.parametrize("theme", THEMES)
def test_words_stand_out_from_every_ground(theme):
    of = COLOURS[theme]
    for ground in (of.window, of.base, of.other, of.button):
        assert contrast(of.words, ground) >= 7
    for ground in (of.window, of.base, of.other):
        for words in (of.dim, of.link, of.good, of.fair, of.poor):
            assert contrast(words, ground) >= WORDS, (words, ground)
    assert contrast(of.on_chosen, of.chosen) >= WORDS


@pytest.mark.parametrize("theme", THEMES)
def test_signs_stand_out(theme):
    of = COLOURS[theme]
    for ground in (of.window, of.base):
        for sign in (of.frame, *of.curves):
            assert contrast(sign, ground) >= SIGNS, (sign, ground)
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
    assert app.style().name() == "fusion"
    words = COLOURS[theme].words
    qtbot.waitUntil(lambda: label.palette().color(ROLES.WindowText).name() == words)
    assert button.palette().color(ROLES.Button).name() == COLOURS[theme].button
    image = label.grab().toImage()
    corner = image.pixelColor(image.width() - 1, image.height() - 1)
    assert corner.name() == COLOURS[theme].window


def test_there_and_back(app):
    apply_theme(app, "dark")
    apply_theme(app, "light")
    assert theme_of(QApplication.palette()) == "light"


def test_another_theme_is_refused(app):
    with pytest.raises(ValueError, match="no theme pink"):
        apply_theme(app, "pink")
