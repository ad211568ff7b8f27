"""``georibbon batch``: many sessions reconstructed, several at a time, each by itself."""

import argparse
import csv
import io
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from glob import glob, has_magic
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from georibbon.cli.arguments import Parser, whole
from georibbon.cli.crew import Crew, Fallen
from georibbon.cli.outputs import signals_noted
from georibbon.cli.printing import json_text
from georibbon.cli.reconstruction import add_settings
from georibbon.errors import ExportError, GeoribbonError, SettingsError
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.export.mesh import Unit
    from georibbon.reconstruction import Reconstruction

DESCRIPTION = """\
Reconstruct many recordings and sessions, each as `georibbon reconstruct` would, in
processes side by side.  SOURCE is a session, a recording folder, or a folder that holds
such; a pattern with * is understood as well.

The files are named as their sources and written into the folder DIR, each when it is
ready.  What is there already is kept and its source is not done again, so that a batch
that was ended goes on where it was; --overwrite writes it anew.  One that fails never
stops the others.

At the end there is a table, also as batch.csv and batch.json in DIR.  Ctrl-C lets those
finish that are being done, a second one ends them too; what is done is kept.

Exit code: 0 all is there, 1 something failed, 2 nothing could be begun, 130 interrupted."""

EPILOG = """\
examples:
  georibbon batch sessions -o out --surface stl --report pdf
  georibbon batch monday/*.georibbon tuesday -o out -j 4 --curves --smoothing 60
  georibbon batch sessions -o out --json > table.json     # for programs"""

_OURS = ("command", "run")  # in the arguments: the parser and what runs, which go to no process
Status = Literal["done", "failed", "kept", "stopped"]


@dataclass(frozen=True)
class Task:
    """One source to reconstruct: the name of what is written, and the files' endings."""

    name: str
    source: Path
    endings: tuple[str, ...]


@dataclass(frozen=True)
class Job:
    """A task, the words that say how, and the new folder to write into."""

    task: Task
    arguments: argparse.Namespace
    place: Path


@dataclass(frozen=True)
class Outcome:
    """What came of one source; numbers are None where there are none.

    status: done; failed, with the sentence in `message`; kept from an earlier
    time; stopped before it was done.  sigma_mm: the passes' position, 1 sigma, rms.
    """

    name: str
    source: str
    status: Status
    verdict: str | None = None
    passes: int | None = None
    ties: int | None = None
    sigma_mm: float | None = None
    area_m2: float | None = None
    notices: int | None = None
    seconds: float | None = None
    message: str = ""
    files: tuple[str, ...] = ()


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "sources", metavar="SOURCE", nargs="+",
        help="recording folder, .georibbon session, a folder of such, or a pattern",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, required=True,
        help="the folder to write into; it is made where it is not there",
    )  # fmt: skip
    parser.add_argument(
        "-j", "--jobs", metavar="N", type=_at_least_one,
        help="so many at a time (default: one for each processor)",
    )  # fmt: skip
    parser.add_argument("--overwrite", action="store_true", help="write anew what is there already")
    parser.add_argument("--json", action="store_true", help="print the table as one JSON object")
    _add_outputs(parser.add_argument_group("what to write of each"))
    add_settings(parser.add_argument_group("how to reconstruct"))
    parser.set_defaults(run=run)


def _add_outputs(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--surface", choices=("stl", "obj", "ply", "step", "iges"), action="append", default=[],
        help="the surface in this format; may be repeated; step and iges need the extra cad",
    )  # fmt: skip
    group.add_argument(
        "--unit", choices=("mm", "cm", "m", "in"), default="mm",
        help="of the surface files (default mm); the report tells it",
    )  # fmt: skip
    group.add_argument("--curves", action="store_true", help="the passes as .csv, in metres")
    group.add_argument(
        "--report", choices=("html", "pdf", "json"), action="append", default=[],
        help="the report in this format; may be repeated",
    )  # fmt: skip
    group.add_argument(
        "--picture", action="store_true", help="a .png of the surface coloured by its uncertainty"
    )


def _at_least_one(text: str) -> int:
    value = whole(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} found, a whole number above 0 expected")
    return value


def run(arguments: argparse.Namespace) -> None:
    """Do all, tell how it goes, and print what came of it; exits with 1 where something failed."""
    endings = _endings(arguments)
    _check_words(arguments)
    tasks = tasks_of(arguments.sources, endings)
    _make_folder(arguments.output)
    table = Table(len(tasks), sys.stderr.isatty(), quiet=arguments.json)
    with signals_noted() as signals:
        _do_all(tasks, arguments, table, signals)
    outcomes = sorted(table.outcomes, key=lambda one: one.name)
    places = write_tables(outcomes, arguments.output)
    if arguments.json:
        print(json_text({"sessions": [asdict(one) for one in outcomes]}))
    else:
        print("\n".join([*table_lines(outcomes), *(f"written: {place}" for place in places)]))
    sys.stdout.flush()
    if signals:
        raise KeyboardInterrupt
    if any(one.status == "failed" for one in outcomes):
        raise SystemExit(1)


def _endings(arguments: argparse.Namespace) -> tuple[str, ...]:
    endings = [*arguments.surface, *(["csv"] if arguments.curves else []), *arguments.report]
    endings += ["png"] if arguments.picture else []
    if not endings:
        raise SettingsError(
            "nothing is to be written; say what with --surface, --curves, --report or --picture"
        )
    return tuple(f".{one}" for one in dict.fromkeys(endings))


def _check_words(arguments: argparse.Namespace) -> None:
    """What is wrong with the words, or with the calibration's file, is told before the work."""
    from georibbon.cli.reconstruction import settings_from
    from georibbon.cli.result_files import check_cad
    from georibbon.session.calibration_file import read_calibration

    check_cad([arguments.output / f"*.{one}" for one in arguments.surface], arguments.thickness)
    settings_from(arguments)
    if arguments.calibration is not None:
        read_calibration(arguments.calibration)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(
            f"{folder}: this folder cannot be made ({error.strerror}); choose another place"
        ) from error


# Which sources


def tasks_of(words: Sequence[str], endings: tuple[str, ...]) -> list[Task]:
    """A task for each source that the words name, each source once, with names of their own.

    Raises ExportError where a word names nothing.
    """
    sources: dict[Path, Path] = {}
    for word in words:
        found = list(_sources(word))
        if not found:
            raise ExportError(
                f"{word}: there is no recording and no session; give .georibbon files, recording "
                "folders, or a folder that holds such"
            )
        for source in found:
            sources.setdefault(source.resolve(), source)
    return [
        Task(name, source, endings)
        for name, source in zip(_names(list(sources)), sources.values(), strict=True)
    ]


def _sources(word: str) -> Iterable[Path]:
    path = Path(word)
    if not path.exists() and has_magic(word):
        for found in sorted(glob(word, recursive=True)):  # noqa: PTH207 - a pattern may be absolute
            yield from _sources_at(Path(found), named=False)
    else:
        yield from _sources_at(path, named=True)


def _sources_at(path: Path, named: bool) -> Iterable[Path]:
    """The recordings and sessions at a place; a file that was named need not look like one."""
    if path.is_file():
        if named or path.suffix.lower() == ".georibbon":
            yield path
    elif (path / "recording.toml").is_file():
        yield path
    elif path.is_dir():
        for one in sorted(path.iterdir()):
            if (one.is_file() and one.suffix.lower() == ".georibbon") or (
                one.is_dir() and (one / "recording.toml").is_file()
            ):
                yield one


def _names(paths: Sequence[Path]) -> list[str]:
    """For each source a name of its own: its file's, with its folder's where that is not enough."""
    plain = [_stem(path) for path in paths]
    longer = [f"{path.parent.name}-{_stem(path)}" for path in paths]
    names: list[str] = []
    for short, long in zip(plain, longer, strict=True):
        alike = [one.lower() for one in plain].count(short.lower()) > 1
        name = wanted = long if alike else short
        number = 2
        while name.lower() in {one.lower() for one in names}:
            name, number = f"{wanted}-{number}", number + 1
        names.append(name)
    return names


def _stem(path: Path) -> str:
    return (
        path.parent.name if path.name == "recording.toml" else path.name.removesuffix(".georibbon")
    )


# The work


def _do_all(
    tasks: Sequence[Task], arguments: argparse.Namespace, table: "Table", signals: list[int]
) -> None:
    """Do the tasks side by side until all are done, or until interrupted."""
    staging = _staging(arguments.output)
    try:
        todo = []
        for task in tasks:
            missing = _missing(task, arguments.output, arguments.overwrite)
            if missing:
                todo.append(replace(task, endings=missing))
            else:
                table.add(_kept(task))
        words = {name: value for name, value in vars(arguments).items() if name not in _OURS}
        plain = argparse.Namespace(**words)
        jobs = [Job(task, plain, staging / str(k)) for k, task in enumerate(todo)]
        crew = Crew(min(arguments.jobs or _processors(), max(len(todo), 1)), _work)
        for job, outcome in crew.do(jobs, signals, table.show):
            if isinstance(outcome, Fallen):
                table.add(_fallen(job.task, outcome))
            else:
                table.add(_moved(outcome, job.place, arguments.output))
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _staging(folder: Path) -> Path:
    try:
        return Path(tempfile.mkdtemp(prefix=".georibbon-", dir=folder))
    except OSError as error:
        raise ExportError(
            f"{folder}: this folder cannot be written to ({error.strerror}); choose a place where "
            "you may write"
        ) from error


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _files(task: Task) -> list[str]:
    return [f"{task.name}{ending}" for ending in task.endings]


def _missing(task: Task, folder: Path, overwrite: bool) -> tuple[str, ...]:
    """The endings of the files that are to be written."""
    return tuple(
        ending
        for ending in task.endings
        if overwrite or not (folder / f"{task.name}{ending}").exists()
    )


def _kept(task: Task) -> Outcome:
    message = "all is there already; --overwrite writes it anew"
    return Outcome(task.name, str(task.source), "kept", message=message, files=tuple(_files(task)))


def _moved(outcome: Outcome, place: Path, folder: Path) -> Outcome:
    """The outcome, its files moved to where they belong."""
    try:
        for name in outcome.files:
            (place / name).replace(folder / name)
    except OSError as error:
        return Outcome(
            outcome.name, outcome.source, "failed",
            message=f"{error.filename or folder}: {error.strerror}",
        )  # fmt: skip
    return outcome


def _fallen(task: Task, fallen: Fallen) -> Outcome:
    status: Status = "stopped" if fallen.stopped else "failed"
    return Outcome(task.name, str(task.source), status, message=fallen.message)


def _work(job: Job) -> Outcome:
    """Do a job; runs in a process of its own."""
    task, begun = job.task, time.monotonic()
    try:
        job.place.mkdir(exist_ok=True)  # where it fell, and is tried again, it is there already
        result = _reconstructed(task, job.arguments, job.place)
    except GeoribbonError as error:
        return Outcome(task.name, str(task.source), "failed", message=str(error))
    except OSError as error:
        reason = f"{error.filename or task.source}: {error.strerror or error}"
        return Outcome(task.name, str(task.source), "failed", message=reason)
    return _summed_up(task, result, time.monotonic() - begun)


def _reconstructed(task: Task, arguments: argparse.Namespace, place: Path) -> "Reconstruction":
    from georibbon.cli.reconstruction import with_session
    from georibbon.reconstruction import reconstruct
    from georibbon.session.calibration_file import read_calibration
    from georibbon.session.source import load

    loaded = load(task.source)
    settings, _ = with_session(arguments, loaded)
    calibration = loaded.calibration
    if arguments.calibration is not None:
        calibration = read_calibration(arguments.calibration)
    result = reconstruct(loaded.recording, settings, calibration)
    for name in _files(task):
        _write(result, place / name, task, arguments.unit, loaded.recording.title)
    return result


def _write(
    result: "Reconstruction", path: Path, task: Task, unit: "Unit", title: str | None
) -> None:
    """Write one file of a result; its ending says what."""
    if path.suffix == ".csv":
        from georibbon.export.curves import write_curves

        write_curves(result, path)
    elif path.suffix == ".png":
        from georibbon.export.picture import write_picture

        write_picture(result, path)
    elif path.suffix in (".html", ".pdf", ".json"):
        from georibbon.export.report import write_report

        files = _files(task)
        write_report(result, path, source=str(task.source), unit=unit, files=files, title=title)
    elif result.surface is not None:
        from georibbon.export.surface_files import write_surface

        write_surface(result.surface, path, unit, title or task.name)


def _summed_up(task: Task, result: "Reconstruction", seconds: float) -> Outcome:
    from georibbon.export.summary import all_notices, overall

    passes = [one for one in result.passes if one.kind == "pass"]
    squares = [float((one.position_sigma**2).mean()) for one in result.passes]
    verdict, reasons = overall(result)
    return Outcome(
        task.name, str(task.source), "done", verdict, len(passes),
        len(result.passes) - len(passes), round(1e3 * (sum(squares) / len(squares)) ** 0.5, 3),
        None if result.surface is None else round(result.surface.area, 5),
        len(all_notices(result)), round(seconds, 2), "; ".join(reasons), tuple(_files(task)),
    )  # fmt: skip


# What is told


class Table:
    """What has come so far, told as it comes."""

    def __init__(self, total: int, terminal: bool, quiet: bool) -> None:
        self.outcomes: list[Outcome] = []
        self._total, self._terminal, self._quiet = total, terminal, quiet
        self._begun = time.monotonic()
        self._shown = ""

    def add(self, outcome: Outcome) -> None:
        """Take an outcome, and tell it in a line."""
        self.outcomes.append(outcome)
        self._clear()
        if not self._quiet:
            print(f"{len(self.outcomes)} of {self._total}  {outcome_line(outcome)}", flush=True)
        self.show(stopping=False)

    def show(self, stopping: bool) -> None:
        """On a terminal: how far it is, and how long it will take yet."""
        if not self._terminal:
            return
        done = [one for one in self.outcomes if one.status in ("done", "failed")]
        left = self._total - len(self.outcomes)
        line = f"{len(self.outcomes)} of {self._total}"
        failed = sum(one.status == "failed" for one in done)
        line += f", {failed} failed" if failed else ""
        if stopping:
            line += ", ending with those that are being done (Ctrl-C ends them too)"
        elif done and left:
            line += f", {time_words((time.monotonic() - self._begun) / len(done) * left)} left"
        if line != self._shown:
            self._clear()
            self._shown = line if left else ""
            print(f"\r{self._shown}", end="", file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self._shown:
            blank = " " * len(self._shown)
            print(f"\r{blank}", end="", file=sys.stderr)
            print("\r", end="", file=sys.stderr, flush=True)
            self._shown = ""


def time_words(seconds: float) -> str:
    """How long, as a person says it."""
    if seconds < 50:
        return f"about {max(5, 5 * round(seconds / 5))} s"
    minutes = round(seconds / 60)
    if minutes < 60:
        return f"about {max(minutes, 1)} min"
    return f"about {minutes // 60} h {minutes % 60} min"


def outcome_line(one: Outcome) -> str:
    """One outcome in a line."""
    if one.status != "done":
        return f"{one.name}  {one.status}: {one.message}"
    area = "" if one.area_m2 is None else f"  {one.area_m2:.4f} m²"
    passes = counted(one.passes or 0, "pass", "passes")
    return f"{one.name}  {one.verdict}  {passes}  sigma {one.sigma_mm:.2f} mm{area}"


def table_lines(outcomes: Sequence[Outcome]) -> list[str]:
    """The table for a person, and a last line that counts."""
    heads = ("name", "verdict", "passes", "ties", "sigma mm", "area m²", "notices", "s")
    rows = [
        (
            one.name, one.verdict or one.status, _cell(one.passes), _cell(one.ties),
            _cell(one.sigma_mm, 2), _cell(one.area_m2, 4), _cell(one.notices),
            _cell(one.seconds, 1),
        )
        for one in outcomes
    ]  # fmt: skip
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = [""]
    for row in (heads, *rows):
        cells = [
            cell.ljust(width) if k < 2 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    counts = {
        status: sum(one.status == status for one in outcomes)
        for status in ("done", "failed", "kept", "stopped")
    }
    told = [f"{count} {status}" for status, count in counts.items() if count]
    return [*lines, f"{counted(len(outcomes), 'source')}: {', '.join(told)}"]


def _cell(value: float | None, digits: int = 0) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def write_tables(outcomes: Sequence[Outcome], folder: Path) -> list[Path]:
    """The table as CSV and JSON in the folder, beside those of earlier batches."""
    from georibbon.export.files import write_whole

    number, stem = 2, "batch"
    while (folder / f"{stem}.csv").exists() or (folder / f"{stem}.json").exists():
        stem, number = f"batch-{number}", number + 1
    names = [field.name for field in fields(Outcome)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for one in outcomes:
        values = asdict(one) | {"files": " ".join(one.files)}
        writer.writerow(["" if values[name] is None else values[name] for name in names])
    document = json.dumps(
        {"sessions": [asdict(one) for one in outcomes]}, indent=2, ensure_ascii=False
    )
    places = [folder / f"{stem}.csv", folder / f"{stem}.json"]
    write_whole(places[0], text.getvalue().encode("utf-8", "backslashreplace"))
    write_whole(places[1], f"{document}\n".encode("utf-8", "backslashreplace"))
    return places
