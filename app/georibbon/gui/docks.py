"""The panels around the page of what is open, and which of them are seen."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QVBoxLayout, QWidget

from georibbon.gui.language import N_, tr

BESIDE, BELOW = Qt.DockWidgetArea.RightDockWidgetArea, Qt.DockWidgetArea.BottomDockWidgetArea
# Name in the kept layout, title, area; those of one area are tabs but for the first's own place.
_TITLES = {
    "passes": (N_("Passes"), BESIDE),
    "surface": (N_("Surface"), BESIDE),
    "view": (N_("View"), BESIDE),
    "notices": (N_("Notices"), BESIDE),
    "history": (N_("History"), BESIDE),
    "curves": (N_("Curves"), BELOW),
    "checks": (N_("Checks"), BELOW),
    "log": (N_("Log"), BELOW),
}
# Those that share a place, the one that is seen at first first.
_TABS = (("passes", "surface", "view", "history"), ("notices",), ("curves", "checks", "log"))


class Docks:
    """The docks of a window by their names; which are hidden a person decides."""

    def __init__(self, window: QMainWindow, panels: dict[str, QWidget]) -> None:
        self._by_name = {name: _dock(window, name, panel) for name, panel in panels.items()}
        self._window = window
        self._are_seen = True
        self._wanted = set(self._by_name)
        window.setDockOptions(QMainWindow.DockOption.AllowTabbedDocks)
        window.setCorner(Qt.Corner.BottomRightCorner, BESIDE)  # the passes get all the height
        self.arrange()

    def __getitem__(self, name: str) -> QDockWidget:
        return self._by_name[name]

    def __iter__(self):
        return iter(self._by_name.values())

    def arrange(self) -> None:
        """Put them where they are at first."""
        window, by_name = self._window, self._by_name
        for group in _TABS:
            first = by_name[group[0]]
            for name in group[1:]:
                window.tabifyDockWidget(first, by_name[name])
            first.raise_()
        beside = [by_name["passes"], by_name["notices"]]
        window.resizeDocks(beside, [460, 460], Qt.Orientation.Horizontal)
        window.resizeDocks(beside, [520, 200], Qt.Orientation.Vertical)
        window.resizeDocks([by_name["curves"]], [290], Qt.Orientation.Vertical)

    def see(self, seen: bool) -> None:
        """Show those that a person wants, or none."""
        if seen == self._are_seen:
            return
        self._are_seen = seen
        if not seen:
            self._wanted = {name for name, dock in self._by_name.items() if not dock.isHidden()}
        for name, dock in self._by_name.items():
            dock.setVisible(seen and name in self._wanted)
            dock.toggleViewAction().setEnabled(seen)

    def show_all(self) -> None:
        """Have a person want all of them again."""
        self._are_seen, self._wanted = True, set(self._by_name)
        for dock in self:
            dock.show()


def _dock(window: QMainWindow, name: str, panel: QWidget) -> QDockWidget:
    title, area = _TITLES[name]
    dock = QDockWidget(tr(title), window)
    dock.setObjectName(name)
    dock.setWidget(panel)
    window.addDockWidget(area, dock)
    dock.toggleViewAction().setStatusTip(tr("Show or hide the panel {name}", name=tr(title)))
    return dock


def place_for_late() -> QWidget:
    """Where a panel is put as soon as it is needed."""
    place = QWidget()
    QVBoxLayout(place).setContentsMargins(0, 0, 0, 0)
    return place
