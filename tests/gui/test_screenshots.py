"""Pictures of every page and dialog, in light and dark at two scales, into build/screenshots.

Each is taken by a process of its own, as `packaging/gallery` takes them; it tells
which words have no room, and which page a window is too small for.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtGui import QImage

from georibbon.gui.theme import THEMES

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "packaging" / "gallery"
SCREENSHOTS = ROOT / "build" / "screenshots"
LONGEST = 280  # s that a process may take on a busy machine; alone it takes a fifth of it
COLOURS = 12  # at least, of a picture that is not blank: words are smooth at their edges
WHOLE, SMALL = (1280, 800), (1024, 700)
PARTS = ("export-", "panel-", "manual-", "settings", "palette", "picture", "about", "discard",
         "compare", "crash")  # fmt: skip
# The same pages again, in another state or size: at one scale they tell all they can.
AGAIN = ("colours-", "tool-", "curves-", "small-")


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """Where what is shown is prepared by the first process, for those that follow."""
    return tmp_path_factory.mktemp("gallery") / "prepared"


def names(scale):
    """The pictures that there must be, in their order."""
    said = subprocess.run(
        [sys.executable, str(GALLERY), "--list"], capture_output=True, text=True, check=True
    )
    return [name for name in said.stdout.split() if scale == 1 or not name.startswith(AGAIN)]


def colours(image):
    """How many colours some ten thousand points of a picture have."""
    step = max(1, image.width() // 120)
    across, down = range(0, image.width(), step), range(0, image.height(), step)
    return len({image.pixel(x, y) for x in across for y in down})


@pytest.mark.timeout(LONGEST + 10)
@pytest.mark.parametrize("scale", [1, 2])
def test_every_page_and_dialog_has_room_for_its_words(prepared, scale):
    wanted = sorted(names(scale))
    folders = [SCREENSHOTS / f"{theme}-{scale}" for theme in THEMES]
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
    options = ["-o", str(SCREENSHOTS), "--theme", *THEMES, "--scale", str(scale)]
    done = subprocess.run(
        [sys.executable, str(GALLERY), *options, "--prepared", str(prepared), "--only", *wanted],
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for folder in folders:
        look_through(folder, wanted, scale)


def look_through(folder, wanted, scale):
    """That all pictures are there, in their size, and not blank."""
    assert sorted(path.stem for path in folder.glob("*.png")) == wanted
    for path in sorted(folder.glob("*.png")):
        image = QImage(str(path))
        assert colours(image) >= COLOURS, path
        if not path.stem.startswith(PARTS):
            width, height = SMALL if path.stem.startswith("small-") else WHOLE
            assert (image.width(), image.height()) == (width * scale, height * scale), path
