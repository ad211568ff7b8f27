"""The catalogues are up to date, whole and in order, and the window is seen in French."""

import importlib.util
import io
import re
from pathlib import Path

import pytest
from babel.messages.pofile import read_po
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QDialogButtonBox,
    QGroupBox,
    QLabel,
    QMenu,
    QTabWidget,
    QTreeWidget,
    QWidget,
)

from georibbon.gui import language
from georibbon.gui.actions import ACTIONS, MENUS
from georibbon.gui.app import take_up
from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow

ROOT = Path(__file__).resolve().parents[2]
MNEMONIC = re.compile(r"&(?!&)(.)")
SPACED = re.compile(r"\S [:;?!»%](?!:)|« |\w [.,](?:\s|$)")
# The same in both languages, or no words.
ALIKE = re.compile(r"^[\W\d_]*$|^[xyz]$")


def _tool():
    spec = importlib.util.spec_from_file_location(
        "translations", ROOT / "packaging" / "translations.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TOOL = _tool()
FILES = TOOL.files("fr")


def catalogue(name):
    """The messages of a .po file as it is kept."""
    (path,) = (path for path in FILES if path.name == name)
    return [one for one in read_po(io.BytesIO(path.read_bytes())) if one.id]


def pairs(name):
    """(English, French) of every message, the plural ones several."""
    for one in catalogue(name):
        many = isinstance(one.id, tuple)
        yield from zip(one.id, one.string, strict=True) if many else ((one.id, one.string),)


@pytest.fixture
def french(qapp):
    """The window's words in French, and in English again afterwards."""
    take_up(qapp, "fr")
    yield "fr"
    take_up(qapp, "en")


@pytest.fixture
def window(french, tmp_path, qtbot):
    settings = Settings(tmp_path / "settings.ini")
    settings.language = french
    window = MainWindow(settings, Notifier())
    qtbot.addWidget(window)
    window.show()
    yield window
    window.close()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_catalogues_are_those_of_the_code(path):
    same = path.read_bytes() == FILES[path]  # to tell where they differ would take minutes
    assert same, "run packaging/translations.py"


def test_every_text_of_the_window_is_translated():
    assert TOOL.untranslated(FILES[_path("georibbon.po")]) == []


@pytest.mark.parametrize("name", ["georibbon.po", "sentences.po"])
def test_names_are_those_of_the_text(name):
    assert TOOL.misfits(FILES[_path(name)]) == []


def _path(name):
    return next(path for path in FILES if path.name == name)


@pytest.mark.parametrize("name", ["georibbon.po", "sentences.po"])
def test_french_is_set_as_french(name):
    """A blank that breaks no line before : ; ? ! » and %; blanks at the ends as in English."""
    wrong = [other for _, other in pairs(name) if SPACED.search(other)]
    assert wrong == []
    cut = [other for one, other in pairs(name) if other and _ends(one) != _ends(other)]
    assert cut == []


def _ends(text):
    """The blanks at both ends, but before a sign that stands off in French."""
    text = re.sub("^\\N{NO-BREAK SPACE}(?=[;:?!%])", "", text)
    return text[:1] == " ", text[-1:] == " "


def test_keys_of_texts_are_kept_and_are_letters():
    for one, other in pairs("georibbon.po"):
        english, translated = (MNEMONIC.findall(re.sub("<.*?>", "", text)) for text in (one, other))
        assert len(english) == len(translated), other
        assert all(key.isalpha() and key.isascii() for key in translated), other
        assert one.endswith("…") == other.endswith("…"), other


def test_most_sentences_of_the_core_are_translated():
    messages = catalogue("sentences.po")
    assert sum(bool(one.string) for one in messages) > 0.9 * len(messages)


def test_the_menus_are_french_and_every_key_in_them_is_its_own(window):
    titles = [action.text() for action in window.menuBar().actions()]
    assert titles == [language.tr(menu) for menu in MENUS]
    assert "&Fichier" in titles
    for menu in (window.menuBar(), *window.menuBar().findChildren(QMenu)):
        keys = [key.lower() for one in menu.actions() for key in MNEMONIC.findall(one.text())]
        assert len(keys) == len(set(keys)), [one.text() for one in menu.actions()]


def test_the_next_window_is_english_again(qapp, tmp_path, qtbot):
    said = []
    for name in ("fr", "en"):
        take_up(qapp, name)
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        qtbot.addWidget(box)
        said.append(box.buttons()[0].text().replace("&", ""))
    assert said == ["Annuler", "Cancel"]
    window = MainWindow(Settings(tmp_path / "settings.ini"), Notifier())
    qtbot.addWidget(window)
    assert [one.text() for one in window.menuBar().actions()] == list(MENUS)


def test_no_page_shows_english(window, session, qtbot):
    with qtbot.waitSignal(window.document.reconstructed, timeout=60_000):
        window.open(session)
    english = _english()
    found = {}
    for page in ("start", "connect", "calibrate", "capture", "review"):
        window.show_page(page)
        found[page] = sorted(set(_texts(window)) & english)
    assert found == {page: [] for page in found}
    told = [action.statusTip() for action in window.findChildren(QAction)]
    assert set(told) & english == set()
    assert len(ACTIONS) > 40


def _english():
    """The English texts that are another text in French, as they are seen."""
    return {_plain(one) for one, other in pairs("georibbon.po") if one != other} - {
        _plain(other) for _, other in pairs("georibbon.po")
    }


def _plain(text):
    return MNEMONIC.sub(r"\1", text)


def _texts(window):
    """Every text of the window's widgets, shown or not."""
    for widget in window.findChildren(QWidget):
        yield from (widget.toolTip(), widget.accessibleName(), widget.accessibleDescription())
        match widget:
            case QLabel() | QAbstractButton():
                yield _plain(widget.text())
            case QGroupBox():
                yield _plain(widget.title())
            case QComboBox():
                yield from (widget.itemText(k) for k in range(widget.count()))
            case QTabWidget():
                yield from (_plain(widget.tabText(k)) for k in range(widget.count()))
            case QTreeWidget():
                head = widget.headerItem()
                yield from (head.text(k) for k in range(head.columnCount()))
            case _:
                yield widget.windowTitle()
    for action in window.findChildren(QAction):
        if not isinstance(action.parent(), QWidget):
            continue  # a plot's own, of the library, which no menu of the window shows
        yield from (_plain(action.text()), action.toolTip(), action.statusTip())
