"""How far a result is from the truth."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import RecordingError
from georibbon.geometry.closest import closest_point
from georibbon.geometry.frames import Strip, arc_angles, interpolated, unit
from georibbon.geometry.mesh import Mesh, facets
from georibbon.geometry.reference import ReferenceSurface
from georibbon.simulation.truth import Truth

if TYPE_CHECKING:  # so that simulating loads nothing of the fit
    from georibbon.reconstruction import Reconstruction


@dataclass(frozen=True)
class Errors:
    """Errors of a curve or of all: positions in millimetres, normals in degrees."""

    rms: float
    max: float
    normal_rms: float
    normal_max: float


@dataclass(frozen=True, eq=False)
class CurveErrors:
    """Curves against the truth.

    passes: by name; all: of all points together.  turn (3, 3), shift (3,):
    the rigid motion, x -> turn x + shift, that was applied first (the identity
    where not aligned).
    """

    passes: Mapping[str, Errors]
    all: Errors
    turn: FloatArray
    shift: FloatArray


@dataclass(frozen=True, eq=False)
class Score:
    """A reconstruction against the truth.

    curves: in their own frame or, `aligned`, after the best rigid motion.
    surface_rms, surface_max: millimetres, the distances of the mesh's vertices
    from the true surface, after the same motion, rms weighted by the vertices'
    areas; None without a mesh or a known surface.
    """

    curves: CurveErrors
    aligned: bool
    surface_rms: float | None
    surface_max: float | None


def score(reconstruction: "Reconstruction", truth: Truth) -> Score:
    """Compare a reconstruction (not thickened) with the truth.

    Where the survey holds no mark, nothing fixes the workpiece's frame and the
    curves are first moved rigidly onto the truth.
    """
    aligned = not any(item.kind == "mark" for item in reconstruction.survey)
    strips = {fitted.name: fitted.strip for fitted in reconstruction.passes}
    curves = curve_errors(strips, truth, align=aligned)
    if reconstruction.surface is None or truth.shape is None:
        return Score(curves, aligned, None, None)
    mesh = reconstruction.surface.mesh
    rms, worst = surface_errors(mesh, truth.shape, curves.turn, curves.shift)
    return Score(curves, aligned, rms, worst)


def curve_errors(strips: Mapping[str, Strip], truth: Truth, align: bool) -> CurveErrors:
    """Compare curves with the truth at the truth's distances along each.

    Raises `RecordingError` where the truth's passes have no curve.
    """
    missing = [name for name in truth.strips if name.startswith("P") and name not in strips]
    if missing or not truth.strips:
        raise RecordingError(
            f"no curve for {', '.join(missing) or 'any pass'} of the truth: "
            "compare with the truth of the same recording"
        )
    names = [name for name in truth.strips if name in strips]
    pairs = {name: _matched(strips[name], truth.strips[name]) for name in names}
    turn, shift = np.eye(3), np.zeros(3)
    if align:
        turn, shift = rigid_motion(
            np.concatenate([found[:, :3] for found, _ in pairs.values()]),
            np.concatenate([true[:, :3] for _, true in pairs.values()]),
        )
    each = {name: _deviations(*pair, turn, shift) for name, pair in pairs.items()}
    total = _errors(np.concatenate(list(each.values()), axis=1))
    return CurveErrors({name: _errors(values) for name, values in each.items()}, total, turn, shift)


def _matched(found: Strip, true: Strip) -> tuple[FloatArray, FloatArray]:
    """(n, 6) points and normals of both curves at the truth's distances that both cover."""
    keep = (true.s >= found.s[0] - 1e-9) & (true.s <= found.s[-1] + 1e-9)
    columns = np.concatenate([found.points, found.normals], axis=1)
    at = interpolated(true.s[keep], found.s, columns)
    at[:, 3:] = unit(at[:, 3:])
    return at, np.concatenate([true.points, true.normals], axis=1)[keep]


def _deviations(
    found: FloatArray, true: FloatArray, turn: FloatArray, shift: FloatArray
) -> FloatArray:
    """(2, n) position errors in millimetres and normal errors in degrees."""
    gap = found[:, :3] @ turn.T + shift - true[:, :3]
    angles = arc_angles(found[:, 3:] @ turn.T, true[:, 3:])
    return np.stack([1e3 * np.linalg.norm(gap, axis=1), np.degrees(angles)])


def _errors(values: FloatArray) -> Errors:
    rms = np.sqrt(np.mean(values**2, axis=1))
    worst = values.max(axis=1)
    return Errors(float(rms[0]), float(worst[0]), float(rms[1]), float(worst[1]))


def rigid_motion(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The rotation (3, 3) and shift (3,) that carry points a (n, 3) onto b, least squares.

    Kabsch's method: the singular vectors of the covariance, reflections barred.
    """
    middle_a, middle_b = a.mean(axis=0), b.mean(axis=0)
    u, _, vt = np.linalg.svd((a - middle_a).T @ (b - middle_b))
    turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt).T
    return turn, middle_b - turn @ middle_a


def surface_errors(
    mesh: Mesh, shape: ReferenceSurface, turn: FloatArray, shift: FloatArray
) -> tuple[float, float]:
    """The rms (weighted by area) and greatest distance, mm, of a mesh's vertices from a surface.

    turn, shift: applied to the mesh first.
    """
    vertices = mesh.vertices @ turn.T + shift
    distance = 1e3 * closest_point(shape, vertices).distance
    area = np.linalg.norm(facets(mesh), axis=1)
    weight = np.bincount(mesh.triangles.ravel(), np.repeat(area, 3), minlength=len(vertices))
    rms = np.sqrt(np.sum(weight * distance**2) / np.sum(weight))
    return float(rms), float(np.abs(distance).max())
