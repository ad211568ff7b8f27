"""``georibbon compare``: figures, page, refusals."""

import json
import re

import pytest

from georibbon.cli import main


@pytest.fixture(scope="module")
def surface(small_capture, tmp_path_factory):
    """The dome's surface as a mesh file, in millimetres."""
    path = tmp_path_factory.mktemp("surface") / "dome.stl"
    assert main(["reconstruct", str(small_capture), "--surface", str(path)]) == 0
    return path


def test_a_recording_lies_on_its_own_surface(small_capture, surface, capsys):
    assert main(["compare", str(small_capture), str(surface)]) == 0
    told = capsys.readouterr().out
    assert "dome from dome.stl" in told
    assert "rms 0.000 mm" in told
    assert "100.0 % of the area within 0.5 mm; 100.0 % is covered" in told
    assert len(re.findall(r"^P\d .*good", told, re.MULTILINE)) == 3


def test_json_and_report_say_the_same(small_capture, surface, tmp_path, capsys):
    page, data = tmp_path / "c.html", tmp_path / "c.json"
    words = ["compare", str(small_capture), str(surface), "--align", "--tolerance", "0.1"]
    assert main([*words, "--json", "--report", str(page), "--report", str(data)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads(data.read_text(encoding="utf-8"))
    assert told["deviation"]["tolerance_mm"] == 0.1
    assert told["aligned"]["turned_deg"] < 0.01
    assert "laid onto the other first" in page.read_text(encoding="utf-8")


def test_a_report_as_pdf(small_capture, surface, tmp_path, capsys):
    path = tmp_path / "c.pdf"
    assert main(["compare", str(small_capture), str(surface), "--report", str(path)]) == 0
    assert path.read_bytes().startswith(b"%PDF-")
    assert f"written: {path}" in capsys.readouterr().out


def test_alignment_is_told(small_capture, surface, capsys):
    assert main(["compare", str(small_capture), str(surface), "--align"]) == 0
    assert "laid onto it first: turned 0.0" in capsys.readouterr().out


def test_a_wrong_unit_has_nothing_in_common_or_lies_far(small_capture, surface, capsys):
    assert main(["compare", str(small_capture), str(surface), "--unit", "in"]) == 0
    assert "rms 0.000 mm" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["{surface}", "{recording}"], "a mesh file is SECOND"),
        (["{recording}", "{recording}", "--unit", "mm"], "--unit is of a mesh file"),
        (["{recording}", "nowhere"], "no such folder or file"),
        (["{recording}", "{surface}", "--report", "c.txt"], "expected .html or .pdf or .json"),
    ],
)
def test_refusals_are_one_sentence(small_capture, surface, words, found, capsys):
    places = {"surface": surface, "recording": small_capture}
    assert main(["compare", *(word.format(**places) for word in words)]) == 2
    told = capsys.readouterr().err
    assert found in told
    assert told.count("\n") == 1
