"""Reading the words of the command line: refusals in one sentence, numbers with units."""

import argparse
import math
import re
from collections.abc import Callable
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """An argument parser that refuses in one sentence, and keeps the layout of its texts."""

    def __init__(self, **settings: Any) -> None:
        settings.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **settings)
        # a value, not an option: by itself a parser knows -10, but not lists such as -10,0,0,0
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    def error(self, message: str) -> NoReturn:
        """Print the refusal and exit with 2."""
        self.exit(2, f"georibbon: error: {message}; {self.prog} --help explains\n")

    def teach(self, description: str, epilog: str) -> None:
        """Give the command its description and its examples."""
        self.description, self.epilog = description, epilog


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no finite number")
    return value


def _at_least(minimum: float, included: bool, what: str) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = number(text)
        if value < minimum or (value == minimum and not included):
            raise argparse.ArgumentTypeError(f"{text} found, {what} expected")
        return value

    return read


def millimetres(text: str) -> float:
    """A length above zero written in millimetres; returns metres."""
    return _at_least(0.0, False, "a length above 0 mm")(text) / 1000.0


def zero_or_millimetres(text: str) -> float:
    """A length in millimetres that may be 0; returns metres."""
    return _at_least(0.0, True, "a length of 0 mm or more")(text) / 1000.0


def whole(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number") from error


def pair(text: str, what: str) -> tuple[str, str]:
    """The two sides of NAME=VALUE; the name may hold equals signs itself."""
    name, sign, value = text.rpartition("=")
    if not sign or not name:
        raise argparse.ArgumentTypeError(f"{text!r} found, {what} expected")
    return name, value


def above_zero(text: str) -> float:
    """A number above zero."""
    return _at_least(0.0, False, "a number above 0")(text)


def add_link_options(parser: Parser) -> None:
    """The words that say which ribbon, and how to speak with it."""
    parser.add_argument(
        "url", metavar="URL", help="the ribbon's port: /dev/tty…, COM… or socket://HOST:PORT"
    )
    parser.add_argument(
        "--rate", metavar="HZ", type=above_zero,
        help="ask the ribbon for so many frames a second",
    )  # fmt: skip
    parser.add_argument(
        "--baud", metavar="N", type=_baud, default=921600,
        help="the port's speed (default %(default)s)",
    )  # fmt: skip
    parser.add_argument("--id", metavar="RIBBON", help="refuse any other ribbon than this one")


def _baud(text: str) -> int:
    value = whole(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} found, a whole number above 0 expected")
    return value
