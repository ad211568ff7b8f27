"""The virtual ribbon: one that is not there, on a wire that is."""

from georibbon.virtual.commands import COMMANDS
from georibbon.virtual.ports import Port, serve_pty, serve_tcp
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import MeshSettings, VirtualSettings
from georibbon.virtual.wire import Sent

__all__ = [
    "COMMANDS",
    "MeshSettings",
    "Port",
    "Sent",
    "VirtualRibbon",
    "VirtualSettings",
    "serve_pty",
    "serve_tcp",
]
