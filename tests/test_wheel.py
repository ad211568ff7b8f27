"""The package as others install it: a wheel, in a folder of its own, without the checkout."""

import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

import georibbon
from georibbon.resources import resource

ROOT = Path(__file__).resolve().parents[1]


def run(*words: str, **settings) -> str:
    """A program's standard output; its failure is the test's."""
    done = subprocess.run(words, capture_output=True, text=True, check=False, **settings)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    run(
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "--outdir",
        str(folder),
        str(ROOT),
    )
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A new environment with the wheel in it, and the tests' own packages lent to it."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    paths = sysconfig.get_paths(vars={"base": str(folder), "platbase": str(folder)})
    # A path named in a .pth file: its packages count, the editable install in it does not.
    Path(paths["purelib"], "lent.pth").write_text(sysconfig.get_path("purelib"))
    python = next(Path(paths["scripts"]).glob("python*"))
    pip = (sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet")
    run(*pip, "--disable-pip-version-check", "--no-deps", "--no-index", str(wheel))
    return folder, next(Path(paths["scripts"]).glob("georibbon*"))


def test_the_wheel_holds_the_package_and_its_resources(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    checkout = ROOT / "resources"
    resources = {
        f"georibbon/resources/{path.relative_to(checkout).as_posix()}"
        for path in checkout.rglob("*")
        if path.is_file()
    }
    assert resources
    assert resources <= names
    assert {"georibbon/__init__.py", "georibbon/cli/__init__.py", "georibbon/py.typed"} <= names
    assert {name.partition("/")[0] for name in names} == {
        "georibbon",
        f"georibbon-{georibbon.__version__}.dist-info",
    }


def test_the_command_is_installed(wheel):
    with zipfile.ZipFile(wheel) as archive:
        entry = f"georibbon-{georibbon.__version__}.dist-info/entry_points.txt"
        assert "georibbon = georibbon.cli:main" in archive.read(entry).decode()


def test_it_runs_without_the_checkout(installed, tmp_path):
    folder, command = installed
    python = command.with_name("python")
    where = "import georibbon.resources as r; print(r.__file__, r.resource('demonstration.toml'))"
    assert str(ROOT) not in run(str(python), "-c", where, cwd=tmp_path)
    assert str(folder) in run(str(python), "-c", where, cwd=tmp_path)
    assert run(str(command), "--version", cwd=tmp_path) == f"georibbon {georibbon.__version__}\n"
    assert "reconstruct" in run(str(command), "--help", cwd=tmp_path)
    assert run(str(command), "licences", cwd=tmp_path).startswith("georibbon ")


def test_it_reconstructs_without_the_checkout(installed, small_capture, tmp_path):
    """The report's page is made from the resources."""
    _, command = installed
    told = run(str(command), "reconstruct", str(small_capture), "--report=r.html", cwd=tmp_path)
    assert "written: r.html" in told
    assert (tmp_path / "r.html").stat().st_size > 0


def test_a_checkout_finds_its_resources():
    assert resource("demonstration.toml").read_bytes()
