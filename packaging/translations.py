"""Brings the translations up to date with the program's texts.

    translations.py           rewrites the .po files, and what is made of them
    translations.py --check   only tells what is not up to date, and exits with 1

The window's texts (`tr`, `trn` and `N_` in gui/) are in the catalogue georibbon.po,
and of it georibbon.mo is made.  The sentences of the core, as patterns with {0}, {1},
... for what is filled in, are in sentences.po, and of it sentences.json is made.  A
text that is new gets an empty translation, one that is gone is dropped.
"""

import argparse
import ast
import io
import json
import re
import string
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeGuard

from babel.messages.catalog import Catalog, Message
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "app" / "georibbon"
TRANSLATIONS = ROOT / "resources" / "translations"
LANGUAGES = ("fr",)
MADE = datetime(2000, 1, 1, tzinfo=UTC)  # in the .mo, which must be the same for the same texts
KEYWORDS = {"tr": 1, "trn": 2, "N_": 1}  # how many of what is given are texts
# The rooms whose sentences a person reads in the window.
ROOMS = (
    "calibration", "capture", "device", "export", "fitting", "geometry", "session", "virtual",
    "reconstruction.py", "recording.py", "ribbon.py", "simulation", "scene", "resources.py",
)  # fmt: skip
# What sentences are filled in with or joined by, too short to be known for words by itself.
SHORT = (
    "{0}: {1}", "{0}; {1}", "{0}, {1}", "{0} and {1}", "{0} or {1}", "{0} to {1}",
    "{0}, with {1}", "{0} ({1})",
    "accelerometer", "magnetometer", "sensor", "mark", "distance", "crossing", "pass", "passes",
    "tie", "pose", "entry", "entries", "north", "south", "up", "down", "start", "end", "stronger",
    "weaker", "{0} % stronger", "{0} % weaker", "steeper", "flatter", "is", "are", "has", "have",
    "does", "do", "es", "again",
    "soon", "calibrated", "smoothing", "weight", "undone", "redone", "disconnected", "opening",
    "streaming", "stalled", "first", "last",
    "{0} byte", "{0} bytes", "{0} packet", "{0} packets", "{0} packet lost", "{0} packets lost",
    "{0} frame", "{0} frames", "{0} event", "{0} events", "{0} piece", "{0} pieces",
    "{0} sensor", "{0} sensors", "{0} pose", "{0} poses", "{0} pass", "{0} passes", "{0} tie",
    "{0} ties", "{0} entry", "{0} entries", "{0} damaged", "{0} {1} damaged", ", {0} disturbed",
    "{0} value", "{0} values", "{0} characters", "{0} more",
    "pass {0}", "passes {0}", "pose {0}", "tie {0}", "ribbon {0}", "sensor {0}", "mark {0}",
    "distance {0}", "crossing {0}", "pose {0} ({1})", "part {0}", "link {0}", "skipping {0}",
    "opening {0}", "rate {0}", "stream {0}", "between {0}", "noted: {0}", "mark noted",
    "distance noted",
    "crossing noted", "{0} entry noted", "{0} entries noted",
    "planned: {0}", "undone: {0}", "redone: {0}", "link {0}: {1}", "misfit {0}",
    "misfit {0}, settling", "skipped: {0}", "survey: {0}", "{0} on {1} m", "{0} (firmware {1})",
    " ({0} times)", " ({0}: {1} {2}, {3} expected)", "{0} in {1} s", "{0}; but {1}", "a file",
    "{0}, still", "{0}, still in {1} s", "disconnected: {0}", "stalled: {0}", "streaming: {0}",
    "opening: {0}", "{0}: sensor {1} is switched off and has no say",
    "{0}: sensors {1} are switched off and have no say",
    "{0}, line {1}", "{0}, frame {1}", "line {0}", ", line {0}", "[[{0}]] number {1}: {2}",
)  # fmt: skip
WORDS = re.compile(r"[a-z]{2,}[ ,;:'].*[a-z]{2,}", re.DOTALL)
CODE = re.compile(
    r"\b(SELECT|INSERT|UPDATE|DELETE|CREATE|PRAGMA|BEGIN)\b|^\W*<|^--|\\|^(https?|file):|->"
)

# What the system says in a sentence, as a file or a port cannot be had.
SYSTEM = (
    "No such file or directory", "Permission denied", "No space left on device", "File exists",
    "Is a directory", "Not a directory", "Input/output error", "Read-only file system",
    "Disk quota exceeded", "File name too long", "Operation not permitted", "No such device",
    "Device or resource busy", "Resource temporarily unavailable", "Too many open files",
    "Connection refused", "Connection reset by peer", "Connection timed out", "timed out",
    "Network is unreachable", "No route to host", "Name or service not known", "Broken pipe",
    "Address already in use", "Directory not empty", "disk I/O error", "database is locked",
    "database disk image is malformed", "file is not a database", "unable to open database file",
    "attempt to write a readonly database", "database or disk is full",
)  # fmt: skip


def texts_of_window() -> Catalog:
    """The texts that gui/ marks."""
    catalogue = Catalog(charset="utf-8")
    for path in sorted((SOURCES / "gui").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = _marked(node)
            if text and text != ("",):
                catalogue.add(text if len(text) > 1 else text[0])
    return catalogue


def _marked(node: ast.AST) -> tuple[str, ...]:
    """The texts that a call marks; none where it is no such call, or they are known only later."""
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name):
        return ()
    given = node.args[: KEYWORDS.get(node.func.id, 0)]
    texts = (one.value for one in given if isinstance(one, ast.Constant))
    return tuple(text for text in texts if isinstance(text, str))


def sentences_of_core() -> Catalog:
    """The patterns of the sentences in the core's rooms."""
    catalogue = Catalog(charset="utf-8")
    for short in (*SHORT, *SYSTEM):
        catalogue.add(short)
    for room in ROOMS:
        place = SOURCES / room
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            for pattern in _patterns(ast.parse(path.read_text(encoding="utf-8"))):
                catalogue.add(pattern)
    return catalogue


def _patterns(tree: ast.Module) -> Iterator[str]:
    """The strings of a module that are words for a person, docstrings left out."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            skipped.add(id(node.value))
        elif isinstance(node, ast.JoinedStr):
            skipped.update(id(part) for part in node.values)
            skipped.update(
                id(part) for part in ast.walk(node) if isinstance(part, ast.FormattedValue)
                and part.format_spec is not None for part in ast.walk(part.format_spec)
            )  # fmt: skip
            pattern = _pattern(node)
            if _is_sentence(pattern):
                yield pattern
        elif _is_words(node):
            yield str(node.value)


def _is_words(node: ast.AST) -> TypeGuard[ast.Constant]:
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and _is_sentence(node.value)
        and "{" not in node.value
    )


def _pattern(node: ast.JoinedStr) -> str:
    parts, count = [], 0
    for part in node.values:
        if isinstance(part, ast.Constant):
            parts.append(str(part.value))
        else:
            parts.append(f"{{{count}}}")
            count += 1
    return "".join(parts)


def _is_sentence(text: str) -> bool:
    return bool(WORDS.search(text)) and not CODE.search(text) and len(text) < 1000


def merged(catalogue: Catalog, path: Path, language: str) -> Catalog:
    """The catalogue with what is translated already."""
    known = Catalog(locale=language)
    if path.exists():
        with path.open("rb") as file:
            known = read_po(file, locale=language)
    new = Catalog(locale=language, charset="utf-8", project="Georibbon", version="1")
    for message in sorted(catalogue, key=_order):
        if message.id:
            there = known.get(message.id)
            if there is None or there.pluralizable != message.pluralizable:
                new.add(message.id)
            else:
                new.add(message.id, string=there.string)
    new.mime_headers[:] = []
    return new


def _order(message: Message) -> str:
    return message.id if isinstance(message.id, str) else message.id[0]


def as_po(catalogue: Catalog) -> bytes:
    """The catalogue as a .po file, the same for the same texts."""
    buffer = io.BytesIO()
    write_po(buffer, catalogue, width=100, omit_header=True)
    header = f'msgid ""\nmsgstr ""\n"Language: {catalogue.locale}\\n"\n'
    header += '"Content-Type: text/plain; charset=utf-8\\n"\n'
    header += f'"Plural-Forms: {catalogue.plural_forms}\\n"\n\n'
    return header.encode() + buffer.getvalue()


def as_mo(po: bytes) -> bytes:
    """What gettext reads."""
    buffer, catalogue = io.BytesIO(), read_po(io.BytesIO(po))
    catalogue.creation_date = catalogue.revision_date = MADE
    write_mo(buffer, catalogue)
    return buffer.getvalue()


def as_json(po: bytes) -> bytes:
    """The patterns that are translated, from English."""
    found = {m.id: m.string for m in read_po(io.BytesIO(po)) if m.id and m.string}
    return (json.dumps(found, ensure_ascii=False, indent=0, sort_keys=True) + "\n").encode()


def files(language: str) -> dict[Path, bytes]:
    """All files of a language as they should be."""
    folder = TRANSLATIONS / language
    messages = folder / "LC_MESSAGES"
    window = as_po(merged(texts_of_window(), messages / "georibbon.po", language))
    core = as_po(merged(sentences_of_core(), folder / "sentences.po", language))
    return {
        messages / "georibbon.po": window,
        messages / "georibbon.mo": as_mo(window),
        folder / "sentences.po": core,
        folder / "sentences.json": as_json(core),
    }


def untranslated(po: bytes) -> list[str]:
    """The texts without a translation."""
    return [str(one.id) for one in read_po(io.BytesIO(po)) if one.id and not _whole(one)]


def misfits(po: bytes) -> list[str]:
    """The translations whose {names} are not those of the text."""
    return [str(one.id) for one in read_po(io.BytesIO(po)) if one.id and _whole(one)
            and not _same_names(one)]  # fmt: skip


def _whole(message: Message) -> bool:
    strings = message.string if isinstance(message.string, tuple | list) else (message.string,)
    return all(strings)


def _same_names(message: Message) -> bool:
    ids = message.id if isinstance(message.id, tuple | list) else (message.id,)
    strings = message.string if isinstance(message.string, tuple | list) else (message.string,)
    names = {frozenset(_names(one)) for one in (*ids, *strings)}
    return len(names) == 1


def _names(text: str) -> Iterator[str]:
    return (name for _, name, _, _ in string.Formatter().parse(text) if name is not None)


def main() -> int:
    """Brings up to date, or tells what is not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="change nothing, exit with 1")
    check = parser.parse_args().check
    stale = False
    for language in LANGUAGES:
        for path, wanted in files(language).items():
            if path.exists() and path.read_bytes() == wanted:
                continue
            stale = True
            if not check:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(wanted)
            print(f"{'stale' if check else 'written'}: {path.relative_to(ROOT)}")
            if path.suffix == ".po":
                print(f"    {len(untranslated(wanted))} texts without a translation")
    return int(stale and check)


if __name__ == "__main__":
    sys.exit(main())
