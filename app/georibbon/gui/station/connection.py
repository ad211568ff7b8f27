"""One connection: the link to a ribbon, and the virtual ribbon where it is one; without Qt.

Made and closed in a worker thread: both may take a while.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from georibbon.capture.link_diary import LinkDiary
from georibbon.device.link import Link
from georibbon.device.ports import BAUDRATE
from georibbon.errors import SettingsError
from georibbon.ribbon import Ribbon

if TYPE_CHECKING:
    from georibbon.virtual import Port, VirtualRibbon, VirtualSettings

Way = Literal["pty", "tcp"]


@dataclass(frozen=True)
class Connection:
    """A link that is not started yet, and what it leads to.

    diary: made before the link starts, so that it misses nothing.  virtual,
    served: None for a real ribbon.
    """

    link: Link
    diary: LinkDiary
    virtual: VirtualRibbon | None = None
    served: Port | None = None

    def close(self) -> None:
        """Stop the link and the virtual ribbon; raises what ended the virtual one before."""
        self.link.stop()
        if self.served is not None:
            self.served.close()


def to_port(
    url: str,
    baudrate: int | None = None,
    ribbon_id: str | None = None,
    ribbon: Ribbon | None = None,
) -> Connection:
    """To a ribbon at a serial port or a socket; DeviceError for what cannot be meant."""
    link = Link(
        url,
        ribbon_id=ribbon_id,
        ribbon=ribbon,
        baudrate=BAUDRATE if baudrate is None else baudrate,
    )
    return Connection(link, LinkDiary(link))


def to_virtual(
    settings: VirtualSettings | Callable[[], VirtualSettings] | None, way: Way
) -> Connection:
    """To a virtual ribbon of our own, through a real port.

    settings: or what makes them.  way: "pty", or "tcp", which is also taken where there are no
    pseudo-terminals.  Raises what a `VirtualRibbon` refuses.
    """
    # A real ribbon needs nothing of this, and it takes a while to load.
    from georibbon.virtual import VirtualRibbon

    world = VirtualRibbon(settings() if callable(settings) else settings)
    served = _serve(world, way)
    try:
        link = Link(served.url, ribbon_id=world.ribbon.id)
        return Connection(link, LinkDiary(link), world, served)
    except BaseException:
        served.close()
        raise


def _serve(world: VirtualRibbon, way: Way) -> Port:
    from georibbon.virtual import serve_pty, serve_tcp

    if way == "pty":
        try:
            return serve_pty(world)
        except SettingsError:  # this system has none, or none is to be had now
            pass
    return serve_tcp(world)
