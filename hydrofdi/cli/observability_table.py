"""How well records determine the unknowns of model-based indicators, on the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.text import Text

from hydrofdi.cli.parted_table import PartedTable
from hydrofdi.cli.terminal import terminal
from hydrofdi.report.detection.wording import two_digits
from hydrofdi.settings.readable import readable_unit
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.observability import KnownUnknown, Observability


def print_observability(found: Observability) -> None:
    """Print each unknown before and after a record, the least known direction, and collinear pairs."""
    console = terminal()
    console.print(
        Text(
            f"Standard deviations before and after {found.duration:g} s without a leak: {found.indicator}",
            style="bold",
        )
    )
    if not found.unknowns:
        console.print("nothing: the estimate diverges; do its options fit the actuator?")
        return
    shown = PartedTable(["", "before", "after", "unit"], left=(0, 3))
    for each in found.unknowns:
        shown.add_row(each.name, *_row(each))
    console.print(shown)
    if not any(found.singular_values):
        console.print("the record contains no information on them; does the valve open?")
        return
    console.print(_singular_values(found))
    left = f"{found.weakest_left:.0%} of the prior deviation remains"
    console.print(f"least known: {found.weakest} (in prior deviations): {left}")
    pairs = ", ".join(f"{one} and {other} ({value:+.3f})" for one, other, value in found.collinear)
    console.print(f"collinear: {pairs}" if pairs else "no two unknowns are collinear")


def _row(each: KnownUnknown) -> tuple[str, str, str]:
    unit = "%" if each.unit == "1" else readable_unit(each.unit, each.before)
    scale = 100.0 if unit == "%" else 1.0 if unit == each.unit else convert(1.0, unit)
    return two_digits(each.before * scale), two_digits(each.after * scale), unit.replace("*", "·")


def _singular_values(found: Observability) -> str:
    values = ", ".join(f"{value:.2g}" for value in found.singular_values)
    condition = f"{found.condition:.2g}" if math.isfinite(found.condition) else "infinite"
    return f"singular values of the Gramian: {values}; condition number {condition}"
