"""What the pictures show, prepared without a window: sessions and calibrations in a folder."""

import shutil
from collections.abc import Sequence
from pathlib import Path

from georibbon.calibration import calibrate
from georibbon.calibration.serial import to_dict
from georibbon.capture.plan import CapturePlan
from georibbon.capture.start import open_capture
from georibbon.device.identity import Identity
from georibbon.gui.connect.choice import POSES, VirtualChoice
from georibbon.recording import Recording
from georibbon.session.calibration_shelf import Shelf
from georibbon.session.file import create_session
from georibbon.session.outline import survey_tables
from georibbon.simulation import simulate
from georibbon.simulation.demonstration import demonstration_settings
from georibbon.simulation.settings import changed
from georibbon.virtual import VirtualSettings

# The poses that are taken of the calibration that was begun, from 0, and of the capture the passes.
BEGUN, LAID = (0, 1, 2, 3, 4, 5, 6, 7, 10, 12, 13, 14, 17, 18), 2
BONNET, NEXT, PART = "bonnet.georibbon", "bonnet, next day.georibbon", "left door.georibbon"
SHELF, SESSIONS = "calibrations", "sessions"


def virtual_settings() -> VirtualSettings:
    """The virtual ribbon as the page Connect offers it at first."""
    return VirtualChoice().settings()


def prepare(folder: Path) -> None:
    """Make everything in a new folder; nothing where it is there already."""
    if folder.exists():
        return
    made = folder.with_name(f"{folder.name}.making")
    shutil.rmtree(made, ignore_errors=True)
    (made / SHELF / SESSIONS).mkdir(parents=True)
    settings = demonstration_settings()
    create_session(made / BONNET, simulate(settings).recording)
    other = changed(settings, {"seed": settings.seed + 1, "faults.dead": ()})
    create_session(made / NEXT, simulate(other).recording)
    recording = simulate(virtual_settings().simulation).recording
    _keep_calibrations(made / SHELF, recording)
    for name, poses in (("begun", BEGUN), ("whole", range(POSES))):
        path = made / SHELF / SESSIONS / f"calibration {name}.georibbon"
        _capture(path, recording, CapturePlan(poses=POSES, passes=0), poses, 0)
    plan = CapturePlan(
        poses=POSES,
        ties=len([one for one in recording.passes if one.kind == "tie"]),
        title="left door",
        survey=survey_tables(recording.marks, recording.distances, recording.crossings),
    )
    _capture(made / PART, recording, plan, range(POSES), LAID)
    made.rename(folder)


def _keep_calibrations(folder: Path, recording: Recording) -> None:
    """Two, the older one of fewer poses."""
    shelf = Shelf(folder)
    older = [one for k, one in enumerate(recording.poses) if k % 5 != 4]
    shelf.keep(calibrate(recording.ribbon, older), "before the summer")
    shelf.keep(calibrate(recording.ribbon, recording.poses), "workshop, by the window")


def _capture(
    path: Path, recording: Recording, plan: CapturePlan, poses: Sequence[int], passes: int
) -> None:
    """A session in which so many poses and passes of a recording are taken already."""
    identity = Identity(recording.ribbon, "1.0.0")
    session, plan = open_capture(path, identity, plan)
    try:
        for k in poses:
            asked = plan.planned_poses[k]
            session.add_pose(
                asked.key, asked.name, asked.roll, asked.heading, asked.pitch, asked.table,
                recording.poses[k].readings,
            )  # fmt: skip
        if passes:
            document = to_dict(calibrate(recording.ribbon, recording.poses))
            session.do("calibration", document=document)
        for one in recording.passes[:passes]:
            session.add_pass(one.name, one.kind, one.readings)
    finally:
        session.close()
