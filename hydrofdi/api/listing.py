"""Lists of indicators."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hydrofdi.api.arguments import refusal
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import indicator_names
from hydrofdi.indicators.description import Description, describe
from hydrofdi.indicators.registry import shadows
from hydrofdi.records import Channel
from hydrofdi.report.table import Table


def indicators(name: str | None = None) -> Any:
    """List all indicators, or describe one, as ``hydrofdi indicators`` does.

    Returns
    -------
    Table or Description
        A row for each indicator: ``name``, ``summary``, ``channels`` that it needs, number of ``outputs``,
        ``cost`` and ``source``. Of one: equation, source, channels, options and outputs.

    Raises
    ------
    ConfigError
        There is no indicator of this name.

    Examples
    --------
    >>> import hydrofdi
    >>> "dwt" in hydrofdi.indicators()["name"]
    True
    >>> [option.name for option in hydrofdi.indicators("dwt").options]
    ['name', 'levels', 'extension', 'boundary', 'phase', 'channel']
    """
    if name is None:
        return indicators_table(described_indicators()[0])
    if not isinstance(name, str):
        raise refusal("name", "the name of an indicator", name)
    return describe(name)


def indicators_table(described: Sequence[Description], *, with_sources: bool = True) -> Table:
    """A row for each indicator."""
    symbols = [" ".join(Channel(name).symbol for name in each.channels) for each in described]
    columns: dict[str, list[Any]] = {
        "name": [each.name for each in described],
        "summary": [each.summary for each in described],
        "channels": symbols,
        "outputs": [len(each.outputs) for each in described],
        "cost": [each.cost for each in described],
    }
    sources = {"source": [each.source for each in described]} if with_sources else {}
    return Table.of(columns | sources, row="indicator")


def described_indicators() -> tuple[list[Description], list[str]]:
    """All indicators, and a sentence on each package whose indicator cannot be used."""
    described, doubts = [], [*shadows()]
    for name in indicator_names():
        try:
            described.append(describe(name))
        except ConfigError as error:
            doubts.append(str(error))
    return described, doubts
