"""The window's words in the person's language; English is the text itself.

Texts are marked where they stand: `tr("Open")`, `tr("{n} of {all} poses", n=3, all=20)`;
`N_("Open")` marks one that is translated later, as in a table.  Sentences of the core,
which knows no languages, are recognised by their patterns: `sentence(str(error))`.  The
catalogues are in `resources/translations`; what one lacks stays English.
"""

import gettext
import json
from functools import lru_cache

from georibbon.gui.patterns import Recogniser
from georibbon.resources import resource

LANGUAGES = {"en": "English", "fr": "Français"}
DOMAIN = "georibbon"

_catalogue: gettext.NullTranslations = gettext.NullTranslations()
_recogniser: Recogniser | None = None


def use(language: str) -> None:
    """Take up a language of `LANGUAGES`; English for any other."""
    global _catalogue, _recogniser  # noqa: PLW0603 - one language for the whole window
    _catalogue, _recogniser = gettext.NullTranslations(), None
    if language in LANGUAGES and language != "en":
        folder = resource("translations")
        _catalogue = gettext.translation(DOMAIN, folder, [language])
        kept = (folder / language / "sentences.json").read_text(encoding="utf-8")
        _recogniser = Recogniser(json.loads(kept))
    _translated.cache_clear()


def tr(text: str, /, **values: object) -> str:
    """A text in the language in use, its {names} filled in."""
    translated = _catalogue.gettext(text) if text else ""  # of "" it has its own header
    return translated.format(**values) if values else translated


def trn(one: str, many: str, n: int, /, **values: object) -> str:
    """One text or the other by the number n, which is the value {n} in it."""
    return _catalogue.ngettext(one, many, n).format(n=n, **values)


def N_(text: str) -> str:
    """A text that is translated where it is shown."""
    return text


def sentence(text: str) -> str:
    """A sentence of the core in the language in use; as it is where its pattern is not known."""
    return text if _recogniser is None else _translated(text)


@lru_cache(maxsize=2000)
def _translated(text: str) -> str:
    return text if _recogniser is None else _recogniser.translated(text)
