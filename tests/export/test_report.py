"""The report: its JSON is always JSON, its page is whole, closed and safe."""

import base64
import hashlib
import json
import re
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import synthetic
from georibbon import __version__
from georibbon.errors import ExportError
from georibbon.export import figures
from georibbon.export.report import report_data, report_html, write_report
from georibbon.geometry.surface import Check
from georibbon.notices import Notice
from georibbon.reconstruction import Quality

RESULT = synthetic.reconstruction()
HOSTILE = "<script>alert('P')</script>$x_{2$\n\x00ünï日"
WHEN = datetime(2026, 3, 4, 5, 6, tzinfo=UTC)


def data_of(result, **words):
    return report_data(result, **{"source": "bonnet", "unit": "mm", **words})


def renamed(result, name):
    """The result with a name on everything that a person names."""
    first = replace(result.passes[0], name=name, sensors_ignored=(name,))
    survey = replace(result.survey[0], passes=(name,))
    return replace(
        result,
        passes=(first, *result.passes[1:]),
        survey=(survey,),
        notices=(Notice("code", name, name, name),),
        ribbon=replace(result.ribbon, id=name),
    )


class Page(HTMLParser):
    """Tags with their attributes, and the text outside of style."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def page():
    files = ("surface.stl",)
    return report_html(RESULT, data_of(RESULT, files=files), title="Bonnet", created=WHEN)


@pytest.fixture(scope="module")
def hostile_page():
    checks = (
        Check("fold", "pass", 1e-9, "mm", "P1-P2", "flat"),
        Check("gap", "fail", 2.0, "mm", "P1-P2", "a wide gap"),
        Check("fold", "pass", 0.25, "mm", "P4-P5", "flat"),
        Check("gap", "pass", float("nan"), "mm", "P2-P3", "no gap"),
    )
    surface = replace(RESULT.surface, checks=checks, solid=synthetic.mesh(3, 3))
    result = replace(renamed(RESULT, HOSTILE), surface=surface)
    return report_html(result, data_of(result, source=HOSTILE), created=WHEN)


def test_the_report_has_the_promised_names():
    data = data_of(RESULT)
    assert {"georibbon", "source", "method", "unit", "calibration", "passes", "survey"} <= set(data)
    assert {"surface", "notices"} <= set(data)
    assert {
        "name",
        "kind",
        "length_m",
        "position_sigma_mm",
        "residual_rms",
        "smoothing_mm",
        "sensors_ignored",
        "quality",
        "quality_reason",
    } <= set(data["passes"][0])
    assert {"area_m2", "triangles", "checks"} <= set(data["surface"])
    assert data["georibbon"] == __version__
    assert (data["source"], data["unit"], data["method"]) == ("bonnet", "mm", "ribbon")


def test_numbers_are_in_the_units_that_their_names_say():
    data, first = data_of(RESULT), RESULT.passes[0]
    got = data["passes"][0]
    trace = np.trace(first.covariance, axis1=1, axis2=2)
    assert got["position_sigma_mm"] == pytest.approx(1e3 * np.sqrt(trace.mean()), rel=1e-5)
    assert got["position_sigma_max_mm"] == pytest.approx(1e3 * np.sqrt(trace.max()), rel=1e-5)
    assert got["length_m"] == pytest.approx(first.strip.s[-1], rel=1e-5)
    assert got["smoothing_mm"] == pytest.approx(90.0)
    assert got["normal_sigma_deg"] == pytest.approx(0.2)
    assert data["survey"][0]["residual_mm"] == pytest.approx(
        1e3 * RESULT.survey[0].residual, rel=1e-5
    )
    assert data["heading"] == {"deg": pytest.approx(25.0), "sigma_deg": pytest.approx(0.2)}
    assert data["calibration"]["dip_deg"] == pytest.approx(np.degrees(1.152), rel=1e-5)
    assert data["calibration"]["sensors_ignored"] == [
        {"sensor": "M04", "reason": "it never changed in 16 poses"}
    ]


def test_a_thickened_surface_tells_its_solid():
    assert data_of(RESULT)["surface"]["solid_triangles"] is None
    solid = replace(RESULT, surface=replace(RESULT.surface, solid=synthetic.mesh(3, 3)))
    assert data_of(solid)["surface"]["solid_triangles"] == 8


def test_a_notice_names_pass_and_sensor_only_where_it_has_them():
    notices = {notice["code"]: notice for notice in data_of(RESULT)["notices"]}
    assert set(notices["sensor-dead"]) == {"code", "message", "sensor"}
    assert set(notices["field-disturbed"]) == {"code", "message", "pass"}
    assert set(notices["heading-assumed"]) == {"code", "message"}


def test_the_calibrations_notices_are_told_once():
    own = Notice("sensor-dead", "told by the calibration", None, "M04")
    calibration = replace(RESULT.calibration, notices=(own,))
    for notices in ((), (own,)):
        result = replace(RESULT, calibration=calibration, notices=notices)
        assert [n["message"] for n in data_of(result)["notices"]] == [own.message]


@pytest.mark.parametrize(
    ("passes", "checks", "expected"),
    [
        (("good", "good"), ("pass",), "good"),
        (("good", "acceptable"), ("pass",), "acceptable"),
        (("good", "good"), ("pass", "warn"), "acceptable"),
        (("acceptable", "good"), ("fail",), "redo"),
        (("redo", "good"), (), "redo"),
    ],
)
def test_the_verdict_is_the_worst_and_the_reasons_name_all_that_is_not_good(
    passes, checks, expected
):
    fitted = tuple(
        replace(RESULT.passes[0], name=f"P{i}", quality=Quality(verdict, f"why {i}"))
        for i, verdict in enumerate(passes)
    )
    found = tuple(Check("gap", verdict, 1.0, "mm", "P1-P2", "a gap") for verdict in checks)
    result = replace(RESULT, passes=fitted, surface=replace(RESULT.surface, checks=found))
    data = data_of(result)
    assert data["quality"] == expected
    bad = sum(v != "good" for v in passes) + sum(v != "pass" for v in checks)
    assert len(data["quality_reasons"]) == bad
    if bad:
        assert data["quality_reasons"][0].endswith(f"({expected})")


def test_one_reason_for_many_passes_is_one_sentence():
    fair = Quality("acceptable", "a sensor is ignored")
    many = tuple(replace(RESULT.passes[0], name=f"P{i}", quality=fair) for i in range(20))
    some = replace(RESULT, passes=many[:2], surface=None)
    assert data_of(some)["quality_reasons"] == ["P0, P1: a sensor is ignored (acceptable)"]
    (sentence,) = data_of(replace(some, passes=many))["quality_reasons"]
    assert "P7 and 12 more: " in sentence


def test_without_surface_calibration_quality_or_survey_it_still_is_a_report(tmp_path):
    calibration = replace(RESULT.calibration, quality=None)
    bare = replace(
        synthetic.reconstruction(with_surface=False), survey=(), calibration=calibration, notices=()
    )
    data = data_of(bare)
    assert data["surface"] is None
    assert data["calibration"]["quality"] is None
    write_report(bare, tmp_path / "report.html", source="bonnet", unit="m")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "No mark, distance or crossing was given" in text
    assert "came without quality figures" in text


@given(st.text(), st.floats(), st.floats())
def test_the_json_is_valid_whatever_the_words_and_numbers_are(name, number, other):
    """Lone surrogates stand for file names that are no UTF-8."""
    strip = replace(SHORT.strip, points=SHORT.strip.points * np.nan)
    odd = replace(
        SHORT, name=name, residual_rms=number, strip=strip, covariance=SHORT.covariance * other
    )
    result = replace(RESULT, passes=(odd,), notices=(Notice(name, name),))
    with np.errstate(all="ignore"):
        data = data_of(result, source=name + "\udc80")
    text = json.dumps(data, allow_nan=False, ensure_ascii=False)
    assert json.loads(text.encode("utf-8")) == data


SHORT = synthetic.fitted(
    "P", "pass", synthetic.strip_over(np.arange(3.0), np.zeros(3)), 0, Quality("good", "fine")
)


def test_numbers_that_are_not_finite_become_null(tmp_path):
    odd = replace(RESULT.passes[0], residual_rms=float("nan"), smoothing=float("inf"))
    result = replace(RESULT, passes=(odd,))
    write_report(result, tmp_path / "report.json", source="bonnet", unit="mm")
    got = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["passes"][0]
    assert got["residual_rms"] is None
    assert got["smoothing_mm"] is None


def test_the_same_result_gives_the_same_json(tmp_path):
    for name in ("one.json", "two.json"):
        write_report(RESULT, tmp_path / name, source="bonnet", unit="mm")
    assert (tmp_path / "one.json").read_bytes() == (tmp_path / "two.json").read_bytes()


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(ExportError, match=r"\.json or \.html or \.pdf"):
        write_report(RESULT, tmp_path / "report.txt", source="bonnet", unit="mm")
    assert list(tmp_path.iterdir()) == []


def test_the_json_loads_no_vtk_no_plotting_and_no_templates(tmp_path):
    code = (
        "import sys, synthetic; from pathlib import Path\n"
        "from georibbon.export.report import write_report\n"
        "write_report(synthetic.reconstruction(), Path(sys.argv[1]), source='s', unit='mm')\n"
        "print([m for m in ('vtkmodules', 'matplotlib', 'jinja2') if m in sys.modules])"
    )
    tests = str(Path(synthetic.__file__).parent)
    run = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "report.json")],
        cwd=tests, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert run.stdout.strip() == "[]"


def test_the_page_fetches_nothing_and_runs_nothing(page, hostile_page):
    for text in (page, hostile_page):
        parsed = Page(text)
        assert not parsed.all("script")
        assert not parsed.all("link")
        assert all(image["src"].startswith("data:image/") for image in parsed.all("img"))
        assert not [a for _, attributes in parsed.tags for a in attributes if a.startswith("on")]
        assert "http://" not in text
        assert "https://" not in text


def test_the_pages_policy_allows_its_own_style_and_data_images_only(page):
    policy = next(
        meta["content"]
        for meta in Page(page).all("meta")
        if meta.get("http-equiv") == "Content-Security-Policy"
    )
    style = re.search(r"<style>(.*?)</style>", page, re.DOTALL).group(1)
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    assert policy.startswith("default-src 'none'; img-src data:; ")
    assert f"style-src 'sha256-{digest}';" in policy
    assert not [a for _, attributes in Page(page).tags for a in attributes if a == "style"]


def test_names_are_text_and_never_markup(hostile_page):
    assert "<script" not in hostile_page
    words = " ".join(Page(hostile_page).words)
    assert words.count("<script>alert('P')</script>") >= 6


def test_every_picture_is_there_and_described(page):
    images = Page(page).all("img")
    kinds = [image["src"][5:].split(";")[0] for image in images]
    assert kinds == ["image/png"] + ["image/svg+xml"] * 3
    assert all(len(image["alt"]) > 30 for image in images)
    for image in images[1:]:
        svg = base64.b64decode(image["src"].split(",")[1])
        assert ElementTree.fromstring(svg).tag.endswith("svg")  # noqa: S314  our own drawing


def test_the_page_says_what_a_technician_files(page):
    words = " ".join(" ".join(Page(page).words).split())
    for said in ("Bonnet", "2026-03-04", "GR-0011", "surface.stl", "acceptable", "heading-drift"):
        assert said in words
    for fitted in RESULT.passes:
        assert fitted.name in words
    for notice in RESULT.notices:
        assert notice.message in words


def test_checks_that_pass_are_one_line_a_kind_and_each_other_has_its_own(hostile_page):
    rows = re.findall(r'<tr><td class="code">(\S+)</td><td class="where(">.*?)</tr>', hostile_page)
    assert [code for code, _ in rows] == ["gap", "fold", "gap"]
    assert "a wide gap" in rows[0][1]
    assert ">P1-P2 to P4-P5<" in rows[1][1]
    assert ">0 to 0.25 mm<" in rows[1][1]
    assert ">–<" in rows[2][1]
    assert "closed, 8 triangles" in hostile_page


def test_a_verdict_is_told_in_words_beside_its_colour(page):
    badges = re.findall(r'<span class="badge (\w+)">.*?</span> (\w+)</span>', page)
    assert len(badges) == 1 + len(RESULT.surface.checks) + len(RESULT.passes)
    assert {"good", "acceptable", "pass", "warn"} == {word for _, word in badges}
    assert all(colour == word for colour, word in badges)


@pytest.mark.parametrize(
    "draw", [figures.plan_figure, figures.profiles_figure, figures.residuals_figure]
)
def test_drawings_are_the_same_for_the_same_result_and_bear_any_name(draw):
    odd = renamed(RESULT, HOSTILE)
    assert draw(odd) == draw(odd)
    assert draw(renamed(RESULT, "_hidden" * 50)).startswith(b"<?xml")


def test_a_pass_without_any_residual_and_many_passes_can_be_drawn():
    blank = replace(RESULT.passes[0], residuals=RESULT.passes[0].residuals * np.nan)
    many = replace(RESULT, passes=(blank,) + RESULT.passes * 2)
    for draw in (figures.plan_figure, figures.profiles_figure, figures.residuals_figure):
        assert b"</svg>" in draw(many)


@given(st.text())
def test_a_name_in_a_drawing_is_one_short_line(name):
    label = figures.name_label(name)
    assert len(label) <= 16
    assert label.isprintable()


def test_what_was_chosen_of_the_passes_is_told_and_nothing_where_nothing_was():
    first, second, *others = RESULT.passes
    chosen = {"weight": 2.5, "trim": (0.012, 0.0), "sensors_off": ("A03", "M01")}
    result = replace(RESULT, passes=(replace(first, **chosen), replace(second, **chosen), *others))
    data = data_of(result)
    assert data["passes"][0]["weight"] == 2.5
    assert data["passes"][0]["trim_mm"] == [12.0, 0.0]
    assert data["passes"][0]["sensors_off"] == ["A03", "M01"]
    words = " ".join(Page(report_html(result, data, created=WHEN)).words)
    assert (
        f"{first.name}, {second.name}: counts 2.5 times; cut off 12 mm at the beginning and 0 mm "
        "at the end; switched off A03, M01"
    ) in words
    plain = data_of(RESULT)
    assert plain["passes"][0]["trim_mm"] == [0.0, 0.0]
    assert "Chosen by hand" not in report_html(RESULT, plain, created=WHEN)
