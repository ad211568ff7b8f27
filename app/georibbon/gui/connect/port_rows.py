"""The serial ports with what is known of each, for a person to choose from; without Qt."""

import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from georibbon.device.ports import PortInfo, list_ports

Hint = Literal["", "connected", "busy", "forbidden"]
MOST_ROWS = 200
_PROCESSES = Path("/proc")


@dataclass(frozen=True)
class PortRow:
    """One port.

    usb: vendor and product as "1a86:7523", then the serial number; empty for
    what is no USB device.  hint: what stands in the way, or that it is connected.
    """

    device: str
    description: str
    usb: str
    hint: Hint


def port_rows(connected: str | None = None) -> tuple[PortRow, ...]:
    """The ports of this computer, those on USB first; connected: the one that is ours."""
    try:
        ports = list_ports()[:MOST_ROWS]
    except (OSError, TypeError, ValueError):  # one that went while it was asked for its names
        return ()
    held = _held([port.device for port in ports])
    rows = [
        PortRow(p.device, p.description, _usb(p), _hint(p.device, connected, held)) for p in ports
    ]
    return tuple(sorted(rows, key=lambda row: (not row.usb, row.device)))


def _usb(port: PortInfo) -> str:
    parts = []
    if port.vid is not None and port.pid is not None:
        parts.append(f"{port.vid:04x}:{port.pid:04x}")
    if port.serial_number:
        parts.append(port.serial_number)
    return ", ".join(parts)


def _hint(device: str, connected: str | None, held: Iterable[str]) -> Hint:
    if connected is not None and _real(device) == _real(connected):
        return "connected"
    if _real(device) in held:
        return "busy"
    # On Windows a port is no path, and nobody can tell before it is opened.
    forbidden = Path(device).exists() and not os.access(device, os.R_OK | os.W_OK)
    return "forbidden" if forbidden else ""


def _held(devices: Sequence[str]) -> set[str]:
    """Which of the ports a program of this person's has open; where the system tells it."""
    if not sys.platform.startswith("linux") or not devices:
        return set()
    wanted = {_real(device) for device in devices}
    found: set[str] = set()
    for process in _PROCESSES.glob("[0-9]*"):
        with suppress(OSError):  # another person's process, or one that has ended
            found.update(wanted.intersection(map(_target, (process / "fd").iterdir())))
    return found


def _target(descriptor: Path) -> str:
    try:
        return str(descriptor.readlink())
    except OSError:
        return ""


def _real(device: str) -> str:
    return os.path.realpath(device)
