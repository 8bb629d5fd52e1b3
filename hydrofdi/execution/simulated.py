"""Records of simulated runs: made batch by batch when they are asked for, and never stored."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from hydrofdi.config import ExperimentConfig, RunSpec, expand_runs
from hydrofdi.config.plant import absent_signals
from hydrofdi.config.runs import Runs, record_identities, spread
from hydrofdi.config.study import condition_label
from hydrofdi.engine import limited
from hydrofdi.errors import Issue
from hydrofdi.execution.compute import simulated
from hydrofdi.records import Channel, RecordBatch, RecordSource, RejectedRecord
from hydrofdi.settings.messages import counted, time_text
from hydrofdi.simulation.calibration import leakage_coefficients
from hydrofdi.simulation.lanes import WIDTH
from hydrofdi.store import experiment_data as records
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL, ExperimentData, StoredRecords
from hydrofdi.store.names import stored_signals

_log = logging.getLogger(__name__)
_SECONDS_BETWEEN_LINES = 5.0


@dataclass(frozen=True)
class SimulatedRecords:
    """Records of the runs that an experiment asks for, or ``only`` of those at some positions, with some
    ``channels``; ``name`` is what a person calls them.
    """

    experiment: ExperimentConfig
    name: str
    channels: Collection[Channel] = tuple(Channel)
    only: Collection[int] | None = None

    @cached_property
    def runs(self) -> Runs:
        """All runs of the experiment."""
        return expand_runs(self.experiment).runs

    @cached_property
    def record_ids(self) -> tuple[str, ...]:
        """Identities of their records."""
        return record_identities(self.runs)

    @cached_property
    def _rows(self) -> list[int]:
        return records.distinct_records(self.record_ids, [True] * len(self.record_ids), self.only)

    @property
    def data_sheet(self) -> dict[str, Any]:
        """The nominal machine of the experiment."""
        return self.experiment.data_sheet

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """The records in the order of their runs; those that fail are rejected with how they ended.

        The logger tells how many are simulated, and every few seconds how far it is.
        """
        runs, record_ids, rows = self.runs, self.record_ids, self._rows
        known: dict[str, float] = {}
        titles = records.study_labels(self.experiment) if labels else []
        first, start = 0, time.monotonic()
        told = start
        _log.info("%s: simulating %s", self.name, counted(len(rows), "record"))
        while first < len(rows):
            alike = _alike(runs, rows[first:])
            with limited(self.experiment.limits.time_per_job):
                coefficients = leakage_coefficients(alike, None, known, required="none")
                own = rows[first : first + len(alike)]
                texts = [titles[row] for row in own] if titles else [*map(_label, alike, coefficients)]
                own_ids = [record_ids[row] for row in own]
                batch = _batch(alike, coefficients, own_ids, self, texts if labels else None)
            first += len(alike)
            now = time.monotonic()
            if first < len(rows) and now - told > _SECONDS_BETWEEN_LINES:
                told = now
                left = time_text((now - start) * (len(rows) - first) / first)
                _log.info("simulated %s of %s records, %s left", f"{first:,}", f"{len(rows):,}", left)
            yield batch

    def few(self, n_record: int, record_id: str | None = None) -> SimulatedRecords:
        """Some of the records, spread evenly, and those whose identity begins so; all if there are no more.

        The name says how many of them there are.
        """
        record_ids, rows = self.record_ids, self._rows
        chosen = {rows[position] for position in spread(len(rows), n_record)}
        if record_id is not None:
            chosen |= {row for row in rows if record_ids[row].startswith(record_id)}
        if len(chosen) >= len(rows):
            return self
        return replace(self, name=f"{self.name} ({len(chosen)} of {len(rows):,} records)", only=chosen)


def _batch(
    runs: Sequence[RunSpec],
    coefficients: Sequence[float],
    record_ids: Sequence[str],
    source: SimulatedRecords,
    labels: Sequence[str] | None,
) -> RecordBatch:
    """Records of runs with the same samples; those that fail are rejected."""
    parameters, texts = [run.parameters for run in runs], labels or ("",) * len(runs)
    _, shown = simulated(parameters, coefficients)
    good = [row for row, outcome in enumerate(shown.outcomes) if outcome.is_ok]
    absent = absent_signals(parameters[0].plant)
    wanted = {
        channel: signal
        for channel, signal in records.SIGNAL_OF_CHANNEL.items()
        if channel in source.channels and signal not in absent
    }
    signals = shown.signals(wanted.values())
    return RecordBatch(
        {channel: signals[signal][good] for channel, signal in wanted.items() if signal in signals},
        parameters[0].record.sampling_frequency,
        tuple(record_ids[row] for row in good),
        sources=(source.name,) * len(good),
        drive_period=parameters[0].drive_period,
        labels=tuple(texts[row] for row in good) if labels else None,
        rejected=tuple(
            RejectedRecord(record_id, source.name, "", Issue(outcome.message, kind=outcome.status), text)
            for record_id, outcome, text in zip(record_ids, shown.outcomes, texts, strict=True)
            if not outcome.is_ok
        ),
    )


def _label(run: RunSpec, coefficient: float) -> str:
    flow = run.parameters.leakage.internal_flow
    is_known = run.parameters.plant.takes("fluid.bulk_modulus")
    modulus = run.parameters.fluid.bulk_modulus if is_known else math.nan
    return condition_label(math.nan if flow is None else flow, coefficient, modulus)


_MOST_SAMPLES_AT_ONCE = 4_000_000
"""Samples of each channel that records of a batch have together, if they are long: about 0.3 GB."""


def _alike(runs: Sequence[RunSpec], rows: Sequence[int]) -> list[RunSpec]:
    """The first of some runs, as many as fit into one batch; long ones still fill the lanes of the kernel."""
    lead = runs[rows[0]].parameters
    n_sample = lead.record.n_sample
    least = WIDTH if WIDTH * n_sample <= _MOST_SAMPLES_AT_ONCE else 1
    length = max(records.batch_length(n_sample) // WIDTH * WIDTH, least)
    alike = []
    for run in (runs[row] for row in rows[:length]):
        own = run.parameters
        if (own.record.time_axis, own.drive_period) != (lead.record.time_axis, lead.drive_period):
            break
        alike.append(run)
    return alike


def records_of_study(stored: ExperimentData, needed: Collection[Channel]) -> RecordSource:
    """The records of a study: its stored signals where they suffice, else simulated again."""
    store, name = stored.experiment.store, str(stored.path)
    signals = {signal for channel, signal in SIGNAL_OF_CHANNEL.items() if channel in needed}
    signals -= stored.experiment.absent_signals
    if signals <= stored_signals(store.signals) and store.dtype == "float64":
        return StoredRecords(stored, name, needed)
    return SimulatedRecords(stored.experiment, name, needed)
