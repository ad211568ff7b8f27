"""The calibrations that are kept: named, found again, discarded and put back; bad files told."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_calibration_file import calibration

from georibbon.errors import CalibrationError
from georibbon.session import calibration_shelf
from georibbon.session.calibration_file import read_calibration, write_calibration
from georibbon.session.calibration_shelf import HISTORY, Shelf


@pytest.fixture
def shelf(tmp_path):
    return Shelf(tmp_path / "calibrations")


@pytest.fixture
def times(monkeypatch):
    """Times that go on by a second each."""
    moments = iter(f"2026-01-01T10:00:{second:02}.000+00:00" for second in range(60))
    monkeypatch.setattr(calibration_shelf, "now", lambda: next(moments))


def names(shelf):
    return [one.name for one in shelf.look()[0]]


def test_an_empty_shelf_is_no_folder_yet(shelf):
    assert shelf.look() == ((), ())
    assert shelf.newest("GR-0001") is None
    assert not shelf.folder.exists()


@pytest.mark.usefixtures("times")
def test_what_is_kept_is_found_again_the_newest_first(shelf):
    for name in ("morning", "evening"):
        shelf.keep(calibration(), name)
    assert names(shelf) == ["evening", "morning"]
    kept = shelf.look()[0][0]
    assert kept.made == "2026-01-01T10:00:01.000+00:00"
    assert kept.calibration.quality == calibration().quality
    assert shelf.newest("GR-0001").name == "evening"
    assert shelf.newest("GR-0002") is None


def test_what_is_kept_is_a_calibration_file(shelf):
    kept = shelf.keep(calibration(), "bench 3")
    assert read_calibration(kept.path).ribbon_id == "GR-0001"


def test_names_in_use_and_odd_names_have_files_of_their_own(shelf):
    paths = {shelf.keep(calibration(), name).path for name in ("a", "a", "../../a", "ä/ö", "…")}
    assert len(paths) == 5
    assert {path.parent for path in paths} == {shelf.folder}
    assert sorted(names(shelf)) == sorted(["a", "a", "../../a", "ä/ö", "…"])


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 121])
def test_names_that_cannot_be_shown_are_refused(shelf, name):
    with pytest.raises(CalibrationError, match="1 to 120"):
        shelf.keep(calibration(), name)


def test_another_name_is_kept_in_the_same_file(shelf):
    kept = shelf.keep(calibration(), "first")
    again = shelf.rename(kept, " second ")
    assert (again.path, again.made) == (kept.path, kept.made)
    assert names(shelf) == ["second"]


def test_what_is_discarded_can_be_put_back_with_its_checks(shelf):
    kept = shelf.note_check(shelf.keep(calibration(), "first"), "good", 0.2, "fine")
    away = shelf.discard(kept)
    assert names(shelf) == []
    back = shelf.restore(away)
    assert (back.name, back.checks) == ("first", kept.checks)
    assert names(shelf) == ["first"]


def test_discarding_what_is_gone_is_told(shelf):
    kept = shelf.keep(calibration(), "first")
    kept.path.unlink()
    with pytest.raises(CalibrationError, match="cannot be moved"):
        shelf.discard(kept)
    with pytest.raises(CalibrationError, match="cannot be moved"):
        shelf.restore(shelf.folder / "nothing.json")


def test_a_bad_file_is_told_and_the_others_stand(shelf):
    shelf.keep(calibration(), "good one")
    (shelf.folder / "bad.json").write_text("{")
    (shelf.folder / "other.json").write_text("[]")
    (shelf.folder / "folder.json").mkdir()
    kept, spoilt = shelf.look()
    assert [one.name for one in kept] == ["good one"]
    assert {one.path.name for one in spoilt} == {"bad.json", "other.json", "folder.json"}
    assert all(one.path.name in one.reason for one in spoilt)


@given(st.binary(max_size=200) | st.text().map(str.encode))
def test_whatever_lies_in_the_folder_the_shelf_can_be_looked_at(tmp_path_factory, data):
    shelf = Shelf(tmp_path_factory.mktemp("shelf"))
    (shelf.folder / "any.json").write_bytes(data)
    kept, spoilt = shelf.look()
    assert (kept, len(spoilt)) == ((), 1)


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
        max_leaves=10,
    )
)
def test_whatever_the_checks_file_holds_the_calibration_is_there(tmp_path_factory, data):
    shelf = Shelf(tmp_path_factory.mktemp("shelf"))
    kept = shelf.keep(calibration(), "one")
    document = {"format": "georibbon-checks", "version": 1, "checks": data}
    kept.path.with_name(kept.path.stem + HISTORY).write_text(json.dumps(document))
    found, spoilt = shelf.look()
    assert [one.name for one in found] == ["one"]
    assert len(spoilt) == (0 if data == [] else 1)


@pytest.mark.usefixtures("times")
def test_checks_are_kept_in_their_order(shelf):
    kept = shelf.keep(calibration(), "one")
    for verdict, degrees in (("good", 0.2), ("usable", 0.7), ("calibrate", 3.0)):
        kept = shelf.note_check(kept, verdict, degrees, f"worst {degrees}")
    found = shelf.look()[0][0].checks
    assert [(one.verdict, one.degrees) for one in found] == [
        ("good", 0.2),
        ("usable", 0.7),
        ("calibrate", 3.0),
    ]
    assert found[0].time < found[1].time
    assert found[2].reason == "worst 3.0"


def test_checks_that_cannot_be_read_are_put_aside_not_lost(shelf):
    kept = shelf.keep(calibration(), "one")
    history = kept.path.with_name(kept.path.stem + HISTORY)
    history.write_text("{}")
    kept = shelf.look()[0][0]
    shelf.note_check(kept, "good", 0.1, "fine")
    assert len(shelf.look()[0][0].checks) == 1
    assert [path.read_text() for path in shelf.folder.glob("*.spoilt")] == ["{}"]


def test_a_calibration_from_elsewhere_is_kept_under_its_files_name(shelf, tmp_path):
    write_calibration(calibration(), tmp_path / "ribbon 7.json")
    assert shelf.load(tmp_path / "ribbon 7.json").name == "ribbon 7"
    document = json.loads((tmp_path / "ribbon 7.json").read_text())
    odd = tmp_path / "odd.json"
    odd.write_text(json.dumps({**document, "name": "a\nb", "made": "yesterday"}))
    assert shelf.load(odd).name == "calibration"
    odd.write_text("no")
    with pytest.raises(CalibrationError, match="not JSON"):
        shelf.load(odd)
    assert len(names(shelf)) == 2


def test_a_calibration_from_elsewhere_stays_as_old_as_it_is(shelf, tmp_path):
    shelf.keep(calibration(), "today")
    write_calibration(calibration(), tmp_path / "old.json", {"made": "2019-03-01T01:30:00+02:00"})
    assert shelf.load(tmp_path / "old.json").made == "2019-02-28T23:30:00.000+00:00"
    assert names(shelf) == ["today", "old"]
    assert shelf.newest("GR-0001").name == "today"


@pytest.mark.parametrize("made", ["0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59-14:00"])
def test_times_beyond_all_days_are_none(shelf, made):
    shelf.folder.mkdir()
    write_calibration(calibration(), shelf.folder / "a.json", {"made": made})
    assert shelf.look()[0][0].made[:2] == "20"


def test_a_file_without_its_time_goes_by_the_files(shelf):
    shelf.folder.mkdir()
    write_calibration(calibration(), shelf.folder / "a.json", {"made": "2026-01-01"})
    assert shelf.look()[0][0].made[:2] == "20"
    assert shelf.look()[0][0].made != "2026-01-01"


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CalibrationError, match="cannot be made"):
        Shelf(tmp_path / "file" / "calibrations").keep(calibration(), "one")
