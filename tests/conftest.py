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


@pytest.fixture(scope="session")
def small_capture(tmp_path_factory):
    """A small recording folder of a virtual capture: 3 passes, 16 sensors; truth beside it."""
    folder = tmp_path_factory.mktemp("capture") / "dome"
    words = ["simulate", "dome", "-o", str(folder), "--sensors=16", "--passes=3", "--frames=40"]
    assert main([*words, "--length=0.6", "--seed=3"]) == 0
    return folder
