"""How the ribbon, its sensors and the link's states are told to a person."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

from georibbon.device.telling import LinkState
from georibbon.gui.language import N_, tr, trn

if TYPE_CHECKING:
    from georibbon.device.identity import Identity
    from georibbon.gui.units import Units
    from georibbon.ribbon import Ribbon, Sensor

KINDS = {"accelerometer": N_("accelerometer"), "magnetometer": N_("magnetometer")}
UNIT_OF = {"accelerometer": N_("g"), "magnetometer": N_("of the field")}
FLAGS = {
    "": N_("ok"),
    "lost": N_("values lost"),
    "saturated": N_("saturated"),
    "stuck": N_("stuck"),
}
STATES = {
    LinkState.DISCONNECTED: N_("not connected"),
    LinkState.OPENING: N_("connecting"),
    LinkState.STREAMING: N_("streaming"),
    LinkState.STALLED: N_("stalled"),
}
UNPLUGGED = N_("cable out, looking for it")


def state_words(state: LinkState, known: bool) -> str:
    """A state in words; known: a ribbon has answered on this connection before."""
    if known and state is LinkState.DISCONNECTED:
        return tr(UNPLUGGED)
    return tr(STATES[state])


def clock_time(moment: str) -> str:
    """The time of day here of a moment, UTC in ISO 8601."""
    return datetime.fromisoformat(moment).astimezone().strftime("%H:%M:%S")


def kind_words(sensor: Sensor) -> str:
    """What kind of sensor it is."""
    return tr(KINDS[sensor.kind])


def sensor_words(sensor: Sensor, units: Units) -> str:
    """Where a sensor sits and what it is, in one sentence."""
    return tr(
        "{name}: {kind}, {place} from the start of the ribbon, measures {axes} in units {unit}, "
        "{counts} counts each",
        name=sensor.name,
        kind=kind_words(sensor),
        place=units.text(sensor.position),
        axes=_axes(sensor),
        unit=tr(UNIT_OF[sensor.kind]),
        counts=f"{sensor.counts_per_unit:g}",
    )


def _axes(sensor: Sensor) -> str:
    meanings = (tr("x (along)"), tr("y (across)"), tr("z (out of the surface)"))
    return ", ".join(meanings[: sensor.axes])


def identity_rows(identity: Identity, units: Units) -> tuple[tuple[str, str], ...]:
    """What the ribbon says of itself: names and values."""
    ribbon = identity.ribbon
    return (
        (tr("Name"), ribbon.id),
        (tr("Firmware"), identity.firmware),
        (tr("Frames per second"), f"{ribbon.rate:g}"),
        (tr("Length"), units.text(ribbon.length)),
        (tr("Sensors"), sensors_words(ribbon)),
        (tr("Axes"), str(len(ribbon.columns))),
    )


def sensors_words(ribbon: Ribbon) -> str:
    """How many sensors of each kind."""
    accelerometers = len(ribbon.indices("accelerometer"))
    magnetometers = len(ribbon.indices("magnetometer"))
    return ", ".join(
        (
            trn("{n} accelerometer", "{n} accelerometers", accelerometers),
            trn("{n} magnetometer", "{n} magnetometers", magnetometers),
        )
    )
