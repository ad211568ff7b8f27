"""The survey as rows: what is written comes back, and every residual finds its entry."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.capture.plan import PlannedLayout, check_survey
from georibbon.capture.survey_rows import TABLES, make_entry, proposed, survey_rows
from georibbon.reconstruction import SurveyResidual
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import virtual_ribbon

RIBBON = virtual_ribbon(RibbonSettings(sensors=16, length=0.48))
PASSES, TIES = ("P1", "P2", "P3"), ("T1", "T2")

at = st.floats(0.0, 0.48)
sigmas = st.floats(1e-4, 1e-2)
entries = st.one_of(
    st.tuples(st.just("mark"), st.tuples(st.sampled_from(PASSES)), st.tuples(at),
              st.tuples(*3 * [st.floats(-1.0, 1.0)]), sigmas),
    st.tuples(st.just("distance"), st.just(("P1", "P2")), st.tuples(at, at),
              st.tuples(st.floats(0.01, 1.0)), sigmas),
    st.tuples(st.just("crossing"), st.just(("P2", "T1")), st.tuples(at, at), st.just(()), sigmas),
)  # fmt: skip


def tables_of(parts):
    tables = {table: [] for table in TABLES}
    for one in parts:
        tables[one[0]].append(make_entry(*one))
    return tables


@given(st.lists(entries, max_size=8))
def test_rows_say_what_the_entries_say(parts):
    tables = tables_of(parts)
    rows = survey_rows(tables)
    assert tables_of([(r.table, r.passes, r.at, r.values, r.sigma) for r in rows]) == tables
    assert all(row.entry() == tables[row.table][row.number - 1] for row in rows)
    assert all(row.grade == "open" for row in rows)
    check_survey(tables, RIBBON, (*PASSES, *TIES), "the survey")


@given(st.lists(entries, max_size=8), st.data())
def test_every_residual_finds_its_entry_also_where_some_are_missing(parts, data):
    tables = tables_of(parts)
    rows = survey_rows(tables)
    kept = [row for row in rows if data.draw(st.booleans())]
    residuals = [
        SurveyResidual(row.table, row.passes, row.at, 0.001 * k, row.sigma, float(k))
        for k, row in enumerate(kept, start=1)
    ]
    found = survey_rows(tables, residuals)
    told = [row.residual for row in found if row.residual is not None]
    assert sorted(told) == [one.residual for one in residuals]
    for row, one in zip([row for row in found if row.residual is not None], told, strict=True):
        same = [r for r in residuals if r.residual == one]
        assert (same[0].kind, same[0].passes, same[0].at) == (row.table, row.passes, row.at)


@pytest.mark.parametrize(("ratio", "grade"), [(0.5, "fits"), (4.0, "suspect"), (9.0, "outlier")])
def test_an_entry_that_the_curves_miss_is_graded(ratio, grade):
    tables = tables_of([("mark", ("P1",), (0.1,), (0.0, 0.0, 0.0), 0.001)])
    residual = SurveyResidual("mark", ("P1",), (0.1,), 0.001 * ratio, 0.001, ratio)
    assert survey_rows(tables, [residual])[0].grade == grade


def test_a_changed_row_changes_that_alone():
    row = survey_rows(tables_of([("distance", ("P1", "P2"), (0.0, 0.1), (0.2,), 0.001)]))[0]
    assert row.entry(values=(0.3,)) == {
        "passes": ["P1", "P2"], "at": [0.0, 0.1], "distance": 0.3, "sigma": 0.001
    }  # fmt: skip


def test_what_the_plan_says_to_measure_is_proposed_once():
    layout = PlannedLayout(spacing=0.1, distances=2, distance_sigma=0.002)
    first = proposed(layout, 0.48, PASSES, TIES, {})
    assert [table for table, _ in first].count("distance") == 4
    crossings = [entry for table, entry in first if table == "crossing"]
    assert len(crossings) == 6
    middle = [one for one in crossings if one["passes"] == ["P2", "T1"]]
    assert middle[0]["at"][1] == pytest.approx(0.24)
    tables = {"distance": [], "crossing": [], "mark": []}
    for table, entry in first:
        tables[table].append(entry)
    check_survey(tables, RIBBON, (*PASSES, *TIES), "the survey")
    assert proposed(layout, 0.48, PASSES, TIES, tables) == ()


def test_a_crossing_beyond_the_ties_end_is_not_proposed():
    layout = PlannedLayout(spacing=0.3)
    found = proposed(layout, 0.48, ("P1", "P2", "P3"), ("T1",), {})
    assert [entry["passes"] for _, entry in found] == [["P2", "T1"]]
