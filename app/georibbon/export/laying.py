"""From curves of any origin to their surface: what `georibbon surface` does."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip
from georibbon.geometry.framing import Framed, FramingSettings, faced, faced_as, frame_curve
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.surface import Surface, build_surface
from georibbon.notices import Notice
from georibbon.reconstruction import FittedPass, Quality, Reconstruction
from georibbon.recording import PassKind
from georibbon.ribbon import Ribbon
from georibbon.session.curves_file import BareCurve
from georibbon.session.words import counted
from georibbon.threads import one_thread

LEAST_PASSES = 2
FARTHEST = 100.0  # m: what is larger was given in another unit


@dataclass(frozen=True, eq=False)
class LaidCurve:
    """A curve as it was laid: what it was, and its strip.

    sigma: (n,) metres, of its points, None where nobody said.
    """

    name: str
    kind: PassKind
    framed: Framed
    sigma: FloatArray | None

    @property
    def strip(self) -> Strip:
        """The curve with its frames."""
        return self.framed.strip


@dataclass(frozen=True, eq=False)
class Laid:
    """All curves as they were laid, the surface through the passes, and what is to be known.

    The surface runs through ties too where its settings have cells.
    """

    curves: tuple[LaidCurve, ...]
    surface: Surface
    notices: tuple[Notice, ...]


def lay(
    curves: Sequence[BareCurve],
    framing: FramingSettings,
    settings: SurfaceSettings,
    measured: bool = True,
) -> Laid:
    """The surface through curves.

    measured: whether to take the normals that curves have, or to find all.
    Raises SurfaceError, with the curve's name, where a curve or all of them do
    not determine it.
    """
    require_passes(curves)
    require_near(curves)
    with one_thread():
        laid = _faced([_framed(one, framing, measured) for one in curves])
        passes = [one for one in laid if one.kind == "pass"]
        sigmas = [one.sigma for one in passes if one.sigma is not None]
        surface = build_surface(
            [one.strip for one in passes],
            [one.name for one in passes],
            settings,
            sigmas if len(sigmas) == len(passes) else None,
            ties=[(one.name, one.strip) for one in laid if one.kind == "tie"],
        )
    unsure = [note for one in laid for note in _notices(one)]
    return Laid(laid, surface, (*_side(passes), *unsure))


def _faced(curves: list[LaidCurve]) -> tuple[LaidCurve, ...]:
    """The curves, those whose normals were found faced as the others are."""
    passes = [one for one in curves if one.kind == "pass"]
    strips = faced([one.strip for one in passes], [not one.framed.measured for one in passes])
    side = dict(zip((one.name for one in passes), strips, strict=True))
    for one in curves:
        if one.kind == "tie":
            side[one.name] = one.strip if one.framed.measured else faced_as(one.strip, strips)
    return tuple(replace(one, framed=replace(one.framed, strip=side[one.name])) for one in curves)


def _side(passes: Sequence[LaidCurve]) -> list[Notice]:
    """That the outer side was taken, not known, where no normal was measured."""
    if any(one.framed.measured for one in passes):
        return []
    message = (
        "no curve has measured normals, so which side is the outer one cannot be told; the side "
        "that faces up (z) was taken: it decides where --thickness goes"
    )
    return [Notice("side-taken", message)]


def require_passes(curves: Sequence[BareCurve]) -> None:
    """Raise SurfaceError unless there are curves enough to lay a surface through."""
    count = sum(one.kind == "pass" for one in curves)
    if count < LEAST_PASSES:
        raise SurfaceError(
            f"{count} of {counted(len(curves), 'curve')} is a pass, at least {LEAST_PASSES} are "
            "needed for a surface: name each curve in a column pass, or part them by blank lines"
        )


def require_near(curves: Sequence[BareCurve]) -> None:
    """Raise SurfaceError where curves are so large that their unit must be another."""
    points = np.concatenate([one.points for one in curves])
    size = float(np.ptp(points, axis=0).max())
    if size > FARTHEST:
        raise SurfaceError(
            f"the curves reach over {size:.0f} m, {FARTHEST:.0f} m at most are laid: say the unit "
            "of their numbers with --curves-unit, such as mm"
        )


def _framed(curve: BareCurve, framing: FramingSettings, measured: bool) -> LaidCurve:
    normals = curve.normals if measured else None
    try:
        framed = frame_curve(curve.points, curve.s, normals, framing)
    except SurfaceError as error:
        raise SurfaceError(f"{curve.name}: {error}") from error
    return LaidCurve(curve.name, curve.kind, framed, curve.sigma)


def _notices(curve: LaidCurve) -> list[Notice]:
    """What is uncertain about a curve's normals."""
    stretches = curve.framed.straight
    if not stretches:
        return []
    places = ", ".join(f"{1e3 * a:.0f} to {1e3 * b:.0f} mm" for a, b in stretches[:3])
    more = f" and {len(stretches) - 3} more" if len(stretches) > 3 else ""
    message = (
        f"the curve is too straight to tell its normals over {places}{more}; they turn "
        "smoothly there, which may be wrong: give measured normals (nx, ny, nz)"
    )
    return [Notice("normals-unsure", message, curve.name)]


def shown(laid: Laid) -> Reconstruction:
    """Curves and surface as a result to be looked at: without ribbon, calibration and residuals."""
    return Reconstruction(
        ribbon=Ribbon("", 0.0, 0.0, ()),
        method="ribbon",
        calibration=Calibration("", 0.0, ()),
        heading=0.0,
        heading_sigma=None,
        passes=tuple(_fitted(one) for one in laid.curves),
        survey=(),
        surface=laid.surface,
        notices=laid.notices,
    )


def _fitted(curve: LaidCurve) -> FittedPass:
    count = len(curve.strip.s)
    sigma = np.zeros(count) if curve.sigma is None else curve.sigma
    return FittedPass(
        name=curve.name,
        kind=curve.kind,
        strip=curve.strip,
        covariance=sigma[:, None, None] ** 2 / 3.0 * np.eye(3),
        normal_sigma=np.zeros(count),
        residuals=np.empty((0, 3)),
        residual_rms=0.0,
        smoothing=curve.framed.position_cut,
        sensors_ignored=(),
        quality=Quality("good", ""),
    )
