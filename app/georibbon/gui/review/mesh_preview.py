"""The mesh that will be written: as a picture that can be turned, and in figures."""

from PySide6.QtCore import QLocale
from PySide6.QtWidgets import QLabel, QSizePolicy, QVBoxLayout, QWidget

from georibbon.gui.language import tr
from georibbon.gui.parts import Parts
from georibbon.gui.scene_view import make_view

_HIDDEN = ("passes", "ties", "marks", "labels", "floor")


class MeshPreview(QWidget):
    """A small 3D view of one mesh, and below it what a person asks of it."""

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = parts.units
        self._facts = None
        self.view = make_view()
        self.view.setMinimumSize(320, 240)
        self.view.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.view.setAccessibleName(tr("What will be written"))
        self.view.set_colouring("plain")
        for part in _HIDDEN:
            self.view.set_shown(part, False)
        self.facts = QLabel()
        self.facts.setWordWrap(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.view, 1)
        column.addWidget(self.facts)
        self._units.changed.connect(self._tell)

    def show_mesh(self, shown, facts) -> None:
        """Show a result whose surface is the mesh, with its `MeshFacts`; None: nothing."""
        first = self._facts is None
        self._facts = facts
        self.view.show_scene(shown)
        if first and shown is not None:
            self.view.standard_view("iso")
        self._tell()

    def _tell(self) -> None:
        facts, units = self._facts, self._units
        if facts is None:
            self.facts.setText("")
            return
        x, y, z = (units.number(one) for one in facts.size)
        closed = tr("closed (watertight)") if facts.watertight else tr("an open skin")
        count = QLocale.system().toString(facts.triangles)
        self.facts.setText(
            tr("{count} triangles, {closed}", count=count, closed=closed)
            + "\n"
            + tr("{x} × {y} × {z} {unit}", x=x, y=y, z=z, unit=units.symbol)
            + "   "
            + tr("{area} m² of area", area=f"{facts.area:.4f}")
        )
