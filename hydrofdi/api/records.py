"""What records contain, indicators of them, and what these assume of the plant; an FMU, too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack

from hydrofdi.api.sources import Described, LabelledSamples, kind_of, open_records
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators.faults import summaries
from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures, measure_sources, used_channels
from hydrofdi.indicators.nominal_actuator import constants_not_given
from hydrofdi.indicators.registry import Description, describe, indicator_names
from hydrofdi.indicators.selection import (
    Indicators,
    assumed_plants,
    indicators_of,
    make_indicators,
    of_machine,
)
from hydrofdi.records import Channel
from hydrofdi.records.files import selection
from hydrofdi.records.source import write_description
from hydrofdi.report.inspection import Inspection
from hydrofdi.report.measures import measures_table
from hydrofdi.settings.arguments import Texts, names_of, path_of, refusal
from hydrofdi.settings.files import write_new
from hydrofdi.settings.messages import counted
from hydrofdi.tables.table import Table

if TYPE_CHECKING:
    from hydrofdi.config.plant_inspection import PlantInspection
    from hydrofdi.execution.exporting import Exported


def measure(data: Any, indicators: Indicators = "dwt", **samples: Unpack[LabelledSamples]) -> Table:
    """Measure indicators of records, as ``hydrofdi measure`` does.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Any source that the command accepts; or runs and results; or samples of a channel, shape (n_time,)
        or (n_record, n_time), in SI; or columns that are named like channels, ``P1 [bar]`` or
        ``chamber_1_pressure``. Data frames and datasets (pandas, xarray) must state units.
    indicators : str, path, sequence of str, or mapping
        Such as ``dwt,ring_down``; ``all``, or a YAML file with their options. In Python also a list of names,
        or label → options.
    sampling_frequency : str or float, optional
        Such as ``"1 kHz"`` [Hz]; where nothing is named ``time``.
    channel : str or mapping, optional
        Which channel an array is, ``"P1"`` by default; or column → channel.
    unit : str or mapping, optional
        Of the samples; or column → unit.
    label, group : str or sequence of str, optional
        What is known of each record in memory, such as ``"healthy"``; and the unit or day that it shares with
        others. Of a dataset, the coordinates ``label`` and ``group``.

    Returns
    -------
    Table
        A row for each record: ``record_id``, ``source``, ``group``, ``label``, ``status``, a column for each
        number such as ``dwt.d2`` (NaN if there is none), and the ``reasons`` why. Its `remarks` name the
        constants of the plant that nobody gave, estimates that are physically impossible, and models that do
        not explain the records.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

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
    said = Described(**samples)
    columns, measured, remarks = measured_records(data, indicators, said)
    records = [*measured]
    doubts = [doubt for record in records for doubt in record.doubts]
    doubtful = summaries(doubts, sum(record.has_numbers for record in records))
    return measures_table(columns, records, [*remarks, *doubtful])


def measured_records(
    data: Any, indicators: Indicators, said: Described
) -> tuple[Sequence[MeasuredOutput], Iterator[RecordMeasures], tuple[str, ...]]:
    """Columns, records that are measured as they are asked for, and remarks on all numbers, of `measure`."""
    chosen = indicators_of(indicators)
    sources = open_records(data, used_channels(chosen), said)
    chosen = of_machine(chosen, sources)
    return *measure_sources(sources, chosen), assumed_plants(chosen)


def write_measures(
    path: Path, form: str, columns: Sequence[MeasuredOutput], records: Iterable[RecordMeasures]
) -> None:
    """Write what was measured, whole or not at all, as ``csv``, ``json`` or ``parquet``."""
    from hydrofdi.report.measures import OWN, csv_lines, json_parts, write_parquet
    from hydrofdi.store.files import require_own, whole_file

    require_own(path, OWN[form], "a table of measured indicators")
    with whole_file(path) as aside:
        if form == "parquet":
            write_parquet(aside, columns, records)
        else:
            with open(aside, "w", encoding="utf-8", newline="") as file:
                file.writelines((csv_lines if form == "csv" else json_parts)(columns, records))


def indicators(name: str | None = None) -> Any:
    """List all indicators, or describe one, as ``hydrofdi indicators`` does.

    Returns
    -------
    Table or Description
        A row for each indicator: ``name``, ``summary``, ``channels`` that it needs, number of ``outputs`` and
        ``cost``. Of one: equation, source, channels, options and outputs.

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
        return indicators_table([describe(each) for each in indicator_names()])
    if not isinstance(name, str):
        raise refusal("name", "the name of an indicator", name)
    return describe(name)


def export(
    source: Any,
    path: str | PathLike[str],
    *,
    format: Literal["csv", "parquet", "mat"] | None = None,
    channels: Texts = None,
    unit: Texts = None,
    runs: Texts | Sequence[int] | int = None,
    sampling_frequency: str | float | None = None,
    overwrite: bool = False,
) -> Exported:
    """Write signals as CSV, Parquet or MAT, as ``hydrofdi export`` does.

    Parameters
    ----------
    source : path, sequence of path, array_like, mapping, pandas.DataFrame, xarray.DataArray or xarray.Dataset
        As `hydrofdi.measure` takes it: results with signals, an experiment to be simulated, measured files.
    path : path
        A file ending in ``.csv``, ``.parquet`` or ``.mat`` for one record; otherwise a folder with a file for
        each.
    format : {"csv", "parquet", "mat"}, optional
        Format of files in a folder [default: csv].
    channels : str or sequence of str, optional
        Such as ``P1,P2,x`` [default: all].
    unit : str or sequence of str, optional
        Such as ``bar,mm``, each for the channels of its dimension; the others are in SI.
    runs : str, int or sequence of them, optional
        Simulated runs: positions, ranges such as ``3-9``, or first characters of identities [default: all].
    sampling_frequency : str or float, optional
        Of a data file without a column of time [Hz].
    overwrite : bool
        Replace an existing file, or the files of an earlier export in the folder.

    Returns
    -------
    Exported
        The files, and the records that are left out.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, the records cannot be read or written, or there are none.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.export({"P1 [bar]": [50.0, 50.5], "time [s]": [0.0, 0.01]}, "rig.csv").files[0].read_text()
    'time [s],P1 [Pa]\\n0.0,5000000.0\\n0.01,5050000.0\\n'
    """
    from hydrofdi.execution.exporting import target_of, write_records

    chosen = selection(_texts("channels", channels), _texts("unit", unit))
    wanted = _texts("runs", runs)
    target = target_of(path_of(path), format)
    sources = open_records(source, chosen.channels or tuple(Channel), Described(sampling_frequency))
    return write_records(sources, wanted, chosen, target, overwrite=overwrite)


def _texts(name: str, given: Texts | Sequence[int] | int) -> list[str]:
    """Names, given as a list or in one text with commas; none if nothing is given."""
    if given is None:
        return []
    texts = names_of(name, given, "names, or one text with commas")
    found = [each.strip() for text in texts for each in text.split(",") if each.strip()]
    if not found:
        raise ConfigError(f"{name}: is empty; leave it out for all")
    return found


def indicators_table(described: Sequence[Description]) -> Table:
    """A row for each indicator."""
    symbols = [" ".join(Channel(name).symbol for name in each.channels) for each in described]
    columns: dict[str, list[Any]] = {
        "name": [each.name for each in described],
        "summary": [each.summary for each in described],
        "channels": symbols,
        "outputs": [len(each.outputs) for each in described],
        "cost": [each.cost for each in described],
    }
    return Table.of(columns, row="indicator")


_MOST_SIMULATED = 32
"""Records of an experiment file that are simulated for a first look."""


def inspect(
    data: Any,
    *,
    record: str | None = None,
    write: str | PathLike[str] | None = None,
    **samples: Unpack[LabelledSamples],
) -> Inspection | PlantInspection:
    """Inspect records: channels, rates, lengths, ranges and defects.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. Of an experiment file, at most 32 records are simulated,
        spread evenly over its runs, and the one that `record` names.
    record : str, optional
        Record of the figure, or the beginning of its name [default: the first].
    write : path, optional
        New YAML file for the description of a data file or a folder of them, with what their headers state.
        An ellipsis stands for what is to be completed.
    sampling_frequency, channel, unit, label, group
        Of records in memory, as in `hydrofdi.measure`.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> hydrofdi.inspect({"P1 [bar]": numpy.linspace(50.0, 51.0, 500)}, sampling_frequency="1 kHz")
    the mapping
    records   1
    sampling  1000 Hz
    ...
    Channels
    channel             unit  min  mean  max  records
    chamber_1_pressure  bar    50  50.5   51        1
    ...
    """
    (only, *others) = data if isinstance(data, list) and data else [data]
    if not others and isinstance(only, str | PathLike) and path_of(only).suffix.lower() == ".fmu":
        return _inspected_plant(path_of(only), write)
    said = Described(**samples)
    if not isinstance(record, str | None):
        raise refusal("record", "the name of a record", record)
    if write is not None:
        if others or (kind := kind_of(path_of(only))) != "measured":
            given = counted(len(others) + 1, "source") if others else f"{only}, which is of kind {kind!r}"
            raise ConfigError(f"write: expected a data file, or a folder of data files; found {given}")
        if "…" in write_description(path_of(only), path_of(write), said.frequency):
            raise ConfigError(f"{write}: is written; replace each … in it")
        data, said = write, Described()
    sources: list[Any] = open_records(data, said=said)
    sources = [
        source.few(_MOST_SIMULATED, record) if hasattr(source, "few") else source for source in sources
    ]
    found = Inspection(", ".join(source.name for source in sources))
    for batch in chain.from_iterable(source.batches(labels=True) for source in sources):
        found.add(batch, record)
        for rejected in batch.rejected:
            if record is not None and rejected.record_id == record:
                text = f"record {record} is rejected: {rejected.remark.message}"
                raise DataError(f"{found.name}: {text}")
    if record is not None and found.example is None:
        raise DataError(f"{found.name}: has no record {record!r}; 'hydrofdi measure' lists them")
    stated = set.intersection(*(set(each.data_sheet) for each in sources))
    usable = (each for each in make_indicators("all").values() if each.channels <= found.ranges.keys())
    unknown = dict.fromkeys(name for each in usable for name in constants_not_given(each.options))
    if names := ", ".join(name for name in unknown if name not in stated):
        found.assumptions = (
            "for a leak in L/min state your machine under 'actuator:' of a description (docs/measured.md):"
            f" {names}; else balances and observers assume the actuator of the paper",
        )
    return found


def _inspected_plant(path: Path, write: str | PathLike[str] | None) -> PlantInspection:
    from hydrofdi.config.plant_inspection import inspect_plant

    plant = inspect_plant(path)
    if write is not None:
        write_new(path_of(write), inspect_plant(path.resolve()).proposal)
    return plant
