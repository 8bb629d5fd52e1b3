"""What the simulated actuator must obey whatever its parameters are."""

import numpy as np
import pytest

from hydrofdi.physics.leakage import external_leakage_flow
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow
from hydrofdi.simulation import simulate_batch

LEAKS = [0.0, 1e-9, 1e-8, 3e-8]


def control_flows(run, trajectory, row):
    spool, valve, supply = trajectory.spool_position[row], run.valve, run.supply
    ends = supply.pressure, supply.return_pressure
    drops = (
        chamber_1_orifice_drop(spool, trajectory.chamber_1_pressure[row], *ends),
        chamber_2_orifice_drop(spool, trajectory.chamber_2_pressure[row], *ends),
    )
    return [control_flow(spool, drop, valve.flow_gain, valve.area_gradient) for drop in drops]


@pytest.mark.parametrize("external", [0.0, 2e-13])
def test_in_steady_motion_the_flow_in_is_what_the_piston_and_the_leaks_take(parameters, external):
    run = parameters(
        "actuator.load_stiffness=0", "input.period=4 s", f"leakage.external_coefficient={external!r}"
    )
    trajectory = simulate_batch([run] * len(LEAKS), LEAKS)
    for row in range(len(LEAKS)):
        q_1, q_2 = (flow[-1] for flow in control_flows(run, trajectory, row))
        q_il = trajectory.internal_leakage_flow[row, -1]
        swept = run.actuator.piston_area * trajectory.piston_velocity[row, -1]
        losses = [
            external_leakage_flow(pressure[row, -1], external)
            for pressure in (trajectory.chamber_1_pressure, trajectory.chamber_2_pressure)
        ]
        assert swept > 1e-5
        assert q_1 == pytest.approx(swept + q_il + losses[0], rel=1e-5)
        assert q_2 == pytest.approx(swept + q_il - losses[1], rel=1e-5)


def test_the_mirrored_input_mirrors_the_motion_and_swaps_the_chambers(parameters):
    trajectory = simulate_batch([parameters(), parameters("input.amplitude=-2 V")], [1e-8, 1e-8])
    plus, minus = 0, 1
    for name, scale in (("piston_position", 1e-2), ("piston_velocity", 1e-1), ("spool_position", 1e-5)):
        signal = getattr(trajectory, name)
        np.testing.assert_allclose(signal[minus], -signal[plus], atol=1e-9 * scale)
    np.testing.assert_allclose(
        trajectory.chamber_1_pressure[minus], trajectory.chamber_2_pressure[plus], rtol=1e-8
    )
    np.testing.assert_allclose(
        trajectory.internal_leakage_flow[minus], -trajectory.internal_leakage_flow[plus], atol=1e-12
    )


def test_without_input_nothing_moves(parameters):
    trajectory = simulate_batch([parameters("input.amplitude=0")], [1e-8])
    assert not trajectory.piston_position.any()
    np.testing.assert_array_equal(trajectory.chamber_1_pressure, 8.6e6)


def test_the_spool_settles_at_its_gain_times_the_voltage(parameters):
    trajectory = simulate_batch([parameters("input.period=4 s")], [0.0])
    assert trajectory.spool_position[0, -1] == pytest.approx(44e-6, rel=1e-9)


def test_pressures_stay_close_to_the_range_between_return_and_supply(parameters):
    trajectory = simulate_batch([parameters()], [1e-8])
    for pressure in (trajectory.chamber_1_pressure, trajectory.chamber_2_pressure):
        assert pressure.min() >= 0.0
        assert pressure.max() <= 17.2e6


def test_a_larger_leak_leaks_more_and_slows_the_piston(parameters):
    run = parameters("actuator.load_stiffness=0")
    trajectory = simulate_batch([run] * len(LEAKS), LEAKS)
    assert trajectory.mean_internal_leakage_flow[0] == 0.0
    assert np.all(np.diff(trajectory.mean_internal_leakage_flow) > 0.0)
    assert np.all(np.diff(trajectory.piston_velocity[:, 400]) < 0.0)
