"""Runs whose numbers have to be read with care: what their verdicts say, and a mark at their rows."""

from __future__ import annotations

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell
from hydrofdi.report.runs.table import SensitivityTable, TableRow
from hydrofdi.report.wording import counted, row_name

MARKS = {"cavitating": "C", "above_supply": "A", "unsettled": "U", "clipped": "R", "still": "S"}
"""Word of a verdict → its mark in tables."""

_MEANINGS = {
    "cavitating": "a chamber is at or below the vapour limit in up to {} % of the samples",
    "above_supply": "a chamber is above the supply in up to {} % of the samples",
    "unsettled": "the RMS of a detail of P_1 changes by up to {} % from the last but one period to the last",
    "clipped": "the sensor of P_1 is at an end of its range in up to {} % of the samples",
    "still": "P_1 varies by no more than {} % of the supply, which is rounding",
}


def doubts_block(analysis: Analysis) -> Block | None:
    """How many runs have which verdict, and the largest number behind it; None where all are ok."""
    rows = analysis.table.rows
    doubtful = [row for row in rows if row.doubts]
    if not doubtful:
        return None
    verb = "has" if len(doubtful) == 1 else "have"
    lead = f"{len(doubtful)} of {counted(len(rows), 'run')} {verb} numbers that are to be read with care:"
    lines = [_line(word, [row for row in doubtful if word in row.doubts]) for word in MARKS]
    return Block("doubts", "How far the runs can be believed", (lead, *filter(None, lines)))


def _line(word: str, rows: list[TableRow]) -> str:
    if not rows:
        return ""
    worst = max(rows, key=lambda row: row.doubt_numbers[word])
    meaning = _MEANINGS[word].format(_percent(worst.doubt_numbers[word]))
    return f"{word} ({MARKS[word]}), {counted(len(rows), 'run')}: {meaning} ({row_name(worst)})."


def _percent(share: float) -> str:
    """A share in percent with two digits, or more where it has no decimals."""
    return f"{100.0 * share:.2g}" if share < 0.995 else f"{100.0 * share:.0f}"


def doubt_headers(table: SensitivityTable) -> tuple[str, ...]:
    """The header of the column of marks; nothing where no row has one."""
    return ("Verdict",) if table.has_doubts else ()


def doubt_columns(table: SensitivityTable, before: int) -> tuple[int, ...]:
    """Position of the column of marks behind so many others."""
    return (before,) if table.has_doubts else ()


def doubt_cells(table: SensitivityTable, row: TableRow) -> tuple[Cell, ...]:
    """The marks of a row under `doubt_headers`."""
    if not table.has_doubts:
        return ()
    marks = " ".join(MARKS[word] for word in row.doubts)
    return (Cell(marks, value=row.verdict if marks else None),)


def doubt_note(table: SensitivityTable) -> str:
    """What the marks mean, those that occur."""
    found = {word for row in table.rows for word in row.doubts}
    words = ", ".join(f"{mark} {word}" for word, mark in MARKS.items() if word in found)
    return f"Verdict: {words}." if words else ""
