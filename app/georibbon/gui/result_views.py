"""What shows a result: the 3D view, the curves, notices and checks, and the summary in words."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtWidgets import QDockWidget, QWidget

from georibbon.gui.language import tr, trn

if TYPE_CHECKING:
    from georibbon.gui.checks_panel import ChecksPanel
    from georibbon.gui.notices_panel import NoticesPanel
    from georibbon.gui.parts import Parts
    from georibbon.gui.passes_panel import PassesPanel
    from georibbon.gui.scene_view import ImageView, SceneView
    from georibbon.reconstruction import Reconstruction
    from georibbon.scene.measuring import Pick


CURVES_REST = 0.1  # s between the curves of previews: the surface needs the time more


class ResultViews(QObject):
    """Shows every result of the document, and what a moving slider makes of it.

    words: the panels that tell of a result in words.  curves_dock: where the curves are put
    with the first result.
    summarised(words): what came out, in a line.
    """

    summarised = Signal(str)

    def __init__(
        self,
        parts: Parts,
        view: SceneView | ImageView,
        passes: PassesPanel,
        words: tuple[NoticesPanel, ChecksPanel],
        curves_dock: QDockWidget,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._parts, self._document, self._view = parts, parts.document, view
        self._passes, self._words, self._curves_dock = passes, words, curves_dock
        self.curves = None
        self._shown: Reconstruction | None = None  # the newest result, or a preview
        self._curves_at = 0.0  # when the curves followed a preview last
        document = parts.document
        document.reconstructed.connect(self.show_result)
        document.previewed.connect(self.show_preview)
        document.changed.connect(self._changed)
        passes.chosen.connect(lambda _: self.show_curves())
        view.picked.connect(self._picked)
        curves_dock.visibilityChanged.connect(lambda _: self.show_curves())

    @Slot(object)
    def show_result(self, result: Reconstruction) -> None:
        """Show a result in all views."""
        self._shown = result
        self._view.show_scene(result)
        for panel in self._words:
            panel.show_result(result)
        self.summarised.emit(summary(result))
        self.show_curves()

    @Slot(object)
    def show_preview(self, result: Reconstruction) -> None:
        """What a moving slider makes of it; the words follow when it rests, the curves soon."""
        self._shown = result
        self._view.show_scene(result)
        now = monotonic()
        if now - self._curves_at >= CURVES_REST:
            self._curves_at = now
            self.show_curves()

    def show_nothing(self) -> None:
        """Nothing is open, or nothing came of it yet."""
        self._shown = None
        self._view.show_scene(None)
        for panel in self._words:
            panel.show_result(None)
        if self.curves is not None:
            self.curves.show_passes(None, ())
        self.summarised.emit("")

    def show_curves(self) -> None:
        """The curves of the selected passes, or of all, where they are seen."""
        result = self._shown
        if result is None or not self._curves_dock.isVisible():
            return
        if self.curves is None:
            self.curves = self._make_curves(self._curves_dock.widget())
        names = self._passes.selected() or [one.name for one in result.passes]
        self.curves.show_passes(result, names, self._document.recording)

    @Slot(object)
    def _picked(self, pick: Pick) -> None:
        """The cursor goes to a place that was pointed at, in the view and in the curves."""
        self._view.show_cursor(pick.pass_name, pick.s)
        if self.curves is not None:
            self.curves.show_cursor(pick.pass_name, pick.s)

    def _make_curves(self, place: QWidget) -> QWidget:
        from georibbon.gui.curve_panel import CurvePanel

        curves = CurvePanel(self._parts, place)
        curves.cursor_moved.connect(self._view.show_cursor)
        place.layout().addWidget(curves)
        return curves

    @Slot(str)
    def _changed(self, what: str) -> None:
        if what == "source" or (what == "passes" and self._document.reconstruction is None):
            self.show_nothing()


def summary(result: Reconstruction) -> str:
    """What came out, in a line."""
    passes = sum(one.kind == "pass" for one in result.passes)
    words = [trn("{n} pass", "{n} passes", passes)]
    if len(result.passes) > passes:
        words.append(trn("{n} tie", "{n} ties", len(result.passes) - passes))
    redo = sum(one.quality.verdict == "redo" for one in result.passes)
    if redo:
        words.append(tr("{n} to be laid again", n=redo))
    if result.surface is not None:
        words.append(tr("{area} m²", area=f"{result.surface.area:.3f}"))
        triangles = len(result.surface.mesh.triangles)
        words.append(trn("{n} triangle", "{n} triangles", triangles))
    return " · ".join(words)
