"""Takes a picture of every page and dialog of the window, and tells whose words lack room.

    packaging/gallery -o build/screenshots --theme light dark --scale 2

writes them into build/screenshots/light-2 and build/screenshots/dark-2.
The window is driven as a person drives it, over a virtual ribbon.  Exits with 1
where words are clipped.
"""

import argparse
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path


def main() -> int:
    """Take the pictures; the exit code."""
    wanted = _arguments()
    if wanted.list:
        from scenes import NAMES

        print("\n".join(NAMES))
        return 0
    os.environ["QT_SCALE_FACTOR"] = str(wanted.scale)  # before there is an application
    for folder in _folders(wanted).values():
        folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="georibbon-") as home:
        os.environ["HOME"], os.environ["XDG_DATA_HOME"] = home, f"{home}/data"
        os.environ["XDG_CONFIG_HOME"] = f"{home}/config"
        return _take(wanted, Path(home))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("-o", "--output", type=Path, help="folder of the pictures")
    what.add_argument("--list", action="store_true", help="only the pictures' names")
    parser.add_argument("--theme", nargs="+", choices=("light", "dark"), default=["light"])
    parser.add_argument("--scale", type=int, choices=(1, 2), default=1)
    parser.add_argument("--language", choices=("en", "fr"), default="en")
    parser.add_argument("--size", default="1280x800", help="of the window, as 1280x800")
    parser.add_argument("--prepared", type=Path, help="folder in which the sessions are kept")
    parser.add_argument("--calm", action="store_true", help="figures as a real ribbon has them")
    parser.add_argument("--only", nargs="*", default=[], metavar="NAME", help="these pictures")
    parser.add_argument("--scenes", nargs="*", default=[], help="these scenes")
    return parser.parse_args()


def _folders(wanted: argparse.Namespace) -> dict[str, Path]:
    """Where the pictures of each theme go."""
    whole = wanted.output.absolute()
    return {theme: whole / f"{theme}-{wanted.scale}" for theme in wanted.theme}


def _take(wanted: argparse.Namespace, home: Path) -> int:
    from georibbon.gui import language
    from georibbon.gui.app import make_application

    application = make_application()
    language.use(wanted.language)
    import prepare
    from scenes import SCENES

    captures = home / "captures"
    prepared = wanted.prepared or home / "prepared"
    prepare.prepare(prepared)
    shutil.copytree(prepared, captures)
    stage = _stage(wanted, home, captures)
    for scene in SCENES:
        if not wanted.scenes or scene.__name__ in wanted.scenes:
            began = time.monotonic()
            scene(stage)
            print(f"{scene.__name__}: {time.monotonic() - began:.1f} s", flush=True)
    stage.window.close()
    application.processEvents()
    return _tell(stage, wanted.output)


def _stage(wanted: argparse.Namespace, home: Path, captures: Path):
    """The window, with what is kept put where it looks for it."""
    import prepare
    from stage import Stage, Wishes

    from georibbon.gui.files import calibrations_folder
    from georibbon.gui.settings import Settings

    calibrations_folder().parent.mkdir(parents=True, exist_ok=True)
    (captures / prepare.SHELF).rename(calibrations_folder())
    settings = Settings(home / "settings.ini")
    settings.theme, settings.language, settings.folder = wanted.theme[0], wanted.language, captures
    settings.sound = False
    for name in (prepare.PART, prepare.NEXT, prepare.BONNET):
        settings.opened(captures / name)
    wishes = Wishes(_folders(wanted), frozenset(wanted.only), wanted.calm)
    stage = Stage(captures, wishes, settings)
    width, height = wanted.size.split("x")
    stage.resize(int(width), int(height))
    stage.window.show()
    stage.wait(stage.window.isVisible, "the window")
    stage.window.activateWindow()
    return stage


def _tell(stage, folder: Path) -> int:
    """What lacks room, a line each."""
    for name, found in stage.lacking.items():
        for what in found:
            print(f"clipped: {name}: {what}")
    print(f"{len(stage.taken)} pictures of each theme in {folder}")
    return 1 if stage.lacking else 0


if __name__ == "__main__":
    sys.exit(main())
