"""The surface through the passes: geodesic Hermite patches between neighbours."""

from dataclasses import dataclass
from typing import Literal

from georibbon.geometry.mesh import Mesh


@dataclass(frozen=True)
class Check:
    """One self-check of the built surface.

    code: a stable word, such as "fold", "gap", "normal-turn", "heading-drift";
    verdict: "pass", "warn" or "fail"; value: what was found, in `unit`;
    message: the sentence for the person, with advice where it is not a pass.
    where: which pass or pair of passes, such as "P2" or "P2-P3".
    """

    code: str
    verdict: Literal["pass", "warn", "fail"]
    value: float
    unit: str
    where: str
    message: str


@dataclass(frozen=True, eq=False)
class Surface:
    """The built surface: its mesh, its area (m²) and its checks."""

    mesh: Mesh
    area: float
    checks: tuple[Check, ...]
