"""Curves out of CSV files: what is written is read back, and nothing hostile breaks it."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from georibbon.errors import CurvesError
from georibbon.export.curves import write_strips
from georibbon.geometry.frames import Strip
from georibbon.session import curves_file
from georibbon.session.curves_file import read_curves

HEADER = "pass,s,x,y,z,nx,ny,nz,sigma,kind\n"
ROWS = "P1,0,1,2,3,0,0,1,0.1,pass\nP1,1,1,3,3,0,0,1,0.2,pass\nT1,0,4,2,3,0,0.5,1,,tie\n"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("curves") / "curves.csv"


def read(place, text, unit="m"):
    """What is read of a text, or of bytes."""
    place.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return read_curves(place, unit)


def refused(place, text):
    """The one sentence that refuses a text, without the file's name."""
    with pytest.raises(CurvesError) as found:
        read(place, text)
    message = str(found.value)
    assert message.startswith(str(place))
    assert "\n" not in message
    return message.removeprefix(str(place))


def same(one, other):
    """Whether two files hold the same curves."""
    assert len(one.curves) == len(other.curves)
    for a, b in zip(one.curves, other.curves, strict=True):
        assert (a.name, a.kind) == (b.name, b.kind)
        for name in ("s", "points", "normals", "sigma"):
            x, y = getattr(a, name), getattr(b, name)
            assert (x is None) == (y is None)
            if x is not None:
                np.testing.assert_allclose(x, y, rtol=1e-12)


def test_what_each_column_says(place):
    first, tie = read(place, HEADER + ROWS).curves
    assert (first.name, first.kind, tie.name, tie.kind) == ("P1", "pass", "T1", "tie")
    np.testing.assert_array_equal(first.points, [[1, 2, 3], [1, 3, 3]])
    np.testing.assert_array_equal(first.s, [0, 1])
    np.testing.assert_array_equal(first.sigma, [0.1, 0.2])
    np.testing.assert_array_equal(tie.normals, [[0, 0.5, 1]])
    assert tie.sigma is None


def test_columns_may_come_in_any_order_and_writing(place):
    lines = [line.split(",") for line in (HEADER + ROWS).splitlines()]
    order = np.random.default_rng(0).permutation(len(lines[0]))
    usual = read(place, HEADER + ROWS)
    for separator in (",", ";", "\t"):
        rows = [
            [line[k] if line[k] in ("P1", "T1") else f" {line[k]} " for k in order]
            for line in lines
        ]
        text = "\r\n".join(separator.join(row) for row in rows).upper()
        same(read(place, b"\xef\xbb\xbf" + text.encode()), usual)


def test_decimal_commas(place):
    text = (HEADER + ROWS).replace(",", ";").replace("0.", "0,")
    same(read(place, text), read(place, HEADER + ROWS))
    assert "number is expected" in refused(place, "x\ty\tz\n1,2,3\t4\t5\n")


@pytest.mark.parametrize(
    ("unit", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)]
)
def test_lengths_are_in_the_unit_and_normals_are_not(place, unit, metres):
    usual, other = read(place, HEADER + ROWS), read(place, HEADER + ROWS, unit)
    for a, b in zip(usual.curves, other.curves, strict=True):
        np.testing.assert_allclose(b.points, metres * a.points)
        np.testing.assert_allclose(b.s, metres * a.s)
        np.testing.assert_allclose(b.normals, a.normals)
    np.testing.assert_allclose(other.curves[0].sigma, metres * usual.curves[0].sigma)


def test_points_alone_are_enough(place):
    (curve,) = read(place, "x,y,z\n1,2,3\n4,5,6\n").curves
    assert (curve.name, curve.kind) == ("C1", "pass")
    assert curve.s is curve.normals is curve.sigma is None


def test_blank_lines_part_curves_that_have_no_names(place):
    text = "\n\nx,y,z\n\n1,2,3\n4,5,6\n\n ,,\n7,8,9\n1,1,1\n2,2,2\n\n"
    found = read(place, text).curves
    assert [(one.name, len(one.points)) for one in found] == [("C1", 2), ("C2", 3)]
    named = "pass,x,y,z\nA,1,2,3\n\nA,4,5,6\n\nB,7,8,9\n"
    assert [(one.name, len(one.points)) for one in read(place, named).curves] == [
        ("A", 2),
        ("B", 1),
    ]


def test_names_are_kept_exactly(place):
    text = 'pass,x,y,z\n"a ""b"", c",1,2,3\n  left ,1,2,3\nRöhre 7%,4,5,6\n'
    assert [one.name for one in read(place, text).curves] == ['a "b", c', "  left ", "Röhre 7%"]


def test_other_columns_are_left_with_a_notice_tangents_without(place):
    text = "x,y,z,tx,ty,tz,colour,when,\n1,2,3,1,0,0,red,now,\n"
    (notice,) = read(place, text).notices
    assert notice.code == "columns-ignored"
    assert '"colour", "when" of' in notice.message
    assert read(place, HEADER + ROWS).notices == ()
    many = "x,y,z," + ",".join("abcdefgh") + "\n" + "1," * 10 + "1\n"
    assert "and 3 more" in read(place, many).notices[0].message


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no column x, y, z"),
        ("\n\n", "no column x, y, z"),
        ("1,2,3\n4,5,6\n", "line 1 has no column x, y, z; a header line"),
        ("pass,x,y\nA,1,2\n", "no column z"),
        ("x,y,z,x\n1,2,3,4\n", "the column x twice"),
        ("x,y,z,nx,ny\n1,2,3,4,5\n", "nx, ny alone"),
        ("x,y,z\n", "no point below its header"),
        ("pass,x,y,z\nA,1,2,3\nA,1,2\n", "line 3 has 3 fields of 4"),
        ("x,y,z\n0,5,1,5,2,5\n", "line 2 has 6 fields under a header of 3; decimal commas need"),
        ("\nx,y,z,,\n1,2,3,a,b\n1,2,3,,,c", "line 4 has 6 fields under a header of 5"),
        ("pass,x,y,z\n,1,2,3\n", "line 2: the curve is called"),
        ("pass,x,y,z\nA\u202eB,1,2,3\n", "printable"),
        ("pass,x,y,z\n" + "A" * 201 + ",1,2,3\n", "1 to 200"),
        ("pass,x,y,z\nA,1,2,3\nB,1,2,3\nA,1,2,3\n", 'line 4: "A" begins again'),
        ("x,y,z\n1,2,three\n", 'line 2, z: "three" is found, a number'),
        ("x,y,z\n1,nan,3\n", 'line 2, y: "nan"'),
        ("x,y,z\n1,2,inf\n", 'line 2, z: "inf"'),
        ("x,y,z\n1,2,1_0\n", 'line 2, z: "1_0"'),
        ("x,y,z\n1,2,\n", "line 2, z"),
        ("x,y,z\n1,2,1e300\n", "line 2, z: \"1e300\" is out of all bounds"),
        ("x,y,z\n1,2,1e999\n", "out of all bounds"),
        ("x,y,z,sigma\n1,2,3,-1\n", "sigma is below 0"),
        ("x,y,z,s\n1,2,3,0\n1,2,4,\n", 'line 3 leaves out what other points of "C1" have'),
        ("x,y,z,nx,ny,nz\n1,2,3,0,,1\n", "line 2, ny"),
        ("x,y,z,kind\n1,2,3,curve\n", 'line 2: "C1" is of the kind "curve"'),
        ("x,y,z,kind\n1,2,3,tie\n1,2,4,pass\n", 'line 3: "C1" changes its kind'),
        ('pass,x,y,z\n"A,1,2,3\n', "line 2 cannot be read"),
        ('pass,x,y,z\n"A"B,1,2,3\n', "line 2 cannot be read"),
        ("pass,x,y,z\n" + "A" * 200_000 + ",1,2,3\n", "cannot be read"),
        ("x,y,z" + "," * 1000 + "\n1,2,3\n", "line 1 has 1003 columns, at most 1000"),
        ("x,y,z\n1,2,3" + "," * 1000 + "\n", "line 2 has 1003 columns"),
        ("x,y,z\n1,2,3" + "," * 2_000_000 + "\n", "line 2 has 2000006 characters, at most"),
        (b"x,y,z\n1,2,3\n\xff\xfe,1,2\n", "line 3: this is not UTF-8"),
        (b"PK\x03\x04\x00\x00\x9c", "line 1: this is not UTF-8"),
    ],
)  # fmt: skip
def test_what_is_no_such_file_is_refused_with_its_place(place, text, told):
    assert told in refused(place, text)


def test_what_is_too_large_is_refused(place, monkeypatch):
    monkeypatch.setattr(curves_file, "MAX_POINTS", 5)
    monkeypatch.setattr(curves_file, "MAX_CURVES", 3)
    row = "{},1,2,3\n"
    assert len(read(place, "pass,x,y,z\n" + row.format("A") * 5).curves) == 1
    assert "more than 5 points" in refused(place, "pass,x,y,z\n" + row.format("A") * 6)
    assert "more than 3 curves" in refused(place, "pass,x,y,z\n" + "".join(map(row.format, "ABCD")))
    monkeypatch.setattr(curves_file, "MAX_BYTES", 20)
    assert "more than 20 bytes" in refused(place, "x,y,z\n" + "1,2,3\n" * 5)


def test_what_is_no_file_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.csv"):
        with pytest.raises(CurvesError, match=re.escape(str(path))):
            read_curves(path)


characters = st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"])
names = st.text(characters, min_size=1, max_size=20).filter(
    lambda name: name.strip() and name.isprintable()
)
numbers = st.floats(-1e4, 1e4)


@st.composite
def strips(draw):
    """A name, a kind, a strip of any numbers, and its sigma or none."""
    count = draw(st.integers(1, 6))
    table = draw(arrays.arrays(float, (count, 13), elements=numbers))
    frames = table[:, 4:].reshape(count, 3, 3)
    sigma = draw(st.none() | arrays.arrays(float, count, elements=st.floats(0, 10)))
    return draw(st.sampled_from(["pass", "tie"])), Strip(table[:, 0], table[:, 1:4], frames), sigma


@given(st.dictionaries(names, strips(), min_size=1, max_size=4))
def test_what_is_written_is_read_back(place, written):
    curves = [(name, *rest) for name, rest in written.items()]
    write_strips(curves, place)
    found = read_curves(place)
    assert found.notices == ()
    assert [(one.name, one.kind) for one in found.curves] == [one[:2] for one in curves]
    for one, (_, _, strip, sigma) in zip(found.curves, curves, strict=True):
        for a, b in ((one.s, strip.s), (one.points, strip.points), (one.normals, strip.normals)):
            np.testing.assert_allclose(a, b, rtol=1e-9)
        assert (one.sigma is None) == (sigma is None)
        if sigma is not None:
            np.testing.assert_allclose(one.sigma, sigma, rtol=1e-9)


WORDS = ["x", "y", "z", "s", "nx", "pass", "kind", "1", "2.5", "-3e2", "A", "tie", "nan", "é"]
SIGNS = [*',;\t\n" ', "\r\n", "\x00"]


@given(st.lists(st.sampled_from(WORDS + SIGNS), max_size=60))
def test_any_text_is_read_or_refused(place, parts):
    try:
        found = read(place, "x,y,z" + "".join(parts))
    except CurvesError:
        return
    assert all(np.isfinite(one.points).all() for one in found.curves)


@given(st.binary(max_size=200))
def test_no_bytes_are_a_table_of_curves_by_chance(place, data):
    refused(place, data)
