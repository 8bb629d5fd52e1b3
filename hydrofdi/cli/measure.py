"""``hydrofdi measure``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, Sources
from hydrofdi.errors import ConfigError
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.indicators.record_measures import Column, RecordMeasures


_SHOWN = 20
"""Most records that the terminal shows."""


def measure(
    sources: Sources,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write to a file; its suffix sets the format.")
    ] = None,
    form: Annotated[
        Literal["table", "csv", "json", "parquet"] | None,
        typer.Option("--format", help="Output format [default: table]."),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
    **settings: Any,
) -> int:
    """Measure indicators of any records, simulated or measured.

    Exit code 1 if records are rejected or have no number of any indicator, or an indicator fails.
    'hydrofdi indicators' lists what can be measured.
    """
    from hydrofdi.api.measuring import Counted, measured_records
    from hydrofdi.api.records.sources import Said
    from hydrofdi.cli.terminal import tell
    from hydrofdi.indicators.plausibility import summaries

    chosen_form = _form("json" if json else form, out)
    asked = settings.get("indicators", "dwt")
    columns, records, remarks = measured_records(sources, asked, Said(sampling_frequency))
    for remark in remarks:
        tell(f"warning: {remark}")
    tally = Counted()
    _write(chosen_form, out, columns, tally.count(records))
    if out is not None:
        tell(f"wrote {out}: {counted(tally.n_record, 'record')}")
    for sentence in tally.sentences():
        tell(sentence)
    for summary in summaries(tally.doubts, tally.n_record - tally.n_rejected - tally.n_empty):
        tell(f"warning: {summary}")
    if tally.n_unmeasured and chosen_form != "table":
        unmeasured = counted(tally.n_unmeasured, "record")
        tell(f"without some numbers: {unmeasured}; the first: {tally.first_reason}")
    return int(tally.is_lacking)


def _form(form: str | None, out: Path | None) -> str:
    if out is None:
        if form == "parquet":
            raise ConfigError("--format parquet needs --out FILE")
        return form or "table"
    if form is None:
        suffix = out.suffix.lower().lstrip(".")
        if suffix not in ("csv", "json", "parquet"):
            raise ConfigError(f"--out {out}: name it .csv, .json or .parquet, or give --format")
        return suffix
    if form == "table":
        raise ConfigError("--format table is for the terminal; files are csv, json or parquet")
    return form


def _write(form: str, out: Path | None, columns: Sequence[Column], records: Iterable[RecordMeasures]) -> None:
    if form == "table":
        _print(columns, records)
        return
    from hydrofdi.cli.terminal import write_out
    from hydrofdi.report.forms.measures import csv_lines, json_parts

    lines = csv_lines if form == "csv" else json_parts
    if out is None:
        for line in lines(columns, records):
            write_out(line)
        return
    from hydrofdi.api.measuring import write_measures

    write_measures(out, form, columns, records)


def _print(columns: Sequence[Column], records: Iterable[RecordMeasures]) -> None:
    """Print the first records, and how many there are."""
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.report.forms.measures import measures_table

    console, stream = terminal(), iter(records)
    shown = [*islice(stream, _SHOWN)]
    n_record = len(shown) + sum(1 for _ in stream)
    reasons = Counter(item for record in shown for item in record.reasons.items())
    notes = [f"{label}: not measured in {n} of {len(shown)}: {why}" for (label, why), n in reasons.items()]
    print_table(console, measures_table(columns, shown, notes))
    for column in columns:
        if column.output.dims:
            console.print(f"{column.name}: {counted(column.size, 'number')} for each record, in files")
        elif " at " in column.output.long_name and column.output.unit == "m^3/s":
            console.print(f"{column.name}: {column.output.long_name}", style="dim")
    if n_record > len(shown):
        console.print(f"… the first {len(shown)} of {counted(n_record, 'record')}; --out FILE.csv writes all")
    elif n_record != 1:
        console.print(counted(n_record, "record"))
