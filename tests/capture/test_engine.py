"""The engine, driven by the frames of a virtual ribbon and by verbs, as a person would."""

from dataclasses import replace

import numpy as np
import pytest
from hands import Bench, virtual

from georibbon.calibration import calibrate
from georibbon.calibration.model import Calibration
from georibbon.capture.engine import Engine
from georibbon.capture.plan import CapturePlan, PlannedLayout
from georibbon.capture.start import open_capture
from georibbon.device.identity import Identity
from georibbon.errors import CalibrationError, SessionError, SettingsError
from georibbon.reconstruction import reconstruct
from georibbon.recording import Workpiece
from georibbon.ribbon import Ribbon
from georibbon.session.file import read_session
from georibbon.session.session import Session
from georibbon.simulation.scoring import score

POSES = tuple(f"pose-{i:02}" for i in range(1, 13))


@pytest.fixture
def place(tmp_path):
    return tmp_path / "capture.georibbon"


@pytest.fixture
def bench(place):
    bench = Bench(place)
    yield bench
    bench.session.close()


@pytest.fixture
def laying(place):
    """A bench without poses, with the true calibration."""
    bench = Bench(place, CapturePlan(poses=0, passes=3, ties=1))
    bench.engine.use_calibration(bench.ribbon.truth.calibration)
    yield bench
    bench.session.close()


def test_a_whole_capture_by_stillness_alone(bench, place):
    bench.pose_all()
    assert tuple(bench.taken()) == POSES
    assert isinstance(bench.engine.calibration, Calibration)
    assert "heading" in bench.last("calibrated").message
    for name in ("P1", "P2", "P3", "T1"):
        bench.do("lift", f"lay {name}")
    assert tuple(bench.taken()) == (*POSES, "P1", "P2", "P3", "T1")
    assert bench.kinds()[-1] == "complete"
    assert bench.engine.current is None
    marks, distances, crossings = bench.ribbon.survey()
    for mark in marks:
        entry = {"pass": mark.pass_name, "at": mark.at, "sigma": mark.sigma}
        bench.engine.survey.add("mark", entry | {"position": list(mark.position)})
    for crossing in crossings:
        entry = {"passes": list(crossing.passes), "at": list(crossing.at), "sigma": crossing.sigma}
        bench.engine.survey.add("crossing", entry)
    assert not distances
    bench.session.close()
    result = reconstruct(read_session(place))
    errors = score(result, bench.ribbon.truth)
    assert errors.curves.all.rms < 2.5
    assert {one.name for one in result.passes} == {"P1", "P2", "P3", "T1"}


def test_what_is_taken_is_in_the_file_when_it_is_told(place):
    bench = Bench(place)
    seen = []

    def look(happening):
        if happening.kind == "taken":
            with Session.open(place, read_only=True) as other:
                seen.append({one.key for one in other.state.poses} >= {happening.subject})

    bench.engine.observe(look)
    bench.do("lift", "pose 1", "lift", "pose 2")
    bench.session.close()
    assert seen == [True, True]


def test_frames_in_any_blocks_give_the_same_session(tmp_path):
    found = []
    for block in (1, 7, 100):
        bench = Bench(tmp_path / f"{block}.georibbon", block=block, ribbon=virtual(seed=3))
        bench.do("lift", "pose 1", "lift", "pose 2")
        found.append([(one.key, one.frames) for one in bench.session.state.poses])
        bench.session.close()
    assert [key for key, _ in found[0]] == ["pose-01", "pose-02"]
    # A block may bring some frames more than were needed; nothing else may differ.
    assert all([key for key, _ in one] == ["pose-01", "pose-02"] for one in found)


def test_poses_and_passes_come_in_any_order(bench):
    bench.engine.choose("P2")
    bench.do("lift", "lay P2")
    bench.engine.choose("pose-05")
    bench.do("lift", "pose 5")
    assert bench.taken() == ["P2", "pose-05"]
    assert bench.engine.current.key == "pose-06"


def test_without_lifting_nothing_is_taken_twice(laying):
    laying.do("lift", "lay P1", "hold", "hold")
    assert laying.taken() == ["P1"]
    refusal = laying.engine.take()
    assert refusal.code == "not-lifted"
    assert laying.engine.take(force=True) is None
    assert laying.taken() == ["P1", "P2"]


def test_a_repeated_pass_replaces_the_first(laying):
    laying.do("lift", "lay P1")
    first = laying.session.recording(complete=False).passes[0].readings.counts.mean(axis=0)
    laying.engine.choose("P1")
    laying.do("lift", "lay P3")
    (run,) = laying.session.recording(complete=False).passes
    assert run.name == "P1"
    assert np.abs(run.readings.counts.mean(axis=0) - first).max() > 50
    assert laying.engine.current.key == "P2"


def test_the_wrong_face_is_refused_once_and_told(bench):
    bench.do("lift", "pose 3")
    assert bench.taken() == []
    refused = [one for one in bench.told if one.kind == "refused"]
    assert len(refused) == 1
    assert "pose-01 is asked with" in refused[0].message
    bench.engine.choose("pose-03")
    bench.engine.take()
    assert bench.taken() == ["pose-03"]


def test_moving_and_short_are_refused_with_the_reason(laying):
    assert laying.engine.take().code == "moving"
    laying.do("lift", seconds=1.0)
    assert laying.engine.take().code == "moving"
    laying.engine.auto = False
    laying.do("lay P1", seconds=1.2)
    refusal = laying.engine.take()
    assert refusal.code in ("moving", "short")
    assert "still" in refusal.message
    laying.pass_time(2.0)
    assert laying.engine.take() is None


def test_what_lies_still_from_the_start_is_told_once_and_taken_by_hand(laying):
    laying.ribbon.do("lay P1")
    laying.ribbon.advance(5.0)
    laying.pass_time(4.0)
    refused = [one.message for one in laying.told if one.kind == "refused"]
    assert len(refused) == 1
    assert "not moved since the start" in refused[0]
    assert laying.taken() == []
    assert laying.engine.take() is None
    assert laying.taken() == ["P1"]


def test_after_a_gap_nobody_knows_whether_it_was_lifted(laying):
    laying.do("lift", "lay P1")
    laying.ribbon.advance(1.0)
    laying.pass_time(3.0)
    assert laying.taken() == ["P1"]
    assert laying.engine.take().code == "not-lifted"


def test_a_fault_in_reading_poses_ends_nothing(bench, monkeypatch):
    def fail(complete):
        raise SessionError(f"frames cannot be read (complete {complete})")

    bench.pose_all()
    bench.engine.choose("pose-01")
    monkeypatch.setattr(bench.session, "recording", fail)
    bench.do("lift", "pose 1")
    assert bench.taken()[-1] == "pose-01"
    assert "frames cannot be read" in bench.last("quality").message
    assert bench.engine.current is not None


def test_skipping_what_is_repeated_keeps_it(laying):
    laying.do("lift", "lay P1")
    laying.engine.choose("P1")
    laying.engine.skip()
    assert "stays" in laying.last("skipped").message
    assert laying.engine.items[0].status == "taken"


def test_by_hand_only_nothing_is_taken_by_itself(place):
    bench = Bench(place, auto=False)
    bench.do("lift", "pose 1")
    assert bench.taken() == []
    bench.engine.take()
    assert bench.taken() == ["pose-01"]
    bench.session.close()


def test_skip_remove_undo_redo_go_back_and_forth(laying):
    engine = laying.engine
    laying.do("lift", "lay P1")
    engine.skip()
    assert [(i.key, i.status) for i in engine.items[:3]] == [
        ("P1", "taken"), ("P2", "skipped"), ("P3", "open"),
    ]  # fmt: skip
    engine.undo()
    assert engine.items[1].status == "open"
    engine.remove("P1")
    assert engine.items[0].status == "open"
    engine.undo()
    assert engine.items[0].status == "taken"
    engine.redo()
    assert engine.items[0].status == "open"
    with pytest.raises(SettingsError, match="P1"):
        engine.remove("P1")


def test_undo_and_what_is_left_survive_a_restart(laying, place):
    laying.do("lift", "lay P1", "lift", "lay P2")
    laying.engine.note("the left end hung over")
    laying.session.close()
    session, plan = open_capture(place, Identity(laying.ribbon.ribbon, "1.0"), None)
    with session:
        engine = Engine(session, plan)
        assert (plan.poses, plan.passes, plan.ties) == (0, 3, 1)
        assert engine.current.key == "P3"
        assert engine.calibration is not None
        engine.undo()
        assert session.state.notes == ()
        engine.undo()
        assert [one.name for one in session.state.passes] == ["P1"]
        assert engine.current.key in ("P2", "P3")


def test_the_plan_given_again_adds_nothing_and_loses_nothing(place):
    entry = {"pass": "P1", "at": 0.0, "position": [0.0, 0.0, 0.0], "sigma": 0.001}
    plan = CapturePlan(poses=0, passes=2, workpiece=Workpiece(True, 10.0), survey={"mark": [entry]})
    bench = Bench(place, plan)
    bench.engine.survey.add("mark", entry | {"pass": "P2", "at": 0})
    bench.session.close()
    again = Bench(place, plan)
    assert [mark.pass_name for mark in again.session.state.marks] == ["P1", "P2"]
    actions = [one.action for one in again.session.state.history]
    assert actions.count("plan") == actions.count("workpiece") == 1
    assert actions.count("survey") == 2
    again.session.close()
    identity = Identity(again.ribbon.ribbon, "1.0")
    session, wider = open_capture(place, identity, None, {"passes": 4})
    with session:
        assert (wider.poses, wider.passes, wider.ties) == (0, 4, 0)
        assert len(session.state.marks) == 2
    session, same = open_capture(place, identity, None)
    with session:
        assert same.passes == 4


def test_how_passes_are_laid_is_kept_and_undone_with_the_plan(place):
    wide = PlannedLayout(spacing=0.07, marks=1, crossing_sigma=0.002)
    bench = Bench(place, CapturePlan(poses=0, passes=2, layout=wide))
    bench.session.close()
    session, plan = open_capture(place, Identity(bench.ribbon.ribbon, "1.0"), None)
    with session:
        assert plan.layout == wide
        engine = Engine(session, plan)
        engine.replan(replace(plan, layout=PlannedLayout()))
        assert engine.plan.layout == PlannedLayout()
        engine.undo()
        assert engine.plan == plan
        actions = [one.action for one in session.state.history]
        assert actions.count("plan") == 2


def test_a_layout_that_cannot_be_meant_is_the_usual_one(place):
    bench = Bench(place, CapturePlan(poses=0, passes=2))
    bench.session.do("plan", poses=0, passes=3, ties=0, layout={"spacing": 99.0})
    bench.session.close()
    session, plan = open_capture(place, Identity(bench.ribbon.ribbon, "1.0"), None)
    with session:
        assert (plan.passes, plan.layout) == (3, PlannedLayout())


def test_nothing_to_undo_is_said(place):
    bench = Bench(place, CapturePlan(poses=0, passes=2))
    with pytest.raises(SettingsError, match="nothing can be redone"):
        bench.engine.redo()
    bench.session.close()


def test_further_passes_and_unknown_names(laying):
    engine = laying.engine
    with pytest.raises(SettingsError, match="P33"):
        engine.choose("P33")
    engine.add("P33", "pass")
    assert engine.current.key == "P33"
    laying.do("lift", "lay P1")
    assert laying.taken() == ["P33"]
    with pytest.raises(SettingsError, match="P33"):
        engine.add("P33", "tie")
    with pytest.raises(SettingsError, match="name"):
        engine.add(" ", "tie")


def test_the_survey_is_checked_and_kept(laying):
    engine = laying.engine
    mark = {"pass": "P1", "at": 0.0, "position": [0.0, 0.1, 0.2], "sigma": 0.001}
    engine.survey.add("mark", mark)
    with pytest.raises(SettingsError, match="at is 9"):
        engine.survey.add("mark", mark | {"at": 9.0})
    with pytest.raises(SettingsError, match="P9"):
        engine.survey.add("mark", mark | {"pass": "P9"})
    assert len(laying.session.state.marks) == 1
    with pytest.raises(SettingsError, match="mark number 2"):
        engine.survey.remove("mark", 2)
    engine.survey.remove("mark", 1)
    assert laying.session.state.marks == ()
    engine.undo()
    assert len(laying.session.state.marks) == 1


def test_too_few_poses_say_what_is_missing(bench):
    bench.do("lift", "pose 1")
    with pytest.raises(CalibrationError, match="1 poses"):
        bench.engine.calibrate()


def test_poses_alone_give_the_calibration_of_the_library(bench):
    bench.pose_all()
    poses = bench.session.recording(complete=False).poses
    own = calibrate(bench.ribbon.ribbon, poses)
    for one, other in zip(own.sensors, bench.session.state.calibration.sensors, strict=True):
        assert np.allclose(one.gain, other.gain)
    bench.engine.undo()
    assert bench.engine.calibration is None
    bench.engine.redo()
    assert bench.engine.calibration is not None


def test_the_live_curve_is_the_true_one(laying):
    assert laying.engine.refresh().curve is None
    laying.do("lift", "lay P2")
    curve = laying.engine.refresh().curve
    strip = laying.ribbon.truth.strips["P2"]
    # Up to the heading of the workpiece, which turns both alike: how far apart start and end are.
    true = np.linalg.norm(strip.points[-1] - strip.points[0])
    assert np.linalg.norm(curve.strip.points[-1]) == pytest.approx(true, abs=0.003)


def test_a_break_of_the_link_is_kept_and_ends_what_was_still(laying):
    laying.engine.auto = False
    laying.do("lift", "lay P1")
    entry = {"state": "disconnected", "reason": "the cable is out", "frames": 7, "lost": 2}
    laying.engine.link_news(entry)
    assert laying.engine.refresh().stillness is None
    assert laying.engine.take().code == "moving"
    event = laying.session.state.history[-1]
    assert event.action == "link"
    assert event.detail["reason"] == "the cable is out"
    laying.pass_time(2.0)
    assert laying.engine.take() is None


def test_another_ribbon_is_refused_with_both_told(laying, place):
    laying.session.close()
    mine = laying.ribbon.ribbon
    other = Ribbon("GR-0099", mine.length, mine.rate, mine.sensors)
    with pytest.raises(SessionError, match=r"GR-0099.*GR-0001"):
        open_capture(place, Identity(other, "1.0"), None)
    fewer = Ribbon(mine.id, mine.length, mine.rate, mine.sensors[:-1])
    with pytest.raises(SessionError, match="other sensors"):
        open_capture(place, Identity(fewer, "1.0"), None)
    faster = Ribbon(mine.id, mine.length, 2 * mine.rate, mine.sensors)
    session, _ = open_capture(place, Identity(faster, "1.0"), None)
    assert session.state.ribbon.rate == 2 * mine.rate
    session.close()


def test_the_ribbon_is_written_where_one_damage_does_not_reach_both(laying):
    copies = [one.id for one in laying.session.state.history if one.action == "ribbon"]
    (calibration,) = [one.id for one in laying.session.state.history if one.action == "calibration"]
    assert copies[0] < calibration < copies[1]


def test_a_magnet_is_told_with_the_pass(laying):
    laying.ribbon.do("magnet 0.4")
    laying.do("lift", "lay P1")
    if laying.taken() == []:
        laying.engine.take(force=True)
    words = laying.last("taken").message
    assert "acceptable" in words or "redo" in words
    assert "M" in words


def test_what_cannot_be_written_is_held_and_goes_to_another_place(laying, place, tmp_path):
    laying.do("lift", "lay P1")
    place.unlink()
    laying.do("lift", "lay P2")
    assert laying.taken() == ["P1"]
    assert "held" in laying.kinds()
    assert [item.status for item in laying.engine.items[:2]] == ["taken", "taken"]
    told = [one.message for one in laying.told if one.kind == "held" and one.subject is None]
    assert len(told) == len(set(told)), "one sentence for one fault"
    laying.engine.note("in the meantime")
    assert "in memory only" in laying.last("noted").message
    laying.engine.undo()
    assert laying.last("undone").message.startswith("undone: the note")
    other = tmp_path / "other.georibbon"
    laying.engine.save_to(other)
    assert laying.kinds()[-1] == "saved"
    laying.session.close()
    with Session.open(other, read_only=True) as session:
        names = [one.name for one in session.recording(complete=False).passes]
    assert names == ["P1", "P2"]


def test_the_order_is_changed_by_a_verb_and_taken_back_by_name(tmp_path):
    with_two = Bench(tmp_path / "s.georibbon", CapturePlan(poses=0, passes=2, ties=0))
    with_two.do("lift", "lay P1", "lift", "lay P2")
    engine = with_two.engine
    engine.reorder(["P2", "P1"])
    assert [one.name for one in with_two.session.state.passes] == ["P2", "P1"]
    engine.undo()
    assert [one.name for one in with_two.session.state.passes] == ["P1", "P2"]
    with pytest.raises(SettingsError, match="it must name P1, P2, each once"):
        engine.reorder(["P1", "P1"])
    with_two.session.close()


def test_another_plan_asks_for_more_and_is_taken_back(tmp_path):
    bench = Bench(tmp_path / "s.georibbon", CapturePlan(poses=0, passes=1, ties=0))
    bench.do("lift", "lay P1")
    engine = bench.engine
    assert engine.current is None
    engine.replan(CapturePlan(poses=0, passes=2, ties=1))
    assert engine.current.key == "P2"
    assert [item.key for item in engine.items] == ["P1", "P2", "T1"]
    engine.undo()
    assert engine.plan.passes == 1
    assert engine.current is None
    bench.session.close()


def test_frames_that_come_all_at_once_mean_what_they_mean_one_by_one(tmp_path):
    plan = CapturePlan(poses=0, passes=3, ties=0)
    held_up = Bench(tmp_path / "s.georibbon", plan, block=10_000)
    frames = []
    for words in ("lift", "lay P1", "lift", "lay P2", "lift", "lay P3"):
        held_up.ribbon.do(words)
        frames += held_up.ribbon.frames(300)
    held_up.engine.feed(frames)
    assert [one.name for one in held_up.session.state.passes] == ["P1", "P2", "P3"]
    held_up.session.close()
