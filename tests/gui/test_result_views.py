"""What shows a result: the surface follows every preview, the curves some of them, both the end."""

from types import SimpleNamespace

import pytest
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QDockWidget

from georibbon.gui import result_views
from georibbon.gui.document import Document
from georibbon.gui.result_views import ResultViews


class Passes(QObject):
    """A panel in which P1 is selected."""

    chosen = Signal(list)

    def selected(self):
        return ["P1"]


class Shown(QObject):
    """Notes what it is to show."""

    picked = Signal(object)

    def __init__(self):
        super().__init__()
        self.seen, self.cursor = [], None

    def show_cursor(self, name, s):
        self.cursor = (name, s)

    def show_scene(self, result):
        self.seen.append(result)

    def show_passes(self, result, *_):
        self.seen.append(result)

    def show_result(self, result):
        self.seen.append(result)


@pytest.fixture
def views(qapp, qtbot, monkeypatch):
    """The views of a document, with a clock that is turned by hand."""
    document, dock = Document(qapp), QDockWidget()
    qtbot.addWidget(dock)
    dock.show()
    made = ResultViews(
        SimpleNamespace(document=document), Shown(), Passes(qapp), (Shown(), Shown()), dock, qapp
    )
    made.curves, made.clock = Shown(), [100.0]
    monkeypatch.setattr(result_views, "monotonic", lambda: made.clock[0])
    monkeypatch.setattr(result_views, "summary", lambda _: "")
    yield made
    document.end()
    document.deleteLater()
    made.deleteLater()


def result(name):
    return SimpleNamespace(name=name, passes=[])


def test_the_surface_follows_every_preview_and_the_curves_ten_a_second(views):
    previews = [result(k) for k in range(30)]
    for one in previews:
        views._document.previewed.emit(one)
        views.clock[0] += 0.033
    assert views._view.seen == previews
    assert views.curves.seen == previews[::4]
    assert [panel.seen for panel in views._words] == [[], []]


def test_the_result_at_the_end_is_shown_by_all_at_once(views):
    for one in ("first", "second"):
        views._document.previewed.emit(result(one))
    last = result("last")
    views._document.reconstructed.emit(last)
    assert views._view.seen[-1] is last
    assert views.curves.seen[-1] is last
    assert [panel.seen for panel in views._words] == [[last], [last]]


def test_where_the_view_is_picked_the_cursor_of_view_and_curves_goes(views):
    views._view.picked.emit(SimpleNamespace(pass_name="P2", s=0.25))
    assert views._view.cursor == views.curves.cursor == ("P2", 0.25)
    views.curves = None  # not made yet
    views._view.picked.emit(SimpleNamespace(pass_name="P1", s=0.5))
    assert views._view.cursor == ("P1", 0.5)
