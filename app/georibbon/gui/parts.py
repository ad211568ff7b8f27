"""What every page and panel is given: the program's parts that there is one of."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from georibbon.gui.capture_desk import CaptureDesk
    from georibbon.gui.document import Document
    from georibbon.gui.notifier import Notifier
    from georibbon.gui.settings import Settings
    from georibbon.gui.station.station import Station
    from georibbon.gui.units import Units


@dataclass(frozen=True, eq=False)
class Parts:
    """What pages and panels read and send what a person wants to; they know no other."""

    settings: "Settings"
    notifier: "Notifier"
    document: "Document"
    units: "Units"
    station: "Station"
    capture: "CaptureDesk"
