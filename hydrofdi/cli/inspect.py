"""``hydrofdi inspect``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, frequency

if TYPE_CHECKING:
    from hydrofdi.records.overview import Overview, Range

_INFERRED = "inferred_sampling"
"""Kind of the remark of records whose sampling frequency nobody documented."""

_MOST_SHOWN = 12
"""Groups and labels that the terminal lists."""

_READABLE = {"Pa": "MPa", "m": "mm", "m/s": "mm/s"}


def inspect(
    source: Annotated[
        Path,
        typer.Argument(
            help="A results folder, an experiment file, a description of measured files, or one data file."
        ),
    ],
    record: Annotated[
        str | None,
        typer.Option(
            metavar="ID", help="Record of the figure, or the beginning of its name [default: the first]."
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw one record: time, spectrum, details (.png, .svg, .pdf)."),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Look at unknown records: channels, rates, lengths, ranges, and what is wrong with them.

    Exit code 1 where records are rejected.
    """
    from hydrofdi.cli.terminal import print_json, tell
    from hydrofdi.pipeline.sources import open_source
    from hydrofdi.records.overview import look_at

    opened = open_source(source, sampling_frequency=frequency(sampling_frequency))
    overview = look_at(opened, record)
    if figure is not None:
        _draw(overview, figure)
        tell(f"drew {figure}")
    if json:
        print_json(_as_record(overview))
    else:
        _print(overview)
    return 1 if overview.n_rejected else 0


def _draw(overview: Overview, path: Path) -> None:
    from hydrofdi.errors import ReportError
    from hydrofdi.report.figures import save_figure
    from hydrofdi.report.figures.record import draw_record

    if overview.example is None:
        raise ReportError(f"{overview.name}: has no record that could be drawn")
    save_figure(draw_record(overview.example), path)


def _as_record(overview: Overview) -> dict[str, Any]:
    inferred = _INFERRED in overview.findings
    return {
        "source": overview.name,
        "records": overview.n_record,
        "rejected": overview.n_rejected,
        "samples": [{"samples": n, "records": count} for n, count in sorted(overview.lengths.items())],
        "sampling_frequencies_Hz": [
            {"frequency": rate, "records": count, "is": "inferred" if inferred else "given"}
            for rate, count in sorted(overview.sampling_frequencies.items())
        ],
        "drive_periods_s": [
            {"period": period, "records": count}
            for period, count in sorted(overview.drive_periods.items(), key=lambda item: item[0] or 0.0)
        ],
        "channels": {channel: _range_record(found) for channel, found in overview.channels.items()},
        "groups": dict(overview.groups),
        "labels": dict(overview.labels),
        "findings": {
            kind: {
                "records": finding.n_record,
                "rejects": finding.is_rejection,
                "examples": [{"record_id": name, "text": text} for name, text in finding.examples],
            }
            for kind, finding in overview.findings.items()
        },
    }


def _range_record(found: Range) -> dict[str, Any]:
    numbers = {"min": found.least, "mean": found.mean, "max": found.largest}
    finite = {name: value if math.isfinite(value) else None for name, value in numbers.items()}
    return {"unit": found.unit, "records": found.n_record} | finite


def _print(overview: Overview) -> None:
    from rich.text import Text

    from hydrofdi.cli.terminal import terminal

    console = terminal()
    console.print(Text(overview.name, style="bold"))
    console.print(_facts(overview))
    if overview.channels:
        console.print(Text("\nChannels", style="bold"))
        console.print(_channel_table(overview))
    if overview.findings:
        console.print(Text("\nRemarks", style="bold"))
        console.print(_finding_table(overview))
    else:
        console.print("\nno remarks")


def _facts(overview: Overview) -> Any:
    rates = _counts({f"{rate:g} Hz": n for rate, n in overview.sampling_frequencies.items()})
    lines = {
        "records": f"{overview.n_record:,}"
        + (f", and {overview.n_rejected:,} rejected" if overview.n_rejected else ""),
        "sampling": rates + (" (inferred)" if _INFERRED in overview.findings else ""),
        "samples": _counts({f"{length:,}": n for length, n in overview.lengths.items()}),
        "drive": _counts(
            {
                "no known period" if period is None else f"period {period:g} s": n
                for period, n in overview.drive_periods.items()
            }
        ),
        "groups": _counts(overview.groups),
        "labels": _counts(overview.labels),
    }
    table = _table(None, None)
    for name, text in lines.items():
        if text:
            table.add_row(name, text)
    return table


def _counts(counted: Any) -> str:
    """What occurs and how often; the number alone where there is one thing."""
    if len(counted) == 1:
        return str(next(iter(counted)))
    shown = [f"{name} ({count:,})" for name, count in list(counted.items())[:_MOST_SHOWN]]
    more = [f"and {len(counted) - _MOST_SHOWN:,} more"] if len(counted) > _MOST_SHOWN else []
    return ", ".join(shown + more)


def _channel_table(overview: Overview) -> Any:
    from hydrofdi.cli.measures_table import number_text
    from hydrofdi.units import convert

    table = _table("channel", "unit", "min", "mean", "max", "records")
    for column in table.columns[2:]:
        column.justify = "right"
    for channel, found in overview.channels.items():
        unit = _READABLE.get(found.unit, found.unit)
        numbers = (found.least, found.mean, found.largest)
        shown = [convert(value, unit) if found.unit in _READABLE else value for value in numbers]
        table.add_row(channel.value, unit, *map(number_text, shown), f"{found.n_record:,}")
    return table


def _finding_table(overview: Overview) -> Any:
    table = _table("remark", "records", "for example")
    table.columns[1].justify = "right"
    for kind, finding in overview.findings.items():
        name = f"{kind} (rejected)" if finding.is_rejection else kind
        record_id, text = finding.examples[0]
        table.add_row(name, f"{finding.n_record:,}", f"{record_id}: {text}")
    return table


def _table(*headers: str | None) -> Any:
    from rich.table import Table

    is_headed = headers[0] is not None
    table = Table(box=None, show_header=is_headed, pad_edge=False, padding=(0, 2, 0, 0))
    for header in headers[:-1]:
        table.add_column(header or "", no_wrap=True)
    table.add_column(headers[-1] or "", overflow="fold")
    return table
