"""The connection's health in the status bar: a sign, words and figures, as many as have room."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QToolButton, QWidget

from georibbon.gui.connect.signs import SIZE, sign_icon, sign_of
from georibbon.gui.connect.words import state_words
from georibbon.gui.language import sentence, tr, trn
from georibbon.gui.theme import colours_of

if TYPE_CHECKING:
    from georibbon.device.health import Health
    from georibbon.gui.parts import Parts

NARROWEST = 34  # px: the sign alone
SLACK = 40  # px for figures that grow: it would say less for a moment each time
ROUND = 14  # px beside the text: the frame and the gap to the sign


class HealthStrip(QToolButton):
    """How the ribbon's connection is.  asked(): a person wants to see the Connect page.

    The protocol has no temperature, so none is shown.
    """

    asked = Signal()

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._station = parts.station
        self._health: Health | None = None
        self.setAutoRaise(True)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setIconSize(QSize(SIZE, SIZE))
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setStatusTip(tr("How the ribbon's connection is; press it to see the Connect page"))
        self.clicked.connect(self.asked)
        station = parts.station
        station.changed.connect(self._show)
        station.identified.connect(self._show)
        station.disconnected.connect(self._show)
        station.health_changed.connect(self._take)
        self._show()

    @property
    def words(self) -> str:
        """Everything that is shown where there is room for it."""
        return self._texts()[0]

    def sizeHint(self) -> QSize:
        """Room for everything."""
        size = super().sizeHint()
        return QSize(self._width(self.words) + SLACK, size.height())

    def minimumSizeHint(self) -> QSize:
        """Room for the sign."""
        return QSize(NARROWEST, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Say as much as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_station"):
            self._show()

    # --- inside ---

    def _take(self, health: Health) -> None:
        self._health = health
        self._show()

    def _show(self, *_: object) -> None:
        station = self._station
        if not station.active:
            self._health = None
        known = station.identity is not None
        sign = sign_of(station.state, known)
        self.setIcon(sign_icon(sign, colours_of(self.palette()), self.devicePixelRatioF()))
        self.setToolTip(self._details())
        self.setAccessibleName(tr("Ribbon: {words}", words=self.words))
        self.updateGeometry()
        self._fit()

    def _fit(self) -> None:
        room = self.width()
        texts = self._texts()
        fitting = next((text for text in texts if self._width(text) <= room), "")
        self.setText(fitting)

    def _width(self, text: str) -> int:
        return self.fontMetrics().horizontalAdvance(text) + SIZE + ROUND

    def _texts(self) -> list[str]:
        """What may be said, the longest first."""
        station, health = self._station, self._health
        identity = station.identity
        words = state_words(station.state, identity is not None)
        if identity is None:
            return [words]
        named = f"{identity.ribbon.id} {words}"
        if health is None:
            return [named, words]
        rate = tr("{n} frames/s", n=f"{health.frames_per_second:.0f}")
        bad = _figures(health)
        troubles = [text for text, count in bad if count]
        brief = " · ".join([rate, *troubles])
        return [
            " · ".join([named, rate, *(text for text, _ in bad)]),
            f"{named} · {brief}",
            f"{words} · {brief}",
            brief,
            rate,
        ]

    def _details(self) -> str:
        station, health = self._station, self._health
        lines = [state_words(station.state, station.identity is not None), sentence(station.reason)]
        if station.url is not None:
            lines.append(tr("at {url}", url=station.url))
        if health is not None:
            lines += [
                tr("{n} frames since the connection began", n=health.frames),
                *(text for text, _ in _figures(health)),
                tr("{n} of a kind not known", n=health.unknown),
                trn("{n} restart of the ribbon", "{n} restarts of the ribbon", health.restarts),
            ]
        lines.append(tr("Press it to see the Connect page."))
        return "\n".join(line for line in lines if line)


def _figures(health: Health) -> list[tuple[str, int]]:
    """What may go wrong, each with how often it did."""
    return [
        (tr("{n} lost", n=health.lost), health.lost),
        (tr("{n} damaged", n=health.damaged), health.damaged),
        (trn("{n} stall", "{n} stalls", health.stalls), health.stalls),
        (trn("{n} reconnect", "{n} reconnects", health.reconnects), health.reconnects),
    ]
