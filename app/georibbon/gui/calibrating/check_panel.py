"""What the daily check found: the verdict in words and figures, and which sensors are off."""

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.check import DIP_WITHIN, GOOD, NORM_WITHIN, USABLE, Check
from georibbon.gui.calibrating.live import Sign
from georibbon.gui.calibrating.quality import Figure
from georibbon.gui.calibrating.state import grade
from georibbon.gui.calibrating.words import VERDICTS, told_words
from georibbon.gui.language import N_, tr

ROWS = {
    "worst": N_("Worst sensor"),
    "tilt": N_("Accelerometers, rms"),
    "heading": N_("Heading, rms"),
    "norm": N_("Strength of the field"),
    "dip": N_("Dip of the field"),
}
GRADE_SIGNS = {"good": "good", "fair": "poor", "poor": "bad"}
MOST_SHOWN = 8


class CheckPanel(QWidget):
    """The verdict of a daily check."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.sign, self.verdict, self.reason, self.told = Sign(), QLabel(), QLabel(), QLabel()
        font = self.verdict.font()
        font.setPointSizeF(1.5 * font.pointSizeF())
        font.setBold(True)
        self.verdict.setFont(font)
        self.verdict.setAccessibleName(tr("Verdict"))
        for label in (self.reason, self.told):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        grid = QGridLayout()
        grid.setColumnStretch(2, 1)
        self.figures = {
            key: Figure(grid, row, tr(name)) for row, (key, name) in enumerate(ROWS.items())
        }
        self.table = QTableWidget(0, 3)
        self.table.setHorizontalHeaderLabels([tr("Sensor"), tr("Off by"), tr("As if")])
        self.table.setAccessibleName(tr("The sensors that are off most"))
        self.table.verticalHeader().hide()
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setTabKeyNavigation(False)
        self.table.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.Stretch)
        top = QHBoxLayout()
        top.addWidget(self.sign)
        top.addWidget(self.verdict, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(top)
        layout.addWidget(self.reason)
        layout.addLayout(grid)
        layout.addWidget(self.told)
        layout.addWidget(self.table, 1)
        self.show_nothing(3, "")

    def show_nothing(self, left: int, reason: str) -> None:
        """No verdict yet."""
        self.sign.show_state("open")
        self.verdict.setText(tr("No verdict yet"))
        self.reason.setText(reason or tr("The verdict comes with the third pose."))
        for figure in self.figures.values():
            figure.show("–", "open")
        self.told.clear()
        self.table.setRowCount(0)
        self.table.setVisible(False)

    def show_check(self, check: Check, findings: Sequence[str]) -> None:
        """Show a verdict, its figures, what was found, and the sensors that are off most."""
        self.sign.show_state(check.verdict)
        self.verdict.setText(tr(VERDICTS[check.verdict]).capitalize())
        self.reason.setText(told_words(check.reason))
        self._figure("worst", check.degrees, (GOOD, USABLE))
        self._figure("tilt", check.tilt, (GOOD, USABLE))
        self._figure("heading", check.heading, (1.0, 2.0))
        off = abs(check.norm - 1.0)
        words = tr(
            "{percent} % of the calibration's (within {most} %)",
            percent=f"{100.0 * check.norm:.1f}",
            most=f"{100.0 * NORM_WITHIN:g}",
        )
        self.figures["norm"].show(words, "good" if off <= NORM_WITHIN else "bad")
        words = tr(
            "{dip}°, {change}° from the calibration's (within {most}°)",
            dip=f"{check.dip:.1f}",
            change=f"{round(check.dip_change, 1) + 0.0:+.1f}",
            most=f"{DIP_WITHIN:g}",
        )
        self.figures["dip"].show(words, "good" if abs(check.dip_change) <= DIP_WITHIN else "bad")
        self.told.setText("\n".join(findings))
        self._fill(check)

    def _figure(self, key: str, value: float, grades) -> None:
        words = tr("{value}°", value=f"{value:.2f}")
        self.figures[key].show(words, GRADE_SIGNS[grade(value, grades)])

    def _fill(self, check: Check) -> None:
        known = [one for one in check.sensors if one.degrees == one.degrees]
        worst = sorted(known, key=lambda one: -one.degrees)[:MOST_SHOWN]
        self.table.setVisible(True)
        self.table.setRowCount(len(worst))
        for row, one in enumerate(worst):
            if one.turned == one.turned:
                cause = tr("turned by {degrees}°", degrees=f"{one.turned:.2f}")
            elif one.kind == "accelerometer":
                cause = tr("bias changed by {bias} mg", bias=f"{one.shifted:.1f}")
            else:
                cause = tr("hard iron changed by {iron} % of the field", iron=f"{one.shifted:.1f}")
            degrees = tr("{value}°", value=f"{one.degrees:.2f}")
            for column, text in enumerate((one.name, degrees, cause)):
                self.table.setItem(row, column, QTableWidgetItem(text))
