"""Surfaces between curves as a figure asks for them, and what is measured of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.closest import closest_point
from georibbon.geometry.correspondence import aligned, arrange
from georibbon.geometry.crossings import crossing_triangles
from georibbon.geometry.directions import angles_of, directions_of
from georibbon.geometry.frames import Strip, arc_angles, cross, dot, unit
from georibbon.geometry.mesh import grid_mesh
from georibbon.geometry.patch import (
    PatchGrid,
    basis,
    natural_parameters,
    patch_grid,
    patches_at,
    patches_between,
)
from georibbon.geometry.rails import Rails
from georibbon.geometry.reference import ReferenceSurface
from georibbon.geometry.scheme import (
    Found,
    arc_lengths,
    directions_at,
    hermite_control,
    lengths_at,
)
from georibbon.geometry.settings import Direction, SurfaceSettings
from georibbon.paper_figures.figure import Curve, Model

ROWS, COLUMNS = 121, 17
CROSSING_ROWS, CROSSING_STEP = 61, 1
TEAR_LIMIT, FOLD_LIMIT = 3.0, 0.0
DEFAULT = "safe-chord, arc, foot-cover"

Numbers = dict[str, float]


@dataclass(frozen=True, eq=False)
class Built:
    """Patches between curves.

    rails: the curves at matched parameters.  control: (p-1, k, 4, 3) metres.
    grid: the patches' points and derivatives, (p-1, k, m, 3).  lambdas:
    (p-1, k, 2) tangent lengths over the chord; angles: (p-1, k, 2) radians from
    the conormals.  found: what a criterion found.
    """

    rails: Rails
    control: FloatArray
    grid: PatchGrid
    lambdas: FloatArray
    angles: FloatArray
    found: Found | None = None

    @property
    def points(self) -> FloatArray:
        """(p-1, k, m, 3) metres."""
        return self.grid.points

    @property
    def normals(self) -> FloatArray:
        """(p-1, k, m, 3) the patches' own unit normals, wherever they fold."""
        return unit(cross(self.grid.along, self.grid.across))


def laid_by(strips: Sequence[Strip], settings: SurfaceSettings | None = None) -> Built:
    """The surface through strips as `georibbon reconstruct` lays it; its own default if None."""
    model = patches_between(arrange(strips), settings)
    ends = natural_parameters(model)
    u = np.linspace(ends[0], ends[-1], ROWS)
    patches = patches_at(model, u)
    directions = directions_at(patches.rails, model.scheme, u)
    lambdas = lengths_at(patches.rails, directions, model.scheme, u)
    grid = _grid(patches.rails, patches.control, patches.slope)
    return _built(patches.rails, patches.control, grid, directions, lambdas, model.scheme.found)


def laid_plainly(
    strips: Sequence[Strip], direction: Direction, factors: tuple[float, float] | None = None
) -> Built:
    """The surface between samples of the same number, whatever their frames do in between.

    factors: the tangent lengths over the chord; those of an arc where None.
    Derivatives along the curves are differences of the samples.  A strip is
    turned over as a whole where its conormals point away from the other, never
    sample by sample.
    """
    strips = facing(strips)
    rails = Rails(
        np.stack([one.points for one in strips]), np.stack([one.frames for one in strips])
    )
    directions = directions_of(rails, direction)
    if factors is None:
        lambdas = (arc_lengths(directions[0], rails), arc_lengths(directions[1], rails))
    else:
        lambdas = (factors[0] * np.ones_like(rails.gaps), factors[1] * np.ones_like(rails.gaps))
    control = hermite_control(rails, directions, lambdas)
    slope = np.gradient(control, axis=1)
    return _built(rails, control, _grid(rails, control, slope), directions, lambdas, None)


def facing(strips: Sequence[Strip]) -> list[Strip]:
    """The strips, each turned over where most of its conormals point backwards."""
    chords = np.diff(np.stack([one.points for one in strips]), axis=0)
    return [
        aligned(one, False, float(np.sum(dot(one.conormals, chord))) < 0.0)
        for one, chord in zip(strips, [*chords, chords[-1]], strict=True)
    ]


def _grid(rails: Rails, control: FloatArray, slope: FloatArray) -> PatchGrid:
    normals = rails.frames[..., 2]
    return patch_grid(control, slope, (normals[:-1], normals[1:]), np.linspace(0.0, 1.0, COLUMNS))


def _built(
    rails: Rails,
    control: FloatArray,
    grid: PatchGrid,
    directions: tuple[FloatArray, FloatArray],
    lambdas: tuple[FloatArray, FloatArray],
    found: Found | None,
) -> Built:
    sides = (rails.frames[:-1], rails.frames[1:])
    angles = [angles_of(one, frames) for one, frames in zip(directions, sides, strict=True)]
    return Built(rails, control, grid, np.stack(lambdas, axis=-1), np.stack(angles, axis=-1), found)


def tear_ratio(points: FloatArray) -> float:
    """The longest step along u of a grid (p-1, k, m, 3) over the usual (median) one."""
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    return float(steps.max() / np.median(steps))


def crossings_of(points: FloatArray, normals: FloatArray) -> float:
    """How many pairs of triangles of a grid (k, m, 3) run through each other."""
    return float(len(crossing_triangles(grid_mesh(points, normals))))


def self_crossing_pairs(built: Built) -> float:
    """The same of a coarse mesh of all patches."""
    rows = np.unique(np.linspace(0, built.points.shape[1] - 1, CROSSING_ROWS).astype(int))
    points, normals = (
        values[:, rows][:, :, ::CROSSING_STEP] for values in (built.points, built.normals)
    )
    points, normals = (
        np.concatenate([values[0, :, :1], *values[:, :, 1:]], axis=1)
        for values in (points, normals)
    )
    return crossings_of(points, normals)


def normal_jump(strips: Sequence[Strip]) -> float:
    """Degrees: the greatest turn of the strips' normals from one sample to the next."""
    turns = [arc_angles(one.normals[:-1], one.normals[1:]).max() for one in strips]
    return float(np.degrees(max(turns)))


def shape_numbers(built: Built) -> Numbers:
    """Whether a surface tears, folds or runs through itself."""
    along, across = built.grid.along, built.grid.across
    square = cross(along, across)
    sizes = np.sqrt(dot(along, along) * dot(across, across))
    sine = np.sqrt(dot(square, square)) / np.where(sizes > 0.0, sizes, 1.0)
    return {
        "tear_ratio": tear_ratio(built.points),
        "self_crossing_pairs": self_crossing_pairs(built),
        "fold_least": float(built.grid.turn.min()),
        "sine_least": float(sine.min()),
    }


def length_numbers(built: Built) -> Numbers:
    """The tangent lengths and directions that were chosen, and what the search says of itself."""
    numbers = {
        "lambda_least": float(built.lambdas.min()),
        "lambda_greatest": float(built.lambdas.max()),
        "angle_greatest_deg": float(np.degrees(np.abs(built.angles).max())),
    }
    if built.found is not None:
        numbers["unsettled_percent"] = 100.0 * float(built.found.unsettled.max())
        numbers["bounded_percent"] = 100.0 * float(built.found.bounded.max())
    return numbers


def skew(built: Built) -> float:
    """Degrees: how far chords stand from square to the curves, at most."""
    chords = unit(built.rails.chords)
    sides = (built.rails.frames[:-1, ..., 0], built.rails.frames[1:, ..., 0])
    return float(np.degrees(np.arcsin(max(np.abs(dot(chords, one)).max() for one in sides))))


def line_numbers(built: Built) -> Numbers:
    """How fast the lines across leave, pass and arrive, and how long they are, over the chord."""
    speeds = basis(np.linspace(0.0, 1.0, 65), 1, 4) @ built.control
    sizes = np.linalg.norm(speeds, axis=-1) / built.rails.gaps[..., None]
    return {
        "start_speed": float(sizes[..., 0].mean()),
        "middle_speed": float(sizes[..., 32].mean()),
        "end_speed": float(sizes[..., -1].mean()),
        "line_length": float(np.trapezoid(sizes, dx=1.0 / 64.0, axis=-1).mean()),
    }


def distances(built: Built, truth: ReferenceSurface) -> FloatArray:
    """(p-1, k, m) millimetres from the built surface to the true one, signed."""
    found = closest_point(truth, built.points.reshape(-1, 3), grid=150)
    return 1e3 * found.distance.reshape(built.points.shape[:-1])


def error_numbers(away: FloatArray) -> Numbers:
    """rms and greatest of distances, millimetres."""
    return {"rms_mm": float(np.sqrt(np.mean(away**2))), "max_mm": float(np.abs(away).max())}


def verdict_of(numbers: Numbers) -> str:
    """What is wrong with a surface, in a few words."""
    faults = []
    if numbers["tear_ratio"] > TEAR_LIMIT:
        faults.append("torn")
    if numbers["fold_least"] <= FOLD_LIMIT:
        faults.append("folded")
    if numbers["self_crossing_pairs"] > 0.0:
        faults.append("runs through itself")
    return ", ".join(faults) if faults else "whole"


def model_of(
    built: Built,
    strips: Sequence[Strip],
    values: FloatArray | None = None,
    arrows: tuple[FloatArray, FloatArray] | None = None,
) -> Model:
    """The surface with its curves and the lines across, for drawing."""
    every = max(1, built.points.shape[1] // 16)
    lines = [Curve(line, bold=False) for patch in built.points for line in patch[::every]]
    return Model(
        grids=tuple(built.points),
        normals=tuple(built.normals),
        values=() if values is None else tuple(values),
        curves=(*(Curve(one.points) for one in strips), *lines),
        arrows=arrows,
    )


def conormal_arrows(
    strips: Sequence[Strip], length: float, every: int = 8
) -> tuple[FloatArray, FloatArray]:
    """From and to, (n, 3) each: the conormals of every so many samples, so long, metres."""
    points = np.concatenate([one.points[::every] for one in strips])
    ahead = np.concatenate([one.conormals[::every] for one in strips])
    return points, points + length * ahead
