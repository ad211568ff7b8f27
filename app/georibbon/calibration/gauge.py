"""The gauge: from the solution's frame to the ribbon's, by the bar's faces on a table.

Readings cannot tell a rotation common to all sensors.  The faces of the bar
can: with a face on the table, "up" in the ribbon's frame is Rx(-roll) Rz(-psi)
(t1, t2, 1), t the table's own tilt, which turning the bar end for end tells
from the rotation.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.calibration.accelerometers import tangents
from georibbon.rotations import about_x, about_z, exp, skew, to_up

# Standard deviations, radians: how squarely a face lies on the table, and how
# level a table is before anything is measured.
FACE = np.radians(0.1)
TABLE = np.radians(2.0)
STEPS = 12
BELIEF = 4.0
# A face this far off the table, and off the other faces, did not lie on it.
NOT_FLAT = np.radians(1.0)
LEAST_FACES = 4


@dataclass(frozen=True, eq=False)
class Gauge:
    """rotation: (3, 3) ribbon to solution frame; tilt: (2,) of the table, radians.

    sigma: radians, of the common rotation, about the axis where it is largest,
    for faces as square as FACE says; found: the same for faces as square as the
    residuals say; residuals: (p,) radians, how far each table pose is off its face (NaN: not on
    the table).  target: (p, 3) "up" in the solution's frame as the faces have it.
    square: (3 p, 3 p) projection of the poses' "up" on what square faces say of
    them, whatever the rotation and the tilt are.
    """

    rotation: FloatArray
    tilt: FloatArray
    sigma: float
    found: float
    residuals: FloatArray
    target: FloatArray
    square: FloatArray


def fit_gauge(frames: FloatArray, roll: FloatArray, table: BoolArray) -> Gauge:
    """The gauge from the poses' frames (p, 3, 3), solution frame to world.

    roll: (p,) radians, which face is up; table: (p,) bool.  Each table pose
    has frames @ Q = T Rz(psi) Rx(roll): its "up" gives two equations, and its
    heading psi comes along.
    """
    places = np.flatnonzero(table)
    faces = about_x(roll[places])
    up = frames[places][:, 2, :]
    rotation, tilt = np.eye(3), np.zeros(2)
    jacobian = np.zeros((len(places), 3, 5))
    residual = np.zeros((len(places), 3))
    for _ in range(STEPS):
        normal = np.append(tilt, np.sqrt(1.0 - tilt @ tilt))
        forward = (frames[places] @ rotation @ faces.mT)[:, :, 0] @ to_up(normal)
        turns = faces.mT @ about_z(-np.arctan2(forward[:, 1], forward[:, 0]))
        seen = up @ rotation
        residual = seen - turns @ normal
        jacobian[:, :, :3] = skew(seen)
        jacobian[:, :, 3:] = -turns[:, :, :2]
        step = -np.linalg.lstsq(jacobian.reshape(-1, 5), residual.ravel(), rcond=1e-4)[0]
        rotation, tilt = rotation @ exp(step[:3]), tilt + step[3:]
        if np.abs(step).max() < 1e-13:
            break
    off = np.full(len(table), np.nan)
    off[places] = np.linalg.norm(residual, axis=1)
    target = frames[:, 2, :].copy()
    target[places] -= residual @ rotation.T
    square = _square(up, jacobian, rotation, places, len(table))
    sigma = gauge_sigma(jacobian)
    return Gauge(rotation, tilt, sigma, sigma * _roughness(residual), off, target, square)


def _roughness(residual: FloatArray) -> float:
    """How the faces' spread compares with FACE, which counts as BELIEF readings more."""
    freedom = max(2 * len(residual) - 5, 0)
    squares = float((residual**2).sum()) / FACE**2
    return float(np.sqrt((BELIEF + squares) / (BELIEF + freedom)))


def settle(
    frames: FloatArray, roll: FloatArray, table: BoolArray
) -> tuple[Gauge, list[tuple[int, float]]]:
    """The gauge without the poses whose face did not lie on the table.

    Returns it and the places of the poses left out, each with the angle, in
    radians, by which it was off.
    """
    table, out = table.copy(), []
    gauge = fit_gauge(frames, roll, table)
    while table.sum() > LEAST_FACES:
        off = np.where(table, gauge.residuals, 0.0)
        worst = int(np.argmax(off))
        if off[worst] <= max(5.0 * float(np.median(off[table])), NOT_FLAT):
            break
        table[worst] = False
        gauge = fit_gauge(frames, roll, table)
        out.append((worst, float(off[worst])))
    return gauge, out


def _square(
    up: FloatArray, jacobian: FloatArray, rotation: FloatArray, places: IntArray, poses: int
) -> FloatArray:
    basis = tangents(up)
    nuisance = np.einsum("pca,pcm->pam", basis, rotation @ jacobian).reshape(-1, 5)
    free = np.eye(len(nuisance)) - nuisance @ np.linalg.pinv(nuisance, rcond=1e-4)
    pairs = free.reshape(len(places), 2, len(places), 2)
    full = np.zeros((poses, 3, poses, 3))
    full[places[:, None], :, places[None, :], :] = np.einsum(
        "pca,paqb,qdb->pqcd", basis, pairs, basis, optimize=True
    )
    return full.reshape(3 * poses, 3 * poses)


def gauge_sigma(jacobian: FloatArray) -> float:
    """Radians, about the worst axis, from the (n, 3, 5) derivatives of the table's "up"."""
    flat = jacobian.reshape(-1, 5)
    information = flat.T @ flat / FACE**2 + np.diag([0.0, 0.0, 0.0, 1.0, 1.0]) / TABLE**2
    information += np.eye(5)  # a radian: nothing is known of what no face has told
    covariance = np.linalg.inv(information)
    return float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1]))
