"""``georibbon calibrate``."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser
from georibbon.cli.outputs import Outputs
from georibbon.cli.printing import print_notices
from georibbon.export.files import require_ending

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration, CalibrationQuality

DESCRIPTION = """\
Calibrate a ribbon from the poses of a recording, and keep the result in a file.

The poses are the ribbon held still on a straight, square, non-magnetic bar, its faces
by turns up, at several headings and pitches; 16 poses of a good plan are enough.  A
recording with poses is calibrated by itself when it is reconstructed: the file is for
recordings of the same ribbon that have none.

Printed are the expected errors in degrees: of each sensor's tilt and heading, and of
the rotation that all sensors share."""

EPILOG = """\
examples:
  georibbon calibrate part-30 -o ribbon-7.json
  georibbon reconstruct part-31 --calibration ribbon-7.json --surface part-31.stl"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "recording", metavar="RECORDING", type=Path, help="recording folder or .georibbon session"
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help="the calibration (.json)"
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Calibrate, write the file, tell how good it is."""
    from georibbon.calibration import calibrate
    from georibbon.session.calibration_file import write_calibration
    from georibbon.session.source import load_source
    from georibbon.threads import one_thread

    require_ending(arguments.output, (".json",), "a calibration")
    with Outputs([arguments.output], inputs=[arguments.recording]) as outputs:
        recording = load_source(arguments.recording, complete=False)
        with one_thread():
            calibration = calibrate(recording.ribbon, recording.poses)
        write_calibration(calibration, outputs.place(arguments.output))
    _print(calibration)
    print(f"written: {arguments.output}")


def _print(calibration: "Calibration") -> None:
    used = sum(model.used for model in calibration.sensors)
    print(
        f"ribbon {calibration.ribbon_id}: {used} of {len(calibration.sensors)} sensors calibrated"
    )
    if calibration.quality is not None:
        _print_quality(calibration.quality)
    print_notices(calibration.notices)


def _print_quality(quality: "CalibrationQuality") -> None:
    print(f"  from {quality.poses} poses, coverage {quality.coverage:.2f} (1 is even, 0 is flat)")
    print("  expected errors:")
    print(f"    tilt of a sensor       {quality.tilt:6.2f} degrees")
    print(f"    heading of a sensor    {quality.heading:6.2f} degrees")
    print(f"    common to all sensors  {quality.gauge:6.2f} degrees")
    print(
        f"  residuals: {quality.accelerometer_residual_mg:.2f} mg,"
        f" {quality.magnetometer_residual_percent:.2f} % of the field"
    )
