"""``georibbon capture`` as a person uses it: a process at a terminal, a ribbon at its port."""

import contextlib
import os
import pty
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from georibbon.cli import main
from georibbon.session.calibration_file import write_calibration
from georibbon.session.session import Session
from georibbon.simulation.settings import LayoutSettings, RibbonSettings, SimulationSettings
from georibbon.virtual.ports import serve_pty
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import VirtualSettings


class Terminal:
    """A capture in a process of its own, spoken to by lines, listened to until words come."""

    def __init__(self, *words):
        command = [sys.executable, "-m", "georibbon", "capture", *map(str, words)]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, bufsize=1,
        )  # fmt: skip
        self.heard = ""
        self._watch = threading.Timer(60.0, self.process.kill)
        self._watch.start()

    def say(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def wait_for(self, words):
        """Read on until a line with these words has come; the line."""
        for line in self.process.stdout:
            self.heard += line
            if words in line:
                return line
        raise AssertionError(f"{words!r} never came: {self.heard}")

    def end(self):
        """Close the input, read all; the exit code."""
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        self.heard += self.process.stdout.read()
        code = self.process.wait()
        self._watch.cancel()
        self.process.stdout.close()
        return code

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()
        self._watch.cancel()


@pytest.fixture
def world():
    simulation = SimulationSettings(
        ribbon=RibbonSettings(sensors=16), layout=LayoutSettings(passes=2, ties=1)
    )
    return VirtualRibbon(VirtualSettings(simulation, pace=0.2))


@pytest.fixture
def url(world, tmp_path):
    with serve_pty(world, tmp_path / "ribbon") as port:
        yield port.url


@pytest.fixture
def words(world, url, tmp_path):
    """What is the same in every capture here."""
    write_calibration(world.truth.calibration, tmp_path / "ribbon.json")
    place = tmp_path / "capture.georibbon"
    return [url, "-o", place, "--calibration", tmp_path / "ribbon.json", "--passes", 2]


def held(path):
    with Session.open(path, read_only=True) as session:
        return [one.name for one in session.state.passes]


def laid(world, name):
    world.do("lift")
    world.do(f"lay {name}")


def test_two_passes_by_stillness_and_it_ends_by_itself(world, words):
    terminal = Terminal(*words)
    terminal.wait_for("P1: lay a pass")
    terminal.process.stdin.close()
    for name in ("P1", "P2"):
        laid(world, name)
        assert "good" in terminal.wait_for(f"{name} is taken")
    assert terminal.end() == 0
    assert "reconstruct" in terminal.heard
    assert held(words[2]) == ["P1", "P2"]
    assert [one.name for one in words[2].parent.glob("capture*")] == ["capture.georibbon"]


def test_words_are_heard_and_nonsense_is_told(world, words):
    terminal = Terminal(*words, "--manual")
    terminal.wait_for("P1: lay a pass")
    terminal.say("fly")
    terminal.wait_for("not done")
    terminal.say("")
    terminal.wait_for("P1 is not taken")
    terminal.say("mark P1 0 0.1 0.2 0.3")
    terminal.wait_for("the survey has 1 entry")
    terminal.say("note a cold morning")
    terminal.wait_for("noted")
    terminal.say("skip")
    terminal.wait_for("P2: lay a pass")
    terminal.say("status")
    assert "[-] P1" in terminal.wait_for("P1: lay a pass")
    terminal.say("add T1 tie")
    terminal.wait_for("T1: lay a tie")
    world.do("lay T1")
    terminal.say("auto on")
    terminal.wait_for("T1 is taken")
    terminal.say("quit")
    assert terminal.end() == 0
    with Session.open(words[2], read_only=True) as session:
        assert [one.name for one in session.state.passes] == ["T1"]
        assert [note.text for note in session.state.notes] == ["a cold morning"]
        assert session.state.marks[0].position == (0.1, 0.2, 0.3)


def test_killed_in_the_middle_it_goes_on(world, words):
    first = Terminal(*words)
    first.wait_for("P1: lay a pass")
    laid(world, "P1")
    first.wait_for("P1 is taken")
    first.kill()
    assert held(words[2]) == ["P1"]
    again = Terminal(*words)
    again.wait_for("P2: lay a pass")
    again.process.stdin.close()
    laid(world, "P2")
    again.wait_for("P2 is taken")
    assert again.end() == 0
    assert held(words[2]) == ["P1", "P2"]


def test_a_pulled_cable_is_told_and_survived(world, words):
    terminal = Terminal(*words)
    terminal.wait_for("P1: lay a pass")
    laid(world, "P1")
    terminal.wait_for("P1 is taken")
    world.do("unplug 0.5")
    terminal.wait_for("disconnected")
    terminal.wait_for("streaming")
    laid(world, "P2")
    terminal.wait_for("P2 is taken")
    assert terminal.end() == 0
    with Session.open(words[2], read_only=True) as session:
        states = [one.detail["state"] for one in session.state.history if one.action == "link"]
    assert "disconnected" in states


def test_interrupted_it_closes_the_session(world, words):
    terminal = Terminal(*words)
    terminal.wait_for("P1: lay a pass")
    laid(world, "P1")
    terminal.wait_for("P1 is taken")
    terminal.process.send_signal(signal.SIGINT)
    assert terminal.end() == 0
    assert held(words[2]) == ["P1"]
    assert len(list(words[2].parent.glob("capture*"))) == 1


def test_alone_with_a_ribbon_that_is_gone_it_ends(world, words, monkeypatch, capsys):
    monkeypatch.setattr("georibbon.cli.dialogue.PATIENCE", 0.5)
    monkeypatch.setattr("sys.stdin", None)
    threading.Timer(1.5, lambda: world.do("unplug")).start()
    assert main(["capture", *map(str, words)]) == 2
    told = capsys.readouterr()
    assert "2 still open" in told.err
    assert "disconnected" in told.out
    assert held(words[2]) == []


def rescued(terminal):
    """Where what was held was brought to, as it was told."""
    place = terminal.heard.split("is safe in ")[-1].split()[0]
    assert "georibbon-rescued-" in place
    return Path(place)


def test_held_things_keep_it_from_quitting_and_are_rescued(words, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    terminal = Terminal(*words)
    terminal.wait_for("P1: lay a pass")
    words[2].unlink()
    terminal.say("note important")
    terminal.wait_for("!!")
    terminal.say("quit")
    terminal.wait_for("not everything is on disk")
    terminal.process.send_signal(signal.SIGINT)
    assert terminal.end() == 0
    with Session.open(rescued(terminal), read_only=True) as session:
        assert [note.text for note in session.state.notes] == ["important"]


def test_held_things_outlive_the_terminal(words, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    here, there = pty.openpty()
    command = [sys.executable, "-m", "georibbon", "capture", *map(str, words)]
    process = subprocess.Popen(
        command, stdin=there, stdout=there, stderr=there, start_new_session=True
    )
    os.close(there)
    try:
        read_until(here, b"lay a pass")
        words[2].unlink()
        os.write(here, b"note important\n")
        read_until(here, b"noted")
    finally:
        os.close(here)
        process.send_signal(signal.SIGHUP)
        process.wait(timeout=30)
    (place,) = tmp_path.glob("georibbon-rescued-*/*.georibbon")
    with Session.open(place, read_only=True) as session:
        assert [note.text for note in session.state.notes] == ["important"]


def read_until(descriptor, words):
    """Read a terminal until some words have come."""
    heard = b""
    while words not in heard:
        heard += os.read(descriptor, 4096)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere", "-o", "x.georibbon"], "nowhere"),
        (["nowhere", "-o", "x.csv"], ".georibbon"),
        (["nowhere", "-o", "x.georibbon", "--poses", "13"], "13 poses"),
        (["nowhere", "-o", "x.georibbon", "--plan", "none.toml"], "none.toml"),
        (["nowhere", "-o", "x.georibbon", "--passes", "-3"], "-3 passes"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, monkeypatch, capsys, words, told):
    monkeypatch.chdir(tmp_path)
    assert main(["capture", *words]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
