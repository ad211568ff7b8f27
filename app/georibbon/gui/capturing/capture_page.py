"""The page of the capture: first the plan, then pass after pass."""

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from georibbon.gui.capturing.capturing_view import CapturingView
from georibbon.gui.capturing.model import CaptureModel, is_calibration
from georibbon.gui.capturing.plan_page import PlanPage
from georibbon.gui.parts import Parts


class CapturePage(QWidget):
    """Plan and capture.

    finished(): the capture is ended, the review is next.  wanted(page): a
    person is led to another page, as "connect".  folder: where calibrations are
    kept, in the place of the user's own.
    """

    finished = Signal()
    wanted = Signal(str)

    def __init__(
        self, parts: Parts, parent: QWidget | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(parent)
        self._parts = parts
        self.model = CaptureModel(parts, self)
        self.plan = PlanPage(parts, folder=folder)
        self.view = CapturingView(parts, self.model, self.make_scene)
        self.stack = QStackedWidget()
        self.stack.addWidget(self.plan)
        self.stack.addWidget(self.view)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.stack)
        self.plan.wanted.connect(self.wanted)
        self.view.wanted.connect(self.wanted)
        self.plan.left_for_capture.connect(self._show_capture)
        self.view.planned.connect(self._show_plan)
        self.view.finished.connect(self.finished)
        parts.capture.began.connect(self._begin)
        parts.capture.ended.connect(self._show_plan)
        parts.capture.stood.connect(self._take_layout)
        if parts.capture.active:
            self.model.begin()
            self._begin()

    def make_scene(self) -> QWidget:
        """The 3D view, which takes long to load."""
        from georibbon.gui.scene_view import make_view

        return make_view()

    def entered(self) -> None:
        """Comes into sight."""
        self.plan.entered()

    def end(self) -> None:
        """Nothing of it goes on: before the window is closed."""
        self.plan.end()
        self.view.end()

    def _show_plan(self) -> None:
        self.plan.entered()
        self.stack.setCurrentWidget(self.plan)

    def use_calibration(self, calibration, name: str) -> None:
        """Choose a calibration that was just made for the capture."""
        if self._parts.capture.active:
            self._parts.capture.use_calibration(calibration)
        else:
            self.plan.use_calibration(calibration, name)

    def _begin(self) -> None:
        if is_calibration(self._parts.capture):
            return
        self.view.begin()
        self.plan.follow(self._parts.capture.plan)
        self._show_capture()

    def _show_capture(self) -> None:
        self._take_layout()
        self.stack.setCurrentWidget(self.view)
        self.view.setFocus()

    def _take_layout(self) -> None:
        """How passes are meant to be laid is the plan's to say."""
        plan = self._parts.capture.plan
        if plan is not None and plan.layout != self.model.layout:
            self.model.take_layout(plan.layout)

    # What the window's actions do; nothing as long as no capture goes on

    def _do(self, name: str) -> None:
        if self._parts.capture.active and not is_calibration(self._parts.capture):
            getattr(self.view, name)()

    def take(self) -> None:
        """As the view's."""
        self._do("take")

    def take_anyway(self) -> None:
        """As the view's."""
        self._do("take_anyway")

    def skip(self) -> None:
        """As the view's."""
        self._do("skip")

    def lay_again(self) -> None:
        """As the view's."""
        self._do("lay_again")

    def delete(self) -> None:
        """As the view's."""
        self._do("delete")

    def add_pass(self) -> None:
        """As the view's."""
        self._do("add_pass")

    def add_tie(self) -> None:
        """As the view's."""
        self._do("add_tie")

    def move_up(self) -> None:
        """As the view's."""
        self._do("move_up")

    def move_down(self) -> None:
        """As the view's."""
        self._do("move_down")

    def ask_note(self) -> None:
        """As the view's."""
        self._do("ask_note")

    def undo(self) -> None:
        """As the view's."""
        self._do("undo")

    def redo(self) -> None:
        """As the view's."""
        self._do("redo")

    def finish(self) -> None:
        """As the view's."""
        self._do("finish")

    def set_auto(self, auto: bool) -> None:
        """As the view's."""
        if self._parts.capture.active:
            self.view.set_auto(auto)
