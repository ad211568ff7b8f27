"""The calibration file: a round trip loses nothing, and what is no calibration is refused."""

import json
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.calibration.model import Calibration, CalibrationQuality, SensorModel
from georibbon.errors import CalibrationError
from georibbon.notices import Notice
from georibbon.session import calibration_file
from georibbon.session.calibration_file import read_calibration, write_calibration


def calibration():
    """A used accelerometer and a magnetometer of 2 axes that is not."""
    random = np.random.default_rng(2)
    return Calibration(
        "GR-0001",
        1.1234567890123456,
        (
            SensorModel("A01", random.normal(size=(3, 3)), random.normal(size=3)),
            SensorModel("M01", random.normal(size=(2, 3)), random.normal(size=2), False, "dead"),
        ),
        CalibrationQuality(16, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8),
        (Notice("sensor-dead", "M01 never changes.", None, "M01"),),
    )


@pytest.fixture
def path(tmp_path):
    """The file of that calibration."""
    write_calibration(calibration(), tmp_path / "ribbon.json")
    return tmp_path / "ribbon.json"


def refused(path):
    """The sentence with which a file is refused; it names the file."""
    with pytest.raises(CalibrationError) as caught:
        read_calibration(path)
    assert str(caught.value).startswith(str(path))
    return str(caught.value)


def test_what_is_written_is_read_back_to_the_last_bit(path):
    found, made = read_calibration(path), calibration()
    assert (found.ribbon_id, found.dip) == (made.ribbon_id, made.dip)
    assert (found.quality, found.notices) == (made.quality, made.notices)
    for one, other in zip(found.sensors, made.sensors, strict=True):
        assert (one.name, one.used, one.reason) == (other.name, other.used, other.reason)
        assert np.array_equal(one.gain, other.gain)
        assert np.array_equal(one.bias, other.bias)
    assert [p.name for p in path.parent.iterdir()] == ["ribbon.json"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "not JSON"),
        (b"{\n\n,", "not JSON (line 3)"),
        (b"\xff\xff\xff", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b"[1]", "give a calibration file"),
        (b"null", "give a calibration file"),
        (b"{}", "format is None"),
        (b"9" * 5000, "not JSON"),
    ],
)
def test_what_is_no_calibration_is_refused(path, text, words):
    path.write_bytes(text)
    assert words in refused(path)


def test_a_missing_file_a_folder_and_a_huge_file_are_refused(path, monkeypatch):
    assert "missing" in refused(path.parent / "none.json")
    assert "no regular file" in refused(path.parent)
    monkeypatch.setattr(calibration_file, "MAX_CALIBRATION", 10)
    assert "more than 10 bytes" in refused(path)


def test_where_it_cannot_be_written(tmp_path):
    with pytest.raises(CalibrationError, match="cannot be written"):
        write_calibration(calibration(), tmp_path / "none" / "ribbon.json")


OTHER = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3),
    st.lists(st.floats(), max_size=3), st.just({}),
)  # fmt: skip


def places(value, found):
    """Every place in a document as (container, key)."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in pairs:
        found.append((value, key))
        if isinstance(item, dict | list):
            places(item, found)
    return found


@given(st.data())
def test_any_other_value_anywhere_is_refused_or_read_and_never_a_fault(data):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "ribbon.json"
        write_calibration(calibration(), path)
        document = json.loads(path.read_text(encoding="utf-8"))
        container, key = data.draw(st.sampled_from(places(document, [])))
        if data.draw(st.booleans()) and isinstance(container, dict):
            del container[key]
        else:
            container[key] = data.draw(OTHER)
        path.write_text(json.dumps(document), encoding="utf-8")
        try:
            found = read_calibration(path)
        except CalibrationError:
            return
        assert isinstance(found, Calibration)
        assert all(np.isfinite(m.gain).all() and np.isfinite(m.bias).all() for m in found.sensors)
