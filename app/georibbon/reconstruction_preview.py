"""What a reconstruction looks like while a smoothing moves, in a small part of its time.

From the last whole reconstruction with the same settings but for smoothing the
joint adjustment is followed to the new smoothing (`fitting.following`), and the
surface led along on the same triangles.  What neighbours say of each other, the
minimum that was chosen, standard deviations, the survey's residuals, verdicts,
checks and notices are those of the whole reconstruction: they belong to what is
kept, and are done anew by `reconstruct`.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration
from georibbon.fitting.following import follow, stand
from georibbon.fitting.grid import integrate_frames, integrate_positions
from georibbon.fitting.joint import Minimum, residuals_at
from georibbon.fitting.settings import check_settings
from georibbon.fitting.trimming import Curve, trimmed
from georibbon.geometry.frames import Strip
from georibbon.geometry.surface import rebuilt
from georibbon.reconstruction import (
    FittedPass,
    Reconstruction,
    ReconstructionSettings,
    Stages,
    Whole,
    reconstruct,
)
from georibbon.recording import Recording
from georibbon.threads import one_thread


def preview(
    recording: Recording,
    settings: ReconstructionSettings,
    calibration: Calibration | None,
    stages: Stages,
) -> Reconstruction:
    """About what `reconstruct` would give, where only smoothing changed since it was last done.

    stages: those of the last whole reconstruction.  Where anything but the
    smoothing is another, or a pass's smoothing is to be chosen by the evidence
    that was not, it is the whole reconstruction itself.  Nothing that
    `reconstruct` uses is changed.  Within what the readings support it differs
    from the whole by hundredths of a standard deviation; a smoothing that bends
    passes away from their readings is come nearer to call by call.

    Raises what `reconstruct` raises.
    """
    check_settings(settings, recording)
    whole = stages.latest("whole")
    if isinstance(whole, Whole) and _alike(whole, recording, settings, calibration):
        minimum, lengths = whole.fit.minimum, _lengths(whole, settings)
        if minimum is not None and lengths is not None:
            with one_thread(), suppress(np.linalg.LinAlgError):  # far beyond all readings
                return _led(whole, minimum, lengths, stages)
    return reconstruct(recording, settings, calibration, stages)


def _alike(
    whole: Whole,
    recording: Recording,
    settings: ReconstructionSettings,
    calibration: Calibration | None,
) -> bool:
    """Whether a whole reconstruction is that of the same but for smoothing."""
    return (
        whole.recording is recording
        and whole.calibration is calibration
        and replace(whole.settings, smoothing={}) == replace(settings, smoothing={})
    )


def _lengths(whole: Whole, settings: ReconstructionSettings) -> FloatArray | None:
    """(p,) metres, for the passes as fitted; None where the evidence would have to choose."""
    out = []
    for one, fitted in zip(whole.result.passes, whole.fit.lengths, strict=True):
        length = settings.smoothing_of(one.name)
        if length is None and whole.settings.smoothing_of(one.name) is not None:
            return None
        out.append(float(fitted) if length is None else length)
    return np.array(out)


def _led(whole: Whole, minimum: Minimum, lengths: FloatArray, stages: Stages) -> Reconstruction:
    """The whole reconstruction, its curves and surface led to other lengths of smoothing."""
    foothold = stages.get("foothold", (whole,), lambda: stand(minimum.problem, minimum.state))
    # The weight of the roughness goes with the sixth power of the length.
    smoothing = minimum.problem.smoothing * (lengths / whole.fit.lengths) ** 6
    state, foothold = follow(foothold, smoothing)
    stages.put("foothold", (whole,), foothold)
    problem = foothold.problem
    frames = integrate_frames(problem.grid, state.shape)
    points = integrate_positions(problem.grid, state.shape, frames) + state.origin[:, None]
    residuals = residuals_at(problem, state, frames)
    passes = tuple(
        _moved(whole, p, Strip(whole.fit.s, points[p], frames[p]), residuals[p], lengths[p])
        for p in range(len(lengths))
    )
    old, kinds = whole.result, [one.kind == "pass" for one in whole.result.passes]
    strips = [one.strip for one, yes in zip(passes, kinds, strict=True) if yes]
    return replace(
        old,
        heading=state.shared.heading,
        passes=passes,
        surface=None if old.surface is None else rebuilt(old.surface, strips),
    )


def _moved(whole: Whole, p: int, strip: Strip, residuals: FloatArray, length: float) -> FittedPass:
    """A pass with another curve, and residuals (sensors, 3) where it had any."""
    old, trim = whole.result.passes[p], whole.settings.trim_of(whole.result.passes[p].name)
    curve = Curve(strip, whole.fit.covariance[p], whole.fit.normal_sigma[p])
    return replace(
        old,
        strip=trimmed(curve, trim).strip,
        residuals=np.where(np.isnan(old.residuals), np.nan, residuals),
        smoothing=float(length),
    )
