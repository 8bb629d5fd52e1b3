"""Records: sampled channels of an actuator, from any source. They do not contain its true parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import Issue


class Channel(StrEnum):
    """A measured quantity of an actuator; the value is its name in files. The symbol is read as well."""

    CHAMBER_1_PRESSURE = "chamber_1_pressure"
    CHAMBER_2_PRESSURE = "chamber_2_pressure"
    SUPPLY_PRESSURE = "supply_pressure"
    RETURN_PRESSURE = "return_pressure"
    PISTON_POSITION = "piston_position"
    PISTON_VELOCITY = "piston_velocity"
    SPOOL_POSITION = "spool_position"
    INPUT_VOLTAGE = "input_voltage"
    OIL_TEMPERATURE = "oil_temperature"

    @property
    def unit(self) -> str:
        """SI unit."""
        return _UNITS[self.rpartition("_")[2]]

    @property
    def symbol(self) -> str:
        """Symbol in tables and in headers of plain files."""
        return _SYMBOLS[self]

    @classmethod
    def _missing_(cls, value: object) -> Channel | None:
        return next((channel for channel in cls if channel.symbol == value), None)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: Callable[[Any], Any]) -> dict[str, Any]:
        schema: dict[str, Any] = handler(core)
        own = handler.resolve_ref_schema(schema)  # type: ignore[attr-defined]
        own["enum"] = [*(channel.value for channel in cls), *(channel.symbol for channel in cls)]
        return schema

    @property
    def is_pressure(self) -> bool:
        """Whether it is a pressure."""
        return self.unit == "Pa"


_SYMBOLS = {
    "chamber_1_pressure": "P1", "chamber_2_pressure": "P2", "supply_pressure": "Ps", "return_pressure": "Pr",
    "piston_position": "x", "piston_velocity": "v", "spool_position": "xv", "input_voltage": "u",
    "oil_temperature": "Toil",
}  # fmt: skip

_UNITS = {"pressure": "Pa", "position": "m", "velocity": "m/s", "voltage": "V", "temperature": "K"}


Array = NDArray[np.float64]

INFERRED_SAMPLING = "inferred_sampling"
"""Kind of the remark on records with an undocumented sampling frequency."""


@dataclass(frozen=True)
class RejectedRecord:
    """A record that is not in a batch, and the reason."""

    record_id: str
    source: str
    group: str
    remark: Issue
    label: str = ""


_OF_RECORDS = {"sources": "", "groups": "", "remarks": (), "dates": math.nan}
"""Attribute with one entry per record → the entry of each record if it is omitted."""


@dataclass(frozen=True)
class RecordBatch:
    """Records without the true parameters behind them.

    Attributes
    ----------
    channels : mapping of Channel to ndarray, shape (n_record, n_time)
        In SI; channels in `relative` are in counts of a converter, or divided by a reference.
    sampling_frequency : float
        [Hz]
    record_ids : tuple of str, length n_record
        Unique within a source.
    sources : tuple of str, length n_record
        Origin of each record, for display: a file or a results folder.
    groups : tuple of str, length n_record
        Unit, day, direction: a group must not be split over fit and test. Empty if unknown.
    start_time : float
        Instant of the first sample [s].
    drive_period : float or None
        Period of the drive [s]; None if it is not known, or there is none.
    relative : frozenset of Channel
        Channels without a scale.
    normalized : frozenset of Channel
        Channels of `relative` that were divided by a reference of the same unit; the others are in counts.
    remarks : tuple of tuple of Issue, length n_record
        Findings about each record.
    rejected : tuple of RejectedRecord
        Records that were read with these, but cannot be measured.
    units : mapping of Channel to frozenset of str
        Units of the channels in the files, as written there.
    dates : tuple of float, length n_record
        Instant of the first sample of each record since 1970 [s]; NaN if unknown.
    labels : tuple of str or None
        Label of each record, such as its known condition; None unless a study asked for labels.
    """

    channels: Mapping[Channel, Array]
    sampling_frequency: float
    record_ids: tuple[str, ...]
    sources: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    start_time: float = 0.0
    drive_period: float | None = None
    relative: frozenset[Channel] = frozenset()
    normalized: frozenset[Channel] = frozenset()
    remarks: tuple[tuple[Issue, ...], ...] = ()
    rejected: tuple[RejectedRecord, ...] = ()
    units: Mapping[Channel, frozenset[str]] = field(default_factory=dict)
    dates: tuple[float, ...] = ()
    labels: tuple[str, ...] | None = field(default=None)

    def __post_init__(self) -> None:
        """Fill in what is omitted, and check that all attributes have the same number of records."""
        n_record = self.n_record
        for name, value in _OF_RECORDS.items():
            if not getattr(self, name):
                object.__setattr__(self, name, (value,) * n_record)
        names = _OF_RECORDS if self.labels is None else (*_OF_RECORDS, "labels")
        if any(len(getattr(self, name)) != n_record for name in names):
            raise ValueError("sources, groups, remarks, dates and labels have one entry per record")
        if len({samples.shape for samples in self.channels.values()} | {(n_record, self.n_time)}) > 1:
            raise ValueError("all channels have the shape (n_record, n_time)")

    @property
    def n_record(self) -> int:
        """Number of records."""
        return len(self.record_ids)

    @property
    def n_time(self) -> int:
        """Number of samples of each record."""
        return next((samples.shape[1] for samples in self.channels.values()), 0)

    @property
    def duration(self) -> float:
        """Number of samples over the sampling frequency [s]."""
        return self.n_time / self.sampling_frequency

    @property
    def time(self) -> Array:
        """Sampling instants [s], shape (n_time,)."""
        return self.start_time + np.arange(self.n_time) / self.sampling_frequency

    @property
    def samples_per_period(self) -> int | None:
        """Samples per period of the drive; None if that is not an integer, or the period is unknown."""
        samples = 0.0 if self.drive_period is None else self.drive_period * self.sampling_frequency
        return round(samples) if samples > 0.5 and abs(samples - round(samples)) < 1e-6 else None

    def unit(self, channel: Channel) -> str:
        """Unit of a channel in this batch: its SI unit, ``counts``, or ``1``."""
        if channel not in self.relative:
            return channel.unit
        return "1" if channel in self.normalized else "counts"

    def __getitem__(self, channel: Channel) -> Array:
        """Samples of a channel, shape (n_record, n_time)."""
        return self.channels[channel]

    def rows(self, positions: Sequence[int]) -> RecordBatch:
        """Some of the records, without the rejected ones."""
        chosen, names = list(positions), ("record_ids", *_OF_RECORDS, *["labels"] * (self.labels is not None))
        entries: dict[str, Any] = {name: tuple(getattr(self, name)[row] for row in chosen) for name in names}
        channels = {channel: samples[chosen] for channel, samples in self.channels.items()}
        return replace(self, channels=channels, rejected=(), **entries)

    def window(self, first: int, stop: int | None = None) -> Self:
        """The samples from `first` to before `stop`, as views."""
        return replace(
            self,
            channels={channel: samples[:, first:stop] for channel, samples in self.channels.items()},
            start_time=self.start_time + first / self.sampling_frequency,
            dates=tuple(date + first / self.sampling_frequency for date in self.dates),
        )

    def blinded(self) -> RecordBatch:
        """The same samples of numbered records, without ids, sources, groups, remarks, units and labels."""
        nothing: dict[str, Any] = dict.fromkeys((*_OF_RECORDS, "rejected"), ())
        ids = tuple(map(str, range(self.n_record)))
        return replace(self, record_ids=ids, units={}, labels=None, **nothing)


class RecordSource(Protocol):
    """Records, batch by batch: simulated, stored or measured."""

    @property
    def name(self) -> str:
        """Name for display: a file or a folder."""
        ...

    @property
    def data_sheet(self) -> Mapping[str, Any]:
        """Constant of the machine → its value in SI, for all that is stated."""
        ...

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records, each once, in a fixed order; one batch in memory at a time.

        Parameters
        ----------
        labels : bool
            Whether batches contain the labels of their records. Only evaluations request them.

        Raises
        ------
        DataError
            A measured file cannot be used.
        StoreError
            A stored file cannot be read.
        """
        ...
