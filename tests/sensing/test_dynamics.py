"""Lags and filters against their closed forms."""

import numpy as np
import pytest

from hydrofdi.sensing.sampling import LagLanes, first_order_lag, second_order_lag

INTERVAL, CORNER = 1e-3, 20.0
OMEGA = 2.0 * np.pi * CORNER
ANGLE = OMEGA * INTERVAL
TIME = INTERVAL * np.arange(400)
STEP = np.concatenate([np.zeros(10), np.ones(390)])
"""Rises linearly over one step."""


def shown(signal, *lags):
    values = signal[:, None].copy()
    LagLanes([lags]).advance(values)
    return values[:, 0]


def _first_ramp(time):
    """Response of the first-order lag to max(t, 0)."""
    t = np.maximum(time, 0.0)
    return t - (1.0 - np.exp(-OMEGA * t)) / OMEGA


def _second_ramp(time, zeta):
    """Response of the underdamped second-order lag to max(t, 0)."""
    t, damped = np.maximum(time, 0.0), OMEGA * np.sqrt(1.0 - zeta**2)
    swing = 2 * zeta / OMEGA * np.cos(damped * t) + (2 * zeta**2 - 1) / damped * np.sin(damped * t)
    return t - 2 * zeta / OMEGA + np.exp(-zeta * OMEGA * t) * swing


def test_first_order_lag_answers_a_step_as_its_closed_form():
    ramps = _first_ramp(TIME - TIME[9]) - _first_ramp(TIME - TIME[10])
    np.testing.assert_allclose(shown(STEP, first_order_lag(ANGLE)), ramps / INTERVAL, atol=1e-11)


@pytest.mark.parametrize("zeta", [0.1, 0.7])
def test_second_order_lag_answers_a_step_as_its_closed_form(zeta):
    ramps = _second_ramp(TIME - TIME[9], zeta) - _second_ramp(TIME - TIME[10], zeta)
    np.testing.assert_allclose(shown(STEP, second_order_lag(ANGLE, zeta)), ramps / INTERVAL, atol=1e-11)


@pytest.mark.parametrize("angle", [1e-6, 1.0, 1e5])
def test_a_constant_is_shown_from_the_first_step_on_to_the_bit(angle):
    constant = np.full(500, 9.3e6)
    lags = first_order_lag(angle), second_order_lag(angle, 0.7)
    np.testing.assert_array_equal(shown(constant, *lags), constant)


def test_a_very_slow_lag_is_exact_after_many_steps():
    """0.01 Hz at a step of 0.1 ms, over two minutes: the ramp's closed form."""
    omega, steps = 2.0 * np.pi * 0.01, np.arange(1_200_000)
    ramp = 1e-4 * steps
    lagging = ramp - 1.0 / omega * -np.expm1(-omega * ramp)
    np.testing.assert_allclose(shown(ramp, first_order_lag(1e-4 * omega)), lagging, atol=1e-7)


def test_an_error_decays_to_zero_and_not_to_subnormal_numbers():
    fallen = np.concatenate([np.ones(1), np.zeros(99_999)])
    assert shown(fallen, first_order_lag(0.01))[-1] == 0.0
    assert shown(fallen, second_order_lag(0.01, 0.7))[-1] == 0.0


LANES = [
    (),
    (first_order_lag(0.05),),
    (second_order_lag(0.1, 0.7), second_order_lag(0.2, 0.4)),
] * 11  # fmt: skip


@pytest.mark.parametrize("cuts", [[], [1], [7, 8, 399], list(range(1, 400))])
def test_bits_depend_neither_on_stretches_nor_on_neighbours(cuts):
    signals = np.random.default_rng(4).normal(size=(400, len(LANES)))
    cut, together = signals.copy(), LagLanes(LANES)
    for stretch in np.split(cut, cuts):
        together.advance(stretch)
    for lane, lags in enumerate(LANES):
        np.testing.assert_array_equal(cut[:, lane], shown(signals[:, lane], *lags))
    np.testing.assert_array_equal(cut[:, 0], signals[:, 0])
