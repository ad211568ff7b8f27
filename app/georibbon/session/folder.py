"""The recording folder: plain text that holds everything one capture measured.

`recording.toml` describes ribbon, poses, passes and survey; one CSV file of raw
counts belongs to each pose and pass.  Nothing in the folder is trusted.
"""

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from georibbon.errors import RecordingError
from georibbon.recording import Recording
from georibbon.ribbon import Readings
from georibbon.session.counts import check_readings, format_csv, parse_csv
from georibbon.session.fields import Source, Table
from georibbon.session.files import built_folder, kind_of, read_bounded
from georibbon.session.outline import Outline, read_outline, tables_of
from georibbon.session.words import told

FORMAT = "georibbon-recording"
VERSION = 1
_HEAD = ("format", "version")
TOML_NAME = "recording.toml"
MAX_TOML = 4 * 2**20
MAX_CSV = 256 * 2**20
MAX_RECORDING = 2**30
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])", re.IGNORECASE)


def read_recording(path: Path) -> Recording:
    """The recording in a folder.

    Raises RecordingError, one sentence with the file, the line or the field and
    the remedy, for everything that is not as the format says.
    """
    kind = kind_of(path)
    if kind == "nothing":
        raise RecordingError(f"{path}: there is no such folder; give the folder of a recording")
    if kind != "folder":
        raise RecordingError(f"{path}: this is no folder; give the folder of a recording")
    root = path.resolve()
    if not (root / TOML_NAME).exists():
        raise RecordingError(
            f"{path}: there is no {TOML_NAME} in this folder; give the folder of a recording"
        )
    outline = _read_toml(root)
    readings, room = [], MAX_RECORDING
    for place, file in zip(_places(root, outline), outline.files, strict=True):
        data = read_bounded(place, min(MAX_CSV, room), file, RecordingError)
        room -= len(data)
        readings.append(parse_csv(data, outline.ribbon.columns, file))
    return outline.filled(readings)


def write_recording(recording: Recording, path: Path) -> None:
    """Write a recording into a new or an empty folder; a folder with contents is refused.

    Everything is written beside first and the folder then takes its place, so
    that a failure leaves nothing behind.  `read_recording` gives back the same
    recording exactly.  Raises RecordingError.
    """
    files = _file_names(recording)
    tables = tables_of(recording, files)
    check_recording(recording, read_outline(tables, Source("the recording", RecordingError)))
    columns = recording.ribbon.columns
    with built_folder(path, RecordingError) as folder:
        for place in ("calibration", "passes"):
            (folder / place).mkdir()
        for file, readings in zip(files, readings_of(recording), strict=True):
            (folder / file).write_bytes(format_csv(readings, columns))
        head = {"format": FORMAT, "version": VERSION}
        (folder / TOML_NAME).write_bytes(toml_text(head | tables).encode())


def check_recording(recording: Recording, outline: Outline) -> None:
    """Refuse frames that do not fit the outline; RecordingError names the pose or pass."""
    for name, readings in zip(outline.names, readings_of(recording), strict=True):
        check_readings(readings, outline.ribbon.columns, name)


def _read_toml(root: Path) -> Outline:
    data = read_bounded(_inside(root, TOML_NAME), MAX_TOML, TOML_NAME, RecordingError)
    try:
        text = data.removeprefix(b"\xef\xbb\xbf").decode()
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise RecordingError(
            f"{TOML_NAME}, line {line}: this is not UTF-8; save the file as UTF-8"
        ) from error
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise RecordingError(f"{TOML_NAME}: values nested too deeply; no field needs it") from error
    except ValueError as error:
        lines = text.count("\n") + 1
        told_at = str(error).replace("at end of document", f"at the end, line {lines}")
        if "digits" in told_at:  # Python's own advice to raise a limit is none for this person
            told_at = "a whole number has thousands of digits"
        raise RecordingError(f"{TOML_NAME}: this is not TOML: {told_at}; mend that line") from error
    source = Source(TOML_NAME, RecordingError, text)
    _check_version(document, source)
    tables = {key: value for key, value in document.items() if key not in _HEAD}
    return read_outline(tables, source)


def _check_version(document: Mapping[str, object], source: Source) -> None:
    head = {key: value for key, value in document.items() if key in _HEAD}
    table = Table(head, source, "", None, _HEAD)
    table.choice("format", (FORMAT,))
    version = table.whole("version", str(VERSION))
    if version > VERSION:
        table.refuse(
            "version",
            f"version is {told(version)}, newer than {VERSION}, the newest that this program "
            "reads; use a newer Georibbon",
        )
    if version < VERSION:
        table.refuse("version", f"version is {told(version)}; {VERSION} is expected")


def _places(root: Path, outline: Outline) -> list[Path]:
    """Where the files are; refused outside the folder, and one file under two names."""
    seen: dict[Path, str] = {}
    for file in outline.files:
        place = _inside(root, file)
        if place in seen:
            raise RecordingError(
                f"{TOML_NAME}: the files {told(seen[place])} and {told(file)} are the same one; "
                "each pose and pass has its own"
            )
        seen[place] = file
    return list(seen)


def _inside(root: Path, file: str) -> Path:
    """Where a file named in the recording really is; refused if that is not in the root."""
    try:
        place = (root / file).resolve()
    except (OSError, RuntimeError) as error:
        raise RecordingError(f"{file}: the file cannot be reached ({error}); see to it") from error
    if not place.is_relative_to(root):
        raise RecordingError(
            f"{file}: the file leads out of the recording's folder; copy it into the folder"
        )
    return place


def _file_names(recording: Recording) -> tuple[str, ...]:
    """Paths for poses, by number, and passes, by name: unique wherever they are unpacked."""
    poses = [f"calibration/pose-{i + 1:02}.csv" for i in range(len(recording.poses))]
    passes: list[str] = []
    taken: set[str] = set()
    for i, run in enumerate(recording.passes):
        stem = re.sub(r"[^a-z0-9]+", "-", run.name.lower()).strip("-")[:40] or "pass"
        if stem in taken or _RESERVED.fullmatch(stem):
            stem = f"{stem}-{i + 1}"
        while stem in taken:
            stem += "x"
        taken.add(stem)
        passes.append(f"passes/{stem}.csv")
    return (*poses, *passes)


def toml_text(tables: Mapping[str, object]) -> str:
    """Tables, their plain values first, as TOML."""
    return "\n".join(_toml_table("", tables)).lstrip("\n") + "\n"


def _toml_table(name: str, table: Mapping[str, object]) -> list[str]:
    plain: list[str] = []
    below: list[str] = []
    for key, value in table.items():
        path = f"{name}.{key}" if name else key
        if isinstance(value, Mapping):
            below += ["", f"[{path}]", *_toml_table(path, value)]
        elif isinstance(value, list) and all(isinstance(item, Mapping) for item in value):
            for item in value:
                below += ["", f"[[{path}]]", *_toml_table(path, item)]
        else:
            plain.append(f"{key} = {_toml_value(value)}")
    return plain + below


def _toml_value(value: object) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_toml_value, value)) + "]"
    return repr(value)


def readings_of(recording: Recording) -> tuple[Readings, ...]:
    """The frames of the poses in their order, then of the passes."""
    poses = tuple(pose.readings for pose in recording.poses)
    return poses + tuple(run.readings for run in recording.passes)
