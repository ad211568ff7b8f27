"""Identities: written and read back, checked field by field, strangers told apart."""

import json
from dataclasses import replace

import pytest
from fake import RIBBON
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.identity import (
    MOST_RATE,
    Identity,
    OtherRibbonError,
    check_same,
    read_identity,
    write_identity,
)
from georibbon.device.packets import MOST_PAYLOAD
from georibbon.errors import DeviceError
from georibbon.ribbon import Ribbon, Sensor

IDENTITY = Identity(RIBBON, "1.4.0")


def fields():
    return json.loads(write_identity(IDENTITY))


def read(data):
    return read_identity(json.dumps(data).encode())


def test_it_comes_back():
    assert read_identity(write_identity(IDENTITY)) == IDENTITY


@given(st.binary(max_size=400) | st.text(max_size=200).map(str.encode))
def test_any_bytes_are_refused_in_one_sentence(payload):
    with pytest.raises(DeviceError, match="the ribbon's identity: "):
        read_identity(payload)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=8,
)


@given(JSON, st.sampled_from([*fields(), "sensors.name", "sensors.kind", "sensors.axes"]))
def test_any_value_in_any_field_is_read_or_refused(value, field):
    data = fields()
    name, _, inner = field.partition(".")
    if inner:
        data[name][1][inner] = value
    else:
        data[name] = value
    try:
        identity = read(data)
    except DeviceError:
        return
    assert read_identity(write_identity(identity)) == identity


@pytest.mark.parametrize("payload", [b"[" * 4000, b"1" * 4090, b'{"protocol": 1', b"\xff\xfe"])
def test_hostile_bytes(payload):
    with pytest.raises(DeviceError):
        read_identity(payload)


def test_a_newer_firmware_may_tell_more():
    data = fields() | {"battery": 0.7}
    data["sensors"][0]["made"] = "2026"
    assert read(data) == IDENTITY


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"protocol": 2}, "version 2 of the protocol, this program version 1"),
        ({"protocol": "1"}, 'protocol is "1"'),
        ({"firmware": 3}, "firmware is 3"),
        ({"id": ""}, "the ribbon's name is expected"),
        ({"id": "a\nb"}, "control characters"),
        ({"length": -1}, "a length in metres"),
        ({"rate": float("nan")}, "rate is nan"),
        ({"rate": 1e999}, "rate is inf"),
        ({"rate": 10_001.0}, r"rate is 10001\.0; at most 10000 frames per second"),
        ({"rate": 1e9}, "at most 10000 frames per second"),
        ({"sensors": {}}, "tables written"),
        ({"sensors": []}, "no accelerometer"),
        ({"sensors": [7]}, "7 stands where an object"),
    ],
)
def test_refused_with_the_field_named(change, words):
    with pytest.raises(DeviceError, match=words):
        read(fields() | change)


# What a terminal obeys: escape sequences, their one-character forms, and text that turns round.
HOSTILE = "\x1b[2J\x9b31m\r\n\x07\x00\x7f\u202e\u2028"
FIELDS = ("id", "firmware", "protocol", "length", "rate", "sensors")
OF_SENSOR = ("name", "kind", "axes", "position", "counts_per_unit")


@given(
    st.sampled_from([*FIELDS, *(f"sensors.{one}" for one in OF_SENSOR), "new"]),
    st.text(st.sampled_from(HOSTILE + "a"), min_size=1, max_size=300),
    st.booleans(),
)
def test_nothing_in_an_identity_reaches_a_terminal_unescaped(field, text, as_key):
    data = fields()
    name, _, inner = field.partition(".")
    value = {text: text} if as_key else text
    if inner:
        data[name][1][inner] = value
    else:
        data[name] = value
    said = what_is_said(data)
    assert said
    assert all(words.isprintable() for words in said)


def what_is_said(data):
    """All that is told of an identity, in refusing it or in comparing it."""
    try:
        identity = read(data)
        said = [identity.firmware, *(sensor.name for sensor in identity.ribbon.sensors)]
        check_same(replace(identity.ribbon, id=identity.ribbon.id + "z"), identity.ribbon)
    except OtherRibbonError as error:
        return [*said, str(error)]
    except DeviceError as error:
        return [str(error)]


def test_the_highest_rate_that_is_taken():
    assert read(fields() | {"rate": MOST_RATE}).ribbon.rate == MOST_RATE


@pytest.mark.parametrize("field", ["protocol", "firmware", "id", "length", "rate"])
def test_nothing_may_be_missing(field):
    data = fields()
    del data[field]
    with pytest.raises(DeviceError, match=f"the field {field} is missing"):
        read(data)


def test_a_ribbon_without_sensors():
    data = fields()
    del data["sensors"]
    with pytest.raises(DeviceError, match="no accelerometer among its sensors"):
        read(data)


def test_an_identity_that_no_packet_holds():
    half = [Sensor(f"A{i:02}", "accelerometer", 3, i / 100, 16384.0) for i in range(32)]
    other = [Sensor(f"M{i:02}", "magnetometer", 2, i / 100, 2000.0) for i in range(32)]
    with pytest.raises(DeviceError, match=f"64 sensors has .* at most {MOST_PAYLOAD}"):
        write_identity(Identity(Ribbon("GR-1", 1.0, 100.0, (*half, *other)), "1"))
    fits = Identity(Ribbon("GR-1", 1.0, 100.0, (*half[:16], *other[:16])), "1")
    assert read_identity(write_identity(fits)) == fits


def test_the_same_ribbon_at_another_rate_is_the_same():
    check_same(replace(RIBBON, rate=50.0), RIBBON)
    check_same(RIBBON, "GR-0007")
    check_same(RIBBON, None)


def test_another_ribbon_is_told_with_both_names():
    for expected in (RIBBON, RIBBON.id):
        with pytest.raises(OtherRibbonError, match='"GR-0009" answers; "GR-0007" is expected'):
            check_same(replace(RIBBON, id="GR-0009"), expected)


def test_other_sensors_are_told():
    moved = replace(RIBBON.sensors[1], position=0.21)
    other = replace(RIBBON, sensors=(RIBBON.sensors[0], moved, RIBBON.sensors[2]))
    with pytest.raises(
        OtherRibbonError, match=r'other sensors .*"M01": position 0.21, 0.2 expected'
    ):
        check_same(other, RIBBON)
    with pytest.raises(OtherRibbonError, match=r"2 sensors on 0\.5 m; 3 sensors on 0\.5 m exp"):
        check_same(replace(RIBBON, sensors=RIBBON.sensors[:2]), RIBBON)
