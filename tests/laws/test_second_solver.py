"""All options together: a second solver, scaling, and combinations."""

import math
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import PAPER
from hydrofdi.physics.equation import sine
from hydrofdi.physics.fluid import (
    LEAST_ABSOLUTE_PRESSURE,
    binary_exponential,
    binary_logarithm,
    effective_bulk_modulus,
)
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.simulation.balances import Trajectory, balance_residuals
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH, ModelOptions
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


def _long(*values):
    return pytest.param(*values, marks=pytest.mark.long)


@pytest.mark.parametrize(
    ("solver", "tolerance", "n_run", "options"),
    [
        ("lsoda", 1e-8, 4, "on"), ("radau", 1e-6, 2, "off"), _long("lsoda", 1e-8, 40, "off"),
        _long("lsoda", 1e-8, 40, "on"), _long("radau", 1e-6, 40, "off"), _long("radau", 1e-7, 40, "on"),
    ],
)  # fmt: skip
def test_solver_with_error_control_agrees_with_the_kernel(solver, tolerance, n_run, options):
    runs, coefficients, kernel = cases(options)
    opinion = simulate_with_solver(runs[:n_run], coefficients[:n_run], solver, tolerance)
    pressure = kernel.chamber_1_pressure[:n_run]
    assert all(outcome.is_ok for outcome in opinion.outcomes)
    assert np.abs(opinion.chamber_1_pressure - pressure).max() < PRESSURE_BOUND
    ratio = detail_rms(opinion.chamber_1_pressure, PAPER) / detail_rms(pressure, PAPER)
    assert np.abs(ratio - 1.0).max() < RMS_BOUND


ERROR = 1e-12
"""What both functions state."""

positive = st.floats(min_value=1e-300, max_value=1e300)
exponents = st.floats(min_value=-1000.0, max_value=1000.0)


@given(positive, exponents, st.integers(min_value=-1000, max_value=1000))
def test_logarithm_and_power_have_the_stated_error_and_whole_powers_are_exact(
    value: float, exponent: float, whole: int
) -> None:
    assert abs(binary_logarithm(value) - math.log2(value)) < ERROR + 2e-16 * abs(math.log2(value))
    assert binary_exponential(exponent) == pytest.approx(math.pow(2.0, exponent), rel=ERROR, abs=0.0)
    assert Fraction(float(binary_exponential(float(whole)))) == Fraction(2) ** whole
    assert binary_logarithm(2.0**whole) == whole


@given(st.floats(min_value=-1e6, max_value=1e6))
def test_sine_of_turns_has_the_stated_error(turns: float) -> None:
    assert sine(turns) == pytest.approx(math.sin(2.0 * math.pi * math.fmod(turns, 1.0)), abs=1e-9)


@given(
    pressure=st.floats(min_value=-1e6, max_value=200e6),
    liquid=st.floats(min_value=10e6, max_value=10e9),
    free_air=st.floats(min_value=0.0, max_value=0.5),
    exponent=st.floats(min_value=1.0, max_value=10.0),
    atmosphere=st.floats(min_value=10e3, max_value=1e6),
)
def test_modulus_is_the_printed_equation_over_all_usual_values(
    pressure: float, liquid: float, free_air: float, exponent: float, atmosphere: float
) -> None:
    absolute = max(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    liquid_volume = math.exp((atmosphere - absolute) / liquid)
    gas_volume = free_air * math.pow(atmosphere / absolute, 1.0 / exponent)
    slope = liquid_volume / liquid + gas_volume / (exponent * absolute)
    modulus = effective_bulk_modulus(pressure, liquid, free_air, exponent, atmosphere)
    assert modulus == pytest.approx((liquid_volume + gas_volume) / slope, rel=4.0 * ERROR, abs=0.0)


@pytest.mark.parametrize("pressure", [-1e12, -1e6, 0.0, 1e7, 1e12])
def test_modulus_of_absurd_pressures_is_finite_and_that_of_none_is_not(pressure: float) -> None:
    assert 0.0 < effective_bulk_modulus(pressure, 1.4e9, 0.01, 1.4, 101325.0) < math.inf
    assert np.isnan(effective_bulk_modulus(np.nan, 1.4e9, 0.01, 1.4, 101325.0))


SHORT = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5, "record.step": 2e-5})
CHOICES: dict[str, dict[str, Any]] = {
    "paper": {},
    "laminar": {"leakage.law": "laminar"},
    "blended": {"leakage.law": "blended"},
    "ramp": {"leakage.onset": "ramp", "leakage.onset_time": 0.2, "leakage.onset_duration": 0.4},
    "smooth": {"friction.law": "smooth"},
    "scaled": {"friction.scale": 0.3},
    "external": {"leakage.external_coefficient_1": 1e-13},
    "air": {"fluid.law": "free_air"},
    "stiffening": {"fluid.bulk_modulus_pressure_slope": 11.0},
    "saturated": {"valve.largest_opening": 3e-5},
    "hysteresis": {"valve.hysteresis": 0.2},
    "slow": {"valve.largest_speed": 2e-3},
    "overlap": {"valve.lap": 2e-6, "valve.lap_leakage": 1e-14},
    "edges": {
        "supply_1_edge.lap": 1e-6, "return_2_edge.lap_leakage": 2e-14, "supply_2_edge.flow_gain_ratio": 0.9,
    },
    "worn": {"valve.edge_rounding": 1e-6, "valve.gain_slope": 1e3},
    "null": {"valve.null_offset": 1e-6, "valve.null_drift": -5e-7},
    "stops": {"actuator.end_stops": "elastic", "actuator.end_stop_position": 0.02},
    "load": {"load.constant_force": 500.0, "load.random_force": 1000.0, "load.random_period": 0.1},
    "droop": {"supply.droop": "first_order"},
    "ripple": {"supply.ripple": 0.01},
    "return": {"supply.return_pressure": 0.4e6, "supply.return_resistance": 2e9},
    "uneven": {"friction.pressure_slope": 5e-8, "friction.position_share": 0.2},
    "drag": {"leakage.drag": 5e6},
    "scored": {"leakage.scored_centre": 2e-3, "leakage.scored_width": 10e-3},
    "warm": {"fluid.temperature_rise": 12.0, "fluid.temperature_drift": 3.0},
    "hoses": {"actuator.hose_volume": 50e-6},
    "foundation": {"actuator.foundation_stiffness": 20e6},
    "rod": {"actuator.piston_area_2": 380e-6, "actuator.chamber_volume_2": 200e-6},
    "inclined": {"actuator.inclination": math.radians(40.0)},
    "pid": {"control.law": "pid", "control.amplitude": 5e-3},
    "lugre": {"friction.law": "lugre"},
}  # fmt: skip
OTHERS: dict[str, dict[str, Any]] = {
    "measured": {"control.feedback": "measured", "position_sensor.bias": 1e-4},
    "intermittent": {"leakage.onset": "intermittent", "leakage.onset_duration": 0.2},
    "multisine": {"input.shape": "multisine", "input.harmonics": 5},
    "cavitating": {"fluid.cavitation": "clamped"},
}
OPTIONS = [
    {key: value for name in names.split() for key, value in (CHOICES | OTHERS)[name].items()}
    for names in (
        "laminar ramp smooth air stiffening droop ripple warm rod inclined",
        "blended lugre overlap edges worn null load return uneven hoses",
        "pid measured saturated hysteresis slow external",
        "intermittent stops cavitating multisine drag scored foundation",
    )
]  # fmt: skip
"""Every option of the model is on in a quarter of the actuators."""
CHOICES["all"] = {name: value for choice in CHOICES.values() for name, value in choice.items()}
RUNS = [SHORT.with_values(values) for values in CHOICES.values()]
COEFFICIENTS = [3e-9] * len(RUNS)


@pytest.mark.parametrize("name", CHOICES)
def test_balances_close_under_every_option(name: str) -> None:
    run = SHORT.with_values(CHOICES[name] | {"record.sampling_frequency": 50e3})
    residuals = balance_residuals([run], simulate_batch([run], [3e-9]))
    assert residuals.volume[0] < (4e-6 if run.actuator.has_unequal_chambers else 2e-6)  # of both chambers
    assert residuals.energy[0] < 2e-6


def test_every_option_changes_the_record_and_no_run_depends_on_those_of_its_neighbours() -> None:
    together = simulate_batch(RUNS, COEFFICIENTS)
    pressure = together.chamber_1_pressure
    assert min(np.abs(other - pressure[0]).max() for other in pressure[1:]) > 1.0
    for k, run in enumerate(RUNS):
        alone = simulate_batch([run], COEFFICIENTS[:1])
        np.testing.assert_array_equal(alone.chamber_1_pressure[0], pressure[k])
        np.testing.assert_array_equal(alone.internal_leakage_flow[0], together.internal_leakage_flow[k])


CLAMPED = {"fluid.cavitation": "clamped", "load.constant_force": -9e3, "record.step": 1e-4}
AIR_AND_LAP = CHOICES["air"] | CHOICES["overlap"]


@pytest.mark.parametrize("name", [*CHOICES, "clamped", "air and lap", "air and clamped"])
def test_both_halves_of_the_lanes_round_alike(name: str) -> None:
    """The kernel holds two copies of the equations, which the compiler must not treat differently."""
    more = {"clamped": CLAMPED, "air and lap": AIR_AND_LAP, "air and clamped": CHOICES["air"] | CLAMPED}
    values = CHOICES.get(name) or more.get(name) or {}
    runs = [
        SHORT.with_values(
            values
            | {"record.step": 1e-4, "fluid.bulk_modulus": 400e6 + 30e6 * k, "actuator.mass": 8.0 + 0.3 * k}
        )
        for k in range(HALF_WIDTH)
    ]
    coefficients = np.linspace(0.0, 5e-9, HALF_WIDTH).tolist()
    batch = simulate_batch([*runs, *runs], [*coefficients, *coefficients])
    for signal in (batch.piston_position, batch.chamber_1_pressure, batch.chamber_2_pressure):
        np.testing.assert_array_equal(signal[:HALF_WIDTH], signal[HALF_WIDTH:])
