"""Another calibration in the place of the session's own poses: kept, undone, and refused."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from georibbon.calibration import calibrate
from georibbon.gui.document import Document
from georibbon.session.folder import read_recording
from georibbon.session.session import Session
from georibbon.session.source import load


@pytest.fixture
def document(qapp):
    made = Document(qapp)
    yield made
    made.end()


@pytest.fixture(scope="module")
def other(small_capture):
    """A calibration of the same ribbon without one of the poses: another one, but close."""
    recording = read_recording(small_capture)
    return calibrate(recording.ribbon, recording.poses[:1] + recording.poses[2:])


def opened(document, path, qtbot):
    with qtbot.waitSignal(document.reconstructed, timeout=60_000) as done:
        document.open(path)
    return done.args[0]


def after(document, act, qtbot):
    with qtbot.waitSignal(document.reconstructed, timeout=60_000) as done:
        act()
    return done.args[0]


def moved(one, two):
    pairs = zip(one.passes, two.passes, strict=True)
    return max(float(np.abs(a.strip.points - b.strip.points).max()) for a, b in pairs)


@pytest.mark.parametrize("kind", ["session", "folder", "read only"])
def test_it_is_used_and_undone_by_name(document, session, small_capture, other, kind, qtbot):
    path, held = session, None
    if kind == "folder":
        path = session.parent / "recording"
        shutil.copytree(small_capture, path)
    if kind == "read only":
        held = Session.open(session)  # by another
    try:
        own = opened(document, path, qtbot)
        assert document.has_poses
        assert document.calibration is None
        given = after(document, lambda: document.use_calibration(other), qtbot)
        assert moved(own, given) > 1e-6
        assert np.allclose(document.calibration.sensors[0].gain, other.sensors[0].gain)
        assert document.undoable == "the calibration"
        assert moved(own, after(document, document.undo, qtbot)) < 1e-9
        assert document.calibration is None
        assert document.redoable == "the calibration"
        assert moved(given, after(document, document.redo, qtbot)) < 1e-9
        back = after(document, lambda: document.use_calibration(None), qtbot)
        assert moved(own, back) < 1e-9
        assert moved(given, after(document, document.undo, qtbot)) < 1e-9
    finally:
        if held is not None:
            held.close()


def test_a_session_keeps_it_for_the_next_time_and_for_the_command_line(
    document, session, other, qtbot
):
    opened(document, session, qtbot)
    assert load(session).calibration is None
    given = after(document, lambda: document.use_calibration(other), qtbot)
    assert document.close()
    assert load(session).calibration is not None
    assert moved(given, opened(document, session, qtbot)) < 1e-9


def test_a_reset_of_all_settings_leaves_it(document, session, other, qtbot):
    opened(document, session, qtbot)
    after(document, lambda: document.use_calibration(other), qtbot)
    after(document, lambda: document.set_smoothing("*", 0.08), qtbot)
    after(document, document.reset_settings, qtbot)
    assert document.calibration is not None
    assert document.smoothing == {}


@pytest.mark.parametrize("kind", ["session", "folder"])
def test_one_of_another_ribbon_is_refused_and_nothing_is_changed(
    document, session, small_capture, other, kind, qtbot
):
    opened(document, session if kind == "session" else small_capture, qtbot)
    before = document.undoable
    with qtbot.waitSignal(document.failed) as told:
        document.use_calibration(replace(other, ribbon_id="GR-9999"))
    assert "GR-9999" in told.args[0]
    assert document.undoable == before
    assert document.calibration is None
