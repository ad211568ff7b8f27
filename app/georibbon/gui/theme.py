"""The window's colours: a light and a dark palette of our own, on Qt's Fusion style."""

from typing import Literal

from PySide6.QtWidgets import QApplication

Theme = Literal["light", "dark"]
THEMES: tuple[Theme, ...] = ("light", "dark")


def apply_theme(app: QApplication, theme: Theme) -> None:
    """Give all windows, present and to come, a theme's colours."""
    if theme not in THEMES:
        raise ValueError(f"there is no theme {theme}")
    app.setStyle("Fusion")
