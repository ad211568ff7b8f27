"""Where calibrating begins: which ribbon, which plan, and what is kept already."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.expected import PLAN_ERRORS
from georibbon.gui.calibrating.kept_list import KeptList
from georibbon.gui.language import N_, tr
from georibbon.session.calibration_shelf import Shelf

PLAN_WORDS = {12: N_("the least"), 16: N_("good"), 20: N_("the plan")}
HEMISPHERES = {
    "": N_("not told"),
    "north": N_("north of the magnetic equator"),
    "south": N_("south of the magnetic equator"),
}


class StartView(QWidget):
    """What to do: a new calibration, one begun, the daily check, one that is kept.

    begin(poses): a new one by that plan.  go_on(): with the one begun last.
    connect_wanted(): no ribbon is there.  placed(hemisphere): "", north or south.
    """

    begin = Signal(int)
    go_on = Signal()
    connect_wanted = Signal()
    placed = Signal(str)

    def __init__(self, shelf: Shelf, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.ribbon = QLabel()
        self.ribbon.setWordWrap(True)
        self.connect_button = QPushButton(tr("C&onnect a ribbon…"))
        self.connect_button.clicked.connect(self.connect_wanted)
        self.plans = QButtonGroup(self)
        self.place = QComboBox()
        for key, words in HEMISPHERES.items():
            self.place.addItem(tr(words), key)
        self.place.setToolTip(
            tr("Magnetometers that are all mounted reversed show in nothing but the dip's sign")
        )
        self.place.activated.connect(lambda row: self.placed.emit(self.place.itemData(row)))
        self.where = QLabel()
        self.where.setWordWrap(True)
        self.where.setTextFormat(Qt.TextFormat.PlainText)
        self.where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.begin_button = QPushButton(tr("&New calibration"))
        self.begin_button.setDefault(True)
        self.go_on_button = QPushButton(tr("&Go on with the last one"))
        self.begin_button.clicked.connect(lambda: self.begin.emit(self.plans.checkedId()))
        self.go_on_button.clicked.connect(self.go_on)
        self.told = QLabel()
        self.told.setWordWrap(True)
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.told.setAccessibleName(tr("Why it cannot begin"))
        self.kept = KeptList(shelf)
        self._lay_out()

    def _lay_out(self) -> None:
        new = QGroupBox(tr("New calibration"))
        form = QVBoxLayout(new)
        form.addWidget(self.ribbon)
        form.addWidget(self.connect_button, 0, Qt.AlignmentFlag.AlignLeft)
        for poses, (tilt, heading) in PLAN_ERRORS.items():
            form.addWidget(self._plan(poses, tilt, heading))
        note = QLabel(
            tr(
                "Expected errors of a sensor in tilt and heading, for a usual ribbon of 32 sensors "
                "in a field 65° steep. A straighter bar is worth more than more poses."
            )
        )
        note.setWordWrap(True)
        form.addWidget(note)
        place = QFormLayout()
        place.addRow(tr("This &place lies"), self.place)
        form.addLayout(place)
        form.addWidget(self.where)
        row = QHBoxLayout()
        row.addWidget(self.begin_button)
        row.addWidget(self.go_on_button)
        row.addStretch()
        form.addLayout(row)
        form.addWidget(self.told)
        advice = QGroupBox(tr("Before you begin"))
        words = QVBoxLayout(advice)
        for text in (
            N_("Fix the ribbon straight on a straight, flat, square bar without any iron."),
            N_("Calibrate in the place where you will capture: indoors the field alone differs by "
               "2.4 to 4° of heading over a room."),
            N_("Keep steel, magnets, loudspeakers and cables with currents a metre away."),
            N_("Any order will do. Lay the bar as a picture shows and let go of it: it is taken "
               "after one second of rest, or press Space or Page Down."),
        ):  # fmt: skip
            label = QLabel("•  " + tr(text))
            label.setWordWrap(True)
            words.addWidget(label)
        words.addStretch()
        top = QHBoxLayout()
        top.addWidget(new, 1)
        top.addWidget(advice, 1)
        below = QGroupBox(tr("Calibrations that are kept"))
        box = QVBoxLayout(below)
        box.addWidget(self.kept)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(top)
        layout.addWidget(below, 1)

    def _plan(self, poses: int, tilt: float, heading: float) -> QRadioButton:
        button = QRadioButton(
            tr(
                "{poses} poses, {words}: tilt {tilt}°, heading {heading}°",
                poses=poses,
                words=tr(PLAN_WORDS[poses]),
                tilt=f"{tilt:.2f}",
                heading=f"{heading:.2f}",
            )
        )
        button.setChecked(poses == 20)
        self.plans.addButton(button, poses)
        return button

    def show_ribbon(self, ribbon) -> None:
        """Show which ribbon is connected; None: none is."""
        self.connect_button.setVisible(ribbon is None)
        self.begin_button.setEnabled(ribbon is not None)
        if ribbon is None:
            self.ribbon.setText(tr("No ribbon is connected."))
            return
        self.ribbon.setText(
            tr(
                "Ribbon {name}: {accelerometers} accelerometers, {magnetometers} magnetometers.",
                name=ribbon.id,
                accelerometers=len(ribbon.indices("accelerometer")),
                magnetometers=len(ribbon.indices("magnetometer")),
            )
        )

    def show_place(self, hemisphere: str) -> None:
        """Show what was told of the place."""
        self.place.setCurrentIndex(max(self.place.findData(hemisphere), 0))

    def show_where(self, folder, begun) -> None:
        """Show where calibrations are kept, and whether one was begun."""
        self.where.setText(tr("Everything is kept in {folder}", folder=folder))
        self.go_on_button.setVisible(begun is not None)
        if begun is not None:
            self.go_on_button.setToolTip(str(begun))
