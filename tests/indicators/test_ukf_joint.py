"""The unscented Kalman filter with the leakage among its states."""

import numpy as np
import pytest
from estimation.plants import simulated

from hydrofdi.indicators.models.ekf_joint import EkfJoint, JointOptions
from hydrofdi.indicators.models.ukf_joint import UkfJoint, UnscentedOptions
from hydrofdi.records import Channel
from indicators.signals import batch

LEAKS = np.array([0.0, 0.05, 0.5])
PER_LITRE_PER_MINUTE = 1e-3 / 60.0
KNOWN = {"states": ("leakage", "bulk_modulus", "supply", "flow_gain")}


def noisy(settings, noise=1.0):
    """Runs with three leaks, and noise of the pressures and the position."""
    signals = simulated(settings, LEAKS)
    draw = np.random.default_rng(5)
    shape = signals.piston_position.shape
    return batch(
        {
            Channel.CHAMBER_1_PRESSURE: signals.chamber_1_pressure + noise * 5e3 * draw.normal(size=shape),
            Channel.CHAMBER_2_PRESSURE: signals.chamber_2_pressure + noise * 5e3 * draw.normal(size=shape),
            Channel.PISTON_POSITION: signals.piston_position + noise * 1e-5 * draw.normal(size=shape),
            Channel.INPUT_VOLTAGE: signals.input_voltage,
        }
    )


@pytest.fixture(scope="module")
def runs():
    """Runs of 6 s in oil 20 % stiffer than nominal."""
    return noisy(["record.duration=6 s", "fluid.bulk_modulus=661 MPa"])


def test_leakage_and_bulk_modulus_are_those_of_the_actuator(runs):
    found = UkfJoint(UnscentedOptions(**KNOWN)).measure(runs)
    truth = PER_LITRE_PER_MINUTE * LEAKS
    assert (np.abs(found["leakage"] - truth) < 4.0 * found["leakage_error"]).all()
    assert (found["leakage_error"] < 0.02 * PER_LITRE_PER_MINUTE).all()
    np.testing.assert_allclose(found["bulk_modulus"], 661e6, rtol=0.03)


@pytest.mark.parametrize("states", [("leakage",), KNOWN["states"], JointOptions().states])
def test_points_close_together_make_it_the_extended_filter(runs, states):
    extended = EkfJoint(JointOptions(states=states)).measure(runs)
    unscented = UkfJoint(UnscentedOptions(states=states, spread=0.001)).measure(runs)
    error = extended["leakage_error"]
    np.testing.assert_allclose(unscented["leakage_error"], error, rtol=0.01)
    assert (np.abs(unscented["leakage"] - extended["leakage"]) < 0.4 * error).all()


@pytest.mark.parametrize("damage", ["nan", "jump"])
def test_a_lost_record_has_no_number_and_leaves_its_neighbours_alone(runs, damage):
    pressure = runs[Channel.CHAMBER_1_PRESSURE].copy()
    pressure[1, 1000] = np.nan if damage == "nan" else 1e12
    damaged = batch({**runs.channels, Channel.CHAMBER_1_PRESSURE: pressure})
    sound, lost = (UkfJoint().trace(each).values["leakage"] for each in (runs, damaged))
    assert np.isnan(lost[1, 20:]).all()
    np.testing.assert_array_equal(lost[1, :19], sound[1, :19])
    np.testing.assert_array_equal(lost[[0, 2]], sound[[0, 2]])


def test_it_tells_what_is_left_unknown_behind_a_record(runs):
    told, expected = UkfJoint().information(runs), EkfJoint().information(runs)
    assert [each.before for each in told.unknowns] == [each.before for each in expected.unknowns]
    np.testing.assert_allclose(np.diag(told.covariance), np.diag(expected.covariance), rtol=0.1)
