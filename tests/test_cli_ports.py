"""`georibbon ports`."""

import json

import pytest

from georibbon.cli import main
from georibbon.device.ports import PortInfo

RIBBON = PortInfo("/dev/ttyACM0", "Ribbon bridge", "GR-0007", 0x2E8A, 0x000A)
UART = PortInfo("/dev/ttyS12", "", None)


@pytest.fixture
def ports(monkeypatch):
    """Arranges which ports there are."""

    def arrange(*found):
        monkeypatch.setattr("georibbon.device.ports.list_ports", lambda: found)

    return arrange


def test_each_port_is_a_line_with_what_is_known_of_it(ports, capsys):
    ports(RIBBON, UART)
    assert main(["ports"]) == 0
    assert capsys.readouterr().out == (
        "/dev/ttyACM0  Ribbon bridge, USB 2e8a:000a, serial number GR-0007\n/dev/ttyS12\n"
    )


def test_a_device_cannot_write_over_the_terminal(ports, capsys):
    ports(PortInfo("/dev/ttyACM0", "\x1b[2Jbad\nline", None))
    main(["ports"])
    assert capsys.readouterr().out == "/dev/ttyACM0  ?[2Jbad?line\n"


def test_no_port(ports, capsys):
    ports()
    assert main(["ports"]) == 0
    assert "no serial port; plug the ribbon in" in capsys.readouterr().out
    assert main(["ports", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_for_programs(ports, capsys):
    ports(RIBBON, UART)
    assert main(["ports", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [
        {
            "device": "/dev/ttyACM0", "description": "Ribbon bridge", "serial_number": "GR-0007",
            "vid": 0x2E8A, "pid": 0x000A,
        },
        {
            "device": "/dev/ttyS12", "description": "", "serial_number": None,
            "vid": None, "pid": None,
        },
    ]  # fmt: skip


def test_the_ports_of_this_computer_can_be_listed(capsys):
    assert main(["ports", "--json"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), list)
