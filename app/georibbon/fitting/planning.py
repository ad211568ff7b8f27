"""How a survey is used: the heading, what must be assumed, on which side neighbours lie."""

from dataclasses import dataclass

import numpy as np

from georibbon.errors import FitError
from georibbon.fitting import equations
from georibbon.fitting.equations import Pair, Survey
from georibbon.fitting.placing import Curves, Link, Placing, best_placings
from georibbon.notices import Notice
from georibbon.recording import Recording

HEADING_TOLD = float(np.radians(5.0))  # a heading less sure than this is not told by the survey
HEADING_MISTAKE = float(np.radians(4.0))  # rooms bend the field by 2 to 4 degrees
KNOWN_HEADING_SIGMA = float(np.radians(0.5))
# Rigid placings are rough: those this near the best are worth a full adjustment, but no more of
# them than this.
TRY_WITHIN = 60.0
MOST_TRIED = 6
FREE = 1e3  # radians or metres: no prior at all
FIXED = 1e-6


@dataclass(frozen=True, eq=False)
class Plan:
    """The survey with what is assumed beside it.

    heading: radians, of the field in the workpiece frame, None where the marks
    tell it; heading_sigma: its prior.  assumed: pairs taken to lie across from
    each other.  sides: +1 (left) and -1 to be tried for loose pairs.
    """

    survey: Survey
    heading: float | None
    heading_sigma: float
    assumed: tuple[Pair, ...]
    sides: tuple[float, ...]
    notices: tuple[Notice, ...]

    def links(self, side: float) -> list[Link]:
        """The links for the rigid placing."""
        return equations.links(self.survey, self.assumed, side)

    def placings(self, curves: Curves, side: float) -> list[Placing]:
        """The rigid placings on one side that are worth an adjustment, best first."""
        return best_placings(curves, self.links(side), self.heading, TRY_WITHIN)[:MOST_TRIED]


def make_plan(recording: Recording, curves: Curves) -> Plan:
    """What the survey tells of the heading decides what must be assumed.

    Raises `FitError` where the survey does not hold the passes together.
    """
    survey = equations.read_survey(recording)
    heading, sigma = _known_heading(recording, survey)
    assumed: tuple[Pair, ...] = ()
    notices: list[Notice] = []
    if survey.marked:
        told = best_placings(curves, equations.links(survey, (), 1.0), None, TRY_WITHIN)[0]
        if heading is None and told.heading_sigma > HEADING_TOLD:
            assumed = equations.square_pairs(survey)
            notices.append(_heading_notice(bool(assumed)))
            if not assumed:
                _require_no_heading(survey)
                heading, sigma = 0.0, FIXED
        elif heading is not None and _disagree(heading, told):
            notices.append(_disagreement_notice(heading, told.heading))
            heading, sigma = None, FREE
    if survey.loose:
        notices.append(_across_notice(recording, survey.loose))
    sides = (1.0, -1.0) if survey.loose or assumed else (1.0,)
    return Plan(survey, heading, sigma, assumed, sides, tuple(notices))


def _require_no_heading(survey: Survey) -> None:
    """Where marks alone hold the passes, an unknown heading would tear them apart."""
    if not equations.holds_itself(survey):
        raise FitError(
            "the marks do not tell the workpiece's heading: they touch each pass at one place "
            "only, and neighbouring passes at different ones; mark a second point of one pass, or "
            "give the heading under [workpiece]"
        )


def _disagree(heading: float, told: Placing) -> bool:
    """Whether the marks tell another heading than the person, by more than either may err."""
    away = abs((told.heading - heading + np.pi) % (2 * np.pi) - np.pi)
    return bool(away > 4 * np.hypot(told.heading_sigma, HEADING_MISTAKE / 4))


def _disagreement_notice(given: float, found: float) -> Notice:
    return Notice(
        "heading-disagrees",
        f"the recording says that the workpiece's heading is {np.degrees(given):.1f} degrees, the "
        f"marks and the field say {np.degrees(found):.1f}; the marks are believed: correct the "
        "heading under [workpiece], or the marks",
    )


def _known_heading(recording: Recording, survey: Survey) -> tuple[float | None, float]:
    """The heading and its prior: told by the person, by the marks (None), or the gauge."""
    workpiece = recording.workpiece
    given = None if workpiece is None else workpiece.heading
    if not survey.marked:
        return (0.0 if given is None else float(np.radians(given))), FIXED
    if given is None:
        return None, FREE
    return float(np.radians(given)), KNOWN_HEADING_SIGMA


def _heading_notice(square: bool) -> Notice:
    what = (
        "the line of marked points is taken as square to the passes"
        if square
        else "the workpiece's axes are taken as magnetic east and north"
    )
    return Notice(
        "heading-assumed",
        f"the survey does not tell the workpiece's heading, so {what}; mark a second point of "
        "one pass, or give the heading under [workpiece]",
    )


def _across_notice(recording: Recording, pairs: tuple[Pair, ...]) -> Notice:
    names = [one.name for one in recording.passes]
    which = ", ".join(dict.fromkeys(f"{names[pair.i]}-{names[pair.j]}" for pair in pairs))
    return Notice(
        "across-assumed",
        f"only distances hold {which}: the points they were measured between are taken to lie "
        f"across from each other (to {1e3 * equations.ACROSS_SIGMA:.0f} mm), the second pass to "
        "the left of the first where the readings don't tell; marks or a tie pass would settle it",
    )
