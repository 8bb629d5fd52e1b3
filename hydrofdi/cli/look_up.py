"""``hydrofdi indicators`` and ``schema``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from hydrofdi.cli.options import Json
from hydrofdi.cli.terminal import answer, facts, print_json, tell, terminal

if TYPE_CHECKING:
    from hydrofdi.indicators.description import Description

_WIDE = 110
"""Width from which the terminal has room for the sources [columns]."""


def indicators(
    name: Annotated[str | None, typer.Argument(help="Indicator to describe, with its options.")] = None,
    json: Json = False,
) -> int:
    """List the indicators, or describe one."""
    from dataclasses import asdict

    from hydrofdi.api.listing import described_indicators
    from hydrofdi.indicators.description import describe

    if name:
        described = describe(name)
        answer(asdict(described), lambda _: _described(described), json=json)
        return 0
    all_that_load, doubts = described_indicators()
    tell(*(f"warning: {doubt}" for doubt in doubts))
    record = {"indicators": [asdict(each) for each in all_that_load]}
    answer(record, lambda _: _listed(all_that_load), json=json)
    return 0


def _listed(indicators: list[Description]) -> Iterator[Any]:
    from hydrofdi.api.listing import indicators_table
    from hydrofdi.records import Channel

    yield indicators_table(indicators, with_sources=terminal().width >= _WIDE)
    used = sorted({channel for each in indicators for channel in each.channels})
    yield "\n" + ", ".join(f"{Channel(channel).symbol}: {channel}" for channel in used)
    yield "'hydrofdi indicators NAME' shows equation, source, options and outputs of one indicator."


def _described(indicator: Description) -> Iterator[Any]:
    from rich.text import Text

    from hydrofdi.report.table import Table

    yield Text(f"{indicator.name}, version {indicator.version}", "bold")
    yield indicator.summary
    yield from facts([
        ("equation", indicator.equation or "–"),
        ("caution", indicator.caution),
        ("source", indicator.source),
        ("channels", ", ".join(indicator.channels)),
        ("optional", ", ".join(indicator.optional_channels)),
        ("cost", indicator.cost),
        ("scale", "needs channels in SI, not raw counts" if indicator.needs_scale else ""),
    ])  # fmt: skip
    options, outputs = indicator.options, indicator.outputs
    dims = ("".join(f" × {n} {name}" for name, n in output.dims.items()) for output in outputs)
    of_options = {
        "option": [option.name for option in options],
        "default": [option.default for option in options],
        "meaning": [option.text.replace("``", "") for option in options],
    }
    of_outputs = {
        "output": [output.name for output in outputs],
        "unit": [output.unit for output in outputs],
        "under leakage": [output.departure for output in outputs],
        "meaning": [output.long_name + more for output, more in zip(outputs, dims, strict=True)],
    }
    yield from ("", Table.of(of_options, title="Options"), "", Table.of(of_outputs, title="Outputs"))


def schema(
    kind: Annotated[
        Literal["experiment", "measured", "monitor", "detector"],
        typer.Argument(help="Kind of file that the schema describes."),
    ] = "experiment",
) -> int:
    """Print the JSON Schema of a kind of file, for editors and programs.

    Experiment files, descriptions of measured files, configurations of 'hydrofdi monitor', and the detector
    files that 'hydrofdi train' writes.
    """
    from hydrofdi.api.schemas import schema as schema_of

    print_json(schema_of(kind))
    return 0
