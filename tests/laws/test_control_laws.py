"""Laws of the control loop, of stability, and of the hydraulic mode."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics import hydraulic_mode
from hydrofdi.physics.valve import pid_step
from hydrofdi.quality.machine import step_limits
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.batch import simulate_batch
from tests.machines import GAP, HOSES, RIG

LOOP = RunParameters().with_values(
    {
        "record.duration": 8.0, "input.period": 8.0, "control.law": "p", "control.amplitude": 5e-3,
        "control.proportional_gain": 60.0, "friction.scale": 0.1,
    }
)  # fmt: skip


def simulate(values: dict[str, Any], coefficient: float = 2e-9) -> Trajectory:
    return simulate_batch([LOOP.with_values(values)], [coefficient])


def settled_error(trajectory: Trajectory) -> float:
    error = trajectory.reference_position[0] - trajectory.piston_position[0]
    return float(np.mean(error[1900:2000]))  # before the reference reverses at 4 s


def test_proportional_control_leaves_an_error_that_integral_action_takes_away() -> None:
    trajectory = simulate({})
    error, voltage = settled_error(trajectory), float(trajectory.input_voltage[0, 1950])
    assert error > 1e-4
    assert voltage == pytest.approx(60.0 * error, rel=0.02)
    integral = settled_error(simulate({"control.law": "pi", "control.integral_gain": 200.0}))
    assert abs(integral) < 0.05 * error


def test_voltage_never_exceeds_its_limit_and_the_integral_does_not_wind_up() -> None:
    gains = {"control.law": "pi", "control.integral_gain": 400.0, "control.amplitude": 60e-3}
    trajectory = simulate({**gains, "control.voltage_limit": 1.0, "actuator.load_stiffness": 0.0})
    voltage, position = trajectory.input_voltage[0], trajectory.piston_position[0]
    assert np.abs(voltage).max() == 1.0
    assert position[:2000].max() < 1.25 * 60e-3  # 200 V/s · s of wound-up error would overshoot by far


def test_voltage_changes_at_samples_of_the_controller_alone() -> None:
    values = {"control.sample_time": 10e-3, "record.sampling_frequency": 1000.0}
    voltage = simulate(values).input_voltage[0].reshape(-1, 10)
    assert np.all(voltage == voltage[:, :1])
    assert np.unique(voltage).size > 100


def test_controllers_of_different_sample_times_share_a_batch_and_stay_themselves() -> None:
    runs = [LOOP.with_values({"control.sample_time": time, "record.duration": 2.0}) for time in (1e-3, 10e-3)]
    together = simulate_batch(runs, [2e-9] * 2).piston_position
    for position, run in zip(together, runs, strict=True):
        np.testing.assert_array_equal(position, simulate_batch([run], [2e-9]).piston_position[0])
    assert np.ptp(together[:, 100]) > 0.0


def test_pid_derives_the_error_and_releases_a_limited_integral_by_an_error_of_the_other_sign() -> None:
    assert pid_step(3e-3, 1e-3, 0.0, 0.0, 0.0, 0.5, 2e-3, 5.0)[0] == pytest.approx(0.5 * 2e-3 / 2e-3)
    assert pid_step(1e-2, 1e-2, 4.9, 100.0, 50.0, 0.0, 2e-3, 5.0) == (5.0, 4.9)
    assert pid_step(-1e-2, 1e-2, 7.0, 100.0, 50.0, 0.0, 2e-3, 5.0) == (5.0, pytest.approx(7.0 - 1e-3))


FREE = {"actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.0}
"""Nothing but friction acts on the piston."""


LIMITED: dict[str, tuple[dict[str, Any], float, int]] = {
    "friction zone": (FREE, 0.03, 100), "hydraulic mode": (FRICTIONLESS, 0.02, 300),
}  # fmt: skip


@pytest.mark.parametrize("grows", [False, True])
@pytest.mark.parametrize("part", LIMITED)
def test_motion_turns_unstable_at_the_limit_of_its_part(part: str, grows: bool) -> None:
    values, margin, n_step = LIMITED[part]
    limit = step_limits(lambda *_: [RunParameters().with_values(values)])[part]
    step = (1.0 + margin if grows else 1.0 - margin) * limit
    motion = free_motion([values], [{"velocity": 1e-6}], [0.0], n_step * step, step)
    assert (np.abs(motion["velocity"][0, -20:]).max() > 1e-6) == grows


@given(st.floats(min_value=math.pi / 2, max_value=math.pi), st.floats(min_value=0.01, max_value=1e5))
def test_no_step_below_the_limit_amplifies(angle: float, size: float) -> None:
    eigenvalue = size * complex(math.cos(angle), math.sin(angle))
    limit = hydraulic_mode.largest_stable_step(eigenvalue)
    factors = [
        abs(hydraulic_mode.amplification(share * limit * eigenvalue)) for share in (0.25, 0.5, 0.75, 0.999)
    ]
    assert max(factors) <= 1.0 + 1e-9
    assert abs(hydraulic_mode.amplification(1.001 * limit * eigenvalue)) > 1.0


STIFF: dict[str, tuple[str, dict[str, Any], float, float]] = {
    "clearance": ("leakage of the chambers", RIG | {"valve.lap_leakage": 1e-8}, 0.05e-3, 0.1e-3),
    "external": ("leakage of the chambers", {"leakage.external_coefficient": 1e-8}, 0.1e-3, 0.2e-3),
    "bristles": ("bristles", HOSES | {"friction.bristle_damping": 1e5}, 0.1e-3, 0.4e-3),
    "supply": (
        "supply",
        GAP | {
            "supply.droop_resistance": 2e10, "supply.droop_time_constant": 5e-3, "valve.lap_leakage": 1e-9,
            "friction.scale": 0.01,
        },
        0.2e-3, 0.4e-3,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", STIFF)
def test_a_stiff_part_holds_below_its_step_limit_and_diverges_above(name: str) -> None:
    part, values, good, bad = STIFF[name]
    base = RunParameters().with_values({"record.duration": 2.0, "record.sampling_frequency": 250.0, **values})
    runs = [base.with_values({"record.step": step}) for step in (good, bad)]
    assert good < step_limits(lambda *_: [base])[part] < bad
    with np.errstate(over="ignore"):  # of positions beyond all measure in the share of a scored bore
        assert [simulate_batch([run], [0.0]).outcomes[0].status for run in runs] == ["ok", "diverged"]


STIFFNESS, POSITION, VISCOUS = 5e3, 0.02, 50.0
BULK_MODULI = [551e6, 689e6, 827e6]
COEFFICIENTS = [0.0, 1e-9, 3e-9, 6e-9]
CASES = list(itertools.product(BULK_MODULI, COEFFICIENTS))
NOMINAL = RunParameters()
AREA, VOLUME = NOMINAL.actuator.piston_area, NOMINAL.actuator.chamber_volume
MASS = NOMINAL.actuator.mass
DIFFERENCE = STIFFNESS * POSITION / AREA


def _opening(coefficient: float) -> float:
    """Spool position whose flow just feeds the leak: the piston stands still against the spring."""
    valve, drop = NOMINAL.valve, 0.5 * (NOMINAL.supply.pressure - DIFFERENCE)
    return coefficient * math.sqrt(DIFFERENCE) / (valve.flow_gain * valve.area_gradient * math.sqrt(drop))


def _formula(bulk_modulus: float, coefficient: float) -> tuple[float, float]:
    omega = hydraulic_mode.mode_frequency(bulk_modulus, (AREA, AREA), (VOLUME, VOLUME), MASS, STIFFNESS)
    valve = hydraulic_mode.valve_flow_pressure_coefficient(
        _opening(coefficient), 0.5 * (NOMINAL.supply.pressure - DIFFERENCE),
        NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient,
    )  # fmt: skip
    conductance = hydraulic_mode.leakage_conductance(DIFFERENCE, coefficient)
    return omega, hydraulic_mode.mode_damping_ratio(
        omega, bulk_modulus, VOLUME, MASS, VISCOUS, valve, conductance
    )


def _measured(velocity: NDArray[np.float64], step: float) -> tuple[float, float]:
    """ω [rad/s] and ζ of a ring-down, from upward zero crossings and the peaks between them."""
    before = np.flatnonzero((velocity[:-1] <= 0.0) & (velocity[1:] > 0.0))
    crossings = step * (before - velocity[before] / (velocity[before + 1] - velocity[before]))
    peaks = [velocity[a : b + 1].max() for a, b in itertools.pairwise(before)]
    damped = 2.0 * math.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    decay = math.log(peaks[0] / peaks[-1]) * damped / (2.0 * math.pi * (len(peaks) - 1))
    omega = math.hypot(damped, decay)
    return omega, decay / omega


def test_ring_down_has_the_frequency_and_damping_of_the_formula() -> None:
    """Every case kicked by 0.1 mm/s from the equilibrium."""
    step, mean = 2e-5, 0.5 * NOMINAL.supply.pressure
    common = {"actuator.load_stiffness": STIFFNESS, **FRICTIONLESS, "friction.viscous": VISCOUS}
    values = [
        common | {"fluid.bulk_modulus": bulk_modulus, "leakage.internal_coefficient": coefficient}
        for bulk_modulus, coefficient in CASES
    ]
    start = {
        "position": POSITION, "velocity": 1e-4,
        "pressure_1": mean + 0.5 * DIFFERENCE, "pressure_2": mean - 0.5 * DIFFERENCE,
    }  # fmt: skip
    spool = [_opening(coefficient) for _, coefficient in CASES]
    motion = free_motion(values, [start] * len(CASES), spool, 0.15, step)
    measured = [_measured(velocity, step) for velocity in motion["velocity"]]
    np.testing.assert_allclose(measured, [_formula(*case) for case in CASES], rtol=0.01)


def test_piston_without_friction_and_leak_rings_for_ever() -> None:
    values = {"actuator.load_stiffness": 0.0, **FRICTIONLESS}
    velocity = free_motion([values], [{"velocity": 0.01}], [0.0], 0.4, 1e-5)["velocity"][0]
    assert velocity[-2000:].max() == pytest.approx(0.01, rel=1e-3)


def test_incompressible_limit_moves_the_piston_with_the_control_flow() -> None:
    """The piston swings about the kinematic motion by q/(A ω_h), which vanishes as 1/√β."""
    opening, step = 22e-6, 2e-6
    moduli = [551e6, 5.51e9, 55.1e9]
    values = [
        {"fluid.bulk_modulus": modulus, "actuator.load_stiffness": 0.0, **FRICTIONLESS} for modulus in moduli
    ]
    motion = free_motion(values, [{}] * 3, [opening], 0.02, step)
    drop = 0.5 * NOMINAL.supply.pressure
    speed = NOMINAL.valve.flow_gain * NOMINAL.valve.area_gradient * opening * math.sqrt(drop) / AREA
    swing = np.abs(motion["position"] - speed * step * np.arange(10_000)).max(axis=1)
    expected = [
        speed / hydraulic_mode.mode_frequency(modulus, (AREA, AREA), (VOLUME, VOLUME), MASS, 0.0)
        for modulus in moduli
    ]
    np.testing.assert_allclose(swing, expected, rtol=0.05)
