"""The application: made in one place, for the program and for tests."""

import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import (
    QLibraryInfo,
    QSocketNotifier,
    QThreadPool,
    QTimer,
    QtMsgType,
    QTranslator,
    qInstallMessageHandler,
)
from PySide6.QtWidgets import QApplication

from georibbon import __version__
from georibbon.gui import display, language
from georibbon.gui.crash import HardCrashes, crash_folder
from georibbon.gui.notifier import Notifier
from georibbon.gui.scene_view import ask_for_surfaces
from georibbon.gui.settings import Settings


def make_application(arguments: Sequence[str] = ("georibbon",)) -> QApplication:
    """The application, with what must be said before any window is made."""
    ask_for_surfaces()
    application = QApplication(list(arguments))
    application.setApplicationName("georibbon")
    application.setApplicationDisplayName("Georibbon")
    application.setApplicationVersion(__version__)
    return application


def main(path: Path | None = None, *, demonstration: bool = False) -> int:
    """Show the window, with what lies at a path or the demonstration; returns the exit code."""
    application = make_application()
    display.release()
    hard = HardCrashes(crash_folder())
    notifier = Notifier()
    notifier.install()
    qInstallMessageHandler(lambda kind, _, text: _qt_said(notifier, kind, text))
    settings = Settings(notifier=notifier)
    take_up(application, settings.language)
    from georibbon.gui.window import MainWindow

    window = MainWindow(settings, notifier)
    heard = _close_on_signals(window)
    window.show()
    # The window is seen first, and then what takes long is loaded beside it.
    QTimer.singleShot(0, lambda: QThreadPool.globalInstance().start(_load))
    if path is not None:
        QTimer.singleShot(0, lambda: window.open(path))
    elif demonstration:
        QTimer.singleShot(0, window.files.open_demonstration)
    QTimer.singleShot(0, lambda: window.crashes.tell_of_before(hard.previous))
    code = application.exec()
    QThreadPool.globalInstance().waitForDone()
    if heard is not None:
        heard.setEnabled(False)
        os.close(signal.set_wakeup_fd(-1))
        os.close(heard.socket())
    qInstallMessageHandler(None)
    notifier.uninstall()
    hard.end()
    return code


def take_up(application: QApplication, name: str) -> None:
    """Have the window's words, and those of the toolkit itself, in a language."""
    language.use(name)
    for before in application.findChildren(QTranslator):
        application.removeTranslator(before)
        before.deleteLater()
    if name != "en":
        words = QTranslator(application)
        words.load(f"qtbase_{name}", QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath))
        application.installTranslator(words)


def _load() -> None:
    """What the first result needs."""
    import georibbon.gui.sources
    import georibbon.reconstruction
    import georibbon.scene.scene  # noqa: F401 - loaded beside the window, for those that need it


def _close_on_signals(window) -> QSocketNotifier | None:
    """Close the window, and with it the session, on Ctrl+C in the terminal or a plain kill."""
    if os.name != "posix":  # elsewhere a pipe wakes no notifier, and there are no such signals
        return None
    reading, writing = os.pipe()
    os.set_blocking(reading, False)
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda *_: None)
    heard = QSocketNotifier(reading, QSocketNotifier.Type.Read, window)
    heard.activated.connect(window.close)
    return heard


def _qt_said(notifier: Notifier, kind: QtMsgType, text: str) -> None:
    if kind in (QtMsgType.QtDebugMsg, QtMsgType.QtInfoMsg):
        return
    notifier.tell("info", f"Qt: {text}")
    if kind == QtMsgType.QtFatalMsg and sys.stderr is not None:
        print(f"georibbon: {text}", file=sys.stderr)
