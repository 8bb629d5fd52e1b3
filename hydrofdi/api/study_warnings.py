"""What a study cannot state, whatever comes out of its runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.shown_values import shown_value
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.config.sweeps.distributions import quantiles
from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.scoring import EXTRA, has_extra
from hydrofdi.settings.counting import counted
from hydrofdi.studies.charts import time_needed, watched_instants
from hydrofdi.studies.detecting import rules_of
from hydrofdi.studies.left_out import asks_for_extra
from hydrofdi.studies.rules import Rules


def study_warnings(experiment: ExperimentConfig) -> list[str]:
    """A sentence on each number of records that is too small, on charts and the extra."""
    if experiment.study is None:
        return []
    rules = rules_of(experiment.detection)
    sentences = [
        *_fit_warnings(experiment, rules),
        *_count_warnings(experiment.study, rules),
        *_shifts_inside(experiment.study),
        *_free_supply_sensors(experiment),
        *_online_warnings(experiment),
    ]
    if asks_for_extra(experiment.detection) and not has_extra():
        sentences.append(f"the report will leave out scores that need the extra: {EXTRA}")
    return sentences


def _free_supply_sensors(experiment: ExperimentConfig) -> Iterator[str]:
    """A sentence on indicators that read the simulated supply pressure because nobody says otherwise."""
    made = experiment.indicator_choice.made(experiment.wavelet)
    labels = [label for label, each in made.items() if getattr(each.options, "supply", "") == "auto"]
    if labels and experiment.supply_sensor.is_default and not experiment.detection.sensors:
        yield (
            f"{', '.join(labels)}: 'supply: auto' reads the simulated supply pressure, without noise, as no"
            " supply_sensor is set; write 'supply: sum' or 'nominal' if your machine has no such sensor"
        )


def _fit_warnings(experiment: ExperimentConfig, rules: Rules) -> Iterator[str]:
    """A sentence on healthy fit records that are too few for thresholds on one side, or on both."""
    assert experiment.study is not None
    n_fit, of_both = experiment.study.healthy.fit, _two_sided_scores(experiment)
    one, both = (rules.records_for_threshold(each) for each in (Direction.RISING, Direction.BOTH))
    on_both = f"scores that may alarm on both sides, such as {of_both[0]}" if of_both else ""
    rule = f"for {100.0 * rules.false_alarm_rate:g} % false alarms, {rules.threshold} needs"
    if n_fit < one:
        more = f", and {both} for {on_both}" if on_both and both > one else ""
        yield f"study.healthy.fit = {n_fit} sets no threshold: {rule} {one} records{more}"
    elif on_both and n_fit < both:
        yield f"study.healthy.fit = {n_fit} sets no threshold for {on_both}: {rule} {both} records"


def _two_sided_scores(experiment: ExperimentConfig) -> list[str]:
    """Scores of the indicators whose definition does not say in which direction a fault moves them."""
    judged = experiment.detection.indicators
    return [
        f"{label}.{output.name}"
        for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items()
        if not judged or label in judged
        for output in indicator.outputs
        if output.is_score and output.direction in (None, Direction.BOTH)
    ]


def _count_warnings(study: StudyConfig, rules: Rules) -> Iterator[str]:
    healthy, faults = study.healthy, study.faults
    rate, confidence = f"{100.0 * rules.false_alarm_rate:g} %", f"{100.0 * rules.confidence:g} %"
    if healthy.test < rules.records_for_false_alarms:
        yield (
            f"study.healthy.test = {healthy.test} shows no rate of false alarms: {rate} needs"
            f" {rules.records_for_false_alarms} records ({confidence} confidence)"
        )
    if study.shifts and healthy.shift is not None and healthy.shift < rules.records_for_false_alarms:
        yield (
            f"study.healthy.shift = {healthy.shift} shows no rate of false alarms in shifts: {rate} needs"
            f" {rules.records_for_false_alarms} records of each ({confidence} confidence), without which no"
            " score is known to keep its rate"
        )
    if faults is not None and faults.each < rules.records_for_detection:
        yield (
            f"study.faults.each = {faults.each} is too few for one level to show"
            f" {100.0 * rules.probability:g} % detection: that needs {rules.records_for_detection} records"
            f" ({confidence} confidence)"
        )


def _shifts_inside(study: StudyConfig) -> Iterator[str]:
    """A sentence on each shift whose values the fit records may have as well."""
    drawn = study.population.over | study.population.per_record
    for name, changes in study.shifts.items():
        ranges = {each: _usual_range(drawn[each]) for each in changes if each in drawn}
        if len(ranges) == len(changes) and all(
            isinstance(value, float) and low <= value <= high
            for value, (low, high) in zip(changes.values(), ranges.values(), strict=True)
        ):
            shown = ", ".join(f"{each} = {shown_value(each, value)}" for each, value in changes.items())
            yield (
                f"study.shifts.{name}: {shown} lies inside the population, so fit records show this condition"
                " as well; shift it further, or call it a confusion if it is a fault"
            )


def _usual_range(distribution: dict[Any, list[Any]]) -> tuple[float, float]:
    """Where all but one in a hundred draws lie; not a number if they are not numbers."""
    low, high = quantiles(distribution, np.array([0.005, 0.995]))
    return (float(low), float(high)) if isinstance(low, int | float) else (np.nan, np.nan)


def _online_warnings(experiment: ExperimentConfig) -> Iterator[str]:
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
        duration, every = float(instants[1] - instants[0]) * instants.size, max(online.false_alarm_every)
        proof = time_needed(every, experiment.detection.confidence)
        for key, count, needed, cannot in (
            ("fit", study.healthy.fit, every, "set no limit"),
            ("test", study.healthy.test, proof, "do not show that a limit holds"),
        ):
            if count * duration < needed:
                yield (
                    f"study.healthy.{key} = {counted(count, 'record')} {cannot} for {every / 3600.0:g} h"
                    f" between false alarms: {label} needs {math.ceil(needed / duration - 1e-9):,} of them"
                    f" ({needed / 3600.0:.3g} h)"
                )


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
