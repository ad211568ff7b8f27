"""`georibbon virtual`."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace

import pytest
import serial

from georibbon.capture.plan import check_survey, read_plan
from georibbon.cli import build_parser, main
from georibbon.cli.simulation import GROUPS, default_of
from georibbon.cli.virtual import ELSEWHERE, virtual_settings
from georibbon.device.packets import FRAME, PacketReader
from georibbon.simulation import simulate
from georibbon.virtual import COMMANDS, VirtualRibbon, VirtualSettings, serve_tcp
from waiting import wait_until

QUICK = ("--sensors=8", "--passes=2", "--length=0.4", "--pace=0")
MESH = "v -500 -500 0\nv 500 -500 0\nv 500 500 0\nv -500 500 0\nf 1 2 3 4\n"


def settings(*words: str) -> VirtualSettings:
    return virtual_settings(build_parser(("virtual",)).parse_args(["virtual", "--pty", *words]))


@pytest.fixture
def started():
    """Starts `georibbon virtual`; ends what still runs."""
    running: list[subprocess.Popen[str]] = []

    def start(*words: str, stdin: int = subprocess.PIPE) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "georibbon", "virtual", *QUICK, *words]
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, stdin=stdin, stdout=pipe, stderr=pipe, text=True)
        running.append(process)
        return process

    yield start
    for process in running:
        if process.poll() is None:
            process.kill()
        process.communicate()


def url_of(process: subprocess.Popen[str]) -> str:
    found = re.fullmatch(r"ribbon at (.+)\n", process.stdout.readline())
    assert found, process.stderr.read()
    return found[1]


def frames_at(url: str, count: int) -> int:
    """How many frames a host has heard there, at least so many."""
    reader, heard, end = PacketReader(), 0, time.monotonic() + 30
    with serial.serial_for_url(url, timeout=0.1) as port:
        port.write(b"start\n")
        while heard < count:
            heard += sum(packet.type == FRAME for packet in reader.feed(port.read(4096)))
            assert time.monotonic() < end, "no frames came"
    return heard


def test_no_words_no_change():
    assert settings() == VirtualSettings()


def test_every_option_of_simulate_is_one_of_this_too():
    told = build_parser(("virtual",))
    known = vars(told.parse_args(["virtual", "--pty", "--poses=12"]))
    assert known["poses.plan"] == 12
    parser = known["command"]
    flags = {flag for action in parser._actions for flag in action.option_strings}
    asked = {option.flag for options in GROUPS.values() for option in options}
    assert asked - flags == ELSEWHERE - {"--plan"}
    assert default_of(settings("--passes=7").simulation, "layout.passes") == 7


def test_the_words_are_taken(tmp_path):
    path = tmp_path / "part.stl"
    found = settings(
        "--mesh", str(path), "--unit=m", "--hold=2", "--pace=0.5", "--drop=0.1", "--damage=0.2",
        "--noise=3", "--firmware=9", "--play", "--pose=90,0,0", "--dead=A01", "--tell-heading",
    )  # fmt: skip
    assert (found.mesh.path, found.mesh.unit) == (path, "m")
    assert (found.hold, found.pace, found.drop, found.damage, found.noise) == (2, 0.5, 0.1, 0.2, 3)
    assert (found.firmware, found.play) == ("9", True)
    assert found.simulation.poses.poses == ((90.0, 0.0, 0.0, False),)
    assert found.simulation.faults.dead == ("A01",)
    assert found.simulation.tell_heading
    cone = settings("--surface=cone", "--parameter=half_angle=20").simulation
    assert (cone.surface, cone.parameters) == ("cone", {"half_angle": 20.0})


def test_help_names_every_command_and_surface(capsys):
    assert main(["virtual", "--help"]) == 0
    told = capsys.readouterr().out
    assert all(command.usage in told and command.help in told for command in COMMANDS.values())
    assert "a car bonnet" in told


def test_a_session_of_words(started, tmp_path):
    link, truth, plan = tmp_path / "ribbon", tmp_path / "truth.json", tmp_path / "plan.toml"
    words = ("--pty", str(link), "--truth", str(truth), "--plan", str(plan), "--ties=1")
    process = started(*words, "--seed=4", "--surface=dome")
    assert url_of(process) == str(link)
    recording = simulate(
        settings(*QUICK, "--ties=1", "--seed=4", "--surface=dome").simulation
    ).recording
    assert json.loads(truth.read_text())["surface"] == "dome"
    planned = tomllib.loads(plan.read_text())
    assert (planned["format"], planned["version"]) == ("georibbon-plan", 1)
    assert (planned["poses"], planned["passes"], planned["ties"]) == (16, 2, 1)
    assert planned["workpiece"] == {"level": True}
    assert [mark["position"] for mark in planned["mark"]] == [
        list(m.position) for m in recording.marks
    ]
    assert [one["at"] for one in planned["crossing"]] == [list(c.at) for c in recording.crossings]
    assert frames_at(str(link), 20) >= 20
    out, err = process.communicate(
        "lay P1\n\nlay P9\njump\n" + "x" * 9000 + "\nstatus\nquit\nlift\n"
    )
    answers = out.splitlines()
    assert answers[0] == "P1, still"
    assert answers[1].startswith("error: there is no pass")
    assert answers[2].startswith("error: there is no command")
    assert answers[3].startswith("error: a command of")
    assert answers[4].startswith("P1, still; ")
    assert answers[5:] == ["bye"]
    assert (process.returncode, err) == (0, "")
    assert not link.is_symlink()


def test_the_plan_is_one_that_capture_reads(tmp_path):
    plan = tmp_path / "plan.toml"
    words = ("--ties=1", "--survey=starts,distances", "--tell-heading")
    world = VirtualRibbon(settings(*QUICK, *words))
    plan.write_text(world.plan_text(), encoding="utf-8")
    found = read_plan(plan)
    names = [one.name for one in found.planned_passes]
    assert tuple(names) == world.passes
    assert [tuple(pose)[0:4] for pose in world.poses] == [
        (pose.roll, pose.heading, pose.pitch, pose.table) for pose in found.planned_poses
    ]
    assert check_survey(found.survey, world.ribbon, names, "the plan") == world.survey()
    assert found.workpiece.heading == world.truth.yaw_degrees


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_without_input_it_serves_until_it_is_interrupted(started, tmp_path, number):
    link = tmp_path / "ribbon"
    process = started("--pty", str(link), stdin=subprocess.DEVNULL)
    frames_at(url_of(process), 5)
    frames_at(str(link), 5)
    assert process.poll() is None
    process.send_signal(number)
    _, err = process.communicate(timeout=30)
    assert process.returncode == (130 if number == signal.SIGINT else 128 + signal.SIGTERM)
    assert "Traceback" not in err
    assert not os.path.lexists(link)


def test_played_to_its_end_it_ends(started, tmp_path):
    mesh = tmp_path / "part.obj"
    mesh.write_text(MESH, encoding="utf-8")
    words = ("--mesh", str(mesh), "--poses=0", "--play", "--hold=0.2", "--tcp=127.0.0.1:0")
    process = started(*words, stdin=subprocess.DEVNULL)
    frames_at(url_of(process), 10)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (0, "", "")


@pytest.mark.parametrize("words", [(), ("--play",)])
@pytest.mark.parametrize("typed", ["", "status\n" * 9])
def test_a_fault_of_the_program_ends_it(words, typed, capsys, monkeypatch):
    """Also where it waits for a play to end, which then never would."""

    def served(*_):
        def stdin():
            wait_until(lambda: not port.serves)
            return typed.encode()

        monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=Later(stdin)))
        port = serve_tcp(*_)
        return port

    monkeypatch.setattr(VirtualRibbon, "catch_up", lambda _: 1 / 0)
    monkeypatch.setattr("georibbon.virtual.serve_tcp", served)
    assert main(["virtual", *QUICK, "--tcp=127.0.0.1:0", *words]) == 1
    told = capsys.readouterr()
    assert told.out.count("\n") == 1 + bool(typed)
    assert "a fault of the program, not of your input: ZeroDivisionError" in told.err


class Later:
    """An input whose bytes are made when the first line is asked for."""

    def __init__(self, made):
        self._made, self._lines = made, None

    def readline(self, _longest):
        self._lines = self._lines or BytesIO(self._made())
        return self._lines.readline()


REFUSED = {
    "--tcp=10.0.0.1:7000": "this machine only",
    "--tcp=127.0.0.1": "HOST:PORT",
    "--tcp=127.0.0.1:99999": "HOST:PORT",
    "--pty --surface=moon": "there is no surface",
    "--pty --mesh=nothing.stl": "missing",
    "--pty --mesh=part.stl --parameter=a=1": "no parameters",
    "--pty --hold=0": "hold",
    "--pty --sensors=200": "sensors",
    "--pty --truth=nowhere/truth.json": "nowhere",
    "--pty --tcp=127.0.0.1:0": "not allowed with",
    "": "--pty --tcp is required",
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_is_refused_in_a_sentence(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["virtual", *words.split()]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("georibbon: error: ")
    assert told.err.count("\n") == 1
    assert REFUSED[words] in told.err
    assert list(Path().iterdir()) == []


def test_a_plan_that_was_worked_on_is_not_overwritten(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin", None)
    plan = tmp_path / "plan.toml"
    plan.write_text("mine", encoding="utf-8")
    words = ["virtual", "--pty", str(tmp_path / "ribbon"), "--plan", str(plan)]
    assert main(words) == 2
    assert "not overwritten" in capsys.readouterr().err
    assert plan.read_text(encoding="utf-8") == "mine"
