"""``python -m georibbon``: the same as the command ``georibbon``."""

from georibbon.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
