"""The window, in Qt: nothing outside this room knows it."""
