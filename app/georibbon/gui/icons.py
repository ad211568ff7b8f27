"""The icons, drawn from `resources/icons` in the colours of the theme."""

from PySide6.QtGui import QIcon

from georibbon.resources import resource


def icon(name: str, theme: str) -> QIcon:
    """An icon for the light or the dark theme."""
    return QIcon(str(resource(f"icons/{theme}/{name}.svg")))
