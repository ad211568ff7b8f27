"""The calibration poses that are asked for."""

AskedPose = tuple[float, float, float, bool]
"""Roll, heading and pitch in degrees, and whether the bar lies on the table."""

FACES = (0.0, 90.0, 180.0, 270.0)


def _on_table(*pairs: tuple[float, float]) -> tuple[AskedPose, ...]:
    return tuple((roll, heading, 0.0, True) for roll, heading in pairs)


def _tilted(*poses: tuple[float, float, float]) -> tuple[AskedPose, ...]:
    return tuple((roll, heading, pitch, False) for roll, heading, pitch in poses)


PLANS: dict[int, tuple[AskedPose, ...]] = {
    12: (
        _on_table(*((roll, heading) for roll, heading in zip(FACES, FACES, strict=True)))
        + _tilted(*((roll, (roll + 90) % 360, 40.0) for roll in FACES))
        + _tilted(*((roll, (roll + 180) % 360, -40.0) for roll in FACES))
    ),
    16: (
        _on_table(*((roll, heading) for roll in FACES for heading in (0.0, 180.0)))
        + _tilted(*((roll, 90.0, pitch) for pitch in (40.0, -40.0) for roll in FACES))
    ),
    20: (
        _on_table((0, 0), (0, 180), (0, 90), (0, 270), (90, 90), (90, 270))
        + _on_table((180, 0), (180, 180), (180, 90), (180, 270), (270, 90), (270, 270))
        + _tilted((0, 0, 40), (0, 90, -40), (90, 0, -40), (90, 90, 40))
        + _tilted((180, 0, 40), (180, 90, -40), (270, 0, -40), (270, 90, 40))
    ),
}
"""The plans by their number of poses: (roll, heading, pitch) in degrees, and whether on the table.

12 is the least that is accepted, 16 good, 20 the best that hands can do
quickly; every plan shows all four faces up and turns the bar end for end.
"""
