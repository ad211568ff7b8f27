"""What the set-up does on a machine where something is missing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
VENV_PACKAGE = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"


@pytest.fixture
def machine(tmp_path):
    """A bare machine: programs of its own before the real ones, and a checkout without .venv."""
    (tmp_path / "checkout" / "packaging").mkdir(parents=True)
    shutil.copy(ROOT / "packaging" / "prepare.sh", tmp_path / "checkout" / "packaging")
    (tmp_path / "bin").mkdir()

    def add(name: str, script: str) -> None:
        program = tmp_path / "bin" / name
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)

    add("sudo", "exit 1")
    add("python3", f'case "$*" in *ensurepip*) exit 1 ;; esac\nexec "{sys.executable}" "$@"')
    add("apt-get", f'echo "$@" >> "{tmp_path}/apt"; case "$*" in *install*) exit 100 ;; esac')
    return add


def prepare(tmp_path) -> subprocess.CompletedProcess[str]:
    path = f"{tmp_path / 'bin'}{os.pathsep}{os.defpath}"
    return subprocess.run(
        ["sh", "packaging/prepare.sh", "run"],
        cwd=tmp_path / "checkout", env={"PATH": path}, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_who_may_not_install_is_told_the_command(machine, tmp_path):
    machine("id", "echo 1000")
    run = prepare(tmp_path)
    assert run.returncode != 0
    assert f"sudo apt-get update && sudo apt-get install -y {VENV_PACKAGE}\n" in run.stderr
    assert not (tmp_path / "apt").exists()
    assert not (tmp_path / "checkout" / ".venv").exists()


@pytest.mark.parametrize(
    ("name", "script"), [("id", "echo 0"), ("sudo", '[ "$1" = -n ] && shift\nexec "$@"')]
)
def test_who_may_install_need_not_be_asked(machine, tmp_path, name, script):
    machine("id", "echo 1000")
    machine(name, script)
    run = prepare(tmp_path)
    assert f"Installing system packages: {VENV_PACKAGE}" in run.stdout
    updated, installed = (tmp_path / "apt").read_text().splitlines()
    assert updated.startswith("update")
    assert installed.startswith("install")
    assert installed.endswith(VENV_PACKAGE)
    assert run.returncode != 0  # this machine's apt-get refuses, and nothing goes on


def test_an_old_python_is_named(machine, tmp_path):
    machine("python3", '[ "$1" = --version ] && echo Python 3.9.2\nexit 1')
    run = prepare(tmp_path)
    assert run.returncode != 0
    assert "Python 3.9.2, and 3.11 or newer is needed" in run.stderr
    assert "make PYTHON=" in run.stderr


def test_make_helps_with_every_target():
    words = ["make", "--no-print-directory", "--directory", str(ROOT)]
    told = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    targets = {line.split()[1] for line in told.splitlines()}
    assert targets == {
        "demo", "cad", "test", "benchmarks", "peers", "pictures", "translations", "lock", "clean",
    }  # fmt: skip


@pytest.mark.parametrize("purpose", ["run", "test"])
def test_pictures_and_windows_can_be_drawn_here(purpose):
    """Where the tests run, nothing that pictures and windows need is missing."""
    script = [sys.executable, "packaging/missing_libraries.py", purpose]
    run = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == ""
