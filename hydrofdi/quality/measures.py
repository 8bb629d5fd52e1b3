"""What is measured of a record by who knows its run: settling, hydraulic mode, the settled part."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.drive import is_whole
from hydrofdi.config.experiment import Analysis
from hydrofdi.config.machine import Edge, FluidConfig, LeakageConfig
from hydrofdi.physics.fluid import effective_bulk_modulus
from hydrofdi.physics.hydraulic_mode import (
    HydraulicMode,
    Pair,
    blended_conductance,
    damping_of_chamber_1,
    laminar_conductance,
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    valve_flow_pressure_coefficient,
)
from hydrofdi.physics.leakage import external_leakage_flow
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, null_position
from hydrofdi.transforms import undecimated
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import CoefficientRms, n_phase, root_mean_square

if TYPE_CHECKING:
    from hydrofdi.simulation.balances import Trajectory


Array = NDArray[np.float64]

SETTLED_CHANGE = 1e-3
"""Periods agree where no detail's RMS differs by more than this share. It moves a δ by 0.2 points at most."""

LEAST_DETAIL = 1e-9
"""A detail's RMS below this share of the supply pressure is rounding and counts as this much."""

_WAVELET = WaveletConfig()


def how_records_settle(runs: Sequence[RunParameters], pressure: Array) -> tuple[Array, Array]:
    """How the details of each run settle.

    Each period is taken as a circle, so that a drift from its start to its end shows as well. Periods are
    counted from the end of the record. The details are those of the paper's wavelet, whatever a record is
    analysed with.

    Parameters
    ----------
    pressure : ndarray, shape (n_run, n_time)
        Chamber-1 pressure as it really is [Pa].

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
        n_period = samples_per_period(run)
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
            unsettled = np.flatnonzero(~(different <= SETTLED_CHANGE))
            first = int(unsettled[-1]) + 1 if unsettled.size else 0
            # At least two periods agree: the last one always does with itself.
            if first < n_whole - 1:
                start = n_sample - (n_whole - first) * n_period
                settled_from[row] = start / runs[row].record.sampling_frequency
    return changes, settled_from


def samples_per_period(run: RunParameters) -> int | None:
    """Samples of a period of all that acts on the actuator; None if there is none, or no whole number."""
    samples = run.input.period * run.record.sampling_frequency
    return round(samples) if run.is_periodic and is_whole(samples) else None


def hydraulic_mode(parameters: RunParameters, trajectory: Trajectory, run: int = 0) -> HydraulicMode:
    """Frequency and damping of the hydraulic mode at the median working point of a record.

    Valve opening, orifice drop and pressure difference are the medians of their absolute values over the
    samples; K_c and G are singular where a drop vanishes, so a mean would be ruled by single samples.

    Parameters
    ----------
    run : int
        Row of the trajectory.

    Returns
    -------
    HydraulicMode
        Frequency [Hz], piston centred, and damping ratio [-]; the ratio is infinite if the median drop
        or, with a leak, the median pressure difference vanishes.
    """
    actuator = parameters.actuator
    # NumPy's scalars, whose division by zero gives infinity instead of an error.
    area_1, area_2 = map(np.float64, actuator.areas)
    mass, areas, volumes = np.float64(actuator.mass), (area_1, area_2), actuator.volumes_at(0.0)
    pressure_1, pressure_2 = trajectory.chamber_1_pressure[run], trajectory.chamber_2_pressure[run]
    coefficient = trajectory.leakage_coefficient[run]
    with np.errstate(all="ignore"):
        beta = _modulus(parameters.fluid, pressure_1, pressure_2)
        omega = mode_frequency(beta, areas, volumes, mass, actuator.load_stiffness)
        flows = damping_of_chamber_1(
            areas, volumes, _valve_coefficients(parameters, trajectory, run),
            _conductance(parameters.leakage, _median_size(pressure_1 - pressure_2), coefficient),
        )  # fmt: skip
        damping = mode_damping_ratio(
            omega, beta, actuator.chamber_volume, mass, parameters.friction.viscous, *flows
        )
    return HydraulicMode(float(omega / (2.0 * math.pi)), float(damping))


def _modulus(fluid: FluidConfig, *pressures: NDArray[np.float64]) -> np.float64:
    """β [Pa]; if it depends on pressure, the mean of those at the median pressures of the chambers."""
    if fluid.is_constant:
        return np.float64(fluid.bulk_modulus)
    medians = [float(np.median(pressure)) for pressure in pressures]
    moduli = [fluid.modulus_at(pressure) for pressure in medians]
    if fluid.law == "free_air":
        air = fluid.free_air, fluid.polytropic_exponent, fluid.atmospheric_pressure
        moduli = [effective_bulk_modulus(*at, *air) for at in zip(medians, moduli, strict=True)]
    return np.float64(np.mean(moduli))


def _valve_coefficients(parameters: RunParameters, trajectory: Trajectory, run: int) -> Pair:
    """K_c of each chamber: the edge that feeds it, clearances and K_e [m³/(s·Pa)].

    Equal chambers share the edge of chamber 1, and the means of clearances and K_e.
    """
    valve, leakage, edges = parameters.valve, parameters.leakage, parameters.edges
    null = null_position(trajectory.time, valve.null_offset, valve.null_drift)
    spool = trajectory.spool_position[run] - null
    supply, ret = trajectory.valve_supply_pressure[run], parameters.supply.return_pressure
    external = leakage.chamber_1_coefficient, leakage.chamber_2_coefficient

    def edge(feeding: Edge, drop: NDArray[np.float64]) -> float:
        opening = np.maximum(_median_size(spool) - feeding.lap, 0.0) if feeding.lap else _median_size(spool)
        return valve_flow_pressure_coefficient(
            opening, _median_size(drop), feeding.flow_gain, valve.area_gradient
        )

    first = edge(
        edges.supply_1, chamber_1_orifice_drop(spool, trajectory.chamber_1_pressure[run], supply, ret)
    )
    if not parameters.actuator.has_unequal_chambers:
        shared = first + 0.5 * sum(edges.clearances) + 0.5 * sum(external)
        return shared, shared
    second = edge(
        edges.supply_2, chamber_2_orifice_drop(spool, trajectory.chamber_2_pressure[run], supply, ret)
    )
    return first + edges.clearances[0] + external[0], second + edges.clearances[1] + external[1]


def _conductance(leakage: LeakageConfig, difference: float, coefficient: float) -> float:
    if not coefficient:
        return 0.0
    if leakage.law == "laminar":
        return laminar_conductance(coefficient, leakage.laminar_reference)
    if leakage.law == "blended":
        return blended_conductance(difference, coefficient, leakage.blending_pressure)
    return leakage_conductance(difference, coefficient)


def _median_size(signal: Any) -> np.float64:
    """Median of abs(signal): the bits of `numpy.median`, whose checks take longer than its arithmetic."""
    size = np.abs(signal)
    low, high = (size.size - 1) // 2, size.size // 2
    size.partition((low, high, -1))  # NaN is last
    return np.float64(0.5 * (size[low] + size[high]) if size[-1] == size[-1] else np.nan)


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
    n_run, wavelet = len(runs), analyses[0].wavelet
    by_level = np.full((2, n_run, wavelet.levels), np.nan)
    names = ("mean_chamber_1_pressure", "settled_detail_rms", "settled_approximation_rms")
    features = dict(zip(names, (np.empty(n_run), *by_level), strict=True))
    if wavelet.phase == "all":
        shape = (n_run, n_phase(wavelet.levels), wavelet.levels)
        features["settled_phase_detail_rms"] = np.full(shape, np.nan)
    for analysis, start, is_circular, members in _windows(runs, analyses, settled_from):
        records = pressure[members]
        part = {"mean_chamber_1_pressure": np.mean(records[:, analysis.n_discarded :], axis=1)}
        if start < pressure.shape[1]:
            settled, first = records[:, start:], start - analysis.n_discarded
            part |= _settled(analysis.wavelet, settled, first, is_circular)
        for name, values in part.items():
            features[name][members] = values
    return features


def _settled(
    wavelet: WaveletConfig, records: Array, first_sample: int, is_circular: bool
) -> dict[str, Array]:
    rms = undecimated.undecimated_rms(records, wavelet) if is_circular else _inner_rms(records, wavelet)
    features = {"settled_detail_rms": rms.detail, "settled_approximation_rms": rms.approximation}
    if wavelet.phase == "all":
        features["settled_phase_detail_rms"] = _phases(records, wavelet, first_sample, is_circular)
    return features


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
            n_sample, settled = run.record.n_sample, float(settled_from[position])
            # Whole periods, counted from the end of the record, of which there are two at least.
            first = n_sample if math.isnan(settled) else round(settled * run.record.sampling_frequency)
            n_whole = (n_sample - max(first, start)) // n_period
            start = n_sample - n_whole * n_period if n_whole > 1 else n_sample
        key = analysis, start, n_period is not None
        groups.setdefault(key, (*key, []))[3].append(position)
    yield from groups.values()


def _inner_rms(records: Array, wavelet: WaveletConfig) -> CoefficientRms:
    inside = slice(undecimated.boundary_length(wavelet), None)
    detail, approximation = (
        root_mean_square(coefficients[..., inside])
        for coefficients in undecimated.undecimated_coefficients(records, wavelet)
    )
    return CoefficientRms(detail, approximation)


def _phases(records: Array, wavelet: WaveletConfig, first_sample: int, is_circular: bool) -> Array:
    outside = 0 if is_circular else undecimated.boundary_length(wavelet)
    details, _ = undecimated.undecimated_coefficients(records, wavelet)
    return undecimated.phase_detail_rms(details[..., outside:], first_sample + outside)


def mean_external_leakage_flows(
    runs: Sequence[RunParameters], trajectory: Trajectory
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of q_el1 and q_el2 over the samples [m³/s], each of shape (n_run,)."""
    pressures = (trajectory.chamber_1_pressure, trajectory.chamber_2_pressure)
    coefficients = (
        np.array([run.leakage.chamber_1_coefficient for run in runs]),
        np.array([run.leakage.chamber_2_coefficient for run in runs]),
    )
    first, second = (
        np.asarray(external_leakage_flow(np.mean(pressure, axis=1), coefficient))
        for pressure, coefficient in zip(pressures, coefficients, strict=True)
    )
    return first, second
