"""The CSV files of counts: the fast way, the careful way, and every defect named."""

import csv
import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made import frames

from georibbon.errors import RecordingError
from georibbon.session import counts
from georibbon.session.counts import format_csv, parse_csv

COLUMNS = ("A1x", "A1y", "A1z")
HEAD = "t,A1x,A1y,A1z\n"


def parse(text):
    return parse_csv(text.encode(), COLUMNS, "p1.csv")


@given(frames(3))
def test_what_is_formatted_is_parsed_to_the_last_bit(made):
    back = parse_csv(format_csv(made, COLUMNS), COLUMNS, "p1.csv")
    assert np.array_equal(back.t, made.t)
    assert np.array_equal(back.counts, made.counts, equal_nan=True)


FIELDS = st.one_of(
    st.integers(-40000, 40000).map(str),
    st.sampled_from(["", "-0", "007", "-", "--1", "1-", "+5", " 6 ", "1.5", "1e3", "nan", "9" * 25,
                     "-9999999999", "-09999999999", "0x1", "1_0", "٣"]),
)  # fmt: skip


@given(st.lists(st.tuples(st.sampled_from(["0", "0.5", "1e0", "2", ""]), FIELDS, FIELDS, FIELDS)))
def test_the_fast_way_and_the_careful_way_agree(rows):
    lines = [",".join(row).encode() for row in rows]
    fast = counts._parse_fast(lines, 3) if lines else None
    if fast is not None:
        slow = counts._parse_slow(lines, COLUMNS, "p1.csv")
        assert np.array_equal(fast[0], slow[0])
        assert np.array_equal(fast[1], slow[1], equal_nan=True)


@given(st.lists(st.lists(st.integers(-40000, 40000), min_size=3, max_size=3), min_size=1))
def test_plain_numbers_are_those_that_the_csv_module_reads(rows):
    text = HEAD + "".join(f"{i},{','.join(map(str, row))}\n" for i, row in enumerate(rows))
    expected = [list(map(int, row[1:])) for row in list(csv.reader(io.StringIO(text)))[1:]]
    assert parse(text).counts.tolist() == expected


def test_an_empty_field_is_a_lost_value_anywhere():
    found = parse(HEAD + "0,,,\n1,,5,\n2,4,,6\n").counts
    expected = [[np.nan] * 3, [np.nan, 5, np.nan], [4, np.nan, 6]]
    assert np.array_equal(found, expected, equal_nan=True)


def test_signs_spaces_and_minus_zero_are_tolerated():
    found = parse("t , A1x,A1y,A1z\n 0.5 ,+5, -7\t, -0\n")
    assert found.t.tolist() == [0.5]
    assert found.counts.tolist() == [[5, -7, 0]]
    assert not np.signbit(found.counts[0, 2])


def test_the_value_that_means_lost_on_the_wire_is_a_count_here():
    assert parse(HEAD + "0,-32768,1,2\n").counts[0, 0] == -32768


DEFECTS = {
    "empty": ("", "p1.csv: the file is empty"),
    "only lines": ("\n\n", "p1.csv: the file is empty"),
    "header only": (HEAD, "a header and no frame"),
    "no t": ("A1x,A1y,A1z\n1,2,3\n", 'line 1: the first column is "A1x"; "t"'),
    "column missing": ("t,A1x,A1z\n0,1,2\n", "the column A1y is missing (the ribbon has 3 columns"),
    "columns missing": ("t,A1x\n0,1\n", "the columns A1y, A1z are missing"),
    "column misspelt": ("t,A1x,A1Y,A1z\n0,1,2,3\n", 'A1y is missing, and "A1Y" is not one'),
    "column too many": ("t,A1x,A1y,A1z,Q\n0,1,2,3,4\n", 'the column "Q" is not one'),
    "column twice": ("t,A1x,A1y,A1z,A1z\n0,1,2,3,4\n", 'the column "A1z" is there twice'),
    "order": ("t,A1x,A1z,A1y\n0,1,2,3\n", "column 3 is A1z where A1y is expected"),
    "semicolons": ("t;A1x;A1y;A1z\n0;1;2;3\n", "not separated by commas"),
    "row short": (HEAD + "0,1,2,3\n1,1,2\n", "line 3: 3 instead of 4 fields"),
    "row long": (HEAD + "0,1,2,3,4\n", "line 2: 5 instead of 4 fields"),
    "blank line": (HEAD + "0,1,2,3\n\n1,1,2,3\n", "line 3: 1 instead of 4 fields"),
    "fraction": (HEAD + "0,1,1.5,3\n", 'line 2, column A1y: "1.5" is no whole number'),
    "power": (HEAD + "0,1,2,1e3\n", 'line 2, column A1z: "1e3"'),
    "word": (HEAD + "0,x,2,3\n", 'line 2, column A1x: "x"'),
    "nan": (HEAD + "0,nan,2,3\n", 'line 2, column A1x: "nan"'),
    "lone minus": (HEAD + "0,1,-,3\n", 'line 2, column A1y: "-"'),
    "not a digit of ours": (HEAD + "0,1,٣,3\n", "line 2, column A1y"),
    "too large": (HEAD + "0,1,2147483648,3\n", "line 2, column A1y: 2147483648 is out of range"),
    "far too large": (HEAD + "0,1," + "9" * 25 + ",3\n", "line 2, column A1y"),
    "without end": (HEAD + "0,1," + "9" * 99 + ",3\n", "line 2, column A1y"),
    "no time": (HEAD + ",1,2,3\n", 'line 2, column t: "" is no number of seconds'),
    "time no number": (HEAD + "now,1,2,3\n", 'line 2, column t: "now"'),
    "time not finite": (HEAD + "inf,1,2,3\n", 'line 2, column t: "inf"'),
    "time infinite": (HEAD + "1e999,1,2,3\n", "line 2, column t: inf"),
    "times infinite": (HEAD + "1e999,1,2,3\n1e999,1,2,3\n", "line 2, column t: inf"),
    "time standing": (HEAD + "0,1,2,3\n0,1,2,3\n", "line 3, column t: 0.0, the one before 0.0"),
    "time back": (HEAD + "1,1,2,3\n2,1,2,3\n1.5,1,2,3\n", "line 4, column t: 1.5"),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_refused_with_line_and_column(name):
    text, words = DEFECTS[name]
    with pytest.raises(RecordingError) as caught:
        parse(text)
    assert str(caught.value).startswith("p1.csv")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_many_missing_columns_are_not_all_listed():
    columns = tuple(f"M{i}x" for i in range(99))
    with pytest.raises(RecordingError, match="M0x, M1x, M2x, M3x, M4x and others are missing"):
        parse_csv(b"t,Q\n0,1\n", columns, "p1.csv")


def test_a_header_that_is_not_utf8_is_refused():
    with pytest.raises(RecordingError, match="line 1: the header is not UTF-8"):
        parse_csv(b"t,A\xff\n0,1\n", COLUMNS, "p1.csv")


@given(st.binary(max_size=60))
def test_any_bytes_are_refused_or_read_and_never_a_fault(data):
    for body in (data, HEAD.encode() + data):
        try:
            found = parse_csv(body, COLUMNS, "p1.csv")
        except RecordingError:
            continue
        assert found.counts.shape == (found.t.size, 3)
