"""The main window: it makes the parts and connects them, and does nothing by itself."""

from pathlib import Path

from PySide6.QtCore import QByteArray, QStandardPaths, Qt, QTimer, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QLabel,
    QMainWindow,
    QProgressBar,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from georibbon.errors import GeoribbonError
from georibbon.gui import dialogs
from georibbon.gui.actions import ACTIONS, Palette, fill_menus, fill_toolbar, make_actions
from georibbon.gui.document import Document
from georibbon.gui.icons import icon
from georibbon.gui.log import Banner, Bell, LogPanel
from georibbon.gui.notices_panel import NoticesPanel
from georibbon.gui.notifier import Notifier
from georibbon.gui.passes_panel import PassesPanel
from georibbon.gui.scene_view import make_view
from georibbon.gui.settings import Settings
from georibbon.gui.start_page import StartPage
from georibbon.gui.theme import apply_theme

BUSY_AFTER_MS = 250  # what takes no longer needs no telling
BESIDE, BELOW = Qt.DockWidgetArea.RightDockWidgetArea, Qt.DockWidgetArea.BottomDockWidgetArea


class MainWindow(QMainWindow):
    """The start page, or the view of what is open with its panels around it."""

    def __init__(self, settings: Settings, notifier: Notifier) -> None:
        super().__init__()
        self.settings, self.notifier = settings, notifier
        self.document = Document(self)
        self.bell = Bell(notifier, self)
        self.actions_by_id = make_actions(self)
        self._unfitted: str | None = None
        self._sentence = ""  # what was told last
        self._curves = None
        self._docks_are_seen = True
        self._make_middle()
        self._make_docks()
        self._make_menus()
        self._make_status()
        self._connect()
        self.setAcceptDrops(True)
        self.set_dark(settings.theme == "dark")
        self._first_layout = self.saveState()
        self._take_up_layout()
        self._show_source()

    # The parts

    def _make_middle(self) -> None:
        self.start_page = StartPage(self.actions_by_id)
        self.view = make_view()
        self.stack = QStackedWidget()
        self.stack.addWidget(self.start_page)
        self.stack.addWidget(self.view)
        self.banner = Banner()
        middle = QWidget()
        column = QVBoxLayout(middle)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.banner)
        column.addWidget(self.stack, 1)
        self.setCentralWidget(middle)

    def _make_docks(self) -> None:
        self.setDockOptions(QMainWindow.DockOption.AllowTabbedDocks)
        self.passes_panel = PassesPanel(self.document)
        self.notices_panel = NoticesPanel()
        self.log_panel = LogPanel()
        self.curves_place = QWidget()  # the plots are loaded with the first result
        QVBoxLayout(self.curves_place).setContentsMargins(0, 0, 0, 0)
        self.passes_dock = self._dock("Passes", self.passes_panel, BESIDE)
        self.notices_dock = self._dock("Notices", self.notices_panel, BESIDE)
        self.curves_dock = self._dock("Curves", self.curves_place, BELOW)
        self.log_dock = self._dock("Log", self.log_panel, BELOW)
        self.tabifyDockWidget(self.curves_dock, self.log_dock)
        self.curves_dock.raise_()
        self.setCorner(Qt.Corner.BottomRightCorner, BESIDE)  # the passes get all the height
        self.docks = (self.passes_dock, self.notices_dock, self.curves_dock, self.log_dock)
        self.resize(1280, 800)
        self.resizeDocks(
            [self.passes_dock, self.notices_dock], [500, 500], Qt.Orientation.Horizontal
        )
        self.resizeDocks([self.passes_dock, self.notices_dock], [520, 200], Qt.Orientation.Vertical)
        self.resizeDocks([self.curves_dock, self.log_dock], [270, 270], Qt.Orientation.Vertical)

    def _dock(self, title: str, panel: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title.lower())
        dock.setWidget(panel)
        self.addDockWidget(area, dock)
        return dock

    def _make_menus(self) -> None:
        menus = fill_menus(self, self.actions_by_id)
        self.recent_menu = menus["&File"].addMenu("Open &recent")
        menus["&File"].insertMenu(self.actions_by_id["import"], self.recent_menu)
        self.recent_menu.aboutToShow.connect(self._fill_recent)
        panels = menus["&View"].addMenu("P&anels")
        for dock in self.docks:
            seen = dock.toggleViewAction()
            seen.setStatusTip(f"Show or hide the panel {dock.windowTitle()}")
            panels.addAction(seen)
        self.panels_menu = panels
        self.toolbar = self.addToolBar("Toolbar")
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
        self.progress.setAccessibleName("Work is going on")
        self.doing = QLabel()
        bar = self.statusBar()
        for label in (self.doing, self.summary, self.kept):
            label.setContentsMargins(8, 0, 8, 0)
        for part in (self.doing, self.progress, self.summary, self.kept):
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
        document.reconstructed.connect(self._show_result)
        document.failed.connect(self._failed)
        document.fault.connect(self.notifier.exception)
        document.told.connect(lambda sentence: self.notifier.tell("warning", sentence))
        document.busy.connect(self._busy)
        self.bell.rang.connect(self._told)
        self.banner.details_asked.connect(self.show_log)
        self.start_page.asked.connect(self.open)
        self.passes_panel.chosen.connect(self._show_curves)
        self.curves_dock.visibilityChanged.connect(lambda _: self._show_curves())

    # What a person asks for

    def open(self, path: Path) -> None:
        """Open a session or a recording folder."""
        self.document.open(path)

    def ask_open_session(self) -> None:
        """Open a session that a person chooses."""
        path = dialogs.ask_session(self, self._folder())
        if path is not None:
            self.open(path)

    def ask_open_folder(self) -> None:
        """Open a recording folder that a person chooses."""
        path = dialogs.ask_folder(self, self._folder(), "Open recording folder")
        if path is not None:
            self.open(path)

    def ask_import(self) -> None:
        """Import a recording folder that a person chooses into a session file to be chosen too."""
        folder = dialogs.ask_folder(self, self._folder(), "Import recording folder")
        if folder is None:
            return
        proposal = folder.with_name(f"{folder.name}.georibbon")
        target = dialogs.ask_target(self, proposal, "Import into session", dialogs.SESSIONS)
        if target is not None:
            self.document.import_folder(folder, target)

    def open_demonstration(self) -> None:
        """Open the virtual capture of a car bonnet."""
        place = QStandardPaths.StandardLocation.AppLocalDataLocation
        self.document.open_demonstration(Path(QStandardPaths.writableLocation(place)))

    def ask_export_surface(self) -> None:
        """Write the surface into a file that a person chooses."""
        from georibbon.export.mesh import write_mesh

        result = self.document.reconstruction
        if result is None or result.surface is None:
            self.notifier.tell("error", "there is no surface to export; mend what is told of first")
            return
        target = self._ask_target("Export surface", ".stl", dialogs.SURFACES)
        if target is not None:
            mesh = result.surface.export_mesh
            self._write(target, lambda: write_mesh(mesh, target, "mm"))

    def ask_save_picture(self) -> None:
        """Save what the view shows into a file that a person chooses."""
        from georibbon.export.files import PICTURE_ENDINGS, require_ending, write_whole

        def write() -> None:
            require_ending(target, PICTURE_ENDINGS, "a picture")
            write_whole(target, _png(self.view.image()))

        target = self._ask_target("Save picture", ".png", dialogs.PICTURES)
        if target is not None:
            self._write(target, write)

    def _ask_target(self, title: str, ending: str, filters: str) -> Path | None:
        name = self.document.path.stem if self.document.path else "georibbon"
        return dialogs.ask_target(self, self._folder() / f"{name}{ending}", title, filters)

    def _write(self, target: Path, write) -> None:
        try:
            write()
        except (GeoribbonError, OSError) as error:
            self.notifier.tell("error", str(error))
        else:
            self.notifier.tell("info", f"written: {target}")
            self.statusBar().showMessage(f"Written: {target}", 8000)

    def close_document(self) -> bool:
        """Back to the start page; whether that could be done."""
        if self.document.close():
            return True
        return dialogs.ask_discard(self, self._sentence) and self.document.close(discard=True)

    def undo(self) -> None:
        """Take the last change back, and say which it was."""
        words = self.document.undo()
        if words:
            self.statusBar().showMessage(f"Undone: {words}", 5000)

    def redo(self) -> None:
        """Do again what was undone last, and say what it was."""
        words = self.document.redo()
        if words:
            self.statusBar().showMessage(f"Done again: {words}", 5000)

    def reset_smoothing(self) -> None:
        """All passes automatically."""
        self.document.reset_smoothing()

    def fit(self) -> None:
        """Show all of the object."""
        self.view.fit()

    def look(self, name: str) -> None:
        """Look from one of the standard sides."""
        self.view.standard_view(name)

    def set_parallel(self, parallel: bool) -> None:
        """Parallel projection, or perspective."""
        self.view.set_parallel(parallel)

    def set_dark(self, dark: bool) -> None:
        """Dark colours, or light ones."""
        theme = "dark" if dark else "light"
        self.settings.theme = theme
        apply_theme(QApplication.instance(), theme)
        self.actions_by_id["dark"].setChecked(dark)
        for one in ACTIONS:
            if one.icon is not None:
                self.actions_by_id[one.id].setIcon(icon(one.icon, theme))

    def reset_layout(self) -> None:
        """The panels back where they were at first."""
        self.restoreState(self._first_layout)
        self._docks_are_seen = True
        for dock in self.docks:
            dock.show()
        self._docks_seen(self.document.path is not None)

    def show_palette(self) -> None:
        """The list of all that can be done now."""
        palette = Palette(self.actions_by_id, self)
        palette.open()
        palette.words.setFocus()

    def show_log(self) -> None:
        """The log in front."""
        self.log_dock.show()
        self.log_dock.raise_()

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
            self.notifier.tell("info", f"opened {path}")
        self.view.show_scene(None)
        self.notices_panel.show_result(None)
        if self._curves is not None:
            self._curves.show_passes(None, ())
        self.summary.clear()
        self.stack.setCurrentWidget(self.start_page if path is None else self.view)
        self._docks_seen(path is not None)
        keeps = "changes are kept in the file" if self.document.keeps else "opened to read only"
        self.kept.setText("" if path is None else keeps)
        self._show_steps()

    def _docks_seen(self, seen: bool) -> None:
        """Panels belong to what is open; which of them, a person decided."""
        if seen == self._docks_are_seen:
            return
        self._docks_are_seen = seen
        if not seen:
            self._shown = {dock for dock in self.docks if not dock.isHidden()}
        for dock in self.docks:
            dock.setVisible(seen and dock in self._shown)
            dock.toggleViewAction().setEnabled(seen)
        self.toolbar.setVisible(seen)
        self.panels_menu.setEnabled(seen)

    def _show_steps(self) -> None:
        """Which actions make sense, and what undoing and redoing would do."""
        document = self.document
        there = {
            "nothing": True,
            "source": document.path is not None,
            "result": document.reconstruction is not None,
        }
        for one in ACTIONS:
            self.actions_by_id[one.id].setEnabled(there[one.needs])
        for name, words in (("undo", document.undoable), ("redo", document.redoable)):
            action, verb = self.actions_by_id[name], name.capitalize()
            action.setText(f"&{verb} {words.replace('&', '&&')}" if words else f"&{verb}")
            action.setIconText(verb)
            action.setEnabled(words is not None)
        self.actions_by_id["reset-smoothing"].setEnabled(bool(document.smoothing))

    @Slot(object)
    def _show_result(self, result) -> None:
        if self._unfitted is not None and self.banner.text.text().endswith(self._unfitted[1:]):
            self.banner.hide()
        self._unfitted = None
        self.view.show_scene(result)
        self.notices_panel.show_result(result)
        self.summary.setText(_summary(result))
        self._show_curves()
        self._show_steps()

    def _show_curves(self, _names: object = None) -> None:
        """The curves of the selected passes, or of all, where they are seen."""
        result = self.document.reconstruction
        if result is None or not self.curves_dock.isVisible():
            return
        if self._curves is None:
            from georibbon.gui.curve_panel import CurvePanel

            self._curves = CurvePanel(self.curves_place)
            self._curves.cursor_moved.connect(self.view.show_cursor)
            self.curves_place.layout().addWidget(self._curves)
        names = self.passes_panel.selected() or [one.name for one in result.passes]
        self._curves.show_passes(result, names)

    @Slot(str)
    def _failed(self, sentence: str) -> None:
        self._sentence = sentence
        self._unfitted = sentence if self.document.failure == sentence else None
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
        self.doing.setText(f"{self._busy_words} …")
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
        forget = menu.addAction("&Forget these")
        forget.setEnabled(bool(self.settings.recent))
        forget.triggered.connect(self._forget_recent)

    def _forget_recent(self) -> None:
        self.settings.forget_recent()
        self.start_page.show_recent([])

    def _folder(self) -> Path:
        """Where a person looked last."""
        path = self.document.path or next(iter(self.settings.recent), None)
        return Path.home() if path is None else path.parent

    def dragEnterEvent(self, event) -> None:
        """One file or folder of this machine may be dropped."""
        if _dropped(event) is not None:
            event.acceptProposedAction()

    def dropEvent(self, event) -> None:
        """Open what is dropped."""
        path = _dropped(event)
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
        self._docks_seen(True)
        self.settings.keep_layout(self.saveGeometry(), self.saveState())
        self.settings.save()
        if not self.close_document():
            self._docks_seen(self.document.path is not None)
            event.ignore()
            return
        self.document.end()
        self.bell.end()
        event.accept()


def _summary(result) -> str:
    """What came out, in a line."""
    from georibbon.session.words import counted

    passes = sum(one.kind == "pass" for one in result.passes)
    words = [counted(passes, "pass", "passes")]
    if len(result.passes) > passes:
        words.append(counted(len(result.passes) - passes, "tie"))
    redo = sum(one.quality.verdict == "redo" for one in result.passes)
    if redo:
        words.append(f"{redo} to be laid again")
    if result.surface is not None:
        words.append(f"{result.surface.area:.3f} m²")
        words.append(counted(len(result.surface.mesh.triangles), "triangle"))
    return " · ".join(words)


def _dropped(event) -> Path | None:
    urls = event.mimeData().urls()
    if len(urls) != 1 or not urls[0].isLocalFile():
        return None
    return Path(urls[0].toLocalFile())


def _png(image) -> bytes:
    from PySide6.QtCore import QBuffer, QIODevice

    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    image.save(buffer, "PNG")
    buffer.close()
    return bytes(data.data())
