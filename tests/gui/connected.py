"""What the tests of connections share: parts without a window, and a small virtual ribbon."""

from types import SimpleNamespace

from georibbon.device.telling import LinkState
from georibbon.gui.capture_desk import CaptureDesk
from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.station.station import Station
from georibbon.gui.units import Units
from georibbon.simulation import LayoutSettings, RibbonSettings, SimulationSettings
from georibbon.virtual import VirtualSettings

SMALL = VirtualSettings(
    SimulationSettings(
        "dome",
        ribbon=RibbonSettings(sensors=8, length=0.24),
        layout=LayoutSettings(passes=2, ties=1),
        seed=5,
    ),
    pace=0.0,
)
WAIT = 20_000  # ms


def make_parts(folder) -> SimpleNamespace:
    """The parts that a window gives its pages; `end_parts` ends them."""
    station, document = Station(), Document()
    return SimpleNamespace(
        settings=Settings(folder / "settings.ini"),
        notifier=Notifier(),
        document=document,
        units=Units(),
        station=station,
        capture=CaptureDesk(station, document),
    )


def end_parts(parts) -> None:
    """Nothing of them goes on."""
    parts.capture.end()
    parts.document.end()
    parts.station.end()


def stream(qtbot, parts, settings=SMALL) -> None:
    """Connect a virtual ribbon, and wait for its frames."""
    parts.station.connect_virtual(settings)
    qtbot.waitUntil(lambda: parts.station.state is LinkState.STREAMING, timeout=WAIT)
