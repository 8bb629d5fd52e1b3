"""The nominal plant moves as the simulation does, and its Jacobian is that of its motion."""

import numpy as np
import pytest

from estimation.plants import NOMINAL, predicted, simulated, spool_paths, true_states
from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE, STATES, follow_command, spool_transition

WITHOUT_FRICTION = ["friction.coulomb=0 N", "friction.breakaway=0 N", "friction.viscous=0 N*s/m"]
LAPPED = ["valve.lap=0.8 um", "valve.lap_leakage=2e-14 m^3/(s*Pa)", "valve.null_offset=0.4 um"]
UNEQUAL = NOMINAL._replace(area_2=500.0, volume_2=200e3)


def smooth_states(n, plant):
    """States and open spools away from the kinks of roots and friction."""
    draw = np.random.default_rng(1)
    states = np.zeros((n, N_STATE))
    states[:, 0], states[:, 1] = draw.uniform(3.0, 5.0, n), draw.uniform(11.0, 13.0, n)
    states[:, 2], states[:, 4] = draw.uniform(-40.0, 40.0, n), draw.normal(0.0, 100.0, n)
    swap = draw.random(n) < 0.5
    states[swap, :2] = states[swap, 1::-1]
    force = plant.area_1 * states[:, 0] - plant.area_2 * states[:, 1]
    states[:, 2] = force / plant.stiffness + draw.normal(0.0, 0.3, n)
    states[:, 3] = draw.choice([-1.0, 1.0], n) * draw.uniform(30.0, 60.0, n)
    states[:, 5], states[:, 6] = draw.uniform(0.0, 1.0, n), draw.normal(0.0, 0.2, n)
    states[:, 7:9] = draw.normal(0.0, 0.03, (n, 2))
    states[:, 9:11] = draw.normal(0.0, 0.6, (n, 2))
    states[:, 11], states[:, 12:] = draw.uniform(0.0, 30.0, n), draw.normal(0.0, 0.05, (n, 2))
    opening = np.copysign(draw.uniform(0.01, 0.04, n), states[:, 3])
    return states, opening[:, None] + np.linspace(0.0, 1e-3, 9)


@pytest.mark.parametrize("plant", [NOMINAL, NOMINAL._replace(has_friction_model=True), UNEQUAL])
@pytest.mark.parametrize("name", STATES)
def test_the_transition_is_the_slope_of_the_motion(plant, name):
    states, paths = smooth_states(40, plant)
    column, size = STATES.index(name), 1e-4
    _, transitions = predicted(states, paths, plant)
    shift = np.zeros(N_STATE)
    shift[column] = size
    after, before = (predicted(states + sign * shift, paths, plant)[0] for sign in (1.0, -1.0))
    slope = (after - before)[:, :N_MOVING] / (2.0 * size)
    np.testing.assert_allclose(
        transitions[:, :, column], slope, rtol=1e-5, atol=1e-6 * np.abs(slope).max(axis=0).max()
    )


@pytest.mark.parametrize("closed_loop", [[], ["control.law=pi", "input.shape=steps", "input.period=1 s"]])
@pytest.mark.parametrize("valve", [[], LAPPED])
@pytest.mark.parametrize("friction", [WITHOUT_FRICTION, ["friction.velocity_threshold=10 mm/s"]])
def test_a_sample_ends_where_the_simulation_has_it(closed_loop, valve, friction):
    leaks = [0.0, 0.5]
    signals = simulated(["record.duration=3 s", *closed_loop, *valve, *friction], leaks)
    plant = NOMINAL._replace(has_friction_model=None if friction is WITHOUT_FRICTION else True)
    for row, states in enumerate(true_states(signals, leaks)):
        states[:, 9], states[:, 10], states[:, 11] = (0.4, 0.8, 20.0) if valve else (0.0, 0.0, 0.0)
        ends, _ = predicted(states[:-1], spool_paths(signals.input_voltage[row])[:-1], plant)
        error = np.abs(ends - states[1:])[:, :N_MOVING]
        assert (error.max(axis=0) < [0.01, 0.01, 1e-3, 0.5]).all()
        assert (np.sqrt((error**2).mean(axis=0)) < [5e-4, 5e-4, 5e-5, 0.03]).all()


@pytest.mark.parametrize("damping_ratio", [0.3, 1.0, 2.0])
def test_the_spool_follows_a_command_as_its_equation_has_it(damping_ratio):
    rate, time, n = 2.0 * np.pi * 175.0, 2e-3, 20000
    transition, path = spool_transition(rate, damping_ratio, time / 8), np.empty(9)
    spool = np.array([0.01, 5.0])
    follow_command(spool, 0.044, transition, path)
    x, v = 0.01, 5.0
    for _ in range(n):
        v += time / n * (rate**2 * (0.044 - x) - 2.0 * damping_ratio * rate * v)
        x += time / n * v
    np.testing.assert_allclose(spool, [x, v], rtol=2e-3, atol=1e-5)
    assert path[0] == 0.01
    assert path[-1] == spool[0]
