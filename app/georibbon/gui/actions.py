"""Every action in one table: menus, toolbar, shortcuts and the command palette come from it."""

from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter, itemgetter
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

from georibbon.gui.language import N_, tr

Needs = Literal["nothing", "source", "result", "ribbon", "virtual", "capture", "taking", "laying"]


@dataclass(frozen=True)
class Action:
    """One action.

    text, tip: English, translated where they are shown.  slot: the window's
    method, or one of a part of it behind a point; called with `argument` where
    there is one, else with the state where it is checkable.  menu: its menu, and
    its submenu behind a slash.  needs: what must be there for it to make sense.
    icon: a name of `icons`.
    """

    id: str
    text: str
    shortcut: str
    tip: str
    slot: str
    menu: str
    needs: Needs = "nothing"
    icon: str | None = None
    argument: str | int | None = None
    checkable: bool = False
    toolbar: bool = False
    line: bool = False  # a separating line above it


PAGES = N_("&Pages")
FILE, EDIT, VIEW, REVIEW = N_("&File"), N_("&Edit"), N_("&View"), N_("Revie&w")
RIBBON, CAPTURE, HELP = N_("&Ribbon"), N_("&Capture"), N_("&Help")
LOOK, UNIT = f"{VIEW}/{N_('&Look from')}", f"{VIEW}/{N_('&Units')}"
HANDS = f"{RIBBON}/{N_('Virtual &hands')}"
COLOUR = f"{VIEW}/{N_('&Colour by')}"
MENUS = (FILE, EDIT, PAGES, RIBBON, CAPTURE, VIEW, REVIEW, HELP)

ACTIONS = (
    Action("page-start", N_("&Start"), "Alt+1", N_("What you can begin with"),
           "show_page", PAGES, argument="start", icon="start", checkable=True),
    Action("page-connect", N_("C&onnect"), "Alt+2",
           N_("Connect a ribbon, and see what each of its sensors says"),
           "show_page", PAGES, argument="connect", icon="connect", checkable=True),
    Action("page-calibrate", N_("C&alibrate"), "Alt+3",
           N_("Calibrate the ribbon on the bar, or check it in three poses"),
           "show_page", PAGES, argument="calibrate", icon="calibrate", checkable=True),
    Action("page-capture", N_("&Capture"), "Alt+4", N_("Plan a capture, and lay pass after pass"),
           "show_page", PAGES, argument="capture", icon="capture", checkable=True),
    Action("page-review", N_("&Review"), "Alt+5", N_("The surface that came of it, and its passes"),
           "show_page", PAGES, "source", argument="review", icon="surface", checkable=True),
    Action("new-capture", N_("&New capture…"), "Ctrl+N",
           N_("Plan a capture into a new session, and lay pass after pass"), "show_page",
           FILE, icon="new", argument="capture", toolbar=True),
    Action("open", N_("&Open session…"), "Ctrl+O", N_("Open a session, a .georibbon file"),
           "files.ask_session", FILE, icon="open", toolbar=True),
    Action("open-folder", N_("Open recording &folder…"), "Ctrl+Shift+O",
           N_("Open a folder that holds a recording.toml; it is never changed"),
           "files.ask_folder", FILE, icon="folder"),
    Action("demonstration", N_("Open the &demonstration"), "Ctrl+D",
           N_("Open the virtual capture of a car bonnet"), "files.open_demonstration", FILE,
           icon="surface"),
    Action("import", N_("&Import recording folder…"), "Ctrl+I",
           N_("Put a recording folder into a session file, which keeps what is changed, and open "
              "it"),
           "files.ask_import", FILE, icon="import", line=True),
    Action("export", N_("&Export…"), "Ctrl+E",
           N_("Write the surface, the curves, a report or the recording's folder"), "export", FILE,
           "source", icon="export", argument="surface", toolbar=True),
    Action("report", N_("Write repor&t…"), "Ctrl+Alt+E",
           N_("Write a report with pictures and figures, as HTML or PDF"), "export", FILE,
           "result", icon="report", argument="report"),
    Action("picture", N_("Save &picture…"), "Ctrl+Shift+S",
           N_("Save what the 3D view shows as a PNG file, larger or transparent too"),
           "files.save_picture", FILE, "result", icon="picture"),
    Action("close", N_("&Close"), "Ctrl+W", N_("Close what is open and go back to the start page"),
           "close_document", FILE, "source", line=True),
    Action("quit", N_("&Quit"), "Ctrl+Q",
           N_("Close the window; what was changed is in the session's file"), "close", FILE),
    Action("undo", N_("&Undo"), "Ctrl+Z", N_("Take the last change back"), "undo", EDIT, "source",
           icon="undo", toolbar=True),
    Action("redo", N_("&Redo"), "Ctrl+Shift+Z", N_("Do again what was undone last"), "redo", EDIT,
           "source", icon="redo", toolbar=True),
    Action("reset-smoothing", N_("Reset &smoothing"), "Ctrl+R",
           N_("Smooth all passes automatically, as the readings support"),
           "document.reset_smoothing", EDIT, "source", line=True),
    Action("reset-passes", N_("Reset &passes"), "Ctrl+Shift+R",
           N_("Smoothing, sensors, trimmed ends and weights of all passes as at first"),
           "reset_passes", EDIT, "source"),
    Action("reset-surface", N_("Reset sur&face"), "Ctrl+Alt+R",
           N_("The surface's settings as at first"), "reset_surface", EDIT, "source"),
    Action("settings", N_("Se&ttings…"), "Ctrl+,",
           N_("Colours, unit, language, sound and folder"), "show_settings", EDIT,
           icon="settings", line=True),
    Action("connect-virtual", N_("Connect to the &virtual ribbon"), "Ctrl+Shift+V",
           N_("Try everything with a ribbon that the program plays itself, through a real port"),
           "connect_virtual", RIBBON, icon="virtual"),
    Action("connect-again", N_("Connect &again"), "Ctrl+Shift+K",
           N_("Connect to the ribbon that was connected last"), "connect_again", RIBBON),
    Action("disconnect", N_("&Disconnect"), "Ctrl+Shift+U", N_("Let go of the ribbon"),
           "station.disconnect", RIBBON, "ribbon"),
    Action("calibrate", N_("&Calibrate…"), "Ctrl+K",
           N_("Calibrate a ribbon in about twenty poses, or check it in three"), "show_page",
           RIBBON, icon="calibrate", argument="calibrate", line=True),
    Action("daily-check", N_("Dail&y check…"), "Ctrl+Alt+K",
           N_("Three poses tell whether the calibration still holds"), "daily_check", RIBBON),
    Action("hands-lay", N_("&Lay what is asked for"), "Ctrl+Y",
           N_("The hands of the virtual ribbon lay what the capture asks for"), "hands.lay", HANDS,
           "virtual"),
    Action("hands-lift", N_("L&ift the ribbon"), "Ctrl+Shift+I",
           N_("The hands take the virtual ribbon up"), "hands.lift", HANDS, "virtual"),
    Action("hands-follow", N_("&Follow by itself"), "Ctrl+Alt+F",
           N_("Every pose and pass is laid as soon as it is asked for"), "hands.set_follow",
           HANDS, "virtual", checkable=True),
    Action("hands-survey", N_("Enter the &survey"), "Ctrl+Alt+S",
           N_("Enter the marks and crossings that you would measure"), "hands.enter_survey",
           HANDS, "virtual"),
    Action("hands-unplug", N_("&Pull the cable"), "Ctrl+Alt+U",
           N_("Pull the virtual ribbon's cable, to see what happens"), "hands.trouble", HANDS,
           "virtual", argument="unplug"),
    Action("hands-replug", N_("Plug the &cable in again"), "Ctrl+Alt+P",
           N_("Plug the virtual ribbon's cable in again"), "hands.trouble", HANDS, "virtual",
           argument="replug"),
    Action("take", N_("&Take"), "Ctrl+T",
           N_("Take what is asked for from the still ribbon: Space or Page Down do it too"),
           "on_page", CAPTURE, "taking", argument="take", icon="capture"),
    Action("take-anyway", N_("Take any&way"), "Ctrl+Space",
           N_("Take it although something speaks against it that may be overruled"),
           "on_page", CAPTURE, "taking", argument="take_anyway"),
    Action("skip", N_("&Leave out"), "Ctrl+Shift+L",
           N_("Leave out what is asked for; choosing it later brings it back"),
           "on_page", CAPTURE, "taking", argument="skip"),
    Action("auto", N_("Take by &stillness"), "Ctrl+Shift+Space",
           N_("Take by itself what lies still as asked, or only when told to"), "capture.set_auto",
           CAPTURE, "taking", checkable=True),
    Action("lay-again", N_("La&y again"), "Ctrl+Shift+Y",
           N_("Ask for the chosen pass once more"), "on_page", CAPTURE, "laying",
           argument="lay_again", line=True),
    Action("delete-pass", N_("&Delete pass"), "Ctrl+Del",
           N_("Take the chosen pass out of the session; undo brings it back"), "on_page",
           CAPTURE, "laying", argument="delete"),
    Action("add-pass", N_("Add &pass"), "Ctrl+Ins",
           N_("Ask for a further pass behind the chosen one"), "on_page", CAPTURE, "laying",
           argument="add_pass"),
    Action("add-tie", N_("Add t&ie"), "Ctrl+Shift+Ins",
           N_("Ask for a further tie across the passes"), "on_page", CAPTURE, "laying",
           argument="add_tie"),
    Action("move-up", N_("Move &up"), "Alt+Up", N_("Move the chosen pass up in the order"),
           "on_page", CAPTURE, "laying", argument="move_up"),
    Action("move-down", N_("Move d&own"), "Alt+Down", N_("Move the chosen pass down in the order"),
           "on_page", CAPTURE, "laying", argument="move_down"),
    Action("finish", N_("&Finish the capture"), "Ctrl+Return",
           N_("End the capture and look at what came of it; you can go on with it at any time"),
           "finish_capture", CAPTURE, "capture", line=True),
    Action("fit", N_("&Fit"), "F", N_("Show all of the object"), "view.fit", VIEW, "result",
           icon="fit", toolbar=True),
    Action("view-iso", N_("&Aslant"), "0", N_("Look from aslant above"), "view.standard_view",
           LOOK, "result", icon="iso", argument="iso", toolbar=True),
    Action("view-front", N_("&Front"), "1",
           N_("Look from the front, along y"), "view.standard_view",
           LOOK, "result", argument="front"),
    Action("view-back", N_("&Back"), "Ctrl+1",
           N_("Look from behind, against y"), "view.standard_view",
           LOOK, "result", argument="back"),
    Action("view-right", N_("&Right"), "3",
           N_("Look from the right, against x"), "view.standard_view",
           LOOK, "result", argument="right"),
    Action("view-left", N_("&Left"), "Ctrl+3",
           N_("Look from the left, along x"), "view.standard_view",
           LOOK, "result", argument="left"),
    Action("view-top", N_("&Top"), "7", N_("Look from above"), "view.standard_view",
           LOOK, "result",
           icon="top", argument="top", toolbar=True),
    Action("view-bottom", N_("B&ottom"), "Ctrl+7", N_("Look from below"), "view.standard_view",
           LOOK, "result", argument="bottom"),
    Action("parallel", N_("&Parallel projection"), "5",
           N_("Parallel projection in place of perspective"), "view.set_parallel", VIEW, "result",
           icon="parallel", checkable=True, toolbar=True),
    Action("colour-uncertainty", N_("&Uncertainty"), "Ctrl+Alt+1",
           N_("Colour by the standard deviation of the place"), "colour_by", COLOUR, "result",
           argument="uncertainty"),
    Action("colour-gaussian", N_("&Gaussian curvature"), "Ctrl+Alt+2",
           N_("Colour by the Gaussian curvature"), "colour_by", COLOUR, "result",
           argument="gaussian"),
    Action("colour-mean", N_("&Mean curvature"), "Ctrl+Alt+3", N_("Colour by the mean curvature"),
           "colour_by", COLOUR, "result", argument="mean"),
    Action("colour-normal", N_("&Normal curvature along the passes"), "Ctrl+Alt+4",
           N_("Colour by how the surface bends along the passes"), "colour_by", COLOUR, "result",
           argument="normal"),
    Action("colour-deviation", N_("&Deviation"), "Ctrl+Alt+5",
           N_("Colour by the distance from another session or a mesh file"), "colour_by", COLOUR,
           "result", argument="deviation"),
    Action("colour-zebra", N_("&Zebra stripes"), "Ctrl+Alt+6",
           N_("Stripes that show every kink of the surface"), "colour_by", COLOUR, "result",
           argument="zebra"),
    Action("colour-plain", N_("&Plain"), "Ctrl+Alt+7", N_("One colour"), "colour_by", COLOUR,
           "result", argument="plain"),
    Action("tool-point", N_("Pick a p&oint"), "Ctrl+Shift+1",
           N_("Click a place: its position, uncertainty, curvature and the nearest pass"),
           "use_tool", REVIEW, "result", argument="point", icon="point"),
    Action("tool-distance", N_("&Measure a distance"), "Ctrl+Shift+2",
           N_("Click two places: how far apart they are, straight and along the surface"),
           "use_tool", REVIEW, "result", argument="distance", icon="measure"),
    Action("tool-section", N_("&Section"), "Ctrl+Shift+3",
           N_("Click two places: the profile of the surface through them"), "use_tool", REVIEW,
           "result", argument="section", icon="section"),
    Action("copy-measures", N_("Copy m&easurements"), "Ctrl+Shift+M",
           N_("Copy all that was picked and measured, as text"), "view_panel.copy_all", REVIEW,
           "result"),
    Action("compare", N_("&Compare with…"), "Ctrl+Shift+C",
           N_("Lay another session or a mesh file beside this one, and colour by the difference"),
           "compare", REVIEW, "result", icon="compare", toolbar=True, line=True),
    Action("other-calibration", N_("Use another c&alibration…"), "Ctrl+Shift+B",
           N_("Reconstruct with another calibration than the session's own"),
           "choose_calibration", REVIEW, "source"),
    Action("note", N_("Add a &note…"), "Ctrl+Shift+N",
           N_("Write a note into the session; its time is kept"), "add_note", REVIEW, "source"),
    Action("previous-pass", N_("&Previous pass"), "Ctrl+Up",
           N_("Go to the pass before, with its notes and readings"), "history_panel.step", REVIEW,
           "source", argument=-1),
    Action("next-pass", N_("Ne&xt pass"), "Ctrl+Down",
           N_("Go to the next pass, with its notes and readings"), "history_panel.step", REVIEW,
           "source", argument=1),
    Action("dark", N_("&Dark colours"), "Ctrl+Shift+D", N_("Dark colours in place of light ones"),
           "set_dark", VIEW, checkable=True, line=True),
    Action("unit-mm", N_("Lengths in &millimetres"), "Ctrl+Alt+M",
           N_("Show and type lengths in millimetres"), "use_unit", UNIT, argument="mm",
           checkable=True),
    Action("unit-cm", N_("Lengths in &centimetres"), "Ctrl+Alt+C",
           N_("Show and type lengths in centimetres"), "use_unit", UNIT, argument="cm",
           checkable=True),
    Action("unit-in", N_("Lengths in &inches"), "Ctrl+Alt+I",
           N_("Show and type lengths in inches"), "use_unit", UNIT, argument="in",
           checkable=True),
    Action("reset-layout", N_("&Reset layout"), "Ctrl+Alt+L",
           N_("Put the panels back where they were at first"), "reset_layout", VIEW),
    Action("help", N_("&Manual"), "F1", N_("The manual, at the page of what is shown"),
           "show_help", HELP, icon="help"),
    Action("keyboard", N_("&Keyboard"), "Shift+F1", N_("Every action with its keys"),
           "show_keyboard", HELP),
    Action("palette", N_("&Command palette…"), "Ctrl+Shift+P",
           N_("Find an action by its words and do it"), "show_palette", HELP),
    Action("log", N_("Show &log"), "Ctrl+L",
           N_("Show what was told since the start, with its details"), "show_log", HELP, line=True),
    Action("crash-report", N_("Report a &fault…"), "Ctrl+Shift+F",
           N_("Versions, log and the last fault, to copy or save"), "show_crash_report", HELP),
    Action("about", N_("&About Georibbon"), "Ctrl+Shift+A",
           N_("Version and licence of the program"), "about", HELP, line=True),
)  # fmt: skip


def make_actions(window: QMainWindow) -> dict[str, QAction]:
    """The window's actions by their ids, connected to its slots."""
    return {one.id: _action(one, window) for one in ACTIONS}


def _action(one: Action, window: QMainWindow) -> QAction:
    action = QAction(tr(one.text), window)
    action.setObjectName(one.id)
    action.setShortcut(QKeySequence(one.shortcut))
    action.setStatusTip(tr(one.tip))
    keys = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
    action.setToolTip(f"{tr(one.tip)} ({keys})")
    action.setCheckable(one.checkable)
    slot = attrgetter(one.slot)  # when it is called: its part of the window is there by then
    if one.argument is not None:
        action.triggered.connect(lambda _=False: slot(window)(one.argument))
    elif one.checkable:
        action.triggered.connect(lambda checked=False: slot(window)(checked))
    else:
        action.triggered.connect(lambda _=False: slot(window)())
    window.addAction(action)
    return action


def fill_menus(window: QMainWindow, actions: Mapping[str, QAction]) -> dict[str, QMenu]:
    """Put every action into its menu; the menus by their paths."""
    menus: dict[str, QMenu] = {}
    for path in MENUS:
        _menu(window, menus, path)
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
        menus[path] = parent.addMenu(tr(text))
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
        self.setWindowTitle(tr("Command palette"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.words = QLineEdit()
        self.words.setPlaceholderText(tr("Type what you want to do"))
        self.words.setAccessibleName(tr("What you want to do"))
        self.words.setClearButtonEnabled(True)
        self.list = QTreeWidget()
        self.list.setAccessibleName(tr("Actions"))
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
        text = plain(f"{tr(above)}: {action.text()}" if above else action.text())
        item = QTreeWidgetItem([text, keys])
        item.setToolTip(0, action.statusTip())
        item.setData(0, Qt.ItemDataRole.UserRole, action)
        self.list.addTopLevelItem(item)

    def _filter(self, text: str) -> None:
        """Hide what has not the words; choose the first that has them in its name."""
        words = text.lower().split()
        seen = []
        for item in self._items():
            name = item.text(0).lower()
            told = f"{name} {item.toolTip(0).lower()}"
            item.setHidden(not all(word in told for word in words))
            if not item.isHidden():
                seen.append((not all(word in name for word in words), item))
        self.list.setCurrentItem(min(seen, key=itemgetter(0))[1] if seen else None)

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
