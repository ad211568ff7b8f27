"""Values out of a table that came from outside, each checked and named.

The tables of `recording.toml` and the rows of a session file go through the
same checks; what is wrong is told with the source, the line where there is
one, the table and the field.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn

from georibbon.errors import GeoribbonError
from georibbon.session.words import nearest, told

MAX_NAME = 200
MAX_TEXT = 10_000
MAX_NUMBER = 1e9
MIN_POSITIVE = 1e-9


@dataclass(frozen=True)
class Source:
    """Where tables came from: its name for the person, and the error that blames it.

    text: the TOML they were read from, to tell lines; None where there are none.
    """

    name: str
    error: type[GeoribbonError]
    text: str | None = None

    def refuse(self, message: str) -> NoReturn:
        """Raise the source's error with its name before the message."""
        raise self.error(f"{self.name}: {message}")

    def line(self, table: str, index: int, key: str | None) -> int | None:
        """The line of a field (or, without it, of the table's header), from 1; None if unknown."""
        if self.text is None:
            return None
        pattern = re.compile(r"[ \t]*\[\[?[ \t]*" + re.escape(table) + r"[ \t]*\]")
        field = key and re.compile(r"[ \t]*[\"']?" + re.escape(key) + r"[\"']?[ \t]*=")
        lines = self.text.split("\n")
        headers = [i for i, line in enumerate(lines) if pattern.match(line)] if table else [-1]
        if index >= len(headers):
            return None
        header = headers[index]
        for i in range(header + 1, len(lines)):
            if field and field.match(lines[i]):
                return i + 1
            if lines[i].lstrip().startswith("["):
                break
        return header + 1 if table else None


class Table:
    """One table of a source, its fields taken out one by one.

    name: as written in TOML ("ribbon.sensor"; "" for the top); index: its
    number among the tables of that name, from 0, or None where there is but one.
    """

    def __init__(
        self, data: object, source: Source, name: str, index: int | None, known: tuple[str, ...]
    ) -> None:
        self.source = source
        self.name = name
        self.index = index
        if not isinstance(data, Mapping):
            self.refuse(None, f"it is {told(data)}; a table [{name}] is expected")
        self.data: Mapping[str, object] = data
        for key in data:
            if key not in known:
                fields = ", ".join(known)
                hint = nearest(key, known) or f"; known here are {fields}"
                self.refuse(key, f"the field {told(key)} is not known{hint}")

    def refuse(self, key: str | None, message: str) -> NoReturn:
        """Raise the source's error for a field of this table, or for the table."""
        line = self.source.line(self.name, self.index or 0, key)
        place = f", line {line}" if line else ""
        raise self.source.error(f"{self.source.name}{place}: {self._title()}{message}")

    def _title(self) -> str:
        if not self.name:
            return ""
        if self.index is None:
            return f"[{self.name}]: "
        label = ""
        if isinstance(self._data_name(), str):
            label = f" ({told(self._data_name())})"
        return f"[[{self.name}]] number {self.index + 1}{label}: "

    def _data_name(self) -> object:
        data = getattr(self, "data", {})
        return data.get("name", data.get("pass"))

    def _take(self, key: str, expected: str) -> object:
        if key not in self.data:
            self.refuse(None, f"the field {key} is missing; {expected} is expected")
        return self.data[key]

    def text(self, key: str, expected: str, limit: int = MAX_NAME) -> str:
        """A text in one line, not empty, of printable characters."""
        value = self._string(key, expected, limit)
        if not value.strip():
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        self._check_printable(key, value)
        return value

    def prose(self, key: str, expected: str) -> str:
        """A text that may have several lines, or none."""
        value = self._string(key, expected, MAX_TEXT)
        self._check_printable(key, value.replace("\n", "").replace("\t", ""))
        return value

    def _string(self, key: str, expected: str, limit: int) -> str:
        value = self._take(key, expected)
        if not isinstance(value, str):
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        if len(value) > limit:
            self.refuse(key, f"{key} has {len(value)} characters; at most {limit} are expected")
        return value

    def _check_printable(self, key: str, value: str) -> None:
        if not value.isprintable():
            self.refuse(key, f"{key} is {told(value)}; leave out its control characters")

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """One of a few words."""
        expected = " or ".join(f'"{c}"' for c in choices)
        value = self._take(key, expected)
        if not isinstance(value, str) or value not in choices:
            hint = nearest(value, choices) if isinstance(value, str) else ""
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected{hint}")
        return value

    def flag(self, key: str, expected: str) -> bool:
        """True or false."""
        value = self._take(key, expected)
        if not isinstance(value, bool):
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        return value

    def whole(self, key: str, expected: str) -> int:
        """A whole number."""
        value = self._take(key, expected)
        if isinstance(value, bool) or not isinstance(value, int):
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        return value

    def number(self, key: str, expected: str) -> float:
        """A finite number, at most `MAX_NUMBER` in magnitude."""
        return self._finite(key, self._take(key, expected), expected)

    def positive(self, key: str, expected: str) -> float:
        """A finite number greater than 0, and not so small that its square vanishes."""
        value = self.number(key, expected)
        if value < MIN_POSITIVE:
            least = f" (at least {MIN_POSITIVE:g})" if value > 0.0 else ""
            self.refuse(key, f"{key} is {told(self.data[key])}; {expected} is expected{least}")
        return value

    def numbers(self, key: str, count: int, expected: str) -> tuple[float, ...]:
        """An array of `count` finite numbers."""
        return tuple(self._finite(key, v, expected) for v in self._array(key, count, expected))

    def names(self, key: str, count: int, expected: str) -> tuple[str, ...]:
        """An array of `count` texts."""
        values = self._array(key, count, expected)
        for value in values:
            if not isinstance(value, str):
                self.refuse(key, f"{key} holds {told(value)}; {expected} is expected")
        return tuple(str(value) for value in values)

    def _array(self, key: str, count: int, expected: str) -> list[object]:
        value = self._take(key, expected)
        if not isinstance(value, list) or len(value) != count:
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        return value

    def _finite(self, key: str, value: object, expected: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(key, f"{key} is {told(value)}; {expected} is expected")
        if abs(value) > MAX_NUMBER:
            self.refuse(key, f"{key} is {told(value)}; at most {MAX_NUMBER:g} is expected")
        if math.isnan(value):
            self.refuse(key, f"{key} is nan; {expected} is expected")
        return float(value)
