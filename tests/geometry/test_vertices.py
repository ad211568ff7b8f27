"""Laws of the vertices of all patches: those of the patches, whatever the numbers of columns."""

import numpy as np

from georibbon.geometry.components import crossed, dotted, inner, interleaved, outer
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.patch import Lines, lines_at, patch_grid, patches_between
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.vertices import vertices_of
from passes import passes

COUNTS = np.array([3, 1, 4])
INSIDE = np.linspace(0.1, 0.8, 12)


def lines_of(interior: str = "g1") -> Lines:
    places = [(0.0, 0.1), (0.0, 0.2), (0.02, 0.32), (0.0, 0.4)]
    strips = passes(Bonnet(), places, [0.0, 0.05, -0.05, 0.0], shifts=[0.0, 0.03, -0.02, 0.0])
    model = patches_between(arrange(strips), SurfaceSettings(interior=interior))
    return lines_at(model, INSIDE)


def expected(lines: Lines, i: int) -> tuple[np.ndarray, np.ndarray]:
    normals = lines.rails.frames[..., 2]
    v = np.arange(COUNTS[i] + 1) / COUNTS[i]
    grid = patch_grid(lines.control[i], lines.slope[i], (normals[i], normals[i + 1]), v)
    return grid.points, grid.normals


def test_vertices_are_the_patches_points_and_normals() -> None:
    for interior in ("g1", "g2"):
        lines = lines_of(interior)
        for upright in (False, True):
            points, normals = vertices_of(lines, COUNTS, upright)
            assert points.shape == normals.shape == (len(INSIDE), 9, 3)
            begin = 0
            for i, count in enumerate(COUNTS):
                here = slice(begin, begin + count + 1)
                grid, facing = expected(lines, i)
                assert np.allclose(points[:, here], grid, atol=1e-14)
                assert np.allclose(normals[:, here], facing, atol=1e-6)
                begin += count


def test_vertices_on_passes_carry_the_passes_own_normals() -> None:
    lines = lines_of()
    _, normals = vertices_of(lines, COUNTS, upright=True)
    at_passes = normals[:, [0, 3, 4, 8]].transpose(1, 0, 2)
    assert np.array_equal(at_passes, lines.rails.frames[..., 2])


def test_where_a_patch_is_folded_its_normals_are_the_passes_blended() -> None:
    lines = lines_of()
    backwards = Lines(lines.rails, lines.control, -lines.slope)
    _, normals = vertices_of(backwards, COUNTS)
    both = lines.rails.frames[:2, :, :, 2]
    blend = (2.0 * both[0] + both[1]) / 3.0
    assert np.allclose(normals[:, 1], blend / np.linalg.norm(blend, axis=1, keepdims=True))


def test_components_and_vectors_are_the_same_numbers() -> None:
    random = np.random.default_rng(1)
    a, b = random.normal(size=(2, 5, 4, 3))
    assert np.array_equal(outer(inner(a)), a)
    view = outer(inner(a))
    assert np.shares_memory(inner(view), view)
    assert interleaved(view).flags.c_contiguous
    assert np.array_equal(interleaved(view), a)
    assert np.allclose(dotted(inner(a), inner(b)), np.sum(a * b, axis=-1))
    assert np.allclose(outer(crossed(inner(a), inner(b))), np.cross(a, b))
