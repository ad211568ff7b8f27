"""``georibbon licences``."""

import argparse

from georibbon.cli.arguments import Parser

DESCRIPTION = """\
List the licences of Georibbon and of every package that it needs to run, which is what
an installer ships: name, version, licence."""

EPILOG = """\
examples:
  georibbon licences                    # one line a package
  georibbon licences --full > NOTICES   # every licence's text, to go with an installer"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument("--full", action="store_true", help="the licences' texts as well")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the list."""
    from georibbon.licences import licences

    for package in licences():
        print(f"{package.name:18} {package.version:12} {package.licence}")
        if arguments.full:
            for text in package.texts:
                print(f"\n{text.rstrip()}\n")
