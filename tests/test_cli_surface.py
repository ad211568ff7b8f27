"""`georibbon surface`."""

import csv
import json
import shutil

import numpy as np
import pytest

import refusing
from georibbon.cli import main
from georibbon.export.curves import write_strips
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.reference import Bonnet

S = np.linspace(0.0, 0.6, 61)
NORMALS = ("nx", "ny", "nz")


@pytest.fixture(scope="module")
def curves(tmp_path_factory):
    """Four passes over a bonnet and a tie across them, as Georibbon writes them."""
    path = tmp_path_factory.mktemp("curves") / "curves.csv"
    passes = [
        (f"P{k + 1}", "pass", geodesic(Bonnet(), (0.1, y), (1.0, 0.0, 0.0), S - 0.3))
        for k, y in enumerate((-0.15, -0.05, 0.05, 0.15))
    ]
    tie = ("T1", "tie", geodesic(Bonnet(), (0.12, 0.0), (0.0, 1.0, 0.0), S[:41] - 0.2))
    write_strips([(*one, None) for one in (*passes, tie)], path)
    return path


@pytest.fixture(scope="module")
def reconstructed(small_capture, tmp_path_factory):
    """A folder with the curves and the surface of the small capture."""
    folder = tmp_path_factory.mktemp("reconstructed")
    words = ["--curves", str(folder / "c.csv"), "--surface", str(folder / "r.obj")]
    assert main(["reconstruct", str(small_capture), *words]) == 0
    return folder


def lay(*words, capsys=None):
    """What the command prints."""
    assert main(["surface", *map(str, words)]) == 0
    return capsys.readouterr().out if capsys else ""


def refused(*words, capsys):
    return refusing.refused(["surface", *words], capsys)


def vertices(obj):
    """(n, 3) millimetres."""
    lines = obj.read_text(encoding="ascii").splitlines()
    return np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)


def rewritten(source, target, without=(), noise=0.0, scale=1.0):
    """The file without some columns, its points moved at random, in another unit."""
    rng = np.random.default_rng(1)
    with source.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name not in without]
    with target.open("w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, names, extrasaction="ignore", delimiter=";")
        out.writeheader()
        for row in rows:
            for name in ("s", "x", "y", "z"):
                moved = noise * rng.normal() if name != "s" else 0.0
                row[name] = repr(scale * (float(row[name]) + moved))
            out.writerow(row)
    return target


def test_it_gives_the_surface_that_reconstruct_gives(reconstructed, capsys):
    told = lay(reconstructed / "c.csv", "--surface", reconstructed / "s.obj", capsys=capsys)
    again, first = vertices(reconstructed / "s.obj"), vertices(reconstructed / "r.obj")
    np.testing.assert_allclose(again, first, atol=2e-4)
    assert told.count("normals measured") == 3
    assert "notice" not in told


def height_misses(obj):
    """(n,) mm that vertices lie above or below the bonnet."""
    x, y, z = (1e-3 * vertices(obj)).T
    zero = np.zeros_like(x)
    return 1e3 * (z - Bonnet().height(x, y).z - zero)


@pytest.mark.parametrize(
    ("without", "noise", "most"),
    [
        ((), 0.0, 0.1),
        (NORMALS, 0.0, 0.1),
        ((*NORMALS, "s", "kind"), 1e-5, 0.4),
        ((*NORMALS, "s"), 1e-4, 1.0),
    ],
)
def test_it_finds_what_the_file_leaves_out(curves, tmp_path, without, noise, most, capsys):
    source = rewritten(curves, tmp_path / "some.csv", without, noise)
    if "kind" in without:  # the tie would be a pass
        text = source.read_text(encoding="utf-8").splitlines(keepends=True)
        source.write_text("".join(line for line in text if not line.startswith("T1")))
    told = lay(source, "--surface", tmp_path / "s.obj", capsys=capsys)
    assert np.sqrt(np.mean(height_misses(tmp_path / "s.obj") ** 2)) < most
    assert ("normals found (doubled-angle)" in told) == ("nx" in without)
    assert ("points smoothed over" in told) == (noise > 0.0)
    assert ("notice: side-taken" in told) == ("nx" in without)
    assert "check" not in told.replace("checks passed", "")


def test_other_units(curves, tmp_path, capsys):
    source = rewritten(curves, tmp_path / "mm.csv", ("sigma",), scale=1e3)
    lay(source, "--curves-unit=mm", "--unit=m", "--surface", tmp_path / "m.obj")
    lay(curves, "--surface", tmp_path / "mm.obj")
    np.testing.assert_allclose(
        1e3 * vertices(tmp_path / "m.obj"), vertices(tmp_path / "mm.obj"), atol=1e-3
    )
    assert "say the unit" in refused(source, capsys=capsys)


def test_all_outputs(curves, tmp_path, capsys):
    words = ["--surface", tmp_path / "s.stl", "--surface", tmp_path / "s.ply"]
    words += ["--curves", tmp_path / "out.csv", "--report", tmp_path / "s.json"]
    told = lay(curves, *words, "--picture", tmp_path / "s.png", capsys=capsys)
    written = {"s.stl", "s.ply", "out.csv", "s.json", "s.png"}
    assert {path.name for path in tmp_path.iterdir()} == written
    assert told.count("written: ") == 5
    report = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in report["curves"]] == ["P1", "P2", "P3", "P4", "T1"]
    assert report["curves"][0]["length_m"] == pytest.approx(0.6)
    assert report["curves"][4]["kind"] == "tie"
    assert {check["code"] for check in report["surface"]["checks"]} >= {
        "fold",
        "tear",
        "heading-drift",
    }
    assert report["quality"] == "good"
    assert set(report["files"]) == written


def test_the_curves_as_laid_can_be_laid_again(curves, tmp_path):
    rough = rewritten(curves, tmp_path / "rough.csv", (*NORMALS, "s"), 1e-5)
    lay(rough, "--curves", tmp_path / "smooth.csv", "--surface", tmp_path / "one.obj")
    cuts = ["--position-cut=0", "--normal-cut=0"]
    lay(tmp_path / "smooth.csv", *cuts, "--surface", tmp_path / "two.obj")
    np.testing.assert_allclose(
        vertices(tmp_path / "two.obj"), vertices(tmp_path / "one.obj"), atol=0.06
    )


def test_the_rules_and_cuts_that_are_asked_for(curves, tmp_path, capsys):
    told = lay(
        curves, "--normals=spline", "--normal-cut=80", "--position-cut=15", "--report",
        tmp_path / "s.json", capsys=capsys,
    )  # fmt: skip
    assert told.count("normals found (spline) over 80 mm, points smoothed over 15 mm") == 5
    report = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))
    assert {one["normals"] for one in report["curves"]} == {"spline"}
    assert {one["position_cut_mm"] for one in report["curves"]} == {15.0}
    plain = lay(curves, "--normal-cut=0", "--position-cut=0", capsys=capsys)
    assert plain.count("normals measured\n") == 5


def test_the_surfaces_settings_count(curves, tmp_path):
    words = ["--surface", tmp_path / "s.obj", "--report", tmp_path / "s.json"]
    lay(curves, *words, "--thickness=2", "--interior=g2", "--tolerance=0.5")
    report = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))
    assert report["settings"]["interior"] == "g2"
    assert report["settings"]["thickness"] == 0.002
    assert report["surface"]["solid_triangles"] > 2 * report["surface"]["triangles"]


def test_a_tie_counts_where_cells_are_wanted(curves, capsys):
    assert " cell" not in lay(curves, capsys=capsys)
    plain = lay(curves, "--interior=g1", capsys=capsys)
    with_cells = lay(curves, "--cells", capsys=capsys)
    checks = [int(text.split(" checks")[0].split()[-1]) for text in (plain, with_cells)]
    assert checks[1] > checks[0]


def test_a_stretch_that_tells_no_normal_is_told(tmp_path, capsys):
    x = np.linspace(0.0, 1.0, 51)
    z = 0.3 * np.maximum(x - 0.6, 0.0) ** 2
    rows = [
        f"{name},{a},{y},{b}"
        for name, y in (("A", 0), ("B", 0.1))
        for a, b in zip(x, z, strict=True)
    ]
    source = tmp_path / "bent.csv"
    source.write_text("pass,x,y,z,colour\n" + "\n".join(rows), encoding="utf-8")
    told = lay(source, capsys=capsys)
    assert (
        "notice: normals-unsure (A): the curve is too straight to tell its normals over 0 to"
        in told
    )
    assert "notice: columns-ignored: " in told


def test_what_is_refused(curves, tmp_path, capsys):
    out = ["--surface", tmp_path / "s.stl"]
    for text, expected in (
        ("x,y,z\n0,0,0\n1,0,0\n2,0,1\n3,0,1\n", "1 of 1 curve is a pass, at least 2"),
        (
            "pass,x,y,z\nP7,0,0,0\nP7,0,0,0\nP7,2,0,1\nP7,3,0,1\nP8,0,1,0\n",
            "P7: its points 1 and 2 are the same",
        ),
        ("pass,x,y,z\nP7,0,0,0\nP8,0,1,0\n", "P7: it has 1 point, at least 4"),
        ("x,y\n1,2\n", "no column z"),
    ):
        source = tmp_path / "bad.csv"
        source.write_text(text, encoding="utf-8")
        assert expected in refused(source, *out, capsys=capsys)
    for words, expected in (
        (["--report", tmp_path / "r.html"], "written as .json"),
        (["--surface", tmp_path / "s.xyz"], "expected .stl"),
        (["--normal-cut=-1"], "0 mm or more"),
        (["--normal-cut=1e9"], "from 0 to 10000 mm"),
        (["--normals=nice"], "invalid choice"),
        (["--curves", curves], "this is an input"),
        (["--thickness=0.0001"], "thickness"),
    ):
        assert expected in refused(curves, *words, capsys=capsys)
    assert "missing" in refused(tmp_path / "none.csv", capsys=capsys)
    (tmp_path / "bad.csv").unlink()
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_left_where_one_output_fails(curves, tmp_path, capsys):
    far = tmp_path / "gone"
    told = refused(
        curves, "--surface", tmp_path / "s.stl", "--curves", far / "c.csv", capsys=capsys
    )
    assert str(far) in told
    assert list(tmp_path.iterdir()) == []


def test_the_input_stays_as_it_is(curves, tmp_path):
    copy = tmp_path / "copy.csv"
    shutil.copy(curves, copy)
    lay(copy, "--report", tmp_path / "r.json")
    assert copy.read_bytes() == curves.read_bytes()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--angles=5,5,5,5"], "--angles is for --direction angles"),
        (["--angles=5,5,5,5", "--direction=chord"], "--angles is for --direction angles"),
        (["--interior=g2", "--lengths=criterion1"], "--lengths has no effect here, as --interior"),
        (
            ["--interior=g2", "--direction=chord"],
            "--direction has no effect here, as --interior g2",
        ),
        (["--interior=c1-lines", "--direction=chord"], "as --interior c1-lines takes its place"),
        (["--interior=c1-lines", "--lengths=criterion4"], "as --interior c1-lines takes its place"),
        (["--lengths=criterion4", "--direction=section"], "as --lengths criterion4 takes its"),
    ],
)
def test_what_another_word_takes_the_place_of_is_refused(curves, tmp_path, words, named, capsys):
    told = refused(curves, f"--surface={tmp_path / 'a.stl'}", *words, capsys=capsys)
    assert named in told
    assert list(tmp_path.iterdir()) == []


def test_angles_may_begin_below_zero(curves, tmp_path, capsys):
    words = [curves, "--direction", "angles", "--angles"]
    lay(*words, "-20,-20,-20,-20", "--report", tmp_path / "a.json", capsys=capsys)
    settings = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["settings"]
    assert settings["angles"] == [-20.0] * 4
