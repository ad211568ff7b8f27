"""The settings of a reconstruction as a session keeps them: one value for a pass and a key.

A value is what JSON can hold; null takes a setting back.  Of a pass, or "*" for
all others: smoothing (metres), sensors_off (a list of names), trim (two
lengths, metres), weight.  Of all together ("*" alone): method, neighbours,
tangents, and surface.tolerance, surface.thickness, surface.direction and the
other fields of `SurfaceSettings`.  Other keys are another program's, and kept as they are.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, replace
from typing import Any

from georibbon.errors import SessionError, SettingsError
from georibbon.fitting.settings import EVERY, ReconstructionSettings
from georibbon.geometry.settings import SurfaceSettings
from georibbon.session.words import nearest, told

Values = Mapping[tuple[str, str], object]

SURFACE = "surface."
CELLS = "surface.cells"
BY_PASS = ("smoothing", "sensors_off", "trim", "weight")
OF_SURFACE = tuple(SURFACE + field.name for field in fields(SurfaceSettings))
KEYS = (*BY_PASS, "method", "neighbours", "tangents", *OF_SURFACE)
MOST_NAMES = 10_000
LONGEST_WORD, LONGEST_LIST = 100, 100  # of the surface's settings and the method
MOST_WHOLE = 2**53


def with_setting(
    settings: ReconstructionSettings, whose: str, key: str, value: object
) -> ReconstructionSettings:
    """The settings with one of another value; None: as where nothing is chosen.

    whose: a pass's name, or "*".  Raises SettingsError for a key that is none,
    for one of all passes that is given to one, and for a value that means nothing.
    """
    if key in BY_PASS:
        values: Any = dict(getattr(settings, key))
        values.pop(whose, None)
        if value is not None:
            values[whose] = _READ[key](value, whose)
        return replace(settings, **{key: values})
    if key not in KEYS:
        raise SettingsError(f"there is no setting {told(key)}{nearest(key, KEYS)}")
    if whose != EVERY:
        raise SettingsError(f"{key} is a setting of all passes together, not of pass {whose}")
    if key.startswith(SURFACE):
        surface = settings.surface or SurfaceSettings()
        name = key.removeprefix(SURFACE)
        chosen: Any = getattr(SurfaceSettings(), name) if value is None else _of_surface(key, value)
        return replace(settings, surface=replace(surface, **{name: chosen}))
    usual = getattr(ReconstructionSettings(), key)
    wanted: Any = usual if value is None else _READ[key](value, whose)
    return replace(settings, **{key: wanted})


def settings_of(values: Values, passes: Collection[str], name: str) -> ReconstructionSettings:
    """The settings that values say, those of passes that are not there left out.

    name: the session's, for messages.  Raises SessionError for the first value
    that means nothing.
    """
    settings, wrong = sound_settings(values, passes)
    if wrong:
        raise SessionError(f"{name}: {wrong[0]}")
    return settings


def sound_settings(
    values: Values, passes: Collection[str]
) -> tuple[ReconstructionSettings, tuple[str, ...]]:
    """The settings that sound values say, and for each that means nothing a sentence."""
    settings, wrong = ReconstructionSettings(), []
    for (whose, key), value in values.items():
        if key in KEYS and (whose == EVERY or whose in passes):
            try:
                settings = with_setting(settings, whose, key, value)
            except SettingsError as error:
                wrong.append(str(error))
    return settings, tuple(wrong)


def _of_surface(key: str, value: object) -> object:
    """A value of the surface's: a truth where one is expected, else what is listed."""
    return value if key == CELLS and isinstance(value, bool) else _listed(value)


def _listed(value: object) -> object:
    """A word, a number, or a list of numbers as the tuple that settings hold; nothing endless."""
    if isinstance(value, str) and len(value) <= LONGEST_WORD:
        return value
    if isinstance(value, list | tuple):
        if len(value) <= LONGEST_LIST and all(map(_is_number, value)):
            return tuple(value)
    elif _is_number(value):
        return value
    raise SettingsError(f"{told(value)} is found; a word, a number or a list is expected")


def _is_number(value: object) -> bool:
    """Whether it is a number that a float can hold; a truth is none."""
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) <= MOST_WHOLE
    return isinstance(value, float)


def _smoothing(value: object, whose: str) -> float:
    return _number(value, f"the smoothing of {told(whose)}", "a number of metres")


def _weight(value: object, whose: str) -> float:
    return _number(value, f"the weight of {told(whose)}", "a number")


def _number(value: object, what: str, expected: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise SettingsError(f"{what} is {told(value)}; {expected} is expected")
    return float(value) if _is_number(value) else float("inf")


def _trim(value: object, whose: str) -> tuple[float, float]:
    if not (isinstance(value, list | tuple) and len(value) == 2 and all(map(_is_number, value))):
        raise SettingsError(
            f"the trimmed ends of {told(whose)} are {told(value)}; two numbers of metres are "
            "expected"
        )
    start, end = (_number(one, f"an end of {told(whose)}", "a number of metres") for one in value)
    return start, end


def _sensors_off(value: object, whose: str) -> tuple[str, ...]:
    if isinstance(value, list | tuple) and len(value) <= MOST_NAMES:
        names = [one for one in value if isinstance(one, str)]
        if len(names) == len(value):
            return tuple(dict.fromkeys(names))
    raise SettingsError(
        f"the sensors switched off in {told(whose)} are {told(value)}; a list of names is expected"
    )


def _method(value: object, _whose: str) -> str:
    return _word(value, "the method is")


def _tangents(value: object, _whose: str) -> str:
    return _word(value, "the tangents are")


def _word(value: object, what: str) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_WORD:
        raise SettingsError(f"{what} {told(value)}; a word is expected")
    return value


def _neighbours(value: object, _whose: str) -> bool:
    if not isinstance(value, bool):
        raise SettingsError(f"neighbours is {told(value)}; true or false is expected")
    return value


_READ: dict[str, Callable[[object, str], object]] = {
    "smoothing": _smoothing,
    "sensors_off": _sensors_off,
    "trim": _trim,
    "weight": _weight,
    "method": _method,
    "neighbours": _neighbours,
    "tangents": _tangents,
}
