"""What happened to a link, in order, as a session keeps it."""

import time
from collections import deque
from dataclasses import asdict

from georibbon.device.link import Change, Event, Link
from georibbon.session.words import counted

LOSSES = 1.0  # seconds between two entries about what was lost, at least
MOST_WAITING = 500  # of news; nobody takes any while nothing is captured


class LinkDiary:
    """Collects a link's changes, events and losses; made before the link is started.

    An entry is the detail of a session's `link` event: state, reason, and all
    figures of the link's health when the entry was taken.  Of what nobody takes
    the newest is kept.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self._news: deque[Change | Event] = deque(maxlen=MOST_WAITING)
        self._seen = (0, 0)
        self._next_loss = 0.0
        link.on_change(self._news.append)
        link.on_event(self._news.append)

    def take(self, *, last: bool = False) -> list[dict[str, object]]:
        """The entries since the last call; last: with every loss, however short ago."""
        entries = []
        while self._news:
            news = self._news.popleft()
            if isinstance(news, Change):
                entries.append(self._entry(news.reason) | {"state": str(news.state)})
            else:
                entries.append(self._entry(news.message))
        return entries + self._losses(last)

    def _losses(self, last: bool) -> list[dict[str, object]]:
        health = self._link.health()
        lost, damaged = health.lost - self._seen[0], health.damaged - self._seen[1]
        if not (lost or damaged) or (time.monotonic() < self._next_loss and not last):
            return []
        self._seen = (health.lost, health.damaged)
        self._next_loss = time.monotonic() + LOSSES
        return [self._entry(f"{counted(lost, 'packet')} lost, {damaged} damaged")]

    def _entry(self, reason: str) -> dict[str, object]:
        health = self._link.health()
        return asdict(health) | {"state": str(health.state), "reason": reason}
