"""A monitor finds a leak that sets in when the study of delays says it is found, and alarms as seldom."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.config import load_experiment
from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.run_lengths import delays
from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig, WindowConfig
from hydrofdi.indicators import make_indicators
from hydrofdi.monitor.lines import Event, EventKind, WindowLine
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.streams import Chunk
from tests.conftest import REPOSITORY

ONSET = 7.0
OPTIONS = {"spool": "command", "supply": "sum", "transient": "4 s"}
STUDY = """
name: few-machines
extends: [{configs}/populations/unknown-plant.yaml, {configs}/motions/closed-loop.yaml]
record: {{duration: 10 s}}
leakage: {{onset: step, onset_time: 7 s}}
baseline: {{leakage.onset: constant}}
study:
  population: {{seed: {seed}}}
  healthy: {{fit: 160, test: 1}}
  faults: {{leakage.internal_flow: [0.05 L/min, 0.5 L/min], each: 8, fit: 0, severity: level}}
"""


def study(folder, seed):
    file = folder / f"study-{seed}.yaml"
    file.write_text(STUDY.format(configs=REPOSITORY / "configs", seed=seed))
    return file


@pytest.fixture(scope="module")
def detector(tmp_path_factory):
    chart = ChartConfig(chart="cusum", options={"shift": 4}, false_alarm_every=300.0)
    config = DetectorConfig(
        indicator="weak_rls", options=OPTIONS, window=WindowConfig(by="estimate"), chart=chart
    )
    healthy = study(tmp_path_factory.mktemp("healthy"), 41)
    return hydrofdi.train(healthy, config=config.model_dump(mode="json", exclude_unset=True)).file


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    """Other machines than those that the detector is trained on."""
    file = study(tmp_path_factory.mktemp("others"), 42)
    return [*SimulatedRecords(load_experiment(file), "others").batches(labels=True)]


def watched(detector, records, row):
    """Lines of a record as a stream of chunks of 0.33 s."""
    watch = Watch(detector)
    state, lines = watch.start(), []
    for first in range(0, records.n_time, 165):
        part = records.window(first, first + 165)
        samples = {channel: part[channel][row] for channel in detector.channels}
        state, found = watch.step(state, Chunk(part.time, samples))
        lines += found
    return lines


def of_population(machines, wanted):
    return [
        (records, row)
        for records in machines
        for row, label in enumerate(records.labels)
        if label.startswith(wanted)
    ]


@pytest.mark.parametrize("leak", ["0.05 L/min", "0.5 L/min"])
def test_the_delay_after_an_onset_is_that_of_the_study(detector, machines, leak):
    found = of_population(machines, leak)
    assert len(found) == 8
    (indicator,) = make_indicators({"weak_rls": OPTIONS}).values()
    for records, row in found:
        trace = indicator.trace(records.rows([row])).since(4.0)
        scores = (trace.values["leakage"] - detector.healthy.centre) / detector.healthy.spread
        chart = make_chart("cusum", {"shift": 4, "direction": "rising"})
        expected = delays(chart, detector.chart.limit, scores, trace.time, ONSET).values[0]
        alarms = [
            line.end
            for line in watched(detector, records, row)
            if isinstance(line, WindowLine) and line.chart is not None and line.chart.alarm
        ]
        first = next((end - ONSET for end in alarms if end >= ONSET), np.inf)
        assert first == pytest.approx(expected, abs=1e-9)


def test_other_healthy_machines_alarm_within_the_promised_interval(detector, machines):
    others = of_population(machines, "sealed")
    assert len(others) == 161
    alarms = sum(
        isinstance(line, Event) and line.kind is EventKind.ALARM_RAISED
        for records, row in others
        for line in watched(detector, records, row)
    )
    hours = 161 * (10.0 - 4.0) / 3600.0
    shortest, longest = detector.chart.interval
    most = 3600.0 * hours / shortest
    least = 0.0 if longest is None else 3600.0 * hours / longest
    assert least - 3.0 * np.sqrt(least) <= alarms <= most + 3.0 * np.sqrt(most)
