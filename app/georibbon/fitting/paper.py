"""The source paper's way for all passes of a capture: tangents, curves, rigid placing."""

from dataclasses import replace

import numpy as np

from georibbon.fitting.capture import Capture
from georibbon.fitting.placing import AMBIGUOUS_WITHIN
from georibbon.fitting.planning import make_plan
from georibbon.fitting.result import PassesFit
from georibbon.fitting.start import find_starts
from georibbon.fitting.strip import whitened_residuals
from georibbon.fitting.tangents import (
    curves_of,
    orientation_sigma,
    position_variances,
    site_orientations,
)
from georibbon.geometry.settings import TangentRule
from georibbon.rotations import about_z


def fit_paper(capture: Capture, tangents: TangentRule = "unrolled") -> PassesFit:
    """All passes the source paper's way: from tangents, placed rigidly by the survey.

    tangents: how they are interpolated between the sensors.  Raises `FitError`
    where the survey does not hold the passes together.
    """
    starts = find_starts(capture.problem)
    sites = site_orientations(capture.problem, starts)
    curves = curves_of(capture.grid, sites, starts.owner, tangents)
    plan = make_plan(capture.recording, curves)
    placings = [(plan.placings(curves, side)[0], side) for side in plan.sides]
    placing, side = placings[0]
    for other, its_side in placings[1:]:
        if other.cost < placing.cost - AMBIGUOUS_WITHIN:
            placing, side = other, its_side
    sigma = orientation_sigma(capture.problem)
    variances = position_variances(curves, sites, plan.links(side), placing, sigma)
    back = about_z(-placing.heading)
    points = curves.points[placing.choice] @ back.T + placing.origins[:, None]
    frames = back @ curves.frames[placing.choice]
    return PassesFit(
        s=capture.grid.nodes,
        points=points,
        frames=frames,
        covariance=variances[..., None, None] * np.eye(3),
        normal_sigma=np.full(points.shape[:2], sigma),
        residuals=whitened_residuals(
            replace(capture.problem, noise=replace(capture.problem.noise, contact=sigma)),
            curves.frames[placing.choice],
        ),
        present=capture.observations.present,
        lengths=np.zeros(len(points)),
        ambiguous=(False,) * len(points),
        heading=placing.heading,
        heading_sigma=placing.heading_sigma if plan.heading is None else None,
        notices=plan.notices,
    )
