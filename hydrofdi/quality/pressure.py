"""What is measured of the chamber-1 pressure if it is known when the record settled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.analysis import Analysis
from hydrofdi.quality.settling import samples_per_period, settled_start
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.undecimated import (
    boundary_length,
    phase_detail_rms,
    undecimated_coefficients,
    undecimated_rms,
)
from hydrofdi.transforms.wavelet import CoefficientRms, n_phase, root_mean_square

Array = NDArray[np.float64]


def pressure_features(
    runs: Sequence[RunParameters], analyses: Sequence[Analysis], pressure: Array, settled_from: Array
) -> dict[str, Array]:
    """What is measured of chamber-1 pressures with the knowledge of when they settled.

    The mean is that of what ``analysis.discard`` leaves. Features of the settled record are undecimated and
    free of boundaries: whole periods are taken as a circle; a record without a period is taken from what is
    left out on, less the coefficients that look back beyond that.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        All with the same duration and sampling frequency.
    analyses : sequence of Analysis, length n_run
        All with the same number of levels, and phases measured.
    pressure : ndarray, shape (n_run, n_time)
        As the sensor shows it [Pa].
    settled_from : ndarray, shape (n_run,)
        Start of the settled periods [s]; NaN if there are none.

    Returns
    -------
    dict
        ``mean_chamber_1_pressure`` (n_run,); ``settled_detail_rms`` and ``settled_approximation_rms``
        (n_run, n_level); where ``wavelet.phase`` is ``all`` also ``settled_phase_detail_rms``
        (n_run, n_phase, n_level). All in Pa; settled ones are NaN for periodic records that have not settled.
    """
    features: dict[str, Array] = {}
    for analysis, start, is_circular, members in _windows(runs, analyses, settled_from):
        records = pressure[members]
        part = {"mean_chamber_1_pressure": np.mean(records[:, analysis.n_discarded :], axis=1)}
        part |= _settled(analysis.wavelet, records[:, start:], start - analysis.n_discarded, is_circular)
        for name, values in part.items():
            features.setdefault(name, np.empty((len(runs), *values.shape[1:])))[members] = values
    return features


def _settled(
    wavelet: WaveletConfig, records: Array, first_sample: int, is_circular: bool
) -> dict[str, Array]:
    if records.shape[1] == 0:
        return _unsettled(wavelet, records.shape[0])
    rms = undecimated_rms(records, wavelet) if is_circular else _inner_rms(records, wavelet)
    features = {"settled_detail_rms": rms.detail, "settled_approximation_rms": rms.approximation}
    if wavelet.phase == "all":
        features["settled_phase_detail_rms"] = _phases(records, wavelet, first_sample, is_circular)
    return features


def _unsettled(wavelet: WaveletConfig, n_run: int) -> dict[str, Array]:
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
        ("settled_detail_rms", "settled_approximation_rms"), (n_run, wavelet.levels)
    )
    if wavelet.phase == "all":
        shapes["settled_phase_detail_rms"] = (n_run, n_phase(wavelet.levels), wavelet.levels)
    return {name: np.full(shape, np.nan) for name, shape in shapes.items()}


def _windows(
    runs: Sequence[RunParameters], analyses: Sequence[Analysis], settled_from: Array
) -> Iterator[tuple[Analysis, int, bool, list[int]]]:
    """Analysis, first settled sample, whether the record from there on is a circle, and the runs of which
    this is so.

    Runs that come together are analysed alike; a record that has not settled has no settled sample.
    """
    groups: dict[object, tuple[Analysis, int, bool, list[int]]] = {}
    for position, (run, analysis) in enumerate(zip(runs, analyses, strict=True)):
        n_period, start = samples_per_period(run), analysis.n_discarded
        if n_period is not None:
            start = settled_start(run, n_period, float(settled_from[position]), analysis.n_discarded)
        key = analysis, start, n_period is not None
        groups.setdefault(key, (*key, []))[3].append(position)
    yield from groups.values()


def _inner_rms(records: Array, wavelet: WaveletConfig) -> CoefficientRms:
    inside = slice(boundary_length(wavelet), None)
    detail, approximation = (
        root_mean_square(coefficients[..., inside])
        for coefficients in undecimated_coefficients(records, wavelet)
    )
    return CoefficientRms(detail, approximation)


def _phases(records: Array, wavelet: WaveletConfig, first_sample: int, is_circular: bool) -> Array:
    outside = 0 if is_circular else boundary_length(wavelet)
    details, _ = undecimated_coefficients(records, wavelet)
    return phase_detail_rms(details[..., outside:], first_sample + outside)
