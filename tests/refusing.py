"""How the command line refuses: in one sentence, with exit code 2."""

from georibbon.cli import main


def refused(words, capsys) -> str:
    """What the command line says when it refuses these words."""
    capsys.readouterr()
    assert main([str(word) for word in words]) == 2
    told = capsys.readouterr().err
    assert told.startswith("georibbon: error: ")
    assert told.count("\n") == 1
    return told
