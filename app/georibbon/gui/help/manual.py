"""The manual's pages and the search over them, without Qt.

A page is a Markdown file of `resources/help/LANGUAGE`; a page that a language
lacks is shown in English.  The page of the keys is made from the actions.
"""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from georibbon.gui.language import tr
from georibbon.resources import resource

TOPICS = (
    "start", "connect", "calibrate", "capture", "survey", "smoothing", "review", "export",
    "command-line", "troubleshooting", "paper", "glossary", "keyboard",
)  # fmt: skip
KEYBOARD = "keyboard"
_HEADING = re.compile(r"^(#{1,3}) +(.+?) *#*$", re.MULTILINE)
_PICTURE = re.compile(r"^!\[([^\]]*)\]\(pictures/([a-z0-9-]+)\.png\) *$", re.MULTILINE)
_LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
_MARKS = re.compile(r"^(#+|[-*]|>|\d+\.) +|^\|[-:| ]+\|$|[*`|]|\\(?=\W)", re.MULTILINE)
_AROUND = 60  # letters of a hit's surroundings


@dataclass(frozen=True)
class Page:
    """One page: its topic, its title, its Markdown, and its sections' titles."""

    topic: str
    title: str
    text: str
    sections: tuple[str, ...]

    @property
    def plain(self) -> str:
        """Its words alone, a line of it a line."""
        return _MARKS.sub("", _LINK.sub(r"\1", self.text))


@dataclass(frozen=True)
class Hit:
    """Where words were found: the page, the section, and the words around, on one line."""

    topic: str
    title: str
    section: str
    around: str


def read_manual(language: str, actions: Sequence[tuple[str, str, str, str]]) -> tuple[Page, ...]:
    """All pages in their order.

    actions: (menu, text, keys, tip) of every action, as a person reads them.
    """
    texts = {topic: _text(topic, language) for topic in TOPICS if topic != KEYBOARD}
    texts[KEYBOARD] = keyboard_page(actions)
    return tuple(_page(topic, texts[topic]) for topic in TOPICS)


def _text(topic: str, language: str) -> str:
    for one in (language, "en"):
        try:
            return resource(f"help/{one}/{topic}.md").read_text(encoding="utf-8")
        except FileNotFoundError:
            continue
    return f"# {topic}\n"  # not wholly installed: the window tells what it can


def _page(topic: str, text: str) -> Page:
    headings = [(len(marks), words) for marks, words in _HEADING.findall(text)]
    title = next((words for level, words in headings if level == 1), topic)
    sections = tuple(words for level, words in headings if level == 2)
    return Page(topic, title, text, sections)


def keyboard_page(actions: Sequence[tuple[str, str, str, str]]) -> str:
    """The page of the keys: every action with its keys, menu by menu."""
    parts = [f"# {tr('Keyboard')}", tr(
        "Everything can be done by keyboard. The command palette finds an action by its words. "
        "Tab goes on to the next control, the arrows move within lists, plots and cards, Space "
        "ticks, Return does, Escape closes."
    )]  # fmt: skip
    rows: dict[str, list[str]] = {}
    for menu, text, keys, tip in actions:
        rows.setdefault(menu, []).append(f"| {_cell(text)} | {_cell(keys)} | {_cell(tip)} |")
    head = f"| {tr('Action')} | {tr('Keys')} | {tr('What it does')} |\n|---|---|---|"
    for menu, of in rows.items():
        parts += [f"## {menu}", "\n".join((head, *of))]
    return "\n\n".join(parts) + "\n"


def _cell(text: str) -> str:
    """A text as a table's cell: nothing in it is taken for a mark."""
    return re.sub(r"([\\|*_`<\[])", r"\\\1", text)


def with_pictures(text: str, theme: str) -> tuple[str, dict[str, Path]]:
    """A page's Markdown without the pictures that are missing, and the files of the others.

    A picture NAME.png is NAME-light.png or NAME-dark.png by the theme.
    """
    files: dict[str, Path] = {}

    def found(match: re.Match[str]) -> str:
        name = match.group(2)
        for ending in (f"-{theme}", ""):
            try:
                files[f"pictures/{name}.png"] = resource(f"help/pictures/{name}{ending}.png")
            except FileNotFoundError:
                continue
            return match.group(0)
        return ""

    return _PICTURE.sub(found, text), files


def target(link: str, topics: Sequence[str] = TOPICS) -> tuple[str, str] | None:
    """The topic and section that a link leads to; None for one that leads out of the manual.

    link: "TOPIC.md" or "TOPIC.md#section", or "#section" with an empty topic.
    """
    name, _, section = link.partition("#")
    topic = name.removesuffix(".md")
    if name and (topic == name or topic not in topics):
        return None
    return topic, section


def slug(heading: str) -> str:
    """A heading as the end of a link: small letters, with hyphens between words."""
    return re.sub(r"[^\w]+", "-", heading.casefold()).strip("-")


def folded(text: str) -> str:
    """A text in which words are looked for: without accents, small; as long as it was."""
    return "".join(
        (unicodedata.normalize("NFD", letter)[0].casefold() or letter)[0] for letter in text
    )


def search(pages: Sequence[Page], words: str) -> list[Hit]:
    """The sections in which all the words stand, in the pages' order; titles first.

    Neither accents nor capitals matter.
    """
    wanted = folded(words).split()
    if not wanted:
        return []
    in_titles, in_texts = [], []
    for page in pages:
        for section, body in _sections(page):
            told = folded(f"{page.title} {section} {body}")
            if all(word in told for word in wanted):
                hit = Hit(page.topic, page.title, section, _around(body, wanted))
                heading = folded(section or page.title)
                (in_titles if all(word in heading for word in wanted) else in_texts).append(hit)
    return in_titles + in_texts


def _sections(page: Page) -> list[tuple[str, str]]:
    """(section's title, its words); "" is what stands before the first."""
    parts = re.split(r"^## +(.+?) *#*$", page.text, flags=re.MULTILINE)
    names = ["", *parts[1::2]]
    bodies = [parts[0].partition("\n")[2], *parts[2::2]]
    return [(name, Page("", "", body, ()).plain) for name, body in zip(names, bodies, strict=True)]


def _around(body: str, wanted: Sequence[str]) -> str:
    line = " ".join(body.split())
    places = [at for word in wanted if (at := folded(line).find(word)) >= 0]
    start = max(min(places, default=0) - _AROUND // 2, 0)
    start = line.find(" ", start) + 1 if start else 0
    shown = line[start : start + 2 * _AROUND].strip()
    return f"{'… ' if start else ''}{shown}{' …' if start + 2 * _AROUND < len(line) else ''}"


def by_topic(pages: Sequence[Page]) -> Mapping[str, Page]:
    """The pages by their topics."""
    return {page.topic: page for page in pages}
