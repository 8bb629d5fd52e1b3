"""What control charts of a study cannot state, whatever comes out of its runs."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.study.online import OnlineConfig
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.settings.counting import counted
from hydrofdi.studies.run_lengths.judgement import time_needed
from hydrofdi.studies.run_lengths.traces import watched_instants


def online_warnings(experiment: ExperimentConfig) -> Iterator[str]:
    """A sentence on leaks that do not set in while they are watched, and on too few healthy hours."""
    study, online = experiment.study, experiment.detection.online
    if study is None or online is None:
        return
    if study.faults is not None:
        yield from _onset_warnings(experiment, study.faults.parameter)
    made = experiment.indicator_choice.made(experiment.wavelet)
    for label in dict.fromkeys(chart.of.partition(".")[0] for chart in online.charts.values()):
        indicator = made[label]
        assert isinstance(indicator, RecursiveIndicator)
        instants = watched_instants(indicator, experiment.nominal_parameters)
        if instants.size < 2:
            yield f"the trace of {label} ends before its transient of {indicator.options.transient:g} s"
            continue
        onset = experiment.leakage.onset_time
        if experiment.leakage.onset != "constant" and not instants[0] < onset < instants[-1]:
            yield (
                f"leakage.onset_time = {onset:g} s is outside of what charts watch of {label}, from"
                f" {instants[0]:g} s to {instants[-1]:g} s: no delay is stated"
            )
        duration = float(instants[1] - instants[0]) * instants.size
        confidence = experiment.detection.confidence
        yield from _duration_warnings(study, online, label, duration, confidence)


def _onset_warnings(experiment: ExperimentConfig, parameter: str) -> Iterator[str]:
    if "leakage.onset" in experiment.varied_names:
        return
    if experiment.leakage.onset == "constant":
        yield (
            "leakage.onset = constant: leaks are there from the start: no delay is stated; give"
            " leakage: {onset: step, onset_time: …}"
        )
    elif parameter == "leakage.internal_flow" and experiment.baseline.get("leakage.onset") != "constant":
        yield (
            f"leakage.onset = {experiment.leakage.onset}: levels of faults are means over whole records;"
            " baseline: {leakage.onset: constant} makes them the flow after the onset"
        )


def _duration_warnings(
    study: StudyConfig, online: OnlineConfig, label: str, duration: float, confidence: float
) -> Iterator[str]:
    every = max(online.false_alarm_every)
    hours = f"{every / 3600.0:g} h between false alarms"
    for key, count, needed, cannot in (
        ("fit", study.healthy.fit, every, "set no limit"),
        ("test", study.healthy.test, time_needed(every, confidence), "do not show that a limit holds"),
    ):
        if count * duration < needed:
            yield (
                f"study.healthy.{key} = {counted(count, 'record')} {cannot} for {hours}: {label} needs"
                f" {math.ceil(needed / duration - 1e-9):,} of them ({needed / 3600.0:.3g} h)"
            )
