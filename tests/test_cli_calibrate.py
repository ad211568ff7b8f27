"""`georibbon calibrate`."""

import re
import shutil

import numpy as np
import pytest

from georibbon.cli import main
from georibbon.session.folder import read_recording


@pytest.fixture(scope="module")
def calibrated(small_capture, tmp_path_factory):
    path = tmp_path_factory.mktemp("calibrated") / "ribbon.json"
    assert main(["calibrate", str(small_capture), "-o", str(path)]) == 0
    return path


def test_the_file_holds_what_was_found(calibrated, small_capture):
    from georibbon.calibration import calibrate
    from georibbon.session.calibration_file import read_calibration

    recording = read_recording(small_capture)
    found, meant = read_calibration(calibrated), calibrate(recording.ribbon, recording.poses)
    assert found.ribbon_id == recording.ribbon.id
    assert found.dip == pytest.approx(meant.dip)
    for ours, theirs in zip(found.sensors, meant.sensors, strict=True):
        assert ours.name == theirs.name
        np.testing.assert_allclose(ours.gain, theirs.gain)
        np.testing.assert_allclose(ours.bias, theirs.bias)


def test_the_quality_is_told_in_degrees(small_capture, tmp_path, capsys):
    path = tmp_path / "ribbon.json"
    capsys.readouterr()
    assert main(["calibrate", str(small_capture), "-o", str(path)]) == 0
    told = capsys.readouterr().out
    for name in ("tilt of a sensor", "heading of a sensor", "common to all sensors"):
        (degrees,) = re.findall(rf"{name} +([0-9.]+) degrees", told)
        assert 0 < float(degrees) < 5
    assert told.endswith(f"written: {path}\n")


@pytest.mark.parametrize("name", ["ribbon.toml", "ribbon", "missing/ribbon.json"])
def test_places_that_are_refused(small_capture, tmp_path, name, capsys):
    assert main(["calibrate", str(small_capture), "-o", str(tmp_path / name)]) == 2
    assert name in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_too_few_poses(tmp_path, capsys):
    folder, file = tmp_path / "bare", tmp_path / "ribbon.json"
    words = ["--plan=0", "--sensors=8", "--passes=2", "--frames=5", "--length=0.4"]
    assert main(["simulate", "dome", "-o", str(folder), *words]) == 0
    capsys.readouterr()
    assert main(["calibrate", str(folder), "-o", str(file)]) == 2
    told = capsys.readouterr().err
    assert told.startswith("georibbon: error: ")
    assert "pose" in told
    assert not file.exists()


def test_a_calibration_of_another_ribbon_is_refused(calibrated, small_capture, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(small_capture, other)
    toml = other / "recording.toml"
    toml.write_text(
        toml.read_text(encoding="utf-8").replace("GR-0001", "GR-0002"), encoding="utf-8"
    )
    capsys.readouterr()
    assert main(["reconstruct", str(other), f"--calibration={calibrated}"]) == 2
    told = capsys.readouterr().err
    assert "GR-0001" in told
    assert "GR-0002" in told
