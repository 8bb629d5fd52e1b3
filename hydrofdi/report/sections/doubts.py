"""Runs to read with care: their verdicts, and a mark at their rows."""

from __future__ import annotations

from hydrofdi.quality.doubts import DOUBTS, Doubt
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.report.wording import row_name
from hydrofdi.settings.counting import counted


def doubts_block(analysis: Analysis) -> Block | None:
    """How many runs have which verdict, by which number, and the remedy; None if all are ok."""
    rows = analysis.table.rows
    doubtful = [row for row in rows if row.doubts]
    if not doubtful:
        return None
    verb = "has" if len(doubtful) == 1 else "have"
    lead = f"{len(doubtful)} of {counted(len(rows), 'run')} {verb} results to read with care:"
    lines = [_line(doubt, [row for row in doubtful if doubt in row.doubts]) for doubt in DOUBTS.values()]
    return Block("doubts", "How reliable the runs are", (lead, *filter(None, lines)))


def _line(doubt: Doubt, rows: list[TableRow]) -> str:
    if not rows:
        return ""
    worst = max(rows, key=lambda row: row.doubt_numbers[doubt.word])
    meaning = doubt.meaning.format(_percent(worst.doubt_numbers[doubt.word]))
    verdict = f"{doubt.word} ({doubt.mark}), {counted(len(rows), 'run')}"
    return f"{verdict}: {meaning} ({row_name(worst)}). Remedy: {doubt.remedy}."


def _percent(share: float) -> str:
    """A share in percent with two digits, or more where it has no decimals."""
    return f"{100.0 * share:.2g}" if share < 0.995 else f"{100.0 * share:.0f}"


def doubt_headers(table: SensitivityTable) -> tuple[str, ...]:
    """The header of the column of marks; nothing if no row has one."""
    return ("Verdict",) if table.has_doubts else ()


def doubt_columns(table: SensitivityTable, before: int) -> tuple[int, ...]:
    """Position of the column of marks behind so many others."""
    return (before,) if table.has_doubts else ()


def doubt_cells(table: SensitivityTable, row: TableRow) -> tuple[Cell, ...]:
    """The marks of a row under `doubt_headers`."""
    if not table.has_doubts:
        return ()
    marks = " ".join(doubt.mark for doubt in row.doubts)
    return (Cell(marks, value=row.verdict if marks else None),)


def doubt_note(table: SensitivityTable) -> str:
    """What the marks mean, those that occur."""
    found = {doubt.word for row in table.rows for doubt in row.doubts}
    words = ", ".join(f"{doubt.mark} {word}" for word, doubt in DOUBTS.items() if word in found)
    return f"Verdict: {words}." if words else ""
