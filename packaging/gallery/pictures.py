"""Makes the pictures of the manual and of the README from the gallery's.

    packaging/gallery/pictures.py

The window is shown in both themes, calmly, in a size that stays readable on a page.
A picture has 256 colours of its own choice, which halves its file.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PySide6.QtGui import QImage
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingColor import vtkImageQuantizeRGBToIndex

ROOT = Path(__file__).resolve().parents[2]
MANUAL, README = ROOT / "resources" / "help" / "pictures", ROOT / "docs" / "images"
SIZE = "1120x720"
COLOURS = 256
LARGEST = 200_000  # bytes of one picture
# What the manual and the README call them, and the gallery.
OF_MANUAL = {
    "start": "start",
    "connect": "connected",
    "calibrate": "calibrate-poses",
    "plan": "capture-plan",
    "capture": "capture-live",
    "survey": "capture-survey",
    "passes": "panel-passes",
    "review": "review",
    "curves": "panel-curves",
    "checks": "panel-checks",
    "export": "export-surface",
}
OF_README = {
    "window-start": "start",
    "window-capture": "capture-live",
    "window-review": "review-pass",
}


def main() -> None:
    """Take the pictures anew."""
    with tempfile.TemporaryDirectory() as folder:
        _take(folder)
        for theme in ("light", "dark"):
            for name, of in OF_MANUAL.items():
                _write(Path(folder) / f"{theme}-1" / f"{of}.png", MANUAL / f"{name}-{theme}.png")
        for name, of in OF_README.items():
            _write(Path(folder) / "light-1" / f"{of}.png", README / f"{name}.png")


def _take(folder: str) -> None:
    options = ["-o", folder, "--theme", "light", "dark", "--size", SIZE, "--calm"]
    scenes = ["start", "connect", "calibrate", "capture", "review", "dialogs"]
    subprocess.run(  # noqa: S603 - the gallery itself
        [sys.executable, str(Path(__file__).parent), *options, "--scenes", *scenes], check=True
    )


def _write(source: Path, target: Path) -> None:
    """A picture with as few colours as do, in its place."""
    target.parent.mkdir(parents=True, exist_ok=True)
    picture = fewer_colours(QImage(str(source)))
    if not picture.save(str(target), "PNG", 0):
        raise SystemExit(f"{target}: cannot be written")
    size = target.stat().st_size
    print(f"{target.relative_to(ROOT)}: {size / 1000:.0f} kB")
    if size > LARGEST:
        raise SystemExit(f"{target} is larger than {LARGEST / 1000:.0f} kB")


def fewer_colours(picture: QImage) -> QImage:
    """The picture with a palette of the colours that it needs most."""
    plain = picture.convertToFormat(QImage.Format.Format_RGB888)
    width, height = plain.width(), plain.height()
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(height, plain.bytesPerLine())
    values = np.ascontiguousarray(rows[:, : 3 * width]).reshape(-1, 3)
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(values))
    quantised = vtkImageQuantizeRGBToIndex()
    quantised.SetNumberOfColors(COLOURS)
    quantised.SetInputData(image)
    quantised.Update()
    found = quantised.GetOutput().GetPointData().GetScalars()
    indices = vtk_to_numpy(found).astype(np.uint8).reshape(height, width)
    table = quantised.GetLookupTable()
    colours = [table.GetTableValue(k)[:3] for k in range(table.GetNumberOfTableValues())]
    small = QImage(width, height, QImage.Format.Format_Indexed8)
    small.setColorTable([_packed(colour) for colour in colours])
    np.frombuffer(small.bits(), np.uint8).reshape(height, -1)[:, :width] = indices
    return small


def _packed(colour: tuple[float, float, float]) -> int:
    red, green, blue = (round(255 * part) for part in colour)
    return 0xFF000000 | red << 16 | green << 8 | blue


if __name__ == "__main__":
    main()
