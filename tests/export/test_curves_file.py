"""The curves' CSV, read back with the csv module as a spreadsheet or script would."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import synthetic
from georibbon.errors import ExportError
from georibbon.export.curves import write_curves


def read(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def result():
    return synthetic.reconstruction(with_surface=False)


def test_every_point_of_every_pass_and_tie_comes_back(result, tmp_path):
    write_curves(result, tmp_path / "curves.csv")
    rows = read(tmp_path / "curves.csv")
    for fitted in result.passes:
        mine = [row for row in rows if row["pass"] == fitted.name]
        assert {row["kind"] for row in mine} == {fitted.kind}
        strip = fitted.strip
        for columns, expected in {
            ("x", "y", "z"): strip.points,
            ("nx", "ny", "nz"): strip.normals,
            ("tx", "ty", "tz"): strip.tangents,
            ("s",): strip.s[:, None],
        }.items():
            got = np.array([[float(row[c]) for c in columns] for row in mine])
            assert np.allclose(got, expected, rtol=0, atol=1e-9)


def test_sigma_is_the_root_of_the_covariances_trace(result, tmp_path):
    write_curves(result, tmp_path / "curves.csv")
    got = [float(row["sigma"]) for row in read(tmp_path / "curves.csv")]
    expected = [np.sqrt(c[0, 0] + c[1, 1] + c[2, 2]) for p in result.passes for c in p.covariance]
    assert np.allclose(got, expected, rtol=1e-9)


def test_the_header_begins_with_the_promised_columns(result, tmp_path):
    write_curves(result, tmp_path / "curves.csv")
    header = (tmp_path / "curves.csv").read_text().splitlines()[0]
    assert header.startswith("pass,s,x,y,z,nx,ny,nz,sigma,")


SHORT = synthetic.fitted("P", "pass", synthetic.strip_over(np.arange(3.0), np.zeros(3)), 0, None)
EMPTY = replace(synthetic.reconstruction(with_surface=False), passes=())


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.text(st.characters(codec="utf-8"), min_size=1, max_size=30))
def test_any_name_comes_back_exactly(tmp_path, name):
    named = replace(EMPTY, passes=(replace(SHORT, name=name),))
    write_curves(named, tmp_path / "curves.csv")
    assert {row["pass"] for row in read(tmp_path / "curves.csv")} == {name}


def test_another_ending_is_refused(result, tmp_path):
    with pytest.raises(ExportError, match=r"expected \.csv for curves"):
        write_curves(result, tmp_path / "curves.txt")
    assert list(tmp_path.iterdir()) == []
