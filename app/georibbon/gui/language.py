"""The window's words in the person's language; English is the text itself.

Texts are marked where they stand: `tr("Open")`, `tr("{n} of {all} poses", n=3, all=20)`;
`N_("Open")` marks one that is translated later, as in a table.  Sentences of the core,
which knows no languages, are recognised by their patterns: `sentence(str(error))`.  The
catalogues are in `resources/translations`; what one lacks stays English.
"""

import gettext
import json
import re
from functools import lru_cache

from georibbon.resources import resource

LANGUAGES = {"en": "English", "fr": "Français"}
DOMAIN = "georibbon"
DEEPEST = 5  # sentences within sentences
_SLOT = re.compile(r"\{(\d+)\}")
Pattern = tuple[re.Pattern[str], str]

_catalogue: gettext.NullTranslations = gettext.NullTranslations()
_patterns: list[Pattern] = []


def use(language: str) -> None:
    """Take up a language of `LANGUAGES`; English for any other."""
    global _catalogue, _patterns  # noqa: PLW0603 - one language for the whole window
    _catalogue, _patterns = gettext.NullTranslations(), []
    if language in LANGUAGES and language != "en":
        folder = resource("translations")
        _catalogue = gettext.translation(DOMAIN, folder, [language])
        kept = (folder / language / "sentences.json").read_text(encoding="utf-8")
        _patterns = patterns(json.loads(kept))
    _translated.cache_clear()


def tr(text: str, /, **values: object) -> str:
    """A text in the language in use, its {names} filled in."""
    translated = _catalogue.gettext(text)
    return translated.format(**values) if values else translated


def trn(one: str, many: str, n: int, /, **values: object) -> str:
    """One text or the other by the number n, which is the value {n} in it."""
    return _catalogue.ngettext(one, many, n).format(n=n, **values)


def N_(text: str) -> str:
    """A text that is translated where it is shown."""
    return text


def sentence(text: str) -> str:
    """A sentence of the core in the language in use; as it is where its pattern is not known."""
    return _translated(text, 0) if _patterns else text


def patterns(translations: dict[str, str]) -> list[Pattern]:
    """What recognises the sentences, the most telling first.

    translations: from English to another language, both with {0}, {1}, ... for
    what differs from one sentence to the next.
    """
    literal = sorted(translations, key=lambda one: -len(_SLOT.sub("", one)))
    return [(_recogniser(english), translations[english]) for english in literal]


def _recogniser(english: str) -> re.Pattern[str]:
    parts = _SLOT.split(english)
    text = "".join(
        re.escape(part) if i % 2 == 0 else f"(?P<slot{part}>.+?)" for i, part in enumerate(parts)
    )
    return re.compile(text, re.DOTALL)


@lru_cache(maxsize=2000)
def _translated(text: str, depth: int) -> str:
    if depth < DEEPEST:
        for recogniser, translation in _patterns:
            found = recogniser.fullmatch(text)
            if found is not None:
                return _SLOT.sub(
                    lambda slot: _translated(found[f"slot{slot[1]}"], depth + 1),  # noqa: B023
                    translation,
                )
    return text
