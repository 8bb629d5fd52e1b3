"""Batches of records of equal length and sampling."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from hydrofdi.records.batch import RecordBatch, RejectedRecord
from hydrofdi.records.measured.forming import MeasuredRecord

MOST_SAMPLES = 2**22
"""Most samples, over all channels, of a batch with more than one record: 32 MiB."""


def batched(
    records: Iterable[MeasuredRecord | RejectedRecord],
    drive_period: float | None,
    labels: bool,
    most_samples: int = MOST_SAMPLES,
) -> Iterator[RecordBatch]:
    """Batches of consecutive records that fit together; rejected records come with the next batch.

    Parameters
    ----------
    records : iterable of MeasuredRecord or RejectedRecord
    drive_period : float or None
        [s].
    labels : bool
        Whether batches contain the labels of their records.
    most_samples : int
        Most samples, over all channels, of a batch with more than one record.
    """
    waiting: list[MeasuredRecord] = []
    rejected: list[RejectedRecord] = []
    for record in records:
        if isinstance(record, RejectedRecord):
            rejected.append(record if labels else replace(record, label=""))
            continue
        if waiting and (_shape(record) != _shape(waiting[0]) or _is_full(waiting, most_samples)):
            yield _batch(waiting, rejected, drive_period, labels)
            waiting, rejected = [], []
        waiting.append(record)
    if waiting or rejected:
        yield _batch(waiting, rejected, drive_period, labels)


def _shape(record: MeasuredRecord) -> Hashable:
    return record.recording.n_time, record.recording.sampling, record.recording.relative


def _is_full(records: list[MeasuredRecord], most_samples: int) -> bool:
    first = records[0].recording
    return (len(records) + 1) * first.n_time * len(first.channels) > most_samples


def _batch(
    records: list[MeasuredRecord],
    rejected: list[RejectedRecord],
    drive_period: float | None,
    labels: bool,
) -> RecordBatch:
    if not records:
        return RecordBatch({}, 1.0, (), rejected=tuple(rejected), labels=() if labels else None)
    first = records[0].recording
    return RecordBatch(
        channels={
            channel: np.stack([record.recording.channels[channel] for record in records])
            for channel in first.channels
        },
        sampling_frequency=first.sampling.frequency,
        start_time=first.sampling.start,
        record_ids=tuple(record.record_id for record in records),
        sources=tuple(record.source for record in records),
        groups=tuple(record.group for record in records),
        drive_period=drive_period,
        relative=first.relative,
        normalized=first.normalized,
        remarks=tuple(record.recording.remarks for record in records),
        rejected=tuple(rejected),
        units={
            channel: frozenset(record.recording.units[channel] for record in records)
            for channel in first.units
        },
        labels=tuple(record.label for record in records) if labels else None,
    )
