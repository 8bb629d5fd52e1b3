"""What `check` and `plan` say of an experiment before it runs: one table of rules."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from math import isclose
from typing import Any

import numpy as np

from hydrofdi.api.step_limits import Distinct, undamped_frequency
from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.plausibility import idle_parameters, unusual_values
from hydrofdi.config.request import parameter_names
from hydrofdi.config.sections.drive import is_whole
from hydrofdi.config.shown_values import shown_parameter, shown_value
from hydrofdi.config.sweeps.distributions import quantiles
from hydrofdi.detectors.run_lengths import time_needed
from hydrofdi.detectors.scores.features import EXTRA, has_extra
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.nominal_actuator import plant_constants
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.records import RecordBatch
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.readable import typeset
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period
from hydrofdi.studies.charts import watched_instants
from hydrofdi.studies.detecting import rules_of
from hydrofdi.studies.reading import asks_for_extra
from hydrofdi.transforms.wavelet import boundary_shares, level_bands

NEAR_BAND_EDGE = 0.25
"""A mode within so many octaves of a band's edge may answer in either level."""

MANY_BOUNDARY_COEFFICIENTS = 0.25
"""Share of a level's coefficients from which on its RMS depends on the extension of the record."""

FEW_SAMPLES = 20
"""Samples per period of an intermittent leak below which its mean flow, a mean over samples, is off."""

MOST_RECORDS = 200
"""Kinds of records that indicators are tried on; a drawn period would make one for each run."""

_OF_WAVELETS = ("dwt", "a4", "modwt", "wavelet_packet")
_PLANT = ("actuator", "fluid", "valve")
_OF_RECORDS = ("input", "load", "record", "analysis", "wavelet")


def experiment_warnings(experiment: ExperimentConfig, distinct: Distinct) -> list[str]:
    """What every rule says of an experiment; `distinct` gives one run for each combination of sections."""
    return said(RULES if experiment.study is None else RULES + STUDY_RULES, experiment, distinct)


def said(rules: Iterable[Rule], experiment: ExperimentConfig, distinct: Distinct) -> list[str]:
    """What rules say, each sentence once."""
    return list(dict.fromkeys(sentence for rule in rules for sentence in rule(experiment, distinct)))


def _sobol_samples(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    for sample in (experiment.ensemble.sample, experiment.sweep.sample):
        if sample and sample.method == "sobol" and sample.count & (sample.count - 1):
            points = counted(sample.count, "point")
            yield f"a Sobol sample of {points} is not balanced; take a power of two"


def period_count(run: RunParameters) -> float:
    """Periods of the input in the record; NaN if it has none."""
    return run.record.duration / run.input.period if run.input.is_periodic else math.nan


def place_in_bands(frequency: float, bands: Sequence[tuple[float, float]]) -> tuple[int, float]:
    """Level whose band holds a frequency, and its distance from the nearest edge in octaves."""
    edges = [bands[0][1], *(low for low, _ in bands)]
    level = sum(frequency < edge for edge in edges)
    if not frequency > 0.0:
        return level, math.nan
    return level, min(abs(math.log2(frequency / edge)) for edge in edges)


def _bands(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A mode near the edge of a band, if an indicator has the bands of a wavelet transform."""
    made = experiment.indicator_choice.made(experiment.wavelet).values()
    if not any(getattr(each.options, "of", each.name) in _OF_WAVELETS for each in made):
        return
    modes = {
        (undamped_frequency(run) / (2.0 * math.pi), run.fluid.bulk_modulus): level_bands(
            run.record.sampling_frequency, run.wavelet.levels
        )
        for run in distinct("actuator", "fluid", "record", "wavelet")
    }
    near = [mode for mode, bands in modes.items() if place_in_bands(mode[0], bands)[1] < NEAR_BAND_EDGE]
    if near:
        frequency, modulus = near[0]
        first = f"{frequency:.1f} Hz at EBM {shown_value('fluid.bulk_modulus', modulus)}"
        where = f" in {len(near):,} of {len(modes):,} conditions, e.g." if len(near) > 1 else ":"
        yield (
            "Two wavelet levels share the natural frequency, so their values depend strongly on the oil"
            f"{where} {first}. Another record.sampling_frequency moves the levels; other indicators are not"
            " affected"
        )


def _intermittent_leaks(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    for run in distinct("leakage", "record"):
        n_sample = run.leakage.onset_duration * run.record.sampling_frequency
        if run.leakage.onset == "intermittent" and n_sample < FEW_SAMPLES:
            yield (
                f"an intermittent leak of period {run.leakage.onset_duration:g} s is sampled only"
                f" {n_sample:g} times in it: its mean flow is off"
            )


def _folding(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """What is too fast for the sampling."""
    for run in distinct("input", "record"):
        drive, sampling = run.input, run.record.sampling_frequency
        more = f"more than half of record.sampling_frequency = {sampling:g} Hz"
        if drive.shape == "sweep" and drive.end_frequency > 0.5 * sampling:
            yield f"input.end_frequency = {drive.end_frequency:g} Hz is {more}"
        if drive.shape == "multisine" and drive.harmonics / drive.period > 0.5 * sampling:
            highest = drive.harmonics / drive.period
            yield f"input.harmonics = {drive.harmonics} reach {highest:g} Hz, {more}"
    for run in distinct("measurement", "record"):
        corner, sampling = run.measurement.anti_alias, run.record.sampling_frequency
        if corner is not None and corner >= 0.5 * sampling:
            yield (
                f"measurement.anti_alias = {corner:g} Hz is not below half of record.sampling_frequency ="
                f" {sampling:g} Hz: sampling folds what it lets pass"
            )


def _records(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """Records of a part of a period, and those whose end decides many coefficients."""
    for run in distinct(*_OF_RECORDS):
        n_period = period_count(run)
        if math.isfinite(n_period) and not is_whole(n_period):
            yield f"the record holds {n_period:g} periods, no whole number: features depend on where it ends"
        shares = enumerate(boundary_shares(run.n_kept, run.wavelet), 1)
        many = [
            f"{share:.0%} of the coefficients of d{level}"
            for level, share in shares
            if share > MANY_BOUNDARY_COEFFICIENTS
        ]
        if many:
            yield f"{' and '.join(many)} depend on the extension of the record"


def without_results(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each indicator that cannot measure the records of some runs, and why."""
    records = dict.fromkeys(
        (
            run.n_kept,
            run.record.sampling_frequency,
            drive_period(run.input, run.load.random_force),
            run.wavelet,
        )
        for run in distinct(*_OF_RECORDS)
    )
    for n_kept, frequency, period, wavelet in islice(records, MOST_RECORDS):
        signals = dict.fromkeys(SIGNAL_OF_CHANNEL, np.broadcast_to(0.0, (1, n_kept)))
        batch = RecordBatch(signals, frequency, ("",), drive_period=period)
        for label, each in experiment.indicator_choice.made(wavelet).items():
            if text := each.obstacle(batch):
                yield f"{label} will have no results: {text}"


def other_machines(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each indicator whose constants of the plant are not those of the nominal machine."""
    labels: dict[str, list[str]] = {}
    for label, each in experiment.indicator_choice.made(experiment.wavelet).items():
        labels.setdefault(", ".join(_differing(experiment, each.options)), []).append(label)
    for text, of in labels.items():
        if text:
            yield (
                f"{', '.join(of)}: the options describe another machine: {text}; a YAML alias such as *area"
                " keeps the value of the file in which it stands"
            )


def _differing(experiment: ExperimentConfig, options: Section) -> Iterator[str]:
    """Constants of an indicator that differ from the parameters of the same meaning."""
    nominal, known = experiment.nominal_parameters, {*parameter_names()}
    for constant in plant_constants(options):
        own = (
            ["supply.pressure"]
            if constant == "supply_pressure"
            else [f"{each}.{constant}" for each in _PLANT]
        )
        for parameter in filter(known.__contains__, own):
            assumed, simulated = getattr(options, constant), nominal.value(parameter)
            if simulated is not None and not isclose(assumed, simulated, rel_tol=1e-3):
                shown = shown_parameter(parameter, [assumed, simulated])
                unit = "" if shown.unit == "1" else f" {typeset(shown.unit)}"
                yield f"{constant} {shown.text(assumed)}{unit}, but {parameter} {shown.text(simulated)}{unit}"


def _free_supply_sensors(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on indicators that read the simulated supply pressure because nobody says otherwise."""
    made = experiment.indicator_choice.made(experiment.wavelet)
    labels = [label for label, each in made.items() if getattr(each.options, "supply", "") == "auto"]
    if labels and experiment.supply_sensor.is_default and not experiment.detection.sensors:
        yield (
            f"{', '.join(labels)}: 'supply: auto' reads the simulated supply pressure, without noise, as no"
            " supply_sensor is set; write 'supply: sum' or 'nominal' if your machine has no such sensor"
        )


def _fit_records(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on healthy fit records that are too few for thresholds on one side, or on both."""
    assert experiment.study is not None
    rules, judged = rules_of(experiment.detection), experiment.detection.indicators
    n_fit = experiment.study.healthy.fit
    of_both = [
        f"{label}.{output.name}"
        for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items()
        if not judged or label in judged
        for output in indicator.outputs
        if output.is_score and output.direction in (None, Direction.BOTH)
    ]
    one, both = (rules.records_for_threshold(each) for each in (Direction.RISING, Direction.BOTH))
    on_both = f"scores that may alarm on both sides, such as {of_both[0]}" if of_both else ""
    rule = f"for {100.0 * rules.false_alarm_rate:g} % false alarms, {rules.threshold} needs"
    if n_fit < one:
        more = f", and {both} for {on_both}" if on_both and both > one else ""
        yield f"study.healthy.fit = {n_fit} sets no threshold: {rule} {one} records{more}"
    elif on_both and n_fit < both:
        yield f"study.healthy.fit = {n_fit} sets no threshold for {on_both}: {rule} {both} records"


def _tested_records(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each number of records that is too small for a rate."""
    study, rules = experiment.study, rules_of(experiment.detection)
    assert study is not None
    n_shift = study.healthy.shift if study.shifts else None
    false_alarms = f"shows no rate of false alarms: {100.0 * rules.false_alarm_rate:g} %"
    detection = f"is too few for one level to show {100.0 * rules.probability:g} % detection: that"
    for key, count, needed, cannot in (
        ("healthy.test", study.healthy.test, rules.records_for_false_alarms, false_alarms),
        ("healthy.shift", n_shift, rules.records_for_false_alarms, false_alarms),
        ("faults.each", study.faults.each if study.faults else None, rules.records_for_detection, detection),
    ):
        if count is not None and count < needed:
            of = f"{100.0 * rules.confidence:g} % confidence"
            each = " of each" if key == "healthy.shift" else ""
            yield f"study.{key} = {count} {cannot} needs {needed} records{each} ({of})"


def _shifts_inside(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each shift whose values the fit records may have as well."""
    study = experiment.study
    assert study is not None
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


def _charts(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on leaks that do not set in while they are watched, and on too few healthy hours."""
    study, online = experiment.study, experiment.detection.online
    if study is None or online is None:
        return
    if study.faults is not None:
        yield from _onsets(experiment, study.faults.parameter)
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


def _onsets(experiment: ExperimentConfig, parameter: str) -> Iterator[str]:
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


def _extra(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    if asks_for_extra(experiment.detection) and not has_extra():
        yield f"the report will leave out scores that need the extra: {EXTRA}"


Rule = Callable[[ExperimentConfig, Distinct], Iterable[str]]

RULES: tuple[Rule, ...] = (
    _sobol_samples,
    lambda experiment, distinct: unusual_values(experiment),
    lambda experiment, distinct: idle_parameters(experiment),
    _bands,
    _intermittent_leaks,
    _folding,
    _records,
    without_results,
    other_machines,
)
STUDY_RULES: tuple[Rule, ...] = (
    _fit_records,
    _tested_records,
    _shifts_inside,
    _free_supply_sensors,
    _charts,
    _extra,
)
"""Rules that hold for every experiment, and those for studies of detection."""
