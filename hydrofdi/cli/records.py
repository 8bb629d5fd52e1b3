"""``hydrofdi inspect``, ``measure``, ``evaluate`` and ``export``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Figure, Found, Json, Sources
from hydrofdi.cli.terminal import answer, draw, tell, write_out
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures

_MOST_FAULTS, _MOST_ROWS, _FEW_RECORDS = 4, 20, 3
"""Most faults that are explained; most records, scores and pairs of groups; and most records beside each
other."""


def inspect(sources: Sources, figure: Figure = None, **settings: Any) -> Found:
    """Inspect records: channels, rates, lengths, ranges and defects.

    Simulates at most 32 records of an experiment file (.yaml), spread evenly over its runs.
    Exit code 1 if records are rejected.
    """
    found = hydrofdi.inspect(sources, **settings)
    if settings.get("write"):
        tell(f"wrote {settings['write']}")
    draw(found, figure)
    return found


def measure(
    sources: Sources,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write to a file; its suffix sets the format.")
    ] = None,
    form: Annotated[
        Literal["table", "csv", "json", "parquet"] | None,
        typer.Option("--format", help="Output format [default: table]."),
    ] = None,
    json: Json = False,
    **settings: Any,
) -> int:
    """Measure indicators of any records, simulated or measured.

    Exit code 1 if records are rejected or have no number of any indicator, or an indicator fails.
    'hydrofdi indicators' lists what can be measured.
    """
    from hydrofdi.api.records import measured_records, write_measures
    from hydrofdi.api.sources import Described
    from hydrofdi.indicators.faults import summaries
    from hydrofdi.indicators.measuring import Counted
    from hydrofdi.report.measures import csv_lines, json_parts
    from hydrofdi.tables.answer import Reply

    chosen = "json" if json else form or (out.suffix.lower()[1:] if out else "table")
    if out is None and chosen == "parquet":
        raise ConfigError("--format parquet needs --out FILE")
    if out is not None and chosen not in ("csv", "json", "parquet"):
        raise ConfigError(f"--out {out}: name it .csv, .json or .parquet, or give --format")
    said = Described(settings.get("sampling_frequency"))
    columns, measured, remarks = measured_records(sources, settings.get("indicators", "dwt"), said)
    tell(*(f"warning: {remark}" for remark in remarks))
    tally = Counted()
    records = tally.count(measured)
    if out is not None:
        write_measures(out, chosen, columns, records)
    elif chosen == "table":
        answer(Reply({}, _measures(columns, iter(records))))
    else:
        for line in (csv_lines if chosen == "csv" else json_parts)(columns, records):
            write_out(line)
    if out is not None:
        tell(f"wrote {out}: {counted(tally.n_record, 'record')}")
    doubts = summaries(tally.doubts, tally.n_record - tally.n_rejected - tally.n_empty)
    tell(*tally.sentences(), *(f"warning: {summary}" for summary in doubts))
    if chosen != "table":
        tell(*tally.unmeasured())
    return int(tally.is_lacking)


def _measures(columns: Sequence[MeasuredOutput], records: Iterator[RecordMeasures]) -> Iterator[Any]:
    """The first records, and how many there are."""
    from hydrofdi.report.measures import measures_table, upright

    shown = [*islice(records, _MOST_ROWS)]
    n_record = len(shown) + sum(1 for _ in records)
    reasons = Counter(item for record in shown for item in record.reasons.items())
    notes = [f"{label}: not measured in {n} of {len(shown)}: {why}" for (label, why), n in reasons.items()]
    table = measures_table(columns, shown, notes)
    yield upright(table, columns) if len(shown) <= _FEW_RECORDS else table
    for column in columns:
        if column.output.dims:
            yield f"{column.name}: {counted(column.size, 'number')} for each record, in files"
        elif " at " in column.output.long_name and column.output.unit == "m^3/s":
            yield f"{column.name}: {column.output.long_name}"
    if n_record > len(shown):
        yield f"… the first {len(shown)} of {counted(n_record, 'record')}; --out FILE.csv writes all"
    elif n_record != 1:
        yield counted(n_record, "record")


def diagnose(
    sources: Sources,
    history: Annotated[
        list[str] | None,
        typer.Option(metavar="SOURCE", help="Healthy records of the same machine; repeat it for several."),
    ] = None,
    **settings: Any,
) -> Found:
    """Name the fault that records show: which, how probable, how large, and what else it may be.

    Compares with healthy records of the same machine: --history, or those with a healthy label; else with the
    data sheet. Needs P1, x, and u or xv; P2 tells much more. Exit code 1 if a record could not be judged.
    """
    from hydrofdi.tables.answer import Reply

    found = hydrofdi.diagnose(sources, history or None, **settings)
    warnings = [f"warning: {remark}" for remark in found.remarks]
    are_judged = all(record.findings for record in found.records)
    return Reply(found.to_dict(), _diagnosis(found), warnings, are_judged)


def _diagnosis(found: hydrofdi.Diagnosis) -> Iterator[Any]:
    """The table, and of the first records with each fault what else it looks like, and what to do."""
    from hydrofdi.settings.messages import percent
    from hydrofdi.tables.answer import Strong

    history = f"{counted(found.n_healthy, 'healthy record')} of it" if found.n_healthy else "its data sheet"
    yield f"Sensors {found.sensors}; the machine is compared with {history}."
    yield "In parentheses: 95 % interval of the size; leaks at 8 MPa."
    if len(found.table):
        yield from ("", replace(found.table, most=_MOST_ROWS))
    for record in found.records:
        if record.reason:
            yield f"{record.record_id}: not judged: {record.reason}"
    faults = {each.name: each for each in reversed(found.records) if each.name not in ("", "healthy")}
    if not faults and found.counts:
        yield from ("", Strong("Nothing is wrong that could be seen."))
    elif sum(found.counts.values()) > 1:
        titles = {each.name: each.title for record in found.records for each in record.findings}
        yield from ("", Strong("; ".join(f"{titles[name]}: {n}" for name, n in found.counts.items())))
    healthy = next((each for each in found.records if each.name == "healthy"), None)
    if healthy:
        yield f"Would have been seen from this size on: {found.visible_text(healthy)}"
    for record in [*reversed(faults.values())][:_MOST_FAULTS]:
        finding, titles = record.findings[0], {each.name: each.title for each in record.findings}
        sure = "above 99.9 %" if finding.low > 0.999 else f"{percent(finding.low)} to {percent(finding.high)}"
        yield from ("", Strong(f"{record.record_id}: {finding.title}, probability {sure}."))
        if finding.name == "none_of_these":
            yield f"The nearest of these: {titles[finding.looks_like[0]]}."
        elif finding.looks_like:
            alike = "; ".join(
                titles[name]
                + (f" (told apart by: {finding.told_by[name]})" if name in finding.told_by else "")
                for name in finding.looks_like
            )
            yield f"These sensors do not tell it from: {alike}."
        if finding.advice:
            yield f"Next: {finding.advice}."


def evaluate(sources: Sources, **settings: Any) -> Found:
    """Evaluate indicators on labelled records.

    Shows what each detects, and its alarms on healthy groups. Labels and groups come from the descriptions.
    Healthy groups are tested at the threshold of the other healthy groups, and compared with each other as if
    they were faulty. If there are too few records for a result, the output says how many are needed. Scores
    made of several numbers are cross-fitted: no record is scored by a model that saw it or its group. Exit
    code 1 if records are rejected, repeat the samples of another or have no number of any indicator, or an
    indicator fails.
    """
    return hydrofdi.evaluate(sources, **settings)


def export(
    sources: Sources,
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE|DIR",
            help="A .csv, .parquet or .mat file for one record; otherwise a folder with a file for each.",
        ),
    ],
    **settings: Any,
) -> int:
    """Write signals as CSV, Parquet or MAT.

    One file for each record. Headers state units, as in time [s], P1 [Pa]; measure, inspect and monitor read
    such files without a description. Exit code 1 if records are left out.
    """
    done = hydrofdi.export(sources, out, **settings)
    tell(*done.parts())
    return int(not done)
