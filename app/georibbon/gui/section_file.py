"""A section's profile as a CSV file where a person wants it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from georibbon.errors import GeoribbonError
from georibbon.gui import dialogs
from georibbon.gui.language import N_, tr

if TYPE_CHECKING:
    from georibbon.gui.notifier import Notifier
    from georibbon.scene.measuring import Section

TABLES = N_("Tables (*.csv)")


def save_section(parent: QWidget, notifier: Notifier, folder: Path, section: Section) -> None:
    """Write a section, metres, into a file that a person chooses; tells what came of it."""
    from georibbon.export.files import CURVES_ENDINGS, require_ending, write_whole
    from georibbon.scene.measuring import section_table

    proposal = folder / f"{tr('section')}.csv"
    path = dialogs.ask_target(parent, proposal, tr("Save the section"), tr(TABLES))
    if path is None:
        return
    try:
        require_ending(path, CURVES_ENDINGS, "a section")
        write_whole(path, section_table(section).encode("utf-8"))
    except GeoribbonError as error:
        notifier.tell("error", str(error))
    else:
        notifier.tell("info", tr("written: {path}", path=path))
