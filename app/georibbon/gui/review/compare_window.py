"""Two surfaces side by side, and how far the first lies from the second."""

from pathlib import Path

from PySide6.QtCore import QStandardPaths, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QComboBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMenu,
    QProgressBar,
    QPushButton,
    QRadioButton,
    QSizePolicy,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui import dialogs
from georibbon.gui.language import tr
from georibbon.gui.length_box import LengthBox
from georibbon.gui.parts import Parts
from georibbon.gui.review.compare_table import CompareTable
from georibbon.gui.review.told import ToldLine
from georibbon.gui.review.worker import Worker
from georibbon.gui.scene_view import make_view
from georibbon.scene.labels import short_name

MESHES = "*.stl *.obj *.ply"
FINEST, COARSEST = 1e-5, 0.1


class CompareWindow(QMainWindow):
    """What is open on the left, another session, recording or mesh file on the right.

    Nothing is written to either.  compared(values, words): the deviation of every
    vertex of what is open, (n,) metres, and from what.
    """

    compared = Signal(object, str)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self._other = None
        self._path: Path | None = None
        self._comparison = None
        self.setWindowTitle(tr("Compare"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._reader, self._measurer = Worker(self), Worker(self)
        self._make_fields()
        self._make_layout()
        self._connect()
        self._show_first()
        self._show_state()
        self.resize(1180, 760)

    @classmethod
    def ask_session(cls, parent: QWidget, folder: Path) -> Path | None:
        """A session that a person chooses."""
        return dialogs.ask_session(parent, folder)

    @classmethod
    def ask_folder(cls, parent: QWidget, folder: Path) -> Path | None:
        """A recording folder that a person chooses."""
        return dialogs.ask_folder(parent, folder, tr("Compare with recording folder"))

    @classmethod
    def ask_mesh(cls, parent: QWidget, folder: Path) -> Path | None:
        """A mesh file that a person chooses."""
        filters = f"{tr('Meshes')} ({MESHES})"
        found, _ = QFileDialog.getOpenFileName(
            parent, tr("Compare with mesh file"), str(folder), filters
        )
        return Path(found) if found else None

    # The parts

    def _make_fields(self) -> None:
        self.choose = QPushButton(tr("&Compare with"))
        menu = QMenu(self.choose)
        for text, slot in (
            (tr("Another &session…"), self.ask_for_session),
            (tr("A recording &folder…"), self._ask_folder),
            (tr("A &mesh file…"), self.ask_for_mesh),
        ):
            action = QAction(text, menu)
            action.triggered.connect(slot)
            menu.addAction(action)
        self.choose.setMenu(menu)
        self.unit = QComboBox()
        self.unit.addItems(["mm", "cm", "m", "in"])
        self.unit.setToolTip(tr("The unit of the numbers in the mesh file"))
        self.aligned = QCheckBox(tr("&Lay it on best first"))
        self.aligned.setToolTip(
            tr("Move the first as a whole so that it fits best; for frames that differ")
        )
        self.tolerance = LengthBox(self._parts.units, FINEST, COARSEST, 1e-4)
        self.tolerance.set_metres(5e-4)
        self.linked = QCheckBox(tr("&Turn together"))
        self.linked.setChecked(True)
        self.by_deviation, self.by_uncertainty = (
            QRadioButton(tr("&Deviation")),
            QRadioButton(tr("&Uncertainty")),
        )
        self.by_deviation.setChecked(True)
        self._colouring = QButtonGroup(self)
        self._colouring.addButton(self.by_deviation)
        self._colouring.addButton(self.by_uncertainty)
        self.first, self.second = make_view(), make_view()
        self.first.setAccessibleName(tr("What is open, in three dimensions"))
        self.second.setAccessibleName(tr("What it is compared with, in three dimensions"))
        self.first_name, self.second_name = QLabel(), QLabel()
        for label in (self.first_name, self.second_name):
            label.setTextFormat(Qt.TextFormat.PlainText)
            font = label.font()
            font.setBold(True)
            label.setFont(font)
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.figures, self.told = ToldLine(), ToldLine()
        self.table = CompareTable(self._parts.units)
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)
        self.progress.setTextVisible(False)
        self.progress.setFixedWidth(120)
        self.progress.setAccessibleName(tr("Work is going on"))

    def _make_layout(self) -> None:
        self.unit_words = QLabel(tr("Mesh &unit"))
        self.unit_words.setBuddy(self.unit)
        within = QLabel(tr("T&olerance"))
        within.setBuddy(self.tolerance)
        bar = QHBoxLayout()
        for part in (
            self.choose, self.unit_words, self.unit, self.aligned, within, self.tolerance,
            QLabel(tr("Colours:")), self.by_deviation, self.by_uncertainty, self.linked,
        ):  # fmt: skip
            bar.addWidget(part)
        bar.addStretch(1)
        bar.addWidget(self.progress)
        views = QSplitter()
        views.setChildrenCollapsible(False)
        for label, view in ((self.first_name, self.first), (self.second_name, self.second)):
            side = QWidget()
            column = QVBoxLayout(side)
            column.setContentsMargins(0, 0, 0, 0)
            column.addWidget(label)
            column.addWidget(view, 1)
            views.addWidget(side)
        below = QWidget()
        column = QVBoxLayout(below)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.told)
        column.addWidget(self.figures)
        column.addWidget(self.table, 1)
        parts = QSplitter(Qt.Orientation.Vertical)
        parts.setChildrenCollapsible(False)
        parts.addWidget(views)
        parts.addWidget(below)
        parts.setStretchFactor(0, 1)
        parts.setSizes([480, 220])
        middle = QWidget()
        outer = QVBoxLayout(middle)
        outer.addLayout(bar)
        outer.addWidget(parts, 1)
        self.setCentralWidget(middle)

    def _connect(self) -> None:
        document, notifier = self._parts.document, self._parts.notifier
        document.reconstructed.connect(self._renewed)
        document.changed.connect(self._changed)
        self._parts.units.changed.connect(self._take_unit)
        self.unit.currentIndexChanged.connect(self._read_again)
        self.aligned.toggled.connect(self._measure)
        self.tolerance.edited.connect(self._count)
        self.by_deviation.toggled.connect(self._colour)
        self.linked.toggled.connect(self._follow_first)
        self.first.camera_moved.connect(self._follow_first)
        self.second.camera_moved.connect(self._follow_second)
        self._reader.done.connect(self._read)
        self._reader.failed.connect(self._failed)
        self._reader.fault.connect(notifier.exception)
        self._measurer.done.connect(self._measured)
        self._measurer.failed.connect(self._failed)
        self._measurer.fault.connect(notifier.exception)
        self._take_unit()

    # What a person asks for

    def ask_for_session(self) -> None:
        """Compare with a session that a person chooses."""
        self._take(self.ask_session(self, self._folder()))

    def _ask_folder(self) -> None:
        self._take(self.ask_folder(self, self._folder()))

    def ask_for_mesh(self) -> None:
        """Compare with a mesh file that a person chooses."""
        self._take(self.ask_mesh(self, self._folder()))

    def _folder(self) -> Path:
        here = self._parts.document.path
        if here is not None:
            return here.parent
        home = QStandardPaths.StandardLocation.DocumentsLocation
        return Path(QStandardPaths.writableLocation(home))

    def _take(self, path: Path | None) -> None:
        if path is not None:
            self.compare_with(path)

    def compare_with(self, path: Path) -> None:
        """Compare with a session, a recording folder or a mesh file."""
        self._path, unit = path, self.unit.currentText()
        self._forget()

        def work() -> object:
            from georibbon.export.comparison import read_other

            return read_other(path, unit)

        self.told.tell(tr("Reading {name}…", name=path.name))
        self._reader.ask(work)
        self._show_state()

    def _read_again(self) -> None:
        from georibbon.export.comparison import is_mesh_file

        if self._path is not None and is_mesh_file(self._path):
            self.compare_with(self._path)

    def _forget(self) -> None:
        """Nothing is compared with any more."""
        self._reader.forget()
        self._measurer.forget()
        self._other = self._comparison = None
        self.second.show_scene(None)
        self.second_name.setText("")
        self.first.set_deviation(None)
        self.figures.tell("")
        self.table.show_pairs(())

    # What comes of it

    def _changed(self, what: str) -> None:
        if what == "source":
            self.close()

    def _renewed(self) -> None:
        self._show_first()
        if self._other is not None:
            self._measure()

    def _show_first(self) -> None:
        document = self._parts.document
        self.first.show_scene(document.reconstruction)
        self.first_name.setText("" if document.path is None else document.path.name)

    def _read(self, other: object) -> None:
        self._other = other
        self.second_name.setText(other.name)
        self.second_name.setToolTip(other.name)
        self._show_second(None)
        self.second.copy_camera(self.first)
        self._measure()

    def _show_second(self, motion) -> None:
        """The other as it lies, or brought to where the first was laid on it from."""
        from georibbon.export.surfaces import moved, with_mesh
        from georibbon.geometry.alignment import Motion

        result, mine = self._other.result, self._parts.document.reconstruction
        for part in ("passes", "ties", "labels"):
            self.second.set_shown(part, result is not None)
        if result is None and mine is not None:
            result = with_mesh(mine, self._other.mesh)
        if result is not None and motion is not None:
            back = Motion(motion.rotation.T, -motion.rotation.T @ motion.translation)
            if self._other.result is None:  # its passes, which are not seen, stay
                mesh = moved(result, back).surface.mesh
                result = with_mesh(result, mesh)
            else:
                result = moved(result, back)
        self.second.show_scene(result)
        self._colour()

    def _measure(self) -> None:
        """Measure anew how the first lies from the other."""
        result, other = self._parts.document.reconstruction, self._other
        if other is None:
            return
        if result is None:
            self.told.tell(tr("What is open gives no surface yet, so nothing can be measured."))
            self._show_state()
            return
        name = self.first_name.text()
        tolerance, aligned = self.tolerance.metres, self.aligned.isChecked()

        def work() -> object:
            from georibbon.export.comparison import compare

            return result, compare(result, name, other, tolerance, aligned)

        self.told.tell(tr("Measuring…"))
        self._measurer.ask(work)
        self._show_state()

    def _measured(self, found: object) -> None:
        from georibbon.export.comparison import pass_pairs

        result, self._comparison = found
        self.told.tell("")
        self._show_second(self._comparison.motion)
        words = tr("from {name}", name=short_name(self._comparison.other.name))
        self.first.set_deviation(self._comparison.values, words)
        self.compared.emit(self._comparison.values, words)
        self.table.show_pairs(pass_pairs(result, self._comparison.other.result))
        self._colour()
        self._tell_figures()
        self._show_state()

    def _count(self) -> None:
        """Count what is within another tolerance."""
        result = self._parts.document.reconstruction
        if self._comparison is not None and result is not None:
            from georibbon.export.comparison import with_tolerance

            mesh = result.surface.mesh
            if len(mesh.vertices) == len(self._comparison.values):
                tolerance = self.tolerance.metres
                self._comparison = with_tolerance(self._comparison, mesh, tolerance)
            self._tell_figures()

    def _tell_figures(self) -> None:
        if self._comparison is None:
            return
        found, units = self._comparison.statistics, self._parts.units
        if found is None:
            self.figures.tell(
                tr(
                    "The two have no place in common; is the unit another, or the frame? Try to "
                    "lay it on first."
                ),
                "poor",
            )
            return
        lines = [
            tr(
                "Deviation: mean {mean}, rms {rms}, 95 % within {p95}, from {low} to {high}",
                mean=units.text(found.mean, 1),
                rms=units.text(found.rms, 1),
                p95=units.text(found.p95, 1),
                low=units.text(found.lowest, 1),
                high=units.text(found.highest, 1),
            ),
            tr(
                "{within} % of the area within {tolerance}; {covered} % is covered by the other",
                within=f"{100 * found.within:.1f}",
                tolerance=units.text(found.tolerance, 1),
                covered=f"{100 * found.covered:.1f}",
            ),
        ]
        motion = self._comparison.motion
        if motion is not None:
            away = float((motion.translation**2).sum() ** 0.5)
            lines.append(
                tr(
                    "Laid on first: turned {angle}°, moved {away}",
                    angle=f"{motion.angle * 57.29577951308232:.2f}",
                    away=units.text(away, 1),
                )
            )
        self.figures.tell("\n".join(lines))

    def _failed(self, sentence: str) -> None:
        self.told.tell(sentence, "poor")
        self._show_state()

    def _show_state(self) -> None:
        from georibbon.export.comparison import is_mesh_file

        mesh = self._path is not None and is_mesh_file(self._path)
        for part in (self.unit, self.unit_words):
            part.setVisible(mesh)
        self.progress.setVisible(self._reader.is_busy or self._measurer.is_busy)
        self.aligned.setEnabled(self._other is not None)
        if self._path is None:
            self.told.tell(tr("Choose what to compare with: a session, a recording or a mesh."))

    # The views

    def _colour(self) -> None:
        """Colour the first by its deviation, or both by their uncertainty in one range."""
        deviates = self.by_deviation.isChecked() and self._comparison is not None
        self.first.set_colouring("deviation" if deviates else "uncertainty")
        plain = self._other is not None and self._other.result is None
        self.second.set_colouring("plain" if plain else "uncertainty")
        if not deviates and not plain and self._other is not None:
            ranges = (self.first.range(), self.second.range())
            low, high = min(one[0] for one in ranges), max(one[1] for one in ranges)
            if low < high:
                self.first.set_range((low, high))
                self.second.set_range((low, high))

    def _follow_first(self) -> None:
        if self.linked.isChecked():
            self.second.copy_camera(self.first)

    def _follow_second(self) -> None:
        if self.linked.isChecked():
            self.first.copy_camera(self.second)

    def _take_unit(self) -> None:
        units = self._parts.units
        for view in (self.first, self.second):
            view.set_units(units.symbol, units.unit.metres)
        self._tell_figures()

    def closeEvent(self, event) -> None:
        """Nothing goes on after it."""
        self._reader.end()
        self._measurer.end()
        super().closeEvent(event)
