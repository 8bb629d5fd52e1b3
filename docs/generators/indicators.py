"""The page of all indicators: channels, equations, options and outputs."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from importlib.metadata import entry_points
from itertools import groupby
from pathlib import Path

from generators.writing import table, write_page
from hydrofdi.indicators import indicator_names
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.registry import GROUP, Description, Option, describe
from hydrofdi.settings.messages import typeset

INTRODUCTION = """\
# All indicators

[Indicators](../indicators.md) shows how they are measured, and how to add your own. Cheap ones cost less
than the simulation of the record. Channels are those without options; those marked SI cannot be in counts.
An arrow shows how a leak moves an output.
"""


def write(reference: Path) -> None:
    """Write ``reference/indicators.md``."""
    added = {point.name for point in entry_points(group=GROUP)}
    indicators = [describe(name) for name in indicator_names() if name not in added]
    shared = _Shared(indicators)
    head = ("indicator", "what it measures", "channels", "cost")
    parts = [INTRODUCTION, table(head, [_row(each) for each in indicators]), *shared.tables()]
    parts += [line for each in indicators for line in _section(each, shared)]
    write_page(reference / "indicators.md", "\n".join(parts) + "\n")


def _row(indicator: Description) -> tuple[str, ...]:
    channels = ", ".join(f"`{channel}`" for channel in indicator.channels) + " (SI)" * indicator.needs_scale
    return f"[`{indicator.name}`](#{indicator.name})", indicator.summary, channels, indicator.cost


class _Shared:
    """Options and outputs that several indicators have with the same text: they stand in two tables, once."""

    def __init__(self, indicators: list[Description]) -> None:
        self.options = _common((option.name, option.text) for each in indicators for option in each.options)
        self.outputs = _common((out.name, _meaning(out)) for each in indicators for out in each.outputs)
        self._indicators = indicators

    def default(self, name: str) -> str:
        """The most frequent default of a shared option."""
        options = (each for indicator in self._indicators for each in indicator.options if each.name == name)
        return Counter(each.default for each in options if self.has_option(each)).most_common(1)[0][0]

    def has_option(self, option: Option) -> bool:
        return self.options.get(option.name) == option.text

    def has_output(self, output: Output) -> bool:
        return self.outputs.get(output.name) == _meaning(output)

    def tables(self) -> Iterator[str]:
        yield "\n## Shared options\n\nOptions of several indicators, with the usual default:\n"
        yield from (_option(name, self.default(name), text) for name, text in self.options.items())
        yield "\n## Shared outputs\n"
        units = {out.name: typeset(out.unit) for each in self._indicators for out in each.outputs}
        yield from (f"- `{name}` [{units[name]}]: {meaning}" for name, meaning in self.outputs.items())


def _common(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Name → text of the pairs that occur at least twice, the most frequent text of each name."""
    counts = Counter(pairs).most_common()
    return dict(reversed([(name, text) for (name, text), count in reversed(counts) if count > 1]))


def _section(indicator: Description, shared: _Shared) -> Iterator[str]:
    yield f"\n## {indicator.name}\n"
    if indicator.equation:
        yield f"Equation: {indicator.equation}."
    yield f"Source: {indicator.source}."
    if indicator.caution:
        yield f"\n**Caution.** {indicator.caution}"
    if indicator.optional_channels:
        yield f"\nOptional channels: {', '.join(f'`{each}`' for each in indicator.optional_channels)}."
    if indicator.options:
        yield "\nOptions:\n"
    others = {each.name: each.default for each in indicator.options if shared.has_option(each)}
    if others:
        unusual = {
            name: f" ({default})" * (default != shared.default(name)) for name, default in others.items()
        }
        yield f"- [shared](#shared-options): {', '.join(f'`{name}`{own}' for name, own in unusual.items())}"
    own = [option for option in indicator.options if not shared.has_option(option)]
    yield from (_option(option.name, option.default, option.text) for option in own)
    yield "\nOutputs:\n"
    if common := [output for output in indicator.outputs if shared.has_output(output)]:
        yield f"- [shared](#shared-outputs): {', '.join(f'`{out.name}`{_arrow(out)}' for out in common)}"
    own_outputs = (out for out in indicator.outputs if not shared.has_output(out))
    for _, alike in groupby(own_outputs, lambda out: _DIGITS.sub("#", f"{out.name} {_meaning(out)}")):
        first, *rest = alike
        names = f"`{first.name}`{f' … `{rest[-1].name}`' if rest else ''}"
        unit = typeset(first.unit)
        yield f"- {names}{_arrow(first)} [{unit}]: {_meaning(first)}{', and so on' if rest else ''}"


_DIGITS = re.compile(r"\d+")


def _option(name: str, default: str, text: str) -> str:
    return f"- `{name}` (`{default}`): {text.replace('``', '`')}"


def _arrow(output: Output) -> str:
    return {"rises": "↑", "falls": "↓", "departs": "↕"}.get(output.departure, "")


def _meaning(output: Output) -> str:
    return output.long_name + "".join(f" × {length} {name}" for name, length in output.dims.items())
