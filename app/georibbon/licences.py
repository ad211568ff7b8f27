"""The licences of what an installer of Georibbon would ship.

Read from the installed packages' own metadata: Georibbon's requirements, those of
its extras where they are installed, what all those require, and so on, and Python
itself; never the tools that only build or test it.
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
# The texts that Georibbon brings along for packages that come without.  The LGPL adds to the GPL.
_LESSER = ("licences/LGPL-3.0.txt", "licences/GPL-3.0.txt")
_KERNEL = ("licences/LGPL-2.1.txt", "licences/OCCT-exception-1.0.txt")
_APACHE = "licences/Apache-2.0.txt"
_TEXTS = {
    "cadquery-ocp-novtk": (_APACHE, *_KERNEL),
    "cadquery-ocp-proxy": (_APACHE,),
    "pyserial": ("licences/pyserial.txt",),
    "pyside6-essentials": _LESSER,
    "shiboken6": _LESSER,
}
# What a package holds beside its own, and does not tell.
_INSIDE = {"cadquery-ocp-novtk": "LGPL-2.1-only WITH OCCT-exception-1.0 (Open CASCADE Technology)"}


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
        waiting.extend(_requirements(found[key].requires or (), extras=key == name))
    return list(found.values())


def _requirements(lines: Iterable[str], extras: bool) -> list[str]:
    """The names of the requirements, with those of extras or without."""
    of_extra = re.compile(r";.*\bextra\s*==")
    matches = (_NAME.match(line) for line in lines if extras or not of_extra.search(line))
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
    names += [_INSIDE[key] for key in (_normal(package.name),) if key in _INSIDE]
    return ", ".join(names) or "see its licence text"


def _field(package: Distribution, name: str) -> list[str]:
    return [str(value) for value in package.metadata.get_all(name) or ()]


def _texts(package: Distribution) -> tuple[str, ...]:
    """The licence files in the package's metadata folder, in the order of their names.

    Where there are none, those that Georibbon brings along for it.
    """
    files = sorted(
        file
        for file in package.files or ()
        if ".dist-info" in file.parts[0] and _LICENCE_FILE.search("/".join(file.parts[1:]))
    )
    if files:
        return tuple(file.read_text(encoding="utf-8") for file in files)
    brought = _TEXTS.get(_normal(package.name), ())
    return tuple(resource(name).read_text(encoding="utf-8") for name in brought)
