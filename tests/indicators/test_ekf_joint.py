"""Kalman filters on simulated runs: extended, unscented, with the leakage among the states and without."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from estimation.plants import PER_LITRE_PER_MINUTE

from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.catalogue.kalman_filters import EkfJoint, JointOptions, UkfJoint, UnscentedOptions
from hydrofdi.indicators.selection import load_indicators
from hydrofdi.records import Channel
from indicators.signals import P1, P2, XV, U, X, measured, noisy, simulated
from tests.machines import RIG, settings_of

PS = Channel.SUPPLY_PRESSURE
LEAKS = (0.0, 0.1, 0.5)
LITRE_PER_MINUTE = 1e-3 / 60.0
CLOSED_LOOP = ("control.law=pi", "input.shape=steps", "input.period=1 s")


NOISE = {P1: 5.3e3, P2: 5.3e3, X: 1e-5, XV: 0.0, U: 0.0}


def leaking(*settings, leaks=LEAKS, modulus=551e6):
    """Runs without noise for leaks in L/min."""
    coefficients = [PER_LITRE_PER_MINUTE * leak for leak in leaks]
    return simulated(*settings, leaks=coefficients, moduli=[modulus] * len(leaks))


@pytest.fixture(scope="module")
def open_loop():
    return leaking("record.duration=6 s", modulus=620e6)


@pytest.fixture(scope="module")
def closed_loop():
    return leaking("record.duration=6 s", *CLOSED_LOOP)


@pytest.fixture(scope="module")
def runs(open_loop):
    return noisy(open_loop, [0, 1, 2], 0, NOISE)


@pytest.mark.parametrize("motion", ["open_loop", "closed_loop"])
@pytest.mark.parametrize("leak", [0, 1, 2])
def test_the_leakage_of_matched_runs_is_within_its_stated_deviation(request, motion, leak):
    records = noisy(request.getfixturevalue(motion), [leak] * 24, leak, NOISE)
    values, _ = measured(records, "ekf_joint")
    modulus = 620e6 if motion == "open_loop" else 551e6
    error = values["internal_coefficient"] - PER_LITRE_PER_MINUTE * LEAKS[leak]
    stated = values["internal_coefficient_error"]
    assert abs(error.mean()) < 0.5 * stated.mean()
    assert (np.abs(error) < 1.96 * stated).mean() > 0.9
    assert stated.max() < 0.006 * PER_LITRE_PER_MINUTE
    np.testing.assert_allclose(values["bulk_modulus"].mean(), modulus, rtol=0.015)
    flow = np.sqrt(8e6) * values["internal_coefficient"]
    np.testing.assert_allclose(values["leakage"], flow, rtol=1e-12)


def test_a_plant_that_is_not_nominal_is_found_and_hides_no_leak():
    leaks = [0.0, 0.05]
    settings = (
        *settings_of(RIG), "record.duration=8 s", "valve.lap=0.8 um", "valve.flow_gain=0.0298 m^1.5/kg^0.5",
        "supply.pressure=16.6 MPa",
    )  # fmt: skip
    records = noisy(leaking(*settings, leaks=leaks, modulus=689e6), [0, 1], 0, NOISE)
    shifted = replace(records, channels={**records.channels, P1: records[P1] + 30e3})
    values, _ = measured(shifted, "ekf_joint")
    np.testing.assert_allclose(values["leakage"] / LITRE_PER_MINUTE, leaks, atol=0.012)
    np.testing.assert_allclose(values["bulk_modulus"], 689e6, rtol=0.02)
    np.testing.assert_allclose(values["supply_pressure"], 16.6e6, rtol=3e-3)
    alone, _ = measured(shifted, "ekf_joint", states=["leakage"])
    assert (np.abs(alone["leakage"] / LITRE_PER_MINUTE - leaks) > 0.02).any()


def test_a_measured_supply_pressure_is_taken_where_it_is(runs):
    with_supply = replace(runs, channels={**runs.channels, PS: np.full_like(runs[P1], 17.2e6)})
    values, _ = measured(with_supply, "ekf_joint", supply_pressure="14 MPa")
    np.testing.assert_allclose(values["supply_pressure"], 17.2e6, rtol=2e-3)
    states = ["leakage", "bulk_modulus"]
    one, _ = measured(with_supply, "ekf_joint", supply_pressure="14 MPa", states=states)
    np.testing.assert_allclose(one["leakage"] / LITRE_PER_MINUTE, LEAKS, atol=0.02)


@pytest.mark.parametrize("name", ["ekf_joint", "ekf_innovation", "ukf_joint"])
def test_a_filter_that_diverged_gives_nothing_from_then_on_and_says_so(runs, name):
    (ekf,) = make_indicators([name]).values()
    for absurd in (np.nan, 1e12):
        broken = {channel: samples.copy() for channel, samples in runs.channels.items()}
        broken[P2][1, 1525] = absurd
        trace = ekf.trace(replace(runs, channels=broken))
        for key, values in trace.values.items():
            assert np.isfinite(values[1, :30]).all(), key
            assert np.isnan(values[1, 30:]).all(), key
            assert np.isfinite(values[[0, 2]]).all(), key
        values, reasons = measured(replace(runs, channels=broken), name)
        assert np.isnan(values["leakage"]).tolist() == [False, True, False]
        assert [reason is None for reason in reasons] == [True, False, True]


def test_the_healthy_filter_tells_a_leak_by_its_signature(runs):
    values, _ = measured(runs, "ekf_innovation", bulk_modulus="620 MPa")
    leakage = values["leakage"] / LITRE_PER_MINUTE
    np.testing.assert_allclose(leakage, LEAKS, rtol=0.15, atol=2e-3)
    assert (np.diff(values["nis"]) > 0.0).all()
    assert 0.3 < values["nis"][0] < 1.2
    assert 5e3 < values["residual"][0] < 30e3


UKF_LEAKS = np.array([0.0, 0.05, 0.5])
KNOWN = {"states": ("leakage", "bulk_modulus", "supply", "flow_gain")}


@pytest.fixture(scope="module")
def ukf_runs():
    """Noisy runs of 6 s in oil 20 % stiffer than nominal."""
    exact = leaking("record.duration=6 s", leaks=UKF_LEAKS, modulus=661e6)
    return noisy(exact, [0, 1, 2], 5, {P1: 5e3, P2: 5e3, X: 1e-5, U: 0.0})


def test_leakage_and_bulk_modulus_are_those_of_the_actuator(ukf_runs):
    found = UkfJoint(UnscentedOptions(**KNOWN)).measure(ukf_runs)
    truth = LITRE_PER_MINUTE * UKF_LEAKS
    assert (np.abs(found["leakage"] - truth) < 4.0 * found["leakage_error"]).all()
    assert (found["leakage_error"] < 0.02 * LITRE_PER_MINUTE).all()
    np.testing.assert_allclose(found["bulk_modulus"], 661e6, rtol=0.03)


@pytest.mark.parametrize("states", [("leakage",), KNOWN["states"], JointOptions().states])
def test_points_close_together_make_it_the_extended_filter(ukf_runs, states):
    extended = EkfJoint(JointOptions(states=states)).measure(ukf_runs)
    unscented = UkfJoint(UnscentedOptions(states=states, spread=0.001)).measure(ukf_runs)
    error = extended["leakage_error"]
    np.testing.assert_allclose(unscented["leakage_error"], error, rtol=0.01)
    assert (np.abs(unscented["leakage"] - extended["leakage"]) < 0.4 * error).all()


DETECTORS = Path(__file__).parents[2] / "configs" / "detectors"


@pytest.mark.parametrize("name", ["ekf_joint", "ekf_innovation"])
def test_a_preset_states_the_defaults(name):
    (made,) = load_indicators(str(DETECTORS / f"{name.replace('_', '-')}.yaml")).values()
    usual = made.Options(supply="nominal").model_dump()
    for option, value in made.options.model_dump().items():
        expected = 0.03 if option == "supply_deviation" and value is not None else usual[option]
        assert value == (pytest.approx(expected) if isinstance(expected, float) else expected), option
