"""Scores: nothing where nothing is wrong, and as much as was done where something is."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.errors import RecordingError
from georibbon.geometry.frames import Strip
from georibbon.geometry.mesh import Mesh
from georibbon.simulation import (
    LayoutSettings,
    PoseSettings,
    SimulationSettings,
    curve_errors,
    score,
    simulate,
)
from georibbon.simulation.scoring import rigid_motion, surface_errors

TRUTH = simulate(
    SimulationSettings(
        "dome", layout=LayoutSettings(passes=3), poses=PoseSettings(plan=0), frames=2
    )
).truth
TURN = Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix()
SHIFT = np.array([0.4, -0.1, 0.2])


def moved(strip, turn=TURN, shift=SHIFT):
    return Strip(strip.s, strip.points @ turn.T + shift, turn @ strip.frames)


def mesh_of(shape, lift=0.0, n=12):
    """A patch of the surface, `lift` metres outside it."""
    u = np.linspace(-0.3, 0.3, n)
    uv = np.stack(np.meshgrid(u, u, indexing="ij"), axis=2).reshape(-1, 2)
    k = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([k, k + n, k + n + 1], axis=1), np.stack([k, k + n + 1, k + 1], axis=1)]
    )
    normals = shape.normals(uv)
    return Mesh(shape.points(uv) + lift * normals, triangles, normals)


def result(strips, mesh=None, marked=True):
    passes = [SimpleNamespace(name=name, strip=strip) for name, strip in strips.items()]
    survey = [SimpleNamespace(kind="mark" if marked else "crossing")]
    surface = None if mesh is None else SimpleNamespace(mesh=mesh)
    return SimpleNamespace(passes=passes, survey=survey, surface=surface)


@pytest.mark.parametrize("align", [False, True])
def test_the_truth_has_no_error(align):
    found = curve_errors(TRUTH.strips, TRUTH, align)
    for errors in (found.all, *found.passes.values()):
        assert max(errors.rms, errors.max, errors.normal_rms, errors.normal_max) < 1e-9


def test_a_rigid_motion_is_undone_by_alignment_alone():
    strips = {name: moved(strip) for name, strip in TRUTH.strips.items()}
    assert curve_errors(strips, TRUTH, align=False).all.rms > 100.0
    found = curve_errors(strips, TRUTH, align=True)
    assert found.all.max < 1e-9
    assert found.all.normal_max < 1e-6
    np.testing.assert_allclose(found.turn, TURN.T, atol=1e-12)
    np.testing.assert_allclose(found.shift, -TURN.T @ SHIFT, atol=1e-12)


def test_a_pass_that_is_shifted_is_off_by_that_much():
    strips = dict(TRUTH.strips)
    strips["P2"] = moved(strips["P2"], np.eye(3), np.array([0.003, 0.004, 0.0]))
    found = curve_errors(strips, TRUTH, align=False)
    assert found.passes["P2"].rms == pytest.approx(5.0)
    assert found.passes["P2"].max == pytest.approx(5.0)
    assert found.passes["P1"].max < 1e-9
    assert found.all.rms == pytest.approx(5.0 / np.sqrt(3))


def test_normals_that_are_turned_about_the_tangent_are_off_by_that_angle():
    roll = Rotation.from_euler("x", 0.7, degrees=True).as_matrix()
    strips = {n: Strip(s.s, s.points, s.frames @ roll) for n, s in TRUTH.strips.items()}
    found = curve_errors(strips, TRUTH, align=False).all
    assert found.rms < 1e-9
    assert found.normal_rms == pytest.approx(0.7)
    flipped = {n: Strip(s.s, s.points, s.frames * [1, -1, -1]) for n, s in TRUTH.strips.items()}
    assert curve_errors(flipped, TRUTH, align=False).all.normal_rms == pytest.approx(180.0)


def test_curves_sampled_elsewhere_are_compared_at_the_truths_distances():
    finer = simulate(
        SimulationSettings(
            "dome",
            layout=LayoutSettings(passes=3),
            poses=PoseSettings(plan=0),
            frames=2,
        )
    ).truth.strips
    strips = {n: Strip(s.s[4:-4], s.points[4:-4], s.frames[4:-4]) for n, s in finer.items()}
    assert curve_errors(strips, TRUTH, align=False).all.max < 1e-9


def test_a_curve_that_is_missing_is_named_and_a_tie_may_be():
    strips = dict(TRUTH.strips)
    tie = {**TRUTH.strips, "T1": TRUTH.strips["P1"]}
    assert set(curve_errors(strips, replace(TRUTH, strips=tie), False).passes) == set(strips)
    del strips["P3"]
    with pytest.raises(RecordingError, match="P3"):
        curve_errors(strips, TRUTH, align=False)
    with pytest.raises(RecordingError, match="any pass"):
        curve_errors(strips, replace(TRUTH, strips={}), align=False)


def test_the_rigid_motion_never_mirrors():
    points = np.random.default_rng(1).standard_normal((20, 3))
    turn, _ = rigid_motion(points, points * [1, 1, -1])
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("lift", [0.0, 0.002, -0.001])
def test_a_surface_that_is_offset_is_off_by_that_much(lift):
    found = surface_errors(mesh_of(TRUTH.shape, lift), TRUTH.shape, np.eye(3), np.zeros(3))
    assert found == pytest.approx((1e3 * abs(lift),) * 2, abs=1e-6)


def test_a_surfaces_rms_weighs_by_area():
    mesh = mesh_of(TRUTH.shape)
    bad = mesh.vertices.copy()
    bad[0] += 0.01 * mesh.normals[0]
    rms, worst = surface_errors(replace(mesh, vertices=bad), TRUTH.shape, np.eye(3), np.zeros(3))
    assert worst == pytest.approx(10.0, abs=0.01)
    # The corner belongs to two of 242 triangles: a third of each is its own.
    assert rms == pytest.approx(10.0 * np.sqrt(2 / 3 / 242), rel=0.15)


def test_a_marked_result_is_scored_in_its_own_frame():
    shift = np.array([0.0, 0.0, 0.002])
    strips = {n: moved(s, np.eye(3), shift) for n, s in TRUTH.strips.items()}
    found = score(result(strips, mesh_of(TRUTH.shape)), TRUTH)
    assert not found.aligned
    assert found.curves.all.rms == pytest.approx(2.0)
    assert found.surface_rms == pytest.approx(0.0, abs=1e-6)


def test_without_marks_curves_and_mesh_are_aligned_together():
    strips = {n: moved(s) for n, s in TRUTH.strips.items()}
    mesh = mesh_of(TRUTH.shape, 0.001)
    mesh = replace(mesh, vertices=mesh.vertices @ TURN.T + SHIFT)
    found = score(result(strips, mesh, marked=False), TRUTH)
    assert found.aligned
    assert found.curves.all.max < 1e-6
    assert found.surface_rms == pytest.approx(1.0, abs=1e-6)
    assert found.surface_max == pytest.approx(1.0, abs=1e-6)


def test_without_a_mesh_or_a_known_surface_there_is_no_surface_error():
    assert score(result(TRUTH.strips), TRUTH).surface_rms is None
    unknown = replace(TRUTH, shape=None)
    assert score(result(TRUTH.strips, mesh_of(TRUTH.shape)), unknown).surface_max is None
