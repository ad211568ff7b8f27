"""Poses and what becomes of them in words of the person's language."""

import re
from collections.abc import Sequence

from georibbon.capture.plan import PlannedPose
from georibbon.gui.calibrating.state import Card, face_words
from georibbon.gui.language import N_, sentence, tr

FACES = {
    "top": N_("upper face up"),
    "left": N_("left edge up"),
    "under": N_("face down"),
    "right": N_("right edge up"),
}
STATES = {
    "open": N_("open"),
    "asked": N_("asked"),
    "good": N_("taken"),
    "poor": N_("poor"),
    "refused": N_("refused"),
    "skipped": N_("left out"),
}
VERDICTS = {
    "good": N_("good"), "usable": N_("usable"), "calibrate": N_("calibrate again"),
}  # fmt: skip


_KEY = re.compile(r"\bpose-\d+")


def told_words(text: str, cards: Sequence[Card] = ()) -> str:
    """A sentence of the core as a person reads it: poses named as their cards are."""
    names = {card.key: pose_name(card.number) for card in cards}
    return _KEY.sub(lambda found: names.get(found[0], found[0]), sentence(text))


def pose_name(number: int) -> str:
    """A pose as its card is headed."""
    return tr("Pose {number}", number=number)


def where_words(pose: PlannedPose) -> str:
    """How it lies: flat, or with one end lifted."""
    if pose.table:
        return tr("flat on the table")
    if pose.pitch > 0:
        return tr("its end on a block, {degrees}°", degrees=f"{abs(pose.pitch):.0f}")
    return tr("its start on a block, {degrees}°", degrees=f"{abs(pose.pitch):.0f}")


def short_where(pose: PlannedPose) -> str:
    """The same for a card."""
    if pose.table:
        return tr("flat")
    return tr("end up") if pose.pitch > 0 else tr("start up")


def pose_words(pose: PlannedPose) -> str:
    """What to do with the bar, in one line."""
    return tr(
        "{face}, {where}, turned to {heading}°",
        face=tr(FACES[face_words(pose)]),
        where=where_words(pose),
        heading=f"{pose.heading:.0f}",
    )


def card_words(pose: PlannedPose) -> str:
    """What to do with the bar, in two short lines."""
    face = tr(FACES[face_words(pose)])
    return (
        face
        + "\n"
        + tr("{where}, {heading}°", where=short_where(pose), heading=f"{pose.heading:.0f}")
    )


def card_told(card: Card) -> str:
    """All of a card in one sentence, for who cannot see it."""
    told = tr(
        "{name}: {pose}; {state}",
        name=pose_name(card.number),
        pose=pose_words(card.pose),
        state=tr(STATES[card.state]),
    )
    return f"{told}: {sentence(card.reason)}" if card.reason else told
