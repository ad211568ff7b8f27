"""The window's words in the person's language; English is the text itself.

Texts are marked where they stand: `tr("Open")`, `tr("{n} of {all} poses", n=3, all=20)`;
`N_("Open")` marks one that is translated later, as in a table.  The catalogues are
gettext's; a text that a catalogue lacks stays English.
"""

import gettext

from georibbon.resources import resource

LANGUAGES = {"en": "English", "fr": "Français"}
DOMAIN = "georibbon"

_catalogue: gettext.NullTranslations = gettext.NullTranslations()


def use(language: str) -> None:
    """Take up a language of `LANGUAGES`; English for any other."""
    global _catalogue  # noqa: PLW0603 - one language for the whole window
    _catalogue = gettext.NullTranslations()
    if language in LANGUAGES and language != "en":
        _catalogue = gettext.translation(DOMAIN, resource("translations"), [language])


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
