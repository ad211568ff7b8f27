"""A calibration as plain data: a round trip loses nothing, what is wrong is named."""

import copy
import json
from dataclasses import replace

import numpy as np
import pytest
from bar import TWENTY, Bar
from hypothesis import given
from hypothesis import strategies as st

from georibbon.calibration import calibrate, check_fits, from_dict, to_dict
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.errors import CalibrationError
from georibbon.notices import Notice

BAR = Bar(seed=1, sensors=6, frames=10, counts=lambda _p, s, y: y * (s.name != "M02"))


@pytest.fixture(scope="module")
def calibration():
    return calibrate(BAR.ribbon, BAR.poses(TWENTY))


@pytest.fixture
def data(calibration):
    return json.loads(json.dumps(to_dict(calibration)))


def same(one, other):
    assert replace(one, sensors=()) == replace(other, sensors=()) or (
        to_dict(one) == to_dict(other)
    )
    for a, b in zip(one.sensors, other.sensors, strict=True):
        assert (a.name, a.used, a.reason) == (b.name, b.used, b.reason)
        np.testing.assert_array_equal(a.gain, b.gain)
        np.testing.assert_array_equal(a.bias, b.bias)


def test_a_round_trip_through_json_loses_nothing(calibration, data):
    assert not all(model.used for model in calibration.sensors)
    back = from_dict(data, "c.json")
    same(calibration, back)
    assert to_dict(back) == data


def test_what_is_not_needed_may_be_missing(data):
    for name in ("notices", "quality", "mounting_sigma", "gauge_sigma", "dip_sigma"):
        del data[name]
    for entry in data["sensors"]:
        del entry["used"], entry["reason"]
    back = from_dict(data, "c.json")
    assert back.quality is None
    assert back.notices == ()
    assert back.mounting_sigma > 0.0
    assert all(model.used for model in back.sensors)


def changed(data, path, value):
    data = copy.deepcopy(data)
    place = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return data


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (["format"], "other", "format is 'other'"),
        (["version"], 2, "version is 2"),
        (["version"], True, "version is True"),
        (["ribbon"], 7, "ribbon is 7"),
        (["dip"], "x", "dip is 'x'"),
        (["dip"], 2.0, "dip is 2.0"),
        (["dip"], float("nan"), "dip is nan"),
        (["dip"], 10**400, "dip is 1000"),
        (["gauge_sigma"], -1.0, "gauge_sigma is -1.0"),
        (["sensors"], {}, "sensors is {}"),
        (["sensors", 0], 3, r"sensors\[0\] holds int"),
        (["sensors", 0, "name"], None, r"sensors\[0\]: name is None"),
        (["sensors", 0, "name"], "M01", "sensor M01 stands twice"),
        (["sensors", 0, "gain"], [[1.0, 2.0, 3.0]], r"sensors\[0\]: gain is"),
        (["sensors", 0, "gain"], [[1.0, 2.0], [1.0, 2.0]], r"sensors\[0\]: gain is"),
        (["sensors", 0, "gain", 1, 2], float("inf"), "3 rows of 3 numbers"),
        (["sensors", 0, "gain", 1, 2], 1e300, "numbers of at most 1e\\+09"),
        (["sensors", 0, "gain", 1], [0.0, 0.0, 0.0], "gain is .* a row for each axis"),
        (["sensors", 0, "gain", 1], 5.0, "3 rows of 3 numbers"),
        (["sensors", 0, "bias"], [1.0, 2.0], "one number for each of gain's 3 rows"),
        (["sensors", 0, "bias"], "no", r"sensors\[0\]: bias is 'no'"),
        (["sensors", 0, "used"], 1, r"sensors\[0\]: used is 1"),
        (["sensors", 0, "reason"], 1, "reason is 1"),
        (["quality"], 1, "quality holds int"),
        (["quality", "poses"], 1.5, "quality: poses is 1.5"),
        (["quality", "tilt"], None, "quality: tilt is None"),
        (["notices"], "x", "notices is 'x'"),
        (["notices"], ["x"], r"notices\[0\] holds str"),
        (["notices"], [{"code": "a"}], r"notices\[0\]: message is None"),
        (["notices"], [{"code": "a", "message": "b", "sensor": 4}], "sensor is 4"),
    ],
)
def test_what_is_wrong_is_refused_with_its_field(data, path, value, words):
    with pytest.raises(CalibrationError, match=words) as caught:
        from_dict(changed(data, path, value), "c.json")
    assert str(caught.value).startswith("c.json")


@pytest.mark.parametrize("document", [None, 3, "text", [1]])
def test_what_is_no_mapping_is_refused(document):
    with pytest.raises(CalibrationError, match="named fields"):
        from_dict(document, "c.json")


def test_long_wrong_values_are_shortened(data):
    with pytest.raises(CalibrationError) as caught:
        from_dict(changed(data, ["ribbon"], list(range(1000))), "c.json")
    assert len(str(caught.value)) < 200


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


@given(
    key=st.sampled_from(["ribbon", "dip", "sensors", "quality", "notices", "gauge_sigma"]),
    value=json_values,
)
def test_any_value_in_any_field_is_read_or_refused(key, value):
    model = SensorModel("A01", np.eye(3), np.zeros(3))
    document = to_dict(Calibration("R", 1.0, (model,), None, (Notice("a", "b"),)))
    document[key] = value
    message = "c.json"
    try:
        dip = from_dict(document, "c.json").dip
    except CalibrationError as error:
        dip, message = 0.0, str(error)
    assert message.startswith("c.json")
    assert np.isfinite(dip)


def test_a_calibration_fits_its_own_ribbon(calibration):
    check_fits(calibration, BAR.ribbon)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: replace(r, id="GR-9"), "ribbon GR-0042.*ribbon GR-9"),
        (lambda r: replace(r, sensors=r.sensors[:-1]), "has 6 sensors.*has 5"),
        (
            lambda r: replace(r, sensors=(replace(r.sensors[0], name="Q"), *r.sensors[1:])),
            "A01 with 3 axes where ribbon GR-0042 has Q with 3 axes",
        ),
        (
            lambda r: replace(r, sensors=(*r.sensors[:-1], replace(r.sensors[-1], axes=3))),
            "M03 with 2 axes where ribbon GR-0042 has M03 with 3 axes",
        ),
    ],
)
def test_another_ribbon_is_refused_with_both_sides(calibration, change, words):
    with pytest.raises(CalibrationError, match=words):
        check_fits(calibration, change(BAR.ribbon))
