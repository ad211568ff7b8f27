"""The start page, as a person begins with it."""

import os
import shutil
import time

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QAction, QDragEnterEvent, QDragLeaveEvent, QDropEvent
from PySide6.QtWidgets import QApplication

from georibbon.gui.start_page import CARDS, SMALLER, StartPage
from georibbon.gui.theme import COLOURS, palette
from georibbon.session.session import Session


@pytest.fixture
def done():
    """The ids of the actions that were triggered."""
    return []


@pytest.fixture
def actions(done):
    """An action for every way to begin."""
    made = {}
    for name in (*CARDS, *SMALLER):
        action = QAction(f"&{name.capitalize()} && so on…")
        action.setStatusTip(f"What {name} does")
        action.triggered.connect(lambda _=False, name=name: done.append(name))
        made[name] = action
    return made


@pytest.fixture
def page(actions, qtbot):
    """A start page on the screen."""
    made = StartPage(actions)
    qtbot.addWidget(made)
    made.resize(1000, 640)
    with qtbot.waitExposed(made):
        made.show()
    return made


def test_every_way_to_begin_is_a_button_with_its_words(page):
    assert list(page.buttons) == [*CARDS, *SMALLER]
    for name, button in page.buttons.items():
        assert button.accessibleName() == f"{name.capitalize()} & so on…"
        assert button.statusTip() == f"What {name} does"


def test_the_pointer_and_the_keys_press_them(page, done, qtbot):
    for name, button in page.buttons.items():
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        assert done[-1] == name
    card = page.buttons["calibrate"]
    card.setFocus()
    for key in (Qt.Key.Key_Return, Qt.Key.Key_Space):
        done.clear()
        qtbot.keyClick(card, key)
        assert done == ["calibrate"]


def test_the_keys_begin_at_the_first_and_reach_all(page, qtbot):
    page.activateWindow()
    qtbot.waitUntil(page.isActiveWindow)
    page.entered()
    reached = []
    for _ in range(len(page.buttons) + 1):
        reached.append(page.focusWidget())
        qtbot.keyClick(page.focusWidget(), Qt.Key.Key_Tab)
    assert reached == [*page.buttons.values(), page.recent]
    page.buttons["open"].setFocus()
    page.entered()
    assert page.buttons["open"].hasFocus()


def test_what_the_window_lacks_is_not_offered(actions, qtbot):
    del actions["calibrate"], actions["import"]
    made = StartPage(actions)
    qtbot.addWidget(made)
    assert "calibrate" not in made.buttons
    assert "import" not in made.buttons
    assert "new-capture" in made.buttons


def test_a_button_follows_its_action(page, actions):
    actions["connect-virtual"].setEnabled(False)
    actions["connect-virtual"].setText("Let &go")
    actions["import"].setEnabled(False)
    assert not page.buttons["connect-virtual"].isEnabled()
    assert page.buttons["connect-virtual"].accessibleName() == "Let go"
    assert not page.buttons["import"].isEnabled()


def test_recent_ones_have_their_date_and_place(page, tmp_path):
    today, old = tmp_path / "today.georibbon", tmp_path / "old.georibbon"
    for path in (today, old):
        path.touch()
    os.utime(old, (86400 * 3653, 86400 * 3653))  # 1980
    page.show_recent([today, old])
    assert page.recent.item(0).text().startswith("today.georibbon\ntoday, ")
    assert page.recent.item(0).text().endswith(str(tmp_path))
    assert "80" in page.recent.item(1).text()
    os.utime(old, (time.time() - 86400,) * 2)
    page.show_recent([old])
    assert "\nyesterday, " in page.recent.item(0).text()
    page.show_recent([tmp_path / "gone"])
    assert page.recent.item(0).text() == f"gone\n{tmp_path}"


def test_a_recent_one_is_asked_for_by_click_and_by_return(page, tmp_path, qtbot):
    paths = [tmp_path / "a", tmp_path / "b"]
    page.show_recent(paths)
    at = page.recent.visualItemRect(page.recent.item(1)).center()
    with qtbot.waitSignal(page.asked) as asked:
        qtbot.mouseClick(page.recent.viewport(), Qt.MouseButton.LeftButton, pos=at)
    assert asked.args == [paths[1]]
    page.recent.setFocus()
    with qtbot.waitSignal(page.asked) as asked:
        qtbot.keyClick(page.recent, Qt.Key.Key_Up)
        qtbot.keyClick(page.recent, Qt.Key.Key_Return)
    assert asked.args == [paths[0]]


def test_nothing_yet_asks_for_nothing(page, qtbot):
    page.show_recent([])
    with qtbot.assertNotEmitted(page.asked):
        page.recent.itemClicked.emit(page.recent.item(0))
    assert "Nothing yet" in page.recent.item(0).text()


def drag(page, urls):
    """Move over the page; the event, and its data to be kept as long."""
    data = QMimeData()
    data.setUrls(urls)
    event = QDragEnterEvent(
        QPoint(50, 50), Qt.DropAction.CopyAction, data,
        Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    QApplication.sendEvent(page, event)
    return event, data


def test_what_is_dropped_is_asked_for(page, tmp_path, qtbot):
    event, data = drag(page, [QUrl.fromLocalFile(str(tmp_path))])
    assert event.isAccepted()
    frame = page.grab().toImage().pixelColor(2, 300).name()
    assert frame in {of.link for of in COLOURS.values()}
    drop = QDropEvent(
        QPointF(50, 50), Qt.DropAction.CopyAction, data,
        Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    with qtbot.waitSignal(page.asked) as asked:
        QApplication.sendEvent(page, drop)
    assert asked.args == [tmp_path]
    assert page.grab().toImage().pixelColor(2, 300).name() != frame


@pytest.mark.parametrize("urls", [[], ["https://example.org/a"], ["file:///a", "file:///b"]])
def test_what_is_no_one_file_is_not_taken(page, urls):
    event, _ = drag(page, [QUrl(url) for url in urls])
    assert not event.isAccepted()


def test_what_is_taken_elsewhere_leaves_no_frame(page, tmp_path):
    before = page.grab().toImage()
    drag(page, [QUrl.fromLocalFile(str(tmp_path))])
    QApplication.sendEvent(page, QDragLeaveEvent())
    assert page.grab().toImage() == before


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_cards_follow_the_theme(page, theme):
    page.setPalette(palette(theme))
    image = page.buttons["open"].grab().toImage()
    middle = image.pixelColor(image.width() // 2, image.height() - 6)
    assert middle.name() == COLOURS[theme].base


def test_what_a_crash_left_open_says_so(page, session, tmp_path):
    with Session.open(session) as opened:
        opened.do("note", text="in the log beside it")
        page.show_recent([session])
        assert "not closed" not in page.recent.item(0).text()
        left = tmp_path / "left.georibbon"
        for ending in ("", "-wal"):
            shutil.copy(f"{session}{ending}", f"{left}{ending}")
    page.show_recent([session, left])
    assert "not closed" not in page.recent.item(0).text()
    assert "It was not closed; what was captured is in it." in page.recent.item(1).text()
