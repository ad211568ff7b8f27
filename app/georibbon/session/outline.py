"""What a recording says beside its frames, checked: one validator for every source.

`read_outline` takes the tables of `recording.toml`, or the same tables built
from the rows of a session file, and refuses everything that cannot be meant.
`tables_of` is its inverse.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import cast

from georibbon.recording import (
    Crossing,
    Distance,
    Mark,
    Pass,
    PassKind,
    Pose,
    Recording,
    Workpiece,
)
from georibbon.ribbon import Readings, Ribbon, Sensor, SensorKind
from georibbon.session.fields import MAX_NAME, Source, Table
from georibbon.session.words import nearest, told

MAX_FILES = 10_000
MAX_SENSORS = 1_000
MAX_SURVEY = 100_000
MAX_TOLD = 20  # names in one message
MOST_TABLE_PITCH = 10.0  # degrees: a pose asked for on the table, taken literally
MIN_PASSES = 2

Survey = tuple[tuple[Mark, ...], tuple[Distance, ...], tuple[Crossing, ...]]

_TOP = ("title", "ribbon", "workpiece", "pose", "pass", "mark", "distance", "crossing")
_RIBBON = ("id", "length", "rate", "sensor")
_SENSOR = ("name", "kind", "axes", "position", "counts_per_unit")
_WORKPIECE = ("level", "heading")
_POSE = ("name", "roll", "heading", "pitch", "table", "file")
_PASS = ("name", "kind", "file")
_MARK = ("pass", "at", "position", "sigma")
_DISTANCE = ("passes", "at", "distance", "sigma")
_CROSSING = ("passes", "at", "sigma")
_AXES = {"accelerometer": (3,), "magnetometer": (2, 3)}


@dataclass(frozen=True)
class PoseEntry:
    """A pose without its frames; file: where they are, as its source names it."""

    name: str
    roll: float
    heading: float
    pitch: float
    table: bool
    file: str


@dataclass(frozen=True)
class PassEntry:
    """A pass without its frames; file: where they are, as its source names it."""

    name: str
    kind: PassKind
    file: str


@dataclass(frozen=True)
class Outline:
    """A recording without its frames."""

    ribbon: Ribbon
    poses: tuple[PoseEntry, ...]
    passes: tuple[PassEntry, ...]
    marks: tuple[Mark, ...]
    distances: tuple[Distance, ...]
    crossings: tuple[Crossing, ...]
    workpiece: Workpiece | None
    title: str | None

    @property
    def files(self) -> tuple[str, ...]:
        """Where the frames are: of the poses in their order, then of the passes."""
        return tuple(e.file for e in self.poses) + tuple(e.file for e in self.passes)

    @property
    def names(self) -> tuple[str, ...]:
        """What a person calls the poses and passes, in the order of `files`."""
        poses = tuple(f"pose {told(e.name)}" for e in self.poses)
        return poses + tuple(f"pass {told(e.name)}" for e in self.passes)

    def filled(self, readings: Sequence[Readings]) -> Recording:
        """The recording, with the frames in the order of `files`."""
        ahead = len(self.poses)
        poses = tuple(
            Pose(e.name, e.roll, e.heading, e.pitch, e.table, r)
            for e, r in zip(self.poses, readings[:ahead], strict=True)
        )
        passes = tuple(
            Pass(e.name, e.kind, r) for e, r in zip(self.passes, readings[ahead:], strict=True)
        )
        return Recording(
            self.ribbon,
            poses,
            passes,
            self.marks,
            self.distances,
            self.crossings,
            self.workpiece,
            self.title,
        )


def read_outline(data: Mapping[str, object], source: Source) -> Outline:
    """The outline in a recording's tables (without `format` and `version`).

    Two poses may have one name (a pose repeated); passes may not.  Raises the
    source's error, with table and field named, for whatever is missing, unknown,
    of the wrong type or out of range.
    """
    top = Table(data, source, "", None, _TOP)
    title = top.prose("title", "a title") if "title" in data else None
    ribbon = _ribbon(top)
    workpiece = read_workpiece(top)
    poses = tuple(_pose(t) for t in _tables(top, "pose", _POSE, MAX_FILES))
    passes = _passes(top)
    _check_files(top, poses, passes)
    marks, distances, crossings = read_survey(top, ribbon, [entry.name for entry in passes])
    return Outline(ribbon, poses, passes, marks, distances, crossings, workpiece, title)


def read_survey(top: Table, ribbon: Ribbon, passes: Iterable[str] | None) -> Survey:
    """The survey in the tables `mark`, `distance` and `crossing` of a table.

    passes: the names that it may speak of, None for any.  Raises the source's error.
    """
    survey = _Survey(ribbon, None if passes is None else dict.fromkeys(passes))
    marks = tuple(survey.mark(t) for t in _tables(top, "mark", _MARK, MAX_SURVEY))
    distances = tuple(survey.distance(t) for t in _tables(top, "distance", _DISTANCE, MAX_SURVEY))
    crossings = tuple(survey.crossing(t) for t in _tables(top, "crossing", _CROSSING, MAX_SURVEY))
    return marks, distances, crossings


def tables_of(recording: Recording, files: Sequence[str]) -> dict[str, object]:
    """The tables that `read_outline` reads back, `files` for the poses and then the passes."""
    tables: dict[str, object] = {} if recording.title is None else {"title": recording.title}
    tables["ribbon"] = ribbon_table(recording.ribbon)
    piece = recording.workpiece
    if piece is not None:
        heading = {} if piece.heading is None else {"heading": piece.heading}
        tables["workpiece"] = {"level": piece.level} | heading
    ahead = len(recording.poses)
    tables["pose"] = [
        {key: getattr(pose, key) for key in _POSE[:-1]} | {"file": file}
        for pose, file in zip(recording.poses, files[:ahead], strict=True)
    ]
    tables["pass"] = [
        {"name": run.name, "kind": run.kind, "file": file}
        for run, file in zip(recording.passes, files[ahead:], strict=True)
    ]
    return tables | survey_tables(recording.marks, recording.distances, recording.crossings)


def ribbon_table(ribbon: Ribbon) -> dict[str, object]:
    """The table `ribbon` that `read_ribbon` reads back."""
    sensors = [{key: getattr(s, key) for key in _SENSOR} for s in ribbon.sensors]
    return {"id": ribbon.id, "length": ribbon.length, "rate": ribbon.rate, "sensor": sensors}


def survey_tables(
    marks: Iterable[Mark], distances: Iterable[Distance], crossings: Iterable[Crossing]
) -> dict[str, list[dict[str, object]]]:
    """The tables `mark`, `distance` and `crossing` that `read_survey` reads back."""
    return {
        "mark": [
            {"pass": m.pass_name, "at": m.at, "position": list(m.position), "sigma": m.sigma}
            for m in marks
        ],
        "distance": [
            {"passes": list(d.passes), "at": list(d.at), "distance": d.distance, "sigma": d.sigma}
            for d in distances
        ],
        "crossing": [
            {"passes": list(c.passes), "at": list(c.at), "sigma": c.sigma} for c in crossings
        ],
    }


def _tables(parent: Table, key: str, known: tuple[str, ...], limit: int) -> list[Table]:
    """The tables [[key]] of a table, none where the key is absent."""
    name = f"{parent.name}.{key}" if parent.name else key
    found = parent.data.get(key, [])
    if not isinstance(found, list):
        parent.refuse(key, f"{key} is {told(found)}; tables written [[{name}]] are expected")
    if len(found) > limit:
        parent.refuse(key, f"{len(found)} tables [[{name}]]; at most {limit} are read")
    return [Table(data, parent.source, name, i, known) for i, data in enumerate(found)]


def _ribbon(top: Table) -> Ribbon:
    if "ribbon" not in top.data:
        top.refuse(None, "the table [ribbon] is missing; it describes the ribbon and its sensors")
    return read_ribbon(top.data["ribbon"], top.source)


def read_ribbon(data: object, source: Source) -> Ribbon:
    """The ribbon in a table [ribbon] with its tables [[ribbon.sensor]].

    Raises the source's error for whatever is missing, unknown, of the wrong type
    or out of range.
    """
    table = Table(data, source, "ribbon", None, _RIBBON)
    name = table.text("id", "the ribbon's name")
    length = table.positive("length", "a length in metres greater than 0")
    rate = table.positive("rate", "a number of frames per second greater than 0")
    tables = _tables(table, "sensor", _SENSOR, MAX_SENSORS)
    sensors = tuple(_sensor(t, length) for t in tables)
    for i, first in _repeated([s.name for s in sensors]):
        message = f"the name is that of sensor number {first + 1} too; every sensor needs its own"
        tables[i].refuse("name", message)
    for kind in _AXES:
        if not any(s.kind == kind for s in sensors):
            message = f"there is no {kind} among its sensors; at least one is needed"
            table.refuse(None, message)
    return Ribbon(name, length, rate, sensors)


def _sensor(table: Table, length: float) -> Sensor:
    name = table.text("name", "the sensor's name")
    if any(c in name for c in ",\"'") or name != name.strip():
        table.refuse("name", "a sensor's name without commas, quotes and outer spaces is expected")
    kind = cast(SensorKind, table.choice("kind", tuple(_AXES)))
    axes = table.whole("axes", "2 or 3")
    if axes not in _AXES[kind]:
        expected = " or ".join(map(str, _AXES[kind]))
        table.refuse("axes", f"axes is {told(axes)}; {expected} is expected for this {kind}")
    position = _along(table, "position", table.number("position", "metres along it"), length)
    counts = table.positive("counts_per_unit", "a number of counts greater than 0")
    return Sensor(name, kind, axes, position, counts)


def _along(table: Table, key: str, value: float, length: float) -> float:
    if not 0.0 <= value <= length:
        table.refuse(
            key, f"{key} is {value!r} m; 0 to {length!r} m, the ribbon's ends, is expected"
        )
    return value


def read_workpiece(top: Table) -> Workpiece | None:
    """The frame of the marks in the table `workpiece` of a table; None where there is none."""
    if "workpiece" not in top.data:
        return None
    table = Table(top.data["workpiece"], top.source, "workpiece", None, _WORKPIECE)
    level = "level" not in table.data or table.flag("level", "true")
    if not level:
        table.refuse("level", "level is false; only a workpiece whose z axis is vertical is placed")
    heading = table.number("heading", "degrees") if "heading" in table.data else None
    return Workpiece(level, heading)


def _pose(table: Table) -> PoseEntry:
    return read_pose(table, _file(table))


def read_pose(table: Table, file: str) -> PoseEntry:
    """The pose in a table, whose frames are in `file`; raises the source's error."""
    pitch, on_table = table.number("pitch", "degrees"), table.flag("table", "true or false")
    if on_table and abs(pitch) > MOST_TABLE_PITCH:
        table.refuse(
            "table",
            f"table is true beside a pitch of {pitch:g} degrees; a bar that lies on the table has "
            "a pitch of 0: give table = false, or the right pitch",
        )
    return PoseEntry(
        table.text("name", "the pose's name"),
        table.number("roll", "degrees"),
        table.number("heading", "degrees"),
        pitch,
        on_table,
        file,
    )


def _passes(top: Table) -> tuple[PassEntry, ...]:
    tables = _tables(top, "pass", _PASS, MAX_FILES)
    passes = tuple(_pass(t) for t in tables)
    for i, first in _repeated([p.name for p in passes]):
        message = f"the name is that of pass number {first + 1} too; every pass needs its own"
        tables[i].refuse("name", message)
    check_count(passes, top.source)
    return passes


def check_count(passes: Sequence[PassEntry], source: Source) -> None:
    """Refuse, with the source's error, fewer passes than span a surface."""
    count = sum(entry.kind == "pass" for entry in passes)
    if count < MIN_PASSES:
        few = f'{count or "no"} pass{"" if count == 1 else "es"} of kind "pass"'
        source.refuse(f"{few}; at least {MIN_PASSES} are needed to span a surface")


def _pass(table: Table) -> PassEntry:
    return read_pass(table, _file(table))


def read_pass(table: Table, file: str) -> PassEntry:
    """The pass or tie in a table, whose frames are in `file`; raises the source's error."""
    name = table.text("name", "the pass's name")
    kind = cast(PassKind, table.choice("kind", ("pass", "tie")))
    return PassEntry(name, kind, file)


def _repeated(names: Sequence[str]) -> list[tuple[int, int]]:
    """For each name that came before: its place and the first one's."""
    first: dict[str, int] = {}
    return [(i, first[n]) for i, n in enumerate(names) if first.setdefault(n, i) != i]


@dataclass(frozen=True)
class _Survey:
    """The survey's tables, which name points of passes."""

    ribbon: Ribbon
    passes: dict[str, None] | None

    def mark(self, table: Table) -> Mark:
        name = table.text("pass", "the name of a pass")
        self._present(table, "pass", name)
        at = _along(table, "at", table.number("at", "metres along the ribbon"), self.ribbon.length)
        x, y, z = table.numbers("position", 3, "[x, y, z] in metres")
        return Mark(name, at, (x, y, z), _sigma(table))

    def distance(self, table: Table) -> Distance:
        passes, at = self._pair(table)
        if passes[0] == passes[1] and at[0] == at[1]:
            table.refuse("at", "a point and itself; a distance between two points is expected")
        distance = table.positive("distance", "metres greater than 0")
        return Distance(passes, at, distance, _sigma(table))

    def crossing(self, table: Table) -> Crossing:
        passes, at = self._pair(table)
        if passes[0] == passes[1]:
            table.refuse("passes", f"{told(passes[0])} with itself; two passes are expected")
        return Crossing(passes, at, _sigma(table))

    def _pair(self, table: Table) -> tuple[tuple[str, str], tuple[float, float]]:
        first, second = table.names("passes", 2, "the names of two passes")
        for name in (first, second):
            self._present(table, "passes", name)
            if not name.strip() or not name.isprintable() or len(name) > MAX_NAME:
                table.refuse("passes", f"passes holds {told(name)}; a pass's name is expected")
        at = table.numbers("at", 2, "two numbers of metres along the ribbon")
        a, b = (_along(table, "at", value, self.ribbon.length) for value in at)
        return (first, second), (a, b)

    def _present(self, table: Table, key: str, name: str) -> None:
        if self.passes is not None and name not in self.passes:
            hint = nearest(name, self.passes) or "; the passes are " + ", ".join(
                map(told, list(self.passes)[:MAX_TOLD])
            )
            table.refuse(key, f"there is no pass {told(name)}{hint}")


def _sigma(table: Table) -> float:
    return table.positive("sigma", "a standard deviation in metres greater than 0")


def _file(table: Table) -> str:
    """The path of a file inside the recording, with no way out of it."""
    file = table.text("file", "the file of its frames")
    plain = file.isprintable() and not any(c in file for c in '\\:*?"<>|')
    parts = PurePosixPath(file).parts
    if not plain or not parts or file.startswith("/") or ".." in parts:
        table.refuse(
            "file",
            f"the file {told(file)} leaves the recording's folder or is no plain path; a relative "
            "path such as passes/p1.csv is expected",
        )
    return file


def _check_files(top: Table, poses: Sequence[PoseEntry], passes: Sequence[PassEntry]) -> None:
    files = [*(pose.file for pose in poses), *(one.file for one in passes)]
    if len(files) > MAX_FILES:
        top.refuse(None, f"{len(files)} poses and passes; at most {MAX_FILES} are read")
    for i, _ in _repeated(files):
        ahead = len(poses)
        table, index = ("pose", i) if i < ahead else ("pass", i - ahead)
        Table({}, top.source, table, index, ()).refuse(
            "file", f"the file {told(files[i])} is named twice; each pose and pass has its own"
        )
