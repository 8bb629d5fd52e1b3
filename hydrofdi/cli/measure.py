"""``hydrofdi measure``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hydrofdi.cli.options import Json, SamplingFrequency
from hydrofdi.errors import ConfigError
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.indicators.plausibility import Doubt
    from hydrofdi.indicators.record_measures import Column, RecordMeasures


_SHOWN = 20
"""Most records that the terminal shows."""


def measure(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="A results folder, an experiment file (.h5, or .yaml to be simulated), a description of"
            " measured files, or one data file.",
        ),
    ],
    indicators: Annotated[
        str,
        typer.Option(metavar="NAME,…|FILE", help="Indicators, 'all', or a YAML file with their options."),
    ] = "dwt",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write to a file; its suffix sets the format.")
    ] = None,
    form: Annotated[
        Literal["table", "csv", "json", "parquet"] | None,
        typer.Option("--format", help="Output format [default: table]."),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Measure indicators of any records, simulated or measured.

    Exit code 1 if records are rejected or have no number of any indicator, or an indicator fails.
    'hydrofdi indicators' lists what can be measured.
    """
    from hydrofdi.api.measuring import measured_records
    from hydrofdi.api.records.sources import Said
    from hydrofdi.cli.terminal import tell

    chosen_form = _form("json" if json else form, out)
    measured = measured_records(sources, indicators, Said(sampling_frequency))
    for remark in measured.remarks:
        tell(f"warning: {remark}")
    tally = _Counted(measured.records)
    _write(chosen_form, out, measured.columns, tally)
    _tell(tally, out, with_reason=chosen_form != "table")
    return 1 if tally.n_rejected or tally.n_empty or tally.faults else 0


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


class _Counted:
    """Records that are counted while they are read."""

    def __init__(self, records: Iterable[RecordMeasures]) -> None:
        self._records = records
        self.n_record = self.n_rejected = self.n_unmeasured = self.n_empty = 0
        self.first_reason = self.first_rejection = ""
        self.faults: dict[str, None] = {}
        self.doubts: list[Doubt] = []

    def __iter__(self) -> Iterator[RecordMeasures]:
        for record in self._records:
            self.n_record += 1
            self.n_rejected += record.is_rejected
            self.n_empty += not (record.is_rejected or record.has_numbers)
            self.faults |= dict.fromkeys(record.faults.values())
            self.doubts += record.doubts
            others = [(label, text) for label, text in record.reasons.items() if label not in record.faults]
            for label, reason in others[:1]:
                if record.is_rejected:
                    self.first_rejection = self.first_rejection or f"{record.record_id}: {reason}"
                else:
                    self.n_unmeasured += 1
                    self.first_reason = self.first_reason or f"{label}: {reason}"
            yield record


def _write(form: str, out: Path | None, columns: Sequence[Column], records: _Counted) -> None:
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


def _print(columns: Sequence[Column], records: _Counted) -> None:
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


def _tell(tally: _Counted, out: Path | None, *, with_reason: bool) -> None:
    from hydrofdi.cli.terminal import tell
    from hydrofdi.indicators.plausibility import summaries

    if out is not None:
        tell(f"wrote {out}: {counted(tally.n_record, 'record')}")
    for fault in tally.faults:
        tell(f"failed: {fault}")
    for summary in summaries(tally.doubts, tally.n_record - tally.n_rejected - tally.n_empty):
        tell(f"warning: {summary}")
    if tally.n_unmeasured and with_reason:
        tell(
            f"without some numbers: {counted(tally.n_unmeasured, 'record')}; the first: {tally.first_reason}"
        )
    if tally.n_rejected:
        tell(
            f"rejected: {tally.n_rejected:,} of {counted(tally.n_record, 'record')}; {tally.first_rejection}"
        )
