"""Names as labels, in the scene and in the drawings."""

LONGEST = 16


def short_name(name: str) -> str:
    """A name as a label: on one line, without control characters, short."""
    line = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1] + "…"
