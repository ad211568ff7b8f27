"""Where the program's own files are: the same for a checkout and an installed package."""

from pathlib import Path


def resource(name: str) -> Path:
    """The path of a file of resources/, such as "demonstration.toml".

    A wheel carries the folder inside the package; in a checkout, and so for an
    editable install, it stands beside app/.
    """
    package = Path(__file__).resolve().parent
    installed = package / "resources"
    folder = installed if installed.is_dir() else package.parents[1] / "resources"
    return folder / name
