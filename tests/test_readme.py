"""What the README and the pages beside it say runs, and is true."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from georibbon.session import outline

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
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
    targets = re.findall(r"\]\(([^)]+)\)", README + FORMAT)
    assert targets
    for target in targets:
        assert (ROOT / target).exists(), target
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


def test_the_readme_says_what_it_must():
    for words in ("make demo", "make test", "US 7587837", "US 9188422", "BSD-3-Clause"):
        assert words in README
