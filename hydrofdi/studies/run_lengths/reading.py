"""Evaluation of the charts of a stored study."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.study.study import ChartConfig
from hydrofdi.store import ExperimentData
from hydrofdi.studies.judged import rules_of
from hydrofdi.studies.reading import needed_channels, study_designs
from hydrofdi.studies.records import StudyRecords
from hydrofdi.studies.run_lengths.judgement import ChartJudgement, RunLengths
from hydrofdi.studies.run_lengths.judging import judge_chart
from hydrofdi.studies.run_lengths.traces import read_traces


def judge_run_lengths(data: ExperimentData) -> tuple[RunLengths, ...]:
    """Evaluate the charts of every design of a stored study; empty if there are none.

    Charts on indicators that need sensors which the machine does not have are omitted.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the traces.
    """
    if data.experiment.detection.online is None:
        return ()
    rules = rules_of(data.experiment.detection)
    return tuple(
        RunLengths(records, tuple(_judged(data, records, rows)), rules.confidence, rules.probability)
        for records, rows in study_designs(data)
    )


def _judged(data: ExperimentData, records: StudyRecords, rows: NDArray[np.intp]) -> Iterator[ChartJudgement]:
    detection = data.experiment.detection
    assert detection.online is not None
    for label, asked in detection.online.charts.items():
        if _has_its_sensors(data, asked):
            traces = read_traces(data, records, rows, asked.of)
            yield from judge_chart(traces, label, asked, detection.online, rules_of(detection))


def _has_its_sensors(data: ExperimentData, asked: ChartConfig) -> bool:
    experiment, sensors = data.experiment, data.experiment.detection.sensors
    indicator = experiment.indicator_choice.made(experiment.wavelet)[asked.of.partition(".")[0]]
    return not sensors or set(needed_channels(indicator)) <= set(sensors)
