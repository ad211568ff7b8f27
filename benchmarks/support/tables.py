"""Figures as Markdown tables, printed and kept in build/benchmarks."""

from collections.abc import Sequence
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[2] / "build" / "benchmarks"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; the first column to the left, all others to the right."""
    ruler = ["---", *("---:" for _ in header[1:])]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (header, ruler, *rows))


def met(fine: bool) -> str:
    """The verdict on a figure."""
    return "pass" if fine else "**miss**"


def publish(name: str, parts: Sequence[str]) -> None:
    """Print the parts, and keep them as build/benchmarks/NAME.md."""
    text = "\n\n".join(parts) + "\n"
    print(text)
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / f"{name}.md").write_text(text, encoding="utf-8")
