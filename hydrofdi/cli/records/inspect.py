"""``hydrofdi inspect``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, frequency

if TYPE_CHECKING:
    from hydrofdi.records.overview import Overview, Range


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
    from hydrofdi.cli.records.overview_table import print_overview
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
        print_overview(overview)
    return 1 if overview.n_rejected else 0


def _draw(overview: Overview, path: Path) -> None:
    from hydrofdi.errors import ReportError
    from hydrofdi.report.figures import save_figure
    from hydrofdi.report.figures.record import draw_record

    if overview.example is None:
        raise ReportError(f"{overview.name}: has no record that could be drawn")
    save_figure(draw_record(overview.example), path)


def _as_record(overview: Overview) -> dict[str, Any]:
    return {
        "source": overview.name,
        "records": overview.n_record,
        "rejected": overview.n_rejected,
        "samples": [{"samples": n, "records": count} for n, count in sorted(overview.lengths.items())],
        "sampling_frequencies_Hz": [
            {"frequency": rate, "records": count, "is": "inferred" if overview.is_inferred else "given"}
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
