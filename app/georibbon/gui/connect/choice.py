"""What a person chose to connect to, kept from one start to the next; without Qt."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeVar

if TYPE_CHECKING:
    from georibbon.virtual import VirtualSettings

Kind = Literal["port", "socket", "virtual"]
KINDS: tuple[Kind, ...] = ("port", "socket", "virtual")
BAUDRATE = 921_600  # the protocol's own
BAUDRATES = (115_200, 230_400, 460_800, BAUDRATE, 1_000_000, 2_000_000, 3_000_000)
ENTRY = "connect/choice"
POSES = 20  # as a capture plans them, unless told otherwise
MOST_PASSES, MOST_TIES, MOST_NOISE, MOST_DROP = 20, 6, 20.0, 0.5
T = TypeVar("T")


class Kept(Protocol):
    """What is needed of the window's settings."""

    def get(self, name: str, default: str) -> str:
        """An entry, or the default."""

    def put(self, name: str, value: str) -> None:
        """Keep an entry."""


@dataclass(frozen=True)
class VirtualChoice:
    """A virtual ribbon as a person wants it.

    surface: a reference surface of the simulation, used where mesh is empty;
    mesh: a file, in `unit`.  noise: times the sensors' own; drop: share of the
    frames that are lost.  pace: how slow the hands are; 0: there at once.
    socket: through a socket, not a pseudo-terminal.
    """

    surface: str = "bonnet"
    mesh: str = ""
    unit: str = "mm"
    passes: int = 5
    ties: int = 2
    noise: float = 1.0
    drop: float = 0.0
    pace: float = 1.0
    socket: bool = False

    def settings(self) -> VirtualSettings:
        """What the virtual ribbon is made with; SettingsError for what cannot be."""
        from georibbon.simulation import LayoutSettings, PoseSettings, SimulationSettings
        from georibbon.virtual import MeshSettings, VirtualSettings

        simulation = SimulationSettings(
            surface=self.surface,
            poses=PoseSettings(plan=POSES),
            layout=LayoutSettings(passes=self.passes, ties=self.ties),
        )
        mesh = MeshSettings(Path(self.mesh), self.unit) if self.mesh else None
        return VirtualSettings(
            simulation, mesh=mesh, noise=self.noise, drop=self.drop, pace=self.pace
        )


@dataclass(frozen=True)
class Choice:
    """What to connect to: a serial port, a socket's address, or the virtual ribbon."""

    kind: Kind = "virtual"
    port: str = ""
    address: str = ""
    baudrate: int = BAUDRATE
    virtual: VirtualChoice = field(default_factory=VirtualChoice)


def kept_choice(settings: Kept) -> Choice:
    """What was chosen last; whatever is not to be understood is as at first."""
    try:
        found = json.loads(settings.get(ENTRY, ""))
    except (ValueError, RecursionError):
        return Choice()
    if not isinstance(found, dict):
        return Choice()
    virtual = found.get("virtual")
    made = _read(VirtualChoice(), virtual if isinstance(virtual, dict) else {})
    choice = _read(Choice(virtual=made), found)
    return choice if choice.kind in KINDS else Choice(virtual=made)


def keep_choice(settings: Kept, choice: Choice) -> None:
    """Remember it."""
    settings.put(ENTRY, json.dumps(asdict(choice)))


def _read(first: T, found: dict[str, Any]) -> T:
    """The entries of the right type and within their bounds, in the place of the first ones."""
    values = {
        one.name: found[one.name]
        for one in fields(first)
        if type(found.get(one.name)) is type(getattr(first, one.name))
        and _within(one.name, found[one.name])
    }
    return type(first)(**{one.name: getattr(first, one.name) for one in fields(first)} | values)


BOUNDS = {
    "passes": (2, MOST_PASSES),
    "ties": (0, MOST_TIES),
    "noise": (0.0, MOST_NOISE),
    "drop": (0.0, MOST_DROP),
    "pace": (0.0, 10.0),
    "baudrate": (1, 50_000_000),
}


def _within(name: str, value: Any) -> bool:
    """Whether a value is one that can be meant; NaN is none."""
    low, high = BOUNDS.get(name, (None, None))
    return low is None or low <= value <= high
