"""``hydrofdi indicators``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.indicators.description import Description


_USUAL = 80
"""Width from which the terminal has room for separate columns [columns]."""

_WIDE = 110
"""Width from which the terminal has room for the sources [columns]."""


def indicators(
    name: Annotated[str | None, typer.Argument(help="Indicator to describe, with its options.")] = None,
    json: Json = False,
) -> int:
    """List the indicators, or describe one."""
    from hydrofdi.api.listing import describe_indicator
    from hydrofdi.cli.terminal import print_json

    described = [describe_indicator(name)] if name else _all_that_load()
    if json:
        records = [_record(each) for each in described]
        print_json(records[0] if name else {"indicators": records})
    elif name:
        _print_one(described[0])
    else:
        _print_all(described)
    return 0


def _all_that_load() -> list[Description]:
    """All indicators; a package that cannot be loaded causes only a warning."""
    from hydrofdi.api.listing import described_indicators
    from hydrofdi.cli.terminal import tell

    described, doubts = described_indicators()
    for doubt in doubts:
        tell(f"warning: {doubt}")
    return described


def _record(indicator: Description) -> dict[str, Any]:
    from dataclasses import asdict

    return asdict(indicator)


def _print_all(indicators: list[Description]) -> None:
    from rich.table import Table

    from hydrofdi.cli.folding import Folded
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.records import Channel

    console = terminal()
    symbols = {each.name: " ".join(Channel(name).symbol for name in each.channels) for each in indicators}
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    if console.width < _USUAL:
        table.add_column("indicator", no_wrap=True)
        table.add_column("what it measures")
        for each in indicators:
            text = (
                f"{each.summary} {counted(len(each.outputs), 'number')} of {symbols[each.name]}, {each.cost}."
            )
            table.add_row(each.name, Folded(text))
    else:
        has_room = console.width >= _WIDE
        table.add_column("indicator", no_wrap=True)
        table.add_column("what it measures", ratio=3)
        table.add_column("of", no_wrap=True)
        table.add_column("numbers", justify="right", no_wrap=True)
        table.add_column("cost", no_wrap=True)
        if has_room:
            table.add_column("source", overflow="fold", ratio=2)
        for each in indicators:
            source = [each.source] if has_room else []
            table.add_row(
                each.name,
                Folded(each.summary),
                symbols[each.name],
                str(len(each.outputs)),
                each.cost,
                *source,
            )
    console.print(table)
    used = sorted({channel for each in indicators for channel in each.channels})
    console.print("\n" + ", ".join(f"{Channel(channel).symbol}: {channel}" for channel in used))
    console.print("'hydrofdi indicators NAME' shows equation, source, options and outputs of one indicator.")


def _print_one(indicator: Description) -> None:
    from rich.table import Table
    from rich.text import Text

    from hydrofdi.cli.terminal import terminal

    console = terminal()
    console.print(Text(f"{indicator.name}, version {indicator.version}", style="bold"))
    console.print(indicator.summary)
    facts = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    facts.add_column(no_wrap=True)
    facts.add_column(overflow="fold")
    facts.add_row("equation", indicator.equation or "–")
    if indicator.caution:
        facts.add_row("caution", indicator.caution)
    facts.add_row("source", indicator.source)
    facts.add_row("channels", ", ".join(indicator.channels))
    if indicator.optional_channels:
        facts.add_row("optional", ", ".join(indicator.optional_channels))
    facts.add_row("cost", indicator.cost)
    if indicator.needs_scale:
        facts.add_row("scale", "needs channels in SI, not raw counts")
    console.print(facts)
    console.print(Text("\nOptions", style="bold"))
    options = _table("option", "default", "meaning")
    for option in indicator.options:
        options.add_row(option.name, option.default, option.text.replace("``", ""))
    console.print(options if indicator.options else "none")
    console.print(Text("\nOutputs", style="bold"))
    outputs = _table("output", "unit", "under leakage", "meaning")
    for output in indicator.outputs:
        dims = "".join(f" × {length} {name}" for name, length in output.dims.items())
        outputs.add_row(output.name, output.unit, output.departure, output.long_name + dims)
    console.print(outputs)


def _table(*headers: str) -> Any:
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for header in headers[:-1]:
        table.add_column(header, no_wrap=True)
    table.add_column(headers[-1], overflow="fold")
    return table
