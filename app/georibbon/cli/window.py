"""``georibbon`` without a command: the window, where there is a display for it."""

from collections.abc import Callable
from pathlib import Path

from georibbon.errors import RecordingError, SettingsError


def run(path: Path | None) -> int:
    """Show the window until it is closed; returns the exit code.

    Raises SettingsError where no window can be shown, and RecordingError for a
    path where nothing lies.
    """
    if path is not None and not path.exists():
        raise RecordingError(
            f"{path}: there is no such folder or file; give a recording folder or a session"
        )
    from georibbon.gui.display import why_no_display

    why = why_no_display()
    if why is not None:
        raise SettingsError(f"{why}; georibbon --help lists the commands that need none")
    return _main()(path)


def run_demonstration() -> int:
    """Show the window with the demonstration until it is closed; returns the exit code."""
    return _main()(demonstration=True)


def _main() -> Callable[..., int]:
    """The window's own main function, loaded now."""
    try:
        from georibbon.gui.app import main
    except ImportError as error:
        raise SettingsError(
            f"the window cannot be loaded ({error}); install georibbon again, or see "
            "georibbon --help for the commands that need no window"
        ) from error
    return main
