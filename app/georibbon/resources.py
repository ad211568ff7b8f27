"""The files that come with the program: templates, icons, the demonstration."""

from pathlib import Path

_PACKAGE = Path(__file__).parent


def resource(name: str) -> Path:
    """The path of a resource, a file or a folder, such as "report" or "report/report.css".

    Installed from a wheel the resources lie inside the package; in a checkout,
    which an editable install uses too, beside `app/`.  Raises FileNotFoundError
    where the program is not wholly installed.
    """
    for root in (_PACKAGE / "resources", _PACKAGE.parents[1] / "resources"):
        path = root / name
        if path.exists():
            return path
    raise FileNotFoundError(f"the resource {name} is missing; install georibbon again")
