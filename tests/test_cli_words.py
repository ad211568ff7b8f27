"""The command line as such: help, exit codes, and how refusals are told."""

import itertools
import json
import os
import shlex
import signal
import subprocess
import sys

import pytest

import georibbon
from georibbon import cli
from georibbon.cli import COMMANDS, main
from georibbon.cli.printing import json_text
from georibbon.errors import GeoribbonError


def refused(capsys) -> str:
    """What was printed on standard error: one line, which this returns."""
    told = capsys.readouterr().err
    assert told.startswith("georibbon: error: ")
    assert told.count("\n") == 1
    assert "Traceback" not in told
    return told


@pytest.fixture
def failing(monkeypatch):
    """Makes `georibbon licences` raise what it is given."""

    def arrange(error: BaseException) -> None:
        def run(*_: object) -> None:
            raise error

        monkeypatch.setattr("georibbon.cli.licence_list.run", run)

    return arrange


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"georibbon {georibbon.__version__}\n"


def test_help_names_every_command(capsys):
    assert main(["--help"]) == 0
    told = capsys.readouterr().out
    for name, (_, summary) in COMMANDS.items():
        assert name in told
        assert summary in told


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_teaches(name, capsys):
    assert main([name, "--help"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(f"usage: georibbon {name}")
    assert len(told.splitlines()) > 12


def examples(text: str) -> list[list[str]]:
    """The words of each command that a help text shows, without the program's name."""
    lines = text.replace("\\\n", " ").splitlines()
    shown = [shlex.split(line, comments=True) for line in lines if line.startswith("  georibbon ")]
    return [list(itertools.takewhile(lambda word: word != ">", words[1:])) for words in shown]


@pytest.mark.parametrize("words", [["--help"], *([name, "--help"] for name in COMMANDS)])
def test_the_examples_of_each_help_are_commands(words, capsys):
    main(words)
    shown = examples(capsys.readouterr().out)
    assert shown
    for example in shown:
        opens_window = cli.window_for(example) is not None
        assert opens_window or cli.build_parser(example).parse_args(example).run is not None


@pytest.mark.parametrize(
    ("words", "named", "command"),
    [
        (["frobnicate"], "frobnicate", "georibbon"),
        (["reconstruct"], "SOURCE", "georibbon reconstruct"),
        (["simulate", "dome"], "--output", "georibbon simulate"),
        (["reconstruct", "x", "--frobnicate"], "--frobnicate", "georibbon reconstruct"),
        (["reconstruct", "x", "--surf", "a.stl"], "--surf a.stl", "georibbon reconstruct"),
    ],
)
def test_words_that_cannot_be_read(words, named, command, capsys):
    assert main(words) == 2
    told = refused(capsys)
    assert named in told
    assert f"; {command} --help explains" in told


def test_the_input_at_fault(failing, capsys):
    failing(GeoribbonError("found A, expected B, do C"))
    assert main(["licences"]) == 2
    assert capsys.readouterr().err == "georibbon: error: found A, expected B, do C\n"


def test_a_file_the_system_refuses(failing, capsys):
    failing(PermissionError(13, "Permission denied", "part.stl"))
    assert main(["licences"]) == 2
    assert refused(capsys) == "georibbon: error: part.stl: Permission denied\n"


@pytest.mark.parametrize("error", [KeyError("k"), OSError("no file named"), AssertionError()])
def test_a_fault_of_ours(failing, capsys, error):
    failing(error)
    assert main(["licences"]) == 1
    told = capsys.readouterr().err
    assert "fault of the program" in told
    assert type(error).__name__ in told
    assert "Traceback" not in told


def test_debug_says_where_it_arose(failing, capsys):
    failing(KeyError("k"))
    assert main(["licences", "--debug"]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_interrupted(failing, capsys):
    failing(KeyboardInterrupt())
    assert main(["licences"]) == 130
    assert capsys.readouterr().err == "georibbon: interrupted\n"


def program(*words: str, **settings):
    """The program in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "georibbon", *words],
        capture_output=True, text=True, check=False, **settings,
    )  # fmt: skip


def test_as_a_module():
    run = program("--version")
    assert (run.returncode, run.stdout) == (0, f"georibbon {georibbon.__version__}\n")


def test_a_terminal_that_knows_few_signs():
    run = program("reconstruct", "--help", env=os.environ | {"PYTHONIOENCODING": "ascii"})
    assert run.returncode == 0
    assert "\\u2026" in run.stdout


def test_a_file_name_that_is_no_text(tmp_path):
    name = os.fsdecode(os.fsencode(str(tmp_path)) + b"/\xff")
    run = program("info", name, errors="surrogateescape")
    assert run.returncode == 2
    assert run.stderr.startswith(f"georibbon: error: {name}: ")


def test_a_file_name_on_a_terminal_that_knows_few_signs(tmp_path):
    environment = os.environ | {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    run = program("info", str(tmp_path / "Tür"), env=environment, encoding="utf-8")
    assert run.returncode == 2
    assert run.stderr.startswith(f"georibbon: error: {tmp_path / 'Tür'}: ")


STEERING = "\x1b[31m\x07\x9b2J\u202ered\u2028\x7f\x08\r"


def test_nothing_from_outside_steers_the_terminal(failing, capsys):
    failing(GeoribbonError(f"name {STEERING}, Ärmel 2 µm,\nand so on"))
    assert main(["licences"]) == 2
    told = "name ?[31m??2J?red????, Ärmel 2 µm,\nand so on\n"
    assert capsys.readouterr().err == f"georibbon: error: {told}"


def test_what_a_command_prints_steers_nothing_either(monkeypatch, capsys):
    monkeypatch.setattr("georibbon.cli.licence_list.run", lambda _: print(f"a {STEERING} b"))
    before = sys.stdout, sys.stderr
    assert main(["licences"]) == 0
    assert capsys.readouterr().out == "a ?[31m??2J?red???? b\n"
    assert (sys.stdout, sys.stderr) == before


def test_a_line_may_be_written_once_more(monkeypatch, capsys):
    """What the program itself writes before and behind a text, as for a running count."""
    monkeypatch.setattr(
        "georibbon.cli.licence_list.run", lambda _: sys.stdout.write("\ra\rb\bc\b\b")
    )
    assert main(["licences"]) == 0
    assert capsys.readouterr().out == "\ra?b?c\b\b"


def test_a_file_name_that_would_steer(tmp_path):
    run = program("info", str(tmp_path / "\x1b[31mred\x9b.georibbon"))
    assert run.returncode == 2
    assert "/?[31mred?.georibbon: there is no such" in run.stderr


def test_json_escapes_what_would_steer():
    facts = {"a": [STEERING, 'Ärmel\udcff\n"', 1.5], "ß\u202e": None}
    text = json_text(facts)
    assert json.loads(text) == facts
    assert text.replace("\n", "").isprintable()
    assert '"Ärmel' in text


def test_the_exit_code_reaches_the_shell(tmp_path):
    run = program("info", str(tmp_path / "nothing"))
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.startswith("georibbon: error: ")
    assert run.stderr.count("\n") == 1


def test_an_interrupt_ends_in_one_line():
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
    patched = (
        "import georibbon.cli.licence_list as c\n"
        f"def run(*_):\n    {code}\n    raise SystemExit('not interrupted')\n"
        "c.run = run\n"
        "from georibbon.cli import main\n"
        "raise SystemExit(main(['licences']))"
    )
    run = subprocess.run(
        [sys.executable, "-c", patched], capture_output=True, text=True, check=False
    )
    assert run.returncode == 128 + signal.SIGINT
    assert run.stderr == "georibbon: interrupted\n"


def test_a_reader_that_has_enough():
    """`georibbon licences --full | head -1` ends without a complaint."""
    with subprocess.Popen(
        [sys.executable, "-m", "georibbon", "licences", "--full"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as run:  # fmt: skip
        assert run.stdout.readline().startswith(b"georibbon")
        run.stdout.close()
        assert run.stderr.read() == b""
    assert run.returncode == cli.PIPE_CLOSED
