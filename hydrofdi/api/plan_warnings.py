"""What can be said of runs without simulating them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from math import isclose

import numpy as np

from hydrofdi.api.step_limits import Distinct, undamped_frequency
from hydrofdi.api.study_warnings import study_warnings
from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.experiment import DEFAULT_CHOICE, IndicatorChoice
from hydrofdi.config.plausibility import idle_parameters, unusual_values
from hydrofdi.config.request import parameter_names
from hydrofdi.config.sections.drive import InputConfig, is_whole
from hydrofdi.config.shown_values import shown_parameter, shown_value
from hydrofdi.indicators.nominal_actuator import plant_constants
from hydrofdi.records import RecordBatch
from hydrofdi.settings.counting import counted
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.readable import typeset
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period
from hydrofdi.transforms.configuration import WaveletConfig
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


def experiment_warnings(experiment: ExperimentConfig, distinct: Distinct) -> list[str]:
    """All that is said of an experiment before it runs, each once: by `check` and `plan` alike."""
    choice, warnings = experiment.indicator_choice, []
    for sample in (experiment.ensemble.sample, experiment.sweep.sample):
        if sample and sample.method == "sobol" and sample.count & (sample.count - 1):
            points = counted(sample.count, "point")
            warnings.append(f"a Sobol sample of {points} is not balanced; take a power of two")
    warnings += unusual_values(experiment) + idle_parameters(experiment)
    warnings += plan_warnings(distinct, choice) + indicator_warnings(distinct, choice)
    warnings += other_machine_warnings(experiment) + study_warnings(experiment)
    return list(dict.fromkeys(warnings))


def plan_warnings(distinct: Distinct, choice: IndicatorChoice = DEFAULT_CHOICE) -> list[str]:
    """Sentences on bands, sampling and record of runs, each said once.

    Parameters
    ----------
    distinct : callable
        Gives one run for each combination of sections that occurs, such as ``Runs.distinct``.
    choice : IndicatorChoice
        What is measured: bands matter only to wavelets.
    """
    records = dict.fromkeys(
        (period_count(run), run.n_kept, run.wavelet)
        for run in distinct("input", "load", "record", "analysis", "wavelet")
    )
    sentences = [*_band_warnings(distinct)] if measures_wavelets(choice) else []
    sentences += [*_onset_warnings(distinct), *_folding_warnings(distinct)]
    for n_period, n_kept, wavelet in records:
        sentences += _record_warnings(n_period, boundary_shares(n_kept, wavelet))
    return list(dict.fromkeys(sentences))


def measures_wavelets(choice: IndicatorChoice) -> bool:
    """Whether one of the indicators has the bands of a wavelet transform."""
    made = choice.made(WaveletConfig()).values()
    return any(getattr(each.options, "of", each.name) in _OF_WAVELETS for each in made)


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


def _band_warnings(distinct: Distinct) -> Iterator[str]:
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
            "The hydraulic mode f_h is close to the edge of a wavelet band, so both bands respond to it"
            f"{where} {first}. Another record.sampling_frequency moves the bands; the undecimated transform"
            " (modwt) has the same ones"
        )


def _onset_warnings(distinct: Distinct) -> Iterator[str]:
    for run in distinct("leakage", "record"):
        n_sample = run.leakage.onset_duration * run.record.sampling_frequency
        if run.leakage.onset == "intermittent" and n_sample < FEW_SAMPLES:
            yield (
                f"an intermittent leak of period {run.leakage.onset_duration:g} s is sampled only"
                f" {n_sample:g} times in it: its mean flow is off"
            )


def _folding_warnings(distinct: Distinct) -> Iterator[str]:
    for run in distinct("input", "record"):
        sampling = run.record.sampling_frequency
        if sentence := _fast_input(run.input, 0.5 * sampling):
            yield f"{sentence} more than half of record.sampling_frequency = {sampling:g} Hz"
    for run in distinct("measurement", "record"):
        corner, sampling = run.measurement.anti_alias, run.record.sampling_frequency
        if corner is not None and corner >= 0.5 * sampling:
            yield (
                f"measurement.anti_alias = {corner:g} Hz is not below half of record.sampling_frequency ="
                f" {sampling:g} Hz: sampling folds what it lets pass"
            )


def _fast_input(drive: InputConfig, limit: float) -> str:
    """What is faster than a limit [Hz]; empty if nothing is."""
    if drive.shape == "sweep" and drive.end_frequency > limit:
        return f"input.end_frequency = {drive.end_frequency:g} Hz is"
    highest = drive.harmonics / drive.period
    if drive.shape == "multisine" and highest > limit:
        return f"input.harmonics = {drive.harmonics} reach {highest:g} Hz,"
    return ""


def _record_warnings(n_period: float, boundary: Sequence[float]) -> Iterator[str]:
    if math.isfinite(n_period) and not is_whole(n_period):
        yield f"the record holds {n_period:g} periods, no whole number: features depend on where it ends"
    many = [
        f"{share:.0%} of the coefficients of d{level}"
        for level, share in enumerate(boundary, 1)
        if share > MANY_BOUNDARY_COEFFICIENTS
    ]
    if many:
        yield f"{' and '.join(many)} depend on the extension of the record"


def indicator_warnings(distinct: Distinct, choice: IndicatorChoice) -> list[str]:
    """A sentence on each indicator that cannot measure the records of some runs, and why."""
    records = dict.fromkeys(
        (
            run.n_kept,
            run.record.sampling_frequency,
            drive_period(run.input, run.load.random_force),
            run.wavelet,
        )
        for run in distinct("input", "load", "record", "analysis", "wavelet")
    )
    sentences: list[str] = []
    for n_kept, frequency, period, wavelet in islice(records, MOST_RECORDS):
        signals = dict.fromkeys(SIGNAL_OF_CHANNEL, np.broadcast_to(0.0, (1, n_kept)))
        batch = RecordBatch(signals, frequency, ("",), drive_period=period)
        obstacles = {label: each.obstacle(batch) for label, each in choice.made(wavelet).items()}
        sentences += [f"{label} will have no results: {text}" for label, text in obstacles.items() if text]
    return list(dict.fromkeys(sentences))


def other_machine_warnings(experiment: ExperimentConfig) -> list[str]:
    """A sentence on each indicator whose constants of the plant are not those of the nominal machine."""
    labels: dict[str, list[str]] = {}
    for label, each in experiment.indicator_choice.made(experiment.wavelet).items():
        labels.setdefault(", ".join(_differing(experiment, each.options)), []).append(label)
    return [
        f"{', '.join(of)}: the options describe another machine: {text}; a YAML alias such as *area keeps the"
        " value of the file in which it stands"
        for text, of in labels.items()
        if text
    ]


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
