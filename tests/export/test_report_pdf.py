"""The report as PDF: the same words as the page, and the same bytes for the same result."""

import re
import zlib
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from reportlab.platypus import KeepTogether, Paragraph, Table

import synthetic
from georibbon.export import comparison_pdf, figures, pdf
from georibbon.export.comparison import Other, compare, comparison_data
from georibbon.export.comparison_pdf import comparison_story
from georibbon.export.pdf_pages import plain, table, text, use_fonts
from georibbon.export.report import report_data, report_html, write_report
from georibbon.notices import Notice

RESULT = synthetic.reconstruction()
WHEN = datetime(2026, 3, 4, 5, 6, tzinfo=UTC)
HOSTILE = "</para><font color='red'><img src='/etc/passwd'/>&amp;$x$\n\x00ünï日\U0001f600"


DRAWN = figures.plan_figure(RESULT, "png")


@pytest.fixture(autouse=True)
def one_drawing(monkeypatch):
    """One drawing in the place of all, which are other tests' matter."""
    monkeypatch.setattr(pdf, "scene_picture", lambda _result, _size: DRAWN)
    monkeypatch.setattr(comparison_pdf, "deviation_picture", lambda _comparison, _first: DRAWN)
    for name in ("plan_figure", "profiles_figure", "residuals_figure"):
        monkeypatch.setattr(pdf.figures, name, lambda _result, _form="svg": DRAWN)


def data_of(result):
    return report_data(result, source="bonnet", unit="mm", files=("a.stl", "b.obj"))


def pages_of(result, **words):
    return pdf.report_pdf(result, data_of(result), **{"title": "Bonnet", "created": WHEN, **words})


def words_in(flowables):
    """All texts of paragraphs, in tables too."""
    found = []
    for one in flowables:
        if isinstance(one, Paragraph):
            found.append(one.getPlainText())
        elif isinstance(one, Table):
            found += words_in(cell for row in one._cellvalues for cell in row)
        elif isinstance(one, list | tuple):
            found += words_in(one)
        elif isinstance(one, KeepTogether):
            found += words_in(one._content)
    return found


def test_everything_that_the_page_says_stands_in_the_pdf():
    weighed = replace(RESULT.passes[0], weight=3.0, sensors_off=("A05",), trim=(0.01, 0.02))
    result = replace(RESULT, passes=(weighed, *RESULT.passes[1:]))
    data = data_of(result)
    html = report_html(result, data, title="Bonnet", created=WHEN)
    body = re.sub(r"<style>.*?</style>|<title>.*?</title>|<[^>]+>", " ", html, flags=re.DOTALL)
    on_page = set(re.findall(r"[\w.]+", body.replace("&#39;", "'")))
    story = pdf.report_story(result, data, "Bonnet", "2026-03-04 05:06+00:00")
    in_pdf = set(re.findall(r"[\w.]+", " ".join(words_in(story))))
    missing = {word for word in on_page if word.strip(".").lower() not in lowered(in_pdf)}
    assert not missing - {"05", "06", "00", "2026"}


def lowered(words):
    return {word.strip(".").lower() for word in words}


def test_the_same_result_gives_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.undo()  # with all its drawings
    paths = [tmp_path / "one.pdf", tmp_path / "two.pdf"]
    for path in paths:
        write_report(RESULT, path, source="bonnet", unit="mm", title="Bonnet", created=WHEN)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].read_bytes().startswith(b"%PDF-")


def test_every_page_has_its_number_and_there_are_pictures():
    data = pages_of(RESULT)
    count = len(re.findall(rb"/Type /Page\b", data))
    assert count >= 2
    assert b"/Subtype /Image" in data
    assert b"/JavaScript" not in data
    assert b"/URI" not in data


def test_names_are_text_and_never_markup():
    first = replace(RESULT.passes[0], name=HOSTILE, sensors_ignored=(HOSTILE,))
    hostile = replace(
        RESULT,
        passes=(first, *RESULT.passes[1:]),
        notices=(Notice("code", HOSTILE, HOSTILE, HOSTILE),),
        ribbon=replace(RESULT.ribbon, id=HOSTILE),
    )
    story = pdf.report_story(hostile, data_of(hostile), HOSTILE, "now")
    shown = [words for words in words_in(story) if "passwd" in words]
    assert len(shown) >= 5
    assert all("<img src='/etc/passwd'/>&amp;$x$□□ünï□" in words for words in shown)
    assert pages_of(hostile, title=HOSTILE).startswith(b"%PDF-")


@pytest.mark.parametrize("length", [200, 20_000])
def test_words_without_end_are_broken_and_go_over_pages(length):
    notices = (Notice("code", "x" * length, "P" * 500),)
    assert pages_of(replace(RESULT, notices=notices)).startswith(b"%PDF-")


def test_without_surface_quality_or_survey_it_still_is_a_report():
    bare = replace(
        synthetic.reconstruction(with_surface=False),
        survey=(),
        notices=(),
        heading_sigma=None,
        calibration=replace(RESULT.calibration, quality=None),
    )
    told = " ".join(words_in(pdf.report_story(bare, data_of(bare), "bare", "now")))
    assert "Passes in space" in told
    assert "No mark, distance or crossing was given." in told
    assert "came without quality figures" in told
    assert "taken, not measured" in told
    assert pages_of(bare).startswith(b"%PDF-")


def test_signs_that_the_font_lacks_are_boxes():
    use_fonts()
    assert plain("a日\x07b") == "a□□b"
    assert text("1 < 2 & 3").getPlainText() == "1 < 2 & 3"


def test_the_head_of_a_table_is_on_every_page_it_goes_over():
    use_fonts()
    long = table([("Name", "left"), ("Value", "right")], [("a", "1")] * 200, (1, 1))
    parts = long.split(400, 300)
    assert len(parts) > 1
    assert all(words_in([part])[:2] == ["Name", "Value"] for part in parts)


def test_drawings_as_pictures_are_the_same_for_the_same_result(monkeypatch):
    monkeypatch.undo()
    one, two = (figures.profiles_figure(RESULT, "png") for _ in range(2))
    assert one == two
    assert one.startswith(b"\x89PNG")
    assert zlib.crc32(one) != zlib.crc32(figures.plan_figure(RESULT, "png"))


def test_a_comparison_says_what_its_page_says():
    other = Other("other <b>", RESULT.surface.mesh, replace(RESULT, passes=RESULT.passes[1:]))
    found = compare(RESULT, "one", other, aligned=True)
    data = comparison_data(found, RESULT)
    story = comparison_story(found, RESULT, data, "one from other <b>", "now")
    told = " ".join(words_in(story))
    assert "one from other <b>" in told
    assert "laid onto the other first: turned 0.000°" in told
    assert "Root mean square 0.000 mm" in told
    assert "Covered by the other 100.0 %" in told
    assert "P1 ✔ good" in told
    assert "– – –" in told


def test_a_comparison_with_nothing_in_common_says_so():
    mesh = RESULT.surface.mesh
    found = compare(RESULT, "one", Other("far", replace(mesh, vertices=mesh.vertices + 9.0)))
    data = comparison_data(found, RESULT)
    story = comparison_story(found, RESULT, data, "one", "now")
    assert "The two have no place in common." in words_in(story)
