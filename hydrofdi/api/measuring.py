"""Indicators of any records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any

import numpy as np

from hydrofdi.api.sources import Names, sources_of
from hydrofdi.api.table import Table
from hydrofdi.indicators.record_measures import Column, RecordMeasures, measure_sources, used_channels
from hydrofdi.indicators.selection import load_indicators, make_indicators
from hydrofdi.settings.yaml_source import plain


def measure(
    data: Any,
    indicators: str | PathLike[str] | Sequence[str] | Mapping[str, Any] = "dwt",
    *,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> Table:
    """Measure indicators of records, as ``hydrofdi measure`` does.

    Parameters
    ----------
    data : path, sequence of path, array_like, mapping, pandas.DataFrame, xarray.DataArray or xarray.Dataset
        Whatever the command takes as a source; or samples of a channel, shape (n_time,) or
        (n_record, n_time), in SI; or columns that are named like channels, ``P1 [bar]`` or
        ``chamber_1_pressure``. Frames and datasets have to state units.
    indicators : str, path, sequence of str, or mapping
        ``"dwt,ring_down"``, ``"all"``, a list of names, a YAML file, or label → options.
    sampling_frequency : str or float, optional
        Such as ``"1 kHz"`` [Hz]; where nothing is named ``time``.
    channel : str or mapping, optional
        Which channel an array is, ``"P1"`` where left out; or column → channel.
    unit : str or mapping, optional
        Of the samples; or column → unit.

    Returns
    -------
    Table
        A row for each record: ``record_id``, ``source``, ``group``, ``label``, ``status``, a column for each
        number such as ``dwt.d2`` (NaN where there is none), and the ``reasons`` why.

    Raises
    ------
    ConfigError, DataError, StoreError
        As the command says it.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> time = numpy.arange(2048) / 1000.0
    >>> pressure = 5e6 + 1e5 * numpy.sin(2.0 * numpy.pi * 50.0 * time)
    >>> table = hydrofdi.measure(pressure, "dwt", sampling_frequency="1 kHz")
    >>> table["dwt.d4"] > table["dwt.d1"], table.units["dwt.d4"]
    (array([ True]), 'Pa')
    >>> hydrofdi.measure(pressure)
    Traceback (most recent call last):
    hydrofdi.errors.DataError: the array: no sampling frequency is given (sampling_frequency='1 kHz'), ...
    """
    chosen = _indicators(indicators)
    sources = sources_of(data, used_channels(chosen), sampling_frequency, channel, unit)
    columns, records = measure_sources(sources, chosen)
    return _table(columns, [*records])


def _indicators(given: str | PathLike[str] | Sequence[str] | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(given, str | PathLike):
        return load_indicators(fspath(given))
    return make_indicators(plain(given))


def _table(columns: Sequence[Column], records: Sequence[RecordMeasures]) -> Table:
    texts = ("record_id", "source", "group", "label", "status")
    content: dict[str, Any] = {name: [getattr(record, name) for record in records] for name in texts}
    for column in columns:
        nothing = np.full(tuple(column.output.dims.values()), np.nan)
        held = [record.values.get(column.name, nothing) for record in records]
        content[column.name] = np.array(held, dtype=float).reshape(len(records), *nothing.shape)
    content["reasons"] = [_sentence(record) for record in records]
    dims = {each.name: tuple(f"{each.label}.{dim}" for dim in each.output.dims) for each in columns}
    return Table("record", content, {each.name: each.unit for each in columns if each.unit != "1"}, dims)


def _sentence(record: RecordMeasures) -> str:
    return "; ".join(f"{label}: {reason}" for label, reason in record.reasons.items())
