"""``hydrofdi detect``."""

from __future__ import annotations

from heapq import nsmallest
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hydrofdi.cli.options import Detector, Json, SamplingFrequency, Sources
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.detectors.windows import JudgedWindow, Tally


_SHOWN = 20
"""Most windows that the terminal shows."""


def detect(
    detector: Detector,
    sources: Sources,
    form: Annotated[
        Literal["table", "csv", "json"], typer.Option("--format", help="Output format.")
    ] = "table",
    json: Json = False,
    fail_on_alarm: Annotated[bool, typer.Option("--fail-on-alarm", help="Exit code 1 on an alarm.")] = False,
    sampling_frequency: SamplingFrequency = None,
) -> int:
    """Judge records with a trained detector, window by window, as 'hydrofdi monitor' does.

    Exit code 1 if no window of a record could be judged, and on an alarm with --fail-on-alarm.
    """
    from hydrofdi.api.detectors.detector import Detector

    tally = Detector.load(detector).windows(sources, sampling_frequency=sampling_frequency)
    _write("json" if json else form, tally)
    _tell(tally)
    return 1 if tally.unjudged or (fail_on_alarm and tally.n_alarm) else 0


def _write(form: str, tally: Tally) -> None:
    if form == "table":
        _print(tally)
        return
    from hydrofdi.api.detectors.judged import csv_lines, json_parts
    from hydrofdi.cli.terminal import write_out

    for text in (csv_lines if form == "csv" else json_parts)(tally):
        write_out(text)


def _print(tally: Tally) -> None:
    """Print the first windows, in order; of many, alarms first, then other scores beyond a limit."""
    from hydrofdi.api.detectors.judged import windows_table
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal

    def place(row: tuple[int, JudgedWindow]) -> tuple[bool, bool, int]:
        return not row[1].alarm, not row[1].is_beyond, row[0]

    shown = [window for _, window in sorted(nsmallest(_SHOWN, enumerate(tally), place), key=itemgetter(0))]
    n_row, n_alarm = tally.n_judged + tally.faults.total(), sum(bool(window.alarm) for window in shown)
    console = terminal()
    print_table(console, windows_table(tally.file, shown))
    if n_row > len(shown):
        first = f"{n_alarm} of {counted(tally.n_alarm, 'alarm')} among them" if n_alarm else "no alarm"
        console.print(f"… {len(shown)} of {counted(n_row, 'row')}, {first}; --format csv writes all")


def _tell(tally: Tally) -> None:
    from hydrofdi.cli.terminal import tell
    from hydrofdi.settings.readable import count_text, time_text

    windows, records = counted(tally.n_judged, tally.noun), counted(tally.n_record, "record")
    lasting = time_text(3600.0 * tally.hours)
    parts = [f"judged {windows} of {records}, {lasting}: {counted(tally.n_alarm, 'alarm')}"]
    if tally.n_judged:
        parts += [_share(tally), f"{count_text(tally.n_alarm / tally.hours)} an hour"]
    tell(", ".join(parts))
    if tally.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in tally.faults.most_common())
        beyond = f"; {tally.n_beyond:,} of them with a score beyond the limit" if tally.n_beyond else ""
        tell(f"not judged: {tally.faults.total():,} ({kinds}){beyond}")
    if tally.n_doubtful:
        tell(f"doubtful: {tally.n_doubtful:,} of {windows}, such as {tally.first_doubt}")
    for (_, record), reason in list(tally.unjudged.items())[:1]:
        more = f"; {counted(len(tally.unjudged), 'record')} in all" if len(tally.unjudged) > 1 else ""
        tell(f"no window of {record} was judged: {reason}{more}")


def _share(tally: Tally) -> str:
    """Share of alarms among judged windows, with the interval if there is one."""
    from hydrofdi.settings.readable import percent, percentage

    rate, share = tally.rate, percent(tally.rate.value)
    if tally.rests_on:
        ends = f"{percentage(rate.low)} to {percent(rate.high)}"
        few = f"; {tally.group_noun} are too few" if tally.rests_on == "windows" and tally.n_group > 1 else ""
        return f"{share} ({ends}, {100.0 * rate.confidence:g} % interval over {tally.rests_on}{few})"
    if tally.n_group > 1:
        return f"{share} ({tally.n_group} {tally.group_noun} are too few for an interval)"
    return share
