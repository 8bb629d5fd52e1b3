"""An experiment as it was stored, and its runs as records, without the parameters that made them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.drive import PERIODIC
from hydrofdi.config.experiment import DWT, Indicators
from hydrofdi.config.plant import SIGNAL_NAMES
from hydrofdi.config.runs import PHYSICS_VERSION, study_roles
from hydrofdi.config.study import condition_label
from hydrofdi.errors import Issue, StoreError
from hydrofdi.records import Array, Channel, RecordBatch, RejectedRecord
from hydrofdi.store import names
from hydrofdi.store.shards import FileSignals, ShardResults


@dataclass(frozen=True)
class ExperimentData:
    """An experiment and its results: variable → array with one row per run, and where its signals are.

    `configuration` is what the file says, in SI; None if there is no file. `remarks` apply to all rows.
    `attributes`: label of an indicator that is not installed → what the file says of it.
    """

    path: Path
    experiment: ExperimentConfig
    columns: dict[str, NDArray[Any]]
    versions: dict[str, str]
    signals: FileSignals | ShardResults
    configuration: dict[str, Any] | None = None
    remarks: tuple[str, ...] = ()
    physics_version: int = PHYSICS_VERSION
    attributes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def all_remarks(self) -> tuple[str, ...]:
        """The remarks, on indicators without outputs first, on another version of the physics last."""
        omitted = (
            f"Indicator {label} is omitted: {absent.reason}. Its values remain stored."
            for label, absent in self.experiment.indicator_choice.placeholders(self.attributes).items()
            if not absent.outputs
        )
        older = (
            f"Computed with version {self.physics_version} of the physics; this hydrofdi has version"
            f" {PHYSICS_VERSION}, and runs that are computed now may differ."
        )
        return (*omitted, *self.remarks, *([older] if self.physics_version != PHYSICS_VERSION else []))

    @property
    def indicators(self) -> Indicators:
        """Label → indicator."""
        choice = self.experiment.indicator_choice
        return {**choice.made(self.experiment.wavelet), **choice.placeholders(self.attributes)}

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self.columns[names.RUN_ID])

    @property
    def is_whole(self) -> bool:
        """Whether every run has been computed or has failed."""
        return names.MISSING not in self.columns[names.STATUS]

    @cached_property
    def leakage_requests(self) -> NDArray[np.float64]:
        """Requested leakage of each run: mean flow [m³/s] or K_i [m^3.5/kg^0.5]; 0 if sealed."""
        level = self.columns[names.LEAKAGE_LEVEL]
        requests: NDArray[np.float64] = np.where(
            np.isnan(level), self.columns[names.LEAKAGE_COEFFICIENT], level
        )
        return requests

    @cached_property
    def fixed_baseline(self) -> NDArray[np.int64]:
        """Row of each run's sealed run under the baseline's conditions; `NO_BASELINE` if there is none."""
        return self._sealed(self.columns[names.FIXED_BASELINE])

    @cached_property
    def matched_baseline(self) -> NDArray[np.int64]:
        """Row of each run's sealed run under its own conditions; `NO_BASELINE` if there is none."""
        return self._sealed(self.columns[names.MATCHED_BASELINE])

    @property
    def baselines(self) -> dict[str, NDArray[np.int64]]:
        """Rows of the healthy runs by the names of both kinds: ``fixed`` and ``matched``."""
        return {"fixed": self.fixed_baseline, "matched": self.matched_baseline}

    @property
    def has_details(self) -> bool:
        """Whether the experiment measures the wavelet details as configured."""
        return DWT in self.experiment.indicators

    def _sealed(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Baseline rows, without those of leaking runs."""
        return np.where((rows >= 0) & (self.leakage_requests[rows] == 0.0), rows, names.NO_BASELINE)

    def values(self, name: str) -> list[Any]:
        """Value of a dotted parameter in SI, for each run; None if it is not set."""
        variable = names.axis_variable(name)
        if variable in self.columns:
            stored = self.columns[variable].tolist()
            return [None if value != value or value == "" else value for value in stored]
        values = np.full(self.n_run, self.experiment.nominal_parameters.shown_value(name), dtype=object)
        if name in self.experiment.baseline:
            of_baseline = [names.FIXED_BASELINE] + [names.MATCHED_BASELINE] * name.startswith("leakage.")
            for rows in (self.columns[kind] for kind in of_baseline):
                values[rows[rows >= 0]] = self.experiment.baseline[name]
        return list(values)

    def signal(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, (n_time,); a StoreError if it is not stored."""
        time, rows = self.signals.time(), self.signals.rows([name], [position])
        if time is None or name not in rows:
            raise StoreError(f"{self.path}: contains no {name}; set store: {{signals: all}} and sweep again")
        return time, rows[name][0]


_MOST_RECORDS, _MOST_SAMPLES = 256, 320_000
"""Limits of a batch: records, and samples per channel that are in memory at a time."""

SIGNAL_OF_CHANNEL = {channel: signal for channel, signal in SIGNAL_NAMES.items() if signal in names.SIGNALS}
"""Channel → name of its signal, for all channels of simulated runs."""


def batch_length(n_time: int) -> int:
    """Number of records per batch for records of `n_time` samples."""
    return max(1, min(_MOST_RECORDS, _MOST_SAMPLES // max(n_time, 1)))


def distinct_records(
    record_ids: Sequence[str], are_ok: Sequence[bool], only: Collection[int] | None = None
) -> list[int]:
    """Position of one run per record: the first successful run, or else the first."""
    chosen: dict[str, int] = {}
    for position in range(len(record_ids)) if only is None else sorted(only):
        first = chosen.setdefault(record_ids[position], position)
        if are_ok[position] and not are_ok[first]:
            chosen[record_ids[position]] = position
    return sorted(chosen.values())


def study_labels(experiment: ExperimentConfig) -> list[str]:
    """Population of each run of a study, such as ``0.1 L/min`` or ``shift stiffer``; empty for others."""
    if experiment.study is None:
        return []
    roles = study_roles(experiment)
    titles = [population.title.removeprefix("fault ") for population in roles.populations]
    return [titles[index] for index in roles.of_run.tolist()]


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
            yield self._batch(positions, labels)

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

    def _batch(self, positions: Sequence[int], labels: bool) -> RecordBatch:
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
            rejected=tuple(self._rejected(row, labels) for row in positions if not self._is_ok(row)),
            labels=tuple(map(self._label, rows)) if labels else None,
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
        drives = map(self.data.values, ("input.shape", "input.period", "load.random_force"))
        return [
            period if shape in PERIODIC and not force else None
            for shape, period, force in zip(*drives, strict=True)
        ]


def _missing_value_remarks(channels: dict[Channel, Array], row: int) -> tuple[Issue, ...]:
    return tuple(
        Issue(f"{channel} is not stored completely", channel, kind="missing_values", is_unusable=True)
        for channel, samples in channels.items()
        if not np.isfinite(samples[row]).all()
    )
