"""Ring-down: the frequency and damping that were put in come out, with the uncertainty that is stated."""

import numpy as np
import pytest

from hydrofdi.physics.hydraulic_mode import mode_frequency
from indicators.signals import P1, U, batch, measured, noise, ringing_pressure, simulated, square_wave

N, HALF = 5000, 500


def ringing(frequency=60.0, damping_ratio=0.05, noise=0.0, n_record=1):
    noise = noise * np.random.default_rng(0).normal(size=(n_record, N))
    pressure = ringing_pressure(N, HALF, frequency, damping_ratio) + noise
    return batch({P1: pressure, U: np.tile(square_wave(N, HALF), (n_record, 1))}, drive_period=2.0)


@pytest.mark.parametrize(
    ("frequency", "damping_ratio"), [(15.0, 0.3), (15.0, 0.02), (60.0, 0.1), (140.0, 0.002), (140.0, 0.3)]
)
def test_the_frequency_and_damping_of_a_second_order_system_come_out(frequency, damping_ratio):
    values, _ = measured(ringing(frequency, damping_ratio), "ring_down")
    np.testing.assert_allclose(values["frequency"], frequency, rtol=1e-6)
    np.testing.assert_allclose(values["damping_ratio"], damping_ratio, rtol=1e-6)
    assert (values["steps"], values["overdamped"]) == (N // HALF - 1, 0.0)


@pytest.mark.parametrize(
    ("records", "options"),
    [
        (ringing(20.0, 1.2, noise=1e3), {"delay": 0, "window": "0.3 s"}),
        (batch({P1: noise(4, (20, N), size=1e4)}, drive_period=2.0), {}),
        (batch({P1: np.arange(N) * 1e3}, drive_period=2.0), {}),
    ],
    ids=["overdamped", "white noise", "ramp"],
)
def test_what_does_not_oscillate_does_not_ring(records, options):
    values, _ = measured(records, "ring_down", **options)
    assert values["steps"].sum() == 0.0
    np.testing.assert_array_equal(values["overdamped"], 1.0)
    assert np.isnan(values["damping_ratio"]).all()


def test_the_stated_errors_cover_the_truth_as_often_as_they_should():
    """Student's 95 % of 9 steps; binomial scatter of 400 repeats is 1.1 %."""
    values, _ = measured(ringing(60.0, 0.05, noise=3e4, n_record=400), "ring_down")
    for name, truth in (("frequency", 60.0), ("damping_ratio", 0.05)):
        for kind, factor in (("error", 2.306), ("formal_error", 1.96)):
            covered = np.abs(values[name] - truth) <= factor * values[f"{name}_{kind}"]
            assert 0.91 <= covered.mean() <= 0.985, (name, kind)


def test_the_mode_of_a_simulated_actuator_is_that_of_linear_theory():
    moduli = np.repeat([551e6, 827e6], 2)
    records = simulated("record.duration=6 s", leaks=[0.0, 5e-9] * 2, moduli=moduli)
    values, _ = measured(records, "ring_down", less="chamber_2_pressure")
    machine = (633e-6, 633e-6), (280e-6, 280e-6), 12.3, 150e3
    theory = [mode_frequency(modulus, *machine) / (2 * np.pi) for modulus in moduli]
    np.testing.assert_allclose(values["frequency"], theory, rtol=0.02)
    healthy, leaking = values["damping_ratio"][0::2], values["damping_ratio"][1::2]
    assert (leaking > 1.5 * healthy).all()


def test_the_steps_may_be_found_by_the_command_the_period_or_the_pressure():
    command, period, signal = (
        measured(ringing(50.0, 0.02), "ring_down", steps=kind)[0]["damping_ratio"]
        for kind in ("command", "period", "signal")
    )
    np.testing.assert_array_equal(command, period)
    np.testing.assert_allclose(signal, command, rtol=1e-6)


@pytest.mark.parametrize("pressure", [np.full(N, 8e6), np.full(N, np.nan)])
@pytest.mark.parametrize("command", [square_wave(N, HALF), np.ones(N)])
def test_a_pressure_that_does_not_move_has_no_numbers_and_says_so(pressure, command):
    values, obstacles = measured(batch({P1: pressure, U: command}), "ring_down")
    assert all(np.isnan(value).all() for value in values.values())
    assert obstacles[0]
