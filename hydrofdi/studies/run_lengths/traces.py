"""Stored traces of a score over time in a study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.request import RunRequest
from hydrofdi.errors import ReportError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.scores import Array
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout.names import MEAN_LEAKAGE_FLOW
from hydrofdi.studies.records import StudyRecords


@dataclass(frozen=True, eq=False)
class Traces:
    """Score over time of records, without the initial transient of its estimator.

    Attributes
    ----------
    records : StudyRecords
        Records of the traces.
    values : ndarray, shape (n_record, n_instant)
        [unit]; NaN after the estimator diverged.
    time : ndarray, shape (n_instant,)
        Instants [s], on the clock of the records.
    onset : ndarray, shape (n_record,)
        Onset of the leak of a record [s]; NaN if it exists from the start.
    flow : ndarray, shape (n_record,)
        True mean leakage flow from the onset on [m³/s]; NaN if the run failed.
    unit : str
        SI.
    direction : Direction
        Direction of change of the score that means a leak.
    """

    records: StudyRecords
    values: Array
    time: Array
    onset: Array
    flow: Array
    unit: str = "1"
    direction: Direction = Direction.BOTH

    @property
    def interval(self) -> float:
        """Time between instants [s]."""
        return float(self.time[1] - self.time[0])

    @property
    def sets_in(self) -> NDArray[np.bool_]:
        """Whether the onset of the leak is within the watched time, shape (n_record,)."""
        is_watched = (self.onset > self.time[0]) & (self.onset < self.time[-1])
        return np.asarray(is_watched & np.isfinite(self.flow))


def read_traces(data: ExperimentData, records: StudyRecords, rows: NDArray[np.intp], watched: str) -> Traces:
    """Read the traces of a score in a design of a stored study.

    Parameters
    ----------
    data : ExperimentData
    records : StudyRecords
        Records of the design.
    rows : ndarray of int, shape (n_record,)
        Their rows in the file.
    watched : str
        ``label.output``.

    Raises
    ------
    ReportError
        The file does not contain the traces, or they are too short.
    """
    label = watched.partition(".")[0]
    indicator = data.experiment.indicator_choice.made(data.experiment.wavelet)[label]
    stored = data.columns.get(f"{watched}_trace")
    if stored is None or not isinstance(indicator, RecursiveIndicator):
        raise ReportError(f"{data.path}: contains no trace of {watched}; sweep again")
    request = data.experiment.nominal_parameters.with_values(records.design)
    time = watched_instants(indicator, request)
    if time.size < 2:
        raise ReportError(f"the trace of {watched} ends before its transient is over")
    onset = _onsets(data)[rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1.0 - np.where(np.isnan(onset), 0.0, onset) / request.record.duration
        flow = data.columns[MEAN_LEAKAGE_FLOW][rows] / share
    score = indicator.estimates[0]
    return Traces(
        records,
        np.asarray(stored[rows], dtype=float)[:, indicator.n_instant - time.size : indicator.n_instant],
        time,
        onset,
        flow,
        score.unit,
        Direction.BOTH if score.direction is None else score.direction,
    )


def watched_instants(indicator: RecursiveIndicator[Any], request: RunRequest) -> Array:
    """Instants of a stored trace after its transient [s], on the clock of the whole record."""
    frequency = request.record.sampling_frequency
    instants = indicator.trace_instants(frequency)
    return np.asarray(instants[instants >= indicator.options.transient] + request.n_discarded / frequency)


def _onsets(data: ExperimentData) -> Array:
    """Onset of the leak of each run [s]; NaN if the leak is constant."""
    is_constant = np.array([kind == "constant" for kind in data.values("leakage.onset")])
    return np.where(is_constant, np.nan, np.array(data.values("leakage.onset_time"), dtype=float))
