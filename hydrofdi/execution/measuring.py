"""Indicators and features of records, whether they were just simulated or are stored."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters, RunSpec
from hydrofdi.config.experiment import DEFAULT_ANALYSIS, DWT, Analysis, Indicators
from hydrofdi.errors import Issue
from hydrofdi.indicators.measuring import Measures, Seconds, measure
from hydrofdi.indicators.record_measures import used_channels
from hydrofdi.quality.measures import pressure_features
from hydrofdi.records import RecordBatch
from hydrofdi.store.index import StoredRun
from hydrofdi.store.layout import names
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period
from hydrofdi.transforms.configuration import WaveletConfig


@dataclass(frozen=True)
class Job:
    """A run that is ready to be computed.

    `leakage_coefficient` is K_i [m^3.5/kg^0.5], NaN if none gives its leakage; `stored` is where its record
    is, None if it is to be simulated.
    """

    run_id: str
    parameters: RunParameters
    leakage_coefficient: float
    analysis: Analysis = DEFAULT_ANALYSIS
    record_id: str = ""
    stored: StoredRun | None = None

    @classmethod
    def of(cls, run: RunSpec, run_id: str, leakage_coefficient: float, record_id: str = "") -> Job:
        """The job of a run."""
        return cls(run_id, run.parameters, leakage_coefficient, run.analysis, record_id)


Columns = Mapping[str, NDArray[Any]]


def needed_signals(indicators: Indicators) -> set[str]:
    """The signals that are measured: those of the indicators, and the chamber-1 pressure."""
    needed = used_channels(indicators) & SIGNAL_OF_CHANNEL.keys()
    return {SIGNAL_OF_CHANNEL[channel] for channel in needed} | {names.CHAMBER_1_PRESSURE}


def measured_columns(
    jobs: Sequence[Job], records: Columns, seconds: Seconds | None = None
) -> dict[str, NDArray[Any]]:
    """What is measured of the records of jobs, one row per job; NaN if a run failed."""
    columns: dict[str, NDArray[Any]] = {}
    for rows in _alike(jobs):
        part = _measured_alike([jobs[row] for row in rows], _at(records, rows), seconds)
        insert(columns, rows, len(jobs), part)
    failed = records[names.STATUS] != "ok"
    for name, values in columns.items():
        if values.dtype == float:
            values[failed] = np.nan
        elif name.endswith(names.OBSTACLE):
            values[failed] = records[names.MESSAGE][failed]
    return columns | names.wavelet_numbers(columns)


def _alike(jobs: Sequence[Job]) -> list[list[int]]:
    """Positions of jobs that are analysed alike, but for the start phase, and have the period of their drive
    in common."""
    return _grouped((_without_phase(job.analysis), _period(job)) for job in jobs)


def _grouped(keys: Iterable[object]) -> list[list[int]]:
    groups: dict[object, list[int]] = {}
    for row, key in enumerate(keys):
        groups.setdefault(key, []).append(row)
    return list(groups.values())


def _without_phase(analysis: Analysis) -> Analysis:
    """The analysis from phase 0 on; one of every phase stays what it is."""
    return (
        analysis
        if analysis.wavelet.phase == "all"
        else replace(analysis, wavelet=_at_phase_0(analysis.wavelet))
    )


@lru_cache(maxsize=1024)
def _at_phase_0(wavelet: WaveletConfig) -> WaveletConfig:
    return wavelet.model_copy(update={"phase": 0})


def _period(job: Job) -> float | None:
    return drive_period(job.parameters.input, job.parameters.load.random_force)


def _measured_alike(
    jobs: Sequence[Job], records: Columns, seconds: Seconds | None
) -> dict[str, NDArray[Any]]:
    analysis = _without_phase(jobs[0].analysis)
    columns: dict[str, NDArray[Any]] = {}
    identities = [job.analysis.identities(job.record_id) for job in jobs]
    for label in analysis.indicators:
        columns[f"{label}{names.ANALYSIS_ID}"] = np.array([each[label] for each in identities], dtype=object)
    batch = record_batch(jobs, records).window(analysis.n_discarded)
    for rows, indicators in _indicators_of(jobs):
        measures = measure(batch if len(rows) == len(jobs) else batch.rows(rows), indicators, seconds)
        insert(columns, rows, len(jobs), _as_columns(measures))
    with np.errstate(all="ignore"):
        return columns | pressure_features(
            [job.parameters for job in jobs],
            [analysis] * len(jobs),
            np.ascontiguousarray(records[names.CHAMBER_1_PRESSURE]),
            records[names.SETTLED_FROM],
        )


def _indicators_of(jobs: Sequence[Job]) -> Iterator[tuple[list[int], Indicators]]:
    """Positions of jobs and the indicators to measure together: the start phase is that of the transform."""
    by_phase = _grouped(job.analysis.wavelet.phase for job in jobs)
    indicators = jobs[0].analysis.indicators
    if len(by_phase) == 1 or DWT not in indicators:
        yield list(range(len(jobs))), indicators
        return
    yield list(range(len(jobs))), {label: each for label, each in indicators.items() if label != DWT}
    for rows in by_phase:
        yield rows, {DWT: jobs[rows[0]].analysis.indicators[DWT]}


def _as_columns(measures: Measures) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = dict(measures.values)
    for label, reasons in measures.obstacles.items():
        columns[f"{label}{names.OBSTACLE}"] = np.array([reason or "" for reason in reasons], dtype=object)
    return columns


def record_batch(jobs: Sequence[Job], records: Columns) -> RecordBatch:
    """What the sensors show of records, as far as indicators need it."""
    needed = used_channels(jobs[0].analysis.indicators)
    return RecordBatch(
        {
            channel: records[signal]
            for channel, signal in SIGNAL_OF_CHANNEL.items()
            if channel in needed and signal in records
        },
        jobs[0].parameters.record.sampling_frequency,
        tuple(job.record_id for job in jobs),
        drive_period=_period(jobs[0]),
        remarks=tuple(
            () if status == "ok" else (Issue(message, kind=status, is_unusable=True),)
            for status, message in zip(records[names.STATUS], records[names.MESSAGE], strict=True)
        ),
    )


def _at(records: Columns, rows: list[int]) -> dict[str, NDArray[Any]]:
    n_row = len(records[names.STATUS])
    if len(rows) == n_row:
        return dict(records)
    return {name: values[rows] for name, values in records.items() if name != names.TIME}


def insert(
    columns: dict[str, NDArray[Any]], rows: list[int], n_job: int, part: Mapping[str, NDArray[Any]]
) -> None:
    """Put the numbers of some rows in their places; those of different shapes lie in the largest."""
    for name, values in part.items():
        whole = columns.get(name)
        sizes = np.maximum(values.shape[1:], whole.shape[1:] if whole is not None else 0)
        shape = (n_job, *np.atleast_1d(sizes).astype(int)[: values.ndim - 1])
        is_text = values.dtype == object
        if whole is None or whole.shape != shape:
            larger = np.full(shape, "" if is_text else np.nan, values.dtype)
            if whole is not None:
                larger[tuple(slice(size) for size in whole.shape)] = whole
            columns[name] = whole = larger
        inside: list[Any] = [rows, *(slice(size) for size in values.shape[1:])]
        whole[tuple(inside)] = values
