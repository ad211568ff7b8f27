"""The licences of what an installer of Georibbon would ship.

Read from the installed packages' own metadata: Georibbon's requirements, what
those require, and so on, and Python itself; never the tools that only build or test it.
"""

import platform
import re
import sysconfig
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from georibbon.resources import resource

PROGRAM = "georibbon"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_LICENCE_FILE = re.compile(r"(^|[-_./ ])(licen[cs]es?|copying|notice|copyright)", re.IGNORECASE)
_LONGEST_NAME = 60


@dataclass(frozen=True)
class Licence:
    """One package's name, version and licence, with the texts that come with it."""

    name: str
    version: str
    licence: str
    texts: tuple[str, ...]


def licences() -> tuple[Licence, ...]:
    """Georibbon's own licence, Python's, then those of all it needs to run, by name."""
    own, *others = _closure(PROGRAM)
    packages = sorted(others, key=lambda package: _normal(package.name))
    return (_licence(own), _python(), *(_licence(package) for package in packages))


def _python() -> Licence:
    """The interpreter's own; its text where this Python came with one."""
    text = Path(sysconfig.get_path("stdlib"), "LICENSE.txt")
    texts = (text.read_text(encoding="utf-8"),) if text.is_file() else ()
    return Licence("Python", platform.python_version(), "PSF-2.0", texts)


def _closure(name: str) -> list[Distribution]:
    """The distribution and all it requires when it runs, each once."""
    found: dict[str, Distribution] = {}
    waiting = [name]
    while waiting:
        key = _normal(waiting.pop(0))
        if key in found:
            continue
        try:
            found[key] = distribution(key)
        except PackageNotFoundError:
            # A requirement for another system or another Python: not shipped here.
            continue
        waiting.extend(_requirements(found[key].requires or ()))
    return list(found.values())


def _requirements(lines: Iterable[str]) -> list[str]:
    """The names of the requirements that belong to no extra."""
    matches = (_NAME.match(line) for line in lines if not re.search(r";.*\bextra\s*==", line))
    return [match.group() for match in matches if match]


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _licence(package: Distribution) -> Licence:
    return Licence(package.name, package.version, _named(package), _texts(package))


def _named(package: Distribution) -> str:
    """What the metadata calls the licence: an expression, classifiers or a short name."""
    expressions = _field(package, "License-Expression")
    classifiers = [
        line.rpartition("::")[2].strip()
        for line in _field(package, "Classifier")
        if line.startswith("License ::") and line.count("::") > 1
    ]
    lines = [text.strip().partition("\n")[0] for text in _field(package, "License")]
    names = expressions or classifiers or [line[:_LONGEST_NAME] for line in lines if line]
    return ", ".join(names) or "see its licence text"


def _field(package: Distribution, name: str) -> list[str]:
    return [str(value) for value in package.metadata.get_all(name) or ()]


def _texts(package: Distribution) -> tuple[str, ...]:
    """The licence files in the package's metadata folder, in the order of their names.

    Where there are none, the text that Georibbon brings along for it.
    """
    files = sorted(
        file
        for file in package.files or ()
        if ".dist-info" in file.parts[0] and _LICENCE_FILE.search("/".join(file.parts[1:]))
    )
    if files:
        return tuple(file.read_text(encoding="utf-8") for file in files)
    own = resource(f"licences/{_normal(package.name)}.txt")
    return (own.read_text(encoding="utf-8"),) if own.is_file() else ()
