"""The manual: its pages are whole, its links stay inside, and it is found in."""

import re
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QImage, QPalette, QTextDocument
from PySide6.QtWidgets import QWidget

from georibbon.gui.actions import ACTIONS
from georibbon.gui.help import manual
from georibbon.gui.help.manual import TOPICS, folded, read_manual, search, slug, target
from georibbon.gui.help.window import HelpWindow, action_rows
from georibbon.gui.settings import Settings
from georibbon.gui.theme import palette

# Said by the offscreen platform, which has no windows one above the other.
pytestmark = pytest.mark.qt_log_ignore("This plugin does not support raise", extend=True)
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)]*)\)")
PAGES = {language: read_manual(language, action_rows()) for language in ("en", "fr")}
# (language, page) of all that are written, not made.
WRITTEN = [(name, one) for name, pages in PAGES.items() for one in pages if one.topic != "keyboard"]


def test_there_is_a_page_of_every_topic():
    for pages in PAGES.values():
        assert tuple(one.topic for one in pages) == TOPICS
        assert all(one.title and len(one.plain) > 100 for one in pages)
    titles = [one.title for one in PAGES["en"]]
    assert len(set(titles)) == len(titles)


def test_every_link_leads_to_a_section_that_is_there():
    followed = 0
    for language, one in WRITTEN:
        known = {other.topic: other for other in PAGES[language]}
        for link in LINK.findall(one.text):
            place = target(link)
            assert place is not None, (language, one.topic, link)
            topic, section = place
            there = {slug(name) for name in known[topic or one.topic].sections}
            assert not section or section in there, (language, one.topic, link)
            followed += 1
    assert followed >= 20


def test_pages_hold_no_markup_of_another_kind():
    for language, one in WRITTEN:
        where = (language, one.topic)
        assert not re.search(r"<[a-zA-Z/!]|https?:", one.text), where
        for picture in re.findall(r"^.*!\[.*$", one.text, re.MULTILINE):
            assert manual._PICTURE.fullmatch(picture), (*where, picture)


def test_a_page_has_the_same_sections_and_pictures_in_every_language():
    for english, french in zip(*(PAGES[language] for language in ("en", "fr")), strict=True):
        assert len(english.sections) == len(french.sections), english.topic
        pictures = [re.findall(r"pictures/[a-z-]+", one.text) for one in (english, french)]
        assert pictures[0] == pictures[1], english.topic


def test_the_keys_of_every_action_are_listed():
    text = PAGES["en"][-1].text
    rows = re.findall(r"^\| .* \|$", text, re.MULTILINE)
    assert len(rows) == len(ACTIONS) + text.count("| Action |")
    for _, words, keys, tip in action_rows():
        assert any(manual._cell(words) in row and manual._cell(keys) in row for row in rows), words
        assert manual._cell(tip) in text


def test_links_lead_within_or_nowhere():
    for link in ("https://example.org", "file:///etc/passwd", "../../x.md", "nowhere.md", "start"):
        assert target(link) is None
    assert target("start.txt") is None
    assert target("capture.md") == ("capture", "")
    assert target("capture.md#plan") == ("capture", "plan")
    assert target("#plan") == ("", "plan")


@given(st.text())
def test_any_words_may_be_looked_for(words):
    for hit in search(PAGES["en"], words):
        assert hit.topic in TOPICS
        assert "\n" not in hit.around


@given(st.text())
def test_folding_keeps_every_place(text):
    assert len(folded(text)) == len(text)


def test_what_stands_on_a_page_is_found_on_it():
    assert "survey" in {hit.topic for hit in search(PAGES["en"], "CALLIPERS tape")}
    first = search(PAGES["en"], "daily check")[0]
    assert (first.topic, first.section) == ("calibrate", "The daily check")
    assert "Three poses" in first.around
    assert search(PAGES["en"], "nowhere-to-be-found") == []
    assert search(PAGES["en"], "   ") == []
    page = manual.Page("a", "Étalonner", "# Étalonner\n\nLa règle\n", ())
    assert len(search([page], "etalonner regle")) == 1


def test_a_language_that_lacks_a_page_shows_it_in_english(monkeypatch, tmp_path):
    (tmp_path / "help" / "en").mkdir(parents=True)
    (tmp_path / "help" / "en" / "start.md").write_text("# Beginning\n", encoding="utf-8")

    def resource(name):
        if not (tmp_path / name).exists():
            raise FileNotFoundError(name)
        return tmp_path / name

    monkeypatch.setattr(manual, "resource", resource)
    pages = read_manual("fr", [])
    assert (pages[0].title, pages[1].title) == ("Beginning", "connect")


@pytest.fixture
def parts(tmp_path):
    settings = Settings(tmp_path / "settings.ini")
    settings.language = "en"
    return SimpleNamespace(settings=settings)


@pytest.fixture
def window(parts, qtbot):
    made = HelpWindow(parts)
    qtbot.addWidget(made)
    with qtbot.waitActive(made):
        made.open_at("capture")
    return made


def first_line(window):
    return window.browser.document().begin().text()


def test_it_opens_at_the_page_that_is_asked_for(window):
    assert first_line(window) == "Capture"
    assert window.contents.currentItem().text(0) == "Capture"
    window.open_at("survey", "residuals")
    assert window.contents.currentItem().text(0) == "Residuals"
    assert window.browser.textCursor().block().text() == "Residuals"
    window.open_at("nonsense")
    assert window.topic == "start"


def test_back_and_forward_by_the_keys(window, qtbot):
    window.browser.anchorClicked.emit(QUrl("survey.md"))
    window.browser.anchorClicked.emit(QUrl("#residuals"))
    window.browser.anchorClicked.emit(QUrl("https://example.org"))
    assert first_line(window) == "Survey"
    alt = Qt.KeyboardModifier.AltModifier
    for key, line in (
        (Qt.Key.Key_Left, "Survey"), (Qt.Key.Key_Left, "Capture"), (Qt.Key.Key_Right, "Survey"),
    ):  # fmt: skip
        qtbot.keyClick(window, key, alt)
        assert first_line(window) == line
    window.open_at("export")
    assert not window.forward_button.isEnabled()
    qtbot.mouseClick(window.back_button, Qt.MouseButton.LeftButton)
    assert first_line(window) == "Survey"
    assert window.forward_button.isEnabled()


def test_the_contents_lead_to_pages_and_sections(window, qtbot):
    window.contents.setFocus()
    window.contents.setCurrentItem(window.contents.topLevelItem(2).child(1))
    with qtbot.waitSignal(window.contents.itemActivated):
        qtbot.keyClick(window.contents, Qt.Key.Key_Return)
    assert window.topic == "calibrate"
    assert window.browser.textCursor().block().text() == "Quality"


def test_what_is_found_is_listed_and_lit(window, qtbot):
    qtbot.keyClick(window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
    assert window.words.hasFocus()
    qtbot.keyClicks(window.words, "callipers")
    assert window.left.currentIndex() == 1
    assert window.hits.count() == 1
    qtbot.keyClick(window.words, Qt.Key.Key_Return)
    assert first_line(window) == "Survey"
    lit = [one.cursor.selectedText().lower() for one in window.browser.extraSelections()]
    assert lit == ["callipers"]
    qtbot.keyClick(window, Qt.Key.Key_Escape)
    assert window.words.text() == ""
    assert window.browser.extraSelections() == []
    assert window.left.currentIndex() == 0
    qtbot.keyClick(window, Qt.Key.Key_Escape)
    assert not window.isVisible()


def test_pictures_are_its_own_and_those_that_lack_leave_no_gap(window, monkeypatch, tmp_path):
    image = QImage(3000, 100, QImage.Format.Format_RGB32)
    image.fill(Qt.GlobalColor.red)
    (tmp_path / "help" / "pictures").mkdir(parents=True)
    for name in ("plan-light", "plan-dark", "capture"):
        assert image.save(str(tmp_path / "help" / "pictures" / f"{name}.png"))

    def resource(name):
        if not (tmp_path / name).exists():
            raise FileNotFoundError(name)
        return tmp_path / name

    monkeypatch.setattr(manual, "resource", resource)
    window.setPalette(palette("dark"))
    files = window.browser.files
    assert files["pictures/plan.png"].name == "plan-dark.png"
    assert files["pictures/capture.png"].name == "capture.png"
    kind = QTextDocument.ResourceType.ImageResource
    shown = window.browser.loadResource(kind, QUrl("pictures/plan.png"))
    assert 0 < shown.width() < window.browser.viewport().width()
    for name in ("file:///etc/hostname", "pictures/other.png"):
        assert window.browser.loadResource(kind, QUrl(name)) is None
    window.open_at("survey")
    assert window.browser.files == {}
    assert "table" not in window.browser.toPlainText()


def test_it_follows_the_theme(window):
    window.setPalette(palette("dark"))
    dark = window.grab().toImage()
    window.setPalette(palette("light"))
    assert window.grab().toImage() != dark
    assert window.palette().color(QPalette.ColorRole.Base).lightnessF() > 0.5


def test_it_closes_with_its_parent(parts, qtbot):
    above = QWidget()
    qtbot.addWidget(above)
    above.show()
    made = HelpWindow(parts, above)
    made.open_at("start")
    assert made.isWindow()
    assert made.parent() is above


def test_the_page_of_the_keys_has_every_menu_once():
    rows = [("File", "a", "1", ""), ("View", "b", "2", ""), ("File", "c", "3", "")]
    text = manual.keyboard_page(rows)
    assert re.findall(r"^## (.*)$", text, re.MULTILINE) == ["File", "View"]
    assert text.index("| c |") < text.index("## View")
