"""The kernel against theory, and against SciPy on the equations as they are printed."""

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.transforms.wavelet import detail_rms
from tests.simulation import reference

NOMINAL = load_experiment().nominal_parameters
"""Of the rates of x_p, v_p, x_v, v_v, P_1 and P_2, where large terms cancel."""

SMOOTH = (
    "record.duration=0.2 s", "wavelet.levels=2", "friction.coulomb=0", "friction.breakaway=0",
    "friction.viscous=500",
)  # fmt: skip


def smooth_record(parameters, step):
    run = parameters(*SMOOTH, f"record.step={step!r}")
    trajectory = simulate_batch([run], [0.0])
    assert trajectory.piston_velocity[0, 1:].min() > 0.0
    names = ("piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure")
    return np.array([getattr(trajectory, name)[0] for name in names])


def test_halving_the_step_divides_the_error_by_sixteen_on_a_smooth_problem(parameters):
    exact = smooth_record(parameters, 1e-4 / 16)
    errors = [np.abs(smooth_record(parameters, step) - exact).max(axis=1) for step in (4e-4, 2e-4, 1e-4)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 4.0, atol=0.3)


@pytest.fixture(scope="module")
def radau():
    """Parameters over 4 s with a leak, K_i, and their states by Radau at a relative tolerance of 1e-9."""
    run = load_experiment(None, ["record.duration=4 s"]).nominal_parameters
    return run, 1e-8, reference.integrate(reference.printed_rates, run, 1e-8, 1e-9)


def deviations(radau, step):
    run, K_i, states = radau
    trajectory = simulate_batch([run.with_values({"record.step": step})], [K_i])
    pressures = np.array([trajectory.chamber_1_pressure[0], trajectory.chamber_2_pressure[0]])
    return trajectory, np.abs(pressures - states[4:])


def test_the_kernel_agrees_with_radau_within_200_pa_over_4_s_at_half_the_nominal_step(radau):
    trajectory, deviation = deviations(radau, 5e-5)
    assert deviation.max() < 200.0
    np.testing.assert_allclose(trajectory.piston_position[0], radau[2][0], atol=1e-6)
    np.testing.assert_allclose(trajectory.spool_position[0], radau[2][2], atol=1e-11)


def test_the_kernel_converges_to_radau(radau):
    assert deviations(radau, 1e-5)[1].max() < 5.0


def test_the_nominal_step_costs_less_than_a_thousandth_of_any_detail_rms(radau):
    trajectory, deviation = deviations(radau, 1e-4)
    assert np.sqrt(np.mean(deviation**2)) < 200.0
    wavelet = radau[0].wavelet
    expected = detail_rms(radau[2][4], wavelet)
    np.testing.assert_allclose(detail_rms(trajectory.chamber_1_pressure[0], wavelet), expected, rtol=1e-3)
