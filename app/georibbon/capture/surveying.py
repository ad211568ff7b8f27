"""The survey while it is captured: marks, distances and crossings, in and out one by one."""

from collections.abc import Callable, Iterable, Mapping

from georibbon.capture.ledger import Ledger
from georibbon.capture.plan import check_survey
from georibbon.errors import SettingsError
from georibbon.ribbon import Ribbon
from georibbon.session.outline import survey_tables
from georibbon.session.words import counted

Entry = dict[str, object]


class SurveyDesk:
    """The survey of a session.  names: the passes and ties that it may speak of."""

    def __init__(self, ledger: Ledger, ribbon: Ribbon, names: Callable[[], Iterable[str]]) -> None:
        self._ledger, self._ribbon, self._names = ledger, ribbon, names

    def tables(self) -> dict[str, list[Entry]]:
        """The survey as in a recording: lists of marks, distances and crossings."""
        state = self._ledger.session.state
        return survey_tables(state.marks, state.distances, state.crossings)

    def add(self, table: str, entry: Mapping[str, object]) -> None:
        """Add a mark, distance or crossing, given as in a recording.

        Raises SettingsError for what cannot be meant on this ribbon.
        """
        tables = self.tables()
        tables[table].append(dict(entry))
        self._change(tables, f"{table} noted")

    def add_all(self, entries: Iterable[tuple[str, Mapping[str, object]]]) -> None:
        """Add several, each with its table, in one step of undo."""
        tables = self.tables()
        added = 0
        for table, entry in entries:
            tables[table].append(dict(entry))
            added += 1
        self._change(tables, f"{counted(added, 'entry', 'entries')} noted")

    def change(self, table: str, number: int, entry: Mapping[str, object]) -> None:
        """Put an entry in the place of the one with a number, from 1, in one step of undo."""
        tables = self._with(table, number)
        if tables[table][number - 1] != entry:
            tables[table][number - 1] = dict(entry)
            self._change(tables, f"{table} {number} is corrected")

    def remove(self, table: str, number: int) -> None:
        """Take the entry with a number, from 1, out of a table; SettingsError if there is none."""
        tables = self._with(table, number)
        del tables[table][number - 1]
        self._change(tables, f"{table} {number} is taken out")

    def _with(self, table: str, number: int) -> dict[str, list[Entry]]:
        """The tables, where one of them has an entry of that number."""
        tables = self.tables()
        if not 1 <= number <= len(tables[table]):
            raise SettingsError(
                f"there is no {table} number {number}; the survey has {len(tables[table])}"
            )
        return tables

    def _change(self, tables: dict[str, list[Entry]], words: str) -> None:
        check_survey(tables, self._ribbon, self._names(), "the survey")
        self._ledger.write(lambda: self._ledger.session.do("survey", **tables))
        count = sum(map(len, tables.values()))
        told = f"{words}; the survey has {counted(count, 'entry', 'entries')}"
        self._ledger.tell("survey", None, told)
