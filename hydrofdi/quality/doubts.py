"""What simulated records are worth: how they settle, features of what has settled, what decides doubts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi import transforms as undecimated
from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import Analysis
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.transforms import WaveletConfig, n_phase, root_mean_square

if TYPE_CHECKING:
    from hydrofdi.simulation.balances import Trajectory

Array = NDArray[np.float64]

LEAST_DETAIL = 1e-9
"""A detail's RMS below this share of the supply pressure is rounding and counts as this much."""

_WAVELET = WaveletConfig()


def how_records_settle(
    runs: Sequence[RunParameters], pressure: Array, agreement: float
) -> tuple[Array, Array]:
    """How the details of each run settle.

    Each period is taken as a circle, so that a drift from its start to its end shows as well. Periods are
    counted from the end of the record. The details are those of the paper's wavelet, whatever a record is
    analysed with.

    Parameters
    ----------
    pressure : ndarray, shape (n_run, n_time)
        Chamber-1 pressure as it really is [Pa].
    agreement : float
        Largest relative change of the RMS of a detail between periods that agree [-].

    Returns
    -------
    changes : ndarray, shape (n_run,)
        Largest relative change of the RMS of a detail from the last but one period to the last [-]; NaN where
        the record does not contain two whole periods.
    settled_from : ndarray, shape (n_run,)
        Start of the whole periods that agree with the last one, of which there are two at least [s]; NaN if
        there are none.
    """
    changes, settled_from = np.full((2, len(runs)), np.nan)
    together: dict[int, list[int]] = {}
    n_sample = pressure.shape[1]
    for row, run in enumerate(runs):
        n_period = run.samples_per_period
        if n_period is not None and n_sample >= 2 * n_period:
            together.setdefault(n_period, []).append(row)
    for n_period, rows in together.items():
        n_whole = n_sample // n_period
        periods = pressure[rows, -n_whole * n_period :].reshape(len(rows), n_whole, n_period)
        for row, rms in zip(rows, undecimated.undecimated_rms(periods, _WAVELET).detail, strict=True):
            rms = np.maximum(rms, LEAST_DETAIL * runs[row].supply.pressure)
            different = np.abs(rms / rms[-1] - 1.0).max(axis=1)
            changes[row] = different[-2]
            # Negated, so that NaN counts as unsettled.
            unsettled = np.flatnonzero(~(different <= agreement))
            first = int(unsettled[-1]) + 1 if unsettled.size else 0
            # At least two periods agree: the last one always does with itself.
            if first < n_whole - 1:
                start = n_sample - (n_whole - first) * n_period
                settled_from[row] = start / runs[row].record.sampling_frequency
    return changes, settled_from


def pressure_features(
    runs: Sequence[RunParameters], analysis: Analysis, pressure: Array, settled_from: Array
) -> dict[str, Array]:
    """What is measured of chamber-1 pressures with the knowledge of when they settled.

    The mean is that of what ``analysis.discard`` leaves. Features of the settled record are undecimated and
    free of boundaries: whole periods are taken as a circle; a record without a period is taken from what is
    left out on, less the coefficients that look back beyond that.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        All with the same duration and sampling frequency.
    analysis : Analysis
        What is left out, and the wavelet.
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
    n_run, wavelet, n_sample = len(runs), analysis.wavelet, pressure.shape[1]
    names = "settled_detail_rms", "settled_approximation_rms"
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(names, (wavelet.levels,))
    if wavelet.phase == "all":
        shapes["settled_phase_detail_rms"] = (n_phase(wavelet.levels), wavelet.levels)
    features = {name: np.full((n_run, *shape), np.nan) for name, shape in shapes.items()}
    windows: dict[tuple[int, bool], list[int]] = {}
    for row, (run, settled) in enumerate(zip(runs, settled_from.tolist(), strict=True)):
        n_period, start = run.samples_per_period, analysis.n_discarded
        if n_period is not None:
            # Whole periods, counted from the end of the record, of which there are two at least.
            first = n_sample if math.isnan(settled) else round(settled * run.record.sampling_frequency)
            n_whole = (n_sample - max(first, start)) // n_period
            start = n_sample - n_whole * n_period if n_whole > 1 else n_sample
        windows.setdefault((start, n_period is not None), []).append(row)
    for (start, is_circular), rows in windows.items():
        if start < n_sample:
            found = _settled(wavelet, pressure[rows, start:], start - analysis.n_discarded, is_circular)
            for own, values in zip(features.values(), found, strict=True):
                own[rows] = values
    return {"mean_chamber_1_pressure": np.mean(pressure[:, analysis.n_discarded :], axis=1)} | features


def _settled(wavelet: WaveletConfig, records: Array, first_sample: int, is_circular: bool) -> list[Array]:
    outside = 0 if is_circular else undecimated.boundary_length(wavelet)
    if is_circular:
        rms = undecimated.undecimated_rms(records, wavelet)
        settled = [rms.detail, rms.approximation]
    else:
        parts = undecimated.undecimated_coefficients(records, wavelet)
        settled = [root_mean_square(part[..., outside:]) for part in parts]
    if wavelet.phase == "all":
        details, _ = undecimated.undecimated_coefficients(records, wavelet)
        settled.append(undecimated.phase_detail_rms(details[..., outside:], first_sample + outside))
    return settled


_MACHINE = ("actuator", "fluid", "supply", "valve", "friction")
"""Sections that describe a machine."""

_USUAL_DAMPING_RATIO = 0.02
"""That of the nominal actuator of the paper; real ones have 0.05 to 0.4."""


class Simulated(NamedTuple):
    """What is known of simulated records: runs, what really happened, what the sensors show of it, how much
    the details change from the last but one period to the last, and damping ratios of the hydraulic modes.
    """

    runs: Sequence[RunParameters]
    trajectory: Trajectory
    measured: Trajectory
    settling_changes: Array
    damping_ratios: Array


def _cavitating_share(known: Simulated) -> Array:
    """Share of the samples with a chamber pressure at or below the vapour limit [-]."""
    vapour = np.array([run.fluid.vapour_pressure for run in known.runs])[:, None]
    signals = known.trajectory
    below = (signals.chamber_1_pressure <= vapour) | (signals.chamber_2_pressure <= vapour)
    return np.asarray(np.mean(below, axis=1))


def _above_supply_share(known: Simulated) -> Array:
    """Share of the samples with a chamber pressure above the supply [-]."""
    signals = known.trajectory
    supply = (1.0 + 1e-9) * signals.valve_supply_pressure  # at rest, a pressure is the supply
    above = (signals.chamber_1_pressure > supply) | (signals.chamber_2_pressure > supply)
    return np.asarray(np.mean(above, axis=1))


def _clipped_share(known: Simulated) -> Array:
    """Share of the samples of P_1 at an end of its sensor's range, or on the converter's level there [-]."""
    shares = []
    for run, shown in zip(known.runs, known.measured.chamber_1_pressure, strict=True):
        sensor = run.pressure_1_sensor
        lowest = -math.inf if sensor.lowest is None else sensor.lowest
        highest = math.inf if sensor.highest is None else sensor.highest
        # The level at an end may differ from the end by rounding.
        slack = 0.5 * sensor.resolution
        shares.append(float(np.mean((shown <= lowest + slack) | (shown >= highest - slack))))
    return np.array(shares)


def _pressure_variation(known: Simulated) -> Array:
    """Largest less least P_1, over the supply [-]."""
    supply = np.array([run.supply.pressure for run in known.runs])
    return np.asarray(np.ptp(known.trajectory.chamber_1_pressure, axis=1) / supply)


def _unusual_share(known: Simulated) -> Array:
    """By how much a parameter or the damping ratio of the mode misses its usual range: 1 less its ratio to
    the nearest end, or the inverse [-].
    """
    shares = []
    for run, damping_ratio in zip(known.runs, known.damping_ratios.tolist(), strict=True):
        share = max(0.0, 1.0 - damping_ratio / _USUAL_DAMPING_RATIO)
        for section, field, low, high in _usual_ranges():
            value = getattr(getattr(run, section), field)
            # Zero means that a part is absent.
            if isinstance(value, float) and value:
                size = abs(value)
                share = max(share, 1.0 - size / low if low else 0.0, 1.0 - high / size)
        shares.append(share)
    return np.array(shares)


@lru_cache(maxsize=1)
def _usual_ranges() -> list[tuple[str, str, float, float]]:
    """Section, field, and lowest and highest usual size of what describes a machine; what may be zero has no
    lowest."""
    ranges = []
    for name in parameter_names():
        (section, field), quantity = name.split("."), parameter_quantity(name)
        if section in _MACHINE and quantity is not None and quantity.usual is not None:
            low, high = quantity.usual_range
            ranges.append((section, field, low if quantity.above == 0.0 else 0.0, high))
    return ranges


def numbers_of_doubts(known: Simulated) -> dict[str, Array]:
    """The numbers that decide doubts, each of shape (n_run,)."""
    return {
        "cavitating_share": _cavitating_share(known),
        "above_supply_share": _above_supply_share(known),
        "settling_change": known.settling_changes,
        "clipped_share": _clipped_share(known),
        "pressure_variation": _pressure_variation(known),
        "unusual_share": _unusual_share(known),
    }
