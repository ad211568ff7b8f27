"""Pages are made when they are first shown, and told when they come and go."""

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QLabel, QMainWindow, QWidget

from georibbon.gui.pages import NavigationBar, Page, Pages


class Told(QLabel):
    def __init__(self, heard):
        super().__init__()
        self.heard = heard

    def entered(self):
        self.heard.append("entered")

    def left(self):
        self.heard.append("left")


def test_a_page_is_made_once_and_told_that_it_comes_and_goes(qtbot):
    heard, made = [], []

    def make():
        made.append(1)
        return Told(heard)

    pages = Pages((Page("one", QLabel), Page("two", make)))
    qtbot.addWidget(pages)
    turned = []
    pages.turned.connect(turned.append)
    pages.show_page("one")
    assert pages.made("two") is None
    for name in ("two", "two", "one", "two"):
        pages.show_page(name)
    assert pages.currentWidget() is pages.page("two")
    assert heard == ["entered", "left", "entered"]
    assert len(made) == 1
    assert turned == ["one", "two", "one", "two"]


def test_the_bar_marks_one_page(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    actions = {name: QAction(name, parent, checkable=True) for name in ("one", "two")}
    bar = NavigationBar(actions, parent)
    bar.mark("one")
    bar.mark("two")
    assert [one.isChecked() for one in actions.values()] == [False, True]


def test_a_page_that_is_not_seen_takes_no_room(qtbot):
    wide, narrow = QWidget(), QWidget()
    wide.setMinimumSize(900, 500)
    narrow.setMinimumSize(100, 80)
    pages = Pages((Page("wide", lambda: wide), Page("narrow", lambda: narrow)))
    window = QMainWindow()
    qtbot.addWidget(window)
    window.setCentralWidget(pages)
    for name in ("wide", "narrow"):
        pages.show_page(name)
    window.show()
    window.resize(300, 200)
    assert (window.width(), window.height()) == (300, 200)
    pages.show_page("wide")
    qtbot.waitUntil(lambda: window.width() >= 900)
