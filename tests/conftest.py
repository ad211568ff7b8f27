"""What all tests share."""

import os

import pytest
from hypothesis import settings

from georibbon.cli import main

# Reproducible, and without a time limit an example: a slow machine is no failure.
settings.register_profile("house", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("house")

# Pictures are drawn off screen; without this, VTK looks for a display and complains.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

# They take longest in one piece: begun first, none of them is waited for at the end.
LONGEST = (
    "test_screenshots.py", "test_whole_job.py", "test_readme.py", "test_kill_and_go_on.py",
    "test_unplugged.py", "test_clumsy.py", "test_cli_capture.py", "test_wheel.py",
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """The longest files first; all else in its order."""
    items.sort(key=lambda item: item.path.name not in LONGEST)


@pytest.fixture(scope="session")
def small_capture(tmp_path_factory):
    """A small recording folder of a virtual capture: 3 passes, 16 sensors; truth beside it."""
    folder = tmp_path_factory.mktemp("capture") / "dome"
    words = ["simulate", "dome", "-o", str(folder), "--sensors=16", "--passes=3", "--frames=40"]
    assert main([*words, "--length=0.6", "--seed=3"]) == 0
    return folder


@pytest.fixture
def no_work(monkeypatch):
    """Makes the long work a fault: what is refused late exits with 1."""

    def reconstruct(*_):
        raise AssertionError("the work has begun")

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", reconstruct)
