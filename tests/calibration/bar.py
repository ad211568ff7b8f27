"""A virtual bar: a ribbon of known sensors, turned through poses, with faults to order."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from georibbon.recording import Pose
from georibbon.ribbon import Readings, Ribbon, Sensor

ACCELEROMETER, FIELD = 16384.0, 2000.0
FACES = (0, 90, 180, 270)
ON_TABLE = [(0, 0), (0, 180), (0, 90), (0, 270), (90, 90), (90, 270), (180, 0), (180, 180)]
ON_TABLE += [(180, 90), (180, 270), (270, 90), (270, 270)]
TILTED = [(0, 0, 40), (0, 90, -40), (90, 0, -40), (90, 90, 40), (180, 0, 40), (180, 90, -40)]
TILTED += [(270, 0, -40), (270, 90, 40)]
TWENTY = [(r, h, 0, True) for r, h in ON_TABLE] + [(*t, False) for t in TILTED]
SIXTEEN = [(r, h, 0, True) for r in FACES for h in (0, 180)]
SIXTEEN += [(r, 90, p, False) for p in (40, -40) for r in FACES]
TWELVE = [(r, r, 0, True) for r in FACES]
TWELVE += [(r, (r + 90) % 360, 40, False) for r in FACES]
TWELVE += [(r, (r + 180) % 360, -40, False) for r in FACES]
ONE_HEADING = [(r, 0, p, p == 0) for p in (0, 40, -40) for r in FACES]
TABLE_ONLY = [(r, h, 0, True) for r in FACES for h in FACES]
TWO_FACES = [(r, h, p, p == 0) for r in (0, 180) for h in (0, 180) for p in (0, 40, -40)]


@dataclass
class Bar:
    """A bar to be turned; what is not said is perfect.

    sensors: their number, accelerometers and magnetometers by turns; axes: of
    the magnetometers; noise: 1 for a usual ribbon's, 0 for none; careless:
    degrees, standard deviation of headings, a fifth of it of tilts.
    field(pose, sensor, b) and counts(pose, sensor, y) bring faults in.
    """

    seed: int = 0
    sensors: int = 12
    axes: int = 2
    dip: float = np.radians(65.0)
    noise: float = 1.0
    careless: float = 10.0
    bend: float = 0.0
    frames: int = 40
    specific: object = None
    field: object = None
    counts: object = None

    def __post_init__(self):
        self.rng = np.random.default_rng(self.seed)
        self.ribbon = Ribbon(
            "GR-0042",
            0.03 * self.sensors,
            100.0,
            tuple(self._described(k) for k in range(self.sensors)),
        )
        self.truth = [self._sensor(sensor) for sensor in self.ribbon.sensors]
        self.bends = [self._turn(self.bend) for _ in self.truth]
        self.tilt = self._turn(0.5)

    def _described(self, k):
        number, position = f"{k // 2 + 1:02d}", 0.015 + 0.03 * k
        if k % 2 == 0:
            return Sensor("A" + number, "accelerometer", 3, position, ACCELEROMETER)
        return Sensor("M" + number, "magnetometer", self.axes, position, FIELD)

    def _turn(self, degrees):
        return Rotation.from_rotvec(np.radians(self.rng.normal(0, degrees, 3))).as_matrix()

    def _sensor(self, sensor):
        rng = self.rng
        if sensor.kind == "accelerometer":
            gain = np.eye(3) + rng.normal(0, 0.01, (3, 3)) + np.diag(rng.normal(0, 0.02, 3))
            bias = rng.normal(0, 0.03, 3)
        else:
            gain, bias = np.eye(3) + rng.normal(0, 0.1, (3, 3)), rng.normal(0, 0.3, 3)
        gain, unit = gain @ self._turn(2.0), sensor.counts_per_unit
        return gain[: sensor.axes] * unit, bias[: sensor.axes] * unit

    def attitude(self, roll, heading, pitch, table):
        """Where the bar really stood."""
        rng, tilt_care = self.rng, self.careless / 5.0
        heading = heading + 33.0 + rng.normal(0, self.careless)
        if table:
            turned = Rotation.from_euler("ZYX", [heading, 0, roll], degrees=True).as_matrix()
            return self.tilt @ turned
        slips = rng.normal(0, tilt_care, 2)
        angles = [heading, -(pitch + slips[0]), roll + slips[1]]
        return Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()

    def readings(self, place, attitude):
        """(frames, columns) counts in a pose."""
        up, b = np.array([0, 0, 1.0]), np.array([0, np.cos(self.dip), -np.sin(self.dip)])
        columns = []
        for k, sensor in enumerate(self.ribbon.sensors):
            frame = attitude @ self.bends[k]
            heavy = sensor.kind == "accelerometer"
            world, change = (up, self.specific) if heavy else (b, self.field)
            if change is not None:
                world = world + change(place, sensor)
            gain, bias = self.truth[k]
            y = np.repeat((gain @ (frame.T @ world) + bias)[None], self.frames, axis=0)
            spread = self.noise * sensor.counts_per_unit * (1e-3 if heavy else 5e-3)
            y = y + spread * self.rng.normal(size=y.shape)
            y = np.round(y) if self.noise else y
            columns.append(y if self.counts is None else self.counts(place, sensor, y))
        return np.concatenate(columns, axis=1)

    def poses(self, plan):
        """The poses of a plan of (roll, heading, pitch, on the table), degrees."""
        made = []
        for place, asked in enumerate(plan):
            counts = self.readings(place, self.attitude(*asked))
            roll, heading, pitch, table = asked
            readings = Readings(np.arange(self.frames) / 100.0, counts)
            name = f"roll {roll}, heading {heading}, pitch {pitch}"
            made.append(Pose(name, float(roll), float(heading), float(pitch), table, readings))
        return made


def relabelled(poses, changes):
    """The poses with labels changed: {place: {"roll": ...}}."""
    return [replace(pose, **changes.get(k, {})) for k, pose in enumerate(poses)]


def errors(calibration, bar):
    """Largest error of gains and biases of the used sensors, in units, accelerometers and field."""
    worst = {"accelerometer": 0.0, "magnetometer": 0.0}
    for model, sensor, (gain, bias) in zip(
        calibration.sensors, bar.ribbon.sensors, bar.truth, strict=True
    ):
        if model.used:
            off = max(np.abs(model.gain - gain).max(), np.abs(model.bias - bias).max())
            worst[sensor.kind] = max(worst[sensor.kind], off / sensor.counts_per_unit)
    return worst["accelerometer"], worst["magnetometer"]


def codes(calibration):
    """The notices' codes."""
    return {notice.code for notice in calibration.notices}


def told(calibration, code):
    """The notices of one code."""
    return [notice for notice in calibration.notices if notice.code == code]
