"""First inspection of records, their indicators, and what these assume of the plant."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.api.arguments import Names, Texts, refusal
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import ConfigError, Issue, ReportError
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.faults import summaries
from hydrofdi.indicators.nominal_actuator import constants_not_given, plant_constants
from hydrofdi.indicators.record_measures import Column, RecordMeasures, measure_sources, used_channels
from hydrofdi.indicators.registry import Description, describe, indicator_names, shadows, sound_indicator
from hydrofdi.indicators.selection import load_indicators, make_indicators
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.measured.source import HeldSource, MeasuredSource
from hydrofdi.records.overview import Finding, Overview, Range, look_at
from hydrofdi.report.forms.measures import measures_table
from hydrofdi.report.table import Table, finite
from hydrofdi.settings.messages import Guessable, brief, counted
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.readable import shown_quantity
from hydrofdi.settings.yaml_source import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Indicators = str | PathLike[str] | Sequence[str] | Mapping[str, Any]
"""``"dwt,ring_down"``, ``"all"``, a list of names, a YAML file, or label → options."""


def measure(
    data: Any,
    indicators: Indicators = "dwt",
    *,
    options: Mapping[str, Any] | None = None,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
) -> Table:
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
    options : mapping, optional
        Options of one named indicator, such as ``{"spool": "command"}``.
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
    said = Said(sampling_frequency, channel, unit, label, group)
    columns, measured, remarks = measured_records(data, with_options(indicators, options), said)
    records = [*measured]
    doubts = [doubt for record in records for doubt in record.doubts]
    doubtful = summaries(doubts, sum(record.has_numbers for record in records))
    return measures_table(columns, records, [*remarks, *doubtful])


@dataclass
class Counted:
    """What became of measured records: numbers of them, the first reasons, faulty indicators and doubts."""

    n_record: int = 0
    n_rejected: int = 0
    n_empty: int = 0
    n_unmeasured: int = 0
    first_rejection: str = ""
    first_reason: str = ""
    faults: dict[str, None] = field(default_factory=dict)
    doubts: list[Issue] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come."""
        for record in records:
            self.n_record += 1
            self.n_rejected += record.is_rejected
            self.n_empty += not (record.is_rejected or record.has_numbers)
            self.faults |= dict.fromkeys(record.faults.values())
            self.doubts += record.doubts
            others = ((label, text) for label, text in record.reasons.items() if label not in record.faults)
            label, reason = next(others, ("", record.status))
            if record.is_rejected:
                self.first_rejection = self.first_rejection or f"{record.record_id}: {reason}"
            elif label:
                self.n_unmeasured += 1
                self.first_reason = self.first_reason or f"{label}: {reason}"
            yield record

    @property
    def is_lacking(self) -> bool:
        """Whether records could not be measured, or an indicator failed."""
        return bool(self.n_rejected or self.n_empty or self.faults)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records without numbers."""
        yield from (f"failed: {fault}" for fault in self.faults)
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_rejected:
            yield f"rejected: {self.n_rejected:,} {of}; {self.first_rejection}"
        if self.n_empty:
            yield f"without any number: {self.n_empty:,} {of}"


def measured_records(
    data: Any, indicators: Indicators, said: Said
) -> tuple[Sequence[Column], Iterator[RecordMeasures], tuple[str, ...]]:
    """Columns, records that are measured as they are asked for, and remarks on all numbers, of `measure`.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.
    """
    chosen = indicators_of(indicators)
    sources = sources_of(data, used_channels(chosen), said)
    return *measure_sources(sources, chosen), assumed_plants(sources, chosen)


def write_measures(
    path: Path, form: str, columns: Sequence[Column], records: Iterable[RecordMeasures]
) -> None:
    """Write what was measured, whole or not at all, as ``csv``, ``json`` or ``parquet``.

    Raises
    ------
    ReportError, StoreError
        The file cannot be written or belongs to something else, or a library is not installed.
    """
    from hydrofdi.report.forms.measures import OWN, csv_lines, json_parts, write_parquet
    from hydrofdi.store.files import require_own, whole_file

    require_own(path, OWN[form], "a table of measured indicators")
    with whole_file(path) as aside:
        if form == "parquet":
            write_parquet(aside, columns, records)
        else:
            with open(aside, "w", encoding="utf-8", newline="") as file:
                file.writelines((csv_lines if form == "csv" else json_parts)(columns, records))


def with_options(indicators: Indicators, options: Mapping[str, Any] | None) -> Indicators:
    """An indicator with its options as label → options; indicators as they are if no options are given.

    Raises
    ------
    ConfigError
        Options are given, but not with the name of one indicator.
    """
    if options is None:
        return indicators
    if not isinstance(options, Mapping):
        raise refusal("options", "option → value", options)
    if indicators not in indicator_names():
        raise ConfigError(
            f"options: are for one named indicator; found indicators={brief(indicators)}; write"
            " indicators={'dwt': {…}, …}"
        )
    return {str(indicators): options}


def indicators_of(given: Indicators) -> dict[str, Any]:
    """Label → indicator.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    if isinstance(given, int | float):
        raise ConfigError(f"indicators: found {given!r}; is it meant as sampling_frequency={given!r}?")
    if isinstance(given, str | PathLike):
        return load_indicators(fspath(given))
    return make_indicators(plain(given))


def assumed_constants(sources: Sequence[RecordSource], options: Section) -> tuple[str, ...]:
    """Constants of the plant that nobody gave; none if all records are simulated."""
    return constants_not_given(options) if any(map(_is_measured, sources)) else ()


def _is_measured(source: RecordSource) -> bool:
    if isinstance(source, HeldSource):
        return not source.is_simulated
    return isinstance(source, MeasuredSource)


def assumed_plants(
    sources: Sequence[RecordSource], indicators: Mapping[str, Indicator[Any]]
) -> tuple[str, ...]:
    """A sentence for each set of indicators that assume the same constants of the plant."""
    labels: dict[tuple[str, ...], list[str]] = {}
    for label, indicator in indicators.items():
        if names := assumed_constants(sources, indicator.options):
            labels.setdefault(names, []).append(label)
    return tuple(assumption_text(", ".join(of), names) for names, of in labels.items())


def plant_advice(sources: Sequence[RecordSource], channels: Collection[Channel]) -> tuple[str, ...]:
    """What the indicators that can use these channels assume of the plant; at most one sentence."""
    labels: list[str] = []
    names: dict[str, None] = {}
    for label, usual in make_indicators("all").items():
        for indicator, text in ((usual, label), (_by_command(usual), f"{label} (spool: command)")):
            own = () if indicator is None else assumed_constants(sources, indicator.options)
            if indicator is not None and own and indicator.channels <= set(channels):
                labels.append(text)
                names |= dict.fromkeys(own)
                break
    if not labels:
        return ()
    return (
        f"{', '.join(labels)} take {', '.join(names)} of your actuator as options; without them they assume"
        " the nominal actuator of the paper",
    )


def _by_command(indicator: Indicator[Any]) -> Indicator[Any] | None:
    """The same with the spool position from the input voltage; None if it has no such option."""
    if getattr(indicator.options, "spool", "") != "measured":
        return None
    return sound_indicator(indicator.name, {"spool": "command"})


def assumption_text(label: str, names: Sequence[str]) -> str:
    """The sentence that names constants which nobody gave."""
    are = "is" if len(names) == 1 else "are"
    them = f"it as an option of {label}" if len(names) == 1 else f"them as options of {label}"
    return (
        f"{label}: {', '.join(names)} {are} not given; the nominal actuator of the paper is assumed, so the"
        f" numbers may be wrong for yours; give {them}"
    )


def constants_text(options: Section) -> str:
    """The constants of the plant with their values, ``piston_area = 633 mm^2``; empty if there are none."""
    return ", ".join(
        f"{name} = {shown_quantity(getattr(options, name), unit)}"
        for name, unit in plant_constants(options).items()
    )


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


_MOST_SIMULATED = 32
"""Records of an experiment file that are simulated for a first look."""


class Inspection(Guessable):
    """Contents and defects of records, as `hydrofdi.inspect` returns them.

    Attributes
    ----------
    overview : Overview
        Counts, ranges and remarks, in SI.
    assumptions : tuple of str
        What indicators assume of the actuator behind measured records.
    """

    def __init__(self, overview: Overview, assumptions: tuple[str, ...] = ()) -> None:
        self.overview = overview
        self.assumptions = assumptions

    @property
    def n_record(self) -> int:
        """Records that can be measured."""
        return self.overview.n_record

    @property
    def n_rejected(self) -> int:
        """Records that cannot."""
        return self.overview.n_rejected

    @property
    def remarks(self) -> dict[str, int]:
        """Kind of a remark → number of records that have it."""
        return {kind: finding.n_record for kind, finding in self.overview.findings.items()}

    def plot(self) -> Figure:
        """Figure of the chosen record, or of the first: signals, spectra, details.

        Raises
        ------
        ReportError
            No record can be drawn.
        """
        from hydrofdi.report.figures.signals import draw_record

        if self.overview.example is None:
            raise ReportError(f"{self.overview.name}: has no record that can be drawn")
        return draw_record(self.overview.example)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi inspect --json`` prints."""
        overview = self.overview
        frequency_is = "inferred" if overview.is_inferred else "given"
        return {
            "source": overview.name,
            "records": overview.n_record,
            "rejected": overview.n_rejected,
            "samples": [{"samples": n, "records": count} for n, count in sorted(overview.lengths.items())],
            "sampling_frequencies_Hz": [
                {"frequency": rate, "records": count, "is": frequency_is}
                for rate, count in sorted(overview.sampling_frequencies.items())
            ],
            "drive_periods_s": [
                {"period": period, "records": count}
                for period, count in sorted(overview.drive_periods.items(), key=lambda item: item[0] or 0.0)
            ],
            "channels": {channel: _range_record(found) for channel, found in overview.channels.items()},
            "groups": dict(overview.groups),
            "labels": dict(overview.labels),
            "findings": {
                kind: {
                    "records": finding.n_record,
                    "rejects": finding.is_rejection,
                    "examples": [{"record_id": name, "text": text} for name, text in finding.examples],
                }
                for kind, finding in overview.findings.items()
            },
            "assumptions": list(self.assumptions),
        }

    @property
    def channels(self) -> Table:
        """A row for each channel: its range in the ``unit`` of the files, or in one that suits it."""
        found = self.overview.channels
        ranges = {
            "min": [each.shown(each.least) for each in found.values()],
            "mean": [each.shown(each.mean) for each in found.values()],
            "max": [each.shown(each.largest) for each in found.values()],
        }
        return Table.of(
            {
                "channel": [channel.value for channel in found],
                "unit": [each.shown_unit for each in found.values()],
                **ranges,
                "records": [each.n_record for each in found.values()],
            },
            n_lead=2,
            title="Channels",
        )

    @property
    def findings(self) -> Table:
        """A row for each kind of remark: ``records`` that have it, and one as an ``example``."""
        found = self.overview.findings
        examples = [each.examples[0] for each in found.values()]
        return Table.of(
            {
                "remark": [f"{kind}{' (rejected)' * each.is_rejection}" for kind, each in found.items()],
                "records": [each.n_record for each in found.values()],
                "example": [f"{record_id}: {text}" for record_id, text in examples],
            },
            title="Remarks",
        )

    def _title(self) -> str:
        rates = ", ".join(f"{rate:g} Hz" for rate in self.overview.sampling_frequencies)
        rejected = f", {self.n_rejected:,} rejected" if self.n_rejected else ""
        records = f"{counted(self.n_record, 'record')}{rejected}"
        return f"{self.overview.name}: {records} at {rates or 'no known rate'}"

    def __repr__(self) -> str:
        tables = [self.channels, self.findings] if self.overview.findings else [self.channels]
        return "\n\n".join([self._title(), *map(repr, tables)])

    def _repr_html_(self) -> str:
        tables = replace(self.channels, title=self._title()), self.findings
        return "".join(each._repr_html_() for each in tables if len(each))


def inspect(
    data: Any,
    indicators: Indicators | None = None,
    *,
    record: str | None = None,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
) -> Inspection:
    """Inspect records: channels, rates, lengths, ranges and defects.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. Of an experiment file, at most 32 records are simulated,
        spread evenly over its runs, and the one that `record` names.
    indicators : str, list or mapping, optional
        Indicators whose doubts about the records are remarks, too; as in `hydrofdi.measure`.
    record : str, optional
        Record of the figure, or the beginning of its name [default: the first].
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
    the mapping: 1 record at 1000 Hz
    <BLANKLINE>
    Channels
    channel             unit  min  mean  max  records
    chamber_1_pressure  bar    50  50.5   51        1
    """
    said = Said(sampling_frequency, channel, unit, label, group)
    if not isinstance(record, str | None):
        raise refusal("record", "the name of a record", record)
    sources: list[Any] = sources_of(data, tuple(Channel), said)
    sources = [
        source.few(_MOST_SIMULATED, record) if hasattr(source, "few") else source for source in sources
    ]
    overview = look_at(sources, record)
    if indicators is not None:
        for measured in measure_sources(sources, indicators_of(indicators))[1]:
            if measured.doubts:
                remark = Issue("; ".join(doubt.message for doubt in measured.doubts), kind="doubtful")
                overview.findings.setdefault(remark.kind, Finding()).add(measured.record_id, remark)
    return Inspection(overview, plant_advice(sources, overview.channels))


def _range_record(found: Range) -> dict[str, Any]:
    least, mean, largest = map(finite, (found.least, found.mean, found.largest))
    return {"unit": found.unit, "records": found.n_record, "min": least, "mean": mean, "max": largest}
