"""The longest Runge-Kutta step that each part of a run allows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.plausibility import idle_parameters, unusual_values
from hydrofdi.config.request import EDGES, RunRequest
from hydrofdi.config.sections.drive import is_whole
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.physics.hydraulic_mode import (
    largest_stable_step,
    second_order_eigenvalues,
    valve_flow_pressure_coefficient,
)
from hydrofdi.quality.machine import natural_frequency
from hydrofdi.simulation.inputs import largest_opening, no_load_speed

Distinct = Callable[..., Iterable[RunRequest]]
"""Gives one run for each combination of some sections, given by their names, that occurs in an experiment."""

CONTACT_SHARE = 0.25
"""Share of the stable step that resolves the contact with an end stop, which is short and has a kink."""


def step_limits(distinct: Distinct) -> dict[str, float]:
    """Longest step that is stable in all runs [s], for each part of the model that some run has."""
    shortest: dict[str, float] = {}
    for part, limit, _ in _limits(distinct):
        shortest[part] = min(limit, shortest.get(part, math.inf))
    return shortest


def _limits(distinct: Distinct, *more: str) -> Iterator[tuple[str, float, RunParameters]]:
    """Parts of the model with the longest stable step of each run; its mode is undamped."""
    for sections, part_limits in _PARTS:
        for run in distinct(*sections, *more):
            yield from ((part, limit, run) for part, limit in part_limits(run).items())


def _valve_limits(run: RunParameters) -> dict[str, float]:
    return {"valve": lag_limit(run.valve.angular_frequency, run.valve.damping_ratio)}


def _mode_limits(run: RunParameters) -> dict[str, float]:
    actuator = run.actuator
    largest = _largest_modulus(run)
    omega = 2.0 * math.pi * max(natural_frequency(run, place, largest) for place in actuator.reach)
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


def likely_mistakes(
    experiment: ExperimentConfig, distinct: Distinct, *, with_sweep: bool = True
) -> list[str]:
    """Unusual values, parameters without effect, and steps that are too long."""
    doubts = unusual_values(experiment, with_sweep=with_sweep) + idle_parameters(experiment)
    return doubts + step_warnings(distinct)


def step_warnings(distinct: Distinct) -> list[str]:
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
