"""The rules of the house, held by tests: what is loaded when, and what the locks name."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LOCKS = ("requirements.lock", "requirements-build.lock", "requirements-dev.lock")
PEERS = "requirements-peers.lock"


def loaded_by(code: str) -> set[str]:
    """The top-level modules that a fresh process has loaded after running `code`."""
    program = f"{code}\nimport json, sys; print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return {name.partition(".")[0] for name in json.loads(run.stderr.splitlines()[-1])}


def test_the_command_line_is_light():
    loaded = loaded_by("import georibbon.cli")
    assert "georibbon" in loaded
    assert not loaded & {"vtkmodules", "vtk", "matplotlib", "PySide6", "scipy", "numpy"}


@pytest.mark.parametrize(
    "words", [["--help"], ["--version"], ["reconstruct", "--help"], ["surface", "--help"]]
)
def test_help_loads_no_mathematics(words):
    loaded = loaded_by(f"from georibbon.cli import main; assert main({words!r}) == 0")
    assert not loaded & {"numpy", "scipy", "matplotlib", "vtkmodules", "jinja2"}


def test_the_core_knows_no_pictures_and_no_window():
    loaded = loaded_by(
        "import georibbon.reconstruction, georibbon.geometry.surface, georibbon.calibration,"
        "georibbon.fitting, georibbon.session.folder"
    )
    assert "numpy" in loaded
    assert not loaded & {"vtkmodules", "vtk", "matplotlib", "PySide6", "jinja2"}


@pytest.mark.parametrize("name", [*LOCKS, PEERS])
def test_every_locked_requirement_has_a_hash_and_no_place(name):
    lines = (ROOT / "packaging" / name).read_text(encoding="utf-8").splitlines()
    requirements = [line for line in lines if not line.startswith(" ")]
    pinned = re.compile(r"[a-z0-9-]+==[^ ]+( ; .+)? \\")
    assert requirements
    assert [line for line in requirements if not pinned.fullmatch(line)] == []
    hashed = re.compile(r" +--hash=sha256:[0-9a-f]{64}( \\)?")
    assert [line for line in lines if line.startswith(" ") and not hashed.fullmatch(line)] == []


def pins(name: str) -> dict[str, str]:
    """Of a lock file: what is pinned, with its marker, to which version."""
    text = (ROOT / "packaging" / name).read_text(encoding="utf-8")
    found = re.findall(r"^([a-z0-9-]+)==([^ ]+)(?: ; (.+))? \\$", text, re.MULTILINE)
    return {f"{package}; {marker}": version for package, version, marker in found}


def test_the_locks_agree():
    run, build, test = (pins(name) for name in LOCKS)
    assert {key: test.get(key) for key in run | build} == run | build


def test_the_peers_are_measured_against_the_same_numpy_and_scipy():
    run, peers = pins("requirements.lock"), pins(PEERS)
    both = [key for key in run if key.startswith(("numpy;", "scipy;"))]
    assert both
    assert {key: peers.get(key) for key in both} == {key: run[key] for key in both}


def test_the_locks_hold_what_the_project_asks_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    groups = project["dependency-groups"]
    asked = [*project["project"]["dependencies"], *groups["build"], *groups["test"]]
    names = {re.match(r"[A-Za-z0-9-]+", line).group().lower() for line in asked}
    locked = {key.partition(";")[0] for key in pins("requirements-dev.lock")}
    assert names - locked == set()
