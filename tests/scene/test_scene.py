"""The scene as it is drawn: looked at by counting pixels, with room for other machines."""

import ctypes
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vtkmodules.vtkIOImage import vtkPNGReader

import synthetic
from georibbon.errors import ExportError
from georibbon.export.picture import write_picture
from georibbon.scene import egl
from georibbon.scene.arrays import from_vtk
from georibbon.scene.colours import MARK, TIE, quantity_table
from georibbon.scene.offscreen import drawn, offscreen_window, render
from georibbon.scene.scene import Scene
from georibbon.scene.text import plain_label

SIZE = (480, 300)
RESULT = synthetic.reconstruction()


@pytest.fixture(scope="module")
def picture():
    return render(RESULT, SIZE)


def near(pixels, colour, tolerance=40):
    """Which pixels are about a colour (0 to 1 each)."""
    away = pixels.astype(float) - 255 * np.array(colour)
    return np.max(np.abs(away), axis=-1) < tolerance


def coloured(pixels):
    """Which pixels are neither white nor grey."""
    return np.ptp(pixels.astype(int), axis=-1) > 30


def scale_of(picture):
    """The part of a picture where the scale stands: at the right, above the key."""
    return picture[: int(0.58 * SIZE[1]), int(0.83 * SIZE[0]) :]


def test_the_picture_has_the_size_asked_for_and_is_not_blank(picture):
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert picture.dtype == np.uint8
    assert 0.15 < coloured(picture).mean() < 0.7


def test_the_background_is_white_at_all_edges(picture):
    for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert near(edge, (1, 1, 1), 20).mean() > 0.9


def test_the_scale_stands_at_the_right_with_the_tables_colours_in_order(picture):
    right = scale_of(picture)
    table = quantity_table()
    rows = [
        np.median(np.nonzero(near(right, table[index] / 255, 12))[0]) for index in (30, 128, 225)
    ]
    assert rows[0] > rows[1] + 40 > rows[2] + 80


def test_the_surface_fills_the_middle(picture):
    middle = picture[90:170, 130:250]
    assert coloured(middle).mean() > 0.7


def test_without_the_surface_the_middle_is_bare_and_the_scale_stays():
    bare = render(synthetic.reconstruction(with_surface=False), SIZE)
    assert coloured(bare[90:170, 130:250]).mean() < 0.2
    assert coloured(scale_of(bare)).mean() > 0.1


def test_an_uncertainty_that_is_not_known_has_no_scale():
    mesh = replace(RESULT.surface.mesh, sigma=None)
    plain = render(replace(RESULT, surface=replace(RESULT.surface, mesh=mesh)), SIZE)
    assert coloured(scale_of(plain)).mean() < 0.01


def test_marks_and_ties_are_drawn_where_there_are_any(picture):
    without = render(replace(RESULT, survey=(), passes=RESULT.passes[:5]), SIZE)
    for colour in (MARK, TIE):
        assert near(picture, colour).sum() > near(without, colour).sum() + 20


def test_measured_distances_are_drawn():
    first = replace(RESULT.survey[0], kind="distance", passes=("P1", "P2"), at=(0.5, 0.5))
    spans = render(replace(RESULT, survey=(first,)), SIZE)
    without = render(replace(RESULT, survey=()), SIZE)
    assert near(spans, MARK).sum() > near(without, MARK).sum() + 20


def test_the_underside_is_lit_as_the_upper_side_is():
    """Turned over about x the object looks the same, seen from underneath."""
    turn = np.diag([1.0, -1.0, -1.0])
    mesh = RESULT.surface.mesh
    turned_mesh = replace(mesh, vertices=mesh.vertices @ turn, normals=mesh.normals @ turn)
    passes = tuple(
        replace(
            fitted,
            strip=replace(
                fitted.strip,
                points=fitted.strip.points @ turn,
                frames=turn @ fitted.strip.frames,
            ),
        )
        for fitted in RESULT.passes
    )
    turned = replace(RESULT, passes=passes, surface=replace(RESULT.surface, mesh=turned_mesh))
    upper, under = render(RESULT, SIZE), render(turned, SIZE)
    light = [picture[coloured(picture)].mean() for picture in (upper, under)]
    assert light[1] == pytest.approx(light[0], rel=0.15)


def test_pictures_of_one_result_are_the_same(picture):
    again = render(RESULT, SIZE)
    assert np.mean(np.abs(again.astype(int) - picture)) < 0.5


def test_a_fixed_range_overrules_the_data():
    scene = Scene(RESULT, uncertainty_range=(0.0, 50.0))
    window = offscreen_window(SIZE)
    scene.attach(window)
    scene.frame(1.6)
    window.Render()
    low = quantity_table()[0] / 255
    bars = [prop for prop in scene.renderer.GetViewProps() if prop.IsA("vtkScalarBarActor")]
    window.Finalize()
    assert len(bars) == 1
    assert bars[0].GetLookupTable().GetRange() == (0.0, 50.0)
    assert low[0] < 0.3


@pytest.mark.parametrize("name", ["$x_{2$ 日本", "\n\x00", "a|b" + "P" * 300])
def test_any_name_can_be_a_label_without_a_word_on_the_console(name, capfd):
    render(replace(RESULT, passes=(replace(RESULT.passes[0], name=name),), survey=()), (160, 100))
    assert capfd.readouterr() == ("", "")
    assert len(plain_label(name)) <= 16


def test_many_passes_have_fewer_labels():
    many = tuple(replace(RESULT.passes[0], name=f"P{i}") for i in range(200))
    scene = Scene(replace(RESULT, passes=many, survey=()))
    words = [p for p in scene.renderer.GetViewProps() if p.IsA("vtkTextActor")]
    labels = [one for one in words if one.GetInput().startswith("P")]
    assert 6 <= len(labels) <= 12


@pytest.mark.parametrize("display", [None, ":77"])
def test_a_picture_needs_no_display_and_says_nothing(tmp_path, display):
    code = (
        "import sys, synthetic; from pathlib import Path\n"
        "from georibbon.export.picture import write_picture\n"
        "write_picture(synthetic.reconstruction(), Path(sys.argv[1]), (160, 100))"
    )
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW", "WAYLAND_DISPLAY")
    }
    if display is not None:
        environment["DISPLAY"] = display
    run = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "part.png")],
        cwd=Path(synthetic.__file__).parent,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert (tmp_path / "part.png").stat().st_size > 1000


def test_the_png_holds_the_rendered_pixels(tmp_path):
    write_picture(RESULT, tmp_path / "part.png", SIZE)
    reader = vtkPNGReader()
    reader.SetFileName(str(tmp_path / "part.png"))
    reader.Update()
    image = reader.GetOutput()
    assert image.GetDimensions() == (*SIZE, 1)
    pixels = from_vtk(image.GetPointData().GetScalars()).reshape(SIZE[1], SIZE[0], 3)[::-1]
    assert np.mean(np.abs(pixels.astype(int) - render(RESULT, SIZE))) < 0.5


def test_another_ending_is_refused_before_anything_is_drawn(tmp_path):
    with pytest.raises(ExportError, match=r"expected \.png for a picture"):
        write_picture(RESULT, tmp_path / "part.jpg")
    assert list(tmp_path.iterdir()) == []


@ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p)
def no_devices(*_):
    return 1


class Lame:
    """An EGL library that gives no function, or functions that find no device."""

    def __init__(self, has_functions):
        found = ctypes.cast(no_devices, ctypes.c_void_p).value if has_functions else None
        self.eglGetProcAddress = lambda _: found
        self.eglInitialize = lambda *_: 0


def broken(name):
    raise OSError(f"no library {name}")


@pytest.mark.parametrize(
    ("library", "reason"),
    [
        (broken, "missing or broken"),
        (lambda _: object(), "missing or broken"),
        (lambda _: Lame(False), "no EGL device"),
        (lambda _: Lame(True), "no EGL device"),
    ],
)
def test_a_system_that_cannot_draw_is_told_what_to_install(monkeypatch, library, reason):
    monkeypatch.setattr(egl.ctypes, "CDLL", library)
    egl._missing.cache_clear()
    try:
        with pytest.raises(ExportError, match=f"{reason}.*apt-get install libegl1"):
            egl.require_egl()
    finally:
        egl._missing.cache_clear()


@pytest.mark.parametrize("width", [300, 480])
def test_the_key_keeps_within_the_picture_however_narrow(width):
    picture = render(RESULT, (width, 360))
    assert coloured(picture[:, -2:]).mean() == 0.0
    key = picture[int(0.63 * 360) :, int(0.5 * width) :]
    words = near(key, MARK, 60) & coloured(key)
    assert words.any()
    assert not words[:, -4:].any()


@pytest.mark.parametrize(("height", "left"), [(480, 0.82), (180, 0.0)])
def test_the_axes_give_way_to_the_key_in_a_low_picture(height, left):
    scene = Scene(RESULT)
    drawn(scene, (480, height))
    assert scene.overlay.GetViewport()[0] == pytest.approx(left)
