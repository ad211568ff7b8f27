"""What all tests share."""

import os

from hypothesis import settings

# Reproducible, and without a time limit an example: a slow machine is no failure.
settings.register_profile("house", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("house")

# Pictures are drawn off screen; without this, VTK looks for a display and complains.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
