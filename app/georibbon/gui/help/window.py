"""The manual in a window of its own: contents, search, history, and links that stay inside."""

from PySide6.QtCore import QEvent, QSize, Qt, QUrl
from PySide6.QtGui import (
    QImage,
    QKeySequence,
    QShortcut,
    QTextCharFormat,
    QTextCursor,
    QTextDocument,
)
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QSplitter,
    QStackedWidget,
    QTextBrowser,
    QTextEdit,
    QToolButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.actions import ACTIONS, plain
from georibbon.gui.help.manual import (
    TOPICS,
    Hit,
    by_topic,
    folded,
    read_manual,
    search,
    slug,
    target,
    with_pictures,
)
from georibbon.gui.icons import icon
from georibbon.gui.language import tr, trn
from georibbon.gui.parts import Parts
from georibbon.gui.theme import theme_of

_PLACE = Qt.ItemDataRole.UserRole  # (topic, section)
_MARGIN = 24  # px, that a picture leaves free
_WIDEST = 800  # px of a picture
_MOST_LIT = 500


class Browser(QTextBrowser):
    """A page; its pictures are those it was given, as wide as the page at most."""

    def __init__(self) -> None:
        super().__init__()
        self.files = {}
        self.setOpenLinks(False)
        self.setAccessibleName(tr("Page of the manual"))

    def loadResource(self, kind: int, name: QUrl) -> object:
        """A picture that was given; nothing else is ever loaded."""
        path = self.files.get(name.toString())
        if kind != QTextDocument.ResourceType.ImageResource or path is None:
            return None
        image = QImage(str(path))
        ratio = self.devicePixelRatioF()
        width = int(min(self.viewport().width() - 2 * _MARGIN, _WIDEST) * ratio)
        if image.width() > width > 0:
            image = image.scaledToWidth(width, Qt.TransformationMode.SmoothTransformation)
        image.setDevicePixelRatio(ratio)
        return image


class HelpWindow(QWidget):
    """The manual; `open_at(topic)` shows it at a page."""

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self._settings = parts.settings
        self.setWindowTitle(tr("Georibbon: the manual"))
        self._pages = by_topic(read_manual(parts.settings.language, action_rows()))
        self._history: list[tuple[str, str]] = []
        self._now = -1  # of the history
        self.browser = Browser()
        self.browser.anchorClicked.connect(self._follow)
        self._make_buttons()
        self._make_contents()
        self._lay_out()
        self._add_keys()
        self.resize(1000, 720)
        self._theme = ""
        self._go("start", "")

    @property
    def topic(self) -> str:
        """The topic of the page that is shown."""
        return self._history[self._now][0]

    def open_at(self, topic: str, section: str = "") -> None:
        """Show the window at a page, the first where there is none of this topic."""
        self._go(topic if topic in self._pages else TOPICS[0], section)
        self.show()
        self.raise_()
        self.activateWindow()
        self.browser.setFocus()

    def back(self) -> None:
        """The page before."""
        self._step(-1)

    def forward(self) -> None:
        """The page that was gone back from."""
        self._step(1)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self._history:
            self._show()

    # Making

    def _make_buttons(self) -> None:
        self.back_button, self.forward_button = QToolButton(), QToolButton()
        for button, words, act in (
            (self.back_button, tr("Back (Alt+Left)"), self.back),
            (self.forward_button, tr("Forward (Alt+Right)"), self.forward),
        ):
            button.setToolTip(words)
            button.setAccessibleName(words)
            button.setIconSize(QSize(20, 20))
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(act)
        self.words = QLineEdit()
        self.words.setPlaceholderText(tr("Search the manual (Ctrl+F)"))
        self.words.setAccessibleName(tr("Search the manual"))
        self.words.setClearButtonEnabled(True)
        self.words.textChanged.connect(self._search)
        self.words.returnPressed.connect(self._open_first)

    def _make_contents(self) -> None:
        self.contents = QTreeWidget()
        self.contents.setHeaderHidden(True)
        self.contents.setAccessibleName(tr("Contents"))
        for page in self._pages.values():
            item = QTreeWidgetItem([page.title])
            item.setData(0, _PLACE, (page.topic, ""))
            self.contents.addTopLevelItem(item)
            for section in page.sections:
                below = QTreeWidgetItem([section])
                below.setData(0, _PLACE, (page.topic, slug(section)))
                item.addChild(below)
        self.contents.itemClicked.connect(self._choose)
        self.contents.itemActivated.connect(self._choose)
        self.hits = QListWidget()
        self.hits.setAccessibleName(tr("What was found"))
        self.hits.setWordWrap(True)
        self.hits.setAlternatingRowColors(True)
        self.hits.itemClicked.connect(self._open_hit)
        self.hits.itemActivated.connect(self._open_hit)
        self.found = QLabel()
        found = QWidget()
        column = QVBoxLayout(found)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.found)
        column.addWidget(self.hits)
        self.left = QStackedWidget()
        self.left.addWidget(self.contents)
        self.left.addWidget(found)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(self.back_button)
        row.addWidget(self.forward_button)
        row.addWidget(self.words, 1)
        splitter = QSplitter()
        splitter.addWidget(self.left)
        splitter.addWidget(self.browser)
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([280, 720])
        whole = QVBoxLayout(self)
        whole.setContentsMargins(6, 6, 6, 6)
        whole.addLayout(row)
        whole.addWidget(splitter, 1)
        self.setFocusProxy(self.browser)

    def _add_keys(self) -> None:
        find = QKeySequence.StandardKey.Find
        for keys, act in (
            ("Alt+Left", self.back),
            ("Alt+Right", self.forward),
            (find, lambda: (self.words.setFocus(), self.words.selectAll())),
            ("Escape", self._leave),
        ):
            QShortcut(QKeySequence(keys), self, act)

    # Going somewhere

    def _go(self, topic: str, section: str) -> None:
        """Show a page, and put it into the history."""
        if self._history and self._history[self._now] == (topic, section):
            self._show()
            return
        self._history[self._now + 1 :] = [(topic, section)]
        self._now = len(self._history) - 1
        self._show()

    def _step(self, by: int) -> None:
        if 0 <= self._now + by < len(self._history):
            self._now += by
            self._show()

    def _show(self) -> None:
        topic, section = self._history[self._now]
        self._theme = theme_of(self.palette())
        text, files = with_pictures(self._pages[topic].text, self._theme)
        self.browser.files = files
        self.browser.document().clear()
        self.browser.setMarkdown(text)
        self.browser.document().setDocumentMargin(_MARGIN / 2)
        self._scroll_to(section)
        self._light()
        self._mark_contents(topic, section)
        self.back_button.setIcon(icon("back", self._theme))
        self.forward_button.setIcon(icon("forward", self._theme))
        self.back_button.setEnabled(self._now > 0)
        self.forward_button.setEnabled(self._now + 1 < len(self._history))

    def _scroll_to(self, section: str) -> None:
        block = self.browser.document().begin()
        while section and block.isValid():
            if block.blockFormat().headingLevel() and slug(block.text()) == section:
                cursor = QTextCursor(block)
                self.browser.moveCursor(
                    QTextCursor.MoveOperation.End
                )  # so that it comes to the top
                self.browser.setTextCursor(cursor)
                return
            block = block.next()
        self.browser.moveCursor(QTextCursor.MoveOperation.Start)

    def _mark_contents(self, topic: str, section: str) -> None:
        for index in range(self.contents.topLevelItemCount()):
            item = self.contents.topLevelItem(index)
            here = item.data(0, _PLACE)[0] == topic
            item.setExpanded(here)
            if here:
                below = [item.child(k) for k in range(item.childCount())]
                at = [one for one in below if one.data(0, _PLACE)[1] == section]
                self.contents.setCurrentItem((at or [item])[0])

    def _follow(self, link: QUrl) -> None:
        """Follow a link within the manual; any other leads nowhere."""
        place = target(link.toString(), tuple(self._pages))
        if place is not None:
            topic, section = place
            self._go(topic or self.topic, section)

    def _choose(self, item: QTreeWidgetItem, _column: int = 0) -> None:
        self._go(*item.data(0, _PLACE))

    # Searching

    def _search(self, words: str) -> None:
        found = search(tuple(self._pages.values()), words)
        self.hits.clear()
        for hit in found:
            self.hits.addItem(_hit_item(hit))
        self.found.setText(trn("{n} section", "{n} sections", len(found)))
        self.left.setCurrentIndex(1 if words.strip() else 0)
        self._light()

    def _open_first(self) -> None:
        if self.hits.count():
            self.hits.setCurrentRow(0)
            self._open_hit(self.hits.item(0))
            self.hits.setFocus()

    def _open_hit(self, item: QListWidgetItem) -> None:
        self._go(*item.data(_PLACE))

    def _light(self) -> None:
        """Light up the words that are looked for in the page."""
        form = QTextCharFormat()
        form.setBackground(self.palette().highlight())
        form.setForeground(self.palette().highlightedText())
        lit = []
        document = self.browser.document()
        told = folded(document.toRawText()) if self.words.text().strip() else ""
        for word in set(folded(self.words.text()).split()):
            at = told.find(word)
            while at >= 0 and len(lit) < _MOST_LIT:
                one = QTextEdit.ExtraSelection()
                one.format = form
                one.cursor = QTextCursor(document)
                one.cursor.setPosition(at)
                one.cursor.setPosition(at + len(word), QTextCursor.MoveMode.KeepAnchor)
                lit.append(one)
                at = told.find(word, at + len(word))
        self.browser.setExtraSelections(lit)

    def _leave(self) -> None:
        """Escape: first the search, then the window."""
        if self.words.text():
            self.words.clear()
        else:
            self.close()


def _hit_item(hit: Hit) -> QListWidgetItem:
    head = f"{hit.title} › {hit.section}" if hit.section else hit.title
    item = QListWidgetItem(f"{head}\n{hit.around}")
    item.setData(_PLACE, (hit.topic, slug(hit.section)))
    return item


def action_rows() -> list[tuple[str, str, str, str]]:
    """(menu, text, keys, tip) of every action, as a person reads them."""
    native = QKeySequence.SequenceFormat.NativeText
    rows = []
    for one in ACTIONS:
        menu, _, below = one.menu.partition("/")
        text = plain(tr(one.text)) if not below else f"{plain(tr(below))}: {plain(tr(one.text))}"
        keys = QKeySequence(one.shortcut).toString(native)
        rows.append((plain(tr(menu)), text, keys, tr(one.tip)))
    return rows
