"""Whether a window can be shown, found out before Qt would end the process."""

import sys

import pytest

from georibbon.cli import main, window_for
from georibbon.gui import display
from georibbon.gui.display import why_no_display


@pytest.fixture
def no_display(monkeypatch):
    """A machine without a display, as this program sees it."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.usefixtures("no_display")
@pytest.mark.parametrize("words", [[], ["--debug"], ["session"]])
def test_without_a_display_one_sentence_says_so(words, kept, capsys):
    assert main([str(kept) if word == "session" else word for word in words]) == 2
    told = capsys.readouterr().err
    assert "georibbon: error: there is no display here" in told
    assert "--help" in told


@pytest.mark.parametrize("name", ["nothing.georibbon", "no/where"])
def test_where_nothing_lies_no_window_is_shown(name, tmp_path, capsys):
    assert main([str(tmp_path / name)]) == 2
    assert "there is no such folder or file" in capsys.readouterr().err


def test_a_window_that_cannot_be_loaded_is_told(monkeypatch, capsys):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setitem(sys.modules, "georibbon.gui.app", None)
    assert main([]) == 2
    assert "the window cannot be loaded" in capsys.readouterr().err


def test_the_window_gets_the_path(monkeypatch, kept):
    shown = []

    class App:
        @staticmethod
        def main(path):
            shown.append(path)
            return 0

    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setitem(sys.modules, "georibbon.gui.app", App)
    assert main([]) == 0
    assert main([str(kept)]) == 0
    assert shown == [None, kept]


def test_commands_and_mistakes_open_no_window(tmp_path):
    (tmp_path / "part").mkdir()
    assert window_for([str(tmp_path / "part")]) == (tmp_path / "part",)
    for words in (["demo"], ["--help"], ["frobnicate"], ["a.georibbon", "b.georibbon"]):
        assert window_for(words) is None


def test_what_a_display_is():
    assert why_no_display({"QT_QPA_PLATFORM": "offscreen"}) is None
    assert why_no_display({}) == "there is no display here to show the window on"
    assert why_no_display({"DISPLAY": ":32123"}) is not None
    assert "no display" in why_no_display({"WAYLAND_DISPLAY": "wayland-9"})


class Server:
    """A display that refuses the first few, as one does that begins anew."""

    def __init__(self, refuses):
        self.refuses, self.open = refuses, set()
        self.xcb_connect, self.xcb_disconnect = Called(self.connect), Called(self.open.discard)
        self.xcb_connection_has_error = Called(lambda number: number < self.refuses)
        self.number = -1

    def connect(self, _name, _screen):
        self.number += 1
        self.open.add(self.number)
        return self.number


class Called:
    """A function of a library, as ctypes has it."""

    def __init__(self, act):
        self.act = act

    def __call__(self, *words):
        return self.act(*words)


@pytest.mark.parametrize("refuses", [0, display.TRIES - 1, display.TRIES])
def test_a_display_is_held_until_the_toolkit_has_it(refuses, monkeypatch):
    monkeypatch.setattr(display, "PAUSE", 0.0)
    monkeypatch.setattr(display, "_held", [])
    server = Server(refuses)
    answers = display._answers(server, ":1")
    assert answers == (refuses < display.TRIES)
    assert len(server.open) == answers
    display._answers(server, ":1")
    assert len(server.open) == 1 or not answers
    display.release()
    assert server.open == set()


def test_a_wayland_display_is_one(tmp_path):
    (tmp_path / "wayland-0").touch()
    found = {"WAYLAND_DISPLAY": "wayland-0", "XDG_RUNTIME_DIR": str(tmp_path)}
    assert why_no_display(found) is None
    assert why_no_display(found | {"QT_QPA_PLATFORM": "xcb"}) is not None
