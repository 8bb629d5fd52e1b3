"""What can be said of runs without simulating them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from hydrofdi.assessment.step_limits import Distinct, step_warnings, undamped_frequency
from hydrofdi.config import RunParameters
from hydrofdi.config.analysis import DEFAULT_CHOICE, IndicatorChoice
from hydrofdi.config.sections.input import InputConfig
from hydrofdi.config.sections.record import is_whole
from hydrofdi.config.shown_values import shown_value
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import boundary_shares, level_bands

NEAR_BAND_EDGE = 0.25
"""A mode within so many octaves of a band's edge may answer in either level."""

MANY_BOUNDARY_COEFFICIENTS = 0.25
"""Share of a level's coefficients from which on its RMS depends on the extension of the record."""

FEW_SAMPLES = 20
"""Samples per period of an intermittent leak below which its mean flow, a mean over samples, is off."""

_FEW = 3

_OF_WAVELETS = ("dwt", "a4", "modwt", "wavelet_packet")

Bands = Sequence[tuple[float, float]]


def plan_warnings(distinct: Distinct, choice: IndicatorChoice = DEFAULT_CHOICE) -> list[str]:
    """Sentences on step, bands and record of runs, each said once.

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
    sentences = step_warnings(distinct)
    sentences += band_warnings(distinct) if measures_wavelets(choice) else []
    sentences += _onset_warnings(distinct) + folding_warnings(distinct)
    for n_period, n_kept, wavelet in records:
        sentences += record_warnings(n_period, boundary_shares(n_kept, wavelet))
    return list(dict.fromkeys(sentences))


def measures_wavelets(choice: IndicatorChoice) -> bool:
    """Whether one of the indicators has the bands of a wavelet transform."""
    made = choice.made(WaveletConfig()).values()
    return any(getattr(each.options, "of", each.name) in _OF_WAVELETS for each in made)


def band_warnings(distinct: Distinct) -> list[str]:
    """A sentence on the EBM whose mode is near the edge of a band; none if there are no such."""
    modes = {
        (undamped_frequency(run) / (2.0 * math.pi), run.fluid.bulk_modulus): run
        for run in distinct("actuator", "fluid", "record", "wavelet")
    }
    near = [
        (frequency, modulus)
        for (frequency, modulus), run in modes.items()
        if place_in_bands(frequency, level_bands(run.record.sampling_frequency, run.wavelet.levels))[1]
        < NEAR_BAND_EDGE
    ]
    return [f"{sentence} (see 'hydrofdi check')" for sentence in near_edge_warnings(near, len(modes))]


def near_edge_warnings(near: Iterable[tuple[float, float]], n_all: int) -> list[str]:
    """A sentence on modes near the edge of a band; none if there are no such.

    Parameters
    ----------
    near : iterable of (float, float)
        f_h [Hz] and EBM [Pa] of each.
    n_all : int
        Number of modes that were looked at.
    """
    different = list(dict.fromkeys(near))
    if not different:
        return []
    frequency, modulus = different[0]
    first = f"{frequency:.1f} Hz at EBM {shown_value('fluid.bulk_modulus', modulus)}"
    sentence = "The hydraulic mode f_h is close to the edge of a wavelet band, so both bands respond to it"
    if len(different) == 1:
        return [f"{sentence}: {first}"]
    return [f"{sentence} in {len(different):,} of {n_all:,} conditions, e.g. {first}"]


def few_of(texts: Iterable[str]) -> str:
    """The first three different ones of many texts, and how many more there are."""
    different = list(dict.fromkeys(texts))
    more = f" and {len(different) - _FEW:,} more" if len(different) > _FEW else ""
    return ", ".join(different[:_FEW]) + more


def _onset_warnings(distinct: Distinct) -> list[str]:
    return [
        f"an intermittent leak of period {run.leakage.onset_duration:g} s is sampled only"
        f" {run.leakage.onset_duration * run.record.sampling_frequency:g} times in it: its mean flow is off"
        for run in distinct("leakage", "record")
        if run.leakage.onset == "intermittent"
        and run.leakage.onset_duration * run.record.sampling_frequency < FEW_SAMPLES
    ]


def folding_warnings(distinct: Distinct) -> list[str]:
    """A sentence on each input, and on each anti-alias filter, that is too fast for the sampling."""
    return [*_input_warnings(distinct), *_filter_warnings(distinct)]


def _input_warnings(distinct: Distinct) -> list[str]:
    inputs = dict.fromkeys((run.input, run.record.sampling_frequency) for run in distinct("input", "record"))
    return [
        f"{sentence} more than half of record.sampling_frequency = {sampling:g} Hz"
        for drive, sampling in inputs
        if (sentence := _fast_input(drive, 0.5 * sampling))
    ]


def _filter_warnings(distinct: Distinct) -> list[str]:
    filters = dict.fromkeys(
        (run.measurement.anti_alias, run.record.sampling_frequency)
        for run in distinct("measurement", "record")
    )
    return [
        f"measurement.anti_alias = {corner:g} Hz is not below half of record.sampling_frequency ="
        f" {sampling:g} Hz: sampling folds what it lets pass"
        for corner, sampling in filters
        if corner is not None and corner >= 0.5 * sampling
    ]


def _fast_input(drive: InputConfig, limit: float) -> str:
    """What is faster than a limit [Hz]; empty if nothing is."""
    if drive.shape == "sweep" and drive.end_frequency > limit:
        return f"input.end_frequency = {drive.end_frequency:g} Hz is"
    highest = drive.harmonics / drive.period
    if drive.shape == "multisine" and highest > limit:
        return f"input.harmonics = {drive.harmonics} reach {highest:g} Hz,"
    return ""


def record_warnings(n_period: float, boundary: Sequence[float]) -> Iterator[str]:
    """Sentences on a record.

    Parameters
    ----------
    n_period : float
        Periods that it holds; NaN without a period.
    boundary : sequence of float
        Share of each level's coefficients that depend on its extension.
    """
    if math.isfinite(n_period) and not is_whole(n_period):
        yield f"the record holds {n_period:g} periods, no whole number: features depend on where it ends"
    many = [
        f"{share:.0%} of the coefficients of d{level}"
        for level, share in enumerate(boundary, 1)
        if share > MANY_BOUNDARY_COEFFICIENTS
    ]
    if many:
        yield f"{' and '.join(many)} depend on the extension of the record"


def period_count(run: RunParameters) -> float:
    """Periods of the input in the record; NaN if it has none."""
    return run.record.duration / run.input.period if run.input.is_periodic else math.nan


def place_in_bands(frequency: float, bands: Bands) -> tuple[int, float]:
    """Level whose band holds a frequency, and its distance from the nearest edge in octaves."""
    edges = [bands[0][1], *(low for low, _ in bands)]
    level = sum(frequency < edge for edge in edges)
    if not frequency > 0.0:
        return level, math.nan
    return level, min(abs(math.log2(frequency / edge)) for edge in edges)
