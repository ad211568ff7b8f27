"""The 3D view's panel: its colours and their range, what is shown, tools and what they found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.language import N_, tr
from georibbon.gui.measure_list import Results
from georibbon.gui.parts import Parts
from georibbon.gui.units import Units

if TYPE_CHECKING:
    from georibbon.gui.scene_view import ImageView, SceneView
    from georibbon.scene.measuring import Section

# Mode, what it is called, what it says, the unit of its range ("" for a length, None for none).
_COLOURINGS = (
    ("uncertainty", N_("Position uncertainty (1σ)"),
     N_("How far off a place may lie: the root of its covariance's trace."), ""),
    ("gaussian", N_("Gaussian curvature"),
     N_("Red where the surface is domed or hollow, blue where it is a saddle."), "1/m²"),
    ("mean", N_("Mean curvature"),
     N_("Red where the surface bends towards its outside, blue where away from it."), "1/m"),
    ("normal", N_("Curvature along the passes"),
     N_("Red where the ribbon bends towards the surface's outside, blue where away from it."),
     "1/m"),
    ("deviation", N_("Deviation"),
     N_("How far the surface lies outside (red) or inside (blue) of what it is compared with."),
     ""),
    ("zebra", N_("Zebra stripes"),
     N_("Stripes mirrored in the surface: one that breaks or has a kink shows a flaw; turn the "
        "view to let them run over it."), None),
    ("plain", N_("One colour"), "", None),
)  # fmt: skip
_PARTS = (
    ("surface", N_("&Surface")),
    ("passes", N_("&Passes")),
    ("ties", N_("&Ties")),
    ("sensors", N_("S&ensors")),
    ("frames", N_("&Frames")),
    ("marks", N_("Survey &marks")),
    ("labels", N_("&Labels")),
    ("floor", N_("Fl&oor grid")),
)
_TOOLS = (
    (
        "point",
        N_("Po&int"),
        N_("Click a place: its position, uncertainty, curvature, nearest pass"),
    ),
    ("distance", N_("&Distance"), N_("Click two places: straight and along the surface")),
    ("section", N_("Se&ction"), N_("Click two places: the profile of the surface through them")),
)
_MOST = 1e6  # of a range, in what is shown


class ViewPanel(QScrollArea):
    """What a person chooses of a 3D view, and what was picked and measured in it.

    deviation_from_session(), deviation_from_mesh(): a person wants to choose what
    to compare with.  section_export(Section): to have one as a CSV file.
    """

    deviation_from_session = Signal()
    deviation_from_mesh = Signal()
    section_export = Signal(object)

    def __init__(
        self, parts: Parts, view: SceneView | ImageView, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._units: Units = parts.units
        self._view = view
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.addWidget(self._make_colours())
        column.addWidget(self._make_shown())
        column.addWidget(self._make_tools(), 1)
        self.setWidget(inside)
        view.recoloured.connect(self._follow)
        view.tool_changed.connect(self._follow_tool)
        view.hinted.connect(self.hint.setText)
        view.tools.fault.connect(parts.notifier.exception)
        view.picked.connect(self.results.add)
        view.measured.connect(self.results.add)
        view.sectioned.connect(self.results.add)
        self._units.changed.connect(self._take_unit)
        self._take_unit()
        self._follow()

    # --- making ---

    def _make_colours(self) -> QGroupBox:
        box = QGroupBox(tr("Colours"))
        grid = QGridLayout(box)
        grid.setColumnStretch(1, 1)
        self.colouring = QComboBox()
        for mode, words, _, _ in _COLOURINGS:
            self.colouring.addItem(tr(words), mode)
        self.colouring.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.colouring.setMinimumContentsLength(16)
        self.colouring.activated.connect(
            lambda index: self._view.set_colouring(self.colouring.itemData(index))
        )
        label = QLabel(tr("Colo&ur by"))
        label.setBuddy(self.colouring)
        grid.addWidget(label, 0, 0)
        grid.addWidget(self.colouring, 0, 1)
        self.meaning = QLabel()
        self.meaning.setWordWrap(True)
        grid.addWidget(self.meaning, 1, 0, 1, 2)
        grid.addWidget(self._make_fixed(), 2, 0)
        grid.addLayout(self._make_bounds(), 2, 1)
        grid.addWidget(QLabel(tr("Deviation")), 3, 0)
        grid.addLayout(self._make_comparing(), 3, 1)
        return box

    def _make_fixed(self) -> QCheckBox:
        self.fixed = QCheckBox(tr("Fi&xed range"))
        self.fixed.setToolTip(tr("Keep the range, to compare one state with another"))
        self.fixed.clicked.connect(self._fix)
        return self.fixed

    def _make_bounds(self) -> QHBoxLayout:
        self.low, self.high = _Bound(tr("Lowest value")), _Bound(tr("Highest value"))
        for bound in (self.low, self.high):
            bound.valueChanged.connect(self._typed)
        bounds = QHBoxLayout()
        bounds.addWidget(self.low, 1)
        bounds.addWidget(QLabel(tr("to")))
        bounds.addWidget(self.high, 1)
        return bounds

    def _make_comparing(self) -> QHBoxLayout:
        self.from_session = QPushButton(tr("From a sess&ion…"))
        self.from_session.setToolTip(tr("Colour by the distance from another session's surface"))
        self.from_session.clicked.connect(self.deviation_from_session)
        self.from_mesh = QPushButton(tr("From a mes&h file…"))
        self.from_mesh.setToolTip(tr("Colour by the distance from an STL, OBJ or PLY file"))
        self.from_mesh.clicked.connect(self.deviation_from_mesh)
        buttons = QHBoxLayout()
        buttons.addWidget(self.from_session)
        buttons.addWidget(self.from_mesh)
        return buttons

    def _make_shown(self) -> QGroupBox:
        box = QGroupBox(tr("Shown"))
        grid = QGridLayout(box)
        self.shown: dict[str, QCheckBox] = {}
        for k, (part, words) in enumerate(_PARTS):
            check = QCheckBox(tr(words))
            check.clicked.connect(lambda on, part=part: self._view.set_shown(part, on))
            self.shown[part] = check
            grid.addWidget(check, k // 2, k % 2)
        return box

    def _make_tools(self) -> QGroupBox:
        box = QGroupBox(tr("Measure"))
        column = QVBoxLayout(box)
        column.addLayout(self._make_tool_buttons())
        self.upright = QCheckBox(tr("Sections stand up&right"))
        self.upright.setToolTip(tr("Otherwise they lie along the line of sight"))
        self.upright.setChecked(True)
        self.upright.clicked.connect(self._view.set_upright_sections)
        column.addWidget(self.upright)
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        self.hint.setTextFormat(Qt.TextFormat.PlainText)
        column.addWidget(self.hint)
        self.results = Results(self._units)
        self.results.chosen.connect(self._show_profile)
        column.addWidget(self.results, 1)
        self._column, self.profile = column, None
        column.addLayout(self._make_result_buttons())
        self.results.filled.connect(self._follow_results)
        self._follow_results()
        return box

    def _make_tool_buttons(self) -> QHBoxLayout:
        row = QHBoxLayout()
        self.tools: dict[str, QPushButton] = {}
        for tool, words, tip in _TOOLS:
            button = QPushButton(tr(words))
            button.setCheckable(True)
            button.setToolTip(tr(tip))
            button.clicked.connect(
                lambda on, tool=tool: self._view.set_tool(tool if on else "none")
            )
            self.tools[tool] = button
            row.addWidget(button)
        return row

    def _make_result_buttons(self) -> QHBoxLayout:
        row = QHBoxLayout()
        self.copy_button = QPushButton(tr("Cop&y all"))
        self.copy_button.clicked.connect(self.copy_all)
        self.clear_button = QPushButton(tr("Clear"))
        self.clear_button.clicked.connect(self.clear)
        self.export_button = QPushButton(tr("Section as CS&V…"))
        self.export_button.clicked.connect(self._export)
        for button in (self.copy_button, self.clear_button, self.export_button):
            row.addWidget(button)
        return row

    # --- what a person does ---

    def copy_all(self) -> None:
        """Put all that was picked and measured on the clipboard, as text."""
        QGuiApplication.clipboard().setText(self.results.text())

    def clear(self) -> None:
        """Forget what was picked and measured."""
        self.results.empty()
        self._view.clear_marks()

    def _fix(self, fixed: bool) -> None:
        self._view.set_range(self._view.range() if fixed else None)

    def _typed(self) -> None:
        low, high = self.low.value() * self._size(), self.high.value() * self._size()
        right = low < high
        self.hint_of_range(right)
        if right:
            self._view.set_range((low, high))

    def hint_of_range(self, right: bool) -> None:
        """Say beside the boxes whether the range can be used."""
        words = tr("The lowest value must be below the highest.")
        self.meaning.setText(self._meaning() if right else words)

    def _export(self) -> None:
        section = self.results.section()
        if section is not None:
            self.section_export.emit(section)

    # --- what it follows ---

    def _entry(self) -> tuple[str, str, str, str | None]:
        return next(one for one in _COLOURINGS if one[0] == self._view.colouring)

    def _meaning(self) -> str:
        mode, _, words, _ = self._entry()
        if mode == "deviation" and not self._view.has_deviation:
            return tr("Choose below what this surface is to be compared with.")
        return tr(words) if words else ""

    def _size(self) -> float:
        """The size of the unit that the range is shown in, in the mode's SI unit."""
        return self._units.unit.metres if self._entry()[3] == "" else 1.0

    def _follow(self) -> None:
        mode, _, _, unit = self._entry()
        index = self.colouring.findData(mode)
        if index != self.colouring.currentIndex():
            self.colouring.setCurrentIndex(index)
        if self.meaning.text() != self._meaning():
            self.meaning.setText(self._meaning())
        fixed = self._view.fixed_range is not None
        self.fixed.setChecked(fixed)
        suffix = self._units.symbol if unit == "" else unit or ""
        for bound, value in zip((self.low, self.high), self._view.range(), strict=True):
            bound.show_value(value / self._size(), suffix)
            bound.setEnabled(fixed)
        for widget in (self.fixed, self.low, self.high):
            widget.setVisible(unit is not None)
        for part, check in self.shown.items():
            check.setChecked(self._view.is_shown(part))

    def _follow_tool(self, tool: str) -> None:
        for name, button in self.tools.items():
            button.setChecked(name == tool)
            font = button.font()
            font.setBold(name == tool)
            button.setFont(font)

    def _take_unit(self) -> None:
        self._view.set_units(self._units.symbol, self._units.unit.metres)
        self.results.fill()
        self._follow()

    def _follow_results(self) -> None:
        some = self.results.count() > 0
        self.copy_button.setEnabled(some)
        self.clear_button.setEnabled(some)
        self._show_profile(self.results.section())

    def _show_profile(self, section: Section | None) -> None:
        self.export_button.setEnabled(section is not None)
        if section is not None and self.profile is None:
            from georibbon.gui.profile_plot import ProfilePlot  # pyqtgraph: loaded when needed

            self.profile = ProfilePlot(self._units)
            self._column.insertWidget(self._column.count() - 1, self.profile)
        if self.profile is not None:
            self.profile.setVisible(section is not None)
            if section is not None:
                self.profile.show_section(section)


class _Bound(QDoubleSpinBox):
    """One end of a range."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setRange(-_MOST, _MOST)
        self.setKeyboardTracking(False)
        self.setAccessibleName(name)
        self.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setMinimumWidth(self.fontMetrics().horizontalAdvance("-0.0000 1/m²") + 24)
        self.setDecimals(4)

    def textFromValue(self, value: float) -> str:
        """No more places than the number has."""
        return self.locale().toString(value, "g", 5)

    def show_value(self, value: float, unit: str) -> None:
        """Show a value and its unit; nothing is told."""
        if self.hasFocus() and self.isEnabled() and self.suffix() == f" {unit}":
            return  # a person is typing
        with QSignalBlocker(self):
            if self.suffix() != f" {unit}":
                self.setSuffix(f" {unit}")
            if self.value() != round(value, self.decimals()):
                self.setValue(value)
