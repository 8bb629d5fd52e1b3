import numpy as np
import pytest
from scipy.signal import hilbert

from hydrofdi.indicators.catalogue.envelope import analytic_signal
from hydrofdi.records import Channel, RecordBatch
from indicators.laws import (
    SAMPLING_FREQUENCY,
    noise,
    records,
    ringing,
    values,
)


def decaying(rate, n_time=5000, size=1e6):
    """A pressure that steps every second and rings at 70 Hz."""
    time = np.arange(n_time) / SAMPLING_FREQUENCY
    phase = time % 1.0
    square = np.where(time % 2.0 < 1.0, 1.0, -1.0)
    return 8e6 + square * size * (1.0 - np.exp(-rate * phase) * np.cos(2 * np.pi * 70.0 * phase))


@pytest.mark.parametrize("n_time", [2000, 2001])
def test_the_analytic_signal_of_what_lies_in_the_band_is_that_of_scipy(n_time):
    time = np.arange(n_time) / n_time
    signal = np.cos(2 * np.pi * 300 * time) * (1.0 + 0.5 * np.cos(2 * np.pi * 4 * time))
    ours = analytic_signal(8e6 + signal, n_time, (100.0, 500.0))
    np.testing.assert_allclose(ours, hilbert(signal), atol=1e-8)


@pytest.mark.parametrize("rate", [4.0, 10.0, 20.0])
def test_the_decay_after_steps_is_found(rate):
    found = values("envelope", records(decaying(rate), drive_period=2.0))
    assert found["decay_rate"] == pytest.approx(rate, rel=0.03)
    assert found["decay_rate_spread"] < 0.05 * rate
    assert found["steps"] == 9


def test_the_decay_is_that_of_the_poles_of_the_ring_down():
    batch = records(ringing(7, 6), drive_period=2.0)
    poles = values("ring_down", batch, delay=30e-3, window=0.1)
    rate = 2 * np.pi * poles["frequency"] * poles["damping_ratio"]
    np.testing.assert_allclose(values("envelope", batch)["decay_rate"], rate, rtol=0.06)


def test_steps_come_from_the_command_where_it_is_known():
    pressure = decaying(10.0)[None]
    command = np.where(np.arange(5000) % 1000 < 500, 2.0, -2.0)[None]
    batch = RecordBatch(
        {Channel.CHAMBER_1_PRESSURE: pressure, Channel.INPUT_VOLTAGE: command}, SAMPLING_FREQUENCY, ("a",)
    )
    by_command = values("envelope", batch, steps="command")
    by_period = values("envelope", records(pressure, drive_period=2.0))
    assert by_command["steps"] == 9
    assert by_command["decay_rate"] == pytest.approx(by_period["decay_rate"][0], rel=0.05)


def test_the_amplitude_of_a_tone_in_the_band_is_its_own():
    time = np.arange(5000) / SAMPLING_FREQUENCY
    found = values("envelope", 8e6 + 3e5 * np.sin(2 * np.pi * 70.0 * time))
    assert found["amplitude"] == pytest.approx(3e5, rel=1e-9)


def test_white_noise_has_the_power_of_the_band():
    found = values("envelope", noise(3, (8, 20_000), size=4.0, mean=0.0), band=[40, 120])
    passed = 80.0 * (0.25 + 0.75 * 3 / 8)  # the edges pass the mean of sin^4
    expected = 4.0 * np.sqrt(2.0 * passed / 250.0)
    assert np.sqrt(np.mean(found["amplitude"] ** 2)) == pytest.approx(expected, rel=0.03)


def test_a_record_that_stands_still_has_no_decay():
    found = values("envelope", records(np.full(2000, 8e6), drive_period=2.0))
    assert found["amplitude"] == pytest.approx(0.0, abs=1e-3)
    assert found["steps"] == 0
    assert np.isnan(found["decay_rate"])
