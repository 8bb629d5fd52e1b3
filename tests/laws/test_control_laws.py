"""Laws of the control loop, of stability, and of the hydraulic mode."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from free_motion import FREE, FRICTIONLESS, free_motion, ring_down

from hydrofdi.config import RunParameters
from hydrofdi.physics import hydraulic_mode
from hydrofdi.physics.valve import pid_step
from hydrofdi.quality.machine import step_limits
from hydrofdi.simulation.batch import simulate_batch
from tests.machines import GAP, HOSES, RIG

LOOP = RunParameters().with_values(
    {
        "record.duration": 8.0, "input.period": 8.0, "control.law": "p", "control.amplitude": 5e-3,
        "control.proportional_gain": 60.0, "friction.scale": 0.1,
    }
)  # fmt: skip


def test_proportional_control_leaves_an_error_that_integral_action_takes_away() -> None:
    runs = [LOOP, LOOP.with_values({"control.law": "pi", "control.integral_gain": 200.0})]
    record, before = simulate_batch(runs, [2e-9] * 2), slice(1900, 2000)  # the reference reverses at 4 s
    left = (record.reference_position - record.piston_position)[:, before].mean(axis=1)
    assert left[0] > 1e-4
    assert record.input_voltage[0, 1950] == pytest.approx(60.0 * left[0], rel=0.02)
    assert abs(left[1]) < 0.05 * left[0]


def test_voltage_changes_at_samples_of_the_controller_and_stays_at_its_limit_without_winding_up() -> None:
    gains = {"control.law": "pi", "control.integral_gain": 400.0, "control.amplitude": 60e-3}
    times = {"control.sample_time": 10e-3, "record.sampling_frequency": 1000.0}
    run = LOOP.with_values({**gains, **times, **FREE, "control.voltage_limit": 1.0})
    record = simulate_batch([run], [2e-9])
    voltage = record.input_voltage[0].reshape(-1, 10)
    assert np.all(voltage == voltage[:, :1])
    assert np.unique(voltage).size > 50
    assert np.abs(voltage).max() == 1.0
    assert record.piston_position[0, :4000].max() < 1.25 * 60e-3  # wound up, it would overshoot by far


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


@pytest.mark.parametrize("grows", [False, True])
@pytest.mark.parametrize(
    ("part", "values", "margin", "n_step"),
    [
        ("friction zone", FREE | {"fluid.bulk_modulus": 1.0}, 0.03, 100),
        ("hydraulic mode", FRICTIONLESS, 0.02, 300),
    ],
)
def test_motion_turns_unstable_at_the_limit_of_its_part(part, values, margin, n_step, grows) -> None:
    limit = step_limits(lambda *_: [RunParameters().with_values(values)])[part]
    step = (1.0 + margin if grows else 1.0 - margin) * limit
    motion = free_motion([values], [{"velocity": 1e-6}], [0.0], n_step * step, step)
    assert (np.abs(motion["velocity"][0, -20:]).max() > 1e-6) == grows


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


def test_ring_down_has_the_frequency_and_damping_of_the_formula() -> None:
    """Kicked by 0.1 mm/s from an equilibrium in which the spool just feeds the leak."""
    step, nominal, stiffness, position, viscous = 2e-5, RunParameters(), 5e3, 0.02, 50.0
    gain, area = (nominal.valve.flow_gain, nominal.valve.area_gradient), nominal.actuator.piston_area
    mean, difference = 0.5 * nominal.supply.pressure, stiffness * position / area
    drop, cases = mean - 0.5 * difference, [*itertools.product([551e6, 827e6], [0.0, 1e-9, 6e-9])]
    common = {"actuator.load_stiffness": stiffness, **FRICTIONLESS, "friction.viscous": viscous}
    values, spool, expected = [], [], []
    for modulus, coefficient in cases:
        values.append(common | {"fluid.bulk_modulus": modulus, "leakage.internal_coefficient": coefficient})
        spool.append(coefficient * math.sqrt(difference / drop) / math.prod(gain))
        omega = hydraulic_mode.mode_frequency(modulus, (area, area), (280e-6, 280e-6), 12.3, stiffness)
        of_valve = hydraulic_mode.valve_flow_pressure_coefficient(spool[-1], drop, *gain)
        of_leak = hydraulic_mode.leakage_conductance(difference, coefficient)
        ratio = hydraulic_mode.mode_damping_ratio(omega, modulus, 280e-6, 12.3, viscous, of_valve, of_leak)
        expected.append((omega, ratio))
    pressures = {"pressure_1": mean + 0.5 * difference, "pressure_2": mean - 0.5 * difference}
    start = pressures | {"position": position, "velocity": 1e-4}
    motion = free_motion(values, [start] * len(cases), spool, 0.15, step)
    measured = [ring_down(velocity, step) for velocity in motion["velocity"]]
    np.testing.assert_allclose(measured, expected, rtol=0.01)
