"""What a survey holds, what it leaves open, and what is then assumed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import both, constant, placed, ribbon, shape_of

from georibbon.errors import FitError
from georibbon.fitting.equations import (
    ACROSS_SIGMA,
    LEVEL_SIGMA,
    Pair,
    links,
    loose_assumptions,
    observations,
    read_survey,
    square_pairs,
    without_loose_ties,
)
from georibbon.fitting.grid import make_grid
from georibbon.fitting.placing import Curves
from georibbon.fitting.planning import FIXED, FREE, KNOWN_HEADING_SIGMA, make_plan
from georibbon.fitting.survey import AcrossSet, ChordSet, CrossingSet, DistanceSet, MarkSet
from georibbon.recording import Crossing, Distance, Mark, Pass, Recording, Workpiece
from georibbon.ribbon import Readings
from georibbon.rotations import about_z

RIBBON = ribbon(8)
GRID = make_grid(RIBBON)
LENGTH = float(GRID.nodes[-1])


def recorded(names="P1 P2 P3", **survey):
    """A recording whose readings do not matter."""
    nothing = Readings(np.zeros(1), np.zeros((1, len(RIBBON.columns))))
    passes = tuple(
        Pass(name, "tie" if name.startswith("T") else "pass", nothing) for name in names.split()
    )
    return Recording(RIBBON, (), passes, **survey)


def mark(name, at=0.0, position=(0.0, 0.0, 0.0)):
    return Mark(name, at, position, 5e-4)


def distance(one, other, at=0.0, length=0.1):
    return Distance((one, other), (at, at), length, 1e-3)


def crossing(one, other, at=(0.1, 0.2)):
    return Crossing((one, other), at, 1e-3)


# --- what is held ---


@pytest.mark.parametrize(
    "survey",
    [
        {"marks": tuple(mark(name) for name in ("P1", "P2", "P3"))},
        {"marks": (mark("P2"),), "distances": (distance("P1", "P2"), distance("P3", "P2"))},
        {"distances": (distance("P3", "P1"), distance("P2", "P3"))},
        {"crossings": (crossing("P1", "P2"), crossing("P2", "P3"))},
        {"crossings": (crossing("P1", "P2"),), "distances": (distance("P2", "P3"),)},
    ],
)
def test_every_pass_may_be_held_by_marks_distances_or_crossings(survey):
    held = read_survey(recorded(**survey))
    assert held.marked == ("marks" in survey)
    assert held.number == {"P1": 0, "P2": 1, "P3": 2}


def test_a_single_pass_needs_no_survey():
    assert read_survey(recorded("P1")).loose == ()


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        ({}, ["holds no pass to another", "[[mark]]", "[[distance]]", "[[crossing]]"]),
        ({"marks": (mark("P1"), mark("P3"))}, ["pass P2", "the marked passes"]),
        ({"marks": (mark("P1"),)}, ["passes P2, P3", "the marked passes"]),
        (
            {"marks": (mark("P1"),), "distances": (distance("P2", "P3"),)},
            ["passes P2, P3", "the marked passes"],
        ),
        ({"distances": (distance("P1", "P2"),)}, ["pass P3", "pass P1"]),
    ],
)
def test_passes_that_nothing_holds_are_named(survey, words):
    with pytest.raises(FitError) as caught:
        read_survey(recorded(**survey))
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "survey",
    [
        {"crossings": (crossing("P3", "P2"),)},
        {"distances": (distance("P2", "P3"), distance("P2", "P3", LENGTH))},
    ],
)
def test_where_the_first_pass_is_the_lost_one_it_is_named(survey):
    with pytest.raises(FitError, match="holds pass P1 to") as caught:
        read_survey(recorded(**survey))
    assert "no pass to another" not in str(caught.value)


def test_a_mark_on_a_pass_that_is_already_lost_names_only_the_lost():
    with pytest.raises(FitError, match=r"pass T1 .*marked passes"):
        read_survey(recorded("P1 P2 T1", marks=(mark("P1"), mark("P2"))))


edges = st.lists(
    st.tuples(
        st.sampled_from(["P1", "P2", "P3", "P4"]), st.sampled_from(["P1", "P2", "P3", "P4"])
    ).filter(lambda pair: pair[0] != pair[1]),
    max_size=6,
)


@given(edges, edges, st.randoms())
def test_what_is_held_does_not_depend_on_the_order(crossed, apart, random):
    crossings = [crossing(*pair) for pair in crossed]
    distances = [distance(*pair) for pair in apart]

    def outcome():
        try:
            survey = read_survey(
                recorded("P1 P2 P3 P4", crossings=tuple(crossings), distances=tuple(distances))
            )
        except FitError as error:
            return str(error)
        return sorted((pair.i, pair.j) for pair in survey.loose)

    first = outcome()
    random.shuffle(crossings)
    random.shuffle(distances)
    assert outcome() == first


def test_only_distances_that_alone_hold_a_pass_are_loose():
    survey = read_survey(
        recorded(
            "P1 P2 P3 P4",
            marks=(mark("P1"), mark("P2")),
            crossings=(crossing("P2", "P3"),),
            distances=(
                distance("P1", "P2"),
                distance("P1", "P3"),
                distance("P3", "P4", 0.0, 0.11),
                distance("P3", "P4", LENGTH, 0.12),
            ),
        )
    )
    assert survey.loose == (
        Pair(2, 3, (0.0, 0.0), 0.11),
        Pair(2, 3, (LENGTH, LENGTH), 0.12),
    )


# --- what cannot be ---


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        ({"distances": (distance("P1", "P2", 0.0, 100.0),)}, "100 m.*in metres"),
        (
            {"marks": (mark("P1"), mark("P1", 0.1, (0.2, 0.0, 0.0)))},
            "P1 at 0 m and of P1 at 0.1 m are 0.2 m apart, but only 0.1 m of ribbon",
        ),
        (
            {"marks": (mark("P1"), mark("P2", 0.0, (0.0, 150.0, 0.0)))},
            "P1 at 0 m and of P2 at 0 m are 150 m apart.*in metres",
        ),
    ],
)
def test_measurements_that_no_ribbon_allows_are_refused(survey, words):
    with pytest.raises(FitError, match=words):
        read_survey(recorded("P1 P2", **survey))


def test_a_slip_of_the_tape_is_no_reason_to_refuse():
    marks = (mark("P1"), mark("P1", 0.1, (0.115, 0.0, 0.0)), mark("P2"))
    assert read_survey(recorded("P1 P2", marks=marks)).marked


def test_ties_that_the_survey_nowhere_names_are_left_out_and_named():
    whole = recorded(
        "P1 T1 P2 T2", marks=(mark("P1"), mark("P2")), crossings=(crossing("P1", "T2"),)
    )
    kept, (notice,) = without_loose_ties(whole)
    assert [one.name for one in kept.passes] == ["P1", "P2", "T2"]
    assert (notice.code, notice.pass_name) == ("tie-left-out", "T1")
    assert without_loose_ties(kept) == (kept, ())
    marked = recorded("P1 T1", marks=(mark("P1"), mark("T1")))
    assert without_loose_ties(marked) == (marked, ())


# --- as equations ---


def test_measurements_become_equations_in_a_fixed_order():
    survey = read_survey(
        recorded(
            "P1 P2 T1",
            marks=(mark("P1", 0.1, (1.0, 2.0, 3.0)), mark("P2")),
            distances=(distance("P2", "P1", 0.2, 0.15),),
            crossings=(crossing("P1", "T1"), crossing("T1", "P2", (0.05, 0.06))),
        )
    )
    marks, distances, crossings = observations(survey)
    assert isinstance(marks, MarkSet)
    np.testing.assert_array_equal(marks.i, [0, 1])
    np.testing.assert_array_equal(marks.at, [0.1, 0.0])
    np.testing.assert_array_equal(marks.position[0], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(marks.sigma, 5e-4)
    assert isinstance(distances, DistanceSet)
    assert (distances.i[0], distances.j[0]) == (1, 0)
    assert distances.distance[0] == 0.15
    assert isinstance(crossings, CrossingSet)
    np.testing.assert_array_equal(crossings.i, [0, 2])
    np.testing.assert_array_equal(crossings.j, [2, 1])
    np.testing.assert_array_equal(crossings.at, [[0.1, 0.2], [0.05, 0.06]])


def test_an_empty_survey_has_no_equations():
    assert observations(read_survey(recorded("P1"))) == []
    assert loose_assumptions(()) == []


def test_loose_pairs_are_taken_to_lie_across_and_level():
    across, level = loose_assumptions((Pair(0, 1, (0.1, 0.2), 0.1), Pair(1, 2, (0.0, 0.0), 0.2)))
    assert isinstance(across, AcrossSet)
    assert isinstance(level, ChordSet)
    for one, sigma in ((across, ACROSS_SIGMA), (level, LEVEL_SIGMA)):
        np.testing.assert_array_equal(one.i, [0, 1])
        np.testing.assert_array_equal(one.j, [1, 2])
        np.testing.assert_array_equal(one.at, [[0.1, 0.2], [0.0, 0.0]])
        np.testing.assert_array_equal(one.sigma, sigma)
    np.testing.assert_array_equal(level.offset, 0.0)


def test_the_line_of_marks_leads_from_pass_to_pass_without_ties():
    survey = read_survey(
        recorded(
            "P1 T1 P2 P3",
            marks=(
                mark("P3", 0.0, (0.0, 0.5, 0.0)),
                mark("T1", 0.0, (0.1, 0.1, 0.1)),
                mark("P1", 0.02, (0.0, 0.0, 0.0)),
                mark("P2", 0.0, (0.3, 0.0, 0.4)),
            ),
        )
    )
    first, second = square_pairs(survey)
    assert (first.i, first.j, first.at) == (0, 2, (0.02, 0.0))
    assert first.distance == pytest.approx(0.5)
    assert (second.i, second.j) == (2, 3)


def test_the_line_leads_through_the_marks_at_the_most_alike_places():
    survey = read_survey(
        recorded(
            "P1 P2 P3",
            marks=(
                mark("P1", LENGTH, (0.2, 0.0, 0.0)),
                mark("P1", 0.03),
                mark("P2", 0.01, (0.0, 0.1, 0.0)),
                mark("P3", LENGTH, (0.2, 0.2, 0.0)),
            ),
        )
    )
    # Nothing of P3 was marked that could lie across from P2's mark.
    assert square_pairs(survey) == (Pair(0, 1, (0.03, 0.01), 0.1),)


def test_links_for_the_first_placing():
    survey = read_survey(
        recorded(
            "P1 P2 T1",
            distances=(distance("P1", "P2", 0.1, 0.2),),
            crossings=(crossing("P1", "T1"),),
        )
    )
    met, side, assumed, gauge = links(survey, (Pair(1, 2, (0.0, 0.3), 0.4),), -1.0)
    assert (met.i, met.s, met.j, met.t) == (0, 0.1, 2, 0.2)
    assert met.target == (0.0, 0.0, 0.0)
    assert (side.i, side.j, side.s, side.t, side.side) == (0, 1, 0.1, 0.1, -0.2)
    assert (assumed.i, assumed.j, assumed.s, assumed.t, assumed.side) == (1, 2, 0.0, 0.3, -0.4)
    assert (gauge.i, gauge.s, gauge.j, gauge.target) == (0, 0.0, None, (0.0, 0.0, 0.0))
    held = links(read_survey(recorded("P1", marks=(mark("P1", 0.1, (1.0, 0.0, 0.0)),))), (), 1.0)
    assert [(one.i, one.s, one.j, one.target) for one in held] == [(0, 0.1, None, (1.0, 0.0, 0.0))]


# --- the plan ---


def flat_curves(count, heading):
    """Straight passes along the workpiece's x axis, in magnetic axes."""
    turn = about_z(heading)
    shapes = both(*(shape_of(GRID, turn, constant(0.0), constant(0.0)) for _ in range(count)))
    here = placed(GRID, shapes, np.zeros((count, 3)))
    return Curves(GRID.nodes, np.arange(count), np.zeros(count), here.points, here.frames)


def starts(count, ends=False):
    out = [mark(f"P{k + 1}", 0.0, (0.0, 0.1 * k, 0.0)) for k in range(count)]
    if ends:
        out += [mark(f"P{k + 1}", LENGTH, (LENGTH, 0.1 * k, 0.0)) for k in range(count)]
    return tuple(out)


def test_marks_at_both_ends_need_no_assumption():
    plan = make_plan(recorded(marks=starts(3, ends=True)), flat_curves(3, 0.7))
    assert (plan.heading, plan.heading_sigma) == (None, FREE)
    assert plan.notices == ()
    assert plan.sides == (1.0,)
    (best,) = plan.placings(flat_curves(3, 0.7), 1.0)
    assert best.heading == pytest.approx(0.7, abs=1e-6)


def test_starts_alone_take_their_line_as_square_and_say_so():
    plan = make_plan(recorded(marks=starts(3)), flat_curves(3, 0.7))
    assert [notice.code for notice in plan.notices] == ["heading-assumed"]
    assert "square to the passes" in plan.notices[0].message
    assert [(pair.i, pair.j) for pair in plan.assumed] == [(0, 1), (1, 2)]
    assert plan.sides == (1.0, -1.0)
    left, right = (plan.placings(flat_curves(3, 0.7), side)[0] for side in plan.sides)
    assert left.heading == pytest.approx(0.7, abs=1e-4)
    assert abs(abs(right.heading - 0.7) - np.pi) < 1e-4


def test_a_single_mark_takes_the_axes_as_magnetic_and_says_so():
    plan = make_plan(recorded("P1", marks=(mark("P1"),)), flat_curves(1, 0.7))
    assert [notice.code for notice in plan.notices] == ["heading-assumed"]
    assert "magnetic east and north" in plan.notices[0].message
    assert (plan.heading, plan.heading_sigma) == (0.0, FIXED)
    assert plan.sides == (1.0,)


def test_a_heading_told_poorly_by_marks_contradicts_nobody():
    """Two marks 5 cm apart on one pass: 8 degrees at best."""
    marks = (mark("P1"), mark("P1", 0.05, (0.05 * np.cos(0.7), 0.05 * np.sin(0.7), 0.0)))
    plan = make_plan(recorded("P1", marks=marks), flat_curves(1, 0.0))
    assert [notice.code for notice in plan.notices] == ["heading-assumed"]
    assert plan.heading == 0.0


@pytest.mark.parametrize(("given", "right"), [(40.0, True), (43.0, True), (50.0, False)])
def test_marks_are_believed_where_a_told_heading_contradicts_them(given, right):
    """The marks say 40 degrees; rooms bend the field by 2 to 4."""
    marked = recorded(marks=starts(3, ends=True), workpiece=Workpiece(True, given))
    plan = make_plan(marked, flat_curves(3, np.radians(40.0)))
    if right:
        assert plan.notices == ()
        assert plan.heading == pytest.approx(np.radians(given))
        return
    assert [notice.code for notice in plan.notices] == ["heading-disagrees"]
    assert "is 50.0 degrees" in plan.notices[0].message
    assert "say 40.0" in plan.notices[0].message
    assert (plan.heading, plan.heading_sigma) == (None, FREE)


@pytest.mark.parametrize("given", [-179.0, 181.0])
def test_headings_are_compared_round_the_circle(given):
    marked = recorded(marks=starts(3, ends=True), workpiece=Workpiece(True, given))
    assert make_plan(marked, flat_curves(3, np.radians(180.0))).notices == ()


def test_starts_alone_cannot_contradict_a_told_heading():
    marked = recorded(marks=starts(3), workpiece=Workpiece(True, -100.0))
    plan = make_plan(marked, flat_curves(3, 0.7))
    assert plan.notices == ()
    assert plan.heading == pytest.approx(np.radians(-100.0))


def test_a_heading_that_was_told_is_taken():
    told = Workpiece(True, 40.0)
    plan = make_plan(recorded(marks=starts(3), workpiece=told), flat_curves(3, 0.7))
    assert plan.heading == pytest.approx(np.radians(40.0))
    assert plan.heading_sigma == KNOWN_HEADING_SIGMA
    assert plan.notices == ()
    unmarked = recorded("P1 P2", crossings=(crossing("P1", "P2"),), workpiece=told)
    plan = make_plan(unmarked, flat_curves(2, 0.7))
    assert (plan.heading, plan.heading_sigma) == (pytest.approx(np.radians(40.0)), FIXED)


@pytest.mark.parametrize("workpiece", [None, Workpiece(True, None)])
def test_without_marks_the_axes_are_magnetic(workpiece):
    plan = make_plan(
        recorded("P1 P2", crossings=(crossing("P1", "P2"),), workpiece=workpiece),
        flat_curves(2, 0.7),
    )
    assert (plan.heading, plan.heading_sigma) == (0.0, FIXED)
    assert plan.notices == ()


def test_distances_alone_assume_that_they_were_measured_across_and_say_so():
    apart = (distance("P1", "P2"), distance("P1", "P2", LENGTH), distance("P2", "P3"))
    plan = make_plan(recorded(distances=apart), flat_curves(3, 0.7))
    assert [notice.code for notice in plan.notices] == ["across-assumed"]
    assert "P1-P2, P2-P3" in plan.notices[0].message
    assert plan.sides == (1.0, -1.0)


def test_no_more_placings_are_tried_than_are_worth_it():
    curves = flat_curves(3, 0.0)
    twins = Curves(
        GRID.nodes,
        np.repeat(np.arange(3), 3),
        np.tile([0.0, 1.0, 2.0], 3),
        np.repeat(curves.points, 3, axis=0),
        np.repeat(curves.frames, 3, axis=0),
    )
    plan = make_plan(recorded(marks=starts(3, ends=True)), twins)
    assert len(plan.placings(twins, 1.0)) == 6
