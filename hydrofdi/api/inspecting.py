"""First inspection of unknown records."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hydrofdi.api.arguments import Names, Texts, refusal
from hydrofdi.api.measuring import Indicators, indicators_of, plant_advice
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import Issue, ReportError
from hydrofdi.indicators.record_measures import measure_sources
from hydrofdi.records import Channel
from hydrofdi.records.overview import Finding, Overview, Range, look_at
from hydrofdi.report.table import Table, plain
from hydrofdi.settings.messages import Guessable, counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    numbers = {"min": found.least, "mean": found.mean, "max": found.largest}
    return {"unit": found.unit, "records": found.n_record, **plain(numbers)}
