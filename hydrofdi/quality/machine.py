"""The machine of a run: statics, speeds, hydraulic mode, longest stable steps, and leakage to the outside."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.drive import is_whole
from hydrofdi.config.machine import Edge, FluidConfig, LeakageConfig
from hydrofdi.config.request import EDGES, RunRequest
from hydrofdi.physics.cylinder import external_leakage_flow
from hydrofdi.physics.fluid import effective_bulk_modulus
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.physics.hydraulic_mode import (
    HydraulicMode,
    Pair,
    blended_conductance,
    damping_of_chamber_1,
    laminar_conductance,
    largest_stable_step,
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    pressure_gain,
    rest_pressures,
    second_order_eigenvalues,
    softest_position,
    steady_speed,
    valve_flow_pressure_coefficient,
)
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, null_position, worn_opening
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.inputs import largest_opening, largest_travel, no_load_speed
from hydrofdi.transforms import level_bands

Distinct = Callable[..., Iterable[RunRequest]]
"""Gives one run for each combination of some sections, given by their names, that occurs in an experiment."""

FIGURES = {
    "area_ratio": ("1", "A_2/A_1"),
    "held_force": ("N", "weight and constant load"),
    "rest_pressure_1": ("Pa", "P_1 at rest"),
    "rest_pressure_2": ("Pa", "P_2 at rest"),
    "largest_force_extending": ("N", "largest force out"),
    "largest_force_retracting": ("N", "largest force in"),
    "speed_extending": ("m/s", "full speed out"),
    "speed_retracting": ("m/s", "full speed in"),
    "frequency_centred": ("Hz", "f_h centred"),
    "least_frequency": ("Hz", "least f_h over the stroke"),
    "softest_position": ("m", "its position from the centre"),
    "frequency_retracted": ("Hz", "f_h retracted"),
    "frequency_extended": ("Hz", "f_h extended"),
    "pressure_gain": ("Pa/V", "pressure gain at the null"),
    "damping_ratio_null": ("1", "hydraulic damping ζ at the null"),
    "damping_ratio_extending": ("1", "hydraulic damping ζ at full speed out"),
    "damping_ratio_retracting": ("1", "hydraulic damping ζ at full speed in"),
}
"""Name of a figure → its SI unit and title. Without a stated stroke, none is at an end; without clearance or
underlap, the pressure gain is infinite and left out."""


def machine_figures(run: RunParameters) -> dict[str, float]:
    """Figures of the machine of a run, in SI, by the names of `FIGURES`; oil without air, no leak."""
    actuator, supply = run.actuator, run.supply
    area_1, area_2 = actuator.areas
    rest = rest_pressures(supply.pressure, supply.return_pressure, area_1, area_2, run.held_force)
    softest = min(
        max(softest_position(actuator.areas, actuator.volumes_at(0.0)), actuator.ends[0]), actuator.ends[1]
    )
    gains, coefficients = _null(run, rest)
    figures = {
        "area_ratio": area_2 / area_1,
        "held_force": run.held_force,
        "rest_pressure_1": rest[0],
        "rest_pressure_2": rest[1],
        "largest_force_extending": area_1 * supply.pressure - area_2 * supply.return_pressure,
        "largest_force_retracting": area_2 * supply.pressure - area_1 * supply.return_pressure,
        "frequency_centred": natural_frequency(run),
        "least_frequency": natural_frequency(run, softest),
        "softest_position": softest,
        "pressure_gain": run.valve.spool_gain * pressure_gain(area_2 / area_1, gains, coefficients),
        "damping_ratio_null": _damping_ratio(run, coefficients),
    }
    if actuator.stroke is not None:
        ends = (natural_frequency(run, position) for position in actuator.ends)
        figures |= dict(zip(("frequency_retracted", "frequency_extended"), ends, strict=True))
    for direction, motion in (("extending", 1.0), ("retracting", -1.0)):
        speed, open_edges = at_speed(run, motion)
        figures[f"speed_{direction}"] = speed
        figures[f"damping_ratio_{direction}"] = _damping_ratio(run, open_edges)
    return {name: figures[name] for name in FIGURES if math.isfinite(figures.get(name, math.nan))}


def natural_frequency(run: RunParameters, position: float = 0.0, modulus: float | None = None) -> float:
    """f_h of the hydraulic mode at a position from the centre [Hz], undamped and without air in the fluid; by
    default with β at the mean pressure."""
    actuator, beta = run.actuator, run.mean_modulus if modulus is None else modulus
    volumes = actuator.volumes_at(position)
    omega = mode_frequency(beta, actuator.areas, volumes, actuator.mass, actuator.load_stiffness)
    return omega / (2.0 * math.pi)


NEAR_BAND_EDGE = 0.25
"""A mode within so many octaves of a band's edge may answer in either level."""


def is_near_band_edge(run: RunRequest) -> bool:
    """Whether f_h is near the edge of a band of the wavelet transform of a run."""
    frequency = natural_frequency(run)
    edges = chain(*level_bands(run.record.sampling_frequency, run.wavelet.levels))
    return frequency > 0.0 and min(abs(math.log2(frequency / edge)) for edge in edges) < NEAR_BAND_EDGE


def _damping_ratio(run: RunParameters, coefficients: Pair) -> float:
    """ζ with the piston centred, from K_c of each chamber [m³/(s·Pa)]."""
    actuator, beta = run.actuator, run.mean_modulus
    flows = damping_of_chamber_1(actuator.areas, actuator.volumes_at(0.0), coefficients, 0.0)  # (h4a)
    omega = 2.0 * math.pi * natural_frequency(run)
    return mode_damping_ratio(
        omega, beta, actuator.chamber_volume, actuator.mass, run.friction.viscous, *flows
    )


def _external(run: RunParameters) -> Pair:
    return run.leakage.chamber_1_coefficient, run.leakage.chamber_2_coefficient


def _null(run: RunParameters, rest: Pair) -> tuple[Pair, Pair]:
    """Flow gain [m²/s] and K_c [m³/(s·Pa)] of each chamber at the null, between both directions."""
    edges, supply, width = run.edges, run.supply, run.valve.area_gradient
    gains, coefficients = [], []
    of_chambers = ((edges.supply_1, edges.return_1), (edges.supply_2, edges.return_2))
    for own, pressure, external in zip(of_chambers, rest, _external(run), strict=True):
        gain, coefficient = 0.0, external
        drops = supply.pressure - pressure, pressure - supply.return_pressure
        for edge, drop in zip(own, drops, strict=True):
            distance = math.hypot(edge.lap, run.valve.edge_rounding)
            # Slope of (7d) at the null: ½ (1 + s/√(s² + r²)), s = −x_0; ½ if the edge has neither.
            slope = 0.5 * (1.0 - edge.lap / distance) if distance else 0.5
            gain += edge.flow_gain * width * slope * math.sqrt(drop)
            opening = _opening(run, edge, 0.0)
            coefficient += edge.lap_leakage
            if opening and drop > 0.0:
                coefficient += valve_flow_pressure_coefficient(opening, drop, edge.flow_gain, width)
        gains.append(gain)
        coefficients.append(coefficient)
    return (gains[0], gains[1]), (coefficients[0], coefficients[1])


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
            _conductance(parameters.leakage, float(np.median(np.abs(pressure_1 - pressure_2))), coefficient),
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
    valve, edges, external = parameters.valve, parameters.edges, _external(parameters)
    null = null_position(trajectory.time, valve.null_offset, valve.null_drift)
    spool = trajectory.spool_position[run] - null
    supply, ret = trajectory.valve_supply_pressure[run], parameters.supply.return_pressure

    def edge(feeding: Edge, drop: NDArray[np.float64]) -> float:
        opening = np.maximum(np.median(np.abs(spool)) - feeding.lap, 0.0)
        gains = feeding.flow_gain, valve.area_gradient
        return valve_flow_pressure_coefficient(opening, np.median(np.abs(drop)), *gains)

    pressure_1, pressure_2 = trajectory.chamber_1_pressure[run], trajectory.chamber_2_pressure[run]
    first = edge(edges.supply_1, chamber_1_orifice_drop(spool, pressure_1, supply, ret))
    if not parameters.actuator.has_unequal_chambers:
        shared = first + 0.5 * sum(edges.clearances) + 0.5 * sum(external)
        return shared, shared
    second = edge(edges.supply_2, chamber_2_orifice_drop(spool, pressure_2, supply, ret))
    return first + edges.clearances[0] + external[0], second + edges.clearances[1] + external[1]


def _conductance(leakage: LeakageConfig, difference: float, coefficient: float) -> float:
    if not coefficient:
        return 0.0
    if leakage.law == "laminar":
        return laminar_conductance(coefficient, leakage.laminar_reference)
    if leakage.law == "blended":
        return blended_conductance(difference, coefficient, leakage.blending_pressure)
    return leakage_conductance(difference, coefficient)


def mean_external_leakage_flows(runs: Sequence[RunParameters], trajectory: Trajectory) -> NDArray[np.float64]:
    """Mean of q_el1 and q_el2 over the samples, shape (2, n_run) [m³/s]."""
    pressures = trajectory.chamber_1_pressure, trajectory.chamber_2_pressure
    means = np.array([pressure.mean(axis=1) for pressure in pressures])
    return np.asarray(external_leakage_flow(means, np.transpose([_external(run) for run in runs])))


def _opening(run: RunParameters, edge: Edge, travel: float) -> float:
    return float(worn_opening(travel - edge.lap, run.valve.edge_rounding, run.valve.gain_slope))


def at_speed(run: RunParameters, motion: float) -> tuple[float, Pair]:
    """Speed at the largest opening [m/s], extending or retracting, and K_c of each chamber there."""
    edges, supply, areas, external = run.edges, run.supply, run.actuator.areas, _external(run)
    first, second = (edges.supply_1, edges.return_2) if motion > 0.0 else (edges.return_1, edges.supply_2)
    opened = [
        edge.flow_gain * run.valve.area_gradient * _opening(run, edge, largest_travel(run))
        for edge in (first, second)
    ]
    # Reversed if the piston retracts: chamber 2 is fed then.
    (area_in, fed), (area_out, drained) = list(zip(areas, opened, strict=True))[:: round(motion)]
    if not fed or not drained:
        return 0.0, external
    force = motion * run.held_force
    speed = steady_speed(supply.pressure, supply.return_pressure, area_in, area_out, fed, drained, force)
    if not speed:
        return 0.0, external
    # K_c = k/(2 √Δp), and √Δp = A v/k is the drop at each edge.
    own = [
        opening**2 / (2.0 * area * speed) + clearance + leakage
        for opening, area, clearance, leakage in zip(opened, areas, edges.clearances, external, strict=True)
    ]
    return speed, (own[0], own[1])


CONTACT_SHARE = 0.25
"""Share of the stable step that resolves the contact with an end stop, which is short and has a kink."""


def step_limits(distinct: Distinct) -> dict[str, float]:
    """Longest step that is stable in all runs [s], for each part of the model that some run has."""
    shortest: dict[str, float] = {}
    for part, limit, _ in _limits(distinct):
        shortest[part] = min(limit, shortest.get(part, math.inf))
    return shortest


def _limits(distinct: Distinct, *more: str) -> Iterator[tuple[str, float, RunParameters]]:
    """Parts of the model with the longest stable step of each run; its mode is undamped. None of an FMU."""
    for sections, part_limits in _PARTS:
        for run in distinct(*sections, *more):
            if run.plant.fmu is None:
                yield from ((part, limit, run) for part, limit in part_limits(run).items())


def _valve_limits(run: RunParameters) -> dict[str, float]:
    return {"valve": lag_limit(run.valve.angular_frequency, run.valve.damping_ratio)}


def _mode_limits(run: RunParameters) -> dict[str, float]:
    actuator = run.actuator
    largest = _largest_modulus(run)
    omega = 2.0 * math.pi * max(natural_frequency(run, position, largest) for position in actuator.reach)
    limits = {"hydraulic mode": lag_limit(omega, 0.0)}
    hydraulic = largest / _least_volume(run)
    if actuator.hose_volume:
        line = (actuator.hose_modulus / actuator.hose_volume + hydraulic) / actuator.hose_inertance
        limits["hoses"] = lag_limit(math.sqrt(line), 0.0)
    if actuator.foundation_stiffness is not None:
        stiffness = actuator.foundation_stiffness + 2.0 * hydraulic * max(actuator.areas) ** 2
        limits |= _decay_limit("foundation", stiffness / actuator.foundation_damping)
    if actuator.end_stops == "elastic":
        stiffness = actuator.mass * omega**2 + actuator.end_stop_stiffness
        limits["end stops"] = CONTACT_SHARE * lag_limit(math.sqrt(stiffness / actuator.mass), 0.0)
    return limits


def _friction_limits(run: RunParameters) -> dict[str, float]:
    law = FRICTION_LAWS[run.friction.law]
    largest = run.friction.largest(run.supply.pressure)
    eigenvalues = law.eigenvalues(largest, run.actuator.mass, no_load_speed(run))
    return {law.zone: min(map(largest_stable_step, eigenvalues))} if eigenvalues else {}


def _chamber_limits(run: RunParameters) -> dict[str, float]:
    """Rate [1/s] at which clearances and external leakage let the pressure of a chamber go."""
    leakage = run.leakage
    external = max(leakage.chamber_1_coefficient, leakage.chamber_2_coefficient)
    rate = _largest_modulus(run) * (max(run.edges.clearances) + external) / _least_volume(run)
    return _decay_limit("leakage of the chambers", rate)


def _supply_limits(run: RunParameters) -> dict[str, float]:
    """Rates [1/s] of supply and return pressure, which lessen the flow through open edges and clearances."""
    valve, supply, edges = run.valve, run.supply, run.edges
    opening, gain = largest_opening(run), max(edge.flow_gain for edge in edges)
    drop = 0.5 * (supply.pressure - supply.return_pressure)
    edge = valve_flow_pressure_coefficient(opening, drop, gain, valve.area_gradient)
    clearances = edges.supply_1.lap_leakage + edges.supply_2.lap_leakage
    drained = edges.return_1.lap_leakage + edges.return_2.lap_leakage
    rate = (1.0 + supply.droop_resistance * (clearances + edge)) / supply.used_time_constant
    limits = _decay_limit("supply", rate)
    if supply.return_resistance:
        rate = (1.0 + supply.return_resistance * (drained + edge)) / supply.return_time_constant
        limits |= _decay_limit("return line", rate)
    return limits


def _decay_limit(part: str, rate: float) -> dict[str, float]:
    """Longest step for a part that decays with a rate [1/s]; none if it does not."""
    return {part: largest_stable_step(complex(-rate))} if rate > 0.0 else {}


_PARTS: tuple[tuple[tuple[str, ...], Callable[[RunParameters], dict[str, float]]], ...] = (
    (("valve",), _valve_limits),
    (("actuator", "fluid", "supply"), _mode_limits),
    (("actuator", "friction", "valve", *EDGES, "supply", "input", "control", "record"), _friction_limits),
    (("actuator", "fluid", "supply", "leakage", "valve", *EDGES), _chamber_limits),
    (("supply", "valve", *EDGES, "input", "control", "record"), _supply_limits),
)
"""Sections that steps depend on, and the limits that they set."""


def _largest_modulus(run: RunParameters) -> float:
    """β without air at the supply pressure [Pa]."""
    return run.fluid.modulus_at(run.supply.pressure)


def _least_volume(run: RunParameters) -> float:
    """Volume of the smaller chamber, at the end of a stated stroke [m³]."""
    return min(min(run.actuator.volumes_at(position)) for position in run.actuator.reach)


def long_steps(distinct: Distinct) -> list[str]:
    """A sentence on each part of the model for which the step of some run is too long."""
    shortest: dict[str, tuple[float, float, float]] = {}
    for part, limit, run in _limits(distinct, "record"):
        if run.record.step > limit:
            own = limit, run.record.step, run.record.sampling_frequency
            shortest[part] = min(shortest.get(part, own), own)
    return [
        too_long_sentence(part, step, limit, frequency) for part, (limit, step, frequency) in shortest.items()
    ]


def too_long_sentence(part: str, step: float, limit: float, sampling_frequency: float) -> str:
    """That a step is too long for a part of the model, and the next that divides the sampling interval."""
    return (
        f"the step of {step:g} s is too long for the {part}: Runge-Kutta is stable up to {limit:.3g} s;"
        f" give record.step: {1e3 * _valid_step(limit, 1.0 / sampling_frequency):g} ms"
    )


def _valid_step(limit: float, interval: float) -> float:
    """The longest step of at most three digits, not above a limit, that divides an interval."""
    first = max(math.ceil(interval / limit), 1)
    steps = (float(f"{interval / count:.3g}") for count in range(first, 10 * first))
    sound = (step for step in steps if step <= limit and is_whole(interval / step))
    return next(sound, interval / first)


def lag_limit(frequency: float, damping_ratio: float) -> float:
    """Longest stable step of a lag of second order with an angular frequency [rad/s]."""
    return min(largest_stable_step(value) for value in second_order_eigenvalues(frequency, damping_ratio))
