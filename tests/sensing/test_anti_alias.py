"""The Butterworth filter in front of the converter."""

import numpy as np
import pytest

from hydrofdi.config import RunSpec, load_experiment
from hydrofdi.execution import Job, compute_columns
from hydrofdi.sensing import CHANNELS


def run_with(*settings):
    return load_experiment(None, ("record.duration=2 s", *settings)).nominal_parameters


def columns_of(*runs):
    return compute_columns([Job.of(RunSpec(run), "run", 2e-9) for run in runs])


def _gain(frequency, order, *, corner=100.0):
    """Complex gain for the input voltage, from its second second."""
    sine = run_with(f"input={{shape: sine, period: {1.0 / frequency} s}}", "record.step=0.02 ms")
    filtered = sine.with_values({"measurement.anti_alias": corner, "measurement.anti_alias_order": order})
    columns = columns_of(sine, filtered)
    turns = np.exp(-2j * np.pi * frequency * columns["time"][500:])
    true, shown = (np.mean(voltage[500:] * turns) for voltage in columns["input_voltage"])
    return complex(shown / true)


@pytest.mark.parametrize("order", [2, 4])
def test_gain_at_the_corner_is_3_db_down_and_the_phase_an_eighth_of_a_turn_per_pole(order):
    gain = _gain(100.0, order)
    assert 20.0 * np.log10(abs(gain)) == pytest.approx(-3.01, abs=0.01)
    assert np.angle(gain * np.exp(0.25j * np.pi * order), deg=True) == pytest.approx(0.0, abs=0.5)


def test_all_channels_pass_the_same_filter():
    """What is at rest is shown to the bit, what moves is smoothed."""
    still, moving = run_with("input.amplitude=0"), run_with("supply.droop=first_order")
    filtered = [run.with_values({"measurement.anti_alias": 50.0}) for run in (still, moving)]
    columns = columns_of(still, filtered[0], moving, filtered[1])
    for channel in CHANNELS:
        rows = columns[channel.signal]
        np.testing.assert_array_equal(rows[0], rows[1])
        assert np.abs(np.diff(rows[3], 2)).max() < np.abs(np.diff(rows[2], 2)).max(), channel


def test_sensor_and_filter_act_one_after_the_other():
    """A second-order sensor damped by 1/√2 is a Butterworth filter of order 2: both commute."""
    lag = {"pressure_1_sensor.order": "second", "pressure_1_sensor.bandwidth": 80.0}
    lag |= {"pressure_1_sensor.damping_ratio": 0.5**0.5}
    swapped = lag | {"pressure_1_sensor.bandwidth": 120.0}
    filter_ = {"measurement.anti_alias_order": 2}
    one = run_with().with_values(lag | filter_ | {"measurement.anti_alias": 120.0})
    other = run_with().with_values(swapped | filter_ | {"measurement.anti_alias": 80.0})
    shown = columns_of(one, other)["chamber_1_pressure"]
    np.testing.assert_allclose(shown[0], shown[1], rtol=1e-9)
