"""What a report's pages say, be they HTML or PDF: numbers and rows as a person reads them."""

from datetime import datetime
from pathlib import PurePath
from typing import Any

METHOD_WORDS = {
    "ribbon": "ribbon fit with the survey inside",
    "paper": "the source paper's spherical splines",
}
TANGENT_WORDS = {
    "unrolled": "",
    "averages": ", tangents by averages on the sphere",
    "components": ", tangents by components",
}
SIGNS = {
    "good": "✔",
    "pass": "✔",
    "acceptable": "!",
    "warn": "!",
    "redo": "✖",
    "fail": "✖",
}
"""A verdict's sign, beside its word and its colour."""


def method_words(data: dict[str, Any]) -> str:
    """How the passes of a report were fitted."""
    tangents = TANGENT_WORDS[data["tangents"]] if data["method"] == "paper" else ""
    return METHOD_WORDS[data["method"]] + tangents


def page_title(source: str, title: str | None) -> str:
    """The page's heading: what the object is called, or the name of its source."""
    return title or PurePath(source).name or source


def date_words(created: datetime | None) -> str:
    """A date and time to the minute with its zone; now where it is None."""
    return (created or datetime.now()).astimezone().isoformat(" ", "minutes")


def number(value: float | None, digits: int) -> str:
    """A number as a person reads it; a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}f}"


def chosen_words(passes: list[dict[str, Any]]) -> list[str]:
    """What a person chose of the passes, a sentence for those alike; none where nothing was."""
    alike: dict[str, list[str]] = {}
    for one in passes:
        words = []
        if one["weight"] != 1.0:
            words.append(f"counts {one['weight']:g} times")
        start, end = one["trim_mm"]
        if start or end:
            words.append(f"cut off {start:g} mm at the beginning and {end:g} mm at the end")
        if one["sensors_off"]:
            words.append(f"switched off {', '.join(one['sensors_off'])}")
        if words:
            alike.setdefault("; ".join(words), []).append(one["name"])
    return [f"{', '.join(names)}: {words}" for words, names in alike.items()]


def check_rows(checks: list[dict[str, Any]]) -> list[dict[str, str]]:
    """The checks as a person reads them: each that is amiss, then one line a kind that passes."""
    rows = [{**check, "found": _found([check])} for check in checks if check["verdict"] != "pass"]
    passed: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        if check["verdict"] == "pass":
            passed.setdefault(check["code"], []).append(check)
    for code, same in passed.items():
        places = [check["where"] for check in same]
        rows.append(
            {
                "code": code,
                "where": places[0] if len(same) == 1 else f"{places[0]} to {places[-1]}",
                "verdict": "pass",
                "found": _found(same),
                "message": same[0]["message"] if len(same) == 1 else f"passes in all {len(same)}",
            }
        )
    return rows


def _found(checks: list[dict[str, Any]]) -> str:
    """What checks of one kind found: a value, or the least and the greatest, with the unit."""
    values = [check["value"] for check in checks if check["value"] is not None]
    if not values:
        return "–"
    least, greatest, unit = _short(min(values)), _short(max(values)), checks[0]["unit"]
    return f"{least if least == greatest else f'{least} to {greatest}'} {unit}".strip()


def _short(value: float) -> str:
    """A number to three digits; what would be less than a thousandth is 0."""
    return f"{value:.3g}" if abs(value) >= 5e-4 else "0"
