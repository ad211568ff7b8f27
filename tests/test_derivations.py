"""The derivations: formulas that can be typeset, code that exists, commands that run, links."""

import ast
import importlib
import math
import re
from functools import cache
from pathlib import Path

import pytest
from matplotlib.mathtext import MathTextParser

from georibbon.cli import build_parser

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "docs" / "derivations"
APP = ROOT / "app" / "georibbon"
CHAPTERS = sorted(path.name for path in FOLDER.glob("*.md"))
ASKED = {"frames.md", "ribbon-fit.md", "survey.md", "patch.md", "criteria.md", "uncertainty.md"}

DISPLAY = re.compile(r"^\$\$\n(.*?)\n\$\$$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$([^$\n]+)\$")
SPAN = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\[[^\]]+\]\(([^)\s]+)\)")
CODE = re.compile(r"^((?:[a-z_0-9]+/)*[a-z_0-9]+\.py)(?:: (.+))?$")
NUMBER = re.compile(r"^(-?[0-9.]+(?:e-?[0-9]+)?)(°?)$")
# What GitHub's renderer refuses, or this test's does not know.
REFUSED = (r"\operatorname", r"\begin", r"\text", r"\\", r"\tag", r"\label")


@cache
def source(chapter):
    return (FOLDER / chapter).read_text(encoding="utf-8")


def without_code(text):
    """A chapter's text without its blocks and spans of code."""
    return SPAN.sub("", re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE))


def formulas(chapter):
    """(displayed, within lines) all formulas of a chapter."""
    text = without_code(source(chapter))
    return DISPLAY.findall(text), INLINE.findall(DISPLAY.sub("", text))


def headings(text):
    """The anchors that GitHub makes of a text's headings."""
    found = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", one.lower()).replace(" ", "-") for one in found}


def spans(chapter):
    return SPAN.findall(re.sub(r"^ {4}.*$", "", source(chapter), flags=re.MULTILINE))


def commands(chapter):
    """The commands of a chapter's blocks of code, word by word."""
    return [
        line.split("#")[0].split() for line in re.findall(r"^ {4}(\S.*)$", source(chapter), re.M)
    ]


def test_every_topic_has_its_chapter_and_the_index_names_them_all():
    assert set(CHAPTERS) >= ASKED | {"README.md"}
    linked = set(LINK.findall(source("README.md")))
    assert linked >= set(CHAPTERS) - {"README.md"}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_every_formula_can_be_typeset(chapter):
    shown, within = formulas(chapter)
    parser = MathTextParser("path")
    for formula in [*shown, *within]:
        assert not [word for word in REFUSED if word in formula], formula
        box = parser.parse(f"${' '.join(formula.split())}$")
        assert box.width > 0.0, formula
    if chapter in ASKED:
        assert len(shown) >= 10


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_no_formula_means_something_else_in_markdown(chapter):
    """Before a formula is typeset Markdown must leave it as it is."""
    shown, within = formulas(chapter)
    for formula in [*shown, *within]:
        assert not re.search(r"\\[^a-zA-Z ]", formula), f"Markdown takes the backslash: {formula}"
        assert not re.search(r"(?<![\w])_|\*|`|<\w", formula), f"Markdown takes a mark: {formula}"
        assert formula == formula.strip(), formula
    for formula in shown:
        lines = formula.split("\n")
        assert not [one for one in lines if re.match(r"[-+=>#\s]|\d+[.)]|$", one)], formula
    for line in without_code(source(chapter)).split("\n"):
        if line.startswith("|"):
            assert not [one for one in INLINE.findall(line) if "|" in one], line


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_dollars_come_in_pairs(chapter):
    text = without_code(source(chapter))
    text = DISPLAY.sub("", text)
    assert "$" not in INLINE.sub("", text)
    for match in INLINE.finditer(text):
        around = text[match.start() - 1 : match.start()] + text[match.end() : match.end() + 1]
        assert not re.search(r"\w", around), f"no formula begins or ends within a word: {match[0]}"


def defined(module):
    """The names that a source file defines, with those of its classes as Class.name."""
    tree = ast.parse((module).read_text(encoding="utf-8"))
    names = set()
    for scope, prefix in [
        (tree, ""),
        *((n, f"{n.name}.") for n in tree.body if isinstance(n, ast.ClassDef)),
    ]:
        for node in scope.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                names.add(prefix + node.name)
            for target in getattr(node, "targets", [getattr(node, "target", None)]):
                for one in ast.walk(target) if target is not None else ():
                    if isinstance(one, ast.Name):
                        names.add(prefix + one.id)
    return names


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_code_that_is_named_exists_and_its_numbers_are_these(chapter):
    """`path.py`, `path.py: name, Class.name` and `path.py: CONSTANT = 0.25`, angles in degrees."""
    found = [match for match in map(CODE.match, spans(chapter)) if match]
    if chapter in ASKED:
        assert len(found) >= 8
    for match in found:
        path, rest = match.groups()
        file = ROOT / path if path.startswith(("benchmarks/", "tests/")) else APP / path
        assert file.is_file(), path
        for part in rest.split(", ") if rest else ():
            name, _, value = part.partition(" = ")
            assert name in defined(file), f"{path}: {name}"
            if value:
                assert_is(path, name, value)


def assert_is(path, name, value):
    module = importlib.import_module("georibbon." + path.removesuffix(".py").replace("/", "."))
    number, degrees = NUMBER.match(value).groups()
    told = math.radians(float(number)) if degrees else float(number)
    assert float(getattr(module, name)) == pytest.approx(told, rel=1e-12), f"{path}: {name}"


def options(script):
    """The options that a script of the benchmarks takes."""
    calls = [
        node
        for node in ast.walk(ast.parse(script.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "add_argument"
    ]
    return {one.args[0].value for one in calls}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_commands_can_be_given(chapter):
    for words in commands(chapter):
        if words[0] == ".venv/bin/python":
            script = ROOT / words[1]
            assert script.is_file(), words
            asked = {word for word in words[2:] if word.startswith("--")}
            assert asked <= options(script), words
        elif words[0] == "make":
            makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
            assert all(re.search(f"^{word}:", makefile, re.MULTILINE) for word in words[1:]), words
        else:
            assert words[0] == "georibbon", words
            build_parser(words[1:]).parse_args(words[1:])


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_links_lead_somewhere(chapter):
    for link in LINK.findall(source(chapter)):
        if re.match(r"https?://", link):
            continue
        path, _, anchor = link.partition("#")
        target = (FOLDER / path).resolve() if path else FOLDER / chapter
        assert target.exists(), link
        if anchor:
            assert anchor in headings(target.read_text(encoding="utf-8")), link
