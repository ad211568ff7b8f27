"""STEP and IGES files: read by the kernel again, and by a small reader of the text of our own."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from georibbon.errors import ExportError
from georibbon.export import cad
from georibbon.export.cad import CadFacts, plain_name, what_lacks, write_cad
from georibbon.export.mesh import UNITS
from georibbon.export.surface_files import in_words, require_cad, write_surface
from georibbon.geometry.one_spline import OneSpline, one_spline
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.surface import Surface, build_surface
from passes import passes

TOLERANCE = 1e-4
PER_METRE = {"mm": 1000.0, "cm": 100.0, "m": 1.0, "in": 1 / 0.0254}
STEP_UNIT = {
    "mm": "SI_UNIT(.MILLI.,.METRE.)",
    "cm": "SI_UNIT(.CENTI.,.METRE.)",
    "m": "SI_UNIT($,.METRE.)",
    "in": "CONVERSION_BASED_UNIT('INCH'",
}
IGES_UNIT = {"mm": "2,2HMM", "cm": "10,2HCM", "m": "6,1HM", "in": "1,4HINCH"}
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[ED][-+]?\d+)?")


@cache
def built(interior: str = "g1", thickness: float | None = None) -> Surface:
    strips = passes(Bonnet(), [(0.0, 0.0), (0.0, 0.1), (0.0, 0.2)], length=0.6, count=61)
    settings = SurfaceSettings(TOLERANCE, thickness, interior=interior)
    return build_surface(strips, "abc", settings)


@cache
def spline(interior: str = "g1") -> OneSpline:
    return one_spline(built(interior).plan.model, TOLERANCE)


def write(path, unit="mm", name="part", interior="g1") -> CadFacts:
    return write_cad(built(interior).plan.model, TOLERANCE, path, unit, name)


# What is in the files, read from their text


def entities(path) -> dict[str, str]:
    """STEP's entities by their numbers, without blanks."""
    data = path.read_text(encoding="ascii").partition("DATA;")[2]
    bare = re.sub(r"\s+(?=(?:[^']*'[^']*')*[^']*$)", "", data)
    return dict(one.split("=", 1) for one in bare.split(";") if one.startswith("#"))


def step_surface(path) -> tuple[np.ndarray, list[list[float]], list[list[int]]]:
    """The control points, knots and multiplicities of a STEP file's one B-spline surface."""
    every = entities(path)
    (surface,) = (text for text in every.values() if text.startswith("B_SPLINE_SURFACE_WITH"))
    rows = re.findall(r"\(((?:#\d+,?)+)\)", surface)
    points = [
        [[float(x) for x in NUMBER.findall(every[one].partition("(")[2])] for one in row.split(",")]
        for row in rows
    ]
    tail = surface[surface.rindex("#") :]
    lists = [text.split(",") for text in re.findall(r"\(([-+.\dE,]+)\)", tail)]
    times = [[int(one) for one in words] for words in lists[:2]]
    assert surface.startswith("B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(")
    assert ".F.,.F.,.F." in surface  # neither closed nor crossing itself
    return np.array(points), [[float(one) for one in words] for words in lists[2:]], times


def iges_surface(path) -> tuple[np.ndarray, list[float]]:
    """The control points and knots of an IGES file's one surface 128, and its head in one line."""
    lines = path.read_text(encoding="ascii").splitlines()
    text = "".join(line[:64].strip() for line in lines if line[72] == "P")
    (surface,) = (one for one in text.split(";") if one.startswith("128,"))
    numbers = [float(one) for one in surface.split(",")]
    k1, k2, m1, m2 = (int(one) for one in numbers[1:5])
    assert (m1, m2) == (3, 3)
    assert numbers[7] == 1  # polynomial: not rational
    knots = numbers[10 : 10 + k1 + k2 + 2 + m1 + m2 + 2]
    start = 10 + len(knots) + (k1 + 1) * (k2 + 1)
    assert set(numbers[10 + len(knots) : start]) == {1.0}
    points = np.array(numbers[start : start + 3 * (k1 + 1) * (k2 + 1)]).reshape(k2 + 1, k1 + 1, 3)
    return np.swapaxes(points, 0, 1), knots


def head_of(path) -> str:
    lines = path.read_text(encoding="ascii").splitlines()
    return "".join(line[:72] for line in lines if line[72:73] == "G")


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("ending", [".step", ".stp", ".STP"])
def test_a_step_file_holds_the_spline_in_its_unit(tmp_path, unit, ending):
    path = tmp_path / f"part{ending}"
    facts = write(path, unit)
    points, knots, times = step_surface(path)
    assert points.shape[:2] == facts.count == spline().count
    np.testing.assert_allclose(points, PER_METRE[unit] * spline().control, rtol=1e-11, atol=1e-12)
    for found, many, expected in zip(knots, times, spline().knots, strict=True):
        np.testing.assert_allclose(np.repeat(found, many), 1e3 * expected, rtol=1e-11, atol=1e-9)
    text = "".join(entities(path).values())
    assert STEP_UNIT[unit] in text
    assert text.count("ADVANCED_FACE(") == 1
    assert f"unit: {unit}" in path.read_text(encoding="ascii")


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("ending", [".igs", ".iges"])
def test_an_iges_file_holds_the_spline_in_its_unit(tmp_path, unit, ending):
    path = tmp_path / f"part{ending}"
    facts = write(path, unit)
    points, knots = iges_surface(path)
    assert points.shape[:2] == facts.count
    np.testing.assert_allclose(points, PER_METRE[unit] * spline().control, rtol=0, atol=2e-6)
    np.testing.assert_allclose(knots, 1e3 * np.concatenate(spline().knots), rtol=0, atol=1e-3)
    assert IGES_UNIT[unit] in head_of(path)


@pytest.mark.parametrize("ending", [".step", ".iges"])
def test_the_file_names_the_part_and_nobody(tmp_path, ending, monkeypatch):
    monkeypatch.setenv("LOGNAME", "somebody")
    path = tmp_path / f"a{ending}"
    for _ in range(2):  # the kernel would count the second
        write(path, name="Hood «2», Müller's; 50 %")
    text = path.read_text(encoding="ascii")
    name = "Hood -2- Muller-s- 50"
    assert name in text.replace("\n", "")
    assert f"{name} 2" not in text
    assert "Georibbon" in text
    assert "somebody" not in text
    assert "root" not in text
    assert str(tmp_path) not in text
    if ending == ".step":
        assert f"PRODUCT('{name}','{name}'" in text


def test_names_keep_what_both_formats_have():
    assert plain_name("part 7") == "part 7"
    assert plain_name("Tür/links\n") == "Tur-links"
    assert plain_name("面") == plain_name("  ") == plain_name("../..") == "surface"
    assert len(plain_name("x" * 500)) == 60
    assert re.fullmatch(r"[A-Za-z0-9 ._-]+", plain_name("'; DROP $1,2H\\X2\\00E9"))


# What is told of them


@pytest.mark.parametrize("ending", [".step", ".igs"])
@pytest.mark.parametrize("interior", ["g1", "c1-lines", "g2"])
def test_what_is_told_is_what_was_found(tmp_path, ending, interior):
    facts = write(tmp_path / f"part{ending}", interior=interior)
    own = spline(interior)
    assert (facts.deviation, facts.turn, facts.count) == (own.deviation, own.turn, own.count)
    assert facts.deviation <= TOLERANCE
    assert facts.smooth == (interior != "g1")
    assert facts.read_back < 1e-8
    told = in_words(facts)
    assert f"{facts.count[0]} × {facts.count[1]} control points, read back" in told
    assert ("corners in its lines" in told) == (interior == "g1")
    assert f"{1e3 * facts.deviation:.2g} mm" in told


def test_the_kernel_is_silent_and_leaves_nothing_beside(tmp_path, capfd):
    for name in ("a.step", "b.iges"):
        write(tmp_path / name)
    assert capfd.readouterr() == ("", "")
    assert {one.name for one in tmp_path.iterdir()} == {"a.step", "b.iges"}


# What cannot be


def test_what_is_read_back_wrong_is_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(cad._Kernel, "largest_distance", lambda *_: 2e-4)
    path = tmp_path / "part.step"
    path.write_text("mine")
    with pytest.raises(ExportError, match=r"part.step: .* lies 0.2 mm from the surface, so it was"):
        write(path)
    assert path.read_text() == "mine"
    assert [one.name for one in tmp_path.iterdir()] == ["part.step"]


@pytest.mark.parametrize("ending", [".step", ".igs"])
def test_another_surface_is_seen_when_it_is_read_back(tmp_path, ending):
    path = tmp_path / f"part{ending}"
    write(path)
    place = path.with_suffix(".step" if ending == ".step" else ".igs")
    kernel, own = cad._Kernel(path), spline()
    assert kernel.largest_distance(place, own) < 1e-8
    bent = own.control.copy()
    bent[3, 2] += [0.0, 0.0, 1e-4]
    other = OneSpline(bent, own.knots, own.seams)
    assert 1e-6 < kernel.largest_distance(place, other) < 1e-4


def test_without_the_kernel_it_is_told_how_to_get_it(tmp_path, monkeypatch):
    assert what_lacks() is None
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    assert "make cad" in what_lacks()  # the tests run in a working copy
    with pytest.raises(ExportError, match=r"part.step: STEP and IGES need the CAD kernel"):
        write(tmp_path / "part.step")
    with pytest.raises(ExportError, match="not installed"):
        require_cad(tmp_path / "part.igs", None)
    require_cad(tmp_path / "part.stl", None)
    monkeypatch.setattr("georibbon.__file__", str(tmp_path / "a" / "b" / "c.py"))
    assert what_lacks().endswith('-m pip install "georibbon[cad]"')
    assert list(tmp_path.iterdir()) == []


def test_a_kernel_that_cannot_be_loaded_is_told(tmp_path, monkeypatch):
    def missing(_name):
        raise ImportError("libGL.so.1: cannot open shared object file")

    monkeypatch.setattr(cad._Kernel, "_module", staticmethod(missing))
    with pytest.raises(ExportError, match=r"cannot be loaded \(libGL.so.1: .* libgl1"):
        write(tmp_path / "part.step")


def test_a_kernel_that_is_not_whole_is_told_with_what_installs_it(tmp_path, monkeypatch):
    def half(name):
        raise ModuleNotFoundError(f"No module named 'OCP.{name}'")

    monkeypatch.setattr(cad._Kernel, "_module", staticmethod(half))
    with pytest.raises(ExportError, match=r"not whole \(No module named .* anew: .*make cad"):
        require_cad(tmp_path / "part.step", None)


@pytest.mark.parametrize("ending", [".step", ".igs"])
def test_a_full_disk_is_not_blamed_on_the_surface(tmp_path, ending):
    kernel = cad._Kernel(tmp_path / "part")
    place = tmp_path / "nowhere" / f"surface{ending}"
    with pytest.raises(ExportError, match=r"temporary files, .*; make room there"):
        kernel.write(kernel.face(spline()), place, "mm", "part")


def test_what_the_kernel_throws_comes_in_a_sentence(tmp_path, monkeypatch):
    whole = cad.one_spline

    def torn(*words):
        spline = whole(*words)
        return replace(spline, knots=(spline.knots[0][::-1], spline.knots[1][:-1]))

    monkeypatch.setattr(cad, "one_spline", torn)
    with pytest.raises(ExportError, match=r"part.step: the CAD kernel does not take this surface"):
        write(tmp_path / "part.step")
    assert list(tmp_path.iterdir()) == []


def test_what_no_cad_file_can_be_of_is_refused(tmp_path):
    with pytest.raises(ExportError, match=r"expected .step or .stp or .igs or .iges"):
        write(tmp_path / "part.stl")
    with pytest.raises(ExportError, match=r"part.step: a thickness was asked for"):
        write_surface(built(thickness=2e-3), tmp_path / "part.step", "mm", "part")
    with pytest.raises(ExportError, match="a thickness was asked for"):
        require_cad(tmp_path / "part.step", 2e-3)
    mesh = Surface(built().mesh, 1.0, ())
    with pytest.raises(ExportError, match="triangles alone"):
        write_surface(mesh, tmp_path / "part.step", "mm", "part")
    with pytest.raises(ExportError, match=r"the folder .* does not exist"):
        write(tmp_path / "nowhere" / "part.step")
    assert list(tmp_path.iterdir()) == []


def test_a_surface_is_written_by_its_ending(tmp_path):
    for name in ("a.stl", "a.obj", "a.ply"):
        assert write_surface(built(), tmp_path / name, "mm", "part") is None
    facts = write_surface(built(), tmp_path / "a.step", "mm", "part")
    assert facts.deviation <= TOLERANCE
    assert len(list(tmp_path.iterdir())) == 4
