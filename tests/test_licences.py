"""The licences of what is shipped."""

from importlib.metadata import distribution

import pytest

from georibbon.cli import main
from georibbon.licences import licences


@pytest.fixture(scope="module")
def listed():
    return {package.name.lower(): package for package in licences()}


def test_own_and_pythons_come_first():
    own, python, *others = licences()
    assert (own.name, own.licence) == ("georibbon", "BSD-3-Clause")
    assert python.name == "Python"
    names = [package.name.lower() for package in others]
    assert names == sorted(names)


def test_what_is_needed_to_run_is_listed(listed):
    direct = {
        "numpy",
        "scipy",
        "vtk",
        "matplotlib",
        "jinja2",
        "reportlab",
        "pyserial",
        "trimesh",
        "potpourri3d",
    }
    direct |= {"pyside6_essentials", "pyqtgraph"}
    indirect = {"pillow", "markupsafe", "fonttools", "kiwisolver", "shiboken6"}
    assert direct | indirect <= set(listed)


def test_the_window_toolkit_is_under_the_lesser_licence_with_both_texts(listed):
    for name in ("pyside6_essentials", "shiboken6"):
        assert listed[name].licence.startswith("LGPL-3.0-only")
        lesser, general = listed[name].texts
        assert "GNU LESSER GENERAL PUBLIC LICENSE" in lesser
        assert "TERMS AND CONDITIONS" in general


def test_the_cad_kernel_is_listed_where_it_is_installed_with_its_three_texts(listed):
    kernel = listed["cadquery-ocp-novtk"]
    assert "Apache" in kernel.licence
    assert "LGPL-2.1-only WITH OCCT-exception-1.0 (Open CASCADE Technology)" in kernel.licence
    own, lesser, exception = kernel.texts
    assert "Apache License" in own
    assert "Version 2.1, February 1999" in lesser
    assert exception.startswith("Open CASCADE exception (version 1.0)")
    assert listed["cadquery-ocp-proxy"].texts == (own,)


def test_tools_are_not(listed):
    assert not {"pytest", "mypy", "ruff", "hatchling", "coverage", "uv"} & set(listed)


def test_each_has_version_licence_and_text(listed):
    for name, package in listed.items():
        if name != "python":
            assert package.version == distribution(name).version
        assert package.licence
        assert "see its" not in package.licence
    assert all(package.texts for name, package in listed.items() if name != "python")


def test_the_list_is_one_line_each(listed, capsys):
    assert main(["licences"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(listed)
    assert lines[0].split() == ["georibbon", distribution("georibbon").version, "BSD-3-Clause"]


def test_the_full_list_has_the_texts(listed, capsys):
    assert main(["licences", "--full"]) == 0
    told = capsys.readouterr().out
    assert "Redistribution and use in source and binary forms" in told
    for package in listed.values():
        assert all(text.rstrip() in told for text in package.texts)
