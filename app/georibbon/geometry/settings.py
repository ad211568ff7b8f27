"""What a person may choose of the surface: how it is laid through the passes, and its mesh."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from georibbon.errors import SettingsError

Direction = Literal["safe-chord", "chord", "conormal", "section", "angles"]
LengthRule = Literal[
    "arc",
    "unit",
    "criterion1",
    "criterion2",
    "criterion2-vector",
    "criterion3",
    "criterion4",
    "bending",
    "curvature-variation",
]
CorrespondenceRule = Literal["foot-cover", "foot-trim", "arc-length", "fraction"]
Interior = Literal["g1", "c1-lines", "g2"]
NormalRule = Literal["doubled-angle", "spline", "continuous", "raw"]
TangentRule = Literal["unrolled", "averages", "components"]

DIRECTIONS: tuple[Direction, ...] = get_args(Direction)
LENGTHS: tuple[LengthRule, ...] = get_args(LengthRule)
CORRESPONDENCES: tuple[CorrespondenceRule, ...] = get_args(CorrespondenceRule)
INTERIORS: tuple[Interior, ...] = get_args(Interior)
NORMAL_RULES: tuple[NormalRule, ...] = get_args(NormalRule)
TANGENTS: tuple[TangentRule, ...] = get_args(TangentRule)

LEAST_TOLERANCE = 1e-8  # m; finer than single precision tells in a file
LEAST_THICKNESS = 1e-5  # m; below it both sides fall together in a file
FACTOR_LIMITS = (0.05, 10.0)
GREATEST_ANGLE = 80.0  # degrees


@dataclass(frozen=True)
class SurfaceSettings:
    """How the surface is laid through the passes and made into triangles.

    tolerance: metres, how far triangles may leave the patches.  thickness:
    metres, of a closed solid whose outer face the surface is; None for none.

    direction: in which the lines across leave and reach the passes: along the
    chord brought into the tangent plane ("chord"), the same kept from turning
    back ("safe-chord"), square to the pass ("conormal"), in the plane of the
    chord and the mean normal ("section"), or at `angles`.
    lengths: the tangent length criterion: those of a circular arc ("arc"), the
    chord's ("unit"), a pair of factors of the chord, or those that minimise a
    criterion (see `georibbon.geometry.fairness`); "criterion4" chooses the
    directions too.
    correspondence: which points lie across from each other: feet, with both
    passes covered to their ends or cut to where they overlap, equal arc lengths
    from the beginning, or equal fractions of the lengths.
    interior: the surface across inner passes: smooth ("g1"), with lines across
    that run on smoothly ("c1-lines", chooses the directions; "criterion4" then
    means "arc"), or with equal curvature on both sides ("g2", chooses directions
    and lengths).
    angles: degrees, only for the direction "angles": from the conormal towards
    the run of the pass, where lines leave the first pass of a pair, at its
    beginning and at its end, and where they reach the second; linear between.
    cells: Coons patches where ties close a cell: the surface runs through the ties
    too (see `georibbon.geometry.cells`); only for the interior "g1".

    Raises SettingsError for what means nothing.
    """

    tolerance: float = 5e-5
    thickness: float | None = None
    direction: Direction = "safe-chord"
    lengths: LengthRule | tuple[float, float] = "arc"
    correspondence: CorrespondenceRule = "foot-cover"
    interior: Interior = "g1"
    angles: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    cells: bool = False

    def __post_init__(self) -> None:
        require_length("tolerance", self.tolerance, LEAST_TOLERANCE)
        require_length("thickness", self.thickness, LEAST_THICKNESS)
        require_one_of("direction", self.direction, DIRECTIONS)
        require_one_of("correspondence", self.correspondence, CORRESPONDENCES)
        require_one_of("interior", self.interior, INTERIORS)
        if not isinstance(self.cells, bool):
            raise SettingsError(f'the surface\'s cells is "{self.cells}"; it must be true or false')
        if isinstance(self.lengths, str):
            require_one_of("tangent length criterion", self.lengths, LENGTHS)
        else:
            factors = checked("tangent lengths", self.lengths, 2, FACTOR_LIMITS, " of the chord")
            object.__setattr__(self, "lengths", factors)
        limits = (-GREATEST_ANGLE, GREATEST_ANGLE)
        object.__setattr__(self, "angles", checked("angles", self.angles, 4, limits, "°"))

    @property
    def uses_direction(self) -> bool:
        """Whether `direction` counts, or another choice takes its place."""
        return self.interior == "g1" and self.lengths != "criterion4"

    @property
    def uses_lengths(self) -> bool:
        """Whether `lengths` counts, or another choice takes its place."""
        return self.interior != "g2"

    @property
    def uses_cells(self) -> bool:
        """Whether `cells` counts: lines over inner passes leave no room for the ties."""
        return self.interior == "g1"


def require_length(name: str, value: object, least: float) -> None:
    """Raise SettingsError unless the value is None or a length, metres, of at least so much."""
    if value is None:
        return
    if not isinstance(value, int | float):
        found = f'"{value}"'
    elif math.isfinite(value) and value >= least:
        return
    else:
        found = f"{1e3 * float(value):g} mm"
    raise SettingsError(
        f"the surface's {name} is {found}; it must be a length of at least {1e3 * least:g} mm"
    )


def require_one_of(name: str, value: object, words: Sequence[str]) -> None:
    """Raise SettingsError unless the value is one of the words."""
    if value not in words:
        raise SettingsError(
            f'the surface\'s {name} is "{value}"; it must be one of {", ".join(words)}'
        )


def checked(
    name: str, values: object, count: int, limits: tuple[float, float], unit: str
) -> tuple[float, ...]:
    """So many numbers within limits; raises SettingsError for anything else."""
    listed = values if isinstance(values, list | tuple) else ()
    fine = len(listed) == count and all(
        isinstance(one, int | float) and limits[0] <= one <= limits[1] for one in listed
    )
    if not fine:
        raise SettingsError(
            f"the surface's {name} are {values}; they must be {count} numbers between "
            f"{limits[0]:g} and {limits[1]:g}{unit}"
        )
    return tuple(float(one) for one in listed)
