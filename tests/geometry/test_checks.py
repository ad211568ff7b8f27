"""Every self-check finds what it is for, and leaves good surfaces alone."""

from collections.abc import Sequence

import numpy as np
import pytest

from georibbon.geometry.checks import Check, graded, pair_name
from georibbon.geometry.checks import seam as seam_check
from georibbon.geometry.frames import Strip
from georibbon.geometry.patch import PatchGrid
from georibbon.geometry.reference import Bonnet, Torus
from georibbon.geometry.surface import SurfaceSettings, build_surface
from passes import OFFSETS, moved, passes, plane_passes, sphere_passes, upside_down


def checks_of(strips: Sequence[Strip], **more: object) -> tuple[Check, ...]:
    names = [f"P{k + 1}" for k in range(len(strips))]
    return build_surface(strips, names, SurfaceSettings(5e-4), **more).checks


def found(checks: Sequence[Check], code: str) -> dict[str, Check]:
    return {check.where: check for check in checks if check.code == code}


def rolled(strip: Strip, degrees: np.ndarray) -> Strip:
    """The strip with its normals turned about its tangents."""
    cosine, sine = np.cos(np.radians(degrees))[:, None], np.sin(np.radians(degrees))[:, None]
    normals = cosine * strip.normals + sine * strip.conormals
    conormals = cosine * strip.conormals - sine * strip.normals
    return Strip(strip.s, strip.points, np.stack([strip.tangents, conormals, normals], axis=2))


@pytest.mark.parametrize("shape", ["sphere", "bonnet", "torus", "plane"])
def test_good_surfaces_pass_every_check(shape: str) -> None:
    strips = {
        "sphere": lambda: sphere_passes(shifts=[0.0, 0.02, 0.0, -0.02, 0.0]),
        "bonnet": lambda: passes(Bonnet(), [(0.0, y) for y in OFFSETS], [0.0, 0.05, 0.0, 0.0, 0.0]),
        "torus": lambda: passes(Torus(), [(0.0, v) for v in (-0.5, 0.0, 0.5)], length=0.5),
        "plane": lambda: plane_passes(*OFFSETS),
    }[shape]()
    checks = checks_of(strips)
    assert [check for check in checks if check.verdict != "pass"] == []
    assert {check.code for check in checks} == {
        "heading-drift", "facing", "seam", "fold", "tear", "directions", "pinch", "skew",
        "normal-turn", "gap", "overlap", "self-crossing",
    }  # fmt: skip
    assert all(np.isfinite(check.value) for check in checks)


def test_every_pass_and_every_pair_is_named_once_a_check() -> None:
    checks = checks_of(sphere_passes())
    assert set(found(checks, "heading-drift")) == {"P1", "P2", "P3", "P4", "P5"}
    assert set(found(checks, "seam")) == {"P2", "P3", "P4"}
    assert set(found(checks, "fold")) == {"P1-P2", "P2-P3", "P3-P4", "P4-P5"}
    assert len({(check.code, check.where) for check in checks}) == len(checks)


def test_pairs_are_named_from_the_lower_to_the_higher() -> None:
    assert pair_name("P10", "P9") == "P9-P10"
    assert pair_name("P1", "P2") == "P1-P2"


def test_geodesics_have_no_heading_drift() -> None:
    checks = found(checks_of(passes(Bonnet(), [(0.0, 0.1), (0.0, 0.2)])), "heading-drift")
    assert all(check.value < 1e-4 for check in checks.values())


def test_a_circle_of_latitude_drifts_by_its_geodesic_curvature() -> None:
    """kg = tan(latitude) / R: a parallel is no geodesic, a great circle is."""
    angle = np.linspace(-0.8, 0.8, 97)
    strips = []
    for latitude in (0.0, 0.2):
        normals = np.stack(
            [
                np.cos(latitude) * np.sin(angle),
                np.full_like(angle, np.sin(latitude)),
                np.cos(latitude) * np.cos(angle),
            ],
            axis=1,
        )
        tangents = np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1)
        frames = np.stack([tangents, np.cross(normals, tangents), normals], axis=2)
        s = 0.5 * np.cos(latitude) * (angle - angle[0])
        strips.append(Strip(s, 0.5 * normals, frames))
    drift = found(checks_of(strips), "heading-drift")
    assert drift["P1"].value < 1e-6
    assert drift["P2"].value == pytest.approx(np.degrees(1.6 * np.sin(0.2)), rel=1e-5)
    assert drift["P2"].verdict == "fail"
    assert "lay it flat again" in drift["P2"].message


@pytest.mark.parametrize(("sigma", "verdict"), [(0.2, "pass"), (0.15, "warn"), (0.09, "fail")])
def test_heading_drift_is_judged_by_its_expected_spread(sigma: float, verdict: str) -> None:
    """A normal rolled by delta has kg = kn tan(delta): here 0.96 m / 0.6 m at 0.5 degrees."""
    strips = sphere_passes([0.0, 0.1])
    wrong = rolled(strips[1], np.full(97, 0.5))
    spread = [np.full(97, np.radians(sigma))] * 2
    drift = found(checks_of([strips[0], wrong], frame_sigma=spread), "heading-drift")["P2"]
    assert drift.value == pytest.approx(0.96 / 0.6 * 0.5, rel=1e-3)
    assert drift.verdict == verdict
    assert drift.unit == "°"


def test_heading_drift_is_an_integral() -> None:
    strips = sphere_passes([0.0, 0.1])
    wrong = rolled(strips[1], np.linspace(0.0, 1.0, 97))
    drift = found(checks_of([strips[0], wrong]), "heading-drift")["P2"]
    assert drift.value == pytest.approx(0.96 / 0.6 * 0.5, rel=2e-4)
    assert drift.verdict == "pass"


def test_the_expected_spread_goes_with_its_pass() -> None:
    strips = sphere_passes([0.0, 0.1, 0.2])
    strips[2] = rolled(strips[2], np.full(97, 0.5))
    spread = [np.full(97, np.radians(value)) for value in (0.1, 0.1, 0.5)]
    mixed = checks_of([strips[k] for k in (2, 0, 1)], frame_sigma=[spread[k] for k in (2, 0, 1)])
    assert {check.verdict for check in found(mixed, "heading-drift").values()} == {"pass"}


def test_a_pass_upside_down_is_told() -> None:
    strips = sphere_passes()
    strips[1] = upside_down(strips[1])
    checks = found(checks_of(strips), "facing")
    assert checks["P2"].verdict == "warn"
    assert "upside down" in checks["P2"].message
    assert all(check.verdict == "pass" for where, check in checks.items() if where != "P2")


def test_normals_that_disagree_at_a_seam_are_a_fault() -> None:
    along = np.tile([1.0, 0.0, 0.0], (2, 4, 2, 1))
    across = np.tile([0.0, 1.0, 0.0], (2, 4, 2, 1))
    tilt = np.radians(0.5)
    across[1] = [0.0, np.cos(tilt), np.sin(tilt)]
    grid = PatchGrid(along, along, across, np.tile([0.0, 0.0, 1.0], (2, 4, 2, 1)))
    check = seam_check(grid, 0, "P2")
    assert check.verdict == "warn"
    assert check.value == pytest.approx(0.5)
    assert "crease" in check.message


def test_a_pass_laid_far_out_of_place_folds_the_surface() -> None:
    """Its points sit beyond the next pass's, its order by distance notwithstanding."""
    strips = plane_passes(0.0, 0.1)
    crossing = passes_crossing(0.3)
    checks = checks_of([strips[0], crossing])
    fold, cross = found(checks, "fold")["P1-P2"], found(checks, "crossing")["P1-P2"]
    assert fold.verdict == "fail"
    assert fold.value == pytest.approx(-1.0, abs=0.05)
    assert "folds over" in fold.message
    assert cross.verdict == "fail"
    assert "tie" in cross.message


def passes_crossing(angle: float) -> Strip:
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    return moved(plane_passes(0.0)[0], turn, np.zeros(3))


def test_passes_far_out_of_step_are_close_to_folding_and_oblique() -> None:
    checks = checks_of(plane_passes(0.0, 0.1, shifts=[0.0, 0.6]))
    fold, skew = found(checks, "fold")["P1-P2"], found(checks, "skew")["P1-P2"]
    assert fold.verdict == "warn"
    assert "close to folding" in fold.message
    assert skew.verdict == "warn"
    assert "level with each other" in skew.message
    overlap = found(checks, "overlap")["P1-P2"]
    assert overlap.verdict == "warn"
    assert overlap.value == pytest.approx(0.36 / 0.96)
    assert "level with each other" in overlap.message


def test_passes_that_share_nothing_are_told_to_be_matched_by_shares() -> None:
    overlap = found(checks_of(plane_passes(0.0, 0.1, shifts=[0.0, 1.2])), "overlap")["P1-P2"]
    assert overlap.verdict == "warn"
    assert "equal shares" in overlap.message


def test_a_sudden_turn_of_the_normals_tears_the_surface() -> None:
    strips = sphere_passes([0.0, 0.4])
    jump = 60.0 * np.tanh((strips[1].s - 0.48) / 0.004)
    tear = found(checks_of([strips[0], rolled(strips[1], jump)]), "tear")["P1-P2"]
    assert tear.verdict != "pass"
    assert "tears" in tear.message


def test_directions_that_turn_suddenly_are_told() -> None:
    strips = sphere_passes([0.0, 0.1])
    jump = np.where(strips[1].s > 0.481, 120.0, 0.0)
    spoilt = [strips[0], rolled(strips[1], jump)]
    conormal = build_surface(spoilt, ["P1", "P2"], SurfaceSettings(direction="conormal"))
    check = found(conormal.checks, "directions")["P1-P2"]
    assert check.verdict == "fail"
    assert check.value > 90.0
    assert "safe chord" in check.message
    whole = found(checks_of(strips), "directions")["P1-P2"]
    assert whole.verdict == "pass"
    assert whole.value < 1.0


def test_passes_that_nearly_touch_are_told() -> None:
    pinch = found(checks_of(plane_passes(0.0, 0.003, 0.1)), "pinch")
    assert pinch["P1-P2"].verdict == "warn"
    assert pinch["P1-P2"].value == pytest.approx(3.0)
    assert pinch["P1-P2"].unit == "mm"
    assert pinch["P2-P3"].verdict == "pass"


def test_a_strong_turn_between_passes_asks_for_one_more() -> None:
    strips = passes(Torus(0.5, 0.1), [(0.0, -0.6), (0.0, 0.6)], length=0.3)
    turn = found(checks_of(strips), "normal-turn")["P1-P2"]
    assert turn.verdict == "warn"
    assert turn.value == pytest.approx(np.degrees(1.2), abs=8.0)
    assert "lay a pass in between" in turn.message


def test_a_missing_pass_is_noticed_by_its_gap() -> None:
    gaps = found(checks_of(plane_passes(0.0, 0.1, 0.2, 0.5, 0.6)), "gap")
    assert gaps["P3-P4"].verdict == "warn"
    assert gaps["P3-P4"].value == pytest.approx(3.0)
    assert "a pass may be missing" in gaps["P3-P4"].message
    assert gaps["P1-P2"].verdict == "pass"


@pytest.mark.parametrize(("value", "verdict"), [(1.0, "pass"), (2.5, "warn"), (3.5, "fail")])
def test_verdicts_are_graded(value: float, verdict: str) -> None:
    assert graded(value, 2.0, 3.0) == verdict
