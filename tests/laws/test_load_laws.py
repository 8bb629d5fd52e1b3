"""Laws of the forces on the piston: loads and end stops."""

from __future__ import annotations

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion

from hydrofdi.config import RunParameters
from hydrofdi.simulation.batch import simulate_batch

AREA = RunParameters().actuator.piston_area
AT_REST = RunParameters().with_values(
    {
        "input.amplitude": 0.0, "record.duration": 10.0, "actuator.load_stiffness": 50e3,
        "friction.scale": 0.0, "friction.viscous": 2000.0,
    }
)  # fmt: skip


def test_piston_at_rest_balances_pressure_spring_and_load() -> None:
    run = AT_REST.with_values({"load.constant_force": 700.0})
    record = simulate_batch([run], [1e-8])
    difference = record.chamber_1_pressure[0, -1] - record.chamber_2_pressure[0, -1]
    position = record.piston_position[0, -1]
    assert AREA * difference == pytest.approx(700.0 + 50e3 * position, abs=0.5)


def test_shut_leaking_cylinder_yields_to_the_load_until_the_spring_holds_it() -> None:
    record = simulate_batch([AT_REST.with_values({"load.constant_force": 700.0})], [1e-8])
    assert record.piston_position[0, -1] == pytest.approx(-700.0 / 50e3, rel=1e-3)


def test_random_load_is_seeded_and_held() -> None:
    values = {"load.random_force": 500.0, "load.random_period": 0.1, "load.constant_force": 100.0}
    runs = [AT_REST.with_values({**values, "load.seed": seed}) for seed in (1, 1, 2)]
    force = simulate_batch(runs, [1e-9] * 3).load_force
    np.testing.assert_array_equal(force[0], force[1])
    assert np.all(force.reshape(3, 100, 50) == force.reshape(3, 100, 50)[:, :, :1])
    assert np.abs(force - 100.0).max() <= 500.0
    assert abs(np.corrcoef(force[0, ::50], force[2, ::50])[0, 1]) < 0.4


def test_loads_of_a_batch_reach_their_own_runs() -> None:
    runs = [AT_REST.with_values({"load.constant_force": force}) for force in np.linspace(-800.0, 800.0, 20)]
    position = simulate_batch(runs, [1e-8] * 20).piston_position[:, -1]
    assert np.all(np.diff(position) < 0.0)


STOPPED = {
    **FRICTIONLESS, "actuator.load_stiffness": 0.0, "actuator.end_stops": "elastic",
    "actuator.end_stop_position": 0.05, "fluid.bulk_modulus": 1.0,
}  # fmt: skip


def test_free_mass_bounces_off_an_end_stop_with_its_speed() -> None:
    """A chamber pressure that never changes leaves the mass free; the stop is a spring."""
    motion = free_motion([STOPPED] * 2, [{"velocity": 0.5}, {"velocity": -0.5}], [0.0, 0.0], 0.2, 1e-5)
    assert motion["velocity"][0, -1] == pytest.approx(-0.5, rel=1e-4)
    depth = 0.5 * np.sqrt(12.3 / 20e6)
    assert motion["position"][0].max() == pytest.approx(0.05 + depth, rel=1e-4)
    np.testing.assert_allclose(motion["position"][0], -motion["position"][1], atol=1e-12)


def test_piston_that_would_leave_the_cylinder_is_held_by_the_stops() -> None:
    values = {
        "actuator.load_stiffness": 0.0,
        "input.amplitude": 8.0,
        "record.duration": 4.0,
        "input.period": 4.0,
    }
    free = RunParameters().with_values(values)
    stopped = free.with_values({"actuator.end_stops": "elastic"})
    record = simulate_batch([free, stopped], [0.0, 0.0])
    assert [outcome.status for outcome in record.outcomes] == ["stroke_exceeded", "ok"]
    assert 0.3 < record.piston_position[1].max() < 0.3 + 17.2e6 * AREA / 20e6 * 1.5
    # Driven into the stop, the piston ends with the supply in one chamber and the return in the other.
    assert record.chamber_1_pressure[1, 990] == pytest.approx(17.2e6, rel=1e-3)
    assert record.chamber_2_pressure[1, 990] == pytest.approx(0.0, abs=1e4)
