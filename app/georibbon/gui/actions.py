"""Every action in one table: menus, toolbar, shortcuts and the command palette come from it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QDialog,
    QHeaderView,
    QLineEdit,
    QMainWindow,
    QMenu,
    QToolBar,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

Needs = Literal["nothing", "source", "result"]


@dataclass(frozen=True)
class Action:
    """One action.

    slot: the window's method, with `argument` where there is one, with the
    state where it is checkable.  menu: its menu, and its submenu behind a
    slash.  needs: what must be there for it to make sense.  icon: a name of
    `icons`.
    """

    id: str
    text: str
    shortcut: str
    tip: str
    slot: str
    menu: str
    needs: Needs = "nothing"
    icon: str | None = None
    argument: str | None = None
    checkable: bool = False
    toolbar: bool = False
    line: bool = False  # a separating line above it


ACTIONS = (
    Action("open", "&Open session…", "Ctrl+O", "Open a session, a .georibbon file",
           "ask_open_session", "&File", icon="open", toolbar=True),
    Action("open-folder", "Open recording &folder…", "Ctrl+Shift+O",
           "Open a folder that holds a recording.toml; it is never changed",
           "ask_open_folder", "&File", icon="folder"),
    Action("demonstration", "Open the &demonstration", "Ctrl+D",
           "Open the virtual capture of a car bonnet", "open_demonstration", "&File",
           icon="surface"),
    Action("import", "&Import recording folder…", "Ctrl+I",
           "Put a recording folder into a session file, which keeps what is changed, and open it",
           "ask_import", "&File", icon="import", line=True),
    Action("export-surface", "&Export surface…", "Ctrl+E",
           "Write the surface as STL, OBJ or PLY, in millimetres", "ask_export_surface", "&File",
           "result", icon="export"),
    Action("picture", "Save &picture…", "Ctrl+Shift+S", "Save what the 3D view shows as a PNG file",
           "ask_save_picture", "&File", "result", icon="picture", toolbar=True),
    Action("close", "&Close", "Ctrl+W", "Close what is open and go back to the start page",
           "close_document", "&File", "source", line=True),
    Action("quit", "&Quit", "Ctrl+Q", "Close the window; what was changed is in the session's file",
           "close", "&File"),
    Action("undo", "&Undo", "Ctrl+Z", "Take the last change back", "undo", "&Edit", "source",
           icon="undo", toolbar=True),
    Action("redo", "&Redo", "Ctrl+Shift+Z", "Do again what was undone last", "redo", "&Edit",
           "source", icon="redo", toolbar=True),
    Action("reset-smoothing", "Reset &smoothing", "Ctrl+R",
           "Smooth all passes automatically, as the readings support",
           "reset_smoothing", "&Edit", "source", line=True),
    Action("fit", "&Fit", "F", "Show all of the object", "fit", "&View", "result", icon="fit",
           toolbar=True),
    Action("view-iso", "&Aslant", "0", "Look from aslant above", "look", "&View/&Look from",
           "result", icon="iso", argument="iso", toolbar=True),
    Action("view-front", "&Front", "1", "Look from the front, along y", "look", "&View/&Look from",
           "result", argument="front"),
    Action("view-back", "&Back", "Ctrl+1", "Look from behind, against y", "look",
           "&View/&Look from", "result", argument="back"),
    Action("view-right", "&Right", "3", "Look from the right, against x", "look",
           "&View/&Look from", "result", argument="right"),
    Action("view-left", "&Left", "Ctrl+3", "Look from the left, along x", "look",
           "&View/&Look from", "result", argument="left"),
    Action("view-top", "&Top", "7", "Look from above", "look", "&View/&Look from", "result",
           icon="top", argument="top", toolbar=True),
    Action("view-bottom", "B&ottom", "Ctrl+7", "Look from below", "look", "&View/&Look from",
           "result", argument="bottom"),
    Action("parallel", "&Parallel projection", "5",
           "Parallel projection in place of perspective", "set_parallel", "&View", "result",
           icon="parallel", checkable=True, toolbar=True),
    Action("dark", "&Dark colours", "Ctrl+Shift+D", "Dark colours in place of light ones",
           "set_dark", "&View", checkable=True, line=True),
    Action("reset-layout", "&Reset layout", "Ctrl+Shift+R",
           "Put the panels back where they were at first", "reset_layout", "&View"),
    Action("palette", "&Command palette…", "Ctrl+Shift+P", "Find an action by its words and do it",
           "show_palette", "&Help"),
    Action("log", "Show &log", "Ctrl+L", "Show what was told since the start, with its details",
           "show_log", "&Help"),
    Action("about", "&About Georibbon", "F1", "Version and licence of the program", "about",
           "&Help", line=True),
)  # fmt: skip


def make_actions(window: QMainWindow) -> dict[str, QAction]:
    """The window's actions by their ids, connected to its slots."""
    return {one.id: _action(one, window) for one in ACTIONS}


def _action(one: Action, window: QMainWindow) -> QAction:
    action = QAction(one.text, window)
    action.setObjectName(one.id)
    action.setShortcut(QKeySequence(one.shortcut))
    action.setStatusTip(one.tip)
    keys = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
    action.setToolTip(f"{one.tip} ({keys})")
    action.setCheckable(one.checkable)
    slot = getattr(window, one.slot)
    if one.argument is not None:
        action.triggered.connect(lambda _=False: slot(one.argument))
    elif one.checkable:
        action.triggered.connect(lambda checked=False: slot(checked))
    else:
        action.triggered.connect(lambda _=False: slot())
    window.addAction(action)
    return action


def fill_menus(window: QMainWindow, actions: Mapping[str, QAction]) -> dict[str, QMenu]:
    """Put every action into its menu; the menus by their paths."""
    menus: dict[str, QMenu] = {}
    for one in ACTIONS:
        menu = _menu(window, menus, one.menu)
        if one.line:
            menu.addSeparator()
        menu.addAction(actions[one.id])
    return menus


def _menu(window: QMainWindow, menus: dict[str, QMenu], path: str) -> QMenu:
    if path not in menus:
        above, _, text = path.rpartition("/")
        parent = _menu(window, menus, above) if above else window.menuBar()
        menus[path] = parent.addMenu(text)
    return menus[path]


def fill_toolbar(bar: QToolBar, actions: Mapping[str, QAction]) -> None:
    """Put the actions that are for it into the toolbar, a line between the menus' parts."""
    last = None
    for one in ACTIONS:
        if one.toolbar:
            part = one.menu.partition("/")[0]
            if last not in (None, part):
                bar.addSeparator()
            bar.addAction(actions[one.id])
            last = part


def plain(text: str) -> str:
    """A text without the marks of its key."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&")


class Palette(QDialog):
    """A list of all actions that can be done now, filtered by words."""

    def __init__(self, actions: Mapping[str, QAction], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Command palette")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.words = QLineEdit()
        self.words.setPlaceholderText("Type what you want to do")
        self.words.setAccessibleName("What you want to do")
        self.words.setClearButtonEnabled(True)
        self.list = QTreeWidget()
        self.list.setAccessibleName("Actions")
        self.list.setColumnCount(2)
        self.list.setHeaderHidden(True)
        self.list.setRootIsDecorated(False)
        self.list.setUniformRowHeights(True)
        self.list.header().setStretchLastSection(False)
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.list.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        layout = QVBoxLayout(self)
        layout.addWidget(self.words)
        layout.addWidget(self.list)
        self.resize(520, 380)
        self.setFocusProxy(self.words)
        for one in ACTIONS:
            action = actions[one.id]
            if action.isEnabled() and one.id != "palette":
                self._add(one, action)
        self.words.textChanged.connect(self._filter)
        self.words.returnPressed.connect(self.do)
        self.list.itemActivated.connect(self.do)
        self.words.installEventFilter(self)
        self._filter("")

    def _add(self, one: Action, action: QAction) -> None:
        keys = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        _, _, above = one.menu.partition("/")
        text = plain(f"{above}: {action.text()}" if above else action.text())
        item = QTreeWidgetItem([text, keys])
        item.setToolTip(0, action.statusTip())
        item.setData(0, Qt.ItemDataRole.UserRole, action)
        self.list.addTopLevelItem(item)

    def _filter(self, text: str) -> None:
        words = text.lower().split()
        first = None
        for item in self._items():
            told = f"{item.text(0)} {item.toolTip(0)}".lower()
            item.setHidden(not all(word in told for word in words))
            if first is None and not item.isHidden():
                first = item
        self.list.setCurrentItem(first)

    def _items(self) -> list[QTreeWidgetItem]:
        return [self.list.topLevelItem(i) for i in range(self.list.topLevelItemCount())]

    def eventFilter(self, watched, event) -> bool:
        """The arrows move in the list while the words are typed."""
        if event.type() == event.Type.KeyPress and event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self._move(1 if event.key() == Qt.Key.Key_Down else -1)
            return True
        return super().eventFilter(watched, event)

    def _move(self, step: int) -> None:
        seen = [item for item in self._items() if not item.isHidden()]
        current = self.list.currentItem()
        if current in seen:
            self.list.setCurrentItem(seen[(seen.index(current) + step) % len(seen)])

    def do(self) -> None:
        """Do the chosen action, after this dialog is gone."""
        item = self.list.currentItem()
        if item is not None and not item.isHidden():
            action = item.data(0, Qt.ItemDataRole.UserRole)
            self.accept()
            action.trigger()
