"""The 3D scene of a result, in VTK and without a window system's toolkit."""
