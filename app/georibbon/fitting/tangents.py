"""The source paper's way: an orientation at every sensor, then a curve from its tangents.

Sprynski, Szafran, Lacolle and Biard, "Surface reconstruction via geodesic
interpolation" (Computer-Aided Design 40, 2008), section 5.1: each sensor site
gives one orientation, the tangents are interpolated on the sphere, and the
curve is their integral; the curves are then placed rigidly by the survey.
Nothing is fitted along the ribbon, so every site's noise stays in the curve.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Grid, integrate_frames
from georibbon.fitting.placing import Curves, Link, Placing
from georibbon.fitting.start import Starts, gravity_at
from georibbon.fitting.strip import StripProblem
from georibbon.geometry.settings import TangentRule
from georibbon.geometry.spherical import interpolate_frames
from georibbon.geometry.tangent_splines import SPLINES
from georibbon.rotations import about_z, log, to_up

_NEWTON_STEPS = 8
_LONGEST_TURN = np.radians(5.0)  # a step of the heading's search: the starts' ring is as coarse
_READING_SIGMA = 0.02  # g or field: interpolated gravity and the magnetometer's own noise


@dataclass(frozen=True, eq=False)
class Sites:
    """Where a pass has orientations: s (k,) metres and frames (k, 3, 3) in magnetic axes.

    misfit: sum over the magnetometers of the squared residual over 0.02.
    """

    s: FloatArray
    frames: FloatArray
    misfit: float


def site_orientations(problem: StripProblem, starts: Starts) -> list[Sites]:
    """Orientations at the sensors of one pass for each of its starts.

    At every magnetometer gravity, interpolated between the accelerometers,
    leaves one angle, which its reading gives; at an accelerometer outside the
    magnetometers the ribbon goes on without bending in its plane.
    """
    array, grid = problem.array, problem.grid
    frames = integrate_frames(grid, starts.shape)
    out = []
    for k, p in enumerate(starts.owner):
        present = problem.observations.present[p]
        magnetometers = np.flatnonzero(array.field & present)
        nodes = grid.sensor_nodes[magnetometers]
        nodes, first = np.unique(nodes, return_index=True)
        magnetometers = magnetometers[first]
        one = problem.take([int(p)])
        level = to_up(gravity_at(one, grid.nodes[nodes])[0])
        turned, misfit = _headings(one, magnetometers, level, frames[k, nodes])
        s, sites = _with_ends(one, present, grid.nodes[nodes], turned)
        out.append(Sites(s, sites, misfit))
    return out


def _headings(
    problem: StripProblem, magnetometers: IntArray, level: FloatArray, guess: FloatArray
) -> tuple[FloatArray, float]:
    """Frames (k, 3, 3) that fit each magnetometer best, by Gauss-Newton in the heading alone."""
    gain = problem.array.gain[magnetometers]
    values = problem.observations.values[0, magnetometers]
    field = problem.vectors[magnetometers[0]]
    across = np.array([field[1], -field[0], 0.0])
    about = guess @ np.swapaxes(level, 1, 2)
    heading = np.arctan2(about[:, 1, 0] - about[:, 0, 1], about[:, 0, 0] + about[:, 1, 1])
    for _ in range(_NEWTON_STEPS):
        frames = about_z(heading) @ level
        back = gain @ np.swapaxes(frames, 1, 2)
        residuals, slope = back @ field - values, back @ across
        step = -np.sum(residuals * slope, axis=1) / (np.sum(slope**2, axis=1) + 1e-3)
        heading = heading + np.clip(step, -_LONGEST_TURN, _LONGEST_TURN)
    frames = about_z(heading) @ level
    residuals = (gain @ np.swapaxes(frames, 1, 2)) @ field - values
    return frames, float(np.sum(residuals**2) / _READING_SIGMA**2)


def _with_ends(
    problem: StripProblem, present: FloatArray, s: FloatArray, frames: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The sites with those accelerometers added that lie outside the magnetometers."""
    accelerometers = np.flatnonzero(~problem.array.field & present.astype(bool))
    places = problem.grid.nodes[problem.grid.sensor_nodes[accelerometers]]
    level = to_up(gravity_at(problem, places)[0])
    for place, up in sorted(zip(places, level, strict=True), key=lambda pair: -pair[0]):
        if place < s[0]:
            s, frames = np.r_[place, s], np.concatenate([_onward(frames[0], up)[None], frames])
    for place, up in sorted(zip(places, level, strict=True), key=lambda pair: pair[0]):
        if place > s[-1]:
            s, frames = np.r_[s, place], np.concatenate([frames, _onward(frames[-1], up)[None]])
    return s, frames


def _onward(frame: FloatArray, level: FloatArray) -> FloatArray:
    """The frame above `level` (heading zero) that a step without in-plane bending leads to."""
    about = frame @ level.T
    ahead = np.arctan2(about[1, 0] - about[0, 1], about[0, 0] + about[1, 1])
    headings = ahead + np.radians(np.arange(-30.0, 30.5, 0.5))
    bends = log(frame.T @ about_z(headings) @ level)[:, 2]
    order = np.argsort(bends)
    best = np.interp(0.0, bends[order], headings[order])
    return np.asarray(about_z(best) @ level)


def curves_of(
    grid: Grid, sites: list[Sites], owner: IntArray, tangents: TangentRule = "unrolled"
) -> Curves:
    """The curves of all sites at the grid's nodes: interpolated tangents, integrated."""
    made = SPLINES[tangents]
    strips = [interpolate_frames(part.s, part.frames, grid.nodes, made) for part in sites]
    return Curves(
        grid.nodes,
        owner,
        np.array([part.misfit for part in sites]),
        np.array([strip.points for strip in strips]),
        np.array([strip.frames for strip in strips]),
    )


def orientation_sigma(problem: StripProblem) -> float:
    """Radians, of one site's orientation about an axis: tilt twice, heading once, as a mean.

    Tilt has the contact's noise; heading has it magnified by the field's dip.
    """
    noise = problem.noise
    field = problem.vectors[problem.array.field][0]
    level = max(float(np.hypot(field[0], field[1])), 0.1)
    heading = np.hypot(noise.contact, noise.field) / level
    return float(np.sqrt((2 * noise.contact**2 + heading**2) / 3))


def position_variances(
    curves: Curves, sites: list[Sites], links: list[Link], placing: Placing, sigma: float
) -> FloatArray:
    """(p, n + 1) m², of each coordinate of each point, linearised.

    An error of one site's tangent moves the rest of the curve by the integral
    of its share of the tangent; the survey's least squares then shift each
    curve as a whole.
    """
    drift = [_drift(curves.nodes, sites[int(candidate)].s) * sigma for candidate in placing.choice]
    sizes = np.cumsum([0] + [part.shape[1] for part in drift])
    at_links = np.zeros((len(links), sizes[-1]))
    for row, link in enumerate(links):
        _add_at(at_links[row], drift[link.i], sizes[link.i], curves.nodes, link.s, link.j is None)
        if link.j is not None:
            _add_at(at_links[row], drift[link.j], sizes[link.j], curves.nodes, link.t, True)
    shifts, of_links = placing.response(links)
    out = []
    for p, part in enumerate(drift):
        whole = np.tile(-shifts[p] @ at_links, (len(part), 1))
        whole[:, sizes[p] : sizes[p + 1]] += part
        out.append(np.sum(whole**2, axis=1) + of_links[p])
    return np.array(out)


def _add_at(
    row: FloatArray, drift: FloatArray, start: int, nodes: FloatArray, s: float, ahead: bool
) -> None:
    """Adds (or subtracts) a curve's drift at s to the row of one link."""
    k = int(np.argmin(np.abs(nodes - s)))
    row[start : start + drift.shape[1]] += drift[k] if ahead else -drift[k]


def _drift(nodes: FloatArray, s: FloatArray) -> FloatArray:
    """(n + 1, k) the integrals, from the start, of the k sites' hat functions."""
    hats = np.stack([np.interp(nodes, s, row) for row in np.eye(len(s))], axis=1)
    steps = 0.5 * (hats[1:] + hats[:-1]) * np.diff(nodes)[:, None]
    return np.concatenate([np.zeros((1, len(s))), np.cumsum(steps, axis=0)])
