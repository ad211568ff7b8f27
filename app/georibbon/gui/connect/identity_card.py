"""What the connected ribbon says of itself."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from georibbon.device.identity import Identity
from georibbon.gui.connect.words import identity_rows
from georibbon.gui.language import tr
from georibbon.gui.units import Units

COLUMNS = 2  # pairs of a name and a value in a row


class IdentityCard(QWidget):
    """Name, firmware, rate, length and sensors; one sentence where none is connected."""

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._identity: Identity | None = None
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(14)
        self.labels: dict[str, QLabel] = {}
        units.changed.connect(self._show)
        self.show_identity(None)

    def show_identity(self, identity: Identity | None) -> None:
        """Show a ribbon, or that there is none."""
        self._identity = identity
        self._show()

    def forget(self) -> None:
        """Show that there is none."""
        self.show_identity(None)

    def _show(self) -> None:
        identity = self._identity
        while (item := self._grid.takeAt(0)) is not None:
            item.widget().deleteLater()
        self.labels = {}
        if identity is None:
            self._grid.addWidget(QLabel(tr("No ribbon is connected.")), 0, 0)
            return
        for k, (name, value) in enumerate(identity_rows(identity, self._units)):
            row, column = k // COLUMNS, 2 * (k % COLUMNS)
            told = QLabel(value)
            told.setTextFormat(Qt.TextFormat.PlainText)  # it comes from outside
            told.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            told.setAccessibleName(name)
            self._grid.addWidget(QLabel(name), row, column)
            self._grid.addWidget(told, row, column + 1)
            self._grid.setColumnStretch(column + 1, 1)
            self.labels[name] = told
