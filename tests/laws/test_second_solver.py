"""All options together: a second solver, scaling, and combinations."""

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import PAPER
from hydrofdi.physics import fluid
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.simulation.balances import Trajectory, balance_residuals
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.lanes import HALF_WIDTH, ModelOptions
from hydrofdi.transforms import detail_rms
from tests.machines import MACHINES, Values, machine
from tests.second_solver import simulate_with_solver

RANGES = {
    "actuator.chamber_volume": (160e-6, 470e-6), "actuator.load_stiffness": (15e3, 150e3),
    "fluid.bulk_modulus": (551e6, 827e6), "valve.spool_gain": (22e-6, 40.6e-6),
    "friction.coulomb": (20.0, 200.0), "friction.viscous": (50.0, 500.0), "friction.transition": (4.0, 400.0),
    "input.amplitude": (1.0, 2.0),
}  # fmt: skip
FINE = {"record.step": 2e-5}
PRESSURE_BOUND, RMS_BOUND = 200.0, 1e-4
"""Largest difference of P_1 at any sample [Pa], and largest relative difference of any detail RMS."""


@cache
def cases(options: str) -> tuple[list[RunParameters], list[float], Trajectory]:
    generator, runs, coefficients = np.random.default_rng(2015), [], []
    for k in range(20):
        values = {name: float(generator.uniform(*limits)) for name, limits in RANGES.items()}
        values["friction.breakaway"] = 1.25 * values["friction.coulomb"]
        own = OPTIONS[k % len(OPTIONS)] if options == "on" else {}
        runs.append(machine(FINE, {}).with_values(values | own))
        coefficients.append(float(generator.uniform(0.0, 6e-9)))
    return runs, coefficients, simulate_batch(runs, coefficients)


def test_every_option_is_on_in_one_machine_and_off_in_another() -> None:
    options = [ModelOptions.of(machine({}, base)) for base in MACHINES.values()]
    at_work = [ModelOptions.of(run) for run in cases("on")[0][: len(OPTIONS)]]
    assert all(
        any(values) and not all(values) for values in zip(*(each[:-1] for each in options), strict=True)
    )
    assert set(at_work) == set(options[1:])
    assert {machine({}, base).friction.law for base in MACHINES.values()} == set(FRICTION_LAWS)
    assert options[0] == ModelOptions()


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


@given(st.floats(1e-300, 1e300), st.floats(-1000.0, 1000.0), st.integers(-1000, 1000))
def test_logarithm_and_power_have_the_stated_error_and_whole_powers_are_exact(
    value: float, exponent: float, whole: int
) -> None:
    assert abs(fluid.binary_logarithm(value) - math.log2(value)) < ERROR + 2e-16 * abs(math.log2(value))
    assert fluid.binary_exponential(exponent) == pytest.approx(math.pow(2.0, exponent), rel=ERROR, abs=0.0)
    assert Fraction(float(fluid.binary_exponential(float(whole)))) == Fraction(2) ** whole
    assert fluid.binary_logarithm(2.0**whole) == whole


@given(
    st.floats(-1e6, 200e6), st.floats(10e6, 10e9), st.floats(0.0, 0.5), st.floats(1.0, 10.0),
    st.floats(10e3, 1e6),
)  # fmt: skip
def test_modulus_is_the_printed_equation_over_all_usual_values(
    pressure: float, liquid: float, free_air: float, exponent: float, atmosphere: float
) -> None:
    absolute = max(pressure + atmosphere, fluid.LEAST_ABSOLUTE_PRESSURE)
    liquid_volume = math.exp((atmosphere - absolute) / liquid)
    gas_volume = free_air * math.pow(atmosphere / absolute, 1.0 / exponent)
    slope = liquid_volume / liquid + gas_volume / (exponent * absolute)
    modulus = fluid.effective_bulk_modulus(pressure, liquid, free_air, exponent, atmosphere)
    assert modulus == pytest.approx((liquid_volume + gas_volume) / slope, rel=4.0 * ERROR, abs=0.0)
    assert (
        0.0 < fluid.effective_bulk_modulus(-1e6 * pressure, liquid, free_air, exponent, atmosphere) < math.inf
    )
    assert np.isnan(fluid.effective_bulk_modulus(np.nan, liquid, free_air, exponent, atmosphere))


CHOICES: dict[str, Values] = {
    "laminar": {"leakage.law": "laminar"},
    "blended": {"leakage.law": "blended"},
    "ramp": {"leakage.onset": "ramp", "leakage.onset_time": 0.2, "leakage.onset_duration": 0.4},
    "smooth": {"friction.law": "smooth"},
    "lugre": {"friction.law": "lugre"},
    "scaled": {"friction.scale": 0.3},
    "external": {"leakage.external_coefficient_1": 1e-13},
    "air": {"fluid.law": "free_air", "fluid.free_air": 0.005},
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
    "stops": {
        "actuator.end_stops": "elastic", "actuator.end_stop_position": 0.008,
        "actuator.end_stop_stiffness": 20e6,
    },
    "load": {"load.constant_force": 500.0, "load.random_force": 1000.0, "load.random_period": 0.1},
    "droop": {"supply.droop": "first_order", "supply.droop_resistance": 2e10},
    "ripple": {"supply.ripple": 0.01},
    "return": {"supply.return_pressure": 0.4e6, "supply.return_resistance": 2e9},
    "uneven": {"friction.pressure_slope": 5e-8, "friction.position_share": 0.2},
    "drag": {"leakage.drag": 5e6},
    "scored": {"leakage.scored_centre": 2e-3, "leakage.scored_width": 10e-3},
    "warm": {"fluid.temperature_rise": 12.0, "fluid.temperature_drift": 3.0},
    "hoses": {"actuator.hose_volume": 50e-6},
    "foundation": {"actuator.foundation_stiffness": 20e6, "actuator.foundation_damping": 20e3},
    "rod": {"actuator.piston_area_2": 380e-6, "actuator.chamber_volume_2": 200e-6},
    "inclined": {"actuator.inclination": math.radians(40.0)},
    "pid": {"control.law": "pid", "control.amplitude": 5e-3},
    "measured": {"control.feedback": "measured", "position_sensor.bias": 1e-4},
    "sine": {"input.shape": "sine"},
}  # fmt: skip
"""Options, each as it is alone, and on a machine where it is compiled."""
OF_MACHINE = {
    "rig": "scaled external air stiffening saturated hysteresis slow overlap edges worn null stops load droop"
    " ripple return uneven warm foundation rod inclined",
    "gap": "ramp drag scored",
    "hoses": "",
    "loop": "pid measured drag scored",
}
"""Machines, and the options that are tried one by one on each."""


def chosen(names: str) -> Values:
    return {key: value for name in names.split() for key, value in CHOICES[name].items()}


FULL = {name: MACHINES[name] | chosen(OF_MACHINE["rig"]) | chosen(own) for name, own in OF_MACHINE.items()}
"""Machines with all of their options at work."""
OPTIONS = [
    MACHINES[name] | chosen(names)
    for name, names in (
        ("gap", "ramp air stiffening droop ripple warm rod inclined"),
        ("hoses", "overlap edges worn null load return uneven"),
        ("loop", "pid measured saturated hysteresis slow external drag scored"),
        ("rig", "stops sine foundation"),
    )
]
"""Every option of the model is at work in a quarter of the actuators."""
TOGETHER = {name: chosen(name) for name in ("air overlap", " ".join(CHOICES))}
VARIANTS = [
    *(pytest.param(values, id=name) for name, values in ({"paper": {}} | FULL).items()),
    *(pytest.param(values, id=name, marks=pytest.mark.long) for name, values in (CHOICES | TOGETHER).items()),
]
"""What is compiled: machines with all options at work, and options alone."""


@pytest.mark.parametrize("name", [*OF_MACHINE, *(_long(name) for name in CHOICES)])
def test_balances_close_under_every_option_on_its_machine_and_alone(name: str) -> None:
    base, often = MACHINES.get(name, {}), FINE | {"record.sampling_frequency": 50e3}
    values = {each: CHOICES[each] for each in OF_MACHINE.get(name, "").split()}
    values |= {"none": {}, "all": FULL[name]} if name in FULL else {name: CHOICES[name]}
    runs = [machine(often | changes, base) for changes in values.values()]
    residuals = balance_residuals(runs, simulate_batch(runs, [3e-9] * len(runs)))
    limits = [4e-6 if each in ("rod", "all") else 2e-6 for each in values]  # of both chambers
    assert (residuals.volume < limits).all(), dict(zip(values, residuals.volume, strict=True))
    assert (residuals.energy < 2e-6).all(), dict(zip(values, residuals.energy, strict=True))


def test_every_option_changes_the_record_and_no_run_depends_on_those_of_its_neighbours() -> None:
    runs, origins = [machine({}), *(machine({}, base) for base in MACHINES.values())], [0] * 6
    for number, name in enumerate(MACHINES, 1):
        for each in OF_MACHINE.get(name, "").split():
            runs.append(machine(CHOICES[each], MACHINES[name]))
            origins.append(number)
    together = simulate_batch(runs, [3e-9] * len(runs))
    pressure = together.chamber_1_pressure
    np.testing.assert_allclose(pressure[2], pressure[1], atol=0.1)
    differences = np.abs(pressure - pressure[origins]).max(axis=1)
    assert (differences[3:] > 1.0).all()
    for k, run in enumerate(runs):
        alone = simulate_batch([run], [3e-9])
        np.testing.assert_array_equal(alone.chamber_1_pressure[0], pressure[k])
        np.testing.assert_array_equal(alone.internal_leakage_flow[0], together.internal_leakage_flow[k])


@pytest.mark.parametrize("values", VARIANTS)
def test_both_halves_of_the_lanes_round_alike(values: Values) -> None:
    """The kernel holds two copies of the equations, which the compiler must not treat differently."""
    runs = [
        machine({"fluid.bulk_modulus": 400e6 + 30e6 * k, "actuator.mass": 8.0 + 0.3 * k}, values)
        for k in range(HALF_WIDTH)
    ]
    coefficients = np.linspace(0.0, 5e-9, HALF_WIDTH).tolist()
    batch = simulate_batch([*runs, *runs], [*coefficients, *coefficients])
    for signal in (batch.piston_position, batch.chamber_1_pressure, batch.chamber_2_pressure):
        np.testing.assert_array_equal(signal[:HALF_WIDTH], signal[HALF_WIDTH:])
