"""The main window: it makes the parts and connects them, and does nothing by itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QApplication,
    QLabel,
    QMainWindow,
    QProgressBar,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui import dialogs
from georibbon.gui.actions import (
    ACTIONS,
    FILE,
    VIEW,
    Palette,
    fill_menus,
    fill_toolbar,
    make_actions,
)
from georibbon.gui.capture_desk import CaptureDesk
from georibbon.gui.checks_panel import ChecksPanel
from georibbon.gui.connect.health_strip import HealthStrip
from georibbon.gui.connect.virtual_hands import VirtualHands
from georibbon.gui.crash import CrashReporter
from georibbon.gui.docks import Docks, place_for_late
from georibbon.gui.document import Document
from georibbon.gui.files import Files
from georibbon.gui.icons import icon
from georibbon.gui.language import sentence as spoken
from georibbon.gui.language import tr
from georibbon.gui.log import Banner, Bell, LogPanel
from georibbon.gui.notices_panel import NoticesPanel
from georibbon.gui.notifier import Notifier
from georibbon.gui.pages import NavigationBar, Page, Pages
from georibbon.gui.parts import Parts
from georibbon.gui.passes_panel import PassesPanel
from georibbon.gui.result_views import ResultViews
from georibbon.gui.review.history_panel import HistoryPanel
from georibbon.gui.scene_view import make_view
from georibbon.gui.section_file import save_section
from georibbon.gui.settings import Settings
from georibbon.gui.start_page import StartPage, dropped
from georibbon.gui.station.station import Station
from georibbon.gui.surface_panel import SurfacePanel
from georibbon.gui.theme import apply_theme
from georibbon.gui.units import UNITS, Units
from georibbon.gui.view_panel import ViewPanel

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.gui.review.compare_window import CompareWindow

BUSY_AFTER_MS = 250  # what takes no longer needs no telling
CAPTURING = ("calibrate", "capture")  # the pages of a capture


class MainWindow(QMainWindow):
    """The pages, the panels around the page of what is open, and what is told of everything."""

    def __init__(self, settings: Settings, notifier: Notifier) -> None:
        super().__init__()
        self.settings, self.notifier = settings, notifier
        self.parts = _make_parts(settings, notifier, self)
        self.document, self.units = self.parts.document, self.parts.units
        self.station, self.capture = self.parts.station, self.parts.capture
        self.bell = Bell(notifier, self)
        self.actions_by_id = make_actions(self)
        self._unfitted: str | None = None
        self._sentence = ""  # what was told last
        self._help: QWidget | None = None
        self.crashes = CrashReporter(notifier, lambda: self.document.path, self)
        self.crashes.close_asked.connect(self.close)
        self._make_middle()
        self._make_docks()
        self._make_menus()
        self._make_status()
        self._connect()
        self.setAcceptDrops(True)
        self.set_dark(settings.theme == "dark")
        self.use_unit(self.units.symbol)
        self._first_layout = self.saveState()
        self._take_up_layout()
        self._show_source()

    # The parts

    def _make_middle(self) -> None:
        self.start_page = StartPage(self.actions_by_id)
        self.view = make_view()
        self.pages = Pages(
            (
                Page("start", lambda: self.start_page),
                Page("connect", self._make_connect),
                Page("calibrate", self._make_calibrate),
                Page("capture", self._make_capture),
                Page("review", lambda: self.view),
            )
        )
        for name in ("start", "review"):
            self.pages.page(name)
        self.banner = Banner()
        self.hands = VirtualHands(self.parts)
        middle = QWidget()
        column = QVBoxLayout(middle)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.banner)
        column.addWidget(self.pages, 1)
        column.addWidget(self.hands)
        self.setCentralWidget(middle)
        self.files = Files(self, self.parts, self.view.image)

    def _make_connect(self) -> QWidget:
        from georibbon.gui.connect.page import ConnectPage

        return ConnectPage(self.parts)

    def _make_calibrate(self) -> QWidget:
        from georibbon.gui.calibrating.page import CalibrationPage

        page = CalibrationPage(self.parts)
        page.connect_wanted.connect(lambda: self.show_page("connect"))
        page.finished.connect(self._capture_with)
        return page

    def _make_capture(self) -> QWidget:
        from georibbon.gui.capturing.capture_page import CapturePage

        page = CapturePage(self.parts)
        page.wanted.connect(self.show_page)
        page.finished.connect(lambda: self.show_page("review"))
        return page

    def _capture_with(self, calibration: Calibration) -> None:
        """Plan a capture with a calibration that was just made."""
        self.show_page("capture")
        self.pages.page("capture").use_calibration(calibration, tr("just made"))

    def _make_docks(self) -> None:
        self.passes_panel = PassesPanel(self.parts)
        self.surface_panel = SurfacePanel(self.parts)
        self.view_panel = ViewPanel(self.parts, self.view)
        self.notices_panel, self.checks_panel = NoticesPanel(), ChecksPanel()
        self.checks_panel.chosen.connect(self.passes_panel.select)
        self.history_panel = HistoryPanel(self.parts)
        self.log_panel = LogPanel()
        self.curves_place = place_for_late()  # the plots are loaded with the first result
        self.docks = Docks(
            self,
            {
                "passes": self.passes_panel,
                "surface": self.surface_panel,
                "view": self.view_panel,
                "notices": self.notices_panel,
                "history": self.history_panel,
                "curves": self.curves_place,
                "checks": self.checks_panel,
                "log": self.log_panel,
            },
        )
        self.results = ResultViews(
            self.parts,
            self.view,
            self.passes_panel,
            (self.notices_panel, self.checks_panel),
            self.docks["curves"],
            self,
        )
        self.resize(1280, 800)
        self.docks.arrange()

    def _make_menus(self) -> None:
        menus = fill_menus(self, self.actions_by_id)
        self.recent_menu = menus[FILE].addMenu(tr("Open &recent"))
        menus[FILE].insertMenu(self.actions_by_id["import"], self.recent_menu)
        self.recent_menu.aboutToShow.connect(self._fill_recent)
        panels = menus[VIEW].addMenu(tr("P&anels"))
        for dock in self.docks:
            panels.addAction(dock.toggleViewAction())
        self.panels_menu = panels
        ways = {page: self.actions_by_id[f"page-{page}"] for page in _ways()}
        self.navigation = NavigationBar(ways, self)
        self.navigation.setWindowTitle(tr("Pages"))
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, self.navigation)
        self.toolbar = self.addToolBar(tr("Toolbar"))
        self.toolbar.setObjectName("toolbar")
        self.toolbar.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.toolbar.setMovable(False)
        fill_toolbar(self.toolbar, self.actions_by_id)

    def _make_status(self) -> None:
        self.summary = QLabel()
        self.kept = QLabel()
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)
        self.progress.setFixedWidth(120)
        self.progress.setTextVisible(False)
        self.progress.setAccessibleName(tr("Work is going on"))
        self.doing = QLabel()
        self.health = HealthStrip(self.parts)
        self.health.asked.connect(lambda: self.show_page("connect"))
        bar = self.statusBar()
        for label in (self.doing, self.summary, self.kept):
            label.setContentsMargins(8, 0, 8, 0)
        for part in (self.doing, self.progress, self.summary, self.kept, self.health):
            bar.addPermanentWidget(part)
        self._busy_words = ""
        self._busy_timer = QTimer(self)
        self._busy_timer.setSingleShot(True)
        self._busy_timer.setInterval(BUSY_AFTER_MS)
        self._busy_timer.timeout.connect(self._show_busy)
        self._show_idle()

    def _connect(self) -> None:
        document = self.document
        document.changed.connect(self._changed)
        document.reconstructed.connect(self._reconstructed)
        document.failed.connect(self._failed)
        document.fault.connect(self.notifier.exception)
        document.told.connect(lambda sentence: self.notifier.tell("warning", sentence))
        document.busy.connect(self._busy)
        self.bell.rang.connect(self._told)
        self.banner.details_asked.connect(self.show_log)
        self.start_page.asked.connect(self.open)
        self.pages.turned.connect(self._page_turned)
        self.station.fault.connect(self.notifier.exception)
        self.station.happened.connect(lambda event: self.notifier.tell("warning", event.message))
        self.station.failed.connect(lambda sentence: self.notifier.tell("error", sentence))
        self.station.changed.connect(self._link_changed)
        self.station.disconnected.connect(self._show_steps)
        self._connect_capture()
        self.results.summarised.connect(self.summary.setText)
        self.view_panel.section_export.connect(
            lambda section: save_section(self, self.notifier, self.files.folder(), section)
        )
        self.view_panel.deviation_from_session.connect(lambda: self.compare().ask_for_session())
        self.view_panel.deviation_from_mesh.connect(lambda: self.compare().ask_for_mesh())

    def _connect_capture(self) -> None:
        capture, document = self.capture, self.document
        capture.began.connect(self._capture_began)
        capture.ended.connect(self._capture_ended)
        capture.changed.connect(document.captured)
        capture.stood.connect(self._show_steps)
        capture.fault.connect(self.notifier.exception)
        capture.failed.connect(lambda sentence: self.notifier.tell("error", sentence))

    # What a person asks for

    def show_page(self, name: str) -> None:
        """Turn to a page."""
        self.pages.show_page(name)
        self.navigation.mark(self.pages.current)

    def open(self, path: Path) -> None:
        """Open a session or a recording folder."""
        self.files.open(path)

    def close_document(self) -> bool:
        """Back to the start page; whether that could be done."""
        self.capture.end()
        if self.document.close():
            return True
        return dialogs.ask_discard(self, self._sentence) and self.document.close(discard=True)

    def undo(self) -> None:
        """Take the last change back, and say which it was."""
        if self.capture.active:
            self.capture.undo()
            return
        words = self.document.undo()
        if words:
            self.statusBar().showMessage(tr("Undone: {what}", what=spoken(words)), 5000)

    def redo(self) -> None:
        """Do again what was undone last, and say what it was."""
        if self.capture.active:
            self.capture.redo()
            return
        words = self.document.redo()
        if words:
            self.statusBar().showMessage(tr("Done again: {what}", what=spoken(words)), 5000)

    def set_dark(self, dark: bool) -> None:
        """Dark colours, or light ones."""
        theme = "dark" if dark else "light"
        self.settings.theme = theme
        apply_theme(QApplication.instance(), theme)
        self.actions_by_id["dark"].setChecked(dark)
        for one in ACTIONS:
            if one.icon is not None:
                self.actions_by_id[one.id].setIcon(icon(one.icon, theme))

    def use_unit(self, symbol: str) -> None:
        """Lengths in another unit."""
        self.settings.unit = symbol
        self.units.use(symbol)
        for one in UNITS:
            self.actions_by_id[f"unit-{one}"].setChecked(one == symbol)

    def connect_virtual(self) -> None:
        """Connect to a ribbon that the program plays itself."""
        from georibbon.gui.connect.page import connect_virtual

        connect_virtual(self.parts)
        self.show_page("connect")

    def connect_again(self) -> None:
        """Connect to the ribbon that was connected last."""
        from georibbon.gui.connect.page import connect_last

        connect_last(self.parts)
        self.show_page("connect")

    def daily_check(self) -> None:
        """Whether the calibration still holds, by three poses."""
        self.show_page("calibrate")
        self.pages.page("calibrate").begin_check()

    def on_page(self, verb: str) -> None:
        """Have the page of the capture that is shown do something."""
        getattr(self.pages.currentWidget(), verb)()

    def finish_capture(self) -> None:
        """End the capture, and look at what came of it."""
        self.capture.end()
        self.show_page("review")

    def reset_passes(self) -> None:
        """Smoothing, sensors, ends and weights of all passes as at first."""
        from georibbon.session.settings import BY_PASS

        self.document.reset_settings(BY_PASS)

    def reset_surface(self) -> None:
        """The surface's settings as at first."""
        from georibbon.session.settings import OF_SURFACE

        self.document.reset_settings(OF_SURFACE)

    def colour_by(self, mode: str) -> None:
        """Colour the surface by another quantity."""
        self.show_page("review")
        self.view.set_colouring(mode)

    def use_tool(self, tool: str) -> None:
        """Pick or measure in the view."""
        self.show_page("review")
        self.view.set_tool(tool)
        self.view.setFocus()

    def export(self, kind: str) -> None:
        """Write what is open in another form; kind: as the dialog names it."""
        from georibbon.gui.review.export_dialog import ExportDialog

        ExportDialog(self.parts, self, kind).open()

    def compare(self) -> CompareWindow:
        """Lay another session or a mesh beside what is open."""
        from georibbon.gui.review.compare_window import CompareWindow

        window = CompareWindow(self.parts, self)
        window.compared.connect(self._show_deviation)
        window.show()
        return window

    @Slot(object, str)
    def _show_deviation(self, values: object, words: str) -> None:
        """What was compared colours the view here too."""
        self.view.set_deviation(values, words)
        self.view.set_colouring("deviation")

    def choose_calibration(self) -> None:
        """Reconstruct with another calibration."""
        self.show_history()
        self.history_panel.calibration.ask()

    def show_history(self) -> None:
        """What was done and noted, in front."""
        self.show_page("review")
        self.docks["history"].show()
        self.docks["history"].raise_()

    def add_note(self) -> None:
        """A note, from the page where one is."""
        if self.pages.current == "capture" and self.capture.active:
            self.pages.page("capture").ask_note()
        else:
            self.show_history()
            self.history_panel.write_note()

    def show_settings(self) -> None:
        """Colours, unit, language, sound and folder."""
        from georibbon.gui.settings_dialog import SettingsDialog

        dialog = SettingsDialog(self.parts, self)
        dialog.theme_chosen.connect(lambda theme: self.set_dark(theme == "dark"))
        dialog.open()

    def show_help(self) -> None:
        """The manual, at the page of what is shown."""
        self._manual().open_at(self.pages.current)

    def show_keyboard(self) -> None:
        """Every action with its keys."""
        self._manual().open_at("keyboard")

    def _manual(self) -> QWidget:
        from georibbon.gui.help.window import HelpWindow

        if self._help is None:
            self._help = HelpWindow(self.parts)
        return self._help

    def reset_layout(self) -> None:
        """The panels back where they were at first."""
        self.restoreState(self._first_layout)
        self.docks.show_all()
        self._docks_seen()

    def show_palette(self) -> None:
        """The list of all that can be done now."""
        palette = Palette(self.actions_by_id, self)
        palette.open()
        palette.words.setFocus()

    def show_log(self) -> None:
        """The log in front."""
        self.docks["log"].show()
        self.docks["log"].raise_()

    def show_crash_report(self) -> None:
        """Versions, log and the last fault, to copy or save."""
        self.crashes.show_report()

    def about(self) -> None:
        """Version and licence."""
        dialogs.show_about(self)

    # What the document tells

    @Slot(str)
    def _changed(self, what: str) -> None:
        if what == "source":
            self._show_source()
        self._show_steps()

    def _show_source(self) -> None:
        path = self.document.path
        self._unfitted = None
        self.banner.hide()
        if path is None:
            self.setWindowTitle("Georibbon")
            self.start_page.show_recent(self.settings.recent)
        else:
            self.setWindowTitle(f"{self.document.title} – Georibbon")
            self.settings.opened(path)
            self.notifier.tell("info", tr("opened {path}", path=path))
        if path is None:
            self.show_page("start")
        elif not self.capture.beginning:  # else its own page is where one is
            self.show_page("review")
        keeps = (
            tr("changes are kept in the file") if self.document.keeps else tr("opened to read only")
        )
        self.kept.setText("" if path is None else keeps)
        self._show_steps()

    @Slot(str)
    def _page_turned(self, name: str) -> None:
        self.navigation.mark(name)
        self.hands.setVisible(name in CAPTURING)  # it is empty without a virtual ribbon
        self._docks_seen()  # after it, or the window would grow for both
        self._show_steps()

    @Slot(object, str)
    def _link_changed(self, state: object, reason: str) -> None:
        self.notifier.tell("info", f"{state}: {reason}")
        self._show_steps()

    @Slot()
    def _capture_began(self) -> None:
        self.document.capturing = True
        self._show_steps()

    @Slot()
    def _capture_ended(self) -> None:
        self.document.capturing = False
        self.document.captured()
        self._show_steps()

    def _docks_seen(self) -> None:
        """Panels and toolbar belong to what is open, where it is seen."""
        seen = self.pages.current == "review"
        self.docks.see(seen)
        self.toolbar.setVisible(seen)
        self.panels_menu.setEnabled(seen)

    def _show_steps(self) -> None:
        """Which actions make sense, and what undoing and redoing would do."""
        document = self.document
        active, page = self.capture.active, self.pages.current
        there = {
            "nothing": True,
            "source": document.path is not None,
            "result": document.reconstruction is not None,
            "ribbon": self.station.active,
            "virtual": self.station.virtual is not None,
            "capture": active,
            "taking": active and page in CAPTURING,
            "laying": active and page == "capture",
        }
        for one in ACTIONS:
            self.actions_by_id[one.id].setEnabled(there[one.needs])
        steps = (
            ("undo", tr("Undo"), document.undoable),
            ("redo", tr("Redo"), document.redoable),
        )
        for name, verb, words in steps:
            action = self.actions_by_id[name]
            action.setText(f"&{verb} {spoken(words).replace('&', '&&')}" if words else f"&{verb}")
            action.setIconText(verb)
            action.setEnabled(words is not None)
        self.actions_by_id["reset-smoothing"].setEnabled(bool(document.smoothing))
        self.actions_by_id["auto"].setChecked(self.capture.auto)
        self.actions_by_id["hands-follow"].setChecked(self.hands.follow.isChecked())

    @Slot(object)
    def _reconstructed(self, _result: object) -> None:
        if self._unfitted is not None and self.banner.text.text().endswith(self._unfitted[1:]):
            self.banner.hide()
        self._unfitted = None
        self._show_steps()

    @Slot(str)
    def _failed(self, sentence: str) -> None:
        self._sentence = self._unfitted = spoken(sentence)
        self.notifier.tell("error", sentence)

    @Slot(object)
    def _told(self, entry) -> None:
        self.log_panel.add(entry)
        if entry.level != "info":
            self.banner.show_entry(entry)

    @Slot(bool, str)
    def _busy(self, busy: bool, words: str) -> None:
        self._busy_words = words
        if not busy:
            self._busy_timer.stop()
            self._show_idle()
        elif not self._busy_timer.isActive() and self.progress.isHidden():
            self._busy_timer.start()
        elif not self.progress.isHidden():
            self._show_busy()

    def _show_busy(self) -> None:
        self.doing.setText(f"{spoken(self._busy_words)} …")
        self.doing.show()
        self.progress.show()

    def _show_idle(self) -> None:
        self.doing.hide()
        self.progress.hide()

    # Around it

    def _fill_recent(self) -> None:
        menu = self.recent_menu
        menu.clear()
        for path in self.settings.recent:
            entry = menu.addAction(str(path).replace("&", "&&"))
            entry.triggered.connect(lambda _=False, path=path: self.open(path))
        menu.addSeparator()
        forget = menu.addAction(tr("&Forget these"))
        forget.setEnabled(bool(self.settings.recent))
        forget.triggered.connect(self._forget_recent)

    def _forget_recent(self) -> None:
        self.settings.forget_recent()
        self.start_page.show_recent([])

    def dragEnterEvent(self, event) -> None:
        """One file or folder of this machine may be dropped."""
        if dropped(event) is not None:
            event.acceptProposedAction()

    def dropEvent(self, event) -> None:
        """Open what is dropped."""
        path = dropped(event)
        if path is not None:
            event.acceptProposedAction()
            self.open(path)

    def _take_up_layout(self) -> None:
        kept = self.settings.layout()
        if kept is not None:
            geometry, state = kept
            self.restoreGeometry(geometry)
            self.restoreState(state)
        screens = QGuiApplication.screens()
        if not any(one.availableGeometry().intersects(self.frameGeometry()) for one in screens):
            self.move(QGuiApplication.primaryScreen().availableGeometry().topLeft())

    def closeEvent(self, event) -> None:
        """Keep the layout, close the session, wait for what is running."""
        self.docks.see(True)
        self.settings.keep_layout(self.saveGeometry(), self.saveState())
        self.settings.save()
        if not self.close_document():
            self._docks_seen()
            event.ignore()
            return
        self.pages.end()
        self.station.end()
        self.document.end()
        self.bell.end()
        self.crashes.end()
        if self._help is not None:
            self._help.close()
        event.accept()


def _make_parts(settings: Settings, notifier: Notifier, window: QMainWindow) -> Parts:
    """What there is one of, in the order in which they need each other."""
    document, station = Document(window), Station(window)
    capture = CaptureDesk(station, document, window)
    return Parts(settings, notifier, document, Units(settings.unit, window), station, capture)


def _ways() -> list[str]:
    """The pages that actions lead to, in their order."""
    return [one.argument for one in ACTIONS if one.id.startswith("page-")]
