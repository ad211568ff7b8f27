"""What the README and the pages beside it say runs, and is true."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from georibbon.device.identity import Identity, read_identity, write_identity
from georibbon.device.packets import DONE, FRAME, IDENTITY, MESSAGE, checksum
from georibbon.errors import DeviceError
from georibbon.session import outline
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import virtual_ribbon

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROTOCOL = (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")
FORMAT = (ROOT / "docs" / "recording.md").read_text(encoding="utf-8")


def lines_of(text):
    """The georibbon commands of the code blocks in a text, in order, without their comments."""
    lines = re.findall(r"^ {4,}(georibbon .*)$", text, re.MULTILINE)
    return [line.split("#")[0].split() for line in lines]


def commands():
    """The commands that need no ribbon: those before the section on capturing."""
    return lines_of(README.split("## Capture")[0])


def run(words, folder):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where `make demo` has been run and then the README's commands."""
    place = tmp_path_factory.mktemp("readme")
    georibbon = [sys.executable, "-m", "georibbon"]
    run([*georibbon, "demo", "--output", "build/demo"], place)
    for words in commands():
        run([*georibbon, *words[1:]], place)
    return place


@pytest.mark.timeout(300)
def test_the_commands_run_and_leave_what_they_name(folder):
    named = {word for words in commands() for word in words if word.startswith("build/")}
    assert len(named) >= 8
    for name in named:
        assert (folder / name).exists(), name
    for name in ("report.html", "surface.stl", "curves.csv", "surface.png", "demo.georibbon"):
        assert (folder / "build" / "demo" / name).stat().st_size > 1000


@pytest.mark.timeout(300)
def test_the_two_terminals_capture_and_reconstruct(tmp_path):
    _, virtual, capture, reconstruct = lines_of(README.split("## Capture")[1])
    (tmp_path / "build").mkdir()
    assert capture[-2:] == ["<", "/dev/null"]
    # The same, with quicker hands.
    hurry = ["--hold", "1.5", "--pace", "0.3", "--poses", "12"]
    georibbon = [sys.executable, "-m", "georibbon"]
    with subprocess.Popen(
        [*georibbon, *virtual[1:], *hurry], cwd=tmp_path, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, text=True,
    ) as ribbon:  # fmt: skip
        try:
            assert ribbon.stdout.readline() == "ribbon at build/ribbon\n"
            done = subprocess.run(
                [*georibbon, *capture[1:-2]], cwd=tmp_path, stdin=subprocess.DEVNULL,
                capture_output=True, text=True, check=False,
            )  # fmt: skip
        finally:
            ribbon.terminate()
    assert done.returncode == 0, done.stderr
    assert "P5 is taken" in done.stdout
    told = run([*georibbon, *reconstruct[1:]], tmp_path)
    assert "good" in told
    assert (tmp_path / "build" / "bonnet.stl").stat().st_size > 1000


@pytest.mark.timeout(300)
def test_the_python_lines_run(folder):
    (block,) = re.findall(r"From Python:\n\n((?: {4}.*\n|\n)+)", README)
    script = "\n".join(line[4:] for line in block.splitlines())
    out = run([sys.executable, "-c", script], folder)
    passes = out.split("\n")[:-1]
    assert len(passes) == 8
    assert all(" (" in line for line in passes)


def test_links_and_scripts_are_there():
    for page in PAGES:
        targets = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
        assert targets or page.name == "recording.md", page
        for target in targets:
            assert (page.parent / target).exists(), target
    scripts = re.findall(r"`(benchmarks/\w+\.py)", README)
    assert scripts
    for script in scripts:
        assert (ROOT / script).is_file(), script


@pytest.mark.parametrize("table", ["_SENSOR", "_POSE", "_PASS", "_MARK", "_DISTANCE", "_CROSSING"])
def test_every_field_of_a_recording_is_described(table):
    fields = getattr(outline, table)
    assert fields
    for field in fields:
        assert f"`{field}" in FORMAT, field


def test_the_protocol_is_the_one_that_is_spoken():
    kinds = dict(re.findall(r"^\| (0x\d\d) (\w+) ", PROTOCOL, re.MULTILINE))
    spoken = {"identity": IDENTITY, "frame": FRAME, "message": MESSAGE, "done": DONE}
    assert {name: int(kind, 16) for kind, name in kinds.items()} == spoken
    assert f"{checksum(b'123456789'):#X}".replace("X", "x") in PROTOCOL
    (example,) = re.findall(r"\n\n((?: {4}.*\n)+)", PROTOCOL)
    table = json.loads(example)
    magnetometer = table["sensors"][0] | {"name": "M01", "kind": "magnetometer"}
    table["sensors"].append(magnetometer)
    assert read_identity(json.dumps(table).encode()).ribbon.id == "GR-0007"
    for command in ("identify", "start", "stop", "rate HZ"):
        assert f"| `{command}` |" in PROTOCOL


def test_the_protocol_carries_as_many_sensors_as_it_says():
    (most,) = re.findall(r"room for (\d+) sensors", PROTOCOL)
    assert f"up to {most} sensors" in README

    def identity(sensors):
        return Identity(virtual_ribbon(RibbonSettings(sensors=sensors)), "1.4.0")

    assert read_identity(write_identity(identity(int(most)))) == identity(int(most))
    with pytest.raises(DeviceError):
        write_identity(identity(int(most) + 1))


def test_the_readme_says_what_it_must():
    for words in ("make demo", "make test", "US 7587837", "US 9188422", "BSD-3-Clause"):
        assert words in README
