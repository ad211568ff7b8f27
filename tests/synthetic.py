"""A made-up result to export and to show: five arcs and a tie on a bonnet-like surface."""

import numpy as np

from georibbon.calibration.model import Calibration, CalibrationQuality, SensorModel
from georibbon.geometry.frames import Strip
from georibbon.geometry.mesh import Mesh
from georibbon.geometry.surface import Check, Surface
from georibbon.notices import Notice
from georibbon.reconstruction import FittedPass, Quality, Reconstruction, SurveyResidual
from georibbon.ribbon import Ribbon, Sensor

LENGTH, HALF_WIDTH, PAIRS = 0.96, 0.3, 16
POINTS = 97


def height(x, y):
    """A bonnet: domed along and across, with two soft ribs."""
    ribs = 0.012 * np.exp(-(((np.abs(y) - 0.17) / 0.05) ** 2))
    return 0.10 - 0.22 * (x - 0.35) ** 2 - 0.45 * y**2 + ribs * (1.1 - x)


def normal(x, y, step=1e-6):
    """(n, 3) unit normals of the graph, upwards."""
    slope_x = (height(x + step, y) - height(x - step, y)) / (2 * step)
    slope_y = (height(x, y + step) - height(x, y - step)) / (2 * step)
    n = np.stack((-slope_x, -slope_y, np.ones_like(x)), axis=-1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def point(x, y):
    """(n, 3) points of the graph."""
    return np.stack((x, y, height(x, y)), axis=-1)


def sigma_at(x, y):
    """Metres: small at the marked ends, larger in the middle and outwards."""
    along = np.sin(np.pi * np.clip(x / LENGTH, 0, 1)) ** 2
    return 1e-3 * (0.35 + 0.45 * along + 0.8 * np.abs(y))


def strip_over(x, y):
    """The strip over a polyline of the plane."""
    points, n = point(x, y), normal(x, y)
    tangent = np.gradient(points, axis=0)
    tangent -= np.sum(tangent * n, axis=1, keepdims=True) * n
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    return Strip(s, points, np.stack((tangent, np.cross(n, tangent), n), axis=-1))


def ribbon():
    """A ribbon of 16 accelerometers and 16 two-axis magnetometers."""
    places = 0.015 + 0.03 * np.arange(2 * PAIRS)
    sensors = [
        Sensor(f"A{i // 2 + 1:02d}", "accelerometer", 3, float(place), 16384.0)
        if i % 2 == 0
        else Sensor(f"M{i // 2 + 1:02d}", "magnetometer", 2, float(place), 2000.0)
        for i, place in enumerate(places)
    ]
    return Ribbon("GR-0011", LENGTH, 100.0, tuple(sensors))


def calibration(of):
    """A calibration with one dead magnetometer."""
    models = tuple(
        SensorModel(
            sensor.name,
            sensor.counts_per_unit * np.eye(3)[: sensor.axes],
            np.zeros(sensor.axes),
            used=sensor.name != "M04",
            reason="it never changed in 16 poses" if sensor.name == "M04" else "",
        )
        for sensor in of.sensors
    )
    quality = CalibrationQuality(16, 0.11, 0.19, 0.08, 0.6, 0.31, 0.82, 0.21, 0.24)
    return Calibration(of.id, 1.152, models, quality)


def fitted(name, kind, strip, seed, quality):
    """One fitted pass with residuals drawn from a seed."""
    of, rng = ribbon(), np.random.default_rng(seed)
    sigma = sigma_at(strip.points[:, 0], strip.points[:, 1])
    share = np.array([0.2, 0.3, 0.5])
    covariance = sigma[:, None, None] ** 2 * np.diag(share)
    residuals = rng.normal(size=(len(of.sensors), 3))
    for i, sensor in enumerate(of.sensors):
        residuals[i, sensor.axes :] = np.nan
        if sensor.name == "M04":
            residuals[i] = np.nan
    return FittedPass(
        name=name,
        kind=kind,
        strip=strip,
        covariance=covariance,
        normal_sigma=np.full(len(strip.s), np.radians(0.2)),
        residuals=residuals,
        residual_rms=float(np.sqrt(np.nanmean(residuals**2))),
        smoothing=0.09,
        sensors_ignored=("M04",),
        quality=quality,
    )


def passes():
    """Five passes and a tie."""
    good = Quality("good", "residuals and uncertainty are as expected")
    fair = Quality("acceptable", "position uncertainty reaches 1.0 mm in the middle")
    x = np.linspace(0, LENGTH * 0.97, POINTS)
    result = []
    for i, y0 in enumerate(np.linspace(-HALF_WIDTH, HALF_WIDTH, 5)):
        y = y0 * (1 + 0.05 * np.sin(np.pi * x / LENGTH))
        result.append(fitted(f"P{i + 1}", "pass", strip_over(x, y), i, fair if i == 4 else good))
    y = np.linspace(-HALF_WIDTH * 1.05, HALF_WIDTH * 1.05, POINTS)
    result.append(fitted("T1", "tie", strip_over(np.full(POINTS, 0.47), y), 9, good))
    return tuple(result)


def mesh(columns=97, rows=61):
    """The surface's mesh between the outer passes."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(-1, 1, rows))
    x = (u * LENGTH * 0.97).ravel()
    y = (v.ravel() * HALF_WIDTH) * (1 + 0.05 * np.sin(np.pi * x / LENGTH))
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    lower = np.stack((a, b, c), axis=-1).reshape(-1, 3)
    upper = np.stack((a, c, d), axis=-1).reshape(-1, 3)
    return Mesh(point(x, y), np.vstack((lower, upper)), normal(x, y), sigma_at(x, y))


def survey(of):
    """Marks at both ends of every pass and one crossing of the tie with each."""
    rng = np.random.default_rng(5)
    result = []
    for p in of[:5]:
        for at in (0.0, float(p.strip.s[-1])):
            residual = float(abs(rng.normal()) * 4e-4)
            result.append(SurveyResidual("mark", (p.name,), (at,), residual, 5e-4, residual / 5e-4))
    for i, p in enumerate(of[:5]):
        residual = float(abs(rng.normal()) * 8e-4)
        at = (0.47, 0.02 + 0.15 * i)
        result.append(
            SurveyResidual("crossing", (p.name, "T1"), at, residual, 1e-3, residual / 1e-3)
        )
    return tuple(result)


def surface():
    """The surface with checks of each verdict but "fail"."""
    checks = (
        Check("fold", "pass", 0.0, "triangles", "P1-P2", "no triangle is folded over"),
        Check("gap", "pass", 0.02, "mm", "P2-P3", "the patches meet"),
        Check(
            "heading-drift",
            "warn",
            1.4,
            "°",
            "P5",
            "the pass bends sideways on its own surface; lay it again without pulling",
        ),
    )
    return Surface(mesh(), 0.561, checks)


def reconstruction(with_surface=True):
    """The whole result."""
    of, laid = ribbon(), passes()
    notices = (
        Notice("sensor-dead", "M04 never changed; it is left out of every fit", None, "M04"),
        Notice("field-disturbed", "the field is disturbed near M08 on P5; move steel away", "P5"),
        Notice("heading-assumed", "the workpiece's heading was solved for"),
    )
    return Reconstruction(
        of,
        "ribbon",
        calibration(of),
        np.radians(25.0),
        np.radians(0.2),
        laid,
        survey(laid),
        surface() if with_surface else None,
        notices,
    )
