"""First inspection of unknown records."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from hydrofdi.api.arguments import refusal
from hydrofdi.api.assumed_plant import plant_advice
from hydrofdi.api.page import html_table
from hydrofdi.api.records.held import Names
from hydrofdi.api.records.sources import Said, Texts, joined, sources_of
from hydrofdi.errors import ReportError
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.overview import Overview, Range, look_at
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_SIMULATED = 32
"""Records of an experiment file that are simulated for a first look."""


class Inspection:
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
        from hydrofdi.api.figures import shown
        from hydrofdi.report.figures.record import draw_record

        if self.overview.example is None:
            raise ReportError(f"{self.overview.name}: has no record that can be drawn")
        return shown(draw_record(self.overview.example))

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

    def _lines(self) -> list[tuple[str, ...]]:
        """Channel, unit, lowest, mean and highest value."""
        return [
            (
                channel.value,
                found.shown_unit,
                *(f"{found.shown(each):.4g}" for each in (found.least, found.mean, found.largest)),
            )
            for channel, found in self.overview.channels.items()
        ]

    def _title(self) -> str:
        rates = ", ".join(f"{rate:g} Hz" for rate in self.overview.sampling_frequencies)
        rejected = f", {self.n_rejected:,} rejected" if self.n_rejected else ""
        records = f"{counted(self.n_record, 'record')}{rejected}"
        return f"{self.overview.name}: {records} at {rates or 'no known rate'}"

    def _remark_lines(self) -> list[str]:
        return [
            f"{kind} ({finding.n_record:,}): {finding.examples[0][1]}"
            for kind, finding in self.overview.findings.items()
        ]

    def __repr__(self) -> str:
        lines = [f"  {name} [{unit}]: {least} … {most}" for name, unit, least, _, most in self._lines()]
        return "\n".join([self._title(), *lines, *(f"  remark: {text}" for text in self._remark_lines())])

    def _repr_html_(self) -> str:
        from html import escape

        header = ("channel", "unit", "min", "mean", "max")
        remarks = "".join(f"<p>remark: {escape(text)}</p>" for text in self._remark_lines())
        return html_table(self._lines(), header, caption=self._title()) + remarks


def inspect(
    data: Any,
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
    record : str, optional
        Record of the figure, or the beginning of its name; by default the first.
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
      chamber_1_pressure [bar]: 50 … 51
    """
    said = Said(sampling_frequency, channel, unit, label, group)
    if not isinstance(record, str | None):
        raise refusal("record", "the name of a record", record)
    sources = [_few(source, record) for source in sources_of(data, tuple(Channel), said)]
    overview = look_at(joined(sources), record)
    return Inspection(overview, plant_advice(sources, overview.channels))


def _few(source: RecordSource, record: str | None) -> RecordSource:
    """Some records of an experiment that is simulated now; all records of other sources."""
    if not hasattr(source, "few"):
        return source
    few: RecordSource = source.few(_MOST_SIMULATED, record)
    return few


def _range_record(found: Range) -> dict[str, Any]:
    numbers = {"min": found.least, "mean": found.mean, "max": found.largest}
    finite = {name: value if math.isfinite(value) else None for name, value in numbers.items()}
    return {"unit": found.unit, "records": found.n_record} | finite
