"""How good the calibration is by now: figures that turn green, and which sensors are suspect."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QProgressBar,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.directions import Covered
from georibbon.calibration.expected import Expected
from georibbon.calibration.gates import LEAST_POSES
from georibbon.gui.calibrating.live import Sign
from georibbon.gui.calibrating.signs import colour_of
from georibbon.gui.calibrating.state import (
    GAUGE_GRADES,
    HEADING_GRADES,
    TILT_GRADES,
    grade,
    suspects,
)
from georibbon.gui.language import N_, tr, trn
from georibbon.gui.theme import colours_of

ROWS = {
    "tilt": N_("Tilt of a sensor"),
    "heading": N_("Heading of a sensor"),
    "gauge": N_("Common to all sensors"),
    "covered": N_("Directions covered"),
}
GRADE_SIGNS = {"good": "good", "fair": "poor", "poor": "bad"}


class Figure:
    """One figure with its sign; green where it is good."""

    def __init__(self, grid: QGridLayout, row: int, name: str) -> None:
        self.sign, self.value = Sign(), QLabel()
        label = QLabel(name)
        self.value.setAccessibleName(name)
        self.value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        grid.addWidget(self.sign, row, 0)
        grid.addWidget(label, row, 1)
        grid.addWidget(self.value, row, 2)

    def show(self, words: str, state: str) -> None:
        """Show words with a sign."""
        self.value.setText(words)
        self.sign.show_state(state)
        colours = colours_of(self.value.palette())
        colour = colours.words if state == "open" else colour_of(state, colours)
        self.value.setStyleSheet(f"color: {colour}")


class QualityPanel(QWidget):
    """The figures of a calibration that goes on."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.progress = QProgressBar()
        self.progress.setAccessibleName(tr("Poses taken"))
        self.progress.setTextVisible(False)
        self.count = QLabel()
        self.told = QLabel()
        self.told.setWordWrap(True)
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.told.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.told.setAccessibleName(tr("What is noticed"))
        self.told.setAlignment(Qt.AlignmentFlag.AlignTop)
        grid = QGridLayout()
        grid.setColumnStretch(2, 1)
        self.figures = {
            key: Figure(grid, row, tr(name)) for row, (key, name) in enumerate(ROWS.items())
        }
        scroll = QScrollArea()
        scroll.setWidget(self.told)
        scroll.setWidgetResizable(True)
        scroll.viewport().setAutoFillBackground(False)
        self.told.setAutoFillBackground(False)
        scroll.setFrameShape(QScrollArea.Shape.NoFrame)
        scroll.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        scroll.setAccessibleName(tr("What is noticed"))
        scroll.setMinimumHeight(2 * self.fontMetrics().lineSpacing())
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.count)
        layout.addWidget(self.progress)
        layout.addLayout(grid)
        layout.addWidget(scroll, 1)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.show_nothing()

    def show_progress(self, taken: int, poses: int, finished: bool) -> None:
        """So many poses are taken; the last step is the calibration itself."""
        self.progress.setRange(0, poses + 1)
        self.progress.setValue(poses + 1 if finished else min(taken, poses))
        self.count.setText(tr("{taken} of {poses} poses taken", taken=taken, poses=poses))

    def show_covered(self, found: Covered) -> None:
        """Show how well the directions are covered."""
        words = tr(
            "{figure} (good: {good})", figure=f"{found.figure:.2f}", good=f"{found.goal:.2f}"
        )
        state = GRADE_SIGNS[found.grade] if any(found.taken) else "open"
        self.figures["covered"].show(words, state)

    def show_nothing(self, taken: int = 0, reason: str = "") -> None:
        """No calibration can be made yet, for a reason or for want of poses."""
        for key in ("tilt", "heading", "gauge"):
            self.figures[key].show("–", "open")
        left = LEAST_POSES - taken
        if left > 0:
            reason = trn(
                "Figures come with the 10th pose: {n} more.",
                "Figures come with the 10th pose: {n} more.",
                left,
            )
        self.told.setText(reason)

    def show_quality(self, calibration, expected: Expected, notices: list[str]) -> None:
        """Show a calibration's expected errors, with what they are known to."""
        for key, value, sigma, grades in (
            ("tilt", expected.tilt, expected.tilt_sigma, TILT_GRADES),
            ("heading", expected.heading, expected.heading_sigma, HEADING_GRADES),
        ):
            words = tr("{value}° ± {sigma}°", value=f"{value:.2f}", sigma=f"{sigma:.2f}")
            self.figures[key].show(words, GRADE_SIGNS[grade(value, grades)])
        gauge = calibration.quality.gauge
        words = tr("{value}°", value=f"{gauge:.2f}")
        self.figures["gauge"].show(words, GRADE_SIGNS[grade(gauge, GAUGE_GRADES)])
        names = list(suspects(calibration))
        lines = [tr("Suspect sensors: {names}", names=", ".join(names))] if names else []
        self.told.setText("\n".join([*lines, *notices]) or tr("All sensors and poses agree."))
