"""How a pass lies beside its neighbour: laws of angle and distance, and where passes are put."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lying import curve, lying

from georibbon.capture.beside import advise, compare
from georibbon.capture.placement import (
    Known,
    Lone,
    lone_curve,
    neighbour_of,
    object_axes,
    place_all,
    place_live,
)
from georibbon.fitting.grid import integrate_frames
from georibbon.geometry.frames import Strip
from georibbon.ribbon import Readings
from georibbon.rotations import about_z, exp

S = np.linspace(0.0, 0.96, 65)
ORDER = ("P1", "P2", "P3")


def straight(at=(0.0, 0.0, 0.0), turn=0.0):
    frame = about_z(turn)
    return Strip(S, np.asarray(at) + S[:, None] * frame[:, 0], np.tile(frame, (len(S), 1, 1)))


def arch(across, radius=0.4):
    """A pass over a lying cylinder, square to its axis, at a place along the axis."""
    angle = S / radius - 1.2
    zero = np.zeros_like(S)
    points = np.stack([radius * np.sin(angle), zero + across, radius * np.cos(angle)], axis=1)
    tau = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
    normal = np.stack([np.sin(angle), zero, np.cos(angle)], axis=1)
    return Strip(S, points, np.stack([tau, np.cross(normal, tau), normal], axis=2))


def moved(strip, rotation, shift):
    return Strip(strip.s, strip.points @ rotation.T + shift, rotation @ strip.frames)


@pytest.mark.parametrize("make", [lambda y: straight((0.0, y, 0.0)), arch])
def test_parallel_passes_are_parallel_and_as_far_as_they_are(make):
    found = compare(make(0.1), make(0.0), "P1")
    assert found.angle_rms == pytest.approx(0.0, abs=1e-9)
    assert (found.least, found.mean, found.most) == pytest.approx((0.1, 0.1, 0.1))
    assert (found.side, found.crossing, found.neighbour) == (1.0, None, "P1")
    assert compare(make(0.0), make(0.1), "P2").side == -1.0
    assert advise(found, 0.1) == ()


@given(st.floats(-0.3, 0.3))
def test_a_pass_turned_by_an_angle_shows_it(angle):
    found = compare(straight((0.0, 0.5, 0.0), angle), straight(), "P1")
    assert found.turn == pytest.approx(angle, abs=1e-9)
    assert found.angle_rms == pytest.approx(abs(angle), abs=1e-9)
    assert found.angle_worst == pytest.approx(angle, abs=1e-9)


@given(
    st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
    st.floats(-0.05, 0.05),
)
def test_a_rigid_motion_of_both_changes_nothing(turn, shift, angle):
    live, other = straight((0.02, 0.11, 0.0), angle), arch(0.0)
    rotation = exp(np.array(turn))
    before = compare(live, other, "P1")
    after = compare(moved(live, rotation, shift), moved(other, rotation, shift), "P1")
    for name in ("turn", "angle_rms", "least", "mean", "most", "side"):
        assert getattr(after, name) == pytest.approx(getattr(before, name), abs=1e-6)


def test_a_pass_that_runs_against_its_neighbour_is_parallel_to_it():
    found = compare(straight((0.0, 0.1, 0.0)).reversed(), straight(), "P1")
    assert found.angle_rms == pytest.approx(0.0, abs=1e-9)
    assert found.mean == pytest.approx(0.1)


def test_a_crossing_is_seen_where_it_is():
    angle = 0.2
    found = compare(straight((0.0, 0.05, 0.0), -angle), straight(), "P1")
    assert found.crossing == pytest.approx(0.05 / np.sin(angle), abs=0.003)
    assert found.least == 0.0
    assert [hint.kind for hint in advise(found, 0.1)] == ["crosses"]


def test_passes_one_behind_the_other_are_not_beside_each_other():
    assert compare(straight((2.0, 0.0, 0.0)), straight(), "P1") is None


@pytest.mark.parametrize(
    ("angle", "kind", "where"),
    [(0.06, "turn-right", "end"), (-0.06, "turn-left", "end")],
)
def test_a_pass_that_is_turned_is_to_be_turned_back(angle, kind, where):
    found = compare(straight((0.0, 0.1, 0.0), angle), straight(), "P1")
    first = advise(found, 0.1)[0]
    assert (first.kind, first.where) == (kind, where)
    assert first.amount == pytest.approx(abs(angle))


@pytest.mark.parametrize(
    ("away", "kinds"),
    [(0.069, ["near"]), (0.071, []), (0.139, []), (0.141, ["far"])],
)
def test_from_seven_tenths_to_seven_fifths_of_the_spacing_it_lies_well(away, kinds):
    found = compare(straight((0.0, away, 0.0)), straight(), "P1")
    assert [one.kind for one in advise(found, 0.1)] == kinds


def test_too_near_and_too_far_say_where_and_by_how_much():
    near = advise(compare(straight((0.0, 0.05, 0.0)), straight(), "P1"), 0.1)
    assert [(one.kind, one.where) for one in near] == [("near", "all")]
    assert near[0].amount == pytest.approx(0.05)
    far = advise(compare(straight((0.0, 0.2, 0.0)), straight(), "P1"), 0.1)
    assert [(one.kind, one.where) for one in far] == [("far", "all")]
    assert far[0].amount == pytest.approx(0.1)
    end = advise(compare(straight((0.0, 0.1, 0.0), -0.05), straight(), "P1"), 0.1)
    assert [(one.kind, one.where) for one in end] == [("turn-left", "end"), ("near", "end")]
    assert end[1].amount == pytest.approx(0.96 * np.sin(0.05), abs=0.003)


def lone(name, strip, kind="pass"):
    return Lone(name, kind, strip)


def test_passes_are_laid_at_the_planned_spacing_to_the_left():
    placed = place_all([lone(name, straight((9.0, 9.0, 9.0))) for name in ORDER], ORDER, 0.1,
                       Known())  # fmt: skip
    starts = [placed[name].points[0] for name in ORDER]
    assert np.allclose(starts, [[0, 0, 0], [0, 0.1, 0], [0, 0.2, 0]])


def test_a_pass_that_is_missing_keeps_its_place():
    placed = place_all([lone("P1", straight()), lone("P3", straight())], ORDER, 0.1, Known())
    assert np.allclose(placed["P3"].points[0], [0, 0.2, 0])
    live = place_live(lone("P2", straight()), ORDER, placed, 0.1, Known())
    assert np.allclose(live.points[0], [0, 0.1, 0])
    backwards = place_live(lone("P2", straight().reversed()), ORDER, placed, 0.1, Known())
    assert np.allclose(backwards.points[-1], [0, 0.1, 0])


def test_what_is_known_lies_there_and_all_else_beside_it():
    heading = 0.7
    there = straight((1.0, 2.0, 0.5))
    known = Known({"P1": there}, heading)
    magnetic = straight(turn=heading)
    placed = place_all([lone("P1", magnetic), lone("P2", magnetic)], ORDER, 0.1, known)
    assert placed["P1"] is there
    found = compare(placed["P2"], placed["P1"], "P1")
    assert found.turn == pytest.approx(0.0, abs=1e-9)
    assert found.mean == pytest.approx(0.1)
    again = place_live(lone("P1", magnetic), ORDER, placed, 0.1, known)
    assert np.allclose(again.points, there.points)


def test_a_marked_start_is_where_it_was_marked():
    start = np.array([1.0, 2.0, 3.0])
    known = Known({"P1": straight()}, 0.0, {"P2": start})
    live = place_live(lone("P2", straight()), ORDER, {"P1": straight()}, 0.1, known)
    assert np.allclose(live.points[0], start)


def test_ties_cross_the_middle_pass_with_their_middle():
    across = straight(turn=np.pi / 2)
    taken = [*(lone(name, straight()) for name in ORDER), lone("T1", across, "tie")]
    placed = place_all(taken, ORDER, 0.1, Known())
    gap = np.linalg.norm(placed["T1"].points - placed["P2"].points[32], axis=1)
    assert gap.min() == pytest.approx(0.0, abs=1e-9)
    assert S[gap.argmin()] == pytest.approx(0.48)


def test_the_neighbour_is_the_nearest_that_is_there():
    there = {"P1": 0, "P3": 0}
    assert neighbour_of("P2", ORDER, there) == "P1"
    assert neighbour_of("P1", ORDER, there) == "P3"
    assert neighbour_of("P9", ORDER, there) == "P3"
    assert neighbour_of("P1", ORDER, {"P1": 0}) is None


def test_a_taken_pass_has_its_curve():
    bench = lying(sensors=16)
    shape = curve(bench.grid)
    said = bench.counts(shape)
    found = lone_curve(
        bench.ribbon, bench.calibration, Readings(np.arange(3.0), np.tile(said, (3, 1)))
    )
    frames = integrate_frames(bench.grid, shape)[0]
    assert np.abs(found.strip.frames - frames).max() < 0.05
    nothing = Readings(np.arange(3.0), np.full((3, len(said)), np.nan))
    assert lone_curve(bench.ribbon, bench.calibration, nothing) is None


def test_the_objects_axes_go_with_the_first_pass():
    turn = exp(np.array([0.3, -0.8, 1.9]))
    assert np.allclose(object_axes([moved(straight(), turn, 1.0), straight()]), turn)
    assert np.allclose(object_axes([]), np.eye(3))
