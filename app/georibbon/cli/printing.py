"""What several commands print."""

from collections.abc import Iterable

from georibbon.notices import Notice


def print_notices(notices: Iterable[Notice]) -> None:
    """Each notice in one line, with its code and what it is about."""
    for notice in notices:
        about = ", ".join(filter(None, (notice.pass_name, notice.sensor)))
        print(f"notice: {notice.code}{f' ({about})' if about else ''}: {notice.message}")


def counted(count: int, one: str, many: str | None = None) -> str:
    """Such as "1 pose" or "16 poses"."""
    return f"{count} {one if count == 1 else many or one + 's'}"
