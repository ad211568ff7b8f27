"""What is to be captured: the poses, the passes and ties, and the survey where it is known.

A plan file is TOML:

    format = "georibbon-plan"
    version = 1
    title = "bonnet"          # optional
    poses = 20                # a plan of so many calibration poses; 0: none
    passes = 5                # P1, P2, ...
    ties = 2                  # T1, T2, ...

with `[workpiece]`, `[[mark]]`, `[[distance]]` and `[[crossing]]` as in a
recording, all of them optional.
"""

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from georibbon.calibration.labels import describe
from georibbon.calibration.plans import PLANS
from georibbon.errors import SettingsError
from georibbon.recording import PassKind, Workpiece
from georibbon.ribbon import Ribbon
from georibbon.session.fields import Source, Table
from georibbon.session.files import read_bounded
from georibbon.session.outline import Survey, read_survey, read_workpiece

FORMAT = "georibbon-plan"
VERSION = 1
DEFAULT_POSES, DEFAULT_PASSES, DEFAULT_TIES = 20, 5, 0
MOST_PLANNED = 1000
MAX_PLAN = 4 * 2**20
_COUNTS = ("poses", "passes", "ties")
_SURVEY = ("mark", "distance", "crossing")
_KNOWN = ("format", "version", "title", *_COUNTS, "workpiece", *_SURVEY)


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
class CapturePlan:
    """What is to be captured; survey: the tables of a recording, checked once a ribbon is known.

    poses: the number of a plan of `calibration.plans`, or 0.  source: where it
    came from, for messages.
    """

    poses: int = DEFAULT_POSES
    passes: int = DEFAULT_PASSES
    ties: int = DEFAULT_TIES
    title: str | None = None
    workpiece: Workpiece | None = None
    survey: Mapping[str, object] | None = None
    source: str = "the plan"

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
    )


def _count(table: Table, key: str) -> int:
    """A number of poses, passes or ties, of a size that can be told."""
    value = table.whole(key, f"a whole number of {key}")
    if abs(value) > MOST_PLANNED:
        table.refuse(key, f"{key} is beyond {MOST_PLANNED}; plan fewer")
    return value
