"""How poses stand, without a window: cards, refusals, the bar as it lies, its picture."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from virtual_desk import virtual

from georibbon.calibration.check import CHECK_POSES
from georibbon.calibration.directions import attitude
from georibbon.calibration.plans import PLANS
from georibbon.capture.checklist import Item
from georibbon.capture.ledger import Happening
from georibbon.capture.plan import CapturePlan
from georibbon.gui.calibrating import bar_geometry
from georibbon.gui.calibrating.bar_geometry import bar_picture, project, sees
from georibbon.gui.calibrating.state import (
    CHECK_KEYS,
    Progress,
    cards,
    done,
    face_words,
    grade,
    lying,
    named_poses,
    next_open,
    share_still,
    with_keys,
)
from georibbon.notices import Notice

POSES = CapturePlan(poses=20, passes=2).planned_poses
ANGLES = st.floats(-180.0, 180.0)


def items(taken=(), skipped=()):
    def status(key):
        return "taken" if key in taken else "skipped" if key in skipped else "open"

    return tuple(Item(one.key, one.words, one, status(one.key)) for one in POSES)


def states(found):
    return {card.key: card.state for card in found if card.state != "open"}


def test_the_state_needs_no_window():
    code = (
        "import sys\nimport georibbon.gui.calibrating.state, georibbon.gui.calibrating.bar_geometry"
        "\nassert not [m for m in sys.modules if m.startswith('PySide6')], sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_checks_poses_are_those_that_are_asked():
    asked = {pose.key: pose for pose in POSES}
    found = [asked[key] for key in CHECK_KEYS]
    assert tuple((p.roll, p.heading, p.pitch, p.table) for p in found) == CHECK_POSES


def test_cards_stand_as_the_capture_does():
    all_items = items(taken=("pose-01", "pose-02"), skipped=("pose-03",))
    progress = Progress(poor={"pose-02": "a magnet was near"})
    found = cards(all_items, all_items[3], progress)
    assert states(found) == {
        "pose-01": "good",
        "pose-02": "poor",
        "pose-03": "skipped",
        "pose-04": "asked",
    }
    assert found[1].reason == "a magnet was near"
    assert [card.number for card in found] == list(range(1, 21))
    assert done(found) == 2


def test_a_taken_pose_that_is_asked_again_stays_taken_until_it_is():
    all_items = items(taken=("pose-01",))
    assert cards(all_items, all_items[0], Progress())[0].state == "good"


def test_a_refusal_stands_until_something_else_is_done():
    progress, all_items = Progress(), items()
    progress.take(Happening("refused", "pose-01", "it moves"))
    card = cards(all_items, all_items[0], progress)[0]
    assert (card.state, card.reason) == ("refused", "it moves")
    assert states(cards(all_items, all_items[1], progress)) == {"pose-02": "asked"}
    progress.take(Happening("quality", None, "so far"))
    assert progress.refused == {"pose-01": "it moves"}
    progress.take(Happening("taken", "pose-01", "it is taken"))
    assert progress.refused == {}
    progress.take(Happening("refused", None, "nothing is asked for"))
    assert progress.refused == {}


def test_a_pose_that_is_taken_again_is_no_longer_poor():
    progress = Progress(poor={"pose-01": "x", "pose-02": "y"})
    progress.take(Happening("taken", "pose-01", "it is taken"))
    assert progress.poor == {"pose-02": "y"}


def test_the_check_shows_its_poses_alone_and_goes_from_one_to_the_next():
    all_items = items(taken=(CHECK_KEYS[0],))
    found = cards(all_items, None, Progress(), CHECK_KEYS)
    assert [card.key for card in found] == list(CHECK_KEYS)
    assert [card.number for card in found] == [1, 2, 3]
    assert next_open(found, None) == CHECK_KEYS[1]
    assert next_open(found, CHECK_KEYS[1]) == CHECK_KEYS[2]
    assert next_open(found, CHECK_KEYS[2]) == CHECK_KEYS[1]
    whole = cards(items(taken=CHECK_KEYS), None, Progress(), CHECK_KEYS)
    assert next_open(whole, None) is None


def test_what_a_calibration_says_of_a_pose_is_on_its_card():
    name = POSES[4].name
    progress = Progress()
    told = Notice("pose-disturbed", f"pose 2 ({name!r}) disagrees; take this pose again")
    progress.judge(POSES, [told, Notice("sensor-dead", "sensor A01 is dead", sensor="A01")])
    assert progress.poor == {"pose-05": "pose-05 disagrees; take this pose again"}
    progress.judge(POSES, [])
    assert progress.poor == {}


def test_poses_are_found_in_sentences_by_their_whole_name():
    keys = {"roll 0, heading 0, pitch 4": "a", "roll 0, heading 0, pitch 40": "b"}
    said = "pose 'roll 0, heading 0, pitch 40' lost the values; pose 3 ('other') stands"
    assert named_poses(said, keys) == ["b"]
    assert with_keys(said, keys) == "b lost the values; pose 3 ('other') stands"


@given(st.floats(0.0, 100.0))
def test_the_ring_fills_with_the_seconds_and_no_further(seconds):
    share = share_still(seconds)
    assert 0.0 <= share <= 1.0
    assert (share == 1.0) == (seconds >= 1.0)


@pytest.mark.parametrize(("value", "expected"), [(0.5, "good"), (0.6, "fair"), (1.1, "poor")])
def test_figures_are_graded(value, expected):
    assert grade(value, (0.5, 1.0)) == expected


def test_faces_are_told_by_the_nearest():
    assert [face_words(replace(POSES[0], roll=roll)) for roll in (3.0, 92.0, 178.0, -90.0)] == [
        "top",
        "left",
        "under",
        "right",
    ]


@pytest.fixture(scope="module")
def ribbon():
    return virtual()


class TestLying:
    """The bar as it lies, by a virtual ribbon on its bar."""

    def frames(self, ribbon, word):
        ribbon.do(word)
        ribbon.frames(200)
        return ribbon.frames(20)

    @pytest.mark.parametrize("number", [1, 5, 7, 11, 13, 16])
    def test_in_a_pose_it_matches_that_pose(self, ribbon, number):
        found = lying(ribbon.ribbon, self.frames(ribbon, f"pose {number}"), POSES[number - 1])
        assert found.matches
        assert found.bent < 6.0
        assert found.lifted == (not POSES[number - 1].table)
        turned = found.attitude(POSES[number - 1].heading)
        asked = attitude(PLANS[20][number - 1])
        assert np.degrees(np.arccos((turned[2] * asked[2]).sum())) < 12.0

    def test_in_another_it_does_not(self, ribbon):
        found = lying(ribbon.ribbon, self.frames(ribbon, "pose 7"), POSES[0])
        assert not found.matches
        assert found.off == pytest.approx(180.0, abs=8.0)

    def test_without_a_pose_asked_it_lies_all_the_same(self, ribbon):
        found = lying(ribbon.ribbon, self.frames(ribbon, "pose 1"), None)
        assert found.up[2] > 0.98

    def test_a_silent_ribbon_lies_nowhere(self, ribbon):
        assert lying(ribbon.ribbon, [], POSES[0]) is None
        frames = [
            type(one)(one.t, np.full_like(one.counts, -32768), one.arrived)
            for one in self.frames(ribbon, "pose 1")
        ]
        assert lying(ribbon.ribbon, frames, POSES[0]) is None


class TestPicture:
    """The bar's picture: laws of a solid thing on a table."""

    @given(ANGLES, ANGLES, st.floats(-80.0, 80.0))
    def test_three_faces_at_most_are_seen_and_never_two_opposite(self, roll, heading, pitch):
        picture = bar_picture(attitude((roll, heading, pitch, False)), True)
        names = {face.name for face in picture.bar}
        assert 1 <= len(picture.bar) <= 3
        for pair in ({"top", "under"}, {"left", "right"}, {"start", "end"}):
            assert not pair <= names

    @given(ANGLES, ANGLES, st.floats(-80.0, 80.0))
    def test_faces_that_are_seen_turn_one_way(self, roll, heading, pitch):
        """Seen from outside, each face's corners go round clockwise in the picture (y down)."""
        picture = bar_picture(attitude((roll, heading, pitch, False)), True)
        for face in (*picture.bar, *picture.block):
            x, y = face.corners.T
            area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
            assert area > -1e-9
            assert 0.0 <= face.shade <= 1.0

    def test_what_lies_up_is_seen_and_what_lies_down_is_not(self):
        for roll, name in ((0, "top"), (90, "left"), (180, "under"), (270, "right")):
            for heading in (0, 90, 180, 270):
                picture = bar_picture(attitude((roll, heading, 0.0, True)), False)
                assert name in {face.name for face in picture.bar}
                assert picture.block == ()

    def test_the_end_is_right_at_no_heading_and_behind_at_a_quarter(self):
        right = bar_picture(attitude((0.0, 0.0, 0.0, True)), False).heading[1]
        behind = bar_picture(attitude((0.0, 90.0, 0.0, True)), False).heading[1]
        assert right[0] > 0.9
        assert behind[1] < right[1]
        assert "start" in {f.name for f in bar_picture(attitude((0.0, 90.0, 0.0, True)), False).bar}

    def test_a_lifted_end_has_its_block_under_it(self):
        for pitch in (40.0, -40.0):
            picture = bar_picture(attitude((0.0, 0.0, pitch, False)), True)
            middle = np.mean([face.corners.mean(axis=0) for face in picture.block], axis=0)
            assert np.sign(middle[0]) == np.sign(pitch)
        assert bar_picture(attitude((0.0, 0.0, 0.5, False)), True).block == ()

    def test_upright_it_points_nowhere(self):
        picture = bar_picture(attitude((0.0, 0.0, 90.0, False)), True)
        np.testing.assert_allclose(picture.heading[0], picture.heading[1])

    @given(st.floats(0.1, 5.0))
    def test_what_is_nearer_looks_larger(self, step):
        toward = bar_geometry._camera()[2]
        ends = np.array([[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]])
        near, far = project(ends + step * toward), project(ends - step * toward)
        assert np.ptp(near[:, 0]) > np.ptp(far[:, 0])

    def test_a_face_is_seen_from_its_own_side_alone(self):
        toward = bar_geometry._camera()[2]
        assert sees(toward, np.zeros(3))
        assert not sees(-toward, np.zeros(3))
