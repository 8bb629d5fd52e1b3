"""Objects with records, as sources: paths, results, arrays, data frames, datasets."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np

from hydrofdi.api.arguments import positive_of, refusal
from hydrofdi.api.places import path_of
from hydrofdi.api.records.columns import held, known_text
from hydrofdi.api.records.held import Names, records_of
from hydrofdi.api.records.opened import open_source
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.measured.held import HeldSource
from hydrofdi.settings.counting import counted

Texts = str | Sequence[str] | None
"""One text for all records, or one for each."""


@dataclass(frozen=True)
class Said:
    """Descriptions of data by keywords that `hydrofdi.measure` and others share.

    Attributes
    ----------
    sampling_frequency : str, float or None
        [Hz]
    channel, unit : str, mapping or None
        Of arrays: one name for all columns, or column → name.
    label, group : str, sequence of str or None
        Of records in memory.
    settings : sequence of str
        ``KEY=VALUE`` of an experiment that is simulated.
    """

    sampling_frequency: str | float | None = None
    channel: Names = None
    unit: Names = None
    label: Texts = None
    group: Texts = None
    settings: Sequence[str] = ()

    @property
    def frequency(self) -> float | None:
        """The sampling frequency [Hz]."""
        return frequency_of(self.sampling_frequency)


def sources_of(data: Any, channels: Collection[Channel], said: Said) -> list[RecordSource]:
    """The records in files, results or memory.

    Parameters
    ----------
    data
        As in `hydrofdi.measure`.
    channels : collection of Channel
        What is needed of simulated records.
    said : Said

    Raises
    ------
    ConfigError, DataError, StoreError
        The records cannot be read, or lack names or units.
    """
    parts = _parts(data)
    if all(isinstance(each, str | PathLike) for each in parts):
        _refuse_names(said)
    numbers = range(1, len(parts) + 1) if len(parts) > 1 else [None]
    found = [_source(each, number, channels, said) for each, number in zip(parts, numbers, strict=True)]
    named = iter(_named([source for source in found if isinstance(source, HeldSource)], said))
    return [next(named) if isinstance(source, HeldSource) else source for source in found]


def has_held(sources: Sequence[RecordSource]) -> bool:
    """Whether some records are in memory."""
    return any(isinstance(source, HeldSource) for source in sources)


def _refuse_names(said: Said) -> None:
    for name in ("channel", "unit", "label", "group"):
        if getattr(said, name) is not None:
            raise ConfigError(f"{name}: is for arrays; describe files in a YAML file (docs/measured.md)")


def joined(sources: Sequence[RecordSource]) -> RecordSource:
    """Several sources as one."""
    return sources[0] if len(sources) == 1 else _Joined(sources)


@dataclass(frozen=True)
class _Joined:
    sources: Sequence[RecordSource]

    @property
    def name(self) -> str:
        """All of them."""
        return ", ".join(source.name for source in self.sources)

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """Their batches."""
        for source in self.sources:
            yield from source.batches(labels=labels)


def frequency_of(given: str | float | None) -> float | None:
    """A sampling frequency [Hz].

    Raises
    ------
    ConfigError
        The value is not a frequency above zero.
    """
    if given is None:
        return None
    return positive_of("sampling_frequency", given, "Hz", "a number in Hz, or a text such as '1 kHz'")


def _parts(data: Any) -> list[Any]:
    """The parts of data: several sources in a list, or a single one."""
    if not isinstance(data, list | tuple) or not data:
        return [data]
    are_whole = [isinstance(each, str | PathLike | Mapping) or _is_whole(each) for each in data]
    is_one_array = not any(are_whole) and len({np.shape(each) for each in data}) == 1
    has_numbers = any(
        np.ndim(each) == 0 for each, is_whole in zip(data, are_whole, strict=True) if not is_whole
    )
    return [data] if is_one_array or has_numbers else list(data)


def _is_whole(data: Any) -> bool:
    """Whether data are more than samples: a frame, a dataset, results, an experiment."""
    return any(hasattr(data, name) for name in ("columns", "coords", "record_source", "model_fields"))


def _source(data: Any, number: int | None, channels: Collection[Channel], said: Said) -> RecordSource:
    if isinstance(data, str | PathLike):
        return open_source(path_of(data), channels, said.frequency, said.settings)
    if hasattr(data, "record_source"):
        source: RecordSource = data.record_source(channels)
        return source
    config = sys.modules.get("hydrofdi.config")
    if config is not None and isinstance(data, config.ExperimentConfig):
        from hydrofdi.api.records.simulated import SimulatedRecords

        return SimulatedRecords(data, data.name, channels)
    columns = held(data, number)
    records = records_of(columns, said.frequency, said.channel, said.unit)
    if not records.config.channels.keys() & set(channels):
        names = ", ".join(repr(column.name) for column in columns.columns)
        raise DataError(f"{columns.kind}: has no {' and no '.join(sorted(channels))}; found {names}")
    return records


def _named(sources: Sequence[HeldSource], said: Said) -> list[HeldSource]:
    """Records in memory with labels, groups, and names that differ."""
    n_record = sum(len(source.tables) for source in sources)
    labels, groups = (_texts(name, getattr(said, name), n_record) for name in ("label", "group"))
    named, first = [], 0
    for source in sources:
        tables = []
        for row, table in enumerate(source.tables, first):
            own: dict[str, Any] = (
                {"record_id": str(row)} if len(sources) > 1 and table.record_id.isdecimal() else {}
            )
            own |= ({"label": labels[row]} if labels else {}) | ({"group": groups[row]} if groups else {})
            tables.append(replace(table, **own))
        first += len(tables)
        named.append(replace(source, tables=tables))
    return named


def _texts(name: str, given: Texts, n_record: int) -> list[str]:
    """A text for each record; none if nothing is given."""
    if given is None or isinstance(given, str):
        return [] if given is None else [given] * n_record
    if not isinstance(given, Iterable):
        raise refusal(name, "a text, or one for each record", given)
    texts = [known_text(each) for each in given]
    if len(texts) != n_record:
        raise DataError(f"{name}: found {len(texts)}; expected one for each of {counted(n_record, 'record')}")
    return texts
