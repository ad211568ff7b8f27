"""What is open, written into files: the surface, the curves, a report, the recording."""

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QSplitter,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui import dialogs
from georibbon.gui.language import N_, tr
from georibbon.gui.length_box import LengthBox
from georibbon.gui.parts import Parts
from georibbon.gui.review.mesh_preview import MeshPreview
from georibbon.gui.review.told import ToldLine
from georibbon.gui.review.worker import Worker

if TYPE_CHECKING:
    from georibbon.export.cad import CadFacts
    from georibbon.export.choice import Choice

KINDS = {
    "surface": N_("Surface, as a mesh or as one spline"),
    "curves": N_("Curves of the passes, as a table"),
    "report": N_("Report"),
    "recording": N_("Recording folder, the raw data"),
}
FORMATS = {
    "surface": {
        ".stl": N_("STL, binary"),
        ".obj": N_("OBJ, with normals"),
        ".ply": N_("PLY, with normals and uncertainty"),
        ".step": N_("STEP, one spline for CAD programs"),
        ".iges": N_("IGES, one spline for CAD programs"),
    },
    "curves": {".csv": N_("CSV, metres")},
    "report": {
        ".pdf": N_("PDF"),
        ".html": N_("HTML page"),
        ".json": N_("JSON, for programs"),
    },
    "recording": {"": N_("recording.toml and CSV files of counts")},
}
UNITS = {
    "mm": N_("Millimetres (mm)"),
    "cm": N_("Centimetres (cm)"),
    "m": N_("Metres (m)"),
    "in": N_("Inches (in)"),
}
TITLES = {
    "surface": N_("Export surface"),
    "curves": N_("Export curves"),
    "report": N_("Write report"),
    "recording": N_("Write recording folder"),
}
EXPLAINED = {
    "curves": N_(
        "One row a point of every pass: arc length, position, normal, tangent and uncertainty, in "
        "metres."
    ),
    "report": N_(
        "The verdict with its reasons, notices, the surface with its checks, every pass, residuals "
        "by sensor, the survey and the calibration, with pictures: to be filed with the part."
    ),
    "recording": N_(
        "The raw counts of all poses and passes with the survey, as plain text that any program "
        "can read. Notes and settings stay in the session."
    ),
}
SPLINES = (".step", ".iges")
SHORTER = {".stp": ".step", ".igs": ".iges"}
FINEST, COARSEST = 1e-5, 5e-3
THINNEST, THICKEST = 1e-4, 0.1


class ExportDialog(QDialog):
    """One thing written after another; each with its own name.

    written(path): a file or folder is in its place.
    """

    written = Signal(object)

    def __init__(self, parts: Parts, parent: QWidget | None = None, kind: str = "surface") -> None:
        super().__init__(parent)
        self._parts = parts
        self._cancelled = False
        self._named = False  # whether a person has chosen the name
        self._unsound = False  # whether the mesh cannot be made as it is chosen
        self.setWindowTitle(tr("Export"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._writer, self._painter = Worker(self), Worker(self)
        self._make_fields()
        self._make_layout()
        self._connect()
        self._take_settings()
        self.choose_kind(kind)
        self.resize(880, 560)

    @classmethod
    def ask_place(cls, parent: QWidget, proposal: Path, title: str, kind: str) -> Path | None:
        """Where a person wants it, in place of the proposal."""
        endings = " ".join(f"*{ending}" for ending in FORMATS[kind])
        filters = "" if kind == "recording" else f"{tr(KINDS[kind])} ({endings})"
        return dialogs.ask_target(parent, proposal, title, filters)

    # The parts

    def _make_fields(self) -> None:
        units = self._parts.units
        self.kind, self.format, self.unit = QComboBox(), QComboBox(), QComboBox()
        for key, words in KINDS.items():
            self.kind.addItem(tr(words), key)
        for key, words in UNITS.items():
            self.unit.addItem(tr(words), key)
        self.tolerance = LengthBox(units, FINEST, COARSEST, 1e-5)
        self.tolerance.setToolTip(tr("How far the triangles or the spline may be from the surface"))
        self.solid = QCheckBox(tr("&Closed solid of thickness"))
        self.solid.setToolTip(tr("The surface thickened inwards, for printing"))
        self.thickness = LengthBox(units, THINNEST, THICKEST, 5e-4)
        self.thickness.setAccessibleName(tr("Thickness of the solid"))
        self.place = QLineEdit()
        self.browse = QPushButton(tr("&Browse…"))
        self.browse.setAutoDefault(False)  # Return writes
        self.told = ToldLine()
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)
        self.progress.setTextVisible(False)
        self.progress.setAccessibleName(tr("It is being written"))
        self.progress.hide()
        self.preview = MeshPreview(self._parts)
        self.explained = QLabel()
        self.explained.setWordWrap(True)
        self.explained.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.buttons = QDialogButtonBox()
        self.write = self.buttons.addButton("", QDialogButtonBox.ButtonRole.ActionRole)
        self.write.setDefault(True)
        self.stop = self.buttons.addButton(tr("Cance&l"), QDialogButtonBox.ButtonRole.ActionRole)
        self.buttons.addButton(tr("Cl&ose"), QDialogButtonBox.ButtonRole.RejectRole)

    def _make_layout(self) -> None:
        thick, where = QHBoxLayout(), QHBoxLayout()
        thick.addWidget(self.solid)
        thick.addWidget(self.thickness, 1)
        where.addWidget(self.place, 1)
        where.addWidget(self.browse)
        self.form = QFormLayout()
        self.form.addRow(tr("&What"), self.kind)
        self.form.addRow(tr("&Format"), self.format)
        self.form.addRow(tr("&Unit"), self.unit)
        self.form.addRow(tr("&Tolerance"), self.tolerance)
        self.form.addRow("", thick)
        into = QLabel(tr("&Into"))
        into.setBuddy(self.place)
        self.form.addRow(into, where)
        self._of_surface = (self.unit, self.tolerance, thick)
        left = QWidget()
        column = QVBoxLayout(left)
        column.setContentsMargins(0, 0, 8, 0)
        column.addLayout(self.form)
        column.addStretch(1)
        column.addWidget(self.told)
        column.addWidget(self.progress)
        self.right = QStackedWidget()
        self.right.addWidget(self.preview)
        self.right.addWidget(self.explained)
        parts = QSplitter()
        parts.addWidget(left)
        parts.addWidget(self.right)
        parts.setStretchFactor(1, 1)
        parts.setChildrenCollapsible(False)
        parts.setSizes([420, 440])
        outer = QVBoxLayout(self)
        outer.addWidget(parts, 1)
        outer.addWidget(self.buttons)

    def _connect(self) -> None:
        document = self._parts.document
        self.kind.currentIndexChanged.connect(self._show_kind)
        self.format.currentIndexChanged.connect(self._propose)
        self.format.currentIndexChanged.connect(self._show_format)
        self.solid.toggled.connect(self._show_format)
        self.tolerance.edited.connect(self._draw)
        self.thickness.edited.connect(self._draw)
        self.place.textEdited.connect(self._name)
        self.place.textChanged.connect(self._look)
        self.browse.clicked.connect(self._ask_place)
        self.write.clicked.connect(self.begin)
        self.stop.clicked.connect(self.cancel)
        self.buttons.rejected.connect(self.reject)
        self._writer.done.connect(self._written)
        self._writer.failed.connect(self._failed)
        self._writer.fault.connect(self._fault)
        self._painter.done.connect(self._drawn)
        self._painter.failed.connect(self._not_drawn)
        self._painter.fault.connect(self._parts.notifier.exception)
        document.reconstructed.connect(self._draw)
        document.changed.connect(self._changed)
        self.stop.setEnabled(False)

    # What is chosen

    def _take_settings(self) -> None:
        """The surface's tolerance and thickness as the document has them."""
        surface = self._parts.document.settings.surface
        self.tolerance.set_metres(surface.tolerance)
        self.solid.setChecked(surface.thickness is not None)
        self.thickness.set_metres(surface.thickness or 2e-3)

    def choose_kind(self, kind: str) -> None:
        """Show what is to be chosen of one of KINDS."""
        self.kind.setCurrentIndex(list(KINDS).index(kind))
        self._show_kind()

    @property
    def chosen(self) -> "Choice":
        """What is to be written now, as plain data."""
        from georibbon.export.choice import Choice

        surface = replace(
            self._parts.document.settings.surface,
            tolerance=self.tolerance.metres,
            thickness=self.thickness.metres if self.thickness.isEnabled() else None,
        )
        return Choice(self.kind.currentData(), self._path(), self.unit.currentData(), surface)

    def _show_kind(self) -> None:
        kind = self.kind.currentData()
        self.format.blockSignals(True)
        self.format.clear()
        for ending, words in FORMATS[kind].items():
            self.format.addItem(tr(words), ending)
        if kind == "surface":
            self._close_what_lacks()
        self.format.blockSignals(False)
        for row in self._of_surface:
            self.form.setRowVisible(row, kind == "surface")
        self.right.setCurrentWidget(self.preview if kind == "surface" else self.explained)
        self.explained.setText(tr(EXPLAINED[kind]) if kind in EXPLAINED else "")
        self._named = False
        self._propose()
        self._look()
        self._show_format()

    def _close_what_lacks(self) -> None:
        """Formats that cannot be written here cannot be chosen, and tell why."""
        from georibbon.export.cad import what_lacks

        lacking = what_lacks()
        for ending in SPLINES if lacking else ():
            at = self.format.findData(ending)
            self.format.model().item(at).setEnabled(False)
            self.format.setItemData(at, lacking, Qt.ItemDataRole.ToolTipRole)

    def _show_format(self) -> None:
        """A spline has no thickness."""
        self.solid.setEnabled(self.format.currentData() not in SPLINES)
        self.thickness.setEnabled(self.solid.isEnabled() and self.solid.isChecked())
        self._draw()

    def _propose(self) -> None:
        """A name beside what is open; of a name that a person chose, the ending alone."""
        kind, ending = self.kind.currentData(), self.format.currentData()
        named = Path(self.place.text())
        if self._named and named.name:
            self.place.setText(str(named.with_suffix(ending)))
            return
        source = self._parts.document.path
        if source is None:
            return
        stem = source.name.removesuffix(".georibbon")
        name = f"{stem}-recording" if kind == "recording" else f"{stem}{ending}"
        self.place.setText(str(self._folder() / name))

    def _path(self) -> Path:
        """The place that is named; a name alone is one beside what is open."""
        path = Path(self.place.text().strip())
        try:
            path = path.expanduser()
        except RuntimeError:  # a home that is nobody's
            return path
        return self._folder() / path

    def _folder(self) -> Path:
        """Where files are proposed to be put."""
        source = self._parts.document.path
        return self._parts.settings.folder or (Path.home() if source is None else source.parent)

    def _name(self) -> None:
        self._named = True

    def _ask_place(self) -> None:
        kind = self.kind.currentData()
        found = self.ask_place(self, Path(self.place.text()), tr(TITLES[kind]), kind)
        if found is not None:
            ending = found.suffix.lower()
            at = self.format.findData(SHORTER.get(ending, ending))
            if at >= 0:
                self.format.setCurrentIndex(at)
            self.place.setText(str(found))
            self._name()

    def _look(self) -> None:
        """Tell before it is written whether something is replaced by it."""
        kind, text = self.kind.currentData(), self.place.text().strip()
        there = kind != "recording" and bool(text) and _is_file(self._path())
        self.write.setText(tr("&Replace") if there else tr("W&rite"))
        if not self._writer.is_busy:
            name = Path(text).name
            self.told.tell(
                tr("{name} is there already; it will be replaced.", name=name) if there else ""
            )

    # The picture

    def _draw(self) -> None:
        """Show the mesh as it would be written, as soon as it is made."""
        result = self._parts.document.reconstruction
        if self.kind.currentData() != "surface":
            return
        if result is None or result.surface is None:
            self.preview.show_mesh(None, None)
            return
        choice = self.chosen

        def work() -> object:
            from georibbon.export.choice import mesh_of
            from georibbon.export.surfaces import mesh_facts, with_mesh

            mesh = mesh_of(choice, result)
            return with_mesh(result, mesh), mesh_facts(mesh)

        self._painter.ask(work)

    def _drawn(self, found: object) -> None:
        self.preview.show_mesh(*found)
        if self._unsound:
            self._unsound = False
            self._look()

    def _not_drawn(self, sentence: str) -> None:
        self.preview.show_mesh(None, None)
        self._unsound = True
        self.told.tell(sentence, "poor")

    def _changed(self, what: str) -> None:
        if what == "source":
            self.reject()

    # The work

    def begin(self) -> None:
        """Write what is chosen."""
        if self._writer.is_busy:
            return
        if not self.place.text().strip():
            self.told.tell(tr("Say into which file it is to be written."), "poor")
            self.place.setFocus()
            return
        document, choice = self._parts.document, self.chosen
        result, recording = document.reconstruction, document.captured_so_far()
        source, title = str(document.path), document.title
        self._cancelled = False

        def work() -> object:
            from georibbon.export.choice import CancelledError, write

            try:
                facts = write(choice, result, recording, source, title, lambda: self._cancelled)
            except CancelledError:
                return None
            return choice.path, facts

        self.told.tell(tr("Writing {name}…", name=choice.path.name))
        self._show_busy(True)
        self._writer.ask(work)

    def cancel(self) -> None:
        """Leave nothing of what is being written."""
        if self._writer.is_busy:
            self._cancelled = True
            self.told.tell(tr("Cancelling…"))

    def _written(self, done: object) -> None:
        self._show_busy(False)
        if done is None:
            self.told.tell(tr("Cancelled; nothing was written."))
            return
        path, facts = done
        self._look()  # it is there now
        self.told.tell(self._words(path, facts), "good")
        self.written.emit(path)

    def _words(self, path: Path, facts: "CadFacts | None") -> str:
        if facts is None:
            return tr("Written: {path}", path=path)
        along, across = facts.count
        return tr(
            "Written: {path}: one spline within {distance} and {angle}° of the patches, "
            "{along} × {across} control points, read back",
            path=path,
            distance=self._parts.units.text(facts.deviation, 3),
            angle=f"{math.degrees(facts.turn):.2g}",
            along=along,
            across=across,
        )

    def _failed(self, sentence: str) -> None:
        self._show_busy(False)
        self.told.tell(sentence, "poor")

    def _fault(self, error: object) -> None:
        self._show_busy(False)
        self.told.tell(tr("It could not be written; see the log."), "poor")
        self._parts.notifier.exception(error)

    def _show_busy(self, busy: bool) -> None:
        self.progress.setVisible(busy)
        self.write.setEnabled(not busy)
        self.stop.setEnabled(busy)

    def done(self, code: int) -> None:
        """Close: nothing of what is being written is left."""
        self._cancelled = True
        self._writer.end()
        self._painter.end()
        super().done(code)


def _is_file(path: Path) -> bool:
    """Whether a file is there; not where the name is one that cannot be."""
    try:
        return path.is_file()
    except OSError:
        return False
