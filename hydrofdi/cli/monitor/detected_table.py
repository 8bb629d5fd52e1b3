"""Judged windows on the terminal: alarms before others, in readable units."""

from __future__ import annotations

from operator import itemgetter
from typing import TYPE_CHECKING

from rich.table import Table
from rich.text import Text

from hydrofdi.cli.terminal import terminal
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import limits_text, plain, score_meaning, score_name, score_unit
from hydrofdi.settings.counting import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.detectors.tally import Tally
    from hydrofdi.api.detectors.windows import JudgedWindow

_Rows = list[tuple[int, "JudgedWindow"]]

_SHOWN = 20
"""Most windows that the terminal shows."""

_MOST_TEXT = 28
"""Most characters of the name of a record."""


def print_windows(tally: Tally) -> None:
    """Print a table of the first windows, in order. If not all fit, alarms come first, then other scores
    beyond a limit, then the rest.
    """
    console, file = terminal(), tally.file
    alarms: _Rows = []
    beyond: _Rows = []
    others: _Rows = []
    n_row = 0
    for n_row, window in enumerate(tally, start=1):
        kept = alarms if window.alarm else beyond if window.is_beyond else others
        if len(kept) < _SHOWN:
            kept.append((n_row, window))
    shown = sorted([*alarms, *beyond, *others][:_SHOWN], key=itemgetter(0))
    console.print(f"{score_name(file)}, {score_meaning(file)}: alarm {limits_text(file)}")
    console.print(_table(file, [window for _, window in shown]))
    if n_row > len(shown):
        first = f"{len(alarms)} of {counted(tally.n_alarm, 'alarm')} among them" if alarms else "no alarm"
        console.print(f"… {len(shown)} of {counted(n_row, 'row')}, {first}; --format csv writes all")


def _table(file: DetectorFile, windows: list[JudgedWindow]) -> Table:
    unit = score_unit(file)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("record", overflow="fold")
    for name, unit_text in (("start", "s"), ("score", "" if unit == "1" else unit), ("margin", "spreads")):
        table.add_column(f"{name}\n{unit_text}", justify="right", no_wrap=True)
    if file.chart is not None:
        table.add_column(f"chart\nof {plain(file.chart.limit, 3)}", justify="right", no_wrap=True)
    table.add_column("verdict", overflow="fold")
    for window in windows:
        table.add_row(*_cells(file, window), style=_style(window))
    return table


def _cells(file: DetectorFile, window: JudgedWindow) -> list[str | Text]:
    line, unit = window.line, score_unit(file)
    cells: list[str | Text] = [_short(window.record_id)]
    if line is None:
        cells += ["–"] * (4 if file.chart else 3)
    else:
        score, margin = line.verdict.score, line.verdict.margin
        cells += [
            f"{line.start:.12g}",
            "–" if score is None else plain(convert(score, unit) if unit != file.unit else score, 4),
            "–" if margin is None else f"{margin:+.2f}".replace("-", "−"),
        ]
        if file.chart is not None:
            statistic = None if line.chart is None else line.chart.statistic
            cells.append("–" if statistic is None else plain(statistic, 3))
    return [*cells, _verdict_text(window)]


def _style(window: JudgedWindow) -> str | None:
    return "bold red" if window.alarm else "red" if window.is_beyond else None


def _verdict_text(window: JudgedWindow) -> str:
    if window.fault is not None:
        return f"not judged, {window.fault.kind}: {window.fault.text}"
    doubt = f", doubtful: {window.doubt}" if window.doubt else ""
    return ("ALARM" if window.alarm else "healthy") + doubt


def _short(text: str) -> str:
    return text if len(text) <= _MOST_TEXT else f"…{text[1 - _MOST_TEXT :]}"
