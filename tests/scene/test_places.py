"""Where the survey is drawn: on the curves, and nowhere where a pass is cut off."""

from dataclasses import replace

import numpy as np
import pytest

import synthetic
from georibbon.geometry.frames import Strip, interpolated
from georibbon.reconstruction import SurveyResidual
from georibbon.scene.places import survey_places

WHOLE = synthetic.reconstruction()
FIRST, SECOND = WHOLE.passes[:2]
LENGTH = float(FIRST.strip.s[-1])


def of(kind, passes, at):
    return SurveyResidual(kind, passes, at, 0.001, 0.001, 1.0)


SURVEY = (
    of("mark", (FIRST.name,), (0.0,)),
    of("mark", (FIRST.name,), (0.5 * LENGTH,)),
    of("crossing", (FIRST.name, SECOND.name), (0.5 * LENGTH, 0.4 * LENGTH)),
    of("distance", (FIRST.name, SECOND.name), (0.0, 0.0)),
)


def cut(fitted, share):
    """A pass without some of its points at either end."""
    strip, k = fitted.strip, round(share * len(fitted.strip.s))
    kept = slice(k, len(strip.s) - k)
    return replace(
        fitted,
        strip=Strip(strip.s[kept], strip.points[kept], strip.frames[kept]),
        covariance=fitted.covariance[kept],
        normal_sigma=fitted.normal_sigma[kept],
    )


def test_marks_and_crossings_are_on_the_curves():
    found = survey_places(replace(WHOLE, survey=SURVEY))
    start, middle = interpolated(np.array([0.0, 0.5 * LENGTH]), FIRST.strip.s, FIRST.strip.points)
    assert found.points[:2] == pytest.approx(np.array([start, middle]))
    assert len(found.points) == 3
    assert (len(found.gaps), len(found.spans)) == (1, 1)


def test_what_lies_on_an_end_that_was_cut_off_is_not_drawn():
    passes = (cut(FIRST, 0.2), *WHOLE.passes[1:])
    found = survey_places(replace(WHOLE, passes=passes, survey=SURVEY))
    whole = survey_places(replace(WHOLE, survey=SURVEY[1:3]))
    assert found.points == pytest.approx(whole.points)
    assert (len(found.gaps), len(found.spans)) == (1, 0)
