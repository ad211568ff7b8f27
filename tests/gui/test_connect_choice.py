"""What was chosen to connect to is kept; whatever stands in the settings, the start goes on."""

import json
import os
import pty
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.ports import PortInfo
from georibbon.errors import SettingsError
from georibbon.gui.connect import port_rows
from georibbon.gui.connect.choice import (
    BOUNDS,
    KINDS,
    Choice,
    VirtualChoice,
    keep_choice,
    kept_choice,
)
from georibbon.gui.connect.virtual_form import OBJECTS
from georibbon.simulation import SURFACES


class Kept(dict):
    """Settings as simple as can be."""

    def put(self, name, value):
        self[name] = value


def kept(text):
    return kept_choice(Kept({"connect/choice": text}))


NUMBERS = st.floats(0.0, 0.5)
VIRTUAL = st.builds(
    VirtualChoice,
    surface=st.sampled_from(sorted(SURFACES)),
    mesh=st.text(max_size=20),
    unit=st.sampled_from(["mm", "m"]),
    passes=st.integers(*BOUNDS["passes"]),
    ties=st.integers(*BOUNDS["ties"]),
    noise=NUMBERS,
    drop=NUMBERS,
    pace=NUMBERS,
    socket=st.booleans(),
)


@given(
    st.builds(
        Choice,
        kind=st.sampled_from(KINDS),
        port=st.text(max_size=20),
        address=st.text(max_size=20),
        baudrate=st.integers(*BOUNDS["baudrate"]),
        virtual=VIRTUAL,
    )
)
def test_what_is_kept_is_read_back(choice):
    settings = Kept()
    keep_choice(settings, choice)
    assert kept_choice(settings) == choice


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["kind", "port", "baudrate", "virtual", "passes", "noise", "mesh"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=8,
)


@given(JSON)
def test_whatever_is_kept_a_choice_comes_of_it(found):
    choice = kept(json.dumps(found))
    assert choice.kind in KINDS
    assert BOUNDS["passes"][0] <= choice.virtual.passes <= BOUNDS["passes"][1]
    assert BOUNDS["noise"][0] <= choice.virtual.noise <= BOUNDS["noise"][1]


def test_what_is_no_choice_is_the_first_one():
    for text in ("", "{", "[" * 100_000, "[]", '{"kind": "radio"}', "null"):
        assert kept(text) == Choice()


def test_every_choice_of_an_object_is_a_surface():
    assert set(OBJECTS) == set(SURFACES)


def test_a_choice_is_what_the_virtual_ribbon_is_made_with():
    settings = VirtualChoice(surface="dome", passes=7, ties=1, drop=0.1).settings()
    assert settings.simulation.surface == "dome"
    assert settings.simulation.layout.passes == 7
    assert settings.drop == 0.1
    assert settings.mesh is None
    assert VirtualChoice(mesh="a.stl", unit="m").settings().mesh.path == Path("a.stl")
    with pytest.raises(SettingsError):
        VirtualChoice(mesh="a.stl", unit="foot").settings()


# --- the ports ---


def listed(monkeypatch, *ports):
    monkeypatch.setattr(port_rows, "list_ports", lambda: ports)
    return port_rows.port_rows


def test_ports_on_usb_come_first_with_what_is_known(monkeypatch):
    plain = PortInfo("/dev/ttyS0", "no description", None)
    usb = PortInfo("/dev/ttyUSB9", "a converter", "A50285BI", 0x0403, 0x6001)
    first, second = listed(monkeypatch, plain, usb)()
    assert (first.device, first.usb) == ("/dev/ttyUSB9", "0403:6001, A50285BI")
    assert (second.device, second.usb) == ("/dev/ttyS0", "")


def test_a_port_that_is_open_is_told(monkeypatch):
    master, slave = pty.openpty()
    try:
        name = os.ttyname(slave)
        rows = listed(monkeypatch, PortInfo(name, "a terminal", None))
        assert [row.hint for row in rows()] == ["busy"]
        assert [row.hint for row in rows(name)] == ["connected"]
        os.close(slave)
        slave = -1
        assert [row.hint for row in rows()] == [""]
    finally:
        os.close(master)
        if slave >= 0:
            os.close(slave)


def test_a_port_without_the_right_to_it_is_told(monkeypatch, tmp_path):
    device = tmp_path / "ttyACM0"
    device.touch()
    monkeypatch.setattr(port_rows.os, "access", lambda *_: False)
    assert listed(monkeypatch, PortInfo(str(device), "x", None))()[0].hint == "forbidden"


def test_a_listing_that_fails_lists_nothing(monkeypatch):
    def broken():
        raise OSError("it went meanwhile")

    monkeypatch.setattr(port_rows, "list_ports", broken)
    assert port_rows.port_rows() == ()
