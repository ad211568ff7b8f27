"""The notices: whatever was ignored or assumed, and every check that the surface does not pass."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from georibbon.gui.language import sentence, tr


class NoticesPanel(QWidget):
    """A list of sentences."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.list = QListWidget()
        self.list.setWordWrap(True)
        self.list.setAlternatingRowColors(True)
        self.list.setAccessibleName(tr("Notices"))
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.list)

    def show_result(self, result) -> None:
        """The notices of a result, or none."""
        lines = [] if result is None else _lines(result)
        if lines == [self.list.item(i).text() for i in range(self.list.count())]:
            return  # a slider moves: the list stays where it is
        self.list.clear()
        for line in lines:
            self.list.addItem(QListWidgetItem(line))


def _lines(result) -> list[str]:
    from georibbon.export.summary import all_notices

    lines = []
    for one in all_notices(result):
        about = ", ".join(filter(None, (one.pass_name, one.sensor)))
        lines.append(_about(about, one.message))
    checks = () if result.surface is None else result.surface.checks
    lines += [_about(one.where, one.message) for one in checks if one.verdict != "pass"]
    return lines or [tr("Nothing was ignored or assumed, and the surface passes all checks.")]


def _about(what: str, message: str) -> str:
    said = sentence(message)
    return tr("{what}: {said}", what=sentence(what), said=said) if what else said
