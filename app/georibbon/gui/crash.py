"""When the program itself fails: what is told, the report to copy or save, and crashes of before.

A fault that Python catches is shown while the program goes on.  One that ends
the process is written by `faulthandler` into a file of its own, and the next
start tells of it.
"""

import datetime
import faulthandler
import os
import platform
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from PySide6.QtCore import QObject, Qt, QTimer, Signal, Slot
from PySide6.QtGui import QFontDatabase, QGuiApplication, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QStyle,
    QVBoxLayout,
    QWidget,
)

from georibbon import __version__
from georibbon.gui import dialogs
from georibbon.gui.language import tr
from georibbon.gui.log import Bell, plain_line
from georibbon.gui.notifier import Entry, Notifier

LIBRARIES = ("PySide6-Essentials", "pyqtgraph", "numpy", "scipy", "vtk", "pyserial")
MOST_FAULTS = 20  # in a report; of more it is told how many there were
LOG_LINES = 60  # in a report
LONGEST_CRASH = 100_000  # bytes of a crash's file that are read
TOGETHER_MS = 200  # faults that come in a row are shown together
_FATAL = b"Fatal Python error"
_PREFIX = "crash-"
TEXTS = "Text (*.txt)"


class HardCrashes:
    """The file into which this process's crash would be written, and those of processes before.

    previous: what earlier ones left behind, or None.  folder: where the files
    lie; one that cannot be written to stops nothing.
    """

    def __init__(self, folder: Path) -> None:
        self.previous = _left_behind(folder)
        self._path = folder / f"{_PREFIX}{os.getpid()}.txt"
        self._file: TextIO | None = None
        with suppress(OSError, ValueError):
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("w", encoding="utf-8")
            faulthandler.enable(self._file)

    def end(self) -> None:
        """The process ends as it should: nothing is left behind."""
        if self._file is not None:
            faulthandler.disable()
            self._file.close()
            self._file = None
            with suppress(OSError):
                self._path.unlink()


def _left_behind(folder: Path) -> str | None:
    """What crashed processes wrote; their files are removed, those of living ones stay."""
    texts = []
    with suppress(OSError, ValueError):
        for path in sorted(folder.glob(f"{_PREFIX}*.txt")):
            with suppress(OSError):
                with path.open("rb") as file:
                    data = file.read(LONGEST_CRASH)
                if _FATAL in data:
                    at = datetime.datetime.fromtimestamp(path.stat().st_mtime).astimezone()
                    texts.append(
                        f"{at.isoformat(timespec='seconds')}\n{data.decode(errors='replace')}"
                    )
                elif _lives(path.stem.removeprefix(_PREFIX)):
                    continue
                path.unlink()
    return "\n".join(texts) or None


def _lives(number: str) -> bool:
    """Whether a process of this number runs; where that cannot be asked, its open file says so."""
    if os.name != "posix" or not number.isdecimal():
        return False
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


class Faults:
    """The faults of this run, for the report: each with how often it came; a few are kept."""

    def __init__(self) -> None:
        self.entries: dict[str, tuple[Entry, int]] = {}
        self.count = 0

    def add(self, entry: Entry) -> None:
        """Take one in."""
        self.count += 1
        first, times = self.entries.get(entry.detail, (entry, 0))
        if times or len(self.entries) < MOST_FAULTS:
            self.entries[entry.detail] = (first, times + 1)

    def text(self) -> str:
        """All of them."""
        parts = []
        for entry, times in self.entries.values():
            often = f" ({times} times)" if times > 1 else ""
            parts.append(f"{plain_line(entry)}{often}")
        more = self.count - sum(times for _, times in self.entries.values())
        return "\n\n".join([*parts, *([f"and {more} more"] if more else [])])


def report(
    faults: str, log: Sequence[Entry], session: Path | None, previous: str | None = None
) -> str:
    """All that helps to find a fault, as text; nothing of what was measured."""
    lines = [
        f"Georibbon {__version__}",
        f"Python {platform.python_version()} on {platform.platform()}",
        f"window system: {QGuiApplication.platformName() or 'none'}",
        *(f"{name} {_version(name)}" for name in LIBRARIES),
        f"session: {session if session is not None else 'none'}",
        f"written: {datetime.datetime.now().astimezone().isoformat(timespec='seconds')}",
    ]
    parts = ["\n".join(lines)]
    if previous is not None:
        parts.append(f"== The crash before\n{previous.rstrip()}")
    if faults:
        parts.append(f"== Faults\n{faults}")
    told = "\n".join(plain_line(entry, detail=False) for entry in log[-LOG_LINES:])
    parts.append(f"== Log\n{told}")
    return "\n\n".join(parts) + "\n"


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return "is missing"


class CrashWindow(QDialog):
    """What happened in plain words, that nothing is lost, and the report.

    close_asked: a person wants to close the program.
    """

    close_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("A fault of the program"))
        self.what, self.safe, self.told = (QLabel() for _ in range(3))
        for label in (self.what, self.safe, self.told):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        font = self.what.font()
        font.setBold(True)
        self.what.setFont(font)
        self.details = QPlainTextEdit()
        self.details.setReadOnly(True)
        self.details.setAccessibleName(tr("Details"))
        self.details.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.details.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.copy_button = QPushButton(tr("&Copy"))
        self.copy_button.clicked.connect(self.copy)
        self.save_button = QPushButton(tr("&Save…"))
        self.save_button.clicked.connect(self.ask_save)
        self.go_on_button = QPushButton(tr("&Go on"))
        self.go_on_button.clicked.connect(self.accept)
        self.close_button = QPushButton(tr("C&lose the program"))
        self.close_button.clicked.connect(self._close_program)
        self._lay_out()

    def show_report(self, what: str, safe: str, details: str) -> None:
        """What happened, what of one's work is safe, and the report."""
        self.what.setText(what)
        self.safe.setText(safe)
        if details != self.details.toPlainText():
            self.details.setPlainText(details)

    def copy(self) -> None:
        """Put the report on the clipboard."""
        QGuiApplication.clipboard().setText(self.details.toPlainText())
        self.told.setText(tr("Copied."))

    def ask_save(self) -> None:
        """Write the report into a file that a person chooses."""
        target = dialogs.ask_target(
            self, Path.home() / "georibbon-report.txt", tr("Save the report"), TEXTS
        )
        if target is None:
            return
        try:
            target.write_text(self.details.toPlainText(), encoding="utf-8")
        except OSError as error:
            self.told.setText(tr("{path}: {why}", path=target, why=error.strerror or str(error)))
        else:
            self.told.setText(tr("Written: {path}", path=target))

    def _close_program(self) -> None:
        self.accept()
        self.close_asked.emit()

    def _lay_out(self) -> None:
        size = 2 * self.style().pixelMetric(QStyle.PixelMetric.PM_SmallIconSize)
        sign = QLabel()
        sign.setAccessibleName(tr("Fault"))
        found = self.style().standardIcon(QStyle.StandardPixmap.SP_MessageBoxWarning)
        sign.setPixmap(found.pixmap(size, size))
        words = QVBoxLayout()
        words.addWidget(self.what)
        words.addWidget(self.safe)
        head = QHBoxLayout()
        head.setSpacing(14)
        head.addWidget(sign, 0, Qt.AlignmentFlag.AlignTop)
        head.addLayout(words, 1)
        row = QHBoxLayout()
        row.addWidget(self.copy_button)
        row.addWidget(self.save_button)
        row.addWidget(self.told, 1)
        row.addWidget(self.close_button)
        row.addWidget(self.go_on_button)
        label = QLabel(tr("&Details for who looks into it"))
        label.setBuddy(self.details)
        whole = QVBoxLayout(self)
        whole.addLayout(head)
        whole.addWidget(label)
        whole.addWidget(self.details, 1)
        whole.addLayout(row)
        self.go_on_button.setDefault(True)
        for button in (self.copy_button, self.save_button, self.close_button):
            button.setAutoDefault(False)
        QShortcut(QKeySequence.StandardKey.Save, self, self.ask_save)
        self.resize(720, 460)


class CrashReporter(QObject):
    """Shows one window for all faults that nobody caught, on whatever thread they arose.

    where: gives the path of what is open, or None.  close_asked: a person
    wants to close the program.
    """

    close_asked = Signal()

    def __init__(
        self, notifier: Notifier, where: Callable[[], Path | None], parent: QWidget
    ) -> None:
        super().__init__(parent)
        self._notifier, self._where, self._parent = notifier, where, parent
        self._faults = Faults()
        self._previous: str | None = None
        self.window: CrashWindow | None = None
        self._bell = Bell(notifier, self)
        self._bell.rang.connect(self._heard)
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(TOGETHER_MS)
        self._soon.timeout.connect(self.show_report)

    def end(self) -> None:
        """Listen no more."""
        self._soon.stop()
        self._bell.end()
        if self.window is not None:
            self.window.close()

    def tell_of_before(self, previous: str | None) -> None:
        """Tell of a crash that ended the program before, where there was one."""
        if previous is None:
            return
        self._previous = previous
        self._notifier.tell(
            "warning",
            tr("the program ended by a crash when it ran last; what was captured is in its file"),
            previous,
        )
        self.show_report()

    @Slot()
    def show_report(self) -> None:
        """The window with the report as it is now."""
        if self.window is None:
            self.window = CrashWindow(self._parent)
            self.window.close_asked.connect(self.close_asked)
        self.window.show_report(self._what(), self._safe(), self._text())
        self.window.show()

    @Slot(object)
    def _heard(self, entry: Entry) -> None:
        if entry.level == "fault":
            self._faults.add(entry)
            if not self._soon.isActive():
                self._soon.start()

    def _what(self) -> str:
        if self._faults.count:
            return tr("Something went wrong in the program itself. It was not your doing.")
        if self._previous is not None:
            return tr("The program ended by a crash when it ran last.")
        return tr("No fault of the program has come up since the start.")

    def _safe(self) -> str:
        path = self._where()
        if path is None:
            safe = tr("No session is open. What was captured before is in its file, up to the end.")
        else:
            safe = tr("Nothing that was captured is lost: it lies in {path}.", path=path)
        if not self._faults.count:
            return safe
        return f"{safe} {tr('You may go on; if anything looks odd, close and start again.')}"

    def _text(self) -> str:
        return report(self._faults.text(), self._notifier.entries, self._where(), self._previous)


def crash_folder() -> Path:
    """Where crashes are written: the folder of the program's state."""
    from PySide6.QtCore import QStandardPaths

    kind = QStandardPaths.StandardLocation
    place = getattr(kind, "StateLocation", kind.AppLocalDataLocation)
    return Path(QStandardPaths.writableLocation(place))
