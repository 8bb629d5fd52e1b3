"""The kernel against SciPy's solvers, on random actuators from the admissible ranges."""

from __future__ import annotations

from functools import cache
from typing import Any, Literal

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import PAPER
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.kernels.lanes import ModelOptions
from hydrofdi.transforms.wavelet import detail_rms
from tests.second_solver import simulate_with_solver

RANGES = {
    "actuator.chamber_volume": (160e-6, 470e-6),
    "actuator.load_stiffness": (15e3, 150e3),
    "fluid.bulk_modulus": (551e6, 827e6),
    "valve.spool_gain": (22e-6, 40.6e-6),
    "friction.coulomb": (20.0, 200.0),
    "friction.viscous": (50.0, 500.0),
    "friction.transition": (4.0, 400.0),
    "input.amplitude": (1.0, 2.0),
}
BASE = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5, "record.step": 2e-5})
PRESSURE_BOUND, RMS_BOUND = 200.0, 1e-4
"""Largest difference of P_1 at any sample [Pa], and largest relative difference of any detail RMS."""


@cache
def actuators() -> tuple[list[RunParameters], list[float]]:
    generator = np.random.default_rng(2015)
    runs, coefficients = [], []
    for _ in range(20):
        values = {name: float(generator.uniform(*limits)) for name, limits in RANGES.items()}
        values["friction.breakaway"] = 1.25 * values["friction.coulomb"]
        runs.append(BASE.with_values(values))
        coefficients.append(float(generator.uniform(0.0, 6e-9)))
    return runs, coefficients


OPTIONS: tuple[dict[str, Any], ...] = (
    {
        "leakage.law": "laminar", "leakage.onset": "ramp", "leakage.onset_time": 0.2,
        "leakage.onset_duration": 0.4, "friction.law": "smooth", "fluid.law": "free_air",
        "supply.droop": "first_order",
    },
    {
        "leakage.law": "blended", "friction.law": "lugre", "valve.lap": -2e-6, "valve.lap_leakage": 1e-14,
        "return_1_edge.lap": 1e-6, "supply_2_edge.lap_leakage": 2e-14, "return_2_edge.flow_gain_ratio": 0.95,
        "valve.null_offset": 1e-6, "valve.null_drift": -5e-7,
        "load.constant_force": 300.0, "load.random_force": 500.0, "load.random_period": 0.1,
    },
    {
        "control.law": "pid", "control.amplitude": 5e-3, "control.feedback": "measured",
        "position_sensor.bias": 1e-4, "valve.largest_opening": 5e-5,
        "valve.largest_speed": 2e-2, "valve.hysteresis": 0.05, "valve.lap": 1e-6,
        "leakage.external_coefficient_1": 1e-13,
    },
    {
        "leakage.onset": "intermittent", "leakage.onset_duration": 0.2, "actuator.end_stops": "elastic",
        "actuator.end_stop_position": 0.015, "fluid.cavitation": "clamped", "input.shape": "multisine",
        "input.harmonics": 5,
    },
)  # fmt: skip
"""Every option of the model is on in a quarter of the actuators."""


@cache
def cases(options: str) -> tuple[list[RunParameters], list[float], Trajectory]:
    runs, coefficients = actuators()
    if options == "on":
        runs = [run.with_values(OPTIONS[k % len(OPTIONS)]) for k, run in enumerate(runs)]
    return runs, coefficients, simulate_batch(runs, coefficients)


def test_every_option_is_on_in_some_case() -> None:
    chosen = [ModelOptions.of(run) for run in cases("on")[0]]
    assert all(any(values) for values in zip(*(options[:-1] for options in chosen), strict=True))
    assert {run.friction.law for run in cases("on")[0]} == set(FRICTION_LAWS)
    assert {ModelOptions.of(run) for run in cases("off")[0]} == {ModelOptions()}


@pytest.mark.parametrize("options", ["off", "on"])
@pytest.mark.parametrize(
    ("solver", "tolerance", "n_run"),
    [
        pytest.param("lsoda", 1e-8, 8, id="lsoda"),
        pytest.param("radau", 1e-6, 4, id="radau"),
        pytest.param("lsoda", 1e-8, 40, id="lsoda-all", marks=pytest.mark.long),
        pytest.param("radau", 1e-6, 40, id="radau-all", marks=pytest.mark.long),
    ],
)
def test_solver_with_error_control_agrees_with_the_kernel(
    solver: Literal["lsoda", "radau"], tolerance: float, n_run: int, options: str
) -> None:
    runs, coefficients, kernel = cases(options)
    opinion = simulate_with_solver(runs[:n_run], coefficients[:n_run], solver, tolerance)
    pressure = kernel.chamber_1_pressure[:n_run]
    assert all(outcome.is_ok for outcome in opinion.outcomes)
    assert np.abs(opinion.chamber_1_pressure - pressure).max() < PRESSURE_BOUND
    ratio = detail_rms(opinion.chamber_1_pressure, PAPER) / detail_rms(pressure, PAPER)
    assert np.abs(ratio - 1.0).max() < RMS_BOUND


def test_solver_that_gives_up_is_a_failed_run() -> None:
    impossible = BASE.with_values(
        {"actuator.load_stiffness": 0.0, "input.amplitude": 30.0, "record.duration": 2.0, "input.period": 2.0}
    )
    opinion = simulate_with_solver([impossible], [0.0], "lsoda")
    assert opinion.outcomes[0].status == "stroke_exceeded"
