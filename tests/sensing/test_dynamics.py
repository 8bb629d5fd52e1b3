"""Lags of sensors against their closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hydrofdi.sensing.dynamics import first_order_response, second_order_response

INTERVAL, CORNER = 1e-3, 20.0
OMEGA = 2.0 * np.pi * CORNER
TIME = INTERVAL * np.arange(400)
STEP = np.concatenate([np.zeros(10), np.ones(390)])
"""Rises linearly over one sampling interval."""


def _first_ramp(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Response of the first-order lag to max(t, 0)."""
    t = np.maximum(time, 0.0)
    return t - (1.0 - np.exp(-OMEGA * t)) / OMEGA


def _second_ramp(time: NDArray[np.float64], zeta: float) -> NDArray[np.float64]:
    """Response of the underdamped second-order lag to max(t, 0)."""
    t, damped = np.maximum(time, 0.0), OMEGA * np.sqrt(1.0 - zeta**2)
    swing = 2 * zeta / OMEGA * np.cos(damped * t) + (2 * zeta**2 - 1) / damped * np.sin(damped * t)
    return t - 2 * zeta / OMEGA + np.exp(-zeta * OMEGA * t) * swing


def test_first_order_response_to_a_step_is_the_closed_form() -> None:
    ramps = _first_ramp(TIME - TIME[9]) - _first_ramp(TIME - TIME[10])
    np.testing.assert_allclose(first_order_response(STEP, INTERVAL, CORNER), ramps / INTERVAL, atol=1e-11)


@pytest.mark.parametrize("zeta", [0.1, 0.7])
def test_second_order_response_to_a_step_is_the_closed_form(zeta: float) -> None:
    ramps = _second_ramp(TIME - TIME[9], zeta) - _second_ramp(TIME - TIME[10], zeta)
    shown = second_order_response(STEP, INTERVAL, CORNER, zeta)
    np.testing.assert_allclose(shown, ramps / INTERVAL, atol=1e-11)


def test_critically_damped_sensor_is_two_first_order_ones_for_slow_signals() -> None:
    slow = np.sin(2 * np.pi * 2.0 * TIME)
    twice = first_order_response(first_order_response(slow, INTERVAL, CORNER), INTERVAL, CORNER)
    np.testing.assert_allclose(second_order_response(slow, INTERVAL, CORNER, 1.0), twice, atol=1e-4)


def _gain(shown: NDArray[np.float64]) -> complex:
    """Complex gain at the corner, from the last five periods."""
    last = slice(-round(5 / CORNER / INTERVAL), None)
    return complex(2j * np.mean(shown[last] * np.exp(-1j * OMEGA * TIME[last])))


def test_gain_at_the_corner_is_3_db_down_for_a_first_order_sensor() -> None:
    gain = _gain(first_order_response(np.sin(OMEGA * TIME), INTERVAL, CORNER))
    assert abs(gain) == pytest.approx(0.5**0.5, rel=2e-3)
    assert np.angle(gain, deg=True) == pytest.approx(-45.0, abs=0.2)


@pytest.mark.parametrize("zeta", [0.3, 0.7, 1.5])
def test_gain_at_the_natural_frequency_is_one_over_twice_the_damping(zeta: float) -> None:
    gain = _gain(second_order_response(np.sin(OMEGA * TIME), INTERVAL, CORNER, zeta))
    assert abs(gain) == pytest.approx(1.0 / (2.0 * zeta), rel=2e-3)
    assert np.angle(gain, deg=True) == pytest.approx(-90.0, abs=0.3)


@pytest.mark.parametrize("bandwidth", [1e-3, 10.0, 1e5])
def test_constant_signal_is_shown_from_the_first_sample_on(bandwidth: float) -> None:
    constant = np.full(500, 9.3e6)
    np.testing.assert_array_equal(first_order_response(constant, INTERVAL, bandwidth), constant)
    np.testing.assert_array_equal(second_order_response(constant, INTERVAL, bandwidth, 0.7), constant)


def test_very_fast_sensor_shows_the_signal() -> None:
    signal = np.random.default_rng(3).normal(size=500)
    np.testing.assert_allclose(first_order_response(signal, INTERVAL, 1e7), signal, atol=1e-3)
    np.testing.assert_allclose(second_order_response(signal, INTERVAL, 1e7, 0.7), signal, atol=1e-3)
