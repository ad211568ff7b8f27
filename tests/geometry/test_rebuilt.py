"""Laws of the preview: a surface built again through passes that moved a little."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, arc_angles
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.surface import Surface, SurfaceSettings, build_surface, rebuilt
from passes import moved, passes, sphere_passes, upside_down


def given() -> list[Strip]:
    """Passes out of order, one run backwards, one upside down."""
    places = [(0.0, 0.1 * k) for k in (2, 0, 1, 3)]
    strips = passes(Bonnet(), places, [0.0, 0.04, 0.0, -0.03], shifts=[0.0, 0.05, -0.02, 0.0])
    return [strips[0], strips[1].reversed(), upside_down(strips[2]), strips[3]]


def built(strips: list[Strip]) -> Surface:
    names = [f"P{k + 1}" for k in range(len(strips))]
    sigmas = [np.full(len(strip.s), 1e-4) for strip in strips]
    return build_surface(strips, names, SurfaceSettings(thickness=1e-3), sigmas)


def test_through_the_same_passes_it_is_the_same_surface() -> None:
    surface = built(given())
    again = rebuilt(surface, given())
    assert np.array_equal(again.mesh.vertices, surface.mesh.vertices)
    assert np.array_equal(again.mesh.normals, surface.mesh.normals)
    assert again.mesh.triangles is surface.mesh.triangles
    assert again.mesh.sigma is surface.mesh.sigma
    assert again.area == surface.area
    assert (again.order, again.shape, again.columns) == (
        surface.order,
        surface.shape,
        surface.columns,
    )
    assert again.solid is None


def test_it_moves_with_its_passes() -> None:
    turn, shift = Rotation.from_rotvec([0.3, -1.0, 0.2]).as_matrix(), np.array([1.0, 2.0, 0.5])
    surface = built(given())
    again = rebuilt(surface, [moved(strip, turn, shift) for strip in given()])
    assert np.allclose(again.mesh.vertices, surface.mesh.vertices @ turn.T + shift, atol=1e-9)
    assert np.allclose(again.mesh.normals, surface.mesh.normals @ turn.T, atol=1e-6)


def test_it_is_near_the_surface_that_would_be_built_anew() -> None:
    """A millimetre's bend: the old rows lie on the new surface."""
    strips = sphere_passes(shifts=[0.0, 0.03, 0.0, 0.0, 0.0])
    surface = built(strips)
    again = rebuilt(surface, sphere_passes(radius=0.61, shifts=[0.0, 0.03, 0.0, 0.0, 0.0]))
    assert np.abs(np.linalg.norm(again.mesh.vertices, axis=1) - 0.61).max() < 1e-8
    assert np.degrees(arc_angles(again.mesh.normals, again.mesh.vertices)).max() < 1e-2


def test_a_preview_can_be_built_again() -> None:
    surface = built(sphere_passes())
    wide = rebuilt(surface, sphere_passes(radius=0.61))
    assert np.array_equal(
        rebuilt(wide, sphere_passes()).mesh.vertices,
        rebuilt(surface, sphere_passes()).mesh.vertices,
    )


@pytest.mark.parametrize("wrong", ["number", "length", "unplanned"])
def test_other_passes_are_refused(wrong: str) -> None:
    surface, strips = built(sphere_passes()), sphere_passes()
    if wrong == "number":
        strips.pop()
    if wrong == "length":
        strips[1] = sphere_passes(length=0.9)[1]
    if wrong == "unplanned":
        surface = Surface(surface.mesh, surface.area, ())
    with pytest.raises(SurfaceError, match="not the passes that the surface was built through"):
        rebuilt(surface, strips)
