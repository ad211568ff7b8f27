"""Cells that ties close between passes, and the surface that runs through them."""

from functools import cache

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.cells import with_cells
from georibbon.geometry.checks import pair_name
from georibbon.geometry.closest import closest_point
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.edges import edge_of
from georibbon.geometry.frames import Strip, arc_angles, dot, frames_from, unit
from georibbon.geometry.meetings import meeting
from georibbon.geometry.mesh import is_watertight
from georibbon.geometry.patch import lifted, patch_grid, patches_at, patches_between
from georibbon.geometry.reference import Torus
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.surface import build_surface, rebuilt
from georibbon.rotations import exp
from passes import cut, moved, passes, plane_passes, upside_down

TORUS = Torus()
NAMES = ("P1", "P2", "P3")
CELLS = SurfaceSettings(cells=True)
V = np.linspace(0.0, 1.0, 33)


@cache
def laid():
    """Three passes around the outside of a torus and three ties, no two quite alike."""
    places = [(0.0, 0.35), (0.02, 0.9), (0.0, 1.45)]
    strips = passes(TORUS, places, [0.0, 0.03, -0.02], length=0.6, count=61)
    across = [(-0.25, 0.9), (0.01, 0.9), (0.3, 0.9)]
    ties = passes(TORUS, across, [1.45, 1.6, 1.65], length=0.5, count=51)
    return tuple(strips), tuple(zip(("T1", "T2", "T3"), ties, strict=True))


def spoilt(ties, seed=3):
    """The ties a millimetre away and rolled and turned by about a degree, each its own way."""
    random = np.random.default_rng(seed)
    out = []
    for name, tie in ties:
        bend = 0.01 * np.sin(7.0 * tie.s)[:, None] * tie.tangents
        turns = exp(bend + np.radians(random.normal(0.0, 0.7, 3)))
        shift = random.normal(0.0, 5e-4, 3)
        frames = turns @ tie.frames
        points = tie.points + shift
        tangents = unit(np.gradient(points, tie.s, axis=0))
        out.append((name, Strip(tie.s, points, frames_from(tangents, frames[:, :, 2]))))
    return tuple(out)


def modelled(ties, strips=None):
    """The model with cells, and what was found."""
    model = patches_between(arrange(strips or laid()[0]), CELLS)
    names = [NAMES[i] for i in model.arrangement.order]
    return with_cells(model, names, ties)


def grid_at(model, i, u, v):
    """The i-th patch with what ties add, at u (k,) and v (m,)."""
    sample = patches_at(model, u)
    normals = sample.rails.frames[i : i + 2, ..., 2]
    return lifted(patch_grid(sample.control[i], sample.slope[i], normals, v), sample, i, v)


def along_tie(model, i, t, v):
    """The i-th patch where its t-th tie runs, at v (m,): points, along and normals."""
    first, last = model.cells.lifts[i].crossings[t]
    grid = grid_at(model, i, first + (last - first) * v, v)
    at = np.arange(len(v)), np.arange(len(v))
    return grid.points[at], grid.along[at], grid.normals[at]


def distance(points, strip):
    """(n,) how far points lie from a strip, and its normals there."""
    edge = edge_of(strip)
    s = strip.s[np.argmin(np.sum((points[:, None] - strip.points) ** 2, axis=2), axis=1)]
    for _ in range(8):
        here = edge.at(s)
        s = s + dot(points - here.points, here.slopes)
    here = edge.at(s)
    return np.linalg.norm(points - here.points, axis=1), here.normals


def test_the_surface_runs_through_true_ties_with_their_normals():
    _, ties = laid()
    model, found = modelled(ties)
    assert {one.verdict for one in found} == {"pass"}
    assert [one.value for one in found if one.code == "cells"] == [2.0, 2.0]
    places = [one.where for one in found if one.code.startswith("corner")]
    assert len(places) == 6
    assert set(places) <= {pair_name(name, tie) for name in NAMES for tie, _ in ties}
    for i in range(2):
        for t, (_, tie) in enumerate(ties):
            for v, limit in ((V, 1e-9), (V[:-1] + 0.011, 1e-8)):
                points, along, normals = along_tie(model, i, t, v)
                apart, measured = distance(points, tie)
                assert apart.max() < limit
                assert np.degrees(arc_angles(normals, measured)).max() < 1e-3
                assert np.abs(dot(along, normals)).max() < 1e-5


def test_passes_and_their_normals_stay_as_they_are_whatever_ties_say():
    strips, ties = laid()
    model, found = modelled(spoilt(ties))
    assert [one.value for one in found if one.code == "cells"] == [2.0, 2.0]
    u = np.linspace(*model.match.ends[model.match.middle], 57)
    ends = np.array([0.0, 1.0])
    plain = patches_at(patches_between(arrange(strips), CELLS), u)
    for i in range(2):
        grid = grid_at(model, i, u, ends)
        moved_by = grid_at(model, i, u, np.array([0.5])).points[:, 0] - 0.5 * (
            plain.rails.points[i] + plain.rails.points[i + 1]
        )
        assert np.ptp(np.linalg.norm(moved_by, axis=1)) > 1e-4  # the ties do say something
        for k in (0, 1):
            np.testing.assert_allclose(grid.points[:, k], plain.rails.points[i + k], atol=1e-12)
            upright = unit(np.cross(grid.along[:, k], grid.across[:, k]))
            normals = plain.rails.frames[i + k, ..., 2]
            assert np.degrees(arc_angles(upright, normals)).max() < 1e-5


def test_ties_that_miss_are_brought_onto_the_passes_a_little():
    strips, ties = laid()
    off = spoilt(ties)
    model, found = modelled(off)
    snap = float(found[0].message.split("by ")[1].split(" mm")[0])
    for i in range(2):
        for t, (_, tie) in enumerate(off):
            points, _, normals = along_tie(model, i, t, V)
            apart, measured = distance(points, tie)
            assert 1e3 * apart.max() < 3.0
            # Between the passes a tie is hardly moved further than at the passes.
            assert apart.max() < 1.3 * max(apart[0], apart[-1])
            assert np.degrees(arc_angles(normals, measured)).max() < 5.0
            assert np.degrees(arc_angles(normals[[0, -1]], measured[[0, -1]])).max() > 0.1
    misses = [meeting(edge_of(tie), edge_of(one)).miss for _, tie in off for one in strips]
    assert snap == pytest.approx(1e3 * max(misses), abs=0.006)


def test_the_surface_is_smooth_across_ties():
    _, ties = laid()
    model, _ = modelled(spoilt(ties))
    for i in range(2):
        for t in range(3):
            first, last = model.cells.lifts[i].crossings[t]
            for v in (0.0, 0.3, 1.0):
                at = first + (last - first) * v
                grid = grid_at(model, i, np.array([at - 1e-8, at + 1e-8]), np.array([v]))
                for of in (grid.points, grid.along, grid.across):
                    np.testing.assert_allclose(of[0], of[1], atol=1e-6)


def test_what_is_added_has_the_derivatives_it_says():
    model, _ = modelled(spoilt(laid()[1]))
    lift = model.cells.lifts[0]
    u, v = np.linspace(0.013, 0.57, 23), np.linspace(0.1, 0.9, 7)
    step = 1e-6
    here = lift.at(u, v)
    by_u = (lift.at(u + step, v).points - lift.at(u - step, v).points) / (2 * step)
    by_v = (lift.at(u, v + step).points - lift.at(u, v - step).points) / (2 * step)
    np.testing.assert_allclose(here.along, by_u, atol=1e-8)
    np.testing.assert_allclose(here.across, by_v, atol=1e-8)
    assert np.abs(here.along).max() > 1e-3
    ends = lift.at(u, np.array([0.0, 1.0]))
    for of in ends:
        assert np.abs(of).max() < 1e-15
    bends = lift.bends(u, v)
    more, less = lift.at(u + 1e-5, v), lift.at(u - 1e-5, v)
    np.testing.assert_allclose(bends[1], (more.across - less.across) / 2e-5, atol=1e-4)


@pytest.mark.parametrize("change", [lambda ties: ties, spoilt])
def test_what_is_added_does_not_depend_on_how_finely_it_is_tabulated(change, monkeypatch):
    """It runs out on the passes by itself, without a jump of its slope that nodes would show."""
    ties, v, parts = change(laid()[1]), (np.arange(32) + 0.5) / 32, []
    for nodes in (33, 129):
        monkeypatch.setattr("georibbon.geometry.cells.NODES", nodes)
        parts.append([lift.parts(v) for lift in modelled(ties)[0].cells.lifts])
    for coarse, fine in zip(*parts, strict=True):
        assert np.abs(fine).max() > 1e-4
        np.testing.assert_allclose(coarse, fine, atol=1e-6)


def test_between_ties_cells_come_much_closer_to_the_truth_than_strips_alone():
    strips, ties = laid()
    lifts = modelled(ties)[0].cells.lifts
    first = max(lift.crossings[0].max() for lift in lifts)
    last = min(lift.crossings[-1].min() for lift in lifts)
    distances, turns = [], []
    for settings in (SurfaceSettings(), CELLS):
        surface = build_surface(strips, NAMES, settings, ties=ties)
        nodes = surface.plan.nodes
        between = np.repeat((nodes >= first) & (nodes <= last), surface.shape[1])
        found = closest_point(TORUS, surface.mesh.vertices[between])
        distances.append(np.sqrt(np.mean(found.distance**2)))
        angles = arc_angles(TORUS.normals(found.uv), surface.mesh.normals[between])
        turns.append(np.sqrt(np.mean(angles**2)))
    assert distances[1] < 0.2 * distances[0]
    assert turns[1] < 0.2 * turns[0]


def test_the_skin_and_the_solid_are_whole():
    strips, ties = laid()
    settings = SurfaceSettings(cells=True, thickness=0.002)
    surface = build_surface(strips, NAMES, settings, ties=spoilt(ties))
    assert is_watertight(surface.solid)
    seams = [one for one in surface.checks if one.code == "seam"]
    assert seams
    assert max(one.value for one in seams) < 1e-4
    assert {one.verdict for one in surface.checks if one.code in ("fold", "tear")} == {"pass"}
    rows, columns = surface.shape
    assert len(surface.mesh.vertices) == rows * columns


def test_triangles_keep_the_tolerance_where_ties_bend_the_surface():
    strips, ties = laid()
    settings = SurfaceSettings(cells=True, tolerance=1e-5)
    surface = build_surface(strips, NAMES, settings, ties=spoilt(ties))
    plan = surface.plan
    points = surface.mesh.vertices.reshape(*surface.shape, 3)
    halfway = 0.5 * (plan.nodes[1:] + plan.nodes[:-1])
    for i, (first, count) in enumerate(zip(surface.columns, plan.counts, strict=False)):
        grid = grid_at(plan.model, i, halfway, np.linspace(0.0, 1.0, count + 1))
        ours = points[:, first : first + count + 1]
        away = np.abs(dot(0.5 * (ours[1:] + ours[:-1]) - grid.points, grid.normals))
        assert away.max() < 1e-5


def test_without_the_setting_ties_change_nothing():
    strips, ties = laid()
    alone = build_surface(strips, NAMES, SurfaceSettings())
    other = build_surface(strips, NAMES, SurfaceSettings(), ties=ties)
    np.testing.assert_array_equal(other.mesh.vertices, alone.mesh.vertices)
    assert [one.code for one in other.checks] == [one.code for one in alone.checks]


@pytest.mark.parametrize(
    "change",
    [lambda tie: tie.reversed(), upside_down, lambda tie: upside_down(tie.reversed())],
)
def test_how_a_tie_was_run_or_faced_does_not_matter(change):
    strips, ties = laid()
    off = spoilt(ties)
    one = build_surface(strips, NAMES, CELLS, ties=off)
    turned = [(name, change(tie)) for name, tie in reversed(off)]
    other = build_surface(strips, NAMES, CELLS, ties=turned)
    np.testing.assert_allclose(other.mesh.vertices, one.mesh.vertices, atol=1e-9)
    np.testing.assert_allclose(other.mesh.normals, one.mesh.normals, atol=1e-7)
    found, again = (
        {(each.code, each.where): each.value for each in surface.checks} for surface in (one, other)
    )
    assert again == pytest.approx(found, abs=1e-6)


def test_the_surface_moves_with_its_passes_and_ties():
    strips, ties = laid()
    turn, shift = exp(np.array([0.4, 0.2, -1.0])), np.array([0.3, 0.0, 1.0])
    one = build_surface(strips, NAMES, CELLS, ties=ties)
    other = build_surface(
        [moved(strip, turn, shift) for strip in strips],
        NAMES,
        CELLS,
        ties=[(name, moved(tie, turn, shift)) for name, tie in ties],
    )
    np.testing.assert_allclose(other.mesh.vertices, one.mesh.vertices @ turn.T + shift, atol=2e-8)


@pytest.mark.parametrize(
    "chosen",
    [
        {"direction": "conormal", "lengths": "unit"},
        {"direction": "angles", "angles": (0.0, 10.0, 5.0, -5.0)},
        {"lengths": "criterion1"},
        {"lengths": "criterion4"},
        {"correspondence": "fraction"},
        {"correspondence": "foot-trim"},
    ],
)
def test_ties_are_followed_however_the_lines_across_are_laid(chosen):
    strips, ties = laid()
    surface = build_surface(strips, NAMES, SurfaceSettings(cells=True, **chosen), ties=ties)
    assert [one.value for one in surface.checks if one.code == "cells"] == [2.0, 2.0]
    assert max(one.value for one in surface.checks if one.code == "seam") < 1e-4
    for i in range(2):
        for t, (_, tie) in enumerate(ties):
            points, _, normals = along_tie(surface.plan.model, i, t, V)
            apart, measured = distance(points, tie)
            assert apart.max() < 1e-8
            assert np.degrees(arc_angles(normals, measured)).max() < 0.01


def shifted(tie, by):
    """The tie moved along its normals."""
    return Strip(tie.s, tie.points + by * tie.normals, tie.frames)


def test_ties_that_cannot_be_taken_up_are_left_out_with_the_reason():
    _, ties = laid()
    (_, one), (_, two), (_, three) = ties
    oblique = passes(TORUS, [(0.0, 0.9)], [0.45], length=0.6, count=61)[0]
    leaning = Strip(two.s, two.points, exp(np.radians(20.0) * two.tangents) @ two.frames)
    places = [meeting(edge_of(two), edge_of(strip)).places[0] for strip in laid()[0]]
    half = np.clip((two.s - places[0]) / (places[1] - places[0]), 0.0, 1.0)[:, None]
    over = Strip(two.s, two.points, exp(np.pi * half * two.tangents) @ two.frames)
    for spoils, told in (
        (over, "T2 turns over between P"),
        (shifted(two, 0.008), "T2 misses P"),
        (leaning, "T2 sees normals 20° from those of P"),
        (oblique, "T2 crosses P1 at 21°"),
        (passes(TORUS, [(-0.24, 0.9)], [1.47], length=0.5, count=51)[0], "T2 crosses T1"),
        (cut(two, np.arange(20, 31)), ""),
    ):
        _, found = modelled((("T1", one), ("T2", spoils), ("T3", three)))
        cells = [check for check in found if check.code == "cells"]
        assert any(told in check.message for check in cells), told
        if told:
            assert any(check.verdict == "warn" for check in cells)
    assert all("T1, T3 close 1 cell between" in check.message for check in cells)


def test_a_tie_where_passes_touch_is_left_out():
    first, second = plane_passes(0.0, 0.0, length=0.6, nodes=31)
    turn = exp(np.array([0.0, 0.0, -0.4]))
    aslant = moved(second, turn, np.array([0.2, 0.0, 0.0]) - turn @ np.array([0.2, 0.0, 0.0]))
    quarter = exp(np.array([0.0, 0.0, 0.5 * np.pi]))
    ties = [
        (name, moved(first, quarter, np.array([x, 0.0, 0.0])))
        for name, x in (("T1", -0.2), ("T2", 0.0), ("T3", 0.2))
    ]
    surface = build_surface([first, aslant], NAMES[:2], CELLS, ties=ties)
    assert np.isfinite(surface.mesh.vertices).all()
    assert np.abs(surface.mesh.vertices[:, 2]).max() < 1e-12
    (told,) = [one for one in surface.checks if one.code == "cells"]
    assert (told.value, told.verdict) == (1.0, "warn")
    assert "T3 crosses P1 and P2 where they touch" in told.message


def test_one_tie_closes_no_cell_and_the_strips_stand():
    strips, ties = laid()
    alone = build_surface(strips, NAMES, SurfaceSettings())
    for few, why in ((ties[:1], "two ties that cross both"), ((), "no tie was captured")):
        surface = build_surface(strips, NAMES, CELLS, ties=few)
        np.testing.assert_array_equal(surface.mesh.vertices, alone.mesh.vertices)
        told = [one for one in surface.checks if one.code == "cells"]
        assert {one.verdict for one in told} == {"warn"}
        assert all(why in one.message for one in told)
    lines = build_surface(strips, NAMES, SurfaceSettings(cells=True, interior="g2"), ties=ties)
    told = [one.message for one in lines.checks if one.code == "cells"]
    assert len(told) == 1
    assert 'the interior is "g2"' in told[0]


def test_ties_may_reach_over_some_of_the_passes():
    strips, ties = laid()
    short = []
    for name, tie in ties:
        met = [meeting(edge_of(tie), edge_of(strip)).places[0] for strip in strips[:2]]
        inside = (tie.s > min(met) - 0.03) & (tie.s < max(met) + 0.03)
        short.append((name, cut(tie, np.flatnonzero(inside))))
    model, found = modelled(short)
    names = [NAMES[i] for i in model.arrangement.order]
    where = {one.where: one.value for one in found if one.code == "cells"}
    assert where == {"P1-P2": 2.0, "P2-P3": 0.0}
    assert (model.cells.lifts[0] is None) == (names[0] == "P3")


def test_a_tie_of_too_few_points_is_refused():
    strips, ties = laid()
    few = [("T1", cut(ties[0][1], np.arange(3))), *ties[1:]]
    with pytest.raises(SurfaceError, match="pass T1 has 3 points"):
        build_surface(strips, NAMES, CELLS, ties=few)


def test_a_preview_keeps_what_ties_add():
    strips, ties = laid()
    surface = build_surface(strips, NAMES, CELLS, ties=spoilt(ties))
    again = rebuilt(surface, strips)
    np.testing.assert_allclose(again.mesh.vertices, surface.mesh.vertices, atol=1e-12)
    turn, shift = exp(np.array([0.0, 0.0, 0.1])), np.array([0.1, 0.0, 0.0])
    other = rebuilt(surface, [moved(strip, turn, shift) for strip in strips])
    middle = other.mesh.vertices.reshape(*other.shape, 3)[:, other.columns[1]]
    before = surface.mesh.vertices.reshape(*other.shape, 3)[:, other.columns[1]]
    np.testing.assert_allclose(middle, before @ turn.T + shift, atol=1e-9)
