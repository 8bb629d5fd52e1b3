"""From when on a record has settled: judged by its details, period by period."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.record import is_whole
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.undecimated import undecimated_rms

SETTLED_CHANGE = 1e-3
"""Periods agree where no detail's RMS differs by more than this share. It moves a δ by 0.2 points at most."""

LEAST_DETAIL = 1e-9
"""A detail's RMS below this share of the supply pressure is rounding and counts as this much."""


@dataclass(frozen=True)
class Settling:
    """How a record settles.

    Attributes
    ----------
    change : float
        Largest relative change of the RMS of a detail from the last but one period to the last [-]; NaN where
        the record does not contain two whole periods.
    start : int or None
        First sample of the whole periods that agree with the last one, of which there are two at least; None
        if there are none.
    """

    change: float
    start: int | None


UNKNOWN = Settling(math.nan, None)

_WAVELET = WaveletConfig()


def settled_start(run: RunParameters, n_period: int, settled_from: float, n_discarded: int) -> int:
    """First sample of the settled periods that an analysis may take; the record's end where two are not left.

    Parameters
    ----------
    run : RunParameters
    n_period : int
        Samples of a period.
    settled_from : float
        Start of all settled periods [s]; NaN if there are none.
    n_discarded : int
        Samples that the analysis leaves out.
    """
    record = run.record
    if math.isnan(settled_from):
        return record.n_sample
    first = max(round(settled_from * record.sampling_frequency), n_discarded)
    n_whole = (record.n_sample - first) // n_period
    return record.n_sample - n_whole * n_period if n_whole > 1 else record.n_sample


def how_records_settle(runs: Sequence[RunParameters], pressure: NDArray[np.float64]) -> list[Settling]:
    """How the details of each run settle.

    Each period is taken as a circle, so that a drift from its start to its end shows as well. Periods are
    counted from the end of the record. The details are those of the paper's wavelet, whatever a record is
    analysed with.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
    pressure : ndarray, shape (n_run, n_time)
        Chamber-1 pressure as it really is [Pa].
    """
    return [_settling(run, record) for run, record in zip(runs, pressure, strict=True)]


def samples_per_period(run: RunParameters) -> int | None:
    """Samples of a period of all that acts on the actuator; None if there is none, or no whole number."""
    samples = run.input.period * run.record.sampling_frequency
    return round(samples) if run.is_periodic and is_whole(samples) else None


def _settling(run: RunParameters, record: NDArray[np.float64]) -> Settling:
    n_period = samples_per_period(run)
    if n_period is None or record.size < 2 * n_period:
        return UNKNOWN
    n_whole = record.size // n_period
    periods = record[record.size - n_whole * n_period :].reshape(n_whole, n_period)
    rms = np.maximum(undecimated_rms(periods, _WAVELET).detail, LEAST_DETAIL * run.supply.pressure)
    changes = np.abs(rms / rms[-1] - 1.0).max(axis=1)
    unsettled = np.flatnonzero(~(changes <= SETTLED_CHANGE))
    first = int(unsettled[-1]) + 1 if unsettled.size else 0
    start = record.size - (n_whole - first) * n_period if first < n_whole - 1 else None
    return Settling(float(changes[-2]), start)
