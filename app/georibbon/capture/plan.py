"""What is to be captured: the poses, the passes and ties, and the survey where it is known.

A plan file is TOML:

    format = "georibbon-plan"
    version = 1
    title = "bonnet"          # optional
    poses = 20                # a plan of so many calibration poses; 0: none
    passes = 5                # P1, P2, ...
    ties = 2                  # T1, T2, ...

    [layout]                  # how they are meant to be laid and measured
    spacing = 0.1             # m between neighbouring passes
    marks = 2                 # of each pass: 0, 1 (start), 2 (start and end), 3 ...
    mark_sigma = 0.0005       # m
    distances = 0             # between neighbours: 0, 1 (starts), 2 (and ends), 3 ...
    distance_sigma = 0.0005   # m
    crossing_sigma = 0.001    # m, of each crossing of a tie with a pass

with `[workpiece]`, `[[mark]]`, `[[distance]]` and `[[crossing]]` as in a
recording, all of them optional.
"""

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from georibbon.calibration.labels import describe
from georibbon.calibration.plans import PLANS
from georibbon.errors import SettingsError
from georibbon.recording import PassKind, Workpiece
from georibbon.ribbon import Ribbon
from georibbon.session.fields import Source, Table
from georibbon.session.files import built_file, read_bounded
from georibbon.session.folder import toml_text
from georibbon.session.outline import Survey, read_survey, read_workpiece

FORMAT = "georibbon-plan"
VERSION = 1
DEFAULT_POSES, DEFAULT_PASSES, DEFAULT_TIES = 20, 5, 0
MOST_PLANNED = 1000
MAX_PLAN = 4 * 2**20
_COUNTS = ("poses", "passes", "ties")
_SURVEY = ("mark", "distance", "crossing")
_KNOWN = ("format", "version", "title", *_COUNTS, "layout", "workpiece", *_SURVEY)
_PLACES = ("marks", "distances")
_SIGMAS = ("mark_sigma", "distance_sigma", "crossing_sigma")
_LAYOUT = ("spacing", *_PLACES, *_SIGMAS)
MOST_PLACES = 9
SPACINGS = (0.005, 2.0)  # m
LEAST_SIGMA, MOST_SIGMA = 1e-5, 0.1  # m


@dataclass(frozen=True)
class PlannedPose:
    """A calibration pose that is asked for, in degrees; key: what a person calls it."""

    key: str
    roll: float
    heading: float
    pitch: float
    table: bool

    @property
    def name(self) -> str:
        """Its attitude, as recordings name their poses."""
        return f"roll {self.roll:g}, heading {self.heading:g}, pitch {self.pitch:g}"

    @property
    def words(self) -> str:
        """What to do with the bar."""
        laid = describe(math.radians(self.roll), math.radians(self.pitch))
        where = "flat on the table" if self.table else "one end on a block"
        return f"{laid}, {where}, turned to heading {self.heading:g}°"


@dataclass(frozen=True)
class PlannedPass:
    """A pass or a tie that is asked for."""

    name: str
    kind: PassKind


@dataclass(frozen=True)
class PlannedLayout:
    """How passes are meant to be laid and measured, metres.

    spacing: between neighbouring passes.  marks: points of each pass whose
    place in the workpiece is measured, spread evenly from its start to its end
    (one: the start).  distances: between neighbouring passes, spread likewise.
    crossing_sigma: of a crossing, which every tie makes with every pass.
    """

    spacing: float = 0.1
    marks: int = 2
    mark_sigma: float = 0.0005
    distances: int = 0
    distance_sigma: float = 0.0005
    crossing_sigma: float = 0.001

    def __post_init__(self) -> None:
        """Refuse what cannot be laid or measured, with a SettingsError."""
        if not SPACINGS[0] <= self.spacing <= SPACINGS[1]:
            raise SettingsError(
                f"the passes are {self.spacing:g} m apart; give {SPACINGS[0]:g} to "
                f"{SPACINGS[1]:g} m"
            )
        for name in _PLACES:
            if not 0 <= getattr(self, name) <= MOST_PLACES:
                raise SettingsError(
                    f"{getattr(self, name)} {name} a pass are planned; plan 0 to {MOST_PLACES}"
                )
        for name in _SIGMAS:
            if not LEAST_SIGMA <= getattr(self, name) <= MOST_SIGMA:
                raise SettingsError(
                    f"{name} is {getattr(self, name):g} m; give {LEAST_SIGMA:g} to {MOST_SIGMA:g} m"
                )


def places(count: int, length: float) -> tuple[float, ...]:
    """So many places along a ribbon of a length, metres: the start, start and end, evenly."""
    if count < 2:
        return (0.0,) * count
    return tuple(length * i / (count - 1) for i in range(count))


def tie_places(ties: int) -> tuple[float, ...]:
    """Where ties cross the passes, as fractions of the ribbon's length."""
    return tuple(0.1 + 0.8 * i / (ties + 1) for i in range(1, ties + 1))


@dataclass(frozen=True)
class CapturePlan:
    """What is to be captured; survey: the tables of a recording, checked once a ribbon is known.

    poses: the number of a plan of `calibration.plans`, or 0.  layout: how it is
    to be laid and measured.  source: where it came from, for messages.
    """

    poses: int = DEFAULT_POSES
    passes: int = DEFAULT_PASSES
    ties: int = DEFAULT_TIES
    title: str | None = None
    workpiece: Workpiece | None = None
    survey: Mapping[str, object] | None = None
    source: str = "the plan"
    layout: PlannedLayout = field(default_factory=PlannedLayout)

    def __post_init__(self) -> None:
        """Refuse what cannot be captured, with a SettingsError."""
        if self.poses != 0 and self.poses not in PLANS:
            known = ", ".join(map(str, PLANS))
            raise SettingsError(
                f"there is no plan of {self.poses} poses; choose {known}, or 0 for none"
            )
        for what, count in (("passes", self.passes), ("ties", self.ties)):
            if not 0 <= count <= MOST_PLANNED:
                raise SettingsError(f"{count} {what} are planned; plan 0 to {MOST_PLANNED}")

    def with_counts(self, counts: Mapping[str, int]) -> "CapturePlan":
        """The plan with other numbers of "poses", "passes" or "ties"."""
        return replace(
            self,
            poses=counts.get("poses", self.poses),
            passes=counts.get("passes", self.passes),
            ties=counts.get("ties", self.ties),
        )

    @property
    def planned_poses(self) -> tuple[PlannedPose, ...]:
        """The poses, in the order that is easy for the hands."""
        asked = PLANS.get(self.poses, ())
        return tuple(PlannedPose(f"pose-{i:02}", *one) for i, one in enumerate(asked, start=1))

    @property
    def planned_passes(self) -> tuple[PlannedPass, ...]:
        """The passes, then the ties."""
        passes = [PlannedPass(f"P{i}", "pass") for i in range(1, self.passes + 1)]
        return (*passes, *(PlannedPass(f"T{i}", "tie") for i in range(1, self.ties + 1)))


def check_survey(
    tables: Mapping[str, object], ribbon: Ribbon, passes: Iterable[str], source: str
) -> Survey:
    """The survey in the tables of a recording, checked against the ribbon and the passes.

    Raises SettingsError, with the entry and the field named, for what cannot be meant.
    """
    table = Table(dict(tables), Source(source, SettingsError), "", None, _SURVEY)
    return read_survey(table, ribbon, passes)


def read_plan(path: Path) -> CapturePlan:
    """The plan in a file; SettingsError, with the file and the field, for what cannot be meant."""
    data = read_bounded(path, MAX_PLAN, str(path), SettingsError)
    try:
        text = data.decode("utf-8-sig")
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        why = str(error) if isinstance(error, tomllib.TOMLDecodeError) else "not text, or too deep"
        raise SettingsError(
            f"{path}: this is no plan ({why}); give a TOML file as `georibbon capture --help` "
            "describes it"
        ) from error
    return _plan(Table(document, Source(path.name, SettingsError, text), "", None, _KNOWN))


def _plan(table: Table) -> CapturePlan:
    table.choice("format", (FORMAT,))
    version = table.whole("version", str(VERSION))
    if version != VERSION:
        table.refuse("version", f"version is {version}; {VERSION} is expected")
    counts = {key: _count(table, key) for key in _COUNTS if key in table.data}
    title = table.prose("title", "a title") if "title" in table.data else None
    survey = {key: table.data[key] for key in _SURVEY if key in table.data}
    return CapturePlan(
        **counts,
        title=title,
        workpiece=read_workpiece(table),
        survey=survey or None,
        source=table.source.name,
        layout=_layout(table),
    )


def _layout(top: Table) -> PlannedLayout:
    """The table [layout], what it lacks being as usual."""
    table = Table(top.data.get("layout", {}), top.source, "layout", None, _LAYOUT)
    given: dict[str, Any] = {}
    for key in (one for one in _LAYOUT if one in table.data):
        if key in _PLACES:
            given[key] = table.whole(key, "a whole number")
        else:
            given[key] = table.positive(key, "a length in metres")
    try:
        return PlannedLayout(**given)
    except SettingsError as error:
        table.refuse(None, str(error))


def write_plan(plan: CapturePlan, path: Path) -> None:
    """Write a plan that `read_plan` reads back; SettingsError where it cannot be written.

    A file that is there is replaced as a whole, or left as it was.
    """
    with built_file(path, SettingsError) as built:
        built.write_text(toml_text(_tables(plan)), encoding="utf-8")


def _tables(plan: CapturePlan) -> dict[str, object]:
    head: dict[str, object] = {"format": FORMAT, "version": VERSION}
    if plan.title is not None:
        head["title"] = plan.title
    head |= {key: getattr(plan, key) for key in _COUNTS}
    piece = plan.workpiece
    if piece is not None:
        heading = {} if piece.heading is None else {"heading": piece.heading}
        head["workpiece"] = {"level": piece.level} | heading
    return head | {"layout": asdict(plan.layout)} | dict(plan.survey or {})


def _count(table: Table, key: str) -> int:
    """A number of poses, passes or ties, of a size that can be told."""
    value = table.whole(key, f"a whole number of {key}")
    if abs(value) > MOST_PLANNED:
        table.refuse(key, f"{key} is beyond {MOST_PLANNED}; plan fewer")
    return value
