"""Numbers behind the verdict on a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import Analysis
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.config.sections.machine import Edge, FluidConfig, LeakageConfig
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
from hydrofdi.quality.doubts import DOUBTS, SOUND, Settling, samples_per_period, settled_start
from hydrofdi.simulation.balances import Trajectory, balance_residuals
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.undecimated import (
    boundary_length,
    phase_detail_rms,
    undecimated_coefficients,
    undecimated_rms,
)
from hydrofdi.transforms.wavelet import CoefficientRms, n_phase, root_mean_square


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
    rms = undecimated_rms(records, wavelet) if is_circular else _inner_rms(records, wavelet)
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


_MACHINE = ("actuator", "fluid", "supply", "valve", "friction")
"""Sections that describe a machine."""

_USUAL_DAMPING_RATIO = 0.02
"""That of the nominal actuator of the paper; real ones have 0.05 to 0.4."""


def assess_runs(
    runs: Sequence[RunParameters],
    trajectory: Trajectory,
    measured: Trajectory,
    settlings: Sequence[Settling],
    damping_ratios: NDArray[np.float64],
) -> dict[str, NDArray[Any]]:
    """Verdicts on runs and the numbers behind them; those that failed have NaN for numbers.

    Parameters
    ----------
    trajectory : Trajectory
        What really happened.
    measured : Trajectory
        The same as the sensors show it.
    settlings : sequence of Settling, length n_run
        How its details settle.
    damping_ratios : ndarray, shape (n_run,)
        Of the hydraulic mode [-].

    Returns
    -------
    dict of str to ndarray, shape (n_run,)
        ``verdict``: the status of a run that failed; else ``ok``, or the words of its `DOUBTS`, joined by
        commas. ``cavitating_share``, ``above_supply_share``: of the samples with a chamber pressure at or
        below the vapour limit, or above the supply [-]. ``settling_change``: largest relative change of the
        RMS of a detail from the last but one period to the last [-]; NaN where the record does not contain
        two whole periods. ``settled_from``: start of the whole periods that agree with the last one [s]; NaN
        if there are none. ``clipped_share``: of the samples of P_1 at an end of its sensor's range [-].
        ``pressure_variation``: largest less least P_1, over the supply [-]. ``unusual_share``: by how much a
        parameter or the damping ratio of the mode misses its usual range: 1 less its ratio to the
        nearest end, or the inverse [-]. ``volume_residual``, ``energy_residual``: of the balances, relative.
    """
    pressure_1, pressure_2 = trajectory.chamber_1_pressure, trajectory.chamber_2_pressure
    vapour = np.array([run.fluid.vapour_pressure for run in runs])[:, None]
    supply = (1.0 + 1e-9) * trajectory.valve_supply_pressure  # at rest, a pressure is the supply
    residuals = balance_residuals(runs, trajectory)
    quality: dict[str, NDArray[Any]] = {
        "cavitating_share": np.mean((pressure_1 <= vapour) | (pressure_2 <= vapour), axis=1),
        "above_supply_share": np.mean((pressure_1 > supply) | (pressure_2 > supply), axis=1),
        "settling_change": np.array([settling.change for settling in settlings]),
        "settled_from": np.array(
            [
                math.nan if each.start is None else each.start / run.record.sampling_frequency
                for run, each in zip(runs, settlings, strict=True)
            ]
        ),
        "clipped_share": np.array([*map(_clipped_share, runs, measured.chamber_1_pressure)]),
        "pressure_variation": np.ptp(pressure_1, axis=1) / np.array([run.supply.pressure for run in runs]),
        "unusual_share": np.array([*map(_unusual_share, runs, damping_ratios)]),
        "volume_residual": residuals.volume,
        "energy_residual": residuals.energy,
    }
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    for values in quality.values():
        values[failed] = np.nan
    verdict = np.array([outcome.status for outcome in trajectory.outcomes], dtype=object)
    for row in np.flatnonzero(~failed).tolist():
        words = [word for word, doubt in DOUBTS.items() if doubt.applies(quality[doubt.number][row])]
        verdict[row] = ", ".join(words) or SOUND
    return {"verdict": verdict} | quality


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


def _unusual_share(run: RunParameters, damping_ratio: float) -> float:
    """By how much a parameter or the damping ratio misses its usual range."""
    share = max(0.0, 1.0 - damping_ratio / _USUAL_DAMPING_RATIO)
    for section, field, low, high in _usual_ranges():
        value = getattr(getattr(run, section), field)
        # Zero means that a part is absent.
        if isinstance(value, float) and value:
            size = abs(value)
            share = max(share, 1.0 - size / low if low else 0.0, 1.0 - high / size)
    return share


def _clipped_share(run: RunParameters, shown: NDArray[np.float64]) -> float:
    """Share of samples at an end of the range, or on the level of the converter that lies there."""
    sensor = run.pressure_1_sensor
    lowest = -math.inf if sensor.lowest is None else sensor.lowest
    highest = math.inf if sensor.highest is None else sensor.highest
    # The level at an end may differ from the end by rounding.
    slack = 0.5 * sensor.resolution
    return float(np.mean((shown <= lowest + slack) | (shown >= highest - slack)))
