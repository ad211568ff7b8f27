"""What is known of passes: an old result says nothing of a pass that was laid again since."""

from types import SimpleNamespace

import pytest
from PySide6.QtCore import QObject, Signal

from georibbon.gui.capturing.model import CaptureModel


class Document(QObject):
    """Tells results; is_behind: whether it was asked for a newer one."""

    reconstructed = Signal(object)

    def __init__(self):
        super().__init__()
        self.reconstruction, self.is_behind = None, False

    def tell(self, verdict, is_behind):
        """A result in which P1 has this verdict."""
        quality = SimpleNamespace(verdict=verdict, reason="because")
        self.reconstruction = SimpleNamespace(passes=[SimpleNamespace(name="P1", quality=quality)])
        self.is_behind = is_behind
        self.reconstructed.emit(self.reconstruction)


class Capture(QObject):
    """A capture of one pass, P1."""

    began, ended, changed, stood = Signal(), Signal(), Signal(), Signal()
    refreshed, happened = Signal(object), Signal(object)
    active, session = False, None
    items = (SimpleNamespace(key="P1", is_pose=False, what=SimpleNamespace(kind="pass")),)


@pytest.fixture
def model():
    """The model of a capture in which P1 was just laid again."""
    parts = SimpleNamespace(document=Document(), capture=Capture())
    made = CaptureModel(parts)
    parts.document.tell("good", is_behind=False)
    assert made.quality("P1").final
    parts.capture.happened.emit(SimpleNamespace(kind="taken", subject="P1"))
    return made


def test_a_result_begun_before_a_pass_was_laid_again_is_not_its_verdict(model):
    assert model.quality("P1") is None
    model._parts.document.tell("redo", is_behind=True)
    assert model.quality("P1") is None
    model._parts.document.tell("acceptable", is_behind=False)
    found = model.quality("P1")
    assert (found.verdict, found.final) == ("acceptable", True)
