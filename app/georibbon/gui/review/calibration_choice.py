"""Which calibration the passes are reconstructed with: the poses' own, a kept one, or a file's."""

from pathlib import Path

from PySide6.QtCore import QLocale, QSignalBlocker
from PySide6.QtWidgets import QComboBox, QFileDialog, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from georibbon.gui.files import calibrations_folder
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts
from georibbon.gui.review.told import ToldLine
from georibbon.gui.review.worker import Worker

OWN, FILE, USED = "own", "file", "used"
MOST_LISTED = 30


class CalibrationChoice(QWidget):
    """A list to choose from, and below it what is used and how good it is."""

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self._kept = ()
        self._reader = Worker(self)
        self.choice = QComboBox()
        self.choice.setToolTip(
            tr("Reconstruct with another calibration than that of the poses in the session")
        )
        self.choice.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.choice.setMinimumContentsLength(16)
        self.words = QLabel(tr("Ca&libration"))
        self.words.setBuddy(self.choice)
        self.told = ToldLine()
        row = QHBoxLayout()
        row.addWidget(self.words)
        row.addWidget(self.choice, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(row)
        column.addWidget(self.told)
        self.choice.activated.connect(self._chosen)
        self._reader.done.connect(self._take)
        self._reader.failed.connect(self._refused)
        self._reader.fault.connect(parts.notifier.exception)
        document = parts.document
        document.changed.connect(self._changed)
        document.reconstructed.connect(self._show)
        self._changed("source")

    @classmethod
    def ask_file(cls, parent: QWidget, folder: Path) -> Path | None:
        """A calibration file that a person chooses."""
        filters = f"{tr('Calibrations')} (*.json)"
        found, _ = QFileDialog.getOpenFileName(
            parent, tr("Use another calibration"), str(folder), filters
        )
        return Path(found) if found else None

    @classmethod
    def kept_folder(cls) -> Path:
        """Where calibrations are kept."""
        return calibrations_folder()

    def ask(self) -> None:
        """Ask for a file, and use the calibration in it."""
        document = self._parts.document
        folder = self.kept_folder() if document.path is None else document.path.parent
        path = self.ask_file(self, folder)
        if path is None:
            self._show()
        else:
            self.use_file(path)

    def use_file(self, path: Path) -> None:
        """Use the calibration in a file."""

        def work() -> object:
            from georibbon.session.calibration_file import read_calibration

            return "calibration", read_calibration(path)

        self._reader.ask(work)

    def _changed(self, what: str) -> None:
        if what == "source":
            self._kept = ()
            self._look()
        self._show()

    def _look(self) -> None:
        """Read which ones are kept, beside the window."""
        if self._parts.document.path is None:
            return
        folder = self.kept_folder()

        def work() -> object:
            from georibbon.session.calibration_shelf import Shelf

            return "kept", Shelf(folder).look()[0][:MOST_LISTED]

        self._reader.ask(work)

    def _take(self, found: object) -> None:
        what, value = found
        if what == "kept":
            self._kept = tuple(value)
            self._show()
        else:
            self._parts.document.use_calibration(value)
            self._show()

    def _refused(self, sentence: str) -> None:
        self._show()
        self.told.tell(sentence, "poor")

    def _chosen(self, at: int) -> None:
        chosen, document = self.choice.itemData(at), self._parts.document
        if chosen == FILE:
            self.ask()
        elif chosen == OWN:
            document.use_calibration(None)
        elif chosen != USED:
            document.use_calibration(self._kept[chosen].calibration)

    # What is shown

    def _show(self) -> None:
        document = self._parts.document
        used, ribbon = document.calibration, self._ribbon()
        self.setEnabled(document.path is not None)
        with QSignalBlocker(self.choice):
            self.choice.clear()
            if document.has_poses:
                self.choice.addItem(tr("From the poses in the session"), OWN)
            if used is not None:
                self.choice.addItem(self._name(used), USED)
                self.choice.setCurrentIndex(self.choice.count() - 1)
            for k, kept in enumerate(self._kept):
                other = ribbon is not None and kept.calibration.ribbon_id != ribbon
                if not other and not _same(kept.calibration, used):
                    when = QLocale().toString(_day(kept.made), QLocale.FormatType.ShortFormat)
                    self.choice.addItem(f"{kept.name}, {when}", k)
            self.choice.addItem(tr("From a file…"), FILE)
        self._tell()

    def _ribbon(self) -> str | None:
        result = self._parts.document.reconstruction
        return None if result is None else result.ribbon.id

    def _name(self, used) -> str:
        kept = next((one for one in self._kept if _same(one.calibration, used)), None)
        return tr("Another one, kept in the session") if kept is None else kept.name

    def _tell(self) -> None:
        result = self._parts.document.reconstruction
        if result is None:
            self.told.tell("")
            return
        quality = result.calibration.quality
        if quality is None:
            self.told.tell(tr("It came without figures of its quality."))
            return
        self.told.tell(
            tr(
                "Of {poses} poses: tilt {tilt}°, heading {heading}° (1σ)",
                poses=quality.poses,
                tilt=f"{quality.tilt:.2f}",
                heading=f"{quality.heading:.2f}",
            )
        )


def _same(one, other) -> bool:
    """Whether two are the same calibration, be it read twice."""
    if one is None or other is None:
        return False
    if one.ribbon_id != other.ribbon_id or len(one.sensors) != len(other.sensors):
        return False
    return all(
        (a.gain == b.gain).all() and (a.bias == b.bias).all()
        for a, b in zip(one.sensors, other.sensors, strict=True)
        if a.used and b.used
    )


def _day(time: str):
    """The day of a UTC time, here."""
    import datetime

    return datetime.datetime.fromisoformat(time).astimezone().date()
