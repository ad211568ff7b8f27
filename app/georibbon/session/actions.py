"""Events in words, for a person."""

from collections.abc import Callable, Mapping, Sequence

from georibbon.session.events import EVERY_PASS, Event
from georibbon.session.words import told

Detail = Mapping[str, object]


def in_words(event: Event) -> str:
    """What an event did, short, such as "pass P3" or "the removal of pass P3"."""
    words = _WORDS.get(event.action, event.action)
    return words if isinstance(words, str) else words(event.detail)


def _plain(value: object) -> str:
    """A value without the marks of a text."""
    return told(value).strip('"')


def _named(detail: Detail) -> str:
    return " ".join(f"{kind} {_plain(name)}" for kind, name in detail.items())


def _setting(detail: Detail) -> str:
    return setting_in_words(_plain(detail.get("pass")), _plain(detail.get("key")))


def setting_in_words(whose: str, key: str) -> str:
    """A setting, such as "the smoothing of pass P3"; whose: a pass's name or "*"."""
    if whose == EVERY_PASS and key in _OF_ALL:
        return _OF_ALL[key]
    of = "all passes" if whose == EVERY_PASS else f"pass {whose}"
    return f"the {_OF_PASS.get(key, key)} of {of}"


def _settings(detail: Detail) -> str:
    changes = detail.get("changes")
    listed = [one for one in changes if isinstance(one, dict)] if isinstance(changes, list) else []
    return settings_in_words([(_plain(one.get("pass")), _plain(one.get("key"))) for one in listed])


def settings_in_words(places: Sequence[tuple[str, str]]) -> str:
    """Settings by whose and key, such as "the smoothing of all passes"."""
    if len(places) == 1:
        return setting_in_words(*places[0])
    keys = sorted({key for _, key in places})
    passes = sorted({whose for whose, _ in places})
    if len(keys) == 1:
        return setting_in_words(EVERY_PASS, keys[0])
    if keys and all(key.startswith("surface.") for key in keys):
        return "the settings of the surface"
    one = len(passes) == 1 and passes[0] != EVERY_PASS
    return f"the settings of pass {passes[0]}" if one else "the settings of all passes"


def _link(detail: Detail) -> str:
    reason = detail.get("reason")
    return f"link {_plain(detail.get('state'))}" + (f": {_plain(reason)}" if reason else "")


_OF_PASS = {"sensors_off": "switched-off sensors", "trim": "trimmed ends"}
_OF_ALL = {
    "calibration": "the choice of the calibration",
    "method": "the method",
    "neighbours": "the neighbours' say",
    "tangents": "the interpolation of the tangents",
    "surface.tolerance": "the surface's tolerance",
    "surface.thickness": "the surface's thickness",
    "surface.direction": "the surface's direction across",
    "surface.lengths": "the surface's tangent lengths",
    "surface.correspondence": "the surface's correspondence",
    "surface.interior": "the surface's smoothness across passes",
    "surface.angles": "the surface's angles across",
    "surface.cells": "the surface's cells between passes and ties",
}
_WORDS: dict[str, str | Callable[[Detail], str]] = {
    "created": "the session was made",
    "title": "the title",
    "workpiece": "the workpiece's frame",
    "plan": "the plan of the capture",
    "order": "the order of the passes",
    "survey": "the survey",
    "calibration": "the calibration",
    "opened": "the file was opened",
    "closed": "the file was closed",
    "ribbon": lambda detail: f"ribbon {_plain(detail.get('id'))}",
    "pose": lambda detail: f"pose {_plain(detail.get('key'))}",
    "pass": lambda detail: f"{_plain(detail.get('kind'))} {_plain(detail.get('name'))}",
    "remove": lambda detail: f"the removal of {_named(detail)}",
    "skip": lambda detail: f"skipping {_named(detail)}",
    "setting": _setting,
    "settings": _settings,
    "note": lambda detail: f"the note {told(detail.get('text'))}",
    "undo": lambda detail: f"undoing of event {_plain(detail.get('of'))}",
    "redo": lambda detail: f"redoing of event {_plain(detail.get('of'))}",
    "stream": lambda detail: f"frames in part {_plain(detail.get('part'))}",
    "link": _link,
    "recovered": lambda detail: f"recovered up to {_plain(detail.get('to'))}",
    "moved": lambda detail: f"moved from {_plain(detail.get('from'))}",
}
