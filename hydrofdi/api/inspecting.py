"""First inspection of records: what they contain, and their defects."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api.sources import Described, kind_of, open_records
from hydrofdi.errors import ConfigError, DataError, ReportError
from hydrofdi.fmi.inspection import PlantInspection, inspect_plant
from hydrofdi.indicators.nominal_actuator import constants_not_given
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.records.contents import Contents
from hydrofdi.records.source import write_description
from hydrofdi.settings.arguments import Names, Texts, path_of, refusal
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_SIMULATED = 32
"""Records of an experiment file that are simulated for a first look."""


@dataclass(repr=False)
class Inspection(Contents):
    """Contents and defects of records, as `hydrofdi.inspect` returns them.

    Attributes
    ----------
    n_record, n_rejected : int
        Number of records that can be measured, and of rejected records.
    lengths, sampling_frequencies, drive_periods, groups, labels : counter
        Number of samples, [Hz], [s] (known or found in u; None if there is none), names → number of records.
    ranges : dict of Channel to Range
    remarked : dict of str to Finding
        Kind of a remark, or of a rejection → its records.
    example : RecordBatch or None
        The requested record, or the first.
    assumptions : tuple of str
        A sentence on the constants of the actuator that nobody stated; empty if all are stated.
    """

    def plot(self) -> Figure:
        """Figure of the chosen record, or of the first: its channels.

        Raises
        ------
        ReportError
            No record can be drawn.
        """
        from hydrofdi.report.figures.signals import draw_record

        if self.example is None:
            raise ReportError(f"{self.name}: has no record that can be drawn")
        return draw_record(self.example)


def inspect(
    data: Any,
    *,
    record: str | None = None,
    write: str | PathLike[str] | None = None,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
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
    said = Described(sampling_frequency, channel, unit, label, group)
    if not isinstance(record, str | None):
        raise refusal("record", "the name of a record", record)
    if write is not None:
        (path, *more) = data if isinstance(data, list) else [data]
        if more or (kind := kind_of(path_of(path))) != "measured":
            given = counted(len(more) + 1, "source") if more else f"{path}, which is of kind {kind!r}"
            raise ConfigError(f"write: expected a data file, or a folder of data files; found {given}")
        if "…" in write_description(path_of(path), path_of(write), said.frequency):
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
    from hydrofdi.config.plant import INPUTS, OUTPUTS
    from hydrofdi.store.files import write_whole_text

    plant = inspect_plant(path, INPUTS, OUTPUTS)
    if write is not None:
        if (target := path_of(write)).exists():
            raise ConfigError(f"{target}: exists already; give a new file")
        write_whole_text(target, inspect_plant(path.resolve(), INPUTS, OUTPUTS).proposal)
    return plant
