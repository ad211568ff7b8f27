"""What the virtual ribbon shall be: on which object, with what wrong with it."""

from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QWidget,
)

from georibbon.gui.connect.choice import BOUNDS, VirtualChoice
from georibbon.gui.language import N_, tr

# The surfaces of the simulation, by their names there.
OBJECTS = {
    "bonnet": N_("car bonnet"),
    "hull": N_("boat's hull, keel up"),
    "seat": N_("moulded seat"),
    "dome": N_("dome"),
    "sphere": N_("ball"),
    "ellipsoid": N_("ellipsoid"),
    "saddle": N_("saddle"),
    "torus": N_("ring"),
    "cone": N_("cone"),
    "cylinder": N_("pipe"),
    "elbow": N_("pipe's elbow"),
    "wall": N_("curved wall"),
    "plane": N_("flat plate"),
    "spline": N_("panel with relief"),
}
MESH = "mesh"
PACES = {1.0: N_("as a hand is"), 0.3: N_("quick"), 0.0: N_("there at once")}
MESHES = N_("Meshes (*.stl *.obj *.ply)")


def ask_mesh(parent: QWidget, folder: str) -> str:
    """A mesh file that is there; empty where a person thought better."""
    return QFileDialog.getOpenFileName(parent, tr("The object's mesh"), folder, tr(MESHES))[0]


class VirtualForm(QWidget):
    """The virtual ribbon's choices.  changed(): a person changed one."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.object = QComboBox()
        for name, text in OBJECTS.items():
            self.object.addItem(tr(text), name)
        self.object.addItem(tr("mesh file…"), MESH)
        self.mesh = QLineEdit()
        self.mesh.setPlaceholderText(tr("an STL, OBJ or PLY file"))
        self.browse = QPushButton(tr("Bro&wse…"))
        self.unit = QComboBox()
        self.unit.addItems(["mm", "m"])
        self.unit.setToolTip(tr("The unit of the file's coordinates, which a mesh does not tell"))
        self.passes, self.ties = _whole("passes"), _whole("ties")
        self.noise = _number("noise", 0.5, 1, " ×")
        self.noise.setToolTip(tr("How many times the sensors' own noise"))
        self.drop = _number("drop", 1.0, 1, " %", 100.0)
        self.drop.setToolTip(tr("Share of the frames that are lost on the cable"))
        self.pace = QComboBox()
        for pace, text in PACES.items():
            self.pace.addItem(tr(text), pace)
        self.way = QComboBox()
        self.way.addItem(tr("a pseudo-terminal"), False)
        self.way.addItem(tr("a socket of this computer"), True)
        self._lay_out()
        self._connect()
        self.show_choice(VirtualChoice())

    def choice(self) -> VirtualChoice:
        """What is chosen."""
        mesh = self.object.currentData() == MESH
        return VirtualChoice(
            surface=VirtualChoice.surface if mesh else self.object.currentData(),
            mesh=self.mesh.text().strip() if mesh else "",
            unit=self.unit.currentText(),
            passes=self.passes.value(),
            ties=self.ties.value(),
            noise=self.noise.value(),
            drop=self.drop.value() / 100.0,
            pace=self.pace.currentData(),
            socket=self.way.currentData(),
        )

    @property
    def missing(self) -> str:
        """What has to be chosen before it can be connected to; empty where nothing has."""
        chosen = self.object.currentData() != MESH or self.mesh.text().strip()
        return "" if chosen else tr("Choose the mesh file first.")

    def show_choice(self, choice: VirtualChoice) -> None:
        """Show what was chosen before."""
        with QSignalBlocker(self):
            _choose(self.object, MESH if choice.mesh else choice.surface)
            self.mesh.setText(choice.mesh)
            self.unit.setCurrentText(choice.unit)
            self.passes.setValue(choice.passes)
            self.ties.setValue(choice.ties)
            self.noise.setValue(choice.noise)
            self.drop.setValue(100.0 * choice.drop)
            _choose(self.pace, choice.pace)
            _choose(self.way, choice.socket)
        self._show_mesh()

    # --- inside ---

    def _lay_out(self) -> None:
        form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("O&bject"), self.object)
        self._file = QWidget()
        file = QHBoxLayout(self._file)
        file.setContentsMargins(0, 0, 0, 0)
        file.addWidget(self.mesh, 1)
        file.addWidget(self.unit)
        file.addWidget(self.browse)
        form.addRow(tr("&Mesh file"), self._file)
        form.labelForField(self._file).setBuddy(self.mesh)
        form.addRow(tr("P&asses"), self.passes)
        form.addRow(tr("&Ties"), self.ties)
        form.addRow(tr("No&ise"), self.noise)
        form.addRow(tr("&Lost frames"), self.drop)
        form.addRow(tr("&Kind of hands"), self.pace)
        form.addRow(tr("Throu&gh"), self.way)
        told = QLabel(
            tr("It is started inside the program and reached through a real port, as any ribbon.")
        )
        told.setWordWrap(True)
        form.addRow(told)
        self._form = form
        for box, name in (
            (self.mesh, tr("Mesh file")),
            (self.unit, tr("Unit of the mesh")),
            (self.browse, tr("Browse for the mesh")),
        ):
            box.setAccessibleName(name)

    def _connect(self) -> None:
        for box in (self.object, self.unit, self.pace, self.way):
            box.currentIndexChanged.connect(self._edited)
        for box in (self.passes, self.ties, self.noise, self.drop):
            box.valueChanged.connect(self._edited)
        self.mesh.textChanged.connect(self._edited)
        self.browse.clicked.connect(self._browse)

    def _edited(self, *_: object) -> None:
        self._show_mesh()
        self.changed.emit()

    def _show_mesh(self) -> None:
        self._form.setRowVisible(self._file, self.object.currentData() == MESH)

    def _browse(self) -> None:
        path = ask_mesh(self, str(Path(self.mesh.text()).parent) if self.mesh.text() else "")
        if path:
            self.mesh.setText(path)


def _whole(name: str) -> QSpinBox:
    box = QSpinBox()
    box.setRange(*BOUNDS[name])
    return box


def _number(
    name: str, step: float, decimals: int, suffix: str, scale: float = 1.0
) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    low, high = BOUNDS[name]
    box.setRange(low * scale, high * scale)
    box.setSingleStep(step)
    box.setDecimals(decimals)
    box.setSuffix(suffix)
    return box


def _choose(box: QComboBox, data: object) -> None:
    """Choose the entry with this data; the first where there is none."""
    box.setCurrentIndex(max(box.findData(data), 0))
