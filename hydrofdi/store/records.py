"""Stored runs as records: their signals, without the parameters that made them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.runs import study_roles
from hydrofdi.config.sections.drive import InputConfig
from hydrofdi.config.sections.plant import SIGNAL_NAMES
from hydrofdi.errors import Issue, StoreError
from hydrofdi.records import Array, Channel, RecordBatch, RejectedRecord
from hydrofdi.settings.messages import K_I_UNIT, shown_quantity
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.units import convert

_MOST_RECORDS, _MOST_SAMPLES = 256, 320_000
"""Limits of a batch: records, and samples per channel that are in memory at a time."""

SIGNAL_OF_CHANNEL = {
    channel: signal
    for channel, signal in SIGNAL_NAMES.items()
    if signal in {variable.name for variable in names.stored_variables("all") if variable.is_signal}
}
"""Channel → name of its signal, for all channels of simulated runs."""


def batch_length(n_time: int) -> int:
    """Number of records per batch for records of `n_time` samples."""
    return max(1, min(_MOST_RECORDS, _MOST_SAMPLES // max(n_time, 1)))


def distinct_records(
    record_ids: Sequence[str], are_ok: Sequence[bool], only: Collection[int] | None = None
) -> list[int]:
    """Position of one run per record: the first successful run, or else the first."""
    chosen: dict[str, int] = {}
    looked_at = None if only is None else set(only)
    for position, (record_id, is_ok) in enumerate(zip(record_ids, are_ok, strict=True)):
        if looked_at is not None and position not in looked_at:
            continue
        first = chosen.setdefault(record_id, position)
        if is_ok and not are_ok[first]:
            chosen[record_id] = position
    return sorted(chosen.values())


def drive_period(drive: InputConfig, random_force: float) -> float | None:
    """Period of the input of the actuator [s]; None if the input is not periodic."""
    return drive.period if drive.is_periodic and random_force == 0.0 else None


def study_labels(experiment: ExperimentConfig) -> list[str]:
    """Population of each run of a study, such as ``0.1 L/min`` or ``shift stiffer``; empty for others."""
    if experiment.study is None:
        return []
    roles = study_roles(experiment)
    titles = [each.title.removeprefix("fault ") for each in roles.populations]
    return [titles[each] for each in roles.of_run.tolist()]


def condition_label(flow: float, coefficient: float, bulk_modulus: float) -> str:
    """Label of a simulated run: its leakage, and EBM unless it is unknown (NaN)."""
    leakage = f"{convert(flow, 'L/min'):.4g} L/min"
    if np.isnan(flow):
        leakage = f"K_i {shown_quantity(coefficient, K_I_UNIT)}"
    if flow == 0.0 or (np.isnan(flow) and coefficient == 0.0):
        leakage = "sealed"
    return leakage if math.isnan(bulk_modulus) else f"{leakage}, {convert(bulk_modulus, 'MPa'):.4g} MPa"


@dataclass(frozen=True)
class StoredRecords:
    """Records of some runs of an experiment, as far as stored; one that several runs share occurs once."""

    data: ExperimentData
    name: str
    channels: Collection[Channel] = tuple(Channel)
    only: Collection[int] | None = None

    @property
    def data_sheet(self) -> dict[str, Any]:
        """The nominal machine of the experiment."""
        return self.data.experiment.data_sheet

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """Batches of records in the order of the runs; failed runs are rejected with their status."""
        if self.data.experiment.store.signals == "none":
            again = "sweep" if self.data.n_run > 1 else "simulate"
            raise StoreError(
                f"{self.name}: contains no signals; set store: {{signals: all}} and {again} again"
            )
        for positions in self._windows():
            batch = self._batch(positions)
            if labels:
                batch = replace(
                    batch, labels=tuple(self._label(row) for row in positions if self._is_ok(row))
                )
            rejected = tuple(self._rejected(row, labels) for row in positions if not self._is_ok(row))
            yield replace(batch, rejected=rejected)

    def _windows(self) -> Iterator[list[int]]:
        """Groups of consecutive runs with the same drive period."""
        length = batch_length(self._n_time)
        are_ok = [self._is_ok(row) for row in range(self.data.n_run)]
        rows = distinct_records(self.record_ids, are_ok, self.only)
        for first in range(0, len(rows), length):
            window = rows[first : first + length]
            by_period = sorted(window, key=lambda row: self._periods[row] or 0.0)
            for _, alike in groupby(by_period, key=lambda row: self._periods[row]):
                yield list(alike)

    def _batch(self, positions: Sequence[int]) -> RecordBatch:
        rows = [row for row in positions if self._is_ok(row)]
        wanted = {
            channel: SIGNAL_OF_CHANNEL[channel] for channel in SIGNAL_OF_CHANNEL if channel in self.channels
        }
        held = self.data.signals.rows(list(wanted.values()), rows) if rows else {}
        channels = {channel: held[signal] for channel, signal in wanted.items() if signal in held}
        return RecordBatch(
            channels,
            self._sampling_frequency,
            tuple(self.record_ids[row] for row in rows),
            sources=(self.name,) * len(rows),
            drive_period=self._periods[positions[0]],
            remarks=tuple(_missing_value_remarks(channels, index) for index in range(len(rows))),
        )

    def _rejected(self, row: int, labels: bool) -> RejectedRecord:
        columns = self.data.columns
        status, message = str(columns[names.STATUS][row]), str(columns[names.MESSAGE][row])
        label = self._label(row) if labels else ""
        return RejectedRecord(
            self.record_ids[row], self.name, "", Issue(message or status, kind=status), label
        )

    def _is_ok(self, row: int) -> bool:
        return bool(self.data.columns[names.STATUS][row] == "ok")

    @cached_property
    def _study_labels(self) -> list[str]:
        return study_labels(self.data.experiment)

    def _label(self, row: int) -> str:
        if self._study_labels:
            return self._study_labels[row]
        stated = (names.LEAKAGE_LEVEL, names.LEAKAGE_COEFFICIENT, names.BULK_MODULUS)
        flow, coefficient, modulus = (float(self.data.columns[name][row]) for name in stated)
        is_known = self.data.experiment.plant.takes("fluid.bulk_modulus")
        return condition_label(flow, coefficient, modulus if is_known else math.nan)

    @cached_property
    def record_ids(self) -> list[str]:
        """Identities of the records, or of the runs in files without record identities."""
        run_ids = self.data.columns[names.RUN_ID]
        record_ids = self.data.columns.get(names.RECORD_ID, run_ids)
        return [str(record or run) for record, run in zip(record_ids, run_ids, strict=True)]

    @cached_property
    def _sampling_frequency(self) -> float:
        return float(self.data.values("record.sampling_frequency")[0])

    @cached_property
    def _n_time(self) -> int:
        return round(self._sampling_frequency * float(self.data.values("record.duration")[0]))

    @cached_property
    def _periods(self) -> list[float | None]:
        drives = ("input.shape", "input.period", "load.random_force")
        periods: dict[tuple[Any, ...], float | None] = {}
        values = list(zip(*(self.data.values(name) for name in drives), strict=True))
        for shape, period, force in set(values):
            drive = InputConfig.model_construct(shape=shape, period=period)
            periods[shape, period, force] = drive_period(drive, force)
        return [periods[value] for value in values]


def _missing_value_remarks(channels: dict[Channel, Array], row: int) -> tuple[Issue, ...]:
    return tuple(
        Issue(f"{channel} is not stored completely", channel, kind="missing_values", is_unusable=True)
        for channel, samples in channels.items()
        if not np.isfinite(samples[row]).all()
    )
