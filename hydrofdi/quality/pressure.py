"""What is measured of the chamber-1 pressure: of the record as configured, and of the settled record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.quality.settling import Settling, samples_per_period
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.phases import phase_rms
from hydrofdi.transforms.undecimated import (
    boundary_length,
    phase_detail_rms,
    undecimated_coefficients,
    undecimated_rms,
)
from hydrofdi.transforms.wavelet import CoefficientRms, coefficient_rms, n_phase, root_mean_square

Array = NDArray[np.float64]


def pressure_features(
    runs: Sequence[RunParameters], pressure: Array, settlings: Sequence[Settling]
) -> dict[str, Array]:
    """Features of chamber-1 pressures.

    Those as configured are all of one window, what ``run.discard`` leaves. Those of the settled record are
    undecimated and free of boundaries: whole periods are taken as a circle; a record without a period is
    taken as configured, less the coefficients that look back beyond its start.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        All with the same duration, sampling frequency, number of levels, and phases measured.
    pressure : ndarray, shape (n_run, n_time)
        As the sensor shows it [Pa].
    settlings : sequence of Settling, length n_run

    Returns
    -------
    dict
        ``mean_chamber_1_pressure`` (n_run,); ``detail_rms``, ``approximation_rms``, ``settled_detail_rms``
        and ``settled_approximation_rms`` (n_run, n_level); where ``wavelet.phase`` is ``all`` also
        ``phase_detail_rms`` and ``settled_phase_detail_rms`` (n_run, n_phase, n_level). All in Pa; settled
        ones are NaN for periodic records that have not settled.
    """
    features: dict[str, Array] = {}
    for start, is_circular, members in _windows(runs, settlings):
        run, records = runs[members[0]], pressure[members]
        part = _configured(run, records[:, run.n_discarded :])
        part |= _settled(run.wavelet, records[:, start:], start - run.n_discarded, is_circular)
        for name, values in part.items():
            features.setdefault(name, np.empty((len(runs), *values.shape[1:])))[members] = values
    return features


def _configured(run: RunParameters, kept: Array) -> dict[str, Array]:
    wavelet = run.wavelet
    rms = coefficient_rms(kept[:, wavelet.first_sample :], wavelet)
    features = {
        "mean_chamber_1_pressure": np.mean(kept, axis=1),
        "detail_rms": rms.detail,
        "approximation_rms": rms.approximation,
    }
    return features | ({"phase_detail_rms": phase_rms(kept, wavelet)} if wavelet.phase == "all" else {})


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
    runs: Sequence[RunParameters], settlings: Sequence[Settling]
) -> Iterator[tuple[int, bool, list[int]]]:
    """First settled sample, whether the record from there on is a circle, and the runs of which this is so.

    Runs that come together are analysed alike; a record that has not settled has no settled sample.
    """
    groups: dict[object, tuple[int, bool, list[int]]] = {}
    for position, (run, settling) in enumerate(zip(runs, settlings, strict=True)):
        is_circular = samples_per_period(run) is not None
        start = settling.start if is_circular else run.n_discarded
        start = run.run.n_sample if start is None else start
        key = run.wavelet, run.n_discarded, start, is_circular
        groups.setdefault(key, (start, is_circular, []))[2].append(position)
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
