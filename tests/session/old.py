"""What the published session file of version 1, data/version-1.georibbon, must give."""

from pathlib import Path

import numpy as np
from made import RIBBON

from georibbon.recording import Crossing, Distance, Mark, Pass, Pose, Recording, Workpiece
from georibbon.ribbon import Readings

VERSION_1 = Path(__file__).parent / "data" / "version-1.georibbon"


def _readings(frames, number, scale=1):
    """Frames by arithmetic alone, so that they are the same for ever; some values lost."""
    places = np.arange(frames * len(RIBBON.columns)).reshape(frames, -1) + 1000 * number
    counts = (places * 7919 % 40009 - 20004) * float(scale)
    counts[places % 97 == 5] = np.nan
    return Readings(np.arange(frames) * 0.01, counts)


def recording():
    """Two poses, two passes (one in several chunks, one of wide counts), a tie, a survey."""
    return Recording(
        RIBBON,
        (
            Pose("roll 0", 0.0, 0.0, 0.0, True, _readings(40, 1)),
            Pose("roll 90, steil", 90.0, 10.0, -40.0, False, _readings(41, 2)),
        ),
        (
            Pass("P1", "pass", _readings(2500, 3)),
            Pass("Ärmel 2", "pass", _readings(50, 4, scale=1000)),
            Pass("T1", "tie", _readings(1, 5)),
        ),
        (Mark("P1", 0.0, (0.1, -0.2, 0.3), 0.0005), Mark("T1", 0.5, (0.0, 0.25, -0.125), 0.002)),
        (Distance(("P1", "Ärmel 2"), (0.0, 0.5), 0.1, 0.0005),),
        (Crossing(("Ärmel 2", "T1"), (0.25, 0.05), 0.001),),
        Workpiece(True, 25.0),
        "a bonnet,\nmade with version 1",
    )
