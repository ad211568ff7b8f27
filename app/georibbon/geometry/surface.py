"""The surface through the passes: geodesic Hermite patches between neighbours."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SurfaceError
from georibbon.geometry.cells import no_cells, with_cells
from georibbon.geometry.checks import Check, all_checks
from georibbon.geometry.components import interleaved
from georibbon.geometry.correspondence import aligned, arrange
from georibbon.geometry.frames import Strip, dot
from georibbon.geometry.mesh import Mesh, area, grid_mesh, thicken
from georibbon.geometry.patch import (
    Lines,
    Patches,
    PatchGrid,
    PatchSet,
    basis,
    lifted,
    lines_at,
    natural_parameters,
    patch_grid,
    patches_at,
    patches_between,
)
from georibbon.geometry.rails import PINCHED, interpolant
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.vertices import vertices_of

__all__ = ["Check", "Surface", "SurfaceSettings", "build_surface", "rebuilt"]


LEAST_POINTS = 4
MOST_TRIANGLES = 5_000_000
GREATEST_EDGE = 0.02  # m
MOST_EDGES = 500  # from end to end of an object, that carry its deviations where it is large
ANALYSIS_ROWS = 9
SAME_LENGTH = 1e-9  # m
SKEWED = 1e-3  # of the products of a frame's vectors
# Shares of the tolerance for the chord error along, across and by twist; the rest is margin.
STRETCH_SHARE = 0.35
TWIST_SHARE = 0.2
NARROW = 0.1  # of a patch's greatest width
UPRIGHT = 0.3  # of `PatchGrid.turn`, above which no fold is looked for between its places


@dataclass(frozen=True, eq=False)
class SurfacePlan:
    """What a surface was made from and where it was cut.

    model: the passes in order across, matched.  nodes: (k,) parameters of the
    grid's rows.  counts: (p-1,) columns of each patch.  tolerance: metres, that was asked for.
    upright: whether no patch is near to folding over.
    """

    model: PatchSet
    nodes: FloatArray
    counts: IntArray
    tolerance: float
    upright: bool = False


@dataclass(frozen=True, eq=False)
class Surface:
    """The built surface: its mesh, its area (m²) and its checks.

    mesh: the skin that the passes lie on.  solid: the skin thickened to a
    closed solid, where a thickness was asked for.  columns: (p,) int64, for
    the passes in `order` which column of the mesh's grid they are; shape: the
    grid (rows along the passes, columns across), vertices in row-major order.
    plan: how it was cut, for `rebuilt`.
    """

    mesh: Mesh
    area: float
    checks: tuple[Check, ...]
    solid: Mesh | None = None
    order: tuple[str, ...] = ()
    shape: tuple[int, int] = (0, 0)
    columns: tuple[int, ...] = ()
    plan: SurfacePlan | None = None

    @property
    def export_mesh(self) -> Mesh:
        """What is written to a file: the solid where there is one, else the skin."""
        return self.mesh if self.solid is None else self.solid


def build_surface(
    strips: Sequence[Strip],
    names: Sequence[str],
    settings: SurfaceSettings,
    sigmas: Sequence[FloatArray] | None = None,
    frame_sigma: Sequence[FloatArray] | None = None,
    ties: Sequence[tuple[str, Strip]] = (),
) -> Surface:
    """The surface through p passes, given in any order and run in any direction.

    strips: at least two, of at least four points.  names: one for each strip.
    sigmas: (n,) metres for each strip, the standard deviation of its points.
    frame_sigma: (n,) radians for each strip, of its normals.
    ties: strips across the passes, with their names, for settings that have cells.

    Raises SurfaceError where the passes do not span a surface, where numbers
    are not finite, where more than five million triangles would be needed, or
    where the solid would fold over itself.
    """
    check_strips(strips, names)
    model = patches_between(arrange(strips), settings)
    ordered_names = tuple(names[i] for i in model.arrangement.order)
    model, cells = taken_up(model, ordered_names, settings, ties)
    u = natural_parameters(model)
    sample = patches_at(model, u)
    check_apart(sample, ordered_names)
    grid = grid_of(sample)
    nodes, counts = subdivided(sample, grid, u, settings.tolerance)
    spread = None if sigmas is None else carried(model, in_order(sigmas, model), nodes)
    upright = float(grid.turn.min()) > UPRIGHT
    mesh = triangulated(lines_at(model, nodes), counts, spread, upright)
    expected = None if frame_sigma is None else in_order(frame_sigma, model)
    return Surface(
        mesh=mesh,
        area=area(mesh),
        checks=(*all_checks(model, ordered_names, sample, grid, expected), *cells),
        solid=None if settings.thickness is None else thicken(mesh, settings.thickness),
        order=ordered_names,
        shape=(len(nodes), 1 + int(counts.sum())),
        columns=(0, *(int(column) for column in np.cumsum(counts))),
        plan=SurfacePlan(model, nodes, counts, settings.tolerance, upright),
    )


def taken_up(
    model: PatchSet,
    names: Sequence[str],
    settings: SurfaceSettings,
    ties: Sequence[tuple[str, Strip]],
) -> tuple[PatchSet, tuple[Check, ...]]:
    """The model with the ties where they close cells, and what was found; itself where not asked.

    names: of the model's passes, in its order.
    """
    if not settings.cells:
        return model, ()
    if not (settings.uses_cells and ties):
        return model, (no_cells(settings),)
    check_strips([strip for _, strip in ties], [name for name, _ in ties], 1)
    return with_cells(model, names, ties)


def rebuilt(surface: Surface, strips: Sequence[Strip]) -> Surface:
    """The same surface through passes that moved a little: same rows, columns and triangles.

    surface: as `build_surface` made it.  strips: the same passes in the same
    order as then, each over the same arc lengths, their points and frames new.
    What lies across from what is kept, what a criterion found and what ties add, as are the
    checks and the mesh's sigma; there is no solid.  A preview, in a fraction of
    the time of a new surface.
    Raises SurfaceError where the passes are not those of the surface.
    """
    plan = surface.plan
    if plan is None or not same_passes(plan.model, strips):
        raise SurfaceError(
            "these are not the passes that the surface was built through, in number or length: "
            "build it anew"
        )
    lines = lines_at(moved_model(plan.model, strips), plan.nodes)
    points, normals = vertices_of(lines, plan.counts, plan.upright)
    old = surface.mesh
    vertices = interleaved(points).reshape(-1, 3)
    mesh = Mesh(vertices, old.triangles, normals.reshape(-1, 3), old.sigma)
    return replace(surface, mesh=mesh, area=area(mesh), solid=None)


def same_passes(model: PatchSet, strips: Sequence[Strip]) -> bool:
    """Whether strips, in the order they were given, are as many and as long as the model's."""
    old = model.arrangement
    return len(strips) == len(old.order) and all(
        np.isclose(np.ptp(strips[i].s), np.ptp(strip.s), rtol=0.0, atol=SAME_LENGTH)
        for i, strip in zip(old.order, old.strips, strict=True)
    )


def moved_model(model: PatchSet, strips: Sequence[Strip]) -> PatchSet:
    """The model with strips, as given, in the place of its own."""
    old = model.arrangement
    turns = zip(old.order, old.turned, old.flipped, strict=True)
    ordered = tuple(aligned(strips[i], bool(t), bool(f)) for i, t, f in turns)
    return replace(
        model,
        arrangement=replace(old, strips=ordered),
        splines=tuple(interpolant(strip) for strip in ordered),
    )


def check_strips(strips: Sequence[Strip], names: Sequence[str], least: int = 2) -> None:
    """Raise SurfaceError unless there are enough strips, of enough finite points."""
    if len(strips) < least:
        raise SurfaceError(
            f"{len(strips)} pass cannot span a surface, at least 2 are needed: "
            "lay another beside it"
        )
    for strip, name in zip(strips, names, strict=True):
        if len(strip.s) < LEAST_POINTS:
            raise SurfaceError(
                f"pass {name} has {len(strip.s)} points, at least {LEAST_POINTS} are needed: "
                "fit it at more places"
            )
        if not all(np.isfinite(values).all() for values in (strip.s, strip.points, strip.frames)):
            raise SurfaceError(
                f"pass {name} has points or normals that are not numbers: "
                "fit it again or leave it out"
            )
        square = np.swapaxes(strip.frames, 1, 2) @ strip.frames
        if np.abs(square - np.eye(3)).max() > SKEWED:
            raise SurfaceError(
                f"pass {name} has frames that are not three unit vectors square to each other: "
                "make them so or fit it again"
            )
        if (np.diff(strip.s) <= 0.0).any():
            raise SurfaceError(
                f"pass {name} has places along the ribbon that do not ascend: sort them"
            )


def check_apart(sample: Patches, names: Sequence[str]) -> None:
    """Raise SurfaceError where all neighbours lie on each other."""
    widest = float(sample.mean_gaps.max())
    if widest < PINCHED:
        raise SurfaceError(
            f"the passes {names[0]} to {names[-1]} lie on each other, {1e3 * widest:.2f} mm apart "
            f"at most, at least {1e3 * PINCHED:.0f} mm is needed to span a surface: "
            "place them by marks, distances or ties"
        )


def in_order(values: Sequence[FloatArray], model: PatchSet) -> list[FloatArray]:
    """Values (n,) of each pass as given, put into the order across and the common direction."""
    arrangement = model.arrangement
    return [
        values[i][::-1] if turned else values[i]
        for i, turned in zip(arrangement.order, arrangement.turned, strict=True)
    ]


def carried(model: PatchSet, values: Sequence[FloatArray], u: FloatArray) -> FloatArray:
    """(p, k) values (n,) of each pass, in order across, at the parameters u (k,)."""
    strips, places = model.arrangement.strips, model.match(u)
    return np.stack(
        [np.interp(s, strip.s, of) for s, strip, of in zip(places, strips, values, strict=True)]
    )


def grid_of(sample: Patches) -> PatchGrid:
    """All patches (p-1, k, 9, 3), v from 0 to 1."""
    normals = sample.rails.frames[..., 2]
    v = np.linspace(0.0, 1.0, ANALYSIS_ROWS)
    grid = patch_grid(sample.control, sample.slope, (normals[:-1], normals[1:]), v)
    for i in range(len(normals) - 1):
        one = PatchGrid(grid.points[i], grid.along[i], grid.across[i], grid.reference[i])
        more = lifted(one, sample, i, v)
        grid.points[i], grid.along[i], grid.across[i] = more.points, more.along, more.across
    return grid


def subdivided(
    sample: Patches, grid: PatchGrid, u: FloatArray, tolerance: float
) -> tuple[FloatArray, IntArray]:
    """Where to cut: parameters (k,), and for each patch the number of cuts across (p-1,).

    A triangle of a right-angled cell a by b leaves the patch by at most
    (|L| a² + 2 |M| a b + |N| b²) / 8 with L, M, N the second derivatives' parts
    along the normal.  No edge is longer than 2 cm, or a five-hundredth of a
    large object, so that deviations are carried in detail.  Raises SurfaceError
    where the triangles would be too many.
    """
    v, rows = np.linspace(0.0, 1.0, ANALYSIS_ROWS), sample.control.shape[-2]
    stretch = 8.0 * STRETCH_SHARE * tolerance
    speed_u = np.sqrt(dot(grid.along, grid.along))
    speed_v, normals = widths(grid), grid.normals
    bends = basis(v, 0, rows) @ sample.bend
    twists, crossways = basis(v, 1, rows) @ sample.slope, basis(v, 2, rows) @ sample.control
    for i, lift in enumerate(sample.cells.lifts if sample.cells is not None else ()):
        if lift is not None:
            for of, more in zip((bends, twists, crossways), lift.bends(u, v), strict=True):
                of[i] += more
    twist = normal_part(twists, normals)
    rate = np.sqrt(twist / np.maximum(speed_u, PINCHED) / speed_v / (4.0 * TWIST_SHARE * tolerance))
    size = float(np.linalg.norm(np.ptp(grid.points.reshape(-1, 3), axis=0)))
    rate = np.maximum(rate, 1.0 / max(GREATEST_EDGE, size / MOST_EDGES))
    along = np.sqrt(normal_part(bends, normals) / stretch)
    across = np.sqrt(normal_part(crossways, normals) / stretch)
    density = np.maximum(along, speed_u * rate).max(axis=(0, 2))
    counts = np.ceil(np.maximum(across, speed_v * rate).max(axis=(1, 2))).astype(np.int64)
    return equal_shares(u, density, int(counts.sum())), counts


def widths(grid: PatchGrid) -> FloatArray:
    """(..., k, m) |F_v|, or a tenth of the patch's greatest where it narrows to less.

    Where passes meet in a point it then asks for cells of a finite size, and for
    no larger ones than the patch needs.
    """
    speed: FloatArray = np.sqrt(dot(grid.across, grid.across))
    least = NARROW * speed.max(axis=(-2, -1), keepdims=True)
    wide: FloatArray = np.maximum(speed, np.maximum(PINCHED, least))
    return wide


def normal_part(derivative: FloatArray, normals: FloatArray) -> FloatArray:
    """(...) the size of vectors (..., 3) along unit normals (..., 3)."""
    part: FloatArray = np.abs(dot(derivative, normals))
    return part


def equal_shares(u: FloatArray, density: FloatArray, columns: int) -> FloatArray:
    """(k,) parameters between u[0] and u[-1], as dense as `density` (n,) at u (n,) asks."""
    around = np.maximum.reduce([density[:-1], density[1:]])
    total = np.concatenate([[0.0], np.cumsum(around * np.diff(u))])
    rows = max(int(np.ceil(total[-1])), 1)
    triangles = 2 * rows * columns
    if triangles > MOST_TRIANGLES:
        raise SurfaceError(
            f"this tolerance needs about {triangles:.1e} triangles, at most "
            f"{MOST_TRIANGLES:.0e} are made: choose a larger tolerance, "
            "or check the passes for jumps and for places where one turns back on itself"
        )
    nodes = np.interp(np.linspace(0.0, total[-1], rows + 1), total, u)
    nodes[[0, -1]] = u[[0, -1]]
    return nodes


def triangulated(lines: Lines, counts: IntArray, spread: FloatArray | None, upright: bool) -> Mesh:
    """The mesh of all patches on one grid, with counts (p-1,) columns a patch.

    spread: (p, k) metres, standard deviations on the passes; between them the
    variances are blended linearly.
    """
    points, normals = vertices_of(lines, counts, upright)
    shares = [np.zeros(1), *(i + np.arange(1, n + 1) / n for i, n in enumerate(counts))]
    sigma = None if spread is None else blended(spread, np.concatenate(shares))
    return grid_mesh(points, normals, sigma)


def blended(spread: FloatArray, shares: FloatArray) -> FloatArray:
    """(k, w) metres: standard deviations (p, k) on passes, their squares blended across.

    shares: (w,), for each column the pass before it plus its share of the way to the next.
    """
    squares = spread.T**2
    first = np.minimum(shares.astype(int), len(spread) - 2)
    part = shares - first
    sigma: FloatArray = np.sqrt((1.0 - part) * squares[:, first] + part * squares[:, first + 1])
    return sigma
