"""The truth file: a round trip loses nothing that matters; other files are refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from georibbon.errors import GeoribbonError, RecordingError
from georibbon.simulation import (
    LayoutSettings,
    PoseSettings,
    SimulationSettings,
    read_truth,
    simulate,
    write_truth,
)
from georibbon.simulation import truth as truth_module

TRUTH = simulate(
    SimulationSettings(
        "spline",
        parameters={"seed": 5.0},
        layout=LayoutSettings(passes=2, ties=1),
        poses=PoseSettings(plan=0),
        frames=2,
    )
).truth


def data_of(truth, folder):
    write_truth(truth, folder / "whole.truth.json")
    return json.loads((folder / "whole.truth.json").read_text())


def test_a_round_trip(tmp_path):
    path = tmp_path / "x.truth.json"
    write_truth(TRUTH, path)
    found = read_truth(path)
    assert (found.surface, found.yaw_degrees) == (TRUTH.surface, TRUTH.yaw_degrees)
    assert dict(found.parameters) == dict(TRUTH.parameters)
    assert list(found.strips) == ["P1", "P2", "T1"]
    for name, strip in TRUTH.strips.items():
        np.testing.assert_allclose(found.strips[name].s, strip.s, atol=1e-9)
        np.testing.assert_allclose(found.strips[name].points, strip.points, atol=1e-9)
        np.testing.assert_allclose(found.strips[name].frames, strip.frames, atol=1e-8)
    uv = np.array([[2.2, 3.1], [4.0, 1.5]])
    np.testing.assert_array_equal(found.shape.points(uv), TRUTH.shape.points(uv))
    assert found.calibration.dip == pytest.approx(TRUTH.calibration.dip)
    for one, other in zip(found.calibration.sensors, TRUTH.calibration.sensors, strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.gain, other.gain)
        np.testing.assert_array_equal(one.bias, other.bias)


def test_a_truth_without_its_surface_or_calibration_is_read(tmp_path):
    path = tmp_path / "x.truth.json"
    write_truth(replace(TRUTH, shape=None, calibration=None), path)
    assert set(json.loads(path.read_text())) == {"surface", "yaw_degrees", "passes"}
    found = read_truth(path)
    assert found.shape is None
    assert found.calibration is None
    assert found.surface == "spline"


@pytest.mark.parametrize(
    "change",
    [
        {"passes": {"P1": {"s": [0.0]}}},
        {"passes": {"P1": {"s": [0], "points": [[1, 2]], "normals": [], "tangents": []}}},
        {"passes": [1, 2]},
        {"passes": None},
        {"yaw_degrees": "north"},
        {"surface_parameters": 3},
        {"calibration": {"sensors": []}},
        {"calibration": {"ribbon": "x", "dip_degrees": 1, "sensors": [{"name": "A01"}]}},
    ],
)
def test_a_damaged_truth_is_refused(tmp_path, change):
    path = tmp_path / "x.truth.json"
    path.write_text(json.dumps(data_of(TRUTH, tmp_path) | change))
    with pytest.raises(RecordingError, match="is not a truth file"):
        read_truth(path)


def test_numbers_that_are_none_are_refused(tmp_path):
    data = data_of(TRUTH, tmp_path)
    data["passes"]["P1"]["points"][3][1] = float("nan")
    path = tmp_path / "x.truth.json"
    path.write_text(json.dumps(data))
    with pytest.raises(RecordingError, match="finite"):
        read_truth(path)


def test_a_missing_or_too_large_file_is_refused(tmp_path, monkeypatch):
    with pytest.raises(RecordingError, match="the file is missing"):
        read_truth(tmp_path / "none.json")
    monkeypatch.setattr(truth_module, "MAX_BYTES", 10)
    write_truth(TRUTH, tmp_path / "x.json")
    with pytest.raises(RecordingError, match="more than 10 bytes"):
        read_truth(tmp_path / "x.json")


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["surface", "yaw_degrees", "passes", "s", "points", "surface_parameters", "P1"]
            ),
            inner,
            max_size=4,
        )
    ),
    max_leaves=15,
)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(value=JSON)
def test_no_json_breaks_the_reader(tmp_path, value):
    path = tmp_path / "x.json"
    path.write_text(json.dumps(value))
    try:
        read_truth(path)
    except GeoribbonError:
        return
    assert isinstance(value, dict)


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(raw=st.binary(max_size=60))
def test_no_bytes_break_the_reader(tmp_path, raw):
    path = tmp_path / "x.json"
    path.write_bytes(raw)
    with pytest.raises(RecordingError):
        read_truth(path)
