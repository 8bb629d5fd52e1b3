"""``hydrofdi indicators``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Json

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
    from hydrofdi.cli.terminal import print_json, tell
    from hydrofdi.indicators.description import describe

    if name:
        described = describe(name)
        print_json(asdict(described)) if json else _print_one(described)
        return 0
    all_that_load, doubts = described_indicators()
    for doubt in doubts:
        tell(f"warning: {doubt}")
    if json:
        print_json({"indicators": [asdict(each) for each in all_that_load]})
    else:
        _print_all(all_that_load)
    return 0


def _print_all(indicators: list[Description]) -> None:
    from hydrofdi.api.listing import indicators_table
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.records import Channel

    console = terminal()
    print_table(console, indicators_table(indicators, with_sources=console.width >= _WIDE))
    used = sorted({channel for each in indicators for channel in each.channels})
    console.print("\n" + ", ".join(f"{Channel(channel).symbol}: {channel}" for channel in used))
    console.print("'hydrofdi indicators NAME' shows equation, source, options and outputs of one indicator.")


def _print_one(indicator: Description) -> None:
    from rich.text import Text

    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.report.table import Table

    console = terminal()
    console.print(Text(f"{indicator.name}, version {indicator.version}", style="bold"))
    console.print(indicator.summary)
    facts = {
        "equation": indicator.equation or "–",
        "caution": indicator.caution,
        "source": indicator.source,
        "channels": ", ".join(indicator.channels),
        "optional": ", ".join(indicator.optional_channels),
        "cost": indicator.cost,
        "scale": "needs channels in SI, not raw counts" if indicator.needs_scale else "",
    }
    for fact, text in facts.items():
        if text:
            console.print(Text(f"{fact:<10}{text}"))
    options, outputs = indicator.options, indicator.outputs
    dims = ("".join(f" × {n} {name}" for name, n in output.dims.items()) for output in outputs)
    told = {
        "Options": {
            "option": [option.name for option in options],
            "default": [option.default for option in options],
            "meaning": [option.text.replace("``", "") for option in options],
        },
        "Outputs": {
            "output": [output.name for output in outputs],
            "unit": [output.unit for output in outputs],
            "under leakage": [output.departure for output in outputs],
            "meaning": [output.long_name + more for output, more in zip(outputs, dims, strict=True)],
        },
    }
    for title, columns in told.items():
        console.print()
        print_table(console, Table.of(columns, title=title))
