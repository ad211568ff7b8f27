"""``georibbon ports``: the serial ports on which a ribbon may hang."""

import argparse
import dataclasses
import json
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser

if TYPE_CHECKING:
    from georibbon.device.ports import PortInfo

DESCRIPTION = """\
List the serial ports of this computer, with what is known of each: what the device calls
itself, the USB vendor and product, and the USB serial number, by which a ribbon is found
again when its cable was pulled and put in elsewhere.  Nothing is opened.

A ribbon on the network has no port here; it is reached by socket://HOST:PORT."""

EPILOG = """\
examples:
  georibbon ports
  georibbon ports --json                     # for programs
  georibbon record /dev/ttyACM0 -o run.csv   # record from one of them"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the ports."""
    from georibbon.device.ports import list_ports

    ports = list_ports()
    if arguments.json:
        facts = [dataclasses.asdict(port) for port in ports]
        print(json.dumps(facts, indent=2, ensure_ascii=False))
    elif ports:
        width = max(len(port.device) for port in ports)
        print("\n".join(_line(port, width) for port in ports))
    else:
        print("no serial port; plug the ribbon in, or reach it by socket://HOST:PORT")


def _line(port: "PortInfo", width: int) -> str:
    usb = "" if port.vid is None or port.pid is None else f"USB {port.vid:04x}:{port.pid:04x}"
    number = f"serial number {port.serial_number}" if port.serial_number else ""
    known = ", ".join(filter(None, (port.description, usb, number)))
    line = f"{port.device:{width}}  {known}".rstrip()
    # A device may call itself anything, also what would write over the terminal.
    return "".join(c if c.isprintable() else "?" for c in line)
