"""Write the second half of docs/indicators.md from the indicators themselves.

::

    python docs/generate_indicators.py           write it (also: make docs)
    python docs/generate_indicators.py --check   fail if it is not what would be written (make check)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

from hydrofdi.indicators import indicator_names
from hydrofdi.indicators.description import Description, describe
from hydrofdi.indicators.registry import GROUP

PAGE = Path(__file__).parent / "indicators.md"

MARK = "<!-- written by docs/generate_indicators.py from hydrofdi/indicators; change the texts there -->\n"
"""Ends what is written by hand."""


def page() -> str:
    """The text of docs/indicators.md."""
    added = {point.name for point in entry_points(group=GROUP)}
    indicators = [describe(name) for name in indicator_names() if name not in added]
    parts = [*_overview(indicators), *(line for each in indicators for line in _section(each))]
    return PAGE.read_text(encoding="utf-8").partition(MARK)[0] + MARK + "\n" + "\n".join(parts) + "\n"


def _overview(indicators: list[Description]) -> Iterator[str]:
    yield "| indicator | what it measures | channels | outputs | cost | source |"
    yield "|---|---|---|---|---|---|"
    for each in indicators:
        channels = ", ".join(f"`{channel}`" for channel in each.channels)
        cells = f"[`{each.name}`](#{each.name})", each.summary, channels, _names(each), each.cost, each.source
        yield _row(*cells)
    yield (
        "\nCheap indicators cost less than the simulation of the record; `make bench` measures all of them."
        " Channels and outputs are those without options."
    )


def _section(indicator: Description) -> Iterator[str]:
    yield f"\n### {indicator.name}\n\n{indicator.summary}"
    if indicator.equation:
        yield f"\nEquation: {indicator.equation}."
    if indicator.caution:
        yield f"\n**Caution.** {indicator.caution}"
    if indicator.needs_scale:
        yield "\nIt needs channels in SI, not raw counts."
    if indicator.optional_channels:
        optional = ", ".join(f"`{each}`" for each in indicator.optional_channels)
        yield f"\nIt looks at {optional} where a record has it."
    if indicator.options:
        yield "\n| option | default | meaning |\n|---|---|---|"
        for option in indicator.options:
            yield _row(f"`{option.name}`", f"`{option.default}`", option.text.replace("``", "`"))
    yield "\n| output | unit | under leakage | meaning |\n|---|---|---|---|"
    for output in indicator.outputs:
        dims = "".join(f" × {length} {name}" for name, length in output.dims.items())
        yield _row(f"`{output.name}`", output.unit, output.departure, f"{output.long_name}{dims}")


def _names(indicator: Description) -> str:
    names = [f"`{output.name}`" for output in indicator.outputs]
    return ", ".join(names) if len(names) <= 4 else f"{names[0]} … {names[-1]}"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


if __name__ == "__main__":
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(page(), encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != page():
        sys.exit(f"{PAGE.name} is not up to date; run 'make docs'")
