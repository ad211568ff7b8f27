"""What a person must be told of a result: nothing is dropped or assumed silently."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Notice:
    """One thing to know about a result.

    code: a stable word for programs, such as "sensor-dead"; message: the
    sentence for the person, with what was found and what to do.
    """

    code: str
    message: str
    pass_name: str | None = None
    sensor: str | None = None
