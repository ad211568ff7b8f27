"""The virtual capture of the demonstration, as `resources/demonstration.toml` describes it."""

import tomllib
from typing import Any

from georibbon.resources import resource
from georibbon.simulation.settings import SimulationSettings, changed


def demonstration_settings() -> SimulationSettings:
    """A car bonnet with seven passes and two ties."""
    text = resource("demonstration.toml").read_text(encoding="utf-8")
    return changed(SimulationSettings(), _flat(tomllib.loads(text)))


def _flat(table: dict[str, Any], room: str = "") -> dict[str, Any]:
    """Nested tables as dotted names, lists as tuples."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{room}{key}.")
        else:
            flat[room + key] = tuple(value) if isinstance(value, list) else value
    return flat
