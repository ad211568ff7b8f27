"""What the window's tests share: the platform, the application, and nothing left behind."""

import gc
import os
import shutil
import threading
from importlib import import_module
from types import SimpleNamespace

import pytest
from PySide6.QtCore import QEvent, QThreadPool, QTimer
from PySide6.QtWidgets import QApplication
from shiboken6 import isValid

from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.units import Units
from georibbon.session.file import create_session
from georibbon.session.folder import read_recording

# `make test` brings a display of its own; without one all but the OpenGL view can be tested.
if "QT_QPA_PLATFORM" not in os.environ:
    os.environ["QT_QPA_PLATFORM"] = "xcb" if os.environ.get("DISPLAY") else "offscreen"

LONGEST_END = 10.0  # s for a thread that was told to end: a busy machine takes its time


@pytest.fixture(scope="session")
def qapp_cls():
    """The application as the program makes it, as far as must be before any window."""
    from georibbon.gui.scene_view import ask_for_surfaces

    ask_for_surfaces()
    _set_modules_aside()
    return QApplication


def _set_modules_aside():
    """What is loaded for good is not searched for leaks after every test: it is most of the heap.

    Only before the first window: what of a window is set aside is never let go of in good order.
    """
    import_module("georibbon.gui.window")
    import_module("georibbon.gui.curve_panel")
    import_module("georibbon.reconstruction")
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def nothing_left(qapp):
    """No top-level widget, running timer, worker or thread outlives a test."""
    assert qapp is not None  # it is there before everything that may be left
    threads = set(threading.enumerate())
    yield
    QThreadPool.globalInstance().waitForDone()
    for widget in QApplication.topLevelWidgets():
        widget.close()
    _settle()
    left = [widget for widget in QApplication.topLevelWidgets() if widget.parent() is None]
    timers = [one for one in gc.get_objects() if isinstance(one, QTimer) and _runs(one)]
    for widget in left:
        widget.deleteLater()
    if left:
        _settle()
    assert not timers, f"timers still run: {timers}"
    kept = [one for one in threading.enumerate() if one not in threads and not _of_qt(one)]
    for thread in kept:
        thread.join(LONGEST_END)
    kept = [thread for thread in kept if thread.is_alive()]
    assert not kept, f"threads still run: {kept}"


def _runs(timer):
    return isValid(timer) and timer.isActive()


def _of_qt(thread):
    """Whether it is a thread of the toolkit's pools, which Python has only met."""
    return isinstance(thread, threading._DummyThread)


def _settle():
    """Deliver what waits, delete what is to be deleted, collect what nobody holds."""
    QApplication.processEvents()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    QApplication.processEvents()


@pytest.fixture(scope="session")
def kept(small_capture, tmp_path_factory):
    """A session file that is only copied."""
    path = tmp_path_factory.mktemp("kept") / "dome.georibbon"
    create_session(path, read_recording(small_capture))
    return path


@pytest.fixture
def session(kept, tmp_path):
    """A session file of a small capture: 3 passes."""
    path = tmp_path / "dome.georibbon"
    shutil.copy(kept, path)
    return path


@pytest.fixture
def parts(qapp, tmp_path):
    """What pages are given, without a ribbon: the document, empty, and what it needs."""
    document = Document(qapp)
    made = SimpleNamespace(
        settings=Settings(tmp_path / "settings.ini"), notifier=Notifier(), document=document,
        units=Units("mm"), station=None, capture=None,
    )  # fmt: skip
    yield made
    document.end()
    document.deleteLater()
