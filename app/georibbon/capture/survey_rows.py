"""The survey as a table's rows: every entry with what the fit makes of it, and what to measure."""

from collections import defaultdict, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, cast

from georibbon.capture.plan import PlannedLayout, places, tie_places
from georibbon.reconstruction import SURVEY_OUTLIER, SurveyResidual

Table = Literal["mark", "distance", "crossing"]
TABLES: tuple[Table, ...] = ("mark", "distance", "crossing")
Entry = Mapping[str, object]
SUSPECT = 3.0  # standard deviations from which on an entry is looked at twice
_ALIKE = 1e-9


@dataclass(frozen=True)
class SurveyRow:
    """One entry of the survey, metres.

    number: from 1, in its table.  values: a mark's position, a distance, or
    nothing.  residual: metres, measured less fitted; ratio: in standard
    deviations; both None as long as there is no fit.
    """

    table: Table
    number: int
    passes: tuple[str, ...]
    at: tuple[float, ...]
    values: tuple[float, ...]
    sigma: float
    residual: float | None
    ratio: float | None

    @property
    def grade(self) -> Literal["open", "fits", "suspect", "outlier"]:
        """How the curves agree with it; "open" before there is a fit."""
        if self.ratio is None:
            return "open"
        if self.ratio > SURVEY_OUTLIER:
            return "outlier"
        return "suspect" if self.ratio > SUSPECT else "fits"

    def entry(self, **changes: object) -> dict[str, object]:
        """As in a recording, with some of at, values, sigma or passes changed."""
        get = {"passes": self.passes, "at": self.at, "values": self.values, "sigma": self.sigma}
        get |= changes
        return make_entry(
            self.table,
            cast("Sequence[str]", get["passes"]),
            cast("Sequence[float]", get["at"]),
            cast("Sequence[float]", get["values"]),
            cast("float", get["sigma"]),
        )


def make_entry(
    table: Table,
    passes: Sequence[str],
    at: Sequence[float],
    values: Sequence[float],
    sigma: float,
) -> dict[str, object]:
    """An entry as in a recording; lengths in metres."""
    if table == "mark":
        return {"pass": passes[0], "at": at[0], "position": list(values), "sigma": sigma}
    entry: dict[str, object] = {"passes": list(passes), "at": list(at)}
    if table == "distance":
        entry["distance"] = values[0]
    return entry | {"sigma": sigma}


def survey_rows(
    tables: Mapping[str, Sequence[Entry]], residuals: Iterable[SurveyResidual] = ()
) -> tuple[SurveyRow, ...]:
    """All entries in order: marks, distances, crossings, with the residuals that are theirs."""
    known: defaultdict[tuple[object, ...], deque[SurveyResidual]] = defaultdict(deque)
    for one in residuals:
        known[_key(one.kind, one.passes, one.at, one.sigma)].append(one)
    rows = []
    for table in TABLES:
        for number, entry in enumerate(tables.get(table, ()), start=1):
            passes, at, values, sigma = _parts(table, entry)
            found = known[_key(table, passes, at, sigma)]
            fit = found.popleft() if found else None
            rows.append(
                SurveyRow(
                    table, number, passes, at, values, sigma,
                    None if fit is None else fit.residual,
                    None if fit is None else fit.ratio,
                )
            )  # fmt: skip
    return tuple(rows)


def _key(
    table: str, passes: Sequence[str], at: Sequence[float], sigma: float
) -> tuple[object, ...]:
    return table, tuple(passes), tuple(round(one / _ALIKE) for one in at), round(sigma / _ALIKE)


def _parts(
    table: Table, entry: Entry
) -> tuple[tuple[str, ...], tuple[float, ...], tuple[float, ...], float]:
    """Passes, places, values and sigma of an entry."""
    sigma = cast("float", entry["sigma"])
    if table == "mark":
        position = tuple(cast("Sequence[float]", entry["position"]))
        return (cast("str", entry["pass"]),), (cast("float", entry["at"]),), position, sigma
    passes = tuple(cast("Sequence[str]", entry["passes"]))
    at = tuple(cast("Sequence[float]", entry["at"]))
    values = (cast("float", entry["distance"]),) if table == "distance" else ()
    return passes, at, values, sigma


def proposed(
    layout: PlannedLayout,
    length: float,
    passes: Sequence[str],
    ties: Sequence[str],
    tables: Mapping[str, Sequence[Entry]],
) -> tuple[tuple[Table, dict[str, object]], ...]:
    """What the plan says to measure and the survey has not yet, with what it would be about.

    Distances: the planned spacing.  Crossings: where ties meet passes that lie
    at the planned spacing, the tie's middle on the middle pass.  Marks are not
    proposed: nobody knows where they are.  length: the ribbon's, metres.
    """
    out: list[tuple[Table, dict[str, object]]] = []
    rows = survey_rows(tables)
    there = {(row.table, *sorted(row.passes)) for row in rows}
    for one, other in pairwise(passes):
        if ("distance", *sorted((one, other))) in there:
            continue
        for at in places(layout.distances, length):
            entry = make_entry(
                "distance", (one, other), (at, at), (layout.spacing,), layout.distance_sigma
            )
            out.append(("distance", entry))
    for fraction, tie in zip(tie_places(len(ties)), ties, strict=True):
        for k, name in enumerate(passes):
            along = length / 2 + (k - (len(passes) - 1) // 2) * layout.spacing
            if ("crossing", *sorted((name, tie))) in there or not 0.0 <= along <= length:
                continue
            at2 = (round(fraction * length, 4), round(along, 4))
            out.append(
                ("crossing", make_entry("crossing", (name, tie), at2, (), layout.crossing_sigma))
            )
    return tuple(out)
