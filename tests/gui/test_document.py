"""The document: reads and reconstructs beside the main thread, keeps and undoes what is changed."""

import threading

import numpy as np
import pytest
from PySide6.QtCore import QThread

from georibbon.errors import StorageError
from georibbon.gui.document import Document
from georibbon.session.session import Session
from georibbon.session.source import load


@pytest.fixture
def document(qapp):
    """A document without anything in it."""
    made = Document(qapp)
    yield made
    made.end()
    made.deleteLater()


def opened(document, path, qtbot):
    """Open and wait for the result."""
    with qtbot.waitSignal(document.reconstructed, timeout=20000) as waited:
        document.open(path)
    return waited.args[0]


def changed(document, qtbot, act):
    """Change something and wait for the result."""
    with qtbot.waitSignal(document.reconstructed, timeout=20000) as waited:
        act()
    return waited.args[0]


def smoothing_of(result):
    return {one.name: one.smoothing for one in result.passes}


def test_a_session_is_reconstructed_beside_the_main_thread(document, session, qtbot):
    on, words = [], []
    document.reconstructed.connect(lambda _: on.append(QThread.isMainThread()))
    document.busy.connect(lambda busy, what: words.append((busy, what)))
    document.open(session)
    assert document.is_busy
    assert document.reconstruction is None
    qtbot.waitUntil(lambda: not document.is_busy and document.reconstruction is not None)
    assert on == [True]
    assert words == [(True, "reading dome.georibbon"), (True, "reconstructing"), (False, "")]
    assert [one.name for one in document.passes] == ["P1", "P2", "P3"]
    assert document.path == session
    assert document.keeps
    assert document.undoable is None  # a recording that was imported is not taken apart


def test_a_recording_folder_is_read_and_never_written(document, small_capture, qtbot):
    before = {path: path.stat().st_mtime_ns for path in small_capture.iterdir()}
    opened(document, small_capture, qtbot)
    assert not document.keeps
    assert document.undo() is None
    changed(document, qtbot, lambda: document.set_smoothing("P2", 0.2))
    document.close()
    assert {path: path.stat().st_mtime_ns for path in small_capture.iterdir()} == before


@pytest.mark.parametrize("kind", ["session", "small_capture"])
def test_smoothing_is_undone_and_redone_by_name(document, kind, request, qtbot):
    first = smoothing_of(opened(document, request.getfixturevalue(kind), qtbot))
    before = document.undoable
    second = smoothing_of(changed(document, qtbot, lambda: document.set_smoothing("P2", 0.2)))
    assert second["P2"] == pytest.approx(0.2)
    assert document.undoable == "the smoothing of pass P2"
    changed(document, qtbot, lambda: document.set_smoothing("P2", 0.3))
    back = changed(document, qtbot, document.undo)
    assert smoothing_of(back) == pytest.approx(second)
    assert document.redoable == "the smoothing of pass P2"
    assert smoothing_of(changed(document, qtbot, document.undo)) == pytest.approx(first)
    assert document.undoable == before
    again = changed(document, qtbot, document.redo)
    assert smoothing_of(again) == pytest.approx(second)
    changed(document, qtbot, lambda: document.set_smoothing("P1", 0.1))
    assert document.redoable is None


@pytest.mark.parametrize("kind", ["session", "small_capture"])
def test_a_reset_of_all_is_one_step(document, kind, request, qtbot):
    opened(document, request.getfixturevalue(kind), qtbot)
    for name, metres in (("P1", 0.2), ("P3", 0.3), ("*", 0.1)):
        changed(document, qtbot, lambda n=name, m=metres: document.set_smoothing(n, m))
    chosen = dict(document.smoothing)
    assert chosen == {"P1": 0.2, "P3": 0.3, "*": 0.1}
    changed(document, qtbot, document.reset_smoothing)
    assert document.smoothing == {}
    assert document.undoable == "the smoothing of all passes"
    changed(document, qtbot, document.undo)
    assert document.smoothing == chosen
    assert document.undoable == "the smoothing of all passes"  # that of the star
    changed(document, qtbot, document.redo)
    assert document.smoothing == {}


def test_what_is_changed_survives_a_restart_with_its_undo(document, session, qtbot):
    opened(document, session, qtbot)
    changed(document, qtbot, lambda: document.set_smoothing("P2", 0.2))
    document.close()
    assert load(session).smoothing == {"P2": 0.2}
    other = Document()
    result = opened(other, session, qtbot)
    assert smoothing_of(result)["P2"] == pytest.approx(0.2)
    assert other.undo() == "the smoothing of pass P2"
    other.end()
    assert load(session).smoothing == {}


def previewed(document, qtbot, act):
    """Show something and wait for its preview."""
    with qtbot.waitSignal(document.previewed, timeout=20000) as waited:
        act()
    return waited.args[0]


def test_what_is_shown_while_a_slider_moves_is_not_kept(document, session, qtbot):
    whole = opened(document, session, qtbot)
    shown = previewed(document, qtbot, lambda: document.preview_smoothing("P1", 0.25))
    assert smoothing_of(shown)["P1"] == pytest.approx(0.25)
    assert shown.surface.mesh.triangles is whole.surface.mesh.triangles
    assert document.reconstruction is whole
    assert document.smoothing == {"P1": 0.25}
    assert document.undoable is None
    changed(document, qtbot, lambda: document.set_smoothing("P1", 0.3))
    document.close()
    with Session.open(session, read_only=True) as kept:
        values = [one.detail["value"] for one in kept.state.history if one.action == "setting"]
    assert values == [0.3]


def test_what_is_shown_is_done_wholly_when_the_slider_pauses(document, session, qtbot):
    opened(document, session, qtbot)
    result = changed(document, qtbot, lambda: document.preview_smoothing("P1", 0.25))
    assert document.reconstruction is result
    assert smoothing_of(result)["P1"] == pytest.approx(0.25)
    assert document.smoothing == {"P1": 0.25}
    assert document.undoable is None


def test_what_is_kept_after_previews_is_that_of_no_previews(document, session, qtbot):
    opened(document, session, qtbot)
    for step in range(5):
        previewed(document, qtbot, lambda s=step: document.preview_smoothing("P1", 0.1 + 0.01 * s))
    after = changed(document, qtbot, lambda: document.set_smoothing("P1", 0.2))
    document.close()
    fresh = opened(document, session, qtbot)
    for one, other in zip(after.passes, fresh.passes, strict=True):
        assert np.array_equal(one.strip.points, other.strip.points)
    assert np.array_equal(after.surface.mesh.vertices, fresh.surface.mesh.vertices)


def test_the_newest_request_wins(document, session, qtbot):
    opened(document, session, qtbot)
    shown = []
    document.previewed.connect(shown.append)
    for step in range(30):
        document.preview_smoothing("P1", 0.1 + 0.01 * step)
    qtbot.waitUntil(lambda: not document.is_busy)
    assert len(shown) == 2  # the first, which ran already, and the last
    assert smoothing_of(shown[-1])["P1"] == pytest.approx(0.39)


def test_no_words_of_work_for_what_follows_a_slider(document, session, qtbot):
    opened(document, session, qtbot)
    words = []
    document.busy.connect(lambda _, what: words.append(what))
    previewed(document, qtbot, lambda: document.preview_smoothing("P1", 0.25))
    assert not any(words)


EACH = [
    ("P2", "weight", 2.0, "the weight of pass P2"),
    ("P2", "trim", [0.02, 0.0], "the trimmed ends of pass P2"),
    ("P1", "sensors_off", ["A02"], "the switched-off sensors of pass P1"),
    ("*", "surface.direction", "conormal", "the surface's direction across"),
    ("*", "neighbours", False, "the neighbours' say"),
    ("*", "method", "paper", "the method"),
]


@pytest.mark.parametrize(("whose", "key", "value", "words"), EACH)
def test_every_setting_is_undone_by_name_and_kept(
    document, session, qtbot, whose, key, value, words
):
    first = opened(document, session, qtbot)
    result = changed(document, qtbot, lambda: document.set_setting(whose, key, value))
    assert document.undoable == words
    assert load(session).values == {(whose, key): value}
    assert not np.array_equal(result.surface.mesh.vertices, first.surface.mesh.vertices)
    back = changed(document, qtbot, document.undo)
    assert np.array_equal(back.surface.mesh.vertices, first.surface.mesh.vertices)
    changed(document, qtbot, document.redo)
    assert document.values == {(whose, key): value}


def test_tuples_are_lists_in_the_session(document, session, qtbot):
    opened(document, session, qtbot)
    changed(document, qtbot, lambda: document.set_setting("P1", "trim", (0.01, 0.02)))
    assert document.values == {("P1", "trim"): [0.01, 0.02]}
    assert document.settings.trim == {"P1": (0.01, 0.02)}


@pytest.mark.parametrize(
    ("whose", "key", "value", "words"),
    [
        ("P1", "weight", 0, "the weight of pass P1 is 0"),
        ("P1", "trim", [0.1], "two numbers"),
        ("P1", "surface.direction", "chord", "all passes together"),
        ("*", "surface.direction", "sideways", "sideways"),
        ("*", "colour", "blue", "no setting"),
    ],
)
def test_what_means_nothing_is_refused_and_not_kept(
    document, session, qtbot, whose, key, value, words
):
    opened(document, session, qtbot)
    failed = []
    document.failed.connect(failed.append)
    assert not document.set_setting(whose, key, value)
    assert words in failed[0]
    assert document.values == {}
    assert document.undoable is None
    qtbot.waitUntil(lambda: not document.is_busy)


def test_what_cannot_be_done_is_kept_told_and_undone(document, session, qtbot):
    opened(document, session, qtbot)
    with qtbot.waitSignal(document.failed, timeout=20000) as waited:
        document.set_setting("P1", "trim", [0.4, 0.4])
    assert "leave 0 mm" in waited.args[0]
    assert document.failure == waited.args[0]
    changed(document, qtbot, document.undo)
    assert document.failure is None


def test_settings_are_reset_in_one_step_and_by_name(document, session, qtbot):
    opened(document, session, qtbot)
    chosen = {
        ("P1", "weight"): 2.0,
        ("P1", "smoothing"): 0.1,
        ("P2", "smoothing"): 0.2,
        ("*", "surface.direction"): "conormal",
        ("*", "surface.interior"): "c1-lines",
    }
    changed(document, qtbot, lambda: document.set_settings(chosen))
    assert document.undoable == "the settings of all passes"
    for of, left, words in (
        ({"whose": "P1"}, 3, "the settings of pass P1"),
        ({"keys": ("surface.direction", "surface.interior")}, 3, "the settings of the surface"),
        ({"keys": ("smoothing",)}, 3, "the smoothing of all passes"),
        ({}, 0, "the settings of all passes"),
    ):
        changed(document, qtbot, lambda of=of: document.reset_settings(**of))
        assert len(document.values) == left
        opened(document, session, qtbot)  # the history is in the file
        assert document.undoable == words
        changed(document, qtbot, document.undo)
        assert document.values == chosen
        assert document.redoable == words


def test_a_reset_leaves_what_is_of_another_program(document, session, qtbot):
    with Session.open(session) as other:
        other.do("setting", **{"pass": "*", "key": "colour", "value": "blue"})
    opened(document, session, qtbot)
    changed(document, qtbot, lambda: document.set_setting("P1", "weight", 2.0))
    changed(document, qtbot, document.reset_settings)
    assert document.values == {("*", "colour"): "blue"}


def test_a_bad_value_of_another_program_is_told_once_and_left_out(document, session, qtbot):
    with Session.open(session) as other:
        other.do("setting", **{"pass": "P1", "key": "weight", "value": "heavy"})
        other.do("setting", **{"pass": "P2", "key": "smoothing", "value": 0.2})
    failed = []
    document.failed.connect(failed.append)
    result = opened(document, session, qtbot)
    assert smoothing_of(result)["P2"] == pytest.approx(0.2)
    changed(document, qtbot, lambda: document.set_smoothing("P1", 0.1))
    assert [one for one in failed if "heavy" in one] == failed[:1] == failed


def test_only_what_changed_is_fitted_again(document, session, qtbot, monkeypatch):
    from georibbon import reconstruction

    fitted = []
    real = reconstruction.fit_alone

    def watched(capture, missing, settings):
        fitted.append([capture.recording.passes[k].name for k in missing])
        return real(capture, missing, settings)

    monkeypatch.setattr(reconstruction, "fit_alone", watched)
    opened(document, session, qtbot)
    changed(document, qtbot, lambda: document.set_smoothing("P2", 0.2))
    changed(document, qtbot, lambda: document.set_smoothing("P2", 0.3))
    assert fitted == [["P1", "P2", "P3"], ["P2"], ["P2"]]


def test_the_undoing_of_a_capture_keeps_the_other_passes(document, session, qtbot):
    opened(document, session, qtbot)
    before = {one.name: one for one in document._source.recording().passes}
    document._source.session.do("remove", **{"pass": "P2"})
    after = document._source.recording()
    assert [one.name for one in after.passes] == ["P1", "P3"]
    assert all(one is before[one.name] for one in after.passes)
    assert document.undoable == "the removal of pass P2"
    changed(document, qtbot, document.undo)
    assert {one.name for one in document.passes} == {"P1", "P2", "P3"}


def test_a_session_that_another_has_open_is_read_and_not_written(document, session, qtbot):
    told = []
    document.told.connect(told.append)
    with Session.open(session) as theirs:
        opened(document, session, qtbot)
        assert not document.keeps
        assert "read only" in told[0]
        changed(document, qtbot, lambda: document.set_smoothing("P1", 0.2))
        assert document.undoable == "the smoothing of pass P1"
        changed(document, qtbot, document.undo)
        assert document.smoothing == {}
        document.close()
        assert all(one.action != "setting" for one in theirs.state.history)


def test_what_cannot_be_opened_is_told_and_the_old_stays(document, session, tmp_path, qtbot):
    opened(document, session, qtbot)
    with qtbot.waitSignal(document.failed) as failed:
        document.open(tmp_path / "nothing.georibbon")
    assert "there is no such folder or file" in failed.args[0]
    assert document.path == session
    assert document.reconstruction is not None
    (tmp_path / "text.georibbon").write_text("no session")
    with qtbot.waitSignal(document.failed) as failed:
        document.open(tmp_path / "text.georibbon")
    assert "no Georibbon session" in failed.args[0]


def test_a_value_without_meaning_is_told(document, session, qtbot):
    opened(document, session, qtbot)
    with qtbot.waitSignal(document.failed) as failed:
        document.set_smoothing("P1", 50.0)
    assert "must be between 1 and 10000 mm" in failed.args[0]
    changed(document, qtbot, document.undo)


def test_a_setting_of_another_programs_making_is_told(document, session, qtbot):
    with Session.open(session) as theirs:
        theirs.do("setting", **{"pass": "P1", "key": "smoothing", "value": "much"})
    with qtbot.waitSignal(document.failed) as failed:
        document.open(session)
    assert 'the smoothing of "P1" is "much"' in failed.args[0]
    qtbot.waitUntil(lambda: not document.is_busy)
    document.reset_smoothing()


def test_a_place_that_cannot_be_written_is_told(document, session, qtbot, monkeypatch):
    opened(document, session, qtbot)
    real = document._source.session.do

    def full(*words, **detail):
        real(*words, **detail)
        raise StorageError("the disk is full")

    monkeypatch.setattr(document._source.session, "do", full)
    with qtbot.waitSignals([document.failed, document.reconstructed]):
        document.set_smoothing("P1", 0.2)
    assert document.smoothing == {"P1": 0.2}


def test_what_cannot_be_written_is_not_closed(document, session, small_capture, qtbot, monkeypatch):
    opened(document, session, qtbot)
    real = document._source.session.close

    def full(*, discard=False):
        if not discard:
            raise StorageError("the disk is full")
        real(discard=True)

    monkeypatch.setattr(document._source.session, "close", full)
    for act in (document.close, lambda: document.open(session)):
        with qtbot.waitSignal(document.failed) as failed:
            act()
        assert failed.args == ["the disk is full"]
    with qtbot.waitSignal(document.failed):
        document.open(small_capture)
    assert document.path == session
    assert document.close(discard=True)
    assert document.path is None


def test_a_fault_of_ours_is_told_as_such(document, session, qtbot, monkeypatch):
    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", broken)
    with qtbot.waitSignal(document.fault) as fault:
        document.open(session)
    assert str(fault.args[0]) == "broken"
    assert not document.is_busy


def test_the_last_of_several_that_are_opened_stays(document, session, small_capture, qtbot):
    document.open(session)
    document.open(small_capture)
    document.open(session)
    document.open(small_capture)
    qtbot.waitUntil(lambda: not document.is_busy and document.reconstruction is not None)
    assert document.path == small_capture
    with Session.open(session) as free:
        assert not free.read_only


def test_the_same_session_opens_again(document, session, qtbot):
    opened(document, session, qtbot)
    changed(document, qtbot, lambda: document.set_smoothing("P1", 0.2))
    opened(document, session, qtbot)
    assert document.keeps
    assert document.smoothing == {"P1": 0.2}


def test_closing_leaves_nothing_open(document, session, qtbot):
    before = threading.active_count()
    opened(document, session, qtbot)
    document.close()
    assert document.path is None
    assert document.passes == ()
    assert document.reconstruction is None
    assert document.title is None
    with Session.open(session) as free:
        assert not free.read_only
    document.open(session)
    document.end()
    document.open(session)
    assert not document.is_busy
    with Session.open(session) as free:
        assert not free.read_only
    assert threading.active_count() <= before + 1  # Qt's worker may linger


def test_a_folder_is_imported(document, small_capture, tmp_path, qtbot):
    target = tmp_path / "new.georibbon"
    with qtbot.waitSignal(document.reconstructed, timeout=20000):
        document.import_folder(small_capture, target)
    assert document.path == target
    assert document.keeps
    with qtbot.waitSignal(document.failed) as failed:
        document.import_folder(small_capture, target)
    assert "not overwritten" in failed.args[0]


def test_the_demonstration_is_captured_once(document, session, tmp_path, qtbot, monkeypatch):
    captures = []

    def simulated(settings):
        captures.append(settings)

        class Made:
            recording = load(session).recording

        return Made

    monkeypatch.setattr("georibbon.simulation.simulate", simulated)
    for _ in range(2):
        with qtbot.waitSignal(document.reconstructed, timeout=20000):
            document.open_demonstration(tmp_path / "data")
    assert [one.surface for one in captures] == ["bonnet"]
    assert document.path == tmp_path / "data" / "car bonnet.georibbon"


def test_what_is_captured_behind_an_import_is_undone_but_never_the_import(document, session, qtbot):
    with Session.open(session) as other:
        other.do("remove", **{"pass": "P3"})
    opened(document, session, qtbot)
    assert document.undoable == "the removal of pass P3"
    changed(document, qtbot, document.undo)
    assert [one.name for one in document.passes] == ["P1", "P2", "P3"]
    assert document.undoable is None
    assert document.undo() is None
    assert document.redoable == "the removal of pass P3"
