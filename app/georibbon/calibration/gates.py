"""What a set of poses must give before it is accepted, and what is said of a weak one."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.labels import FACES, face_of
from georibbon.calibration.model import CalibrationQuality
from georibbon.calibration.poses import Attitudes, Block
from georibbon.calibration.quality import weakest_axis
from georibbon.errors import CalibrationError
from georibbon.notices import Notice

LEAST_POSES = 10
FULL_POSES = 12
LEAST_FACES = 3
ALL_FACES = 4
LEAST_COVERAGE = 0.2
# 1 mg is 0.06 degrees: far less than what the bar's bend leaves, so that only poses
# which leave a parameter all but free (2 mg and more) are refused for it.
WORST_ACCELEROMETER, WEAK_ACCELEROMETER = 1.2, 0.3
WORST_MAGNETOMETER, WEAK_MAGNETOMETER = 1.0, 0.7
# Degrees about the worst axis.  Four poses on the table with headings spread, 15 degrees
# carelessly, reach 0.10 to 0.165; four at one heading 0.2 to 2.
WORST_GAUGE = 0.17
# A dip whose sign is in doubt by less than this is not compared with the place's.
LEVEL_FIELD = np.radians(10.0)
MISSING = {
    "x": "lift one end of the bar by about 40°, then the other",
    "y": "lay the bar on its left and on its right edge",
    "z": "lay the bar with the upper face up and with it down",
}


def require_poses(number: int) -> None:
    """Raises CalibrationError for fewer poses than can do."""
    if number < LEAST_POSES:
        raise CalibrationError(
            f"{number} poses were found, at least {LEAST_POSES} are needed and 20 are planned; "
            "take the poses that are missing"
        )


def require_sensors(block: Block, kind: str) -> None:
    """Raises CalibrationError where no sensor of a kind is left."""
    if not block.names:
        raise CalibrationError(
            f"no {kind} of the ribbon gives readings that can be used, at least one is needed; "
            "check the ribbon's connection and its counts_per_unit"
        )


def require_faces(asked: Attitudes) -> None:
    """Raises CalibrationError for fewer than three of the bar's faces on the table."""
    missing = _missing_faces(asked)
    found = ALL_FACES - len(missing)
    if found < LEAST_FACES:
        raise CalibrationError(
            f"the bar lay on the table with {found} of its {ALL_FACES} faces, at least "
            f"{LEAST_FACES} are needed; lay it with {', with '.join(missing)}"
        )


def _missing_faces(asked: Attitudes) -> list[str]:
    """The faces, in words, that were never up while the bar lay on the table."""
    found = {face_of(roll) for roll in asked.roll[asked.table]}
    return [words for face, words in FACES.items() if face not in found]


def require_coverage(coverage: float, up: FloatArray) -> None:
    """Raises CalibrationError where "up" hardly varies along one of the bar's axes."""
    if coverage >= LEAST_COVERAGE:
        return
    weakest = weakest_axis(up)
    raise CalibrationError(
        f"the poses hardly differ along the ribbon's {weakest} axis (coverage "
        f"{coverage:.2f}, at least {LEAST_COVERAGE} is needed); {MISSING[weakest]}"
    )


def require_gauge(gauge: float) -> None:
    """Raises CalibrationError where the table's tilt cannot be told from the sensors'."""
    degrees = np.degrees(gauge)
    if degrees > WORST_GAUGE:
        raise CalibrationError(
            f"the rotation common to all sensors is known to {degrees:.2f}° only, "
            f"{WORST_GAUGE}° is needed, because the table's tilt cannot be told from it; lay the "
            "bar on all four faces and turn it end for end (heading 0 and 180) on the table"
        )


def require_parameters(accelerometer: float, magnetometer: float) -> None:
    """Raises CalibrationError where a sensor's parameters are not determined (A, B)."""
    if accelerometer > WORST_ACCELEROMETER:
        raise CalibrationError(
            f"the accelerometers are determined to {accelerometer:.2f} mg only for 0.1 mg of "
            f"noise, {WORST_ACCELEROMETER} mg is needed; take tilted poses with all four faces up"
        )
    if magnetometer > WORST_MAGNETOMETER:
        raise CalibrationError(
            f"the magnetometers are determined to {magnetometer:.2f} % of the field only for "
            f"0.5 % of noise, {WORST_MAGNETOMETER} % is needed; take more poses at other headings"
        )


def require_dip(dip: float, hemisphere: str | None) -> list[Notice]:
    """Compares the dip's sign with the place's; magnetometers all reversed show nowhere else.

    Raises CalibrationError where they differ; a notice where the field points
    up and the place is not known.
    """
    found = f"the field found points {'down' if dip > 0 else 'up'} by {abs(np.degrees(dip)):.0f}°"
    if hemisphere is None and dip < -LEVEL_FIELD:
        message = (
            f"{found}, as it does south of the magnetic equator only; if this place is north "
            "of it, all magnetometers are mounted reversed: correct their axes"
        )
        return [Notice("field-points-up", message)]
    expected = {"north": 1.0, "south": -1.0, None: np.sign(dip)}[hemisphere]
    if dip * expected < -LEVEL_FIELD:
        raise CalibrationError(
            f"{found}, and in the {hemisphere} it points {'down' if expected > 0 else 'up'}; the "
            "magnetometers are mounted reversed or the hemisphere is wrong: correct it"
        )
    return []


def weaknesses(quality: CalibrationQuality, asked: Attitudes) -> list[Notice]:
    """Notices for a calibration that is accepted and could be better."""
    notices = []
    if quality.poses < FULL_POSES:
        notices.append(
            Notice(
                "calibration-few-poses",
                f"{quality.poses} poses are enough for a first look only; take {FULL_POSES} "
                "or, better, the plan's 20 for the work",
            )
        )
    said = (
        (quality.accelerometer_mg, WEAK_ACCELEROMETER, "mg (A)"),
        (quality.magnetometer_percent, WEAK_MAGNETOMETER, "% of the field (B)"),
    )
    for value, limit, unit in said:
        if value > limit:
            notices.append(
                Notice(
                    "calibration-weak",
                    f"the poses determine the worst parameter to {value:.2f} {unit}, good is "
                    f"{limit} or less; take more poses, spread over faces, tilts and headings",
                )
            )
    missing = _missing_faces(asked)
    if missing:
        notices.append(
            Notice(
                "calibration-weak",
                f"no pose lay on the table with {' or '.join(missing)}; lay it so, all "
                f"{ALL_FACES} faces are needed to tell a common rotation",
            )
        )
    return notices
