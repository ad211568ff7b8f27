"""Who a ribbon says it is: the identity packet's JSON, checked like a recording's ribbon."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from georibbon.device.packets import MOST_PAYLOAD
from georibbon.errors import DeviceError
from georibbon.ribbon import Ribbon
from georibbon.session.fields import Source, Table
from georibbon.session.outline import read_ribbon, ribbon_table
from georibbon.session.words import counted, told

PROTOCOL = 1
MOST_RATE = 10_000.0  # frames per second: what half a second of them takes stays small
_SOURCE = Source("the ribbon's identity", DeviceError)
_OWN = ("protocol", "firmware")
_RIBBON = ("id", "length", "rate")
_SENSOR = ("name", "kind", "axes", "position", "counts_per_unit")


class OtherRibbonError(DeviceError):
    """Another ribbon answers than the one expected, or the same with other sensors."""


@dataclass(frozen=True)
class Identity:
    """A ribbon and the version of its firmware."""

    ribbon: Ribbon
    firmware: str


def read_identity(payload: bytes) -> Identity:
    """The identity in an identity packet's payload.

    Fields that are not known are passed over: a newer firmware may tell more.
    Raises DeviceError for anything missing, of the wrong type or out of range,
    and for another version of the protocol.
    """
    try:
        data = json.loads(payload.decode("utf-8"))
    except (ValueError, RecursionError):
        message = "it is no JSON text in UTF-8; is this a ribbon, and its firmware up to date?"
        raise DeviceError(f"{_SOURCE.name}: {message}") from None
    top = Table(_known(data, _OWN), _SOURCE, "", None, _OWN)
    protocol = top.whole("protocol", f"the number {PROTOCOL}")
    if protocol != PROTOCOL:
        top.refuse(
            "protocol",
            f"the ribbon speaks version {told(protocol)} of the protocol, this program version "
            f"{PROTOCOL}; update the one that is older",
        )
    firmware = top.text("firmware", "the version of the ribbon's firmware")
    table: dict[str, object] = dict(_known(data, _RIBBON))
    if "sensors" in data:
        sensors = data["sensors"]
        listed = isinstance(sensors, list)
        table["sensor"] = [_known(one, _SENSOR) for one in sensors] if listed else sensors
    ribbon = read_ribbon(table, _SOURCE)
    if ribbon.rate > MOST_RATE:
        top.refuse(
            "rate",
            f"rate is {told(ribbon.rate)}; at most {MOST_RATE:g} frames per second are expected; "
            "is the ribbon's firmware up to date?",
        )
    return Identity(ribbon, firmware)


def _known(data: object, fields: tuple[str, ...]) -> Mapping[str, object]:
    """The known fields of a table; what is no table is refused."""
    if not isinstance(data, Mapping):
        message = f"{told(data)} stands where an object with fields is expected"
        raise DeviceError(f"{_SOURCE.name}: {message}; is the ribbon's firmware up to date?")
    return {key: data[key] for key in fields if key in data}


def write_identity(identity: Identity) -> bytes:
    """The payload that `read_identity` reads back; DeviceError where no packet holds it."""
    table = ribbon_table(identity.ribbon)
    table["sensors"] = table.pop("sensor")
    data = {"protocol": PROTOCOL, "firmware": identity.firmware} | table
    payload = json.dumps(data, ensure_ascii=False, separators=(",", ":")).encode("utf-8")
    if len(payload) > MOST_PAYLOAD:
        raise DeviceError(
            f"the identity of a ribbon of {counted(len(identity.ribbon.sensors), 'sensor')} has "
            f"{len(payload)} bytes; a packet holds at most {MOST_PAYLOAD}: give it fewer sensors "
            "or shorter names"
        )
    return payload


def check_same(found: Ribbon, expected: Ribbon | str | None) -> None:
    """OtherRibbonError unless the ribbon is the one expected: by its id, or with its sensors.

    The rate may differ: it can be set.
    """
    if expected is None:
        return
    name = expected if isinstance(expected, str) else expected.id
    if found.id != name:
        raise OtherRibbonError(
            f"the ribbon {told(found.id)} answers; {told(name)} is expected: plug that one in, or "
            "begin a new session"
        )
    if isinstance(expected, str) or replace(found, rate=expected.rate) == expected:
        return
    raise OtherRibbonError(
        f"the ribbon {told(found.id)} has other sensors than it had: {_outline(found)}; "
        f"{_outline(expected)} expected{_first_other(found, expected)}: begin a new session with it"
    )


def _outline(ribbon: Ribbon) -> str:
    return f"{counted(len(ribbon.sensors), 'sensor')} on {ribbon.length:g} m"


def _first_other(found: Ribbon, expected: Ribbon) -> str:
    """Which sensor is the first that differs, and in what."""
    for one, other in zip(found.sensors, expected.sensors, strict=False):
        for field in fields(one):
            here, due = getattr(one, field.name), getattr(other, field.name)
            if here != due:
                return f" ({told(one.name)}: {field.name} {told(here)}, {told(due)} expected)"
    return ""
