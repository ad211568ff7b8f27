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


def commands():
    """The georibbon commands of the README's code blocks, in order, without their comments."""
    lines = re.findall(r"^ {4,}(georibbon .*)$", README, re.MULTILINE)
    return [line.split("#")[0].split() for line in lines]


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
