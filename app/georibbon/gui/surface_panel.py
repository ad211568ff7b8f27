"""The surface's settings, and how the passes are fitted, in plain words; each can be taken back."""

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from georibbon.geometry.settings import (
    FACTOR_LIMITS,
    GREATEST_ANGLE,
    SurfaceSettings,
)
from georibbon.gui.document import EVERY_PASS
from georibbon.gui.language import N_, tr
from georibbon.gui.length_box import LengthBox
from georibbon.gui.parts import Parts

OWN = "own"  # the pair of factors that a person gives
Choices = Sequence[tuple[str, str, str]]  # the setting's word, what it is called, what it does
DIRECTIONS: Choices = (
    ("safe-chord", N_("to the neighbour, safely"), N_(
        "Lines across leave a pass towards the neighbour's point, kept from turning back"
    )),
    ("chord", N_("to the neighbour"), N_(
        "Lines across leave a pass along the chord to the neighbour, brought into the surface"
    )),
    ("conormal", N_("square to the pass"), N_("Lines across leave a pass at a right angle")),
    ("section", N_("in a plane section"), N_(
        "Lines across leave a pass in the plane of the chord and the mean normal"
    )),
    ("angles", N_("at my angles"), N_("Lines across leave a pass at the angles given below")),
)  # fmt: skip
LENGTHS: Choices = (
    ("arc", N_("circular arc"), N_("Exact on spheres and cylinders; a good choice everywhere")),
    ("unit", N_("as long as the chord"), N_("Flatter between the passes than an arc")),
    ("criterion1", N_("even speed (criterion 1)"), N_("Lines across run at an even speed")),
    ("criterion2", N_("even curvature (criterion 2)"), N_(
        "The curvature of the lines across changes in size as little as it can"
    )),
    ("criterion2-vector", N_("even curvature, with its direction"), N_(
        "The curvature of the lines across changes in size and direction as little as it can"
    )),
    ("criterion3", N_("least torsion (criterion 3)"), N_(
        "The lines across twist as little as they can"
    )),
    ("criterion4", N_("least torsion, free direction (criterion 4)"), N_(
        "The directions are chosen too, so that the lines across twist least"
    )),
    ("bending", N_("least bending energy"), N_("The lines across hold the least bending energy")),
    ("curvature-variation", N_("most even curvature, at any scale"), N_(
        "The curvature changes as little as it can along the lines across, whatever their size"
    )),
    (OWN, N_("my factors"), N_("The factors of the chord given below, at either pass")),
)  # fmt: skip
CORRESPONDENCES: Choices = (
    ("foot-cover", N_("feet, to the ends of both"), N_(
        "Points square across from each other; the ends of both passes are covered"
    )),
    ("foot-trim", N_("feet, where both overlap"), N_(
        "Points square across from each other; what has no partner is cut off"
    )),
    ("arc-length", N_("equal lengths from the beginning"), N_(
        "Points at the same length from the beginning of their passes"
    )),
    ("fraction", N_("equal fractions"), N_("Points at the same fraction of their passes' lengths")),
)  # fmt: skip
INTERIORS: Choices = (
    ("g1", N_("smooth (G1)"), N_("The tangent planes on both sides of a pass agree")),
    ("c1-lines", N_("lines run on smoothly (C1)"), N_(
        "Lines across run over inner passes without a kink; their directions are chosen for it"
    )),
    ("g2", N_("equal curvature (G2)"), N_(
        "The curvature on both sides of a pass agrees: for zebra stripes without kinks"
    )),
)  # fmt: skip
METHODS: Choices = (
    ("ribbon", N_("to the readings (ribbon)"), N_(
        "All readings of a pass are fitted at once, with the survey: the more exact way"
    )),
    ("paper", N_("from tangents (paper)"), N_(
        "Tangents are interpolated from sensor to sensor, then placed by the survey"
    )),
)  # fmt: skip
TANGENTS: Choices = (
    ("unrolled", N_("unrolled from the sphere"), N_(
        "A cubic spline in the plane onto which the sphere of directions is rolled"
    )),
    ("averages", N_("averages on the sphere"), N_(
        "Weighted averages of directions, as Buss and Fillmore define them"
    )),
    ("components", N_("by components"), N_(
        "A cubic spline of each component of the tangents, made unit again"
    )),
)  # fmt: skip
THINNEST, THICKEST = 1e-4, 0.1  # metres
FINEST, COARSEST = 1e-5, 0.01
USUAL_THICKNESS = 0.002
LEAST_TIES = 2  # to close a cell


class SurfacePanel(QWidget):
    """All that can be chosen of the surface; what changes it is undone by its name."""

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._document, self._units = parts.document, parts.units
        self._asked = False
        self.direction = self._choice("surface.direction", DIRECTIONS)
        self.lengths = self._choice("surface.lengths", LENGTHS)
        self.correspondence = self._choice("surface.correspondence", CORRESPONDENCES)
        self.interior = self._choice("surface.interior", INTERIORS)
        self.method = self._choice("method", METHODS)
        self.tangents = self._choice("tangents", TANGENTS)
        self.angles = [self._angle() for _ in range(4)]
        self.factors = [self._factor() for _ in range(2)]
        self.neighbours = QCheckBox(tr("Neighbours &correct each other"))
        self.cells = QCheckBox(tr("F&ollow ties where they close cells"))
        self.tolerance = LengthBox(self._units, FINEST, COARSEST, 1e-5)
        self.solid = QCheckBox(tr("Closed &solid"))
        self.thickness = LengthBox(self._units, THINNEST, THICKEST, 5e-4)
        self.reset = QPushButton(tr("&Reset the surface"))
        self.failure = QLabel()
        self.advice = QLabel(
            tr(
                "Where passes are shifted along each other these lines may fold at the ends: "
                "“feet, where both overlap” keeps them flat."
            )
        )
        self._tell()
        self._lay_out()
        self._connect()
        self._show()

    def _choice(self, key: str, choices: Choices) -> QComboBox:
        box = QComboBox()
        for word, name, what in choices:
            box.addItem(tr(name), word)
            box.setItemData(box.count() - 1, tr(what), Qt.ItemDataRole.ToolTipRole)
        box.setMinimumContentsLength(14)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        box.activated.connect(lambda _: self._chosen(key, box.currentData()))
        return box

    def _angle(self) -> QDoubleSpinBox:
        box = QDoubleSpinBox()
        box.setRange(-GREATEST_ANGLE, GREATEST_ANGLE)
        box.setDecimals(1)
        box.setSuffix("°")
        box.setKeyboardTracking(False)
        box.valueChanged.connect(lambda _: self._turned())
        return box

    def _factor(self) -> QDoubleSpinBox:
        box = QDoubleSpinBox()
        box.setRange(*FACTOR_LIMITS)
        box.setDecimals(2)
        box.setSingleStep(0.05)
        box.setPrefix("× ")
        box.setKeyboardTracking(False)
        box.valueChanged.connect(lambda _: self._stretched())
        return box

    def _tell(self) -> None:
        """What each does, for those who ask, and names for those who cannot see."""
        self.neighbours.setToolTip(
            tr("On a smooth surface the chord between passes is square to their mean normal")
        )
        self.tolerance.setToolTip(tr("How far the triangles may be from the surface"))
        self.solid.setToolTip(tr("Thicken the surface inwards, for printing"))
        self.thickness.setAccessibleName(tr("Thickness of the solid"))
        self.thickness.setToolTip(self.solid.toolTip())
        self.reset.setToolTip(tr("All of the surface's settings as they were at first"))
        for box, name in zip(
            self.angles,
            (
                tr("Angle at the first pass, at its beginning"),
                tr("Angle at the first pass, at its end"),
                tr("Angle at the second pass, at its beginning"),
                tr("Angle at the second pass, at its end"),
            ),
            strict=True,
        ):
            box.setAccessibleName(name)
            box.setToolTip(name)
        for box, name in zip(
            self.factors,
            (
                tr("Length at the first pass, times the chord"),
                tr("Length at the second pass, times the chord"),
            ),
            strict=True,
        ):
            box.setAccessibleName(name)
            box.setToolTip(name)

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        self._angles_row, self._factors_row = _row(*self.angles), _row(*self.factors)
        form.addRow(tr("&Direction across"), self.direction)
        form.addRow(tr("Angles"), self._angles_row)
        form.addRow(tr("Tangent &lengths"), self.lengths)
        form.addRow(tr("Factors"), self._factors_row)
        form.addRow(tr("Across from &what"), self.correspondence)
        form.addRow(tr("Over &inner passes"), self.interior)
        form.addRow("", self.cells)
        form.addRow(self.advice)
        form.addRow(tr("&Tolerance"), self.tolerance)
        form.addRow(self.solid, self.thickness)
        form.addRow(_line())
        form.addRow(tr("Passes are &fitted"), self.method)
        form.addRow(tr("Ta&ngents between sensors"), self.tangents)
        form.addRow("", self.neighbours)
        self._form = form
        self.advice.setWordWrap(True)
        self.failure.setWordWrap(True)
        self.failure.setTextFormat(Qt.TextFormat.PlainText)
        self.failure.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.failure.setAccessibleName(tr("Why the surface cannot be made"))
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.addLayout(form)
        column.addWidget(self.failure)
        column.addWidget(self.reset, 0, Qt.AlignmentFlag.AlignRight)
        column.addStretch(1)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidget(inside)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(area)

    def _connect(self) -> None:
        self.neighbours.clicked.connect(lambda on: self._chosen("neighbours", on))
        self.cells.clicked.connect(lambda on: self._chosen("surface.cells", on))
        self.tolerance.edited.connect(lambda metres: self._chosen("surface.tolerance", metres))
        self.solid.clicked.connect(lambda _: self._thickened())
        self.thickness.edited.connect(lambda _: self._thickened())
        self.reset.clicked.connect(self._reset)
        self._document.changed.connect(lambda _: self._show())
        self._document.reconstructed.connect(lambda _: self._done())
        self._document.failed.connect(self._failed)

    # What a person asks for

    def _chosen(self, key: str, value: object) -> None:
        """Keep a choice; what is usual is no choice."""
        if key == "surface.lengths" and value == OWN:
            value = [box.value() for box in self.factors]
        self._asked = True
        usual = value == _usual(key)
        self._document.set_setting(EVERY_PASS, key, None if usual else value)

    def _turned(self) -> None:
        self._chosen("surface.angles", [box.value() for box in self.angles])

    def _stretched(self) -> None:
        self._chosen("surface.lengths", OWN)

    def _thickened(self) -> None:
        on = self.solid.isChecked()
        self._chosen("surface.thickness", self.thickness.metres if on else None)

    def _reset(self) -> None:
        self._asked = True
        self._document.reset_settings(
            {key for _, key in self._document.values if key.startswith("surface.")}, EVERY_PASS
        )

    # What the document tells

    def _show(self) -> None:
        """What is chosen now."""
        document = self._document
        self.setEnabled(document.path is not None)
        if document.path is None:
            surface, neighbours, method, tangents = SurfaceSettings(), True, "ribbon", "unrolled"
        else:
            settings = document.settings
            surface = settings.surface or SurfaceSettings()
            neighbours, method = settings.neighbours, settings.method
            tangents = settings.tangents
        own = not isinstance(surface.lengths, str)
        for box, word in (
            (self.direction, surface.direction),
            (self.lengths, OWN if own else surface.lengths),
            (self.correspondence, surface.correspondence),
            (self.interior, surface.interior),
            (self.method, method),
            (self.tangents, tangents),
        ):
            box.setCurrentIndex(box.findData(word))
            box.setToolTip(box.currentData(Qt.ItemDataRole.ToolTipRole))
        _put(self.angles, surface.angles)
        if own:
            _put(self.factors, surface.lengths)
        self._show_what_counts(surface, own, method)
        for check, on in (
            (self.neighbours, neighbours),
            (self.cells, surface.cells),
            (self.solid, surface.thickness is not None),
        ):
            with QSignalBlocker(check):
                check.setChecked(on)
        self.tolerance.set_metres(surface.tolerance)
        self.thickness.set_metres(surface.thickness or USUAL_THICKNESS)
        chosen = any(key.startswith("surface.") for _, key in document.values)
        self.reset.setEnabled(chosen)

    def _show_what_counts(self, surface: SurfaceSettings, own: bool, method: str) -> None:
        """Choices that another one takes the place of cannot be made."""
        self._form.setRowVisible(self._angles_row, surface.direction == "angles")
        self._form.setRowVisible(self._factors_row, own)
        may_fold = surface.interior == "c1-lines" or (
            surface.uses_direction and surface.direction == "conormal"
        )
        covers = surface.correspondence == "foot-cover"
        self._form.setRowVisible(self.advice, may_fold and covers)
        self.direction.setEnabled(surface.uses_direction)
        self._angles_row.setEnabled(surface.uses_direction)
        self.lengths.setEnabled(surface.uses_lengths)
        self._factors_row.setEnabled(surface.uses_lengths)
        self.neighbours.setEnabled(method == "ribbon")
        self._form.setRowVisible(self.tangents, method == "paper")
        self._show_cells(surface)
        taken = tr("Chosen by another setting: lines over inner passes, or the lengths")
        if not surface.uses_direction:
            self.direction.setToolTip(taken)
        if not surface.uses_lengths:
            self.lengths.setToolTip(taken)

    def _show_cells(self, surface: SurfaceSettings) -> None:
        """Cells can be asked for where there are ties to close them, and taken back anywhere."""
        ties = sum(one.kind == "tie" for one in self._document.passes)
        able = ties >= LEAST_TIES and surface.uses_cells
        self.cells.setEnabled(able or surface.cells)
        if ties < LEAST_TIES:
            what = tr("Two ties at least, laid across the passes, close cells with them")
        elif not surface.uses_cells:
            what = tr("Only where the surface over inner passes is smooth (G1)")
        else:
            what = tr(
                "Coons patches: between two ties the surface runs through the ties too, with the "
                "normals measured there"
            )
        self.cells.setToolTip(what)

    def _done(self) -> None:
        self._asked = False
        self.failure.clear()

    def _failed(self, sentence: str) -> None:
        if self._asked:
            self.failure.setText(sentence)
            self._show()


def _usual(key: str) -> object:
    """What is chosen where nothing is."""
    if key.startswith("surface."):
        value = getattr(SurfaceSettings(), key.removeprefix("surface."))
        return list(value) if isinstance(value, tuple) else value
    return {"method": "ribbon", "neighbours": True, "tangents": "unrolled"}[key]


def _put(boxes: Sequence[QDoubleSpinBox], values: Sequence[float]) -> None:
    for box, value in zip(boxes, values, strict=True):
        with QSignalBlocker(box):
            box.setValue(value)


def _row(*boxes: QWidget) -> QWidget:
    row = QWidget()
    line = QHBoxLayout(row)
    line.setContentsMargins(0, 0, 0, 0)
    for box in boxes:
        line.addWidget(box, 1)
    return row


def _line() -> QFrame:
    line = QFrame()
    line.setFrameShape(QFrame.Shape.HLine)
    return line
