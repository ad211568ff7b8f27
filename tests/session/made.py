"""Made-up recordings: one by hand, and all that the format can hold, for hypothesis."""

import dataclasses

import numpy as np
from hypothesis import strategies as st

from georibbon.recording import Crossing, Distance, Mark, Pass, Pose, Recording, Workpiece
from georibbon.ribbon import Readings, Ribbon, Sensor

RIBBON = Ribbon(
    "GR-0001",
    0.5,
    100.0,
    (
        Sensor("A01", "accelerometer", 3, 0.1, 16384.0),
        Sensor("M01", "magnetometer", 2, 0.2, 2000.0),
        Sensor("M02", "magnetometer", 3, 0.4, 2000.0),
    ),
)


def readings(frames=4, seed=0, ribbon=RIBBON):
    """Frames of random counts, one of them lost where there are several."""
    random = np.random.default_rng(seed)
    counts = random.integers(-20000, 20000, (frames, len(ribbon.columns))).astype(float)
    if frames > 1:
        counts[1, 2] = np.nan
    return Readings(np.arange(frames) / ribbon.rate, counts)


def recording():
    """Two poses, two passes, a tie and one observation of each kind."""
    return Recording(
        RIBBON,
        (
            Pose("roll 0", 0.0, 0.0, 0.0, True, readings(seed=1)),
            Pose("roll 90", 90.0, 10.0, -40.0, False, readings(seed=2)),
        ),
        (
            Pass("P1", "pass", readings(seed=3)),
            Pass("P2", "pass", readings(seed=4)),
            Pass("T1", "tie", readings(seed=5, frames=1)),
        ),
        (Mark("P1", 0.0, (0.1, -0.2, 0.3), 0.0005),),
        (Distance(("P1", "P2"), (0.0, 0.5), 0.1, 0.0005),),
        (Crossing(("P2", "T1"), (0.25, 0.05), 0.001),),
        Workpiece(True, 25.0),
        "by hand",
    )


def same(one, other):
    """Whether two recordings, or parts of them, are the same to the last bit."""
    if isinstance(one, Readings):
        return np.array_equal(one.t, other.t) and np.array_equal(
            one.counts, other.counts, equal_nan=True
        )
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return type(one) is type(other) and all(
            same(getattr(one, name), getattr(other, name)) for name in names
        )
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return type(one) is type(other) and one == other


NUMBERS = st.floats(-1e9, 1e9)
POSITIVE = st.floats(1e-9, 1e9)
NAMES = st.one_of(
    st.sampled_from(["../x", "CON", "con", "P1", "p1", "P 1", 'say "P"', "\\", "Ärmel", "..", "/"]),
    st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1, max_size=8),
).filter(str.isprintable)
COUNTS = st.one_of(
    st.just(np.nan), st.integers(-40000, 40000), st.integers(-(2**31) + 1, 2**31 - 1)
)


@st.composite
def sensors(draw):
    """An accelerometer, a magnetometer, and perhaps more."""
    kinds = ["accelerometer", "magnetometer", *draw(st.lists(st.just("magnetometer"), max_size=2))]
    axes = [3 if kind == "accelerometer" else draw(st.sampled_from([2, 3])) for kind in kinds]
    places = [draw(st.floats(0.0, 0.5)) for _ in kinds]
    return tuple(
        Sensor(f"Ä{i}", kind, n, place, draw(POSITIVE))
        for i, (kind, n, place) in enumerate(zip(kinds, axes, places, strict=True))
    )


@st.composite
def frames(draw, columns):
    """Readings with any counts, some lost, at any times that grow."""
    t = sorted(draw(st.lists(NUMBERS, min_size=1, max_size=4, unique_by=float)))
    rows = [draw(st.lists(COUNTS, min_size=columns, max_size=columns)) for _ in t]
    return Readings(np.array(t) + 0.0, np.array(rows, dtype=float))


def _possible(pose):
    """A bar on the table has hardly any pitch."""
    return dataclasses.replace(pose, table=pose.table and abs(pose.pitch) <= 10)


@st.composite
def recordings(draw):
    """Any recording that the format can hold."""
    ribbon = Ribbon(draw(NAMES), 0.5, draw(POSITIVE), draw(sensors()))
    some = frames(len(ribbon.columns))
    names = draw(st.lists(NAMES, min_size=2, max_size=5, unique=True))
    kinds = ["pass", "pass", *(draw(st.sampled_from(["pass", "tie"])) for _ in names[2:])]
    pose = st.builds(Pose, NAMES, NUMBERS, NUMBERS, NUMBERS, st.booleans(), some).map(_possible)
    along = st.floats(0.0, 0.5)
    name = st.sampled_from(names)
    pair = st.tuples(st.just(names[0]), st.sampled_from(names[1:]))
    points = st.tuples(along, along)
    position = st.tuples(NUMBERS, NUMBERS, NUMBERS)
    title = st.text(st.characters(exclude_categories=["C", "Z"], include_characters='\n\t "\\'))
    return Recording(
        ribbon,
        tuple(draw(st.lists(pose, max_size=2))),
        tuple(Pass(n, kind, draw(some)) for n, kind in zip(names, kinds, strict=True)),
        tuple(draw(st.lists(st.builds(Mark, name, along, position, POSITIVE), max_size=3))),
        tuple(draw(st.lists(st.builds(Distance, pair, points, POSITIVE, POSITIVE), max_size=3))),
        tuple(draw(st.lists(st.builds(Crossing, pair, points, POSITIVE), max_size=3))),
        draw(st.none() | st.builds(Workpiece, st.just(True), st.none() | st.floats(-360.0, 360.0))),
        draw(st.none() | title),
    )
