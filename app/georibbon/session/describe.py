"""What a recording holds, in figures and in words."""

from typing import TypedDict

import numpy as np

from georibbon.recording import Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.session.words import counted


class FrameFacts(TypedDict):
    """The frames of one pose or pass: their number, seconds, and values lost among them."""

    frames: int
    seconds: float
    lost_values: int


class PoseFacts(FrameFacts):
    """A pose: its attitude in degrees, and its frames."""

    name: str
    roll: float
    heading: float
    pitch: float
    table: bool


class PassFacts(FrameFacts):
    """A pass or tie, and its frames."""

    name: str
    kind: str


class SensorFacts(TypedDict):
    """A sensor, as in `recording.toml`."""

    name: str
    kind: str
    axes: int
    position: float
    counts_per_unit: float


class RibbonFacts(TypedDict):
    """The ribbon (metres, frames per second) and how many sensors of each kind it has."""

    id: str
    length: float
    rate: float
    accelerometers: int
    magnetometers: int
    magnetometer_axes: list[int]
    sensors: list[SensorFacts]


class WorkpieceFacts(TypedDict):
    """The frame of the marks; heading in degrees, None where it is unknown."""

    level: bool
    heading: float | None


class SurveyFacts(TypedDict):
    """The number of observations of each kind."""

    marks: int
    distances: int
    crossings: int


class Facts(TypedDict):
    """What `georibbon info` tells; every value is one that JSON has."""

    title: str | None
    ribbon: RibbonFacts | None
    poses: list[PoseFacts]
    passes: list[PassFacts]
    survey: SurveyFacts
    workpiece: WorkpieceFacts | None


def describe(recording: Recording) -> Facts:
    """The facts of a recording, lengths in metres, angles in degrees, times in seconds."""
    piece = recording.workpiece
    return {
        "title": recording.title,
        "ribbon": _ribbon(recording.ribbon),
        "poses": [
            {
                "name": pose.name,
                "roll": pose.roll,
                "heading": pose.heading,
                "pitch": pose.pitch,
                "table": pose.table,
                **_frames(pose.readings),
            }
            for pose in recording.poses
        ],
        "passes": [
            {"name": run.name, "kind": run.kind, **_frames(run.readings)}
            for run in recording.passes
        ],
        "survey": {
            "marks": len(recording.marks),
            "distances": len(recording.distances),
            "crossings": len(recording.crossings),
        },
        "workpiece": None if piece is None else {"level": piece.level, "heading": piece.heading},
    }


def describe_text(facts: Facts) -> str:
    """The facts as lines for a person."""
    survey = facts["survey"]
    observations = (
        counted(survey["marks"], "mark"),
        counted(survey["distances"], "distance"),
        counted(survey["crossings"], "crossing"),
    )
    lines = [] if facts["title"] is None else [facts["title"]]
    ribbon = facts["ribbon"]
    lines.append("no ribbon yet" if ribbon is None else _ribbon_line(ribbon))
    lines.append(f"survey: {', '.join(observations)}; {_placed(facts['workpiece'])}")
    lines.append(counted(len(facts["poses"]), "calibration pose"))
    width = max((len(pose["name"]) for pose in facts["poses"]), default=0)
    lines += [f"  {pose['name']:<{width}}  {_frames_line(pose)}" for pose in facts["poses"]]
    ties = sum(run["kind"] == "tie" for run in facts["passes"])
    passes = counted(len(facts["passes"]) - ties, "pass", "passes")
    lines.append(f"{passes}, {counted(ties, 'tie')}")
    width = max((len(run["name"]) for run in facts["passes"]), default=0)
    lines += [
        f"  {run['name']:<{width}}  {run['kind']:<4}  {_frames_line(run)}"
        for run in facts["passes"]
    ]
    return "\n".join(lines)


def _ribbon(ribbon: Ribbon) -> RibbonFacts:
    magnetometers = ribbon.indices("magnetometer")
    return {
        "id": ribbon.id,
        "length": ribbon.length,
        "rate": ribbon.rate,
        "accelerometers": len(ribbon.indices("accelerometer")),
        "magnetometers": len(magnetometers),
        "magnetometer_axes": sorted({ribbon.sensors[i].axes for i in magnetometers}),
        "sensors": [
            {
                "name": sensor.name,
                "kind": sensor.kind,
                "axes": sensor.axes,
                "position": sensor.position,
                "counts_per_unit": sensor.counts_per_unit,
            }
            for sensor in ribbon.sensors
        ],
    }


def _frames(readings: Readings) -> FrameFacts:
    return {
        "frames": readings.t.size,
        "seconds": float(readings.t[-1] - readings.t[0]),
        "lost_values": int(np.isnan(readings.counts).sum()),
    }


def _ribbon_line(ribbon: RibbonFacts) -> str:
    axes = " and ".join(map(str, ribbon["magnetometer_axes"]))
    return (
        f"ribbon {ribbon['id']}: {ribbon['length']:g} m, {ribbon['rate']:g} frames/s, "
        f"{counted(ribbon['accelerometers'], 'accelerometer')}, "
        f"{counted(ribbon['magnetometers'], 'magnetometer')} of {axes} axes"
    )


def _frames_line(facts: FrameFacts) -> str:
    lost = f", {counted(facts['lost_values'], 'value')} lost" if facts["lost_values"] else ""
    return f"{counted(facts['frames'], 'frame')} in {facts['seconds']:.2f} s{lost}"


def _placed(workpiece: WorkpieceFacts | None) -> str:
    if workpiece is None:
        return "no workpiece frame"
    heading = workpiece["heading"]
    known = "heading unknown" if heading is None else f"heading {heading:g} degrees"
    return f"workpiece level, {known}"
